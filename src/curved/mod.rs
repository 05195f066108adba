//! A mesh as one Embree user geometry of curved triangles.
//!
//! [`CurvedMesh::new`] decides which edges are straight and which triangles stay flat, makes the patches and
//! groups them into clusters. Embree then asks it by callbacks, and it reports what it finds.
//! [`CurvedMesh::tessellate`] cuts the surface into flat triangles; an [`Inspection`] tells what a mesh
//! holds and what the method made of it.
//!
//! ```
//! use std::sync::Arc;
//!
//! use curvetri::curved::{CurvedMesh, CurvedOptions, counters};
//! use curvetri::embree::{QueryOptions, Ray, SceneBuilder};
//! use curvetri::mesh::Mesh;
//! use glam::{DVec3, Vec3};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The unit sphere as four triangles, which share their normals.
//! let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
//! let corners: Vec<DVec3> = corners.map(|p| DVec3::from(p.map(f64::from)).normalize()).into();
//! let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
//! let mesh = Arc::new(Mesh::new(corners.clone(), Some(corners), triangles)?);
//! let curved = Arc::new(CurvedMesh::new(mesh, &CurvedOptions::default()));
//! assert_eq!(curved.kinds().curved, 4);
//!
//! // Its geometries in an Embree scene of the program's own.
//! let device = curvetri::linked::device()?;
//! let mut builder = SceneBuilder::new(&device)?.robust(true);
//! for geometry in curved.geometries(&device)? {
//!     builder.attach(&geometry.commit()?);
//! }
//! let scene = builder.commit()?;
//! let (ray, before) = (Ray::new(Vec3::new(0.1, 0.2, 3.0), Vec3::NEG_Z), counters());
//! let hit = scene.intersect1(&ray, &QueryOptions::default()).expect("it hits the sphere");
//! assert!((ray.at(hit.t).length() - 1.0).abs() < 1e-5);
//! assert_eq!((counters() - before).callbacks, 1);
//! # Ok(())
//! # }
//! ```

mod bits;
mod build;
mod cluster;
mod curved_mesh;
mod geometries;
mod options;
mod query;
mod report;
mod tessellate;
mod triangle;

pub use build::{Kinds, Spheres};
pub use curved_mesh::CurvedMesh;
pub use options::{CurvedOptions, FlatTriangles, Primitives};
pub use query::{Counters, counters};
pub use report::{Advice, EdgeLengths, Inspection, MemoryNeed, SurfaceHeights};
pub use tessellate::Tessellation;
