//! The part of a patch that tells most rays that they miss it.

use super::packed_patch::PackedPatch;
use crate::numbers::{Real, Scalar, Vector};
use crate::patch::{BoundsKind, ClipVolume, Patch, PatchKind, Rule, Sphere, TriangleFrame};

/// A patch's edge planes and slab: what tells most rays that they miss, for a small part of what the
/// whole patch costs.
#[derive(Clone, Copy, Debug)]
pub struct Outline<'a, S: Real> {
    pub(crate) frame: Option<TriangleFrame<S>>,
    pub(crate) clip_volume: ClipVolume<S>,
    origin: Vector<S>,
    normals: [Vector<S>; 3],
    packed: &'a PackedPatch,
}

impl<'a, S: Scalar> Outline<'a, S> {
    /// The outline of the patch of these vertices, from what [`Patch::pack`] kept of it.
    #[inline(always)]
    pub fn new(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        packed: &'a PackedPatch,
    ) -> Self {
        let frame = TriangleFrame::new(&positions, &normals);
        let hull = match &frame {
            Some(frame) => {
                let slab = packed.slab();
                let round = packed.flags().bounds() == BoundsKind::Sphere && slab.is_some();
                let sphere = round.then(|| Sphere::unpacked(frame, packed.enlargement));
                ClipVolume::new(frame, &normals, slab, sphere)
            }
            None => ClipVolume::empty(positions[0]),
        };
        Self {
            frame,
            clip_volume: hull,
            origin: positions[0],
            normals,
            packed,
        }
    }

    /// The same as [`Patch::sphere`].
    pub fn sphere(&self) -> Option<&Sphere<S>> {
        self.clip_volume.sphere.as_ref()
    }

    /// The patch's unit of length.
    pub(crate) fn size(&self) -> S {
        self.frame.as_ref().map_or(S::from_f64(1.0), |f| f.size)
    }

    /// The whole patch.
    #[inline(always)]
    pub fn complete(&self) -> Patch<S> {
        Patch {
            clip_volume: self.clip_volume,
            ..self.surface()
        }
    }

    /// The patch without what rays are clipped to.
    #[inline(always)]
    pub(crate) fn surface(&self) -> Patch<S> {
        match &self.frame {
            Some(frame) => surface(frame, &self.normals, self.packed),
            None => Patch::empty(self.origin),
        }
    }
}

/// The patch of a frame without what rays are clipped to.
#[inline(always)]
pub(crate) fn surface<S: Scalar>(
    frame: &TriangleFrame<S>,
    normals: &[Vector<S>; 3],
    packed: &PackedPatch,
) -> Patch<S> {
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
    patch.unevenness = S::from_f64(packed.unevenness().into());
    if patch.rule == Rule::Angular {
        patch.set_angles();
    }
    for (edge, kept) in patch.edges.iter_mut().zip(packed.correction()) {
        edge.correction = kept;
    }
    patch
}

impl<S: Scalar> Patch<S> {
    /// The patch of these vertices, from what [`Patch::pack`] kept of it.
    pub fn unpack(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        packed: &PackedPatch,
    ) -> Self {
        Outline::new(positions, normals, packed).complete()
    }
}
