//! A packet's rays against the patches of a block: each lane a ray and a patch of its own, so that the lanes
//! are full however few rays of a packet may hit each patch.

use fearless_simd::{Level, dispatch, prelude::*};

use super::clip::RayInterval;
use super::hit::{Hit, Solver};
use super::lane_search::search_each;
use super::packet::{RayLanes, load_ray};
use super::ray::Ray;
use super::segment::{SEGMENT_NUMBERS, Segment};
use crate::numbers::{
    Fields, LaneMask, MAX_LANES, ManyPatches, Mask, PATCHES, PairLanes, Patches, Vector,
    from_array, set_bits, to_array, vector,
};
use crate::store::PatchBlock;

/// Most pairs of a ray and a patch; and the lanes of a last register.
const PAIRS: usize = PATCHES * MAX_LANES + MAX_LANES;
/// Words of one bit a pair.
const WORDS: usize = PAIRS.div_ceil(u64::BITS as usize);
/// How many numbers a ray is.
const RAY_NUMBERS: usize = Ray::<f32>::COUNT;
/// Of fewer pairs than this each is searched alone, its samples in the lanes.
const MIN_SEARCHED: u32 = 3;
/// The hits of a packet's rays on the patches of a block, and the working memory to find them.
#[derive(Clone, Debug)]
pub struct PairHits {
    count: usize,
    lane: [u8; PAIRS],
    /// Where in a column the patch's number is: the places of its four bytes.
    patch: [u32; PAIRS],
    /// The rays, a component each, by lane.
    rays: [[f32; MAX_LANES]; RAY_NUMBERS],
    /// The rays' parameters from which on they may meet the patch.
    start: [f32; PAIRS],
    /// And for how long.
    length: [f32; PAIRS],
    /// The pairs that hit, one bit each.
    found: [u64; WORDS],
    t: [f32; PAIRS],
    u: [f32; PAIRS],
    v: [f32; PAIRS],
    normal: [[f32; PAIRS]; 3],
    /// How often the surface was evaluated, the sum over the lanes.
    pub evaluations: u32,
}

/// A hit of one ray on one patch of a block.
#[derive(Clone, Copy, Debug)]
pub struct PairHit {
    /// The ray's lane.
    pub lane: usize,
    /// The patch's place in the block.
    pub patch: usize,
    /// The ray's parameter.
    pub t: f32,
    /// `b2` at the guide's foot.
    pub u: f32,
    /// `b3` at the guide's foot.
    pub v: f32,
    /// The surface's own geometric normal, unit; only where requested.
    pub normal: Vector<f32>,
}

impl Default for PairHits {
    fn default() -> Self {
        Self {
            count: 0,
            lane: [0; PAIRS],
            patch: [0; PAIRS],
            rays: [[0.0; MAX_LANES]; RAY_NUMBERS],
            start: [0.0; PAIRS],
            length: [0.0; PAIRS],
            found: [0; WORDS],
            t: [0.0; PAIRS],
            u: [0.0; PAIRS],
            v: [0.0; PAIRS],
            normal: [[0.0; PAIRS]; 3],
            evaluations: 0,
        }
    }
}

impl PairHits {
    /// All hits, of every ray with every patch at most one: the first.
    pub fn iter(&self) -> impl Iterator<Item = PairHit> {
        let words = self.found.iter().enumerate();
        words
            .flat_map(|(word, &bits)| set_bits(bits).map(move |bit| word * 64 + bit))
            .map(|n| PairHit {
                lane: self.lane[n].into(),
                patch: number_of(self.patch[n]),
                t: self.t[n],
                u: self.u[n],
                v: self.v[n],
                normal: vector(self.normal[0][n], self.normal[1][n], self.normal[2][n]),
            })
    }
}

