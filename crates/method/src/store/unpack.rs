//! From a packed triangle back to a patch: bit for bit the one that was packed.

use fearless_simd::{Level, dispatch, prelude::*};

use super::packed_patch::PackedPatch;
use super::packed_triangle::PackedTriangle;
use crate::numbers::Vector;
use crate::patch::{
    BoundsKind, ClipVolume, Patch, PatchKind, Rule, Sphere, TriangleFrame, TriangleVertices,
};

impl PackedTriangle<'_> {
    /// The patch, bit for bit the one that was [packed](Patch::pack).
    pub fn unpack(&self) -> Patch<f32> {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let frame = self.frame();
                Patch {
                    clip_volume: self.clip_volume(frame.as_ref()),
                    ..self.unpack_surface(frame.as_ref())
                }
            }
        ))
    }

    /// The same as [`Patch::sphere`].
    pub fn sphere(&self) -> Option<Sphere<f32>> {
        self.clip_volume(self.frame().as_ref()).sphere
    }

    /// The triangle's frame; none if it has no area.
    #[inline(always)]
    pub(crate) fn frame(&self) -> Option<TriangleFrame<f32>> {
        let TriangleVertices { positions, normals } = self.vertices();
        TriangleFrame::new(positions, normals)
    }

    /// What rays are clipped to: all that most of them need, for a small part of what the whole patch costs.
    #[inline(always)]
    pub(crate) fn clip_volume(&self, frame: Option<&TriangleFrame<f32>>) -> ClipVolume<f32> {
        let TriangleVertices { positions, normals } = self.vertices();
        let Some(frame) = frame else {
            return ClipVolume::empty(positions[0]);
        };
        let slab = self.packed().slab();
        let round = self.packed().flags().bounds() == BoundsKind::Sphere && slab.is_some();
        let sphere = round.then(|| Sphere::unpacked(frame, self.packed().enlargement));
        ClipVolume::new(frame, normals, slab, sphere)
    }

    /// The patch without what rays are clipped to.
    #[inline(always)]
    pub(crate) fn unpack_surface(&self, frame: Option<&TriangleFrame<f32>>) -> Patch<f32> {
        let TriangleVertices { positions, normals } = self.vertices();
        let packed = self.packed();
        let Some(frame) = frame else {
            return Patch::empty(positions[0]);
        };
        let mut patch = Patch::from_frame(frame, normals, packed.flags());
        patch.kind = packed.kind();
        match patch.kind {
            PatchKind::Curved | PatchKind::Degenerate => {}
            PatchKind::Fallback => patch.rule = Rule::Angular,
            PatchKind::Flat(reason) => patch.flatten(reason),
        }
        let Some(slab) = packed.slab() else {
            return patch;
        };
        patch.slab = slab;
        patch.unevenness = packed.unevenness();
        if patch.rule == Rule::Angular {
            patch.set_angles();
        }
        for (edge, correction) in patch.edges.iter_mut().zip(packed.correction()) {
            edge.correction = correction;
        }
        patch
    }
}

impl Patch<f32> {
    /// The patch over these vertices that [`Patch::pack`] packed.
    pub fn unpack(
        positions: [Vector<f32>; 3],
        normals: [Vector<f32>; 3],
        packed: &PackedPatch,
    ) -> Self {
        PackedTriangle::new(TriangleVertices { positions, normals }, packed).unpack()
    }
}
