//! Several patches laid out side by side, and a packet's rays against all of them: each lane a ray and a
//! patch of its own, so that the lanes are full however many patches a packet's rays come by.

use fearless_simd::{Level, dispatch, f32x8, mask32x8, prelude::*, u32x8};

use super::columns::{Column, HULL, PATCH, Pick, Store, VERTICES, vertices};
use super::flags::{BoundsKind, PatchFlags, Surface};
use super::frame::Frame;
use super::hit::{Hit, Solver};
use super::hull::{Hull, Interval};
use super::kept::KeptPatch;
use super::lanes::{LaneMask, PATCHES, PatchMask, Patches};
use super::packet::{MAX_LANES, RayLanes, load_ray, search_each};
use super::patch::{Patch, PatchKind, Rule};
use super::ray::{Ray, SEGMENT_NUMBERS, Segment};
use super::real::{Constant, Mask, Real, inlined, three};
use super::vector::{Vector, vector};

/// Most pairs of a ray and a patch, with room for a last register's lanes.
const PAIRS: usize = PATCHES * MAX_LANES + PATCHES;
/// Of fewer pairs than this each is searched alone, its samples in the lanes.
const MIN_SEARCHED: u32 = 3;
/// How many numbers a patch is laid out from.
const SOURCE: usize = 30;

/// Up to eight patches, laid out for rays.
#[derive(Clone, Debug)]
pub struct PatchBlock {
    /// Which ones are, one bit each.
    laid: u32,
    any_obtuse: bool,
    /// A number of each patch: [`Hull::visit`].
    hulls: [[f32; PATCHES]; HULL],
    /// A number of each patch: [`Patch::visit`].
    patches: [[f32; PATCHES]; PATCH],
}

/// The hits of a packet's rays on the patches of a block, and room to find them.
#[derive(Clone, Debug)]
pub struct PairHits {
    count: usize,
    lane: [u8; PAIRS],
    /// Where in a column the patch's number is: the places of its four bytes.
    patch: [u32; PAIRS],
    /// The rays, a component each, by lane.
    rays: [[f32; MAX_LANES]; 8],
    /// The rays' parameters from which on they may meet the patch.
    start: [f32; PAIRS],
    /// And for how long.
    length: [f32; PAIRS],
    found: [bool; PAIRS],
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
    /// The surface's own geometric normal, unit; only where asked for.
    pub normal: Vector<f32>,
}

impl Default for PairHits {
    fn default() -> Self {
        Self {
            count: 0,
            lane: [0; PAIRS],
            patch: [0; PAIRS],
            rays: [[0.0; MAX_LANES]; 8],
            start: [0.0; PAIRS],
            length: [0.0; PAIRS],
            found: [false; PAIRS],
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
        (0..self.count).filter(|&n| self.found[n]).map(|n| PairHit {
            lane: self.lane[n].into(),
            patch: number_of(self.patch[n]),
            t: self.t[n],
            u: self.u[n],
            v: self.v[n],
            normal: vector(self.normal[0][n], self.normal[1][n], self.normal[2][n]),
        })
    }
}

impl KeptPatch<'_> {
    /// Whether a block takes the patch: it does where it is curved as asked for, without straight sides.
    /// Of one surface all that can be are laid out alike.
    pub fn fits_block(&self) -> bool {
        let flags = self.record().flags();
        self.record().kind() == PatchKind::Curved
            && flags.surface() != Surface::Angular
            && flags.bounds() == BoundsKind::Tight
            && !(flags.is_straight(0) | flags.is_straight(1) | flags.is_straight(2))
    }

    /// What it is laid out from in a block.
    #[inline(always)]
    fn source(&self) -> [f32; SOURCE] {
        let mut source = [0.0; SOURCE];
        let record = self.record();
        self.corners().write(&mut source[..VERTICES]);
        source[VERTICES..20].copy_from_slice(&record.slab);
        for (to, from) in source[20..29].chunks_exact_mut(3).zip(record.correction()) {
            to.copy_from_slice(&from);
        }
        source[29] = record.steepness.into();
        source
    }
}

impl Default for PatchBlock {
    fn default() -> Self {
        Self {
            laid: 0,
            any_obtuse: false,
            hulls: [[0.0; PATCHES]; HULL],
            patches: [[0.0; PATCHES]; PATCH],
        }
    }
}

impl PatchBlock {
    /// Takes all patches out.
    pub fn clear(&mut self) {
        (self.laid, self.any_obtuse) = (0, false);
    }

    /// The patches that are laid out, one bit each.
    pub fn laid(&self) -> u32 {
        self.laid
    }

