//! A triangle as a mesh keeps it: what rays are traced against, laid out anew for each.

use fearless_simd::{Level, dispatch, f32x8, prelude::*};

use super::columns::{in_columns, vertices};
use super::packed_patch::PatchRecord;
use super::unpack::Outline;
use crate::bounds::Reach;
use crate::numbers::{Patches, inlined};
use crate::patch::{Corners, Patch, VERTICES};

/// A curved triangle's vertices and its record: all that is kept of a patch.
#[derive(Clone, Copy, Debug)]
pub struct KeptPatch<'a> {
    pub(crate) corners: Corners,
    /// The record's, so that the record is read when the vertices are.
    pub(crate) slab: [f32; 2],
    record: &'a PatchRecord,
}

impl<'a> KeptPatch<'a> {
    /// The patch over these vertices whose [record](Patch::record) this is.
    #[inline(always)]
    pub fn new(corners: Corners, record: &'a PatchRecord) -> Self {
        Self {
            corners,
            slab: record.slab,
            record,
        }
    }

    pub(crate) fn corners(&self) -> &Corners {
        &self.corners
    }

    pub(crate) fn record(&self) -> &'a PatchRecord {
        self.record
    }

    /// What rays are clipped to.
    #[inline(always)]
    pub fn outline(&self) -> Outline<'a, f32> {
        Outline::new(self.corners.positions, self.corners.normals, self.record)
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

impl KeptPatch<'_> {
    #[inline(always)]
    fn reach_source(&self) -> [f32; SOURCE] {
        let mut source = [0.0; SOURCE];
        self.corners().write(&mut source[..VERTICES]);
        source[VERTICES..].copy_from_slice(&self.record().slab().unwrap_or([0.0; 2]));
        source
    }
}

impl<S: Simd> Reach<Patches<S>> {
    /// Of eight triangles, none without area, one a lane.
    #[inline(always)]
    pub fn of_patches<'a>(simd: S, of: impl Fn(usize) -> KeptPatch<'a>) -> Self {
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
