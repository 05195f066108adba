//! Rays from so far away that their numbers would lose a cluster's digits: moved along themselves to near it,
//! in double precision.

use std::ops::{Deref, DerefMut};

use glam::Vec3;

use super::kernel_rays::AnyQuery;
use crate::curved::bits::set_bits;
use crate::embree::{QueryRays, SurfaceHit};
use curvetri_method::{MAX_LANES, RayLanes};

/// From how many extents on rays are moved. At this distance rounding of a ray's place comes to 6e-5 of an
/// extent, and the cluster covers about a pixel of a usual picture. The camera's rays at a mesh whose clusters
/// are smaller than that are moved.
const FAR: f32 = 1024.0;

/// The lanes whose rays come from far away from something around `middle` that is not larger than `extent`.
#[inline]
pub(super) fn far_lanes(query: &QueryRays<'_>, middle: Vec3, extent: f32) -> u32 {
    let least = FAR * extent;
    let origin = [query.org_x(), query.org_y(), query.org_z()];
    // In a form that the compiler turns into SIMD; lanes that are not valid may hold anything.
    let mut any = false;
    for (column, middle) in origin.into_iter().zip(middle.to_array()) {
        for &place in column {
            any |= (place - middle).abs() > least;
        }
    }
    if !any {
        return 0;
    }
    let far = |lane: usize| {
        let place = Vec3::from_array(origin.map(|column| column[lane]));
        (place - middle).abs().max_element() > least
    };
    let lanes = set_bits(query.valid()).filter(|&lane| far(lane));
    lanes.fold(0, |lanes, lane| lanes | 1 << lane)
}

/// A query some of whose rays are moved along themselves. Hits are in the moved rays' parameters, and are
/// reported in the query's own.
pub(super) struct MovedQuery<'q, Q> {
    query: &'q mut Q,
    origin: [[f32; MAX_LANES]; 3],
    tnear: [f32; MAX_LANES],
    tfar: [f32; MAX_LANES],
    /// By how much of its parameter each ray is moved.
    shift: [f32; MAX_LANES],
}

impl<'a, 'q, Q: AnyQuery<'a>> MovedQuery<'q, Q> {
    /// Moves the rays in the lanes of `far` to where they come nearest to a point.
    pub fn new(query: &'q mut Q, far: u32, point: Vec3) -> Self {
        let mut origin = [[0.0; MAX_LANES]; 3];
        let [mut tnear, mut tfar, mut shift] = [[0.0; MAX_LANES]; 3];
        for lane in set_bits(query.valid()) {
            let ray = query.ray(lane);
            let mut start = ray.origin;
            (tnear[lane], tfar[lane]) = (ray.tnear, ray.tfar);
            if far & 1 << lane != 0 {
                let (from, along) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
                let way = (point.as_dvec3() - from).dot(along) / along.dot(along);
                shift[lane] = way as f32;
                start = (from + f64::from(shift[lane]) * along).as_vec3();
                // Wider by what rounding of t comes to: what is reported has to lie on the query's ray.
                let [near, end] = [ray.tnear, ray.tfar].map(|t| t.abs() * f32::EPSILON);
                tnear[lane] = ray.tnear - shift[lane] - near;
                tfar[lane] = ray.tfar - shift[lane] + end;
            }
            for (column, place) in origin.iter_mut().zip(start.to_array()) {
                column[lane] = place;
            }
        }
        Self {
            query,
            origin,
            tnear,
            tfar,
            shift,
        }
    }
}

impl<'a, Q: AnyQuery<'a>> AnyQuery<'a> for MovedQuery<'_, Q> {
    fn needs_normals(&self) -> bool {
        self.query.needs_normals()
    }

    fn may_reject(&self) -> bool {
        true // the last digit of a root before tnear
    }

    fn rays<'s>(&'s self) -> RayLanes<'s>
    where
        'a: 's,
    {
        let width = self.query.tnear().len();
        let [x, y, z] = &self.origin;
        RayLanes {
            origin: [&x[..width], &y[..width], &z[..width]],
            tnear: &self.tnear[..width],
            tfar: &self.tfar[..width],
            ..self.query.rays()
        }
    }

    fn report(&mut self, lane: usize, hit: SurfaceHit) -> bool {
        // t tells fewer digits than the moved ray's parameter, by which hits of one cluster are sorted.
        if hit.t > self.tfar[lane] {
            return false;
        }
        let t = hit.t + self.shift[lane];
        let counts = self.query.report(lane, SurfaceHit { t, ..hit });
        if counts {
            self.tfar[lane] = hit.t;
        }
        counts
    }
}

impl<Q: DerefMut> Deref for MovedQuery<'_, Q> {
    type Target = Q::Target;

    fn deref(&self) -> &Q::Target {
        self.query
    }
}

impl<Q: DerefMut> DerefMut for MovedQuery<'_, Q> {
    fn deref_mut(&mut self) -> &mut Q::Target {
        self.query
    }
}
