//! Which triangles of a cluster a ray may hit: those whose boxes it hits.

use fearless_simd::{Level, dispatch, f32x4, f32x8, prelude::*, u32x8};

use super::layout::{Cluster, DIRECTIONS, NONE, SIZE};
use crate::curved::bits::set_bits;
use curvetri_method::{
    Lanes, MAX_LANES, Quad, Ray, RayLanes, Real, Vector, inlined, load_lanes, three, vector,
};

/// Rounding of a ray's distance to an end of a box, relative to what it is computed from.
const ROUNDING: f32 = 16.0 * f32::EPSILON;
/// Least size of a direction's component: keeps its inverse, and products with it, finite.
const LEAST_DIRECTION: f32 = 1e-18;

/// Where a ray enters the boxes of a cluster.
pub(in crate::curved) struct RayEntries {
    /// The boxes that it hits and that are left, one bit each.
    boxes: u32,
    /// The ray's parameter there, for each box.
    t: [f32; SIZE],
}

/// Where the rays of a packet enter the boxes of a cluster.
pub(in crate::curved) struct PacketEntries {
    /// For each box that is left the lanes that hit it, one bit each.
    lanes: [u32; SIZE],
    /// The rays' parameters there, for each box.
    t: [[f32; MAX_LANES]; SIZE],
}

impl RayEntries {
    /// Tests all boxes at once.
    pub fn new(cluster: &Cluster, ray: &Ray<f32>) -> Self {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || Self::in_lanes(simd, cluster, ray)
        ))
    }

    #[inline(always)]
    fn in_lanes<S: Simd>(simd: S, cluster: &Cluster, ray: &Ray<f32>) -> Self {
        let (mut from, mut to) = (f32x8::splat(simd, ray.tnear), f32x8::splat(simd, ray.tfar));
        let slabs = ray_slabs(simd, cluster, ray);
        for (axis, slab) in slabs.iter().enumerate() {
            let [middle, half] = cluster.ranges_in_steps(axis);
            let middle = f32x8::from_slice(simd, &middle).mul_add(slab.step, slab.start);
            let half = f32x8::from_slice(simd, &half).mul_add(slab.half_step, slab.tolerance);
            from = from.max(middle - half);
            to = to.min(middle + half);
        }
        let hit = from.simd_le(to).to_bitmask() as u32;
        let triangles = u32x8::from_slice(simd, &cluster.triangles);
        let present = (!triangles.simd_eq(u32x8::splat(simd, NONE))).to_bitmask() as u32;
        let mut t = [0.0; SIZE];
        from.store_slice(&mut t);
        Self {
            boxes: hit & present,
            t,
        }
    }

    /// The boxes that are left, one bit each.
    pub fn boxes(&self) -> u32 {
        self.boxes
    }

    /// Takes out the box that the ray enters first, and gives its place. None where the ray enters all that
    /// are left beyond `tfar`.
    #[inline]
    pub fn next(&mut self, tfar: f32) -> Option<usize> {
        let mut nearest = None;
        for n in set_bits(self.boxes) {
            if nearest.is_none_or(|nearest: usize| self.t[n] < self.t[nearest]) {
                nearest = Some(n);
            }
        }
        let nearest = nearest.filter(|&nearest| self.t[nearest] <= tfar)?;
        self.boxes &= !(1 << nearest);
        Some(nearest)
    }
}

impl PacketEntries {
    /// Tests the boxes at these places, one bit each, against the rays in the lanes of `valid`.
    pub fn new(cluster: &Cluster, places: u32, rays: &RayLanes<'_>, valid: u32) -> Self {
        let mut t = [[0.0; MAX_LANES]; SIZE];
        let mut lanes = dispatch!(Level::new(), simd => test_packet(
            simd,
            cluster,
            rays,
            valid,
            #[inline(always)]
            |n, first, from| from.store_slice(&mut t[n][first..][..from.as_slice().len()]),
        ));
        for (n, lanes) in lanes.iter_mut().enumerate() {
            if places & 1 << n == 0 {
                *lanes = 0;
            }
        }
        Self { lanes, t }
    }

    /// Takes out the box that is entered first, and gives its place and the lanes of `valid` that enter it no
    /// further away than their `tfar`. None where nothing is left.
    #[inline]
    pub fn next(&mut self, tfar: &[f32], valid: u32) -> Option<(usize, u32)> {
        while let Some(n) = self.nearest() {
            let lanes = std::mem::take(&mut self.lanes[n]) & valid;
            let lanes = lanes & not_beyond(&self.t[n], tfar);
            if lanes != 0 {
                return Some((n, lanes));
            }
        }
        None
    }

