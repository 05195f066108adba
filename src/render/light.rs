//! The sun and the sky.

use glam::{DVec3, Vec3};

use super::camera::UpAxis;

/// What lights a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lighting {
    /// Towards the sun, which is infinitely far and casts shadows; unit length.
    pub towards_sun: Vec3,
    /// The sun's irradiance on a surface that faces it, over pi: a white surface's radiance.
    pub sun: Vec3,
    /// The sky.
    pub sky: Sky,
}

/// A sky that changes from below to above; it casts no shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Upwards; unit length.
    pub up: Vec3,
    /// Radiance of a white surface that faces straight up.
    pub above: Vec3,
    /// Radiance of a white surface that faces straight down.
    pub below: Vec3,
}

impl Lighting {
    /// A warm sun from the upper left and a blue sky.
    pub fn daylight(up: UpAxis) -> Self {
        let towards_sun = up.turn(DVec3::new(-0.55, 0.75, 0.6));
        Self {
            towards_sun: towards_sun.as_vec3().normalize(),
            sun: Vec3::new(0.95, 0.90, 0.80),
            sky: Sky {
                up: up.vector().as_vec3(),
                above: Vec3::new(0.24, 0.28, 0.34),
                below: Vec3::new(0.09, 0.08, 0.075),
            },
        }
    }
}

impl Sky {
    /// Radiance of a white surface with this unit normal.
    pub fn on(&self, normal: Vec3) -> Vec3 {
        self.below.lerp(self.above, 0.5 + 0.5 * normal.dot(self.up))
    }
}