impl PatchBlock {
    /// The first hits with `tnear <= t <= tfar` of the rays of `lanes` (one bit a lane) with each patch that
    /// is unpacked, with the surface's normals there if `normals`.
    ///
    /// Every answer is bit for bit that of [`Patch::intersect`](crate::Patch::intersect) and [`Patch::normal_at`](crate::Patch::normal_at) for the ray and
    /// the patch alone. Lanes that are not requested may hold anything.
    ///
    /// # Panics
    /// If the slices differ in length, or there are more than 16 rays.
    pub fn intersect_packet(
        &self,
        rays: &RayLanes<'_>,
        lanes: &[u32; PATCHES],
        solver: Solver,
        normals: bool,
        hits: &mut PairHits,
    ) {
        self.intersect_packet_at(Level::new(), rays, lanes, solver, normals, hits);
    }

    /// The same with the instructions of one level.
    #[inline(always)]
    pub(crate) fn intersect_packet_at(
        &self,
        level: Level,
        rays: &RayLanes<'_>,
        lanes: &[u32; PATCHES],
        solver: Solver,
        normals: bool,
        hits: &mut PairHits,
    ) {
        assert!(rays.tnear.len() <= MAX_LANES, "a packet has up to 16 rays");
        dispatch!(level, simd => self.clip(simd, rays, lanes, hits));
        if hits.count > 0 {
            dispatch!(level, simd => self.trace(simd, solver, normals, hits));
        }
    }

    /// Lists the pairs whose ray comes near the surface.
    #[inline(always)]
    fn clip<S: Simd>(
        &self,
        simd: S,
        rays: &RayLanes<'_>,
        lanes: &[u32; PATCHES],
        hits: &mut PairHits,
    ) {
        (hits.count, hits.evaluations, hits.found) = (0, 0, [0; WORDS]);
        let width = rays.tnear.len();
        for first in (0..width).step_by(S::f32s::LEN) {
            let ray = load_ray(simd, rays, first);
            for (to, from) in hits
                .rays
                .iter_mut()
                .zip(to_array::<_, RAY_NUMBERS>(ray, ray.tnear))
            {
                from.0.store_slice(&mut to[first..][..S::f32s::LEN]);
            }
            let there = u64::MAX >> (64 - (width - first));
            for (n, &lanes) in lanes.iter().enumerate() {
                let requested = u64::from(lanes >> first) & there;
                if requested == 0 || self.unpacked() & 1 << n == 0 {
                    continue;
                }
                let valid = LaneMask(S::mask32s::from_bitmask(simd, requested));
                let interval = self.clip_volume(n).clip(&ray, valid);
                let alive = interval.alive.0.to_bitmask();
                if alive == 0 {
                    continue;
                }
                let (mut start, mut length) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
                interval.start.0.store_slice(&mut start[..S::f32s::LEN]);
                interval.length.0.store_slice(&mut length[..S::f32s::LEN]);
                for lane in set_bits(alive) {
                    let to = hits.count;
                    hits.lane[to] = (first + lane) as u8;
                    hits.patch[to] = bytes_of(n);
                    hits.start[to] = start[lane];
                    hits.length[to] = length[lane];
                    hits.count += 1;
                }
            }
        }
        // The lanes of a last register that hold no pair.
        hits.lane[hits.count..][..MAX_LANES].fill(0);
    }

    /// Finds the hits of the pairs, as many at a time as a register holds, or eight where no more are left.
    #[inline(always)]
    fn trace<S: Simd>(&self, simd: S, solver: Solver, normals: bool, hits: &mut PairHits) {
        let mut first = 0;
        while first < hits.count {
            let left = hits.count - first;
            if S::f32s::LEN > PATCHES && left > PATCHES {
                self.trace_some::<S, ManyPatches<S>>(simd, first, solver, normals, hits);
                first += ManyPatches::<S>::LEN;
            } else {
                self.trace_some::<S, Patches<S>>(simd, first, solver, normals, hits);
                first += Patches::<S>::LEN;
            }
        }
    }

