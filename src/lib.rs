//! Ray tracing of triangle meshes with vertex normals as the smooth curved surfaces they stand for,
//! on top of Intel Embree.
//!
//! | module | job |
//! |---|---|
//! | [`method`] | the spherical interpolation method: pure maths of one curved triangle |
//! | [`mesh`] | triangle meshes: reading files, vertex normals, which triangles share an edge |
//! | [`embree`] | a safe wrapper over Embree, 3.13 or 4.3 and later, that links neither |
//! | `linked` | the installed Embree, linked (feature `linked`, a default one): `curvetri::linked::device()` |
//! | [`output`] | files that appear whole or not at all |
//! | [`curved`] | a mesh as one Embree user geometry of curved triangles |
//! | [`render`] | cameras, lights, film: pictures |
//! | `compare` | how much two forms' pictures, outlines and normals differ (feature `compare`) |

#![deny(missing_docs)]

#[doc(inline)]
pub use curvetri_embree as embree;
#[cfg(feature = "linked")]
#[doc(inline)]
pub use curvetri_embree_linked as linked;
#[doc(inline)]
pub use curvetri_mesh as mesh;

#[cfg(feature = "compare")]
pub mod compare;
pub mod curved;
pub mod method;
pub mod output;
pub mod render;

/// Compiles the Rust of README.md with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
