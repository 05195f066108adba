//! Neighbouring triangles as one Embree primitive: a tree a level or three lower, fewer callbacks, and
//! the boxes of all its triangles in two cache lines, tested at once.

use fearless_simd::{Level, dispatch, prelude::*};
use glam::Vec3;
use rayon::prelude::*;

use crate::embree::{Bounds, Ray};
use crate::surface::{MAX_LANES, RayLanes, inlined, load_lanes};

/// Most triangles of a cluster.
pub(super) const SIZE: usize = 8;
/// In place of a triangle's number where a cluster has fewer.
const NONE: u32 = u32::MAX;
/// Steps along an axis of a cluster's box in which its triangles' boxes are given.
const STEPS: f32 = 255.0;
/// Rounding of a ray's distance to a plane of a box, in units of epsilon of what it is computed from.
const ROUNDING: f32 = 6.0 * f32::EPSILON;
/// Least size of a direction's component: keeps its inverse, and products with it, finite.
const LEAST_DIRECTION: f32 = 1e-18;

/// Some neighbouring triangles and their boxes.
#[derive(Clone, Debug)]
#[repr(C)]
pub(super) struct Cluster {
    /// The lower corner of the common box.
    corner: [f32; 3],
    /// A step along each axis.
    step: [f32; 3],
    /// The boxes' lower corners, in steps, an axis each.
    lower: [[u8; SIZE]; 3],
    /// Their upper ones.
    upper: [[u8; SIZE]; 3],
    triangles: [u32; SIZE],
}

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

/// A triangle where its box's centre is, twice as far from the origin.
#[derive(Clone, Copy)]
struct Centre {
    at: [f32; 3],
    triangle: u32,
}

/// Groups triangles by place. Triangles with an empty box are left out: nothing hits them.
pub(super) fn group(boxes: &[Bounds]) -> Box<[Cluster]> {
    let mut centres: Vec<Centre> = (0..boxes.len() as u32)
        .into_par_iter()
        .zip(boxes)
        .filter(|(_, bounds)| !bounds.is_empty())
        .map(|(triangle, bounds)| Centre {
            at: (bounds.lower + bounds.upper).to_array(),
            triangle,
        })
        .collect();
    split(&mut centres);
    centres
        .par_chunks(SIZE)
        .map(|members| Cluster::new(boxes, members))
        .collect()
}

/// Sorts triangles such that every run of [`SIZE`] from the first on is a compact one: by the boxes'
/// centres, halved along the longest axis again and again, at a multiple of the size.
fn split(centres: &mut [Centre]) {
    if centres.len() <= SIZE {
        return;
    }
    let half = (centres.len() / 2).next_multiple_of(SIZE);
    match longest_axis(centres) {
        0 => halve::<0>(centres, half),
        1 => halve::<1>(centres, half),
        _ => halve::<2>(centres, half),
    }
    let (left, right) = centres.split_at_mut(half);
    if left.len() > 1 << 12 {
        rayon::join(|| split(left), || split(right));
    } else {
        split(left);
        split(right);
    }
}

/// Moves what is lower along an axis before what is higher.
fn halve<const AXIS: usize>(centres: &mut [Centre], half: usize) {
    // The numbers decide between equal centres, so that the same mesh gives the same clusters.
    centres.select_nth_unstable_by(half, |a, b| {
        let along = a.at[AXIS].total_cmp(&b.at[AXIS]);
        along.then(a.triangle.cmp(&b.triangle))
    });
}

/// The axis along which centres lie furthest apart.
fn longest_axis(centres: &[Centre]) -> usize {
    let first = Vec3::from(centres[0].at);
    let (lower, upper) = centres
        .iter()
        .fold((first, first), |(lower, upper), centre| {
            let at = Vec3::from(centre.at);
            (lower.min(at), upper.max(at))
        });
    (upper - lower).max_position()
}

impl Cluster {
    fn new(boxes: &[Bounds], members: &[Centre]) -> Self {
        let mut all = Bounds::EMPTY;
        let mut bounds = [Bounds::EMPTY; SIZE];
        for (bounds, member) in bounds.iter_mut().zip(members) {
            *bounds = boxes[member.triangle as usize];
            all = all.union(*bounds);
        }
        let mut cluster = Self {
            corner: all.lower.to_array(),
            step: [0.0; 3],
            // An empty box: above its upper end.
            lower: [[u8::MAX; SIZE]; 3],
            upper: [[0; SIZE]; 3],
            triangles: [NONE; SIZE],
        };
        for axis in 0..3 {
            cluster.step[axis] = step(all.lower[axis], all.upper[axis]);
            let per_step = 1.0 / cluster.step[axis];
            for (n, bounds) in bounds[..members.len()].iter().enumerate() {
                let (lower, upper) = (bounds.lower[axis], bounds.upper[axis]);
                cluster.lower[axis][n] = cluster.step_below(axis, lower, per_step);
                cluster.upper[axis][n] = cluster.step_above(axis, upper, per_step);
            }
        }
        for (place, member) in cluster.triangles.iter_mut().zip(members) {
            *place = member.triangle;
        }
        cluster
    }

