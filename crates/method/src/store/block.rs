//! Several patches unpacked side by side, for the rays that may hit any of them.

use fearless_simd::{Level, dispatch, f32x8, mask32x8, prelude::*};

use super::columns::{Columns, in_columns, load_lanes, load_one, pick_lanes, store_lanes};
use super::packed_triangle::{PackedTriangle, VerticesAndSlab};
use crate::numbers::{
    Constant, Cursor, Fields, MAX_LANES, PATCHES, PairLanes, PatchMask, Patches, Real, to_array,
    vector,
};
use crate::patch::{
    BoundsKind, ClipVolume, Patch, PatchFlags, PatchKind, Rule, Surface, TriangleFrame,
};

/// How many numbers a patch is unpacked from.
const SOURCE: usize = Source::<f32>::COUNT;
/// How many numbers a clip volume is stored in.
const CLIP_VOLUME: usize = ClipVolume::<f32>::COUNT;
/// How many numbers a patch is stored in.
const PATCH: usize = Patch::<f32>::COUNT;

/// Up to eight patches, unpacked for rays.
///
/// ```
/// use curvetri_method::{
///     BuiltPatch, PackedTriangle, PairHits, PatchBlock, PatchFlags, RayLanes, Solver,
///     TriangleVertices, vector,
/// };
///
/// let c = 1.0 / 3f32.sqrt();
/// let positions = [vector(c, c, c), vector(c, -c, -c), vector(-c, c, -c)];
/// let vertices = TriangleVertices { positions, normals: positions };
/// let built = BuiltPatch::new(&vertices, PatchFlags::default());
/// let mut triangles = [None; 8];
/// triangles[3] = Some(PackedTriangle::new(vertices, &built.packed));
/// let mut block = PatchBlock::default();
/// block.unpack(&triangles);
/// assert_eq!(block.unpacked(), 1 << 3);
///
/// // Two rays; the second runs the other way.
/// let rays = RayLanes {
///     origin: [&[5.0 * c; 2], &[5.0 * c; 2], &[-5.0 * c; 2]],
///     direction: [&[-c, c], &[-c, c], &[c, -c]],
///     tnear: &[0.0; 2],
///     tfar: &[f32::INFINITY; 2],
/// };
/// let mut hits = PairHits::default();
/// block.intersect_packet(&rays, &[0b11; 8], Solver::default(), true, &mut hits);
/// let hit = hits.iter().next().expect("the first ray hits");
/// assert_eq!((hit.lane, hit.patch), (0, 3));
/// assert_eq!(hits.iter().count(), 1);
/// ```
#[derive(Clone, Debug)]
pub struct PatchBlock {
    /// Which ones are, one bit each.
    unpacked: u32,
    any_obtuse: bool,
    /// A number of each patch: [`ClipVolume`].
    clip_volumes: Columns<CLIP_VOLUME>,
    /// A number of each patch: [`Patch`].
    patches: Columns<PATCH>,
}

impl PackedTriangle<'_> {
    /// Whether a block takes the patch: it does where it is curved by the requested surface, without straight edges.
    /// All patches of a block are of one surface.
    pub fn fits_block(&self) -> bool {
        let flags = self.packed().flags();
        self.packed().kind() == PatchKind::Curved
            && flags.surface() != Surface::Angular
            && flags.bounds() == BoundsKind::Tight
            && !(flags.is_straight(0) | flags.is_straight(1) | flags.is_straight(2))
    }

    /// What it is unpacked from in a block.
    #[inline(always)]
    fn source(&self) -> [f32; SOURCE] {
        let packed = self.packed();
        let source = Source {
            outline: VerticesAndSlab {
                vertices: *self.vertices(),
                slab: packed.slab,
            },
            correction: packed.correction(),
            unevenness: packed.unevenness(),
        };
        to_array(source, 0.0)
    }
}

/// What patches are unpacked from.
#[derive(Clone, Copy)]
struct Source<V> {
    outline: VerticesAndSlab<V>,
    correction: [[V; 3]; 3],
    unevenness: V,
}

impl<V: Real> Fields<V> for Source<V> {
    const COUNT: usize = VerticesAndSlab::<V>::COUNT + 9 + 1;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<V>) {
        self.outline.visit(cursor);
        let [a, b, c] = &mut self.correction;
        for edge in [a, b, c] {
            cursor.number(&mut edge[0]);
            cursor.number(&mut edge[1]);
            cursor.number(&mut edge[2]);
        }
        cursor.number(&mut self.unevenness);
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

    /// The patches that are unpacked, one bit each.
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
        columns: &Columns<SOURCE>,
    ) {
        let zero = Patches(f32x8::splat(simd, 0.0));
        let blank = Source {
            outline: VerticesAndSlab::blank(zero),
            correction: [[zero; 3]; 3],
            unevenness: zero,
        };
        let source = load_lanes(simd, columns, blank);
        let VerticesAndSlab { vertices, slab } = source.outline;
        let frame = TriangleFrame::of_sound(&vertices.positions, &vertices.normals);
        let clip_volume = ClipVolume::around(&frame, &vertices.normals, Some(slab), None);
        let mut patch = Patch::from_frame(&frame, &vertices.normals, flags);
        for (edge, correction) in patch.edges.iter_mut().zip(source.correction) {
            edge.correction = correction;
        }
        patch.slab = slab;
        patch.unevenness = source.unevenness;
        let lanes = PatchMask(mask32x8::from_bitmask(simd, places.into()));
        store_lanes(clip_volume, &mut self.clip_volumes, lanes);
        store_lanes(patch, &mut self.patches, lanes);
        self.unpacked |= places;
        self.any_obtuse |= patch.any_obtuse;
    }

    /// What rays at one patch are clipped to.
    #[inline(always)]
    pub(crate) fn clip_volume(&self, n: usize) -> ClipVolume<f32> {
        let blank = ClipVolume::empty(vector(0.0, 0.0, 0.0));
        ClipVolume {
            exists: true,
            ..load_one(&self.clip_volumes, n, blank)
        }
    }

    /// One patch, without what rays are clipped to.
    pub(crate) fn patch(&self, n: usize) -> Patch<f32> {
        let blank = Patch::empty(vector(0.0, 0.0, 0.0));
        self.curved(load_one(&self.patches, n, blank))
    }

    /// One patch a lane.
    #[inline(always)]
    pub(crate) fn patches<S: Simd, P: PairLanes<S>>(&self, simd: S, bytes: &[u32]) -> Patch<P> {
        let zero = P::load(simd, &[0.0; MAX_LANES]);
        let blank = self.curved(Patch::empty(vector(zero, zero, zero)));
        let places = P::places(simd, bytes);
        pick_lanes::<S, P, _, PATCH>(simd, &self.patches, places, blank)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::assert_counted;

    #[test]
    fn structs_show_as_many_numbers_as_they_say() {
        assert_counted(Patch::empty(vector(0.0f32, 0.0, 0.0)));
        assert_counted(ClipVolume::empty(vector(0.0f32, 0.0, 0.0)));
        assert_counted(Source {
            outline: VerticesAndSlab::blank(0.0),
            correction: [[0.0; 3]; 3],
            unevenness: 0.0,
        });
    }
}
