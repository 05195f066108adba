//! Which triangles of a cluster a ray may meet: those whose boxes it does.

use fearless_simd::{Level, dispatch, prelude::*};

use super::clusters::{Cluster, NONE, SIZE, STEPS};
use crate::embree::Ray;
use crate::surface::{MAX_LANES, RayLanes, inlined, load_lanes};

/// Rounding of a ray's distance to a plane of a box, in units of epsilon of what it is computed from.
const ROUNDING: f32 = 6.0 * f32::EPSILON;
/// Least size of a direction's component: keeps its inverse, and products with it, finite.
const LEAST_DIRECTION: f32 = 1e-18;

/// Where a ray enters the boxes of a cluster.
pub(super) struct Entries {
    /// The boxes that it meets, one bit each.
    pub met: u32,
    /// The parameters.
    at: [f32; SIZE],
}

/// Where the rays of a packet enter the boxes of a cluster.
#[derive(Default)]
pub(super) struct PacketEntries {
    /// For each box the lanes that meet it, one bit each.
    met: [u32; SIZE],
    /// The parameters.
    at: [[f32; MAX_LANES]; SIZE],
}

impl Cluster {
    /// The boxes that a ray meets, and where.
    pub fn entries(&self, ray: &Ray) -> Entries {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || self.entries_of(ray)
        ))
    }

    #[inline(always)]
    fn entries_of(&self, ray: &Ray) -> Entries {
        let (mut from, mut to) = ([ray.tnear; SIZE], [ray.tfar; SIZE]);
        for axis in 0..3 {
            let way = Way::new(self, axis, ray.origin[axis], ray.direction[axis]);
            for n in 0..SIZE {
                let (near, far) = way.between(self.lower[axis][n], self.upper[axis][n]);
                from[n] = greater(from[n], near);
                to[n] = lesser(to[n], far);
            }
        }
        let met = (0..SIZE).fold(0, |met, n| met | u32::from(from[n] <= to[n]) << n);
        Entries {
            met: met & self.present(),
            at: from,
        }
    }

    /// For each triangle the lanes, of those in `valid`, whose rays meet its box, and where.
    pub fn packet_entries(&self, rays: &RayLanes<'_>, valid: u32) -> PacketEntries {
        dispatch!(Level::new(), simd => self.packet_entries_by(simd, rays, valid))
    }

    /// A register's lanes at a time.
    #[inline(always)]
    fn packet_entries_by<S: Simd>(
        &self,
        simd: S,
        rays: &RayLanes<'_>,
        valid: u32,
    ) -> PacketEntries {
        let mut entries = PacketEntries::default();
        // Converted in lanes, once: a box at a time that would take as long as its test.
        let planes = inlined(
            #[inline(always)]
            |of: &[[u8; SIZE]; 3]| {
                let mut planes = [[0.0; SIZE]; 3];
                for (to, from) in planes.iter_mut().zip(of) {
                    for (to, from) in to.iter_mut().zip(from) {
                        *to = f32::from(*from);
                    }
                }
                planes
            },
        );
        let (lower, upper) = (planes(&self.lower), planes(&self.upper));
        for first in (0..rays.tnear.len().min(MAX_LANES)).step_by(S::f32s::LEN) {
            let way = inlined(
                #[inline(always)]
                |axis: usize| {
                    let origin = load_lanes(simd, rays.origin[axis], first);
                    let direction = load_lanes(simd, rays.direction[axis], first);
                    Ways::<S>::new(self, axis, origin, direction)
                },
            );
            let ways = [way(0), way(1), way(2)];
            let tnear = load_lanes(simd, rays.tnear, first);
            let tfar = load_lanes(simd, rays.tfar, first);
            let valid = valid >> first;
            for n in 0..SIZE {
                if self.triangles[n] == NONE {
                    break;
                }
                let (mut from, mut to) = (tnear, tfar);
                for (axis, way) in ways.iter().enumerate() {
                    let (near, far) = way.between(lower[axis][n], upper[axis][n]);
                    (from, to) = (from.max(near), to.min(far));
                }
                let met = from.simd_le(to).to_bitmask() as u32 & valid;
                entries.met[n] |= met << first;
                from.store_slice(&mut entries.at[n][first..][..S::f32s::LEN]);
            }
        }
        entries
    }
}

