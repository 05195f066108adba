//! How many of a mesh's triangles turned out to be what.

use std::ops::Add;

use curvetri_method::{FlatReason, PatchKind};

/// Triangles by kind.
///
/// ```
/// use curvetri::curved::Kinds;
///
/// let kinds = Kinds { curved: 5, flat_plane: 2, degenerate: 1, ..Kinds::default() };
/// assert_eq!((kinds.flat(), kinds.total()), (2, 8));
/// assert_eq!(kinds.named()[0], ("curved", 5));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kinds {
    /// Curved by the requested surface.
    pub curved: usize,
    /// Curved by the angular rule, the curvature tensor being too wild.
    pub fallback: usize,
    /// Flat because their surface lies in their plane anyway, to within rounding.
    pub flat_plane: usize,
    /// Flat because that is within the [tolerance](crate::curved::CurvedOptions::tolerance), or because all are.
    pub flat_tolerance: usize,
    /// Flat because too thin for a certain plane.
    pub flat_sliver: usize,
    /// Flat because a vertex normal points away from the triangle's front, or nearly so.
    pub flat_back_normal: usize,
    /// Flat because the normals bend too much.
    pub flat_bend: usize,
    /// Flat because the guide field would fold.
    pub flat_fold: usize,
    /// Without area: no ray hits them.
    pub degenerate: usize,
}

impl Kinds {
    /// One triangle of this kind.
    pub(super) fn of(kind: PatchKind) -> Self {
        let mut kinds = Self::default();
        *match kind {
            PatchKind::Curved => &mut kinds.curved,
            PatchKind::Fallback => &mut kinds.fallback,
            PatchKind::Flat(FlatReason::Plane) => &mut kinds.flat_plane,
            PatchKind::Flat(FlatReason::Requested) => &mut kinds.flat_tolerance,
            PatchKind::Flat(FlatReason::Sliver) => &mut kinds.flat_sliver,
            PatchKind::Flat(FlatReason::BackNormal) => &mut kinds.flat_back_normal,
            PatchKind::Flat(FlatReason::Bend) => &mut kinds.flat_bend,
            PatchKind::Flat(FlatReason::Fold) => &mut kinds.flat_fold,
            PatchKind::Degenerate => &mut kinds.degenerate,
        } = 1;
        kinds
    }

    /// The counts with their names, in the order they are reported.
    pub fn named(&self) -> [(&'static str, usize); 9] {
        [
            ("curved", self.curved),
            ("fallback", self.fallback),
            ("flat_plane", self.flat_plane),
            ("flat_tolerance", self.flat_tolerance),
            ("flat_sliver", self.flat_sliver),
            ("flat_back_normal", self.flat_back_normal),
            ("flat_bend", self.flat_bend),
            ("flat_fold", self.flat_fold),
            ("degenerate", self.degenerate),
        ]
    }

    /// Triangles that stay flat, whatever the reason, without the degenerate ones.
    pub fn flat(&self) -> usize {
        self.total() - self.curved - self.fallback - self.degenerate
    }

    /// Triangles that stay flat because their surface is their plane or within the tolerance of it.
    pub(in crate::curved) fn near_plane(&self) -> usize {
        self.flat_plane + self.flat_tolerance
    }

    /// All triangles.
    pub fn total(&self) -> usize {
        self.named().iter().map(|(_, count)| count).sum()
    }
}

impl Add for Kinds {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            curved: self.curved + other.curved,
            fallback: self.fallback + other.fallback,
            flat_plane: self.flat_plane + other.flat_plane,
            flat_tolerance: self.flat_tolerance + other.flat_tolerance,
            flat_sliver: self.flat_sliver + other.flat_sliver,
            flat_back_normal: self.flat_back_normal + other.flat_back_normal,
            flat_bend: self.flat_bend + other.flat_bend,
            flat_fold: self.flat_fold + other.flat_fold,
            degenerate: self.degenerate + other.degenerate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_counted_once() {
        let kinds = [
            PatchKind::Curved,
            PatchKind::Fallback,
            PatchKind::Flat(FlatReason::Plane),
            PatchKind::Flat(FlatReason::Requested),
            PatchKind::Flat(FlatReason::Sliver),
            PatchKind::Flat(FlatReason::BackNormal),
            PatchKind::Flat(FlatReason::Bend),
            PatchKind::Flat(FlatReason::Fold),
            PatchKind::Degenerate,
        ];
        let sum = kinds
            .into_iter()
            .map(Kinds::of)
            .fold(Kinds::default(), Kinds::add);
        assert!(sum.named().iter().all(|&(_, count)| count == 1), "{sum:?}");
        assert_eq!((sum.total(), sum.flat()), (9, 6));
    }
}
