//! How far a hit may be off the surface.

use crate::curved::curved_mesh::CurvedMesh;
use crate::curved::triangle;
use crate::embree::Ray;
use curvetri_method::Real;

/// Share of the error bound that comes with the triangle's size, in epsilons: rounding inside the kernel.
const SIZE_ULPS: f32 = 64.0;
/// Share that comes with coordinates and distance, in epsilons: rounding of the ray's points.
const RAY_ULPS: f32 = 4.0;
/// The same share for triangles that Embree traces.
const EMBREE_ULPS: f32 = 8.0;

impl CurvedMesh {
    /// How far the true surface may be from the point `origin + t direction` of a hit on a
    /// triangle, along the surface's normal, in the units of the positions.
    ///
    /// A secondary ray that starts this far off the surface, on the side it leaves to, does not
    /// meet the surface it starts from; nothing thicker is needed, so that no light leaks where
    /// surfaces come close.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn error_bound(&self, triangle: u32, ray: &Ray, t: f32) -> f32 {
        let positions = triangle::vertices(&self.mesh, triangle as usize).positions;
        let extent = (positions[1] - positions[0])
            .max_abs()
            .greater((positions[2] - positions[0]).max_abs());
        let reach = ray.origin.abs().max_element() + t * ray.direction.abs().max_element();
        let ulps = if self.is_separate(triangle) {
            EMBREE_ULPS
        } else {
            RAY_ULPS
        };
        f32::EPSILON * (SIZE_ULPS * extent + ulps * (reach + positions[0].max_abs()))
    }
}
