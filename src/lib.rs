//! Ray tracing of triangle meshes with vertex normals as the smooth curved surfaces they stand for,
//! on top of Intel Embree.
//!
//! The rooms, in the one direction they may depend on each other:
//!
//! | room | job |
//! |---|---|
//! | [`surface`] | the spherical interpolation method: pure maths of one curved triangle |
//! | [`mesh`] | triangle meshes: reading files, vertex normals, which triangles share a side |
//! | [`bodies`] | bodies with a known true surface, and meshes made by programs |
//! | [`embree`] | a safe wrapper over the installed Embree, 3.13 or 4.x |
//! | [`curved`] | a mesh as one Embree user geometry of curved triangles |
//! | [`accuracy`] | how far the surfaces are from bodies' true ones: the paper's Table 1 |
//! | [`render`] | cameras, lights, film: pictures |
//! | `compare` | how far two forms' pictures, outlines and normals are apart (feature `compare`) |
//! | [`bench`] | how fast and how large all this is against flat triangles |

#![deny(missing_docs)]

pub mod accuracy;
pub mod bench;
pub mod bodies;
#[cfg(feature = "compare")]
pub mod compare;
pub mod curved;
pub mod embree;
pub mod mesh;
pub mod render;
pub mod surface;
