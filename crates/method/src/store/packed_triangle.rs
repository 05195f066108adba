//! A triangle as a mesh holds it: its vertices and the packed patch over them.

use fearless_simd::{f32x8, prelude::*};

use super::columns::{in_columns, vertices};
use super::packed_patch::PackedPatch;
use crate::bounds::DirectionalBounds;
use crate::numbers::{Patches, inlined};
use crate::patch::{TriangleVertices, VERTICES};

/// A curved triangle's vertices and its packed patch.
#[derive(Clone, Copy, Debug)]
pub struct PackedTriangle<'a> {
    pub(crate) vertices: TriangleVertices,
    /// The record's, so that the record is read when the vertices are.
    pub(crate) slab: [f32; 2],
    packed: &'a PackedPatch,
}

impl<'a> PackedTriangle<'a> {
    /// The patch over these vertices whose [packed form](crate::Patch::pack) this is.
    #[inline(always)]
    pub fn new(vertices: TriangleVertices, packed: &'a PackedPatch) -> Self {
        Self {
            vertices,
            slab: packed.slab,
            packed,
        }
    }

    pub(crate) fn vertices(&self) -> &TriangleVertices {
        &self.vertices
    }

    pub(crate) fn packed(&self) -> &'a PackedPatch {
        self.packed
    }
}

/// Numbers of a triangle: its vertices and the slab.
const SOURCE: usize = VERTICES + 2;

impl PackedTriangle<'_> {
    #[inline(always)]
    fn reach_source(&self) -> [f32; SOURCE] {
        let mut source = [0.0; SOURCE];
        self.vertices().write(&mut source[..VERTICES]);
        source[VERTICES..].copy_from_slice(&self.packed().slab().unwrap_or([0.0; 2]));
        source
    }
}

impl<S: Simd> DirectionalBounds<Patches<S>> {
    /// Of eight triangles, none without area, one a lane.
    #[inline(always)]
    pub fn of_patches<'a>(simd: S, of: impl Fn(usize) -> PackedTriangle<'a>) -> Self {
        let columns = in_columns(
            #[inline(always)]
            |n| of(n).reach_source(),
        );
        let number = inlined(
            #[inline(always)]
            |n: usize| Patches(f32x8::from_slice(simd, &columns[n])),
        );
        let [positions, normals] = vertices(simd, &columns);
        Self::new(
            positions,
            &normals,
            [number(VERTICES), number(VERTICES + 1)],
        )
    }
}
