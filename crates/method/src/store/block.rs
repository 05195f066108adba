//! Several patches laid out side by side, for the rays that come by any of them.

use fearless_simd::{Level, dispatch, f32x8, mask32x8, prelude::*};

use super::columns::{CLIP_VOLUME, Column, PATCH, Pick, Store, in_columns, vertices};
use super::packed_triangle::PackedTriangle;
use crate::numbers::{
    Constant, MAX_LANES, PATCHES, PairLanes, PatchMask, Patches, inlined, three, vector,
};
use crate::patch::{
    BoundsKind, ClipVolume, Patch, PatchFlags, PatchKind, Rule, Surface, TriangleFrame, VERTICES,
};

/// How many numbers a patch is laid out from.
const SOURCE: usize = 30;

/// Up to eight patches, laid out for rays.
#[derive(Clone, Debug)]
pub struct PatchBlock {
    /// Which ones are, one bit each.
    unpacked: u32,
    any_obtuse: bool,
    /// A number of each patch: [`ClipVolume::visit`].
    clip_volumes: [[f32; PATCHES]; CLIP_VOLUME],
    /// A number of each patch: [`Patch::visit`].
    patches: [[f32; PATCHES]; PATCH],
}

impl PackedTriangle<'_> {
    /// Whether a block takes the patch: it does where it is curved as asked for, without straight edges.
    /// Of one surface all that can be are laid out alike.
    pub fn fits_block(&self) -> bool {
        let flags = self.packed().flags();
        self.packed().kind() == PatchKind::Curved
            && flags.surface() != Surface::Angular
            && flags.bounds() == BoundsKind::Tight
            && !(flags.is_straight(0) | flags.is_straight(1) | flags.is_straight(2))
    }

    /// What it is laid out from in a block.
    #[inline(always)]
    fn source(&self) -> [f32; SOURCE] {
        let mut source = [0.0; SOURCE];
        let packed = self.packed();
        self.vertices().write(&mut source[..VERTICES]);
        source[VERTICES..20].copy_from_slice(&packed.slab);
        for (to, from) in source[20..29].chunks_exact_mut(3).zip(packed.correction()) {
            to.copy_from_slice(&from);
        }
        source[29] = packed.unevenness();
        source
    }
}

impl Default for PatchBlock {
    fn default() -> Self {
        Self {
            unpacked: 0,
            any_obtuse: false,
            clip_volumes: [[0.0; PATCHES]; CLIP_VOLUME],
            patches: [[0.0; PATCHES]; PATCH],
        }
    }
}

impl PatchBlock {
    /// Takes all patches out.
    pub fn clear(&mut self) {
        (self.unpacked, self.any_obtuse) = (0, false);
    }

    /// The patches that are laid out, one bit each.
    pub fn unpacked(&self) -> u32 {
        self.unpacked
    }

    /// Unpacks triangles, each into its place; those that are given all [fit](PackedTriangle::fits_block) and
    /// are of one surface.
    pub fn unpack(&mut self, triangles: &[Option<PackedTriangle<'_>>; PATCHES]) {
        self.unpack_at(Level::new(), triangles);
    }

    /// The same with the instructions of one level.
    pub(crate) fn unpack_at(
        &mut self,
        level: Level,
        triangles: &[Option<PackedTriangle<'_>>; PATCHES],
    ) {
        let Some(first) = triangles.iter().flatten().next() else {
            return;
        };
        let flags = first.packed().flags();
        debug_assert!(triangles.iter().flatten().all(PackedTriangle::fits_block));
        // Something sound in the other lanes.
        let columns = in_columns(
            #[inline(always)]
            |n| triangles[n].as_ref().unwrap_or(first).source(),
        );
        let places = (triangles.iter().enumerate()).fold(0, |places, (n, triangle)| {
            places | u32::from(triangle.is_some()) << n
        });
        dispatch!(level, simd => self.unpack_columns(simd, places, flags, &columns));
    }

    #[inline(always)]
    fn unpack_columns<S: Simd>(
        &mut self,
        simd: S,
        places: u32,
        flags: PatchFlags,
        columns: &[[f32; PATCHES]; SOURCE],
    ) {
        let number = inlined(
            #[inline(always)]
            |n: usize| Patches(f32x8::from_slice(simd, &columns[n])),
        );
        let [positions, normals] = vertices(simd, columns);
        let slab = [number(VERTICES), number(VERTICES + 1)];
        let frame = TriangleFrame::of_sound(&positions, &normals);
        let mut hull = ClipVolume::around(&frame, &normals, Some(slab), None);
        let mut patch = Patch::from_frame(&frame, &normals, flags);
        for (k, edge) in patch.edges.iter_mut().enumerate() {
            edge.correction = three(
                #[inline(always)]
                |c| number(20 + 3 * k + c),
            );
        }
        patch.slab = slab;
        patch.unevenness = number(29);
        let lanes = PatchMask(mask32x8::from_bitmask(simd, places.into()));
        hull.visit(&mut Store {
            columns: &mut self.clip_volumes,
            lanes,
        });
        patch.visit(&mut Store {
            columns: &mut self.patches,
            lanes,
        });
        self.unpacked |= places;
        self.any_obtuse |= patch.any_obtuse;
    }

    /// What rays at one patch are clipped to.
    #[inline(always)]
    pub(crate) fn hull(&self, n: usize) -> ClipVolume<f32> {
        let mut hull = ClipVolume::empty(vector(0.0, 0.0, 0.0));
        hull.visit(&mut Column {
            columns: &self.clip_volumes,
            n,
        });
        hull.exists = true;
        hull
    }

    /// One patch, without what rays are clipped to.
    pub(crate) fn patch(&self, n: usize) -> Patch<f32> {
        let mut patch = Patch::empty(vector(0.0, 0.0, 0.0));
        patch.visit(&mut Column {
            columns: &self.patches,
            n,
        });
        self.curved(patch)
    }

    /// One patch a lane.
    #[inline(always)]
    pub(crate) fn patches<S: Simd, P: PairLanes<S>>(&self, simd: S, bytes: &[u32]) -> Patch<P> {
        let zero = P::load(simd, &[0.0; MAX_LANES]);
        let mut patch = self.curved(Patch::empty(vector(zero, zero, zero)));
        patch.visit(&mut Pick::<S, P, PATCH> {
            columns: &self.patches,
            simd,
            places: P::places(simd, bytes),
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
