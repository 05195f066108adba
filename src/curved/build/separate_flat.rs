//! Which flat triangles are left to a geometry of Embree's own triangles, and whether that pays.

use super::kinds::Kinds;
use crate::curved::options::FlatTriangles;
use crate::embree::Bounds;
use curvetri_method::{FlatReason, PackedPatch, PatchKind};

/// A second tree pays where one in so many triangles is flat: every ray goes through it as well.
/// Where one in two is flat, all kinds of rays gain, those from a camera threefold. Where one in five is,
/// those and diffuse ones gain a tenth, but bounces lose more.
const LEAST_SHARE: usize = 3;

/// Whether the flat triangles of a mesh with these kinds are left to a second geometry.
pub(super) fn pays(flat: FlatTriangles, kinds: &Kinds) -> bool {
    let count = kinds.near_plane();
    flat == FlatTriangles::Separate && count > 0 && count * LEAST_SHARE >= kinds.total()
}

/// Whether a triangle may be left to a second geometry: its surface is its plane or near it.
///
/// A triangle that is flat because the method cannot take it may not. Its neighbours are the wildest of
/// patches, and where a flat triangle ends sharp, as Embree's do, neither might find a ray through the
/// shared edge.
pub(in crate::curved) fn may_be_separate(record: &PackedPatch) -> bool {
    matches!(
        record.kind(),
        PatchKind::Flat(FlatReason::Plane | FlatReason::Requested)
    )
}

/// Gives the triangles that are left to a second geometry empty boxes: no ray is tested against them then.
pub(super) fn leave_out(records: &[PackedPatch], bounds: &mut [Bounds]) {
    for (bounds, record) in bounds.iter_mut().zip(records) {
        if may_be_separate(record) {
            *bounds = Bounds::EMPTY;
        }
    }
}
