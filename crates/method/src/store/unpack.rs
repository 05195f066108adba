//! The part of a patch that tells most rays that they miss it.

use super::packed_patch::PatchRecord;
use crate::numbers::{Real, Scalar, Vector};
use crate::patch::{BoundsKind, Frame, Hull, Patch, PatchKind, Rule, Sphere};

/// A patch's side planes and slab: what tells most rays that they miss, for a small part of what the
/// whole patch costs.
#[derive(Clone, Copy, Debug)]
pub struct Outline<'a, S: Real> {
    pub(crate) frame: Option<Frame<S>>,
    pub(crate) hull: Hull<S>,
    origin: Vector<S>,
    normals: [Vector<S>; 3],
    record: &'a PatchRecord,
}

impl<'a, S: Scalar> Outline<'a, S> {
    /// The outline of the patch of these vertices, from what [`Patch::record`] kept of it.
    #[inline(always)]
    pub fn new(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        record: &'a PatchRecord,
    ) -> Self {
        let frame = Frame::new(&positions, &normals);
        let hull = match &frame {
            Some(frame) => {
                let slab = record.slab();
                let round = record.flags().bounds() == BoundsKind::Sphere && slab.is_some();
                let sphere = round.then(|| Sphere::of_record(frame, record.enlargement));
                Hull::new(frame, &normals, slab, sphere)
            }
            None => Hull::empty(positions[0]),
        };
        Self {
            frame,
            hull,
            origin: positions[0],
            normals,
            record,
        }
    }

    /// The same as [`Patch::sphere`].
    pub fn sphere(&self) -> Option<&Sphere<S>> {
        self.hull.sphere.as_ref()
    }

    /// The patch's unit of length.
    pub(crate) fn size(&self) -> S {
        self.frame.as_ref().map_or(S::from_f64(1.0), |f| f.size)
    }

    /// The whole patch.
    #[inline(always)]
    pub fn complete(&self) -> Patch<S> {
        Patch {
            hull: self.hull,
            ..self.surface()
        }
    }

    /// The patch without what rays are clipped to.
    #[inline(always)]
    pub(crate) fn surface(&self) -> Patch<S> {
        match &self.frame {
            Some(frame) => surface(frame, &self.normals, self.record),
            None => Patch::empty(self.origin),
        }
    }
}

/// The patch of a frame without what rays are clipped to.
#[inline(always)]
pub(crate) fn surface<S: Scalar>(
    frame: &Frame<S>,
    normals: &[Vector<S>; 3],
    record: &PatchRecord,
) -> Patch<S> {
    let mut patch = Patch::laid(frame, normals, record.flags());
    patch.kind = record.kind();
    match patch.kind {
        PatchKind::Curved | PatchKind::Degenerate => {}
        PatchKind::Fallback => patch.rule = Rule::Angular,
        PatchKind::Flat(reason) => patch.flatten(reason),
    }
    let Some(slab) = record.slab() else {
        return patch;
    };
    patch.slab = slab;
    patch.unevenness = S::from_f64(record.unevenness().into());
    if patch.rule == Rule::Angular {
        patch.set_angles();
    }
    for (side, kept) in patch.sides.iter_mut().zip(record.correction()) {
        side.correction = kept;
    }
    patch
}

impl<S: Scalar> Patch<S> {
    /// The patch of these vertices, from what [`Patch::record`] kept of it.
    pub fn from_record(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        record: &PatchRecord,
    ) -> Self {
        Outline::new(positions, normals, record).complete()
    }
}
