//! A triangle as a mesh keeps it: what rays are traced against, laid out anew for each.

use fearless_simd::{Level, dispatch, f32x8, prelude::*};

use super::columns::{in_columns, vertices};
use super::packed_patch::PackedPatch;
use super::unpack::Outline;
use crate::bounds::DirectionalBounds;
use crate::numbers::{Patches, inlined};
use crate::patch::{Patch, TriangleVertices, VERTICES};

/// A curved triangle's vertices and its packed patch.
#[derive(Clone, Copy, Debug)]
pub struct PackedTriangle<'a> {
    pub(crate) corners: TriangleVertices,
    /// The record's, so that the record is read when the vertices are.
    pub(crate) slab: [f32; 2],
    packed: &'a PackedPatch,
}

impl<'a> PackedTriangle<'a> {
    /// The patch over these vertices whose [record](Patch::pack) this is.
    #[inline(always)]
    pub fn new(corners: TriangleVertices, packed: &'a PackedPatch) -> Self {
        Self {
            corners,
            slab: packed.slab,
            packed,
        }
    }

    pub(crate) fn corners(&self) -> &TriangleVertices {
        &self.corners
    }

    pub(crate) fn packed(&self) -> &'a PackedPatch {
        self.packed
    }

    /// What rays are clipped to.
    #[inline(always)]
    pub fn outline(&self) -> Outline<'a, f32> {
        Outline::new(self.corners.positions, self.corners.normals, self.packed)
    }

    /// The whole patch.
    pub fn patch(&self) -> Patch<f32> {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || self.outline().complete()
        ))
    }
}

/// Numbers of a triangle: its vertices and the slab.
const SOURCE: usize = VERTICES + 2;

impl PackedTriangle<'_> {
    #[inline(always)]
    fn reach_source(&self) -> [f32; SOURCE] {
        let mut source = [0.0; SOURCE];
        self.corners().write(&mut source[..VERTICES]);
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
