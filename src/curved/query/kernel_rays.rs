//! Rays and hits between Embree's form and the kernel's, and one trait for both kinds of query.

use std::ops::DerefMut;

use crate::embree::{IntersectQuery, OccludedQuery, QueryRays, SurfaceHit};
use curvetri_method::{Ray, RayLanes, vector};

/// A query of either kind: what is traced for the nearest hit and for occlusion differs in nothing else.
pub(super) trait AnyQuery<'a>: DerefMut<Target = QueryRays<'a>> {
    /// Whether the normals of reported hits are looked at. Where they are not, zeros will do.
    fn needs_normals(&self) -> bool;

    /// Whether a hit may be rejected though it is the nearest.
    #[inline(always)]
    fn may_reject(&self) -> bool {
        self.has_filters()
    }

    /// The rays that are traced: all of them, in the kernel's form.
    #[inline(always)]
    fn rays<'s>(&'s self) -> RayLanes<'s>
    where
        'a: 's,
    {
        RayLanes {
            origin: [self.org_x(), self.org_y(), self.org_z()],
            direction: [self.dir_x(), self.dir_y(), self.dir_z()],
            tnear: self.tnear(),
            tfar: self.tfar(),
        }
    }

    /// One of them.
    ///
    /// # Panics
    /// If there is no such lane.
    #[inline(always)]
    fn kernel_ray(&self, lane: usize) -> Ray<f32> {
        let rays = self.rays();
        let place = |[x, y, z]: [&[f32]; 3]| vector(x[lane], y[lane], z[lane]);
        Ray {
            origin: place(rays.origin),
            direction: place(rays.direction),
            tnear: rays.tnear[lane],
            tfar: rays.tfar[lane],
        }
    }

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