    /// Lays out some patches, one bit each, that [fit](KeptPatch::fits_block) and are of one surface.
    pub fn lay<'a>(&mut self, which: u32, of: impl Fn(usize) -> KeptPatch<'a>) {
        self.lay_at(Level::new(), which, of);
    }

    /// The same with the instructions of one level.
    pub(super) fn lay_at<'a>(
        &mut self,
        level: Level,
        which: u32,
        of: impl Fn(usize) -> KeptPatch<'a>,
    ) {
        // All are read before anything is done with one: then the processor waits for them side by side.
        let mut all = [None; PATCHES];
        let mut left = which;
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            all[n] = Some(of(n));
            left &= left - 1;
        }
        let Some(first) = all.iter().flatten().next() else {
            return;
        };
        let flags = first.record().flags();
        // Something sound in the other lanes.
        let mut columns = [[0.0; PATCHES]; SOURCE];
        for (column, number) in columns.iter_mut().zip(first.source()) {
            *column = [number; PATCHES];
        }
        for (n, kept) in all.iter().enumerate() {
            let Some(kept) = kept else {
                continue;
            };
            debug_assert!(kept.fits_block());
            for (column, number) in columns.iter_mut().zip(kept.source()) {
                column[n] = number;
            }
        }
        dispatch!(level, simd => self.lay_columns(simd, which, flags, &columns));
    }

    #[inline(always)]
    fn lay_columns<S: Simd>(
        &mut self,
        simd: S,
        which: u32,
        flags: PatchFlags,
        columns: &[[f32; PATCHES]; SOURCE],
    ) {
        let number = inlined(
            #[inline(always)]
            |n: usize| Patches(f32x8::from_slice(simd, &columns[n])),
        );
        let [positions, normals] = vertices(simd, columns);
        let slab = [number(VERTICES), number(VERTICES + 1)];
        let frame = Frame::of_sound(&positions, &normals);
        let mut hull = Hull::around(&frame, &normals, Some(slab), None);
        let mut patch = Patch::laid(&frame, &normals, flags);
        for (k, side) in patch.sides.iter_mut().enumerate() {
            side.correction = three(
                #[inline(always)]
                |c| number(20 + 3 * k + c),
            );
        }
        patch.slab = slab;
        patch.steep = super::crossing::steep(number(29));
        let lanes = PatchMask(mask32x8::from_bitmask(simd, which.into()));
        hull.visit(&mut Store {
            columns: &mut self.hulls,
            lanes,
        });
        patch.visit(&mut Store {
            columns: &mut self.patches,
            lanes,
        });
        self.laid |= which;
        self.any_obtuse |= patch.any_obtuse;
    }

    /// The first hits with `tnear < t <= tfar` of the rays of `lanes` (one bit a lane) with each patch that
    /// is laid out, with the surface's normals there if `normals`.
    ///
    /// Every answer is bit for bit that of [`Patch::intersect`] and [`Patch::normal_at`] for the ray and
    /// the patch alone. Lanes that are not asked for may hold anything.
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
    pub(super) fn intersect_packet_at(
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
        (hits.count, hits.evaluations) = (0, 0);
        let width = rays.tnear.len();
        for first in (0..width).step_by(S::f32s::LEN) {
            let ray = load_ray(simd, rays, first);
            for (to, from) in hits.rays.iter_mut().zip(components(&ray)) {
                from.0.store_slice(&mut to[first..][..S::f32s::LEN]);
            }
            let there = u64::MAX >> (64 - (width - first));
            for (n, &lanes) in lanes.iter().enumerate() {
                let asked = u64::from(lanes >> first) & there;
                if asked == 0 || self.laid & 1 << n == 0 {
                    continue;
                }
                let valid = LaneMask(S::mask32s::from_bitmask(simd, asked));
                let interval = self.hull(n).clip(&ray, valid);
                let mut alive = interval.alive.0.to_bitmask();
                if alive == 0 {
                    continue;
                }
                let (mut start, mut length) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
                interval.start.0.store_slice(&mut start[..S::f32s::LEN]);
                interval.length.0.store_slice(&mut length[..S::f32s::LEN]);
                while alive != 0 {
                    let lane = alive.trailing_zeros() as usize;
                    alive &= alive - 1;
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
        hits.lane[hits.count..][..PATCHES].fill(0);
    }

    /// Finds the hits of the pairs, a register's lanes of them at a time.
    #[inline(always)]
    fn trace<S: Simd>(&self, simd: S, solver: Solver, normals: bool, hits: &mut PairHits) {
        for first in (0..hits.count).step_by(PATCHES) {
            let there = u64::MAX >> (64 - (hits.count - first).min(PATCHES));
            let (lane, number) = (
                &hits.lane[first..][..PATCHES],
                &hits.patch[first..][..PATCHES],
            );
            let ray = gather(simd, &hits.rays, lane);
            let patch = self.patches(simd, number);
            let load = inlined(
                #[inline(always)]
                |from: &[f32]| Patches(f32x8::from_slice(simd, &from[first..][..PATCHES])),
            );
            let interval = Interval {
                start: load(&hits.start),
                length: load(&hits.length),
                alive: PatchMask(mask32x8::from_bitmask(simd, there)),
            };
            let segment = Segment::new(&patch, &ray, &interval);
            let hit = patch.surface_hit(
                segment,
                solver,
                #[inline(always)]
                |segment| {
                    let few = segment.alive.count() < MIN_SEARCHED;
                    if few | (segment.alive & patch.is_high()).any() {
                        self.search_pairs(simd, &segment, number, solver)
                    } else {
                        patch.searched(segment, solver, &|_, _| None)
                    }
                },
            );
            hits.evaluations += hit.evaluations;
            let found = hit.found & ray.tnear.less(hit.t) & hit.t.at_most(ray.tfar);
            let found = found.0.to_bitmask();
            for (n, to) in hits.found[first..][..PATCHES].iter_mut().enumerate() {
                *to = found >> n & 1 != 0;
            }
            let store = inlined(
                #[inline(always)]
                |from: Patches<S>, to: &mut [f32]| from.0.store_slice(&mut to[first..][..PATCHES]),
            );
            store(hit.t, &mut hits.t);
            store(hit.u, &mut hits.u);
            store(hit.v, &mut hits.v);
            if normals && found != 0 {
                let normal = patch.normal_at(hit.u, hit.v);
                store(normal.x, &mut hits.normal[0]);
                store(normal.y, &mut hits.normal[1]);
                store(normal.z, &mut hits.normal[2]);
            }
        }
    }

    /// [`Patch::searched`] of the pairs that are alive, one by one: there are few.
    #[inline(always)]
    fn search_pairs<S: Simd>(
        &self,
        simd: S,
        segment: &Segment<Patches<S>>,
        patch: &[u32],
        solver: Solver,
    ) -> Hit<Patches<S>> {
        let mut columns = [[0.0; MAX_LANES]; SEGMENT_NUMBERS];
        for (column, number) in columns.iter_mut().zip(segment.numbers()) {
            number.0.store_slice(&mut column[..PATCHES]);
        }
        let alive = segment.alive.0.to_bitmask();
        let patch = |lane: usize| self.patch(number_of(patch[lane]));
        let searched = search_each(simd, &columns, alive, patch, solver);
        let load = inlined(
            #[inline(always)]
            |n: usize| Patches(f32x8::from_slice(simd, &searched.hits[n][..PATCHES])),
        );
        Hit {
            found: PatchMask(mask32x8::from_bitmask(simd, searched.found)),
            t: load(0),
            u: load(1),
            v: load(2),
            evaluations: searched.evaluations,
        }
    }

    /// What rays at one patch are clipped to.
    #[inline(always)]
    fn hull(&self, n: usize) -> Hull<f32> {
        let mut hull = Hull::empty(vector(0.0, 0.0, 0.0));
        hull.visit(&mut Column {
            columns: &self.hulls,
            n,
        });
        hull.exists = true;
        hull
    }

    /// One patch, without what rays are clipped to.
    fn patch(&self, n: usize) -> Patch<f32> {
        let mut patch = Patch::empty(vector(0.0, 0.0, 0.0));
        patch.visit(&mut Column {
            columns: &self.patches,
            n,
        });
        self.curved(patch)
    }

    /// One patch a lane.
    #[inline(always)]
    fn patches<S: Simd>(&self, simd: S, bytes: &[u32]) -> Patch<Patches<S>> {
        let zero = Patches(f32x8::splat(simd, 0.0));
        let mut patch = self.curved(Patch::empty(vector(zero, zero, zero)));
        patch.visit(&mut Pick {
            columns: &self.patches,
            bytes: u32x8::from_slice(simd, bytes).to_bytes(),
        });
        patch
    }

    /// What is the same of all patches of a block.
    #[inline(always)]
    fn curved<S: Constant>(&self, patch: Patch<S>) -> Patch<S> {
        Patch {
            rule: Rule::Tensor,
            kind: PatchKind::Curved,
            any_obtuse: self.any_obtuse,
            ..patch
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
fn gather<S: Simd>(simd: S, rays: &[[f32; MAX_LANES]; 8], lanes: &[u8]) -> Ray<Patches<S>> {
    let number = inlined(
        #[inline(always)]
        |component: usize| {
            let mut column = [0.0; PATCHES];
            for (to, &lane) in column.iter_mut().zip(lanes) {
                *to = rays[component][usize::from(lane) % MAX_LANES];
            }
            Patches(f32x8::from_slice(simd, &column))
        },
    );
    Ray {
        origin: vector(number(0), number(1), number(2)),
        direction: vector(number(3), number(4), number(5)),
        tnear: number(6),
        tfar: number(7),
    }
}

/// A ray's numbers.
#[inline(always)]
fn components<V: Copy>(ray: &Ray<V>) -> [V; 8] {
    let (o, d) = (ray.origin, ray.direction);
    [o.x, o.y, o.z, d.x, d.y, d.z, ray.tnear, ray.tfar]
}
