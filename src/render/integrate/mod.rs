//! The light that camera rays bring: integrators, and the rendering of pictures with them.

mod ambient_occlusion;
mod aovs;
mod direct;
mod estimator;
#[cfg(test)]
mod glass_tests;
mod ground_plane;
mod interaction;
mod light_sampling;
mod path;
mod sampler;
mod scattering;
mod tiles;
mod world;

pub use aovs::{Aovs, aovs};
#[cfg(test)]
pub(super) use sampler::PixelSampler;
#[cfg(test)]
pub(super) use scattering::cosine_direction;
pub use tiles::render;
