//! One triangle of a mesh as the kernel takes it.

use crate::mesh::Mesh;
use curvetri_method::{PackedPatch, PackedTriangle, PatchKind, TriangleVertices};

/// A triangle's positions and normals.
#[inline(always)]
pub(super) fn vertices(mesh: &Mesh, triangle: usize) -> TriangleVertices {
    let [a, b, c] = mesh.triangle_positions(triangle);
    let [k, m, n] = mesh.triangle_normals(triangle);
    TriangleVertices {
        positions: [a.into(), b.into(), c.into()],
        normals: [k.into(), m.into(), n.into()],
    }
}

/// A triangle's packed patch: its vertices and the record made of them.
#[inline(always)]
pub(super) fn packed_triangle<'a>(
    mesh: &Mesh,
    triangle: usize,
    record: &'a PackedPatch,
) -> PackedTriangle<'a> {
    PackedTriangle::new(vertices(mesh, triangle), record)
}

/// Whether a triangle has no curved surface.
pub(super) fn is_flat(record: &PackedPatch) -> bool {
    matches!(record.kind(), PatchKind::Flat(_) | PatchKind::Degenerate)
}