    /// The box that is nearest by the first lane that hits it: the rays of a packet run in parallel, or else
    /// no order suits all.
    fn nearest(&self) -> Option<usize> {
        let t = |n: usize| self.t[n][self.lanes[n].trailing_zeros() as usize];
        let left = (0..SIZE).filter(|&n| self.lanes[n] != 0);
        left.min_by(|&a, &b| t(a).total_cmp(&t(b)))
    }
}

/// For each box of a cluster the lanes of `valid` whose rays hit it, one bit each.
pub(in crate::curved) fn lanes_in_boxes(
    cluster: &Cluster,
    rays: &RayLanes<'_>,
    valid: u32,
) -> [u32; SIZE] {
    dispatch!(Level::new(), simd => test_packet(
        simd,
        cluster,
        rays,
        valid,
        #[inline(always)]
        |_, _, _| (),
    ))
}

/// Tests a register's lanes at a time. `enter` gets a box, the first lane, and where the rays enter the box.
#[inline(always)]
fn test_packet<S: Simd>(
    simd: S,
    cluster: &Cluster,
    rays: &RayLanes<'_>,
    valid: u32,
    mut enter: impl FnMut(usize, usize, S::f32s),
) -> [u32; SIZE] {
    let mut all = [0; SIZE];
    // Converted in lanes, once: a box at a time that would take as long as its test.
    let mut ranges = [[[0.0; SIZE]; 2]; DIRECTIONS];
    for (axis, ranges) in ranges.iter_mut().enumerate() {
        *ranges = cluster.ranges_in_steps(axis);
    }
    for first in (0..rays.tnear.len().min(MAX_LANES)).step_by(S::f32s::LEN) {
        let slabs = packet_slabs::<S>(simd, cluster, rays, first);
        let tnear = load_lanes(simd, rays.tnear, first);
        let tfar = load_lanes(simd, rays.tfar, first);
        let valid = valid >> first;
        for n in 0..SIZE {
            if cluster.triangles[n] == NONE {
                break;
            }
            let (mut from, mut to) = (tnear, tfar);
            for (slab, [middle, half]) in slabs.iter().zip(&ranges) {
                let middle = slab.step.0.mul_add(middle[n], slab.start.0);
                let half = slab.half_step.0.mul_add(half[n], slab.tolerance.0);
                from = from.max(middle - half);
                to = to.min(middle + half);
            }
            let hit = from.simd_le(to).to_bitmask() as u32 & valid;
            all[n] |= hit << first;
            enter(n, first, from);
        }
    }
    all
}

/// The lanes whose first value is at most the second, one bit each.
fn not_beyond(t: &[f32; MAX_LANES], tfar: &[f32]) -> u32 {
    #[inline(always)]
    fn by<S: Simd>(simd: S, t: &[f32], tfar: &[f32]) -> u32 {
        let mut lanes = 0;
        for first in (0..tfar.len().min(MAX_LANES)).step_by(S::f32s::LEN) {
            let (t, tfar) = (load_lanes(simd, t, first), load_lanes(simd, tfar, first));
            lanes |= (t.simd_le(tfar).to_bitmask() as u32) << first;
        }
        lanes
    }
    dispatch!(Level::new(), simd => by(simd, t, tfar))
}

/// A ray's parameters along one direction of a cluster, where boxes are counted in steps.
#[derive(Clone, Copy)]
struct RaySlab<V> {
    /// At the cluster's middle.
    start: V,
    /// From one step to the next.
    step: V,
    /// Half as far, without its sign.
    half_step: V,
    /// What rounding may move it by.
    tolerance: V,
}

impl<V: Real<Scalar = f32>> RaySlab<V> {
    /// From a ray's origin, relative to the middle of a cluster of this extent, and the ray's direction.
    #[inline(always)]
    fn new(axis: Vector<V>, step: V, origin: Vector<V>, direction: Vector<V>, extent: V) -> Self {
        let rate = axis.dot(direction);
        let least = rate.splat(LEAST_DIRECTION);
        let inverse = rate.constant(1.0) / V::select(rate.abs().less(least), least, rate);
        // Rounding of the products is rounding of the sizes of what is multiplied. A rate that is rounded, or
        // moved off zero, passes by a little further on.
        let distance = origin.x.abs() + origin.y.abs() + origin.z.abs();
        let tolerance = (distance + extent) * rate.splat(ROUNDING);
        Self {
            start: -(axis.dot(origin) * inverse),
            step: step * inverse,
            half_step: step * inverse.abs() * rate.constant(0.5),
            tolerance: tolerance * inverse.abs(),
        }
    }
}