    /// Finds the hits of a register's pairs from the first on.
    #[inline(always)]
    fn trace_some<S: Simd, P: PairLanes<S>>(
        &self,
        simd: S,
        first: usize,
        solver: Solver,
        normals: bool,
        hits: &mut PairHits,
    ) {
        let there = u64::MAX >> (64 - (hits.count - first).min(P::LEN));
        let number = &hits.patch[first..][..P::LEN];
        let ray = gather::<S, P>(simd, &hits.rays, &hits.lane[first..][..P::LEN]);
        let patch = self.patches::<S, P>(simd, number);
        let interval = RayInterval {
            start: P::load(simd, &hits.start[first..]),
            length: P::load(simd, &hits.length[first..]),
            alive: P::lanes(simd, there),
        };
        let segment = Segment::new(&patch, &ray, &interval);
        let hit = patch.curved_hit(
            segment,
            solver,
            #[inline(always)]
            |segment| {
                let few = segment.alive.count() < MIN_SEARCHED;
                if few | (segment.alive & patch.is_high()).any() {
                    self.search_pairs(simd, &segment, number, solver)
                } else {
                    patch.search_roots(segment, solver, &|_, _| None)
                }
            },
        );
        hits.evaluations += hit.evaluations;
        let found = P::bits(hit.found & hit.t.at_most(ray.tfar));
        if found == 0 {
            return;
        }
        // No register's pairs begin in one word and end in the next.
        hits.found[first / 64] |= found << (first % 64);
        hit.t.store(&mut hits.t[first..]);
        hit.u.store(&mut hits.u[first..]);
        hit.v.store(&mut hits.v[first..]);
        if normals {
            let normal = patch.geometric_normal(hit.u, hit.v);
            normal.x.store(&mut hits.normal[0][first..]);
            normal.y.store(&mut hits.normal[1][first..]);
            normal.z.store(&mut hits.normal[2][first..]);
        }
    }

    /// [`Patch::search_roots`] of the pairs that are alive, one by one: there are few.
    #[inline(always)]
    fn search_pairs<S: Simd, P: PairLanes<S>>(
        &self,
        simd: S,
        segment: &Segment<P>,
        patch: &[u32],
        solver: Solver,
    ) -> Hit<P> {
        let mut columns = [[0.0; MAX_LANES]; SEGMENT_NUMBERS];
        for (column, number) in columns.iter_mut().zip(segment.numbers()) {
            number.store(column);
        }
        let alive = P::bits(segment.alive);
        let patch = |lane: usize| self.patch(number_of(patch[lane]));
        let searched = search_each(simd, &columns, alive, patch, solver);
        let [t, u, v] = &searched.hits;
        Hit {
            found: P::lanes(simd, searched.found),
            t: P::load(simd, t),
            u: P::load(simd, u),
            v: P::load(simd, v),
            evaluations: searched.evaluations,
        }
    }
}

/// The places of a number's bytes in a column.
fn bytes_of(n: usize) -> u32 {
    0x0302_0100 + 0x0404_0404 * n as u32
}

/// Whose bytes' places these are.
fn number_of(bytes: u32) -> usize {
    (bytes & 0xff) as usize / 4
}

/// A ray a lane.
#[inline(always)]
fn gather<S: Simd, P: PairLanes<S>>(
    simd: S,
    rays: &[[f32; MAX_LANES]; RAY_NUMBERS],
    lanes: &[u8],
) -> Ray<P> {
    let mut bytes = [0; MAX_LANES];
    for (to, &lane) in bytes.iter_mut().zip(lanes) {
        *to = bytes_of(lane.into());
    }
    let places = P::places(simd, &bytes);
    let mut numbers = [P::load(simd, &[0.0; MAX_LANES]); RAY_NUMBERS];
    for (number, column) in numbers.iter_mut().zip(rays) {
        *number = P::of_rays(simd, column, lanes, places);
    }
    from_array(Ray::blank(numbers[0]), &numbers)
}
