//! A packet of rays against one patch, on SIMD lanes: the kernel's one source over [`Lanes`], for
//! whatever instruction set the processor turns out to have.

use std::borrow::Borrow;

use fearless_simd::{Level, dispatch, f32x4, prelude::*};

use super::finish::{MAX_PARTS, Samples};
use super::hit::{Hit, Solver, Steps};
use super::hull::Interval;
use super::kept::KeptPatch;
use super::lanes::{LaneMask, Lanes, Quad};
use super::outline::{Outline, surface};
use super::patch::Patch;
use super::ray::{Ray, SEGMENT_NUMBERS, Segment};
use super::real::{Mask, Real, inlined};
use super::single::Single;
use super::vector::{Vector, vector};

/// Most rays of a packet.
pub const MAX_LANES: usize = 16;

/// Up to 16 rays, one slice a component, all of the same length.
#[derive(Clone, Copy, Debug)]
pub struct RayLanes<'a> {
    /// Where `t = 0`: x, y and z.
    pub origin: [&'a [f32]; 3],
    /// The way for one unit of `t`: x, y and z.
    pub direction: [&'a [f32]; 3],
    /// Least parameters of a hit.
    pub tnear: &'a [f32],
    /// Greatest parameters of a hit.
    pub tfar: &'a [f32],
}

/// Where the rays of a packet meet the surface first.
#[derive(Clone, Copy, Debug)]
pub struct HitLanes {
    /// The lanes that do, one bit a lane; the other fields are undefined elsewhere.
    pub found: u32,
    /// The rays' parameters.
    pub t: [f32; MAX_LANES],
    /// `b2` at the guides' feet.
    pub u: [f32; MAX_LANES],
    /// `b3` at the guides' feet.
    pub v: [f32; MAX_LANES],
    /// The surface's own geometric normals, unit, x, y and z; only where asked for.
    pub normal: [[f32; MAX_LANES]; 3],
    /// How often the surface was evaluated, the sum over the lanes.
    pub evaluations: u32,
}

/// What is asked of a packet.
#[derive(Clone, Copy, Debug)]
struct Asked {
    valid: u32,
    solver: Solver,
    normals: bool,
}

impl KeptPatch<'_> {
    /// The first hits with `tnear < t <= tfar` of the lanes of `valid` (one bit a lane), with the
    /// surface's normals there if `normals`.
    ///
    /// Every lane's answer is bit for bit that of [`Patch::intersect`](super::Patch::intersect) and
    /// [`Patch::normal_at`](super::Patch::normal_at) for its ray alone. Lanes that are not valid may
    /// hold anything.
    ///
    /// # Panics
    /// If the slices differ in length, or there are more than 16 rays.
    #[inline]
    pub fn intersect_packet(
        &self,
        rays: &RayLanes<'_>,
        valid: u32,
        solver: Solver,
        normals: bool,
    ) -> HitLanes {
        self.intersect_packet_at(Level::new(), rays, valid, solver, normals)
    }

    /// The same with the instructions of one level.
    #[inline(always)]
    pub(super) fn intersect_packet_at(
        &self,
        level: Level,
        rays: &RayLanes<'_>,
        valid: u32,
        solver: Solver,
        normals: bool,
    ) -> HitLanes {
        assert!(rays.tnear.len() <= MAX_LANES, "a packet has up to 16 rays");
        let there = u32::MAX >> (u32::BITS as usize - MAX_LANES) >> (MAX_LANES - rays.tnear.len());
        let asked = Asked {
            // The lanes of a register beyond the packet hold no ray.
            valid: valid & there,
            solver,
            normals,
        };
        let mut hits = HitLanes {
            found: 0,
            t: [0.0; MAX_LANES],
            u: [0.0; MAX_LANES],
            v: [0.0; MAX_LANES],
            normal: [[0.0; MAX_LANES]; 3],
            evaluations: 0,
        };
        // Laid out within, so that the level's instructions serve that as well.
        dispatch!(level, simd => trace(simd, &self.outline(), rays, asked, &mut hits));
        hits
    }

    /// Where the ray first meets the surface with `tnear < t <= tfar`, and the surface's normal there
    /// if `normal`, else zeros.
    ///
    /// The answer is bit for bit that of [`Patch::intersect`] and [`Patch::normal_at`], but for the count
    /// of evaluations: a ray that may meet the surface several times has it sampled in many places at
    /// once, also in those beyond the first root.
    #[inline]
    pub fn intersect(
        &self,
        ray: &Ray<f32>,
        solver: Solver,
        normal: bool,
    ) -> (Hit<f32>, Vector<f32>) {
        self.intersect_at(Level::new(), ray, solver, normal)
    }

    /// The same with the instructions of one level.
    #[inline(always)]
    pub(super) fn intersect_at(
        &self,
        level: Level,
        ray: &Ray<f32>,
        solver: Solver,
        normal: bool,
    ) -> (Hit<f32>, Vector<f32>) {
        let mut found = (Hit::none(0.0), vector(0.0, 0.0, 0.0));
        dispatch!(level, simd => {
            let (interval, frame) = match self.single_slab() {
                Some(slab) => {
                    let single = Single::new(simd, self.corners(), slab);
                    (single.clip(ray), Some(single.frame))
                }
                None => {
                    let outline = self.outline();
                    (outline.clip(ray, true), outline.frame)
                }
            };
            if let Some(frame) = frame && interval.alive {
                let patch = surface(&frame, &self.corners().normals, self.record());
                found = trace_one(simd, &patch, &interval, ray, solver, normal);
            }
        });
        found
    }
}