    /// The number of triangle `n`.
    pub fn triangle(&self, n: usize) -> u32 {
        self.triangles[n]
    }

    /// The box of all its triangles.
    pub fn bounds(&self) -> Bounds {
        let (corner, step) = (glam::Vec3::from(self.corner), glam::Vec3::from(self.step));
        let upper = corner + step * STEPS;
        Bounds {
            lower: corner,
            upper: upper.to_array().map(f32::next_up).into(),
        }
    }

    /// How far a number of steps leads. From the corner, not from the origin, whose distance may be
    /// large against the box, and rounding with it.
    fn way(&self, axis: usize, steps: u8) -> f32 {
        self.step[axis] * f32::from(steps)
    }

    /// The greatest number of steps, but for rounding, that leads no further than this.
    fn step_below(&self, axis: usize, to: f32, per_step: f32) -> u8 {
        let way = to - self.corner[axis];
        let mut steps = (way * per_step) as u8;
        while steps > 0 && self.way(axis, steps) > way {
            steps -= 1;
        }
        steps
    }

    /// The least number of steps, but for rounding, that leads as far as this.
    fn step_above(&self, axis: usize, to: f32, per_step: f32) -> u8 {
        let way = to - self.corner[axis];
        let mut steps = (way * per_step) as u8;
        while steps < u8::MAX && self.way(axis, steps) < way {
            steps += 1;
        }
        steps
    }

    /// The places that hold a triangle, one bit each.
    fn present(&self) -> u32 {
        let missing = self.triangles.iter().filter(|&&triangle| triangle == NONE);
        ALL >> missing.count()
    }

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

    /// For each triangle the lanes, of those in `valid`, whose rays meet its box.
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
                    let (near, far) = way.between(self.lower[axis][n], self.upper[axis][n]);
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

/// All places of a cluster, one bit each.
const ALL: u32 = u32::MAX >> (u32::BITS as usize - SIZE);

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

    /// Counts some boxes, one bit each, as met no more.
    pub fn leave(&mut self, boxes: u32) {
        for (n, met) in self.met.iter_mut().enumerate() {
            if boxes & 1 << n != 0 {
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
    fn between(&self, lower: u8, upper: u8) -> (S::f32s, S::f32s) {
        let a = self.start + self.step * f32::from(lower);
        let b = self.start + self.step * f32::from(upper);
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

/// A step along an axis from the lower to the upper end of a cluster's box, such that all of them
/// reach the upper end whatever the rounding.
fn step(lower: f32, upper: f32) -> f32 {
    let mut step = (upper - lower) / STEPS;
    while step * STEPS < upper - lower {
        step = step.next_up();
    }
    step.max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;
    use rand::{Rng, SeedableRng, rngs::SmallRng};

    fn boxes(random: &mut SmallRng, count: usize, size: f32, centre: Vec3) -> Vec<Bounds> {
        let mut point = |size: f32| vec3(random.random(), random.random(), random.random()) * size;
        (0..count)
            .map(|_| {
                let lower = centre + point(size);
                let upper = lower + point(size * 0.1);
                Bounds { lower, upper }
            })
            .collect()
    }

    #[test]
    fn every_triangle_with_a_box_is_in_one_cluster_that_holds_it() {
        let mut random = SmallRng::seed_from_u64(1);
        for count in [0, 1, 7, 8, 9, 1000, 20_001] {
            let mut boxes = boxes(&mut random, count, 2.0, Vec3::ZERO);
            for empty in boxes.iter_mut().step_by(11) {
                *empty = Bounds::EMPTY;
            }
            let clusters = group(&boxes);
            let mut seen: Vec<u32> = Vec::new();
            for cluster in &clusters {
                for (n, &triangle) in cluster.triangles.iter().enumerate() {
                    if triangle == NONE {
                        continue;
                    }
                    seen.push(triangle);
                    let wanted = &boxes[triangle as usize];
                    for axis in 0..3 {
                        // But for rounding of the box's size, which tests of rays make up for.
                        let at = |steps: u8| {
                            f64::from(cluster.corner[axis])
                                + f64::from(cluster.step[axis]) * f64::from(steps)
                        };
                        let room = f64::from(cluster.step[axis] * STEPS * f32::EPSILON);
                        let [lower, upper] =
                            [wanted.lower[axis], wanted.upper[axis]].map(f64::from);
                        assert!(at(cluster.lower[axis][n]) <= lower + room);
                        assert!(at(cluster.upper[axis][n]) >= upper - room);
                        assert!(cluster.bounds().lower[axis] <= wanted.lower[axis]);
                        assert!(cluster.bounds().upper[axis] >= wanted.upper[axis]);
                    }
                }
            }
            seen.sort_unstable();
            let expected = (0..count as u32).filter(|&n| n % 11 != 0);
            assert_eq!(seen, expected.collect::<Vec<_>>());
            assert_eq!(clusters.len(), seen.len().div_ceil(SIZE));
        }
    }

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