impl Entries {
    /// The place of the box that the ray enters first of those met, which is then met no more; none
    /// where all that are left are entered beyond `tfar`.
    #[inline]
    pub fn next(&mut self, tfar: f32) -> Option<usize> {
        let mut nearest = None;
        let mut left = self.met;
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            if nearest.is_none_or(|nearest: usize| self.at[n] < self.at[nearest]) {
                nearest = Some(n);
            }
        }
        let nearest = nearest.filter(|&nearest| self.at[nearest] <= tfar)?;
        self.met &= !(1 << nearest);
        Some(nearest)
    }
}

impl PacketEntries {
    /// For each box the lanes that meet it, one bit each.
    pub fn met(&self) -> &[u32; SIZE] {
        &self.met
    }

    /// Counts all boxes but these, one bit each, as met no more.
    pub fn keep(&mut self, boxes: u32) {
        for (n, met) in self.met.iter_mut().enumerate() {
            if boxes & 1 << n == 0 {
                *met = 0;
            }
        }
    }

    /// The place of the box that is entered first of those met, and the lanes of `valid` that enter it no
    /// further away than their `tfar`; that box is met no more. None where nothing is left.
    #[inline]
    pub fn next(&mut self, tfar: &[f32], valid: u32) -> Option<(usize, u32)> {
        while let Some(n) = self.nearest() {
            let lanes = std::mem::take(&mut self.met[n]) & valid;
            let lanes = lanes & not_beyond(&self.at[n], tfar);
            if lanes != 0 {
                return Some((n, lanes));
            }
        }
        None
    }

    /// By the first lane that meets it: the rays of a packet run side by side, or else no order suits.
    fn nearest(&self) -> Option<usize> {
        let at = |n: usize| self.at[n][self.met[n].trailing_zeros() as usize];
        let met = (0..SIZE).filter(|&n| self.met[n] != 0);
        met.min_by(|&a, &b| at(a).total_cmp(&at(b)))
    }
}

/// The lanes whose first value is at most the second, one bit each.
fn not_beyond(at: &[f32; MAX_LANES], tfar: &[f32]) -> u32 {
    #[inline(always)]
    fn by<S: Simd>(simd: S, at: &[f32], tfar: &[f32]) -> u32 {
        let mut lanes = 0;
        for first in (0..tfar.len().min(MAX_LANES)).step_by(S::f32s::LEN) {
            let (at, tfar) = (load_lanes(simd, at, first), load_lanes(simd, tfar, first));
            lanes |= (at.simd_le(tfar).to_bitmask() as u32) << first;
        }
        lanes
    }
    dispatch!(Level::new(), simd => by(simd, at, tfar))
}

/// A ray's parameter along one axis of a cluster's box.
#[derive(Clone, Copy, Default)]
struct Way {
    /// At the lower corner.
    start: f32,
    /// From one step to the next.
    step: f32,
    /// What rounding may move it by.
    room: f32,
}

impl Way {
    #[inline(always)]
    fn new(cluster: &Cluster, axis: usize, origin: f32, direction: f32) -> Self {
        let steep = direction.abs() < LEAST_DIRECTION;
        let inverse = 1.0 / if steep { LEAST_DIRECTION } else { direction };
        let (first, step) = (cluster.corner[axis] - origin, cluster.step[axis]);
        // A direction that was moved off zero passes by a little further on.
        Self {
            start: first * inverse,
            step: step * inverse,
            room: (first.abs() + step * STEPS) * inverse.abs() * ROUNDING,
        }
    }

    /// Where the ray is between two numbers of steps.
    #[inline(always)]
    fn between(&self, lower: u8, upper: u8) -> (f32, f32) {
        let a = self.start + f32::from(lower) * self.step;
        let b = self.start + f32::from(upper) * self.step;
        (lesser(a, b) - self.room, greater(a, b) + self.room)
    }
}

/// The same of a register's lanes.
struct Ways<S: Simd> {
    start: S::f32s,
    step: S::f32s,
    room: S::f32s,
}

impl<S: Simd> Ways<S> {
    #[inline(always)]
    fn new(cluster: &Cluster, axis: usize, origin: S::f32s, direction: S::f32s) -> Self {
        let simd = origin.token();
        let least = S::f32s::splat(simd, LEAST_DIRECTION);
        let steep = direction.abs().simd_lt(least);
        let inverse = S::f32s::splat(simd, 1.0) / steep.select(least, direction);
        let first = S::f32s::splat(simd, cluster.corner[axis]) - origin;
        let step = cluster.step[axis];
        Self {
            start: first * inverse,
            step: inverse * step,
            room: (first.abs() + step * STEPS) * inverse.abs() * ROUNDING,
        }
    }