/// One ray in all lanes of a quad.
#[inline(always)]
fn trace_one<S: Simd>(
    simd: S,
    patch: &Patch<f32>,
    interval: &Interval<f32>,
    ray: &Ray<f32>,
    solver: Solver,
    normal: bool,
) -> (Hit<f32>, Vector<f32>) {
    let like = Quad(f32x4::splat(simd, 0.0));
    let hit = patch.intersect_by(
        &interval.in_lanes(like),
        &ray.in_lanes(like),
        solver,
        #[inline(always)]
        |segment: Segment<Quad<S>>| {
            let mut numbers = [0.0; SEGMENT_NUMBERS];
            for (number, lanes) in numbers.iter_mut().zip(segment.numbers()) {
                *number = lanes.0[0];
            }
            search(simd, patch, Segment::from_numbers(numbers, true), solver).in_lanes(like)
        },
    );
    let normal = if normal && hit.found.any() {
        let Vector { x, y, z } = patch.normal_at(hit.u, hit.v);
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

/// [`Patch::searched`] of one ray, which samples F at all parts' ends at once, one a lane.
fn search<S: Simd>(simd: S, patch: &Patch<f32>, segment: Segment<f32>, solver: Solver) -> Hit<f32> {
    simd.vectorize(
        #[inline(always)]
        || {
            let sampler = inlined(
                #[inline(always)]
                |segment: &Segment<f32>, steps| Some(sample(simd, patch, segment, steps)),
            );
            patch.searched(segment, solver.denser(patch.is_high()), &sampler)
        },
    )
}

/// [`Patch::searched`] of the lanes that are alive, one by one: there are few.
#[inline(always)]
fn search_lanes<S: Simd>(
    simd: S,
    patch: &Patch<f32>,
    segment: &Segment<Lanes<S>>,
    solver: Solver,
) -> Hit<Lanes<S>> {
    let mut columns = [[0.0; MAX_LANES]; SEGMENT_NUMBERS];
    for (column, number) in columns.iter_mut().zip(segment.numbers()) {
        store(number, column, 0);
    }
    let alive = segment.alive.0.to_bitmask();
    let searched = search_each(simd, &columns, alive, |_| patch, solver);
    let [t, u, v] = &searched.hits;
    Hit {
        found: LaneMask(S::mask32s::from_bitmask(simd, searched.found)),
        t: load(simd, t, 0),
        u: load(simd, u, 0),
        v: load(simd, v, 0),
        evaluations: searched.evaluations,
    }
}

/// What [`search_each`] finds.
pub(super) struct Searched {
    /// The lanes with a hit, one bit each.
    pub found: u64,
    /// Their t, u and v.
    pub hits: [[f32; MAX_LANES]; 3],
    pub evaluations: u32,
}

/// [`Patch::searched`] of the lanes that are alive, one bit each, one by one: each lane's segment, a
/// column a number, on its patch.
#[inline(always)]
pub(super) fn search_each<S: Simd, P: Borrow<Patch<f32>>>(
    simd: S,
    columns: &[[f32; MAX_LANES]; SEGMENT_NUMBERS],
    mut alive: u64,
    patch: impl Fn(usize) -> P,
    solver: Solver,
) -> Searched {
    let mut searched = Searched {
        found: 0,
        hits: [[0.0; MAX_LANES]; 3],
        evaluations: 0,
    };
    while alive != 0 {
        let lane = alive.trailing_zeros() as usize;
        alive &= alive - 1;
        let mut numbers = [0.0; SEGMENT_NUMBERS];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = column[lane];
        }
        let segment = Segment::from_numbers(numbers, true);
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

/// A register's lanes at a time.
#[inline(always)]
fn trace<S: Simd>(
    simd: S,
    outline: &Outline<'_, f32>,
    rays: &RayLanes<'_>,
    asked: Asked,
    hits: &mut HitLanes,
) {
    let mut patch = None;
    for first in (0..rays.tnear.len()).step_by(S::f32s::LEN) {
        let valid = S::mask32s::from_bitmask(simd, u64::from(asked.valid >> first));
        let ray = load_ray(simd, rays, first);
        let interval = outline.clip(&ray, LaneMask(valid));
        if interval.is_empty() {
            continue;
        }
        let patch = &*patch.get_or_insert_with(
            #[inline(always)]
            || outline.surface(),
        );
        let hit = match asked.solver {
            Solver::Ita { .. } => patch.intersect_within(&interval, &ray, asked.solver),
            Solver::Finish { .. } => patch.intersect_by(
                &interval,
                &ray,
                asked.solver,
                #[inline(always)]
                |segment| search_lanes(simd, patch, &segment, asked.solver),
            ),
        };
        hits.evaluations += hit.evaluations;
        let found = hit.found.0.to_bitmask() as u32;
        if found == 0 {
            continue;
        }
        hits.found |= found << first;
        store(hit.t, &mut hits.t, first);
        store(hit.u, &mut hits.u, first);
        store(hit.v, &mut hits.v, first);
        if asked.normals {
            let normal = patch.normal_at(hit.u, hit.v);
            store(normal.x, &mut hits.normal[0], first);
            store(normal.y, &mut hits.normal[1], first);
            store(normal.z, &mut hits.normal[2], first);
        }
    }
}

#[inline(always)]
pub(super) fn load_ray<S: Simd>(simd: S, rays: &RayLanes<'_>, first: usize) -> Ray<Lanes<S>> {
    let load_vector = inlined(
        #[inline(always)]
        |[x, y, z]: [&[f32]; 3]| -> Vector<Lanes<S>> {
            vector(
                load(simd, x, first),
                load(simd, y, first),
                load(simd, z, first),
            )
        },
    );
    Ray {
        origin: load_vector(rays.origin),
        direction: load_vector(rays.direction),
        tnear: load(simd, rays.tnear, first),
        tfar: load(simd, rays.tfar, first),
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, from: &[f32], first: usize) -> Lanes<S> {
    Lanes(load_lanes(simd, from, first))
}

/// A register's lanes of a packet from `first` on; zeros beyond the end.
#[inline(always)]
pub fn load_lanes<S: Simd>(simd: S, from: &[f32], first: usize) -> S::f32s {
    let rest = &from[first..];
    match rest.get(..S::f32s::LEN) {
        Some(lanes) => S::f32s::from_slice(simd, lanes),
        None => {
            let mut lanes = [0.0; MAX_LANES];
            lanes[..rest.len()].copy_from_slice(rest);
            S::f32s::from_slice(simd, &lanes[..S::f32s::LEN])
        }
    }
}

#[inline(always)]
fn store<S: Simd>(lanes: Lanes<S>, to: &mut [f32; MAX_LANES], first: usize) {
    lanes.0.store_slice(&mut to[first..][..S::f32s::LEN]);
}
