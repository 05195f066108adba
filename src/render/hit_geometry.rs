//! What a scene knows of a hit: its normal, and how far off it may be.

use glam::Vec3;

use super::scene::Scene;
use crate::embree::{Hit, Ray};

impl Scene {
    /// The unit normal of a hit in the scene's space: the surface's own, on the front of the triangle
    /// by its winding (of a mirrored instance the image of the front); zero where the hit has none.
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn normal(&self, hit: &Hit) -> Vec3 {
        self.placed_shape(hit).normal(hit.ng)
    }

    /// How far the surface may be from the point of a hit along its normal: see
    /// [`CurvedMesh::error_bound`](crate::curved::CurvedMesh::error_bound). On an instance, with the rounding of its transform.
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn error_bound(&self, hit: &Hit, ray: &Ray) -> f32 {
        let place = self.placed_shape(hit);
        let shape = &self.shapes()[place.shape];
        let Some(instance) = &place.instance else {
            return shape.error_bound(hit.prim_id, ray, hit.t);
        };
        let bound = shape.error_bound(hit.prim_id, &instance.localized(ray), hit.t);
        instance.error_bound(bound, hit.ng, ray, hit.t)
    }

    /// Where a secondary ray starts that leaves a hit's surface on the side of `normal`, one of its
    /// two unit normals there: off the surface by the hit's error, so that the ray does not meet the
    /// surface it leaves, and by no more, so that it meets whatever is near.
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn leaving_point(&self, hit: &Hit, ray: &Ray, normal: Vec3) -> Vec3 {
        ray.at(hit.t) + self.error_bound(hit, ray) * normal
    }
}
