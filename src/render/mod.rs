//! Cameras, lights, film: pictures, and answers to many rays at once.
//!
//! A [`Scene`] is meshes under one Embree tree, flat or curved. [`render`] traces a [`Picture`] of it
//! through a [`Camera`] under [`Lighting`]; [`answer_rays`] traces rays of the caller's own. Neither
//! knows of files or of the command line, but for [`OutputFile`], which makes a file appear whole or
//! not at all.

mod all_hits;
mod ao;
mod aov;
mod batch;
mod bsdf;
mod camera;
mod direct;
mod exr;
mod extent;
mod film;
mod framing;
#[cfg(test)]
mod glass_tests;
mod light;
mod output;
mod path;
mod picture;
mod place;
mod point_light;
mod sampler;
mod scene;
mod shading;
mod stats;
mod tiles;
mod tree;
mod world;

pub use aov::{Aovs, aovs};
pub use batch::{
    AllAnswers, Answers, NO_PRIMITIVE, PacketWidth, UserRay, UserRays, answer_all_hits,
    answer_occluded, answer_rays,
};
pub use bsdf::Material;
#[cfg(feature = "compare")]
pub(crate) use camera::Lens;
pub use camera::{Camera, CameraError, UpAxis};
pub use film::{Background, Film};
pub use framing::Framing;
pub use light::{Lighting, Sky, SphereLight};
pub use output::{OutputError, OutputFile, WriteSeek};
pub use picture::{Crop, FixedGround, Ground, Integrator, Picture};
pub use point_light::{Cone, PointLight};
pub use scene::{Form, Scene, SceneError, Shape};
pub use shading::Shading;
pub use stats::{MemoryParts, Rays, RenderStats, Times};
pub use tiles::render;
