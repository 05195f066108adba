//! Cameras, lights, film: pictures, and answers to many rays at once.
//!
//! A [`Scene`] is meshes under one Embree tree, flat or curved. [`render`] traces a [`Picture`] of it
//! through a [`Camera`] under [`Lighting`]; [`answer_rays`] traces rays of the caller's own. Neither
//! knows of files or of the command line.
//!
//! ```
//! use curvetri::curved::CurvedOptions;
//! use curvetri::mesh::Mesh;
//! use curvetri::render::{
//!     Background, Form, Framing, Ground, Integrator, Picture, Scene, UpAxis, aovs, render,
//! };
//! use glam::DVec3;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let corners = vec![DVec3::X, DVec3::Y, DVec3::Z];
//! let mesh = Mesh::new(corners.clone(), Some(corners), vec![[0, 1, 2]])?;
//! let form = Form::Curved(CurvedOptions::default());
//! let scene = Scene::new(&curvetri::linked::device()?, vec![mesh], form)?;
//! let framing = Framing { up: UpAxis::Y, fov_degrees: Some(35.0), aspect: 2.0, shadows_of: None };
//! let picture = Picture {
//!     samples: 4,
//!     integrator: Integrator::Path { depth: 2 },
//!     ground: Ground::Plane,
//!     ..Picture::new(64, 32, framing.camera(&scene), UpAxis::Y)
//! };
//! let (film, stats) = render(&scene, &picture, &|_, _| ())?;
//! assert_eq!(stats.rays.primary, 4 * 64 * 32);
//!
//! let mut png = Vec::new();
//! film.write_png(&mut png, Background::Transparent, 0.0)?;
//! let mut exr = std::io::Cursor::new(Vec::new());
//! film.write_exr(&mut exr, &aovs(&scene, &picture)?)?;
//! # Ok(())
//! # }
//! ```

mod all_hits;
mod camera;
mod exr;
mod extent;
mod film;
mod framing;
mod hit_geometry;
mod integrate;
mod light;
mod material;
mod picture;
mod placed_shape;
mod ray_batch;
mod rounding;
mod scene;
mod shading;
mod shape;
mod stats;
mod tree;
mod user_ray;
mod vicinity;

#[cfg(feature = "compare")]
pub(crate) use camera::Lens;
pub use camera::{Camera, CameraError, Projection, UpAxis};
pub use film::{Background, Film};
pub use framing::Framing;
pub use integrate::{Aovs, aovs, render};
pub use light::{Cone, Lighting, PointLight, Sky, SphereLight};
pub use material::Material;
pub use picture::{Crop, FixedGround, Ground, Integrator, Picture};
pub use ray_batch::{
    AllAnswers, Answers, NO_PRIMITIVE, PacketWidth, Untraceable, UserRays, answer_all_hits,
    answer_occluded, answer_rays, untraceable_rays,
};
pub use scene::{Scene, SceneError};
pub use shading::Shading;
pub use shape::{Form, Shape};
pub use stats::{MemoryParts, RayCounts, RenderStats, Times};
pub use user_ray::{RayFault, UserRay};
#[cfg(feature = "compare")]
pub(crate) use vicinity::Vicinity;
