//! What is known of one curved triangle: data, and what follows from the vertices by plain geometry.
//!
//! The vertices give the `triangle_frame`, which gives the `plane` and each `edge`; together they are the
//! `unpacked` patch. `flags` are what it is made from beside the vertices, `kind` what it turned out to be.

mod choice;
mod clip_volume;
mod cyclic;
mod edge;
mod flags;
mod kind;
mod plane;
mod sphere;
mod triangle_frame;
mod triangle_vertices;
mod unpacked;

pub(crate) use choice::Choice;
pub(crate) use clip_volume::{ClipVolume, HalfSpace};
pub(crate) use cyclic::next;
pub use flags::{BoundsKind, PatchFlags, Surface};
pub(crate) use kind::Rule;
pub use kind::{FlatReason, PatchKind};
pub(crate) use plane::roots;
pub(crate) use sphere::Enlargement;
pub use sphere::Sphere;
pub(crate) use triangle_frame::{SLIVER_AREA, THIN, TriangleFrame};
pub use triangle_vertices::TriangleVertices;
pub use unpacked::Patch;
