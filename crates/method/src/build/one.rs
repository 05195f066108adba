//! One curved triangle: everything about it that does not depend on the ray.
//!
//! All lengths inside a patch are in units of its `size`, a power of two, with the first vertex as
//! the origin. Scaling by a power of two is exact, so what belongs to an edge comes out bit-equal
//! in both triangles that share it.

use super::correction::fit;
use super::validity::{folds, shears};
use crate::bounds::{HeightNet, height_intervals};
use crate::numbers::{Constant, Scalar, Vector};
use crate::patch::{
    BoundsKind, ClipVolume, FlatReason, Patch, PatchFlags, PatchKind, Rule, SLIVER_AREA, Sphere,
    Surface, TriangleFrame,
};
use crate::store::{PackedPatch, pack_unevenness, unpack_unevenness};

impl<S: Scalar> Patch<S> {
    /// The packed patch and its box.
    pub(crate) fn built(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        flags: PatchFlags,
    ) -> (PackedPatch, [Vector<S>; 2]) {
        let (patch, net) = Self::with_net(positions, normals, flags);
        (patch.pack(flags), patch.bounds_by(net.as_ref()))
    }

    /// The patch and what bounds its heights, unless it is flat.
    pub(crate) fn with_net(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        flags: PatchFlags,
    ) -> (Self, Option<HeightNet<S>>) {
        let Some(frame) = TriangleFrame::new(&positions, &normals) else {
            return (Self::empty(positions[0]), None);
        };
        let mut patch = Self::from_frame(&frame, &normals, flags);
        let mut sphere = None;
        let net = match patch.curve(&normals, flags) {
            Ok(net) => {
                if flags.bounds() == BoundsKind::Sphere {
                    sphere = Some(Sphere::around(&frame, &patch, &net));
                }
                patch.slab = net.slab();
                if !flags.is_unchecked() {
                    let packed = pack_unevenness(patch.unevenness(&normals));
                    patch.unevenness = S::from_f64(unpack_unevenness(packed).into());
                }
                Some(net)
            }
            Err(reason) => {
                patch.flatten(reason);
                None
            }
        };
        patch.clip_volume = ClipVolume::new(&frame, &normals, patch.curved_slab(), sphere);
        (patch, net)
    }

    /// Why the triangle has to be flat whatever it would be curved to.
    fn flat_reason(&self, normals: &[Vector<S>; 3], flags: PatchFlags) -> Option<FlatReason> {
        if flags.is_plane() {
            Some(FlatReason::Plane)
        } else if flags.is_flat() {
            Some(FlatReason::Requested)
        } else if self.area2 < S::from_f64(SLIVER_AREA) {
            Some(FlatReason::Sliver)
        } else if !self.agrees(normals) {
            Some(FlatReason::BackNormal)
        } else {
            None
        }
    }

    /// Chooses the rule, adds the correction, and bounds the heights.
    fn curve(
        &mut self,
        normals: &[Vector<S>; 3],
        flags: PatchFlags,
    ) -> Result<HeightNet<S>, FlatReason> {
        if let Some(reason) = self.flat_reason(normals, flags) {
            return Err(reason);
        }
        if self.rule == Rule::Angular {
            self.set_angles();
        }
        let mut checks = self.look();
        if !flags.is_unchecked() {
            if self.rule == Rule::Tensor && !(checks.tame & checks.low) {
                self.rule = Rule::Angular;
                self.kind = PatchKind::Fallback;
                self.set_angles();
                checks = self.look();
            }
            if !(checks.reaches & checks.low) || shears(self) {
                return Err(FlatReason::Bend);
            }
            if folds(self) {
                return Err(FlatReason::Fold);
            }
        }
        if flags.surface() == Surface::Smooth {
            self.correct(flags);
        }
        Ok(checks.net.corrected(self))
    }

    /// As [`Patch::checks`]; called in two places, but compiled once.
    #[inline(never)]
    fn look(&self) -> SurfaceChecks<S> {
        self.checks()
    }
}

impl<S: Constant> Patch<S> {
    /// What the bounds say of the surface by the present rule.
    #[inline(always)]
    pub(crate) fn checks(&self) -> SurfaceChecks<S> {
        let intervals = height_intervals(self);
        let net = HeightNet::new(self, &intervals);
        SurfaceChecks {
            tame: intervals.is_tame(),
            reaches: intervals.reaches(),
            low: net.is_low(self),
            net,
        }
    }

    /// Adds the correction.
    #[inline(always)]
    pub(crate) fn correct(&mut self, flags: PatchFlags) {
        fit(self, flags);
        self.round_correction();
    }
}

/// What bounds say of a surface.
pub(crate) struct SurfaceChecks<S: Constant> {
    /// Whether the curvature tensor may be used.
    pub tame: S::Mask,
    /// Whether every guide meets every sphere.
    pub reaches: S::Mask,
    /// Whether it stays near to the triangle.
    pub low: S::Mask,
    /// The heights, without the correction.
    pub net: HeightNet<S>,
}
