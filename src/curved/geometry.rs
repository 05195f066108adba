//! The Embree callbacks of a curved mesh.

use super::CurvedMesh;
use super::counters::count;
use crate::embree::{Bounds, IntersectQuery, OccludedQuery, SurfaceHit, UserGeometry};
use crate::surface::{Patch, Ray, Real};

impl UserGeometry for CurvedMesh {
    fn primitives(&self) -> u32 {
        // A mesh holds at most 2^31 index values, so this fits.
        self.records.len() as u32
    }

    fn bounds(&self, prim: u32, _time_step: u32) -> Bounds {
        let [lower, upper] = self.patch(prim).bounds();
        Bounds {
            lower: lower.into(),
            upper: upper.into(),
        }
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        let patch = self.patch(query.prim_id());
        for lane in query.lanes() {
            let ray = kernel_ray(&query.ray(lane));
            self.offer_roots(&patch, ray, |hit| query.report(lane, hit));
        }
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        let patch = self.patch(query.prim_id());
        for lane in query.lanes() {
            let ray = kernel_ray(&query.ray(lane));
            self.offer_roots(&patch, ray, |hit| query.report(lane, hit));
        }
    }
}

impl CurvedMesh {
    /// Reports the ray's roots on a patch, nearest first, until one is accepted.
    fn offer_roots(
        &self,
        patch: &Patch<f32>,
        mut ray: Ray<f32>,
        mut report: impl FnMut(SurfaceHit) -> bool,
    ) {
        let mut evaluations = 0;
        loop {
            let hit = patch.intersect(&ray, self.solver);
            evaluations += u64::from(hit.evaluations);
            if !hit.found {
                break;
            }
            let ng = patch.normal_at(hit.u, hit.v).into();
            if report(SurfaceHit {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                ng,
            }) {
                break;
            }
            ray.tnear = patch.beyond(&ray, hit.t);
        }
        count(1, evaluations);
    }

    /// How far the true surface may be from the point `origin + t direction` of a hit on a
    /// triangle, along the surface's normal, in the units of the positions.
    ///
    /// A secondary ray that starts this far off the surface, on the side it leaves to, does not
    /// meet the surface it starts from; nothing thicker is needed, so that no light leaks where
    /// surfaces come close.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn error_bound(&self, triangle: u32, ray: &crate::embree::Ray, t: f32) -> f32 {
        let (positions, _) = super::corners(&self.mesh, triangle as usize);
        let extent = (positions[1] - positions[0])
            .max_abs()
            .greater((positions[2] - positions[0]).max_abs());
        let reach = ray.origin.abs().max_element() + t * ray.direction.abs().max_element();
        f32::EPSILON * (SIZE_ULPS * extent + RAY_ULPS * (reach + positions[0].max_abs()))
    }
}

/// Share of the error bound that comes with the triangle's size: rounding inside the kernel.
const SIZE_ULPS: f32 = 64.0;
/// Share that comes with coordinates and distance: rounding of the ray's points.
const RAY_ULPS: f32 = 4.0;

fn kernel_ray(ray: &crate::embree::Ray) -> Ray<f32> {
    Ray {
        origin: ray.origin.into(),
        direction: ray.direction.into(),
        tnear: ray.tnear,
        tfar: ray.tfar,
    }
}