/// A ray's slabs along the directions, computed one a lane.
#[inline(always)]
fn ray_slabs<S: Simd>(simd: S, cluster: &Cluster, ray: &Ray<f32>) -> [RaySlab<f32>; DIRECTIONS] {
    let quad = inlined(
        #[inline(always)]
        |of: [f32; 4]| Quad(f32x4::from_slice(simd, &of)),
    );
    let [x, y, z] = three(
        #[inline(always)]
        |component| quad(cluster.components(component)),
    );
    let slab = RaySlab::new(
        vector(x, y, z),
        quad(cluster.step()),
        Vector::splat(x, ray.origin - cluster.middle().into()),
        Vector::splat(x, ray.direction),
        x.splat(cluster.extent()),
    );
    let one = inlined(
        #[inline(always)]
        |axis: usize| RaySlab {
            start: slab.start.0[axis],
            step: slab.step.0[axis],
            half_step: slab.half_step.0[axis],
            tolerance: slab.tolerance.0[axis],
        },
    );
    [one(0), one(1), one(2), one(3)]
}

/// The slabs of a register's rays along the directions.
#[inline(always)]
fn packet_slabs<S: Simd>(
    simd: S,
    cluster: &Cluster,
    rays: &RayLanes<'_>,
    first: usize,
) -> [RaySlab<Lanes<S>>; DIRECTIONS] {
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
    let (origin, direction) = (load(rays.origin), load(rays.direction));
    let like = origin.x;
    let origin = origin - Vector::splat(like, cluster.middle().into());
    let extent = like.splat(cluster.extent());
    let step = cluster.step();
    let one = inlined(
        #[inline(always)]
        |axis: usize| {
            let along = Vector::splat(like, cluster.direction(axis).into());
            RaySlab::new(along, like.splat(step[axis]), origin, direction, extent)
        },
    );
    [one(0), one(1), one(2), one(3)]
}

#[cfg(test)]
mod tests {
    use super::super::test_triangles::TestTriangles;
    use super::*;
    use glam::{Vec3, vec3};
    use rand::{Rng, SeedableRng, rngs::SmallRng};

    #[test]
    fn no_box_of_a_triangle_that_a_ray_hits_is_left_out() {
        let mut random = SmallRng::seed_from_u64(2);
        let (mut aimed, mut hit) = (0, 0);
        for (size, lower) in [
            (1.0, Vec3::ZERO),
            (1e6, Vec3::ZERO),
            (1e-6, Vec3::splat(-5e-6)),
            (1.0, vec3(1e4, -2e3, 0.0)),
        ] {
            let triangles = TestTriangles::new(7, 400, size, lower);
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
                let ray = Ray {
                    origin: from.into(),
                    direction: direction.into(),
                    tnear: 0.0,
                    tfar: f32::INFINITY,
                };
                let entries = RayEntries::new(cluster, &ray);
                assert!(entries.boxes & 1 << place != 0, "{ray:?} {n}");
                aimed += 1;
                hit += entries.boxes.count_ones();
                check_order(cluster, &ray, entries);
            }
        }
        assert!(hit < 4 * aimed, "{hit} for {aimed}");
    }

    /// Boxes come in the order in which the ray enters them, and a packet of it in some lanes says the same.
    fn check_order(cluster: &Cluster, ray: &Ray<f32>, mut entries: RayEntries) {
        let boxes = entries.boxes;
        let mut last = f32::NEG_INFINITY;
        while let Some(n) = entries.next(f32::INFINITY) {
            assert!(entries.t[n] >= last);
            last = entries.t[n];
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
        let mut entries = PacketEntries::new(cluster, u32::MAX, &rays, 0b1010);
        let (mut seen, mut last) = (0, f32::NEG_INFINITY);
        while let Some((n, lanes)) = entries.next(&tfar, 0b1011) {
            assert_eq!(lanes, 0b1010);
            assert!(entries.t[n][1] >= last);
            (seen, last) = (seen | 1 << n, entries.t[n][1]);
        }
        assert_eq!(seen, boxes);
        let mut entries = PacketEntries::new(cluster, u32::MAX, &rays, u32::MAX);
        assert_eq!(entries.next(&splat(f32::NEG_INFINITY), u32::MAX), None);
    }
}
