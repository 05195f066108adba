//! How far off computed points may be, by rounding.

use crate::embree::Ray;

/// How far out the points are that a ray's hit was computed from.
pub(super) fn reach(ray: &Ray, t: f32) -> f32 {
    ray.origin.abs().max_element() + t * ray.direction.abs().max_element()
}

/// How far off a plane a computed point of it may be, by the magnitude of what it was computed from.
pub(super) fn rounding(magnitude: f32) -> f32 {
    8.0 * f32::EPSILON * magnitude
}
