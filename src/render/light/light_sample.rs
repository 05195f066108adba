//! What a light sends to a point.

use glam::Vec3;

/// A direction to a light, drawn at random.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct LightSample {
    /// Unit.
    pub direction: Vec3,
    /// How far away the light is.
    pub distance: f32,
    /// Its radiance over the probability density of the direction, over pi (of a light at a point its
    /// irradiance over pi): times the cosine, the radiance of a white surface.
    pub weight: Vec3,
}
