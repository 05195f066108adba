//! Which triangles of a cluster a ray may meet: those whose boxes it does.

use fearless_simd::{Level, dispatch, f32x4, f32x8, prelude::*, u32x8};

use super::cluster::{Cluster, DIRECTIONS, NONE, SIZE};
use crate::embree::Ray;
use crate::method::{
    Lanes, MAX_LANES, Quad, RayLanes, Real, Vector, inlined, load_lanes, three, vector,
};

/// Rounding of a ray's distance to an end of a box, in units of epsilon of what it is computed from.
const ROUNDING: f32 = 16.0 * f32::EPSILON;
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
            || self.entries_of(simd, ray)
        ))
    }

    /// All boxes at once.
    #[inline(always)]
    fn entries_of<S: Simd>(&self, simd: S, ray: &Ray) -> Entries {
        let (mut from, mut to) = (f32x8::splat(simd, ray.tnear), f32x8::splat(simd, ray.tfar));
        let ways = self.ways_of(simd, ray);
        for (axis, way) in ways.iter().enumerate() {
            let [middle, half] = self.ranges_in_steps(axis);
            let middle = f32x8::from_slice(simd, &middle).mul_add(way.step, way.start);
            let half = f32x8::from_slice(simd, &half).mul_add(way.half_step, way.room);
            from = from.max(middle - half);
            to = to.min(middle + half);
        }
        let met = from.simd_le(to).to_bitmask() as u32;
        let triangles = u32x8::from_slice(simd, &self.triangles);
        let present = (!triangles.simd_eq(u32x8::splat(simd, NONE))).to_bitmask() as u32;
        let mut at = [0.0; SIZE];
        from.store_slice(&mut at);
        Entries {
            met: met & present,
            at,
        }
    }

    /// A ray's ways along the directions, one a lane.
    #[inline(always)]
    fn ways_of<S: Simd>(&self, simd: S, ray: &Ray) -> [Way<f32>; DIRECTIONS] {
        let quad = inlined(
            #[inline(always)]
            |of: [f32; 4]| Quad(f32x4::from_slice(simd, &of)),
        );
        let [x, y, z] = three(
            #[inline(always)]
            |component| quad(self.components(component)),
        );
        let way = Way::new(
            vector(x, y, z),
            quad(self.step()),
            Vector::splat(x, (ray.origin - self.middle()).into()),
            Vector::splat(x, ray.direction.into()),
            x.splat(self.extent()),
        );
        let one = inlined(
            #[inline(always)]
            |axis: usize| Way {
                start: way.start.0[axis],
                step: way.step.0[axis],
                half_step: way.half_step.0[axis],
                room: way.room.0[axis],
            },
        );
        [one(0), one(1), one(2), one(3)]
    }

    /// For each triangle the lanes, of those in `valid`, whose rays meet its box.
    pub fn packet_met(&self, rays: &RayLanes<'_>, valid: u32) -> [u32; SIZE] {
        dispatch!(Level::new(), simd => self.packet_met_by(
            simd,
            rays,
            valid,
            #[inline(always)]
            |_, _, _| (),
        ))
    }

    /// The same, and where they do.
    pub fn packet_entries(&self, rays: &RayLanes<'_>, valid: u32) -> PacketEntries {
        let mut at = [[0.0; MAX_LANES]; SIZE];
        let met = dispatch!(Level::new(), simd => self.packet_met_by(
            simd,
            rays,
            valid,
            #[inline(always)]
            |n, first, from| from.store_slice(&mut at[n][first..][..from.as_slice().len()]),
        ));
        PacketEntries { met, at }
    }

    /// A register's lanes at a time; tells a function of a triangle and the first lane where the rays enter.
    #[inline(always)]
    fn packet_met_by<S: Simd>(
        &self,
        simd: S,
        rays: &RayLanes<'_>,
        valid: u32,
        mut enter: impl FnMut(usize, usize, S::f32s),
    ) -> [u32; SIZE] {
        let mut all = [0; SIZE];
        // Converted in lanes, once: a box at a time that would take as long as its test.
        let mut ranges = [[[0.0; SIZE]; 2]; DIRECTIONS];
        for (axis, ranges) in ranges.iter_mut().enumerate() {
            *ranges = self.ranges_in_steps(axis);
        }
        for first in (0..rays.tnear.len().min(MAX_LANES)).step_by(S::f32s::LEN) {
            let ways = self.ways::<S>(simd, rays, first);
            let tnear = load_lanes(simd, rays.tnear, first);
            let tfar = load_lanes(simd, rays.tfar, first);
            let valid = valid >> first;
            for n in 0..SIZE {
                if self.triangles[n] == NONE {
                    break;
                }
                let (mut from, mut to) = (tnear, tfar);
                for (way, [middle, half]) in ways.iter().zip(&ranges) {
                    let middle = way.step.0.mul_add(middle[n], way.start.0);
                    let half = way.half_step.0.mul_add(half[n], way.room.0);
                    from = from.max(middle - half);
                    to = to.min(middle + half);
                }
                let met = from.simd_le(to).to_bitmask() as u32 & valid;
                all[n] |= met << first;
                enter(n, first, from);
            }
        }
        all
    }

    /// The ways of a register's rays along the directions.
    #[inline(always)]
    fn ways<S: Simd>(
        &self,
        simd: S,
        rays: &RayLanes<'_>,
        first: usize,
    ) -> [Way<Lanes<S>>; DIRECTIONS] {
        let load = inlined(
            #[inline(always)]
            |[x, y, z]: [&[f32]; 3]| {
                let load = inlined(
                    #[inline(always)]
                    |of: &[f32]| Lanes::<S>(load_lanes(simd, of, first)),
                );
                vector(load(x), load(y), load(z))
            },
        );
        let (origin, along) = (load(rays.origin), load(rays.direction));
        let like = origin.x;
        let from = origin - Vector::splat(like, self.middle().into());
        let extent = like.splat(self.extent());
        let step = self.step();
        let one = inlined(
            #[inline(always)]
            |axis: usize| {
                let direction = Vector::splat(like, self.direction(axis).into());
                Way::new(direction, like.splat(step[axis]), from, along, extent)
            },
        );
        [one(0), one(1), one(2), one(3)]
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

/// A ray's parameter along a direction of a cluster.
#[derive(Clone, Copy)]
struct Way<V> {
    /// Half-way between the ends.
    start: V,
    /// From one step to the next.
    step: V,
    /// Half as far, without its sign.
    half_step: V,
    /// What rounding may move it by.
    room: V,
}

impl<V: Real<Scalar = f32>> Way<V> {
    /// From a ray's origin, seen from the middle of a cluster that reaches this far, and its direction.
    #[inline(always)]
    fn new(direction: Vector<V>, step: V, origin: Vector<V>, along: Vector<V>, extent: V) -> Self {
        let rate = direction.dot(along);
        let least = rate.splat(LEAST_DIRECTION);
        let inverse = rate.constant(1.0) / V::select(rate.abs().less(least), least, rate);
        // Rounding of the products is rounding of the sizes of what is multiplied. A rate that is rounded, or
        // moved off zero, passes by a little further on.
        let distance = origin.x.abs() + origin.y.abs() + origin.z.abs();
        let room = (distance + extent) * rate.splat(ROUNDING);
        Self {
            start: -(direction.dot(origin) * inverse),
            step: step * inverse,
            half_step: step * inverse.abs() * rate.constant(0.5),
            room: room * inverse.abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cluster::tests::Triangles;
    use super::*;
    use glam::{Vec3, vec3};
    use rand::{Rng, SeedableRng, rngs::SmallRng};

    #[test]
    fn no_box_of_a_triangle_that_a_ray_meets_is_left_out() {
        let mut random = SmallRng::seed_from_u64(2);
        let (mut aimed, mut told) = (0, 0);
        for (size, lower) in [
            (1.0, Vec3::ZERO),
            (1e6, Vec3::ZERO),
            (1e-6, Vec3::splat(-5e-6)),
            (1.0, vec3(1e4, -2e3, 0.0)),
        ] {
            let triangles = Triangles::new(7, 400, size, lower);
            let clusters = triangles.clusters();
            for n in 0..2000 {
                let cluster = &clusters[n % clusters.len()];
                let place = n / clusters.len() % SIZE;
                let target = triangles.point(cluster.triangles[place], &mut random);
                let mut unit = || vec3(random.random(), random.random(), random.random());
                let mut from = lower + (unit() * 8.0 - 3.5) * size;
                match n % 5 {
                    0 => from[n % 3] = target[n % 3],
                    1 => from = target, // where it starts
                    _ => {}
                }
                let direction = if from == target {
                    unit() - 0.5
                } else {
                    target - from
                };
                let ray = Ray::new(from, direction);
                let entries = cluster.entries(&ray);
                assert!(entries.met & 1 << place != 0, "{ray:?} {n}");
                aimed += 1;
                told += entries.met.count_ones();
                check_order(cluster, &ray, entries);
            }
        }
        assert!(told < 4 * aimed, "{told} for {aimed}");
    }

    /// Boxes come in the order in which the ray enters them, and a packet of it in some lanes says the same.
    fn check_order(cluster: &Cluster, ray: &Ray, mut entries: Entries) {
        let met = entries.met;
        let mut last = f32::NEG_INFINITY;
        while let Some(n) = entries.next(f32::INFINITY) {
            assert!(entries.at[n] >= last);
            last = entries.at[n];
        }
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
