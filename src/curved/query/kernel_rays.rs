//! Rays and hits between Embree's form and the kernel's, and one trait for both kinds of query.

use std::ops::DerefMut;

use crate::embree::{self, IntersectQuery, OccludedQuery, QueryRays, SurfaceHit};
use curvetri_method::{Ray, RayLanes};

/// A query of either kind: what is traced for the nearest hit and for occlusion differs in nothing else.
pub(super) trait AnyQuery<'a>: DerefMut<Target = QueryRays<'a>> {
    /// Whether the normals of reported hits are looked at. Where they are not, zeros will do.
    fn needs_normals(&self) -> bool;

    /// Offers a hit of a lane's ray and returns whether it counts. Where it does not, the next one along the
    /// ray should be offered.
    fn report(&mut self, lane: usize, hit: SurfaceHit) -> bool;
}

impl<'a> AnyQuery<'a> for IntersectQuery<'a> {
    #[inline(always)]
    fn needs_normals(&self) -> bool {
        true
    }

    #[inline(always)]
    fn report(&mut self, lane: usize, hit: SurfaceHit) -> bool {
        IntersectQuery::report(self, lane, hit)
    }
}

impl<'a> AnyQuery<'a> for OccludedQuery<'a> {
    #[inline(always)]
    fn needs_normals(&self) -> bool {
        self.has_filters()
    }

    #[inline(always)]
    fn report(&mut self, lane: usize, hit: SurfaceHit) -> bool {
        OccludedQuery::report(self, lane, hit)
    }
}

/// All rays of a query.
pub(super) fn ray_lanes<'a>(query: &'a QueryRays<'_>) -> RayLanes<'a> {
    RayLanes {
        origin: [query.org_x(), query.org_y(), query.org_z()],
        direction: [query.dir_x(), query.dir_y(), query.dir_z()],
        tnear: query.tnear(),
        tfar: query.tfar(),
    }
}

/// One ray.
pub(super) fn kernel_ray(ray: &embree::Ray) -> Ray<f32> {
    Ray {
        origin: ray.origin.into(),
        direction: ray.direction.into(),
        tnear: ray.tnear,
        tfar: ray.tfar,
    }
}
