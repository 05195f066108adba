//! Rays that may have several crossings, one by one.

use std::borrow::Borrow;

use fearless_simd::{f32x4, prelude::*};

use super::clip::RayInterval;
use super::hit::{Hit, Solver};
use super::ray::Ray;
use super::root::{MAX_PARTS, Samples, Steps};
use super::segment::{SEGMENT_NUMBERS, Segment};
use crate::numbers::{
    LaneMask, Lanes, MAX_LANES, Mask, Quad, Real, Vector, inlined, set_bits, vector,
};
use crate::patch::Patch;

/// One ray in all lanes of a quad.
#[inline(always)]
pub(crate) fn trace_one<S: Simd>(
    simd: S,
    patch: &Patch<f32>,
    interval: &RayInterval<f32>,
    ray: &Ray<f32>,
    solver: Solver,
    normal: bool,
) -> (Hit<f32>, Vector<f32>) {
    let lanes = Quad(f32x4::splat(simd, 0.0));
    let hit = patch.intersect_with_search(
        &interval.in_lanes(lanes),
        &ray.in_lanes(lanes),
        solver,
        #[inline(always)]
        |segment: Segment<Quad<S>>| {
            let mut numbers = [0.0; SEGMENT_NUMBERS];
            for (number, value) in numbers.iter_mut().zip(segment.numbers()) {
                *number = value.0[0];
            }
            search(simd, patch, Segment::from_numbers(&numbers, true), solver).in_lanes(lanes)
        },
    );
    let normal = if normal && hit.found.any() {
        let Vector { x, y, z } = patch.geometric_normal(hit.u, hit.v);
        vector(x.0[0], y.0[0], z.0[0])
    } else {
        vector(0.0, 0.0, 0.0)
    };
    let hit = Hit {
        found: hit.found.any(),
        t: hit.t.0[0],
        u: hit.u.0[0],
        v: hit.v.0[0],
        // Every lane counts.
        evaluations: hit.evaluations / 4,
    };
    (hit, normal)
}

/// [`Patch::search_roots`] of one ray, which samples F at all parts' ends at once, one a lane.
fn search<S: Simd>(simd: S, patch: &Patch<f32>, segment: Segment<f32>, solver: Solver) -> Hit<f32> {
    simd.vectorize(
        #[inline(always)]
        || {
            let sampler = inlined(
                #[inline(always)]
                |segment: &Segment<f32>, steps| Some(sample(simd, patch, segment, steps)),
            );
            patch.search_roots(segment, solver.denser(patch.is_high()), &sampler)
        },
    )
}

/// [`Patch::search_roots`] of the lanes that are alive, one by one: there are few.
#[inline(always)]
pub(crate) fn search_lanes<S: Simd>(
    simd: S,
    patch: &Patch<f32>,
    segment: &Segment<Lanes<S>>,
    solver: Solver,
) -> Hit<Lanes<S>> {
    let mut columns = [[0.0; MAX_LANES]; SEGMENT_NUMBERS];
    for (column, number) in columns.iter_mut().zip(segment.numbers()) {
        number.store(column, 0);
    }
    let alive = segment.alive.0.to_bitmask();
    let searched = search_each(simd, &columns, alive, |_| patch, solver);
    let [t, u, v] = &searched.hits;
    Hit {
        found: LaneMask(S::mask32s::from_bitmask(simd, searched.found)),
        t: Lanes::load(simd, t, 0),
        u: Lanes::load(simd, u, 0),
        v: Lanes::load(simd, v, 0),
        evaluations: searched.evaluations,
    }
}

/// What [`search_each`] finds.
pub(crate) struct Searched {
    /// The lanes with a hit, one bit each.
    pub found: u64,
    /// Their t, u and v.
    pub hits: [[f32; MAX_LANES]; 3],
    pub evaluations: u32,
}

/// [`Patch::search_roots`] of the lanes that are alive, one bit each, one by one: each lane's segment, a
/// column a number, on its patch.
#[inline(always)]
pub(crate) fn search_each<S: Simd, P: Borrow<Patch<f32>>>(
    simd: S,
    columns: &[[f32; MAX_LANES]; SEGMENT_NUMBERS],
    alive: u64,
    patch: impl Fn(usize) -> P,
    solver: Solver,
) -> Searched {
    let mut searched = Searched {
        found: 0,
        hits: [[0.0; MAX_LANES]; 3],
        evaluations: 0,
    };
    for lane in set_bits(alive) {
        let mut numbers = [0.0; SEGMENT_NUMBERS];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = column[lane];
        }
        let segment = Segment::from_numbers(&numbers, true);
        let hit = search(simd, patch(lane).borrow(), segment, solver);
        searched.evaluations += hit.evaluations;
        searched.found |= u64::from(hit.found) << lane;
        for (column, value) in searched.hits.iter_mut().zip([hit.t, hit.u, hit.v]) {
            column[lane] = value;
        }
    }
    searched
}

/// F at the ends of all parts of some steps along a segment.
#[inline(always)]
fn sample<S: Simd>(
    simd: S,
    patch: &Patch<f32>,
    segment: &Segment<f32>,
    Steps { start, part, parts }: Steps<f32>,
) -> Samples<f32> {
    const NUMBERS: [f32; 2 * MAX_LANES] = numbers();
    let mut values = [0.0; 2 * MAX_LANES];
    for first in (0..=parts).step_by(S::f32s::LEN) {
        let number = Lanes::<S>(S::f32s::from_slice(simd, &NUMBERS[first..][..S::f32s::LEN]));
        let zero = number.splat(0.0);
        // An endless part times zero would be no number.
        let start = number.splat(start);
        let at = Lanes::select(
            zero.less(number),
            start + number.splat(part) * number,
            start,
        );
        let value = patch.clearance(&segment.in_lanes(number), at);
        value.0.store_slice(&mut values[first..][..S::f32s::LEN]);
    }
    let mut samples = [0.0; MAX_PARTS + 1];
    samples.copy_from_slice(&values[..=MAX_PARTS]);
    samples
}

/// 0, 1, 2 and so on.
const fn numbers() -> [f32; 2 * MAX_LANES] {
    let mut numbers = [0.0; 2 * MAX_LANES];
    let mut n = 1;
    while n < numbers.len() {
        numbers[n] = n as f32;
        n += 1;
    }
    numbers
}
