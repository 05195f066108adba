//! A safe wrapper over Embree, 3.13 or 4.3 and later, that links neither.
//!
//! Embree's functions come by a [`Table`]: that of `curvetri-embree-linked`, which links the installed Embree, or that
//! of a program with an Embree of its own. A [`Device`] is Embree itself. [`Geometry`]s are made with it, built step by step and then
//! committed: triangles, grids and
//! subdivision surfaces of Embree's own, or anything that Rust code can bound and intersect
//! ([`UserGeometry`]). A [`SceneBuilder`] puts them under one tree; the [`Scene`] it ends in is immutable
//! and traced from any number of threads, by packets of 1, 4, 8 or 16 rays ([`RayPacket`]).
//!
//! What differs between the versions is data of the table and does not show here: the same program gives the same
//! answers with all of them. Errors of Embree are [`Error`]s. A panic in a callback resumes in the
//! function that caused the call. Rays that Debian 12's library would abort the process for
//! ([`Ray::is_traceable`]) are misses.
//!
//! ```
//! use curvetri_embree::{Geometry, QueryOptions, Ray, RayPacket, SceneBuilder};
//! use glam::Vec3;
//!
//! # fn main() -> Result<(), curvetri_embree::Error> {
//! let device = curvetri_embree_linked::device()?;
//! let triangle = Geometry::triangles(&device, &[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]])?;
//! let mut builder = SceneBuilder::new(&device)?;
//! let id = builder.attach(&triangle.commit()?);
//! let scene = builder.commit()?;
//!
//! let ray = Ray::new(Vec3::new(0.25, 0.5, -1.0), Vec3::Z);
//! let hit = scene.intersect1(&ray, &QueryOptions::default()).expect("it meets the triangle");
//! assert_eq!((hit.prim_id, hit.geom_id), (0, id));
//! assert!((hit.t - 1.0).abs() < 1e-6 && (hit.u - 0.25).abs() < 1e-6 && (hit.v - 0.5).abs() < 1e-6);
//!
//! let mut packet = RayPacket::<16>::from_rays(&[ray; 16]);
//! assert_eq!(scene.occluded(&mut packet, &QueryOptions::COHERENT), 0xffff);
//! # Ok(())
//! # }
//! ```

mod bindings;
mod bounds;
mod denormals;
mod device;
mod error;
mod filter;
mod geometry;
mod instance;
mod meshes;
mod packet;
mod query;
mod ray;
mod record;
mod scene;
mod sys;
mod table;
mod user;

/// The table as C has it, `struct CurvetriEmbree` of `curvetri_table.h`: for [`Table::read`].
pub use bindings::table::CurvetriEmbree;
pub use bounds::Bounds;
pub use denormals::{FlushedDenormals, flush_denormals};
pub use device::{Device, Memory, Version};
pub use error::{Error, ErrorCode};
pub use filter::{Candidate, Filter};
pub use geometry::{BuildQuality, Geometry, GeometryBuilder};
pub use meshes::Grid;
pub use packet::{Hits, RayPacket, Rays, Traced, Width};
pub use query::QueryOptions;
pub use ray::{Hit, LARGEST_COMPONENT, LEAST_COMPONENT, Ray, SurfaceHit};
pub use scene::{GeometryId, Scene, SceneBuilder};
pub use table::{Table, TableError};
pub use user::{IntersectQuery, OccludedQuery, QueryRays, UserGeometry};
