//! Triangles that are made flat because their surface hardly leaves their plane.

use crate::curved::triangle::vertices;
use crate::mesh::Mesh;
use curvetri_method::BuiltPatch;

/// A surface with a slab no higher than this, in units of the patch's size, is its plane but for rounding:
/// 8 epsilons, and the 32 that every slab has as tolerance.
const PLANE_HEIGHT: f32 = 40.0 * f32::EPSILON;

/// The patch made flat where its surface is its plane but for rounding, or within the tolerance of it.
pub(super) fn flattened(
    patch: BuiltPatch,
    mesh: &Mesh,
    triangle: usize,
    tolerance: f32,
) -> BuiltPatch {
    let Some(height) = patch.greatest_height() else {
        return patch;
    };
    let flags = patch.packed.flags();
    if height <= PLANE_HEIGHT {
        return BuiltPatch::new(&vertices(mesh, triangle), flags.with_plane());
    }
    if tolerance > 0.0 {
        let corners = vertices(mesh, triangle);
        if height * corners.size() <= tolerance {
            return BuiltPatch::new(&corners, flags.with_flat());
        }
    }
    patch
}