    #[inline(always)]
    fn between(&self, lower: f32, upper: f32) -> (S::f32s, S::f32s) {
        let a = self.start + self.step * lower;
        let b = self.start + self.step * upper;
        (a.min(b) - self.room, a.max(b) + self.room)
    }
}

/// Of one instruction, as neither is NaN.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// As [`lesser`].
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::super::clusters::group;
    use super::super::clusters::tests::boxes;
    use super::*;
    use crate::embree::Bounds;
    use glam::{Vec3, vec3};
    use rand::{Rng, SeedableRng, rngs::SmallRng};

    /// Whether a ray meets a box, in double precision.
    fn meets(ray: &Ray, bounds: &Bounds) -> bool {
        let (mut from, mut to) = (f64::from(ray.tnear), f64::from(ray.tfar));
        for axis in 0..3 {
            let [lower, upper, origin, direction] = [
                bounds.lower[axis],
                bounds.upper[axis],
                ray.origin[axis],
                ray.direction[axis],
            ]
            .map(f64::from);
            if direction == 0.0 {
                if origin < lower || origin > upper {
                    return false;
                }
                continue;
            }
            let (a, b) = ((lower - origin) / direction, (upper - origin) / direction);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        from <= to
    }

    #[test]
    fn no_box_that_a_ray_meets_is_left_out() {
        let mut random = SmallRng::seed_from_u64(2);
        let (mut met, mut told) = (0, 0);
        for (size, centre) in [
            (1.0, Vec3::ZERO),
            (1e-4, Vec3::ONE),
            (1e4, vec3(-3e5, 2e5, 1e3)),
        ] {
            let boxes = boxes(&mut random, 400, size, centre);
            let clusters = group(&boxes);
            for n in 0..2000 {
                let mut unit = || vec3(random.random(), random.random(), random.random());
                let target = centre + unit() * size;
                let from = centre + (unit() * 8.0 - 3.5) * size;
                let mut direction = target - from;
                if n % 5 == 0 {
                    direction[n % 3] = 0.0;
                }
                let ray = Ray::new(from, direction);
                for cluster in &clusters {
                    let mut entries = cluster.entries(&ray);
                    told += entries.met.count_ones();
                    for (n, &triangle) in cluster.triangles.iter().enumerate() {
                        if triangle != NONE && meets(&ray, &boxes[triangle as usize]) {
                            met += 1;
                            assert!(entries.met & 1 << n != 0, "{ray:?}");
                        }
                    }
                    check_lanes(cluster, &ray, entries.met);
                    let mut last = f32::NEG_INFINITY;
                    while let Some(n) = entries.next(f32::INFINITY) {
                        assert!(entries.at[n] >= last);
                        last = entries.at[n];
                    }
                }
            }
        }
        assert!(met > 5_000, "{met}");
        assert!(f64::from(told) < 1.2 * f64::from(met), "{told} for {met}");
    }

    /// A packet of the same ray in some lanes says the same.
    fn check_lanes(cluster: &Cluster, ray: &Ray, met: u32) {
        let splat = |value| [value; 4];
        let [o, d] = [ray.origin, ray.direction].map(|v| v.to_array().map(splat));
        let (tnear, tfar) = (splat(ray.tnear), splat(ray.tfar));
        let rays = RayLanes {
            origin: [&o[0], &o[1], &o[2]],
            direction: [&d[0], &d[1], &d[2]],
            tnear: &tnear,
            tfar: &tfar,
        };
        let mut entries = cluster.packet_entries(&rays, 0b1010);
        let (mut seen, mut last) = (0, f32::NEG_INFINITY);
        while let Some((n, lanes)) = entries.next(&tfar, 0b1011) {
            assert_eq!(lanes, 0b1010);
            assert!(entries.at[n][1] >= last);
            (seen, last) = (seen | 1 << n, entries.at[n][1]);
        }
        assert_eq!(seen, met);
        let mut entries = cluster.packet_entries(&rays, u32::MAX);
        assert_eq!(entries.next(&splat(f32::NEG_INFINITY), u32::MAX), None);
    }
}
