//! Where rays meet surfaces.

use glam::Vec3;

use crate::embree::{Hit, Ray};

/// Where a ray meets a surface, and what light needs to know of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interaction {
    /// Where on the ray.
    pub t: f32,
    /// Its point.
    pub point: Vec3,
    /// How far the point may be off the surface: a secondary ray starts this far off it.
    pub error: f32,
    /// The geometry's unit normal, on the side that the ray comes from.
    pub facing: Vec3,
    /// What it is lit by: unit, on the same side.
    pub normal: Vec3,
    /// Whether the ray comes from the front, by the triangle's winding.
    pub front: bool,
    /// Its hit; the ground has none.
    pub hit: Option<Hit>,
    /// How much of what is behind it hides.
    pub coverage: f32,
}

impl Interaction {
    /// The ray from here along a unit direction, to either side of the surface.
    pub fn leaving(&self, direction: Vec3) -> Ray {
        let side = if direction.dot(self.facing) < 0.0 {
            -self.facing
        } else {
            self.facing
        };
        Ray::new(self.point + self.error * side, direction)
    }

    /// Where a ray to a light starts: on the side that is seen.
    pub fn start(&self) -> Vec3 {
        self.point + self.error * self.facing
    }
}
