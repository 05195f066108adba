//! Bodies with a known true surface, and meshes made by programs.
//!
//! [`Body`] is one of the paper's bodies: a coarse cut of it with its true normals, and its true
//! surface to measure against. The other meshes stand in for what people have: [`bumpy_torus`] of
//! any size, [`capped_cylinder`] and [`capped_cone`] with hard rims, the Utah [`teapot`], and
//! [`Blob`], an implicit surface cut irregularly. All are the same numbers at each call.
//! [`scenes`] names those that are kept as files.

mod analytic;
mod blob;
mod made;
mod revolution;
mod scenes;
mod splitmix;
mod teapot;

pub use analytic::{Body, BodyTriangle};
pub use blob::Blob;
pub use made::{bumpy_torus, bumpy_torus_distance, capped_cone, capped_cylinder, terminator};
pub use scenes::scenes;
pub use splitmix::SplitMix;
pub use teapot::{TeapotPart, teapot, teapot_part};
