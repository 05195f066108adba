//! A triangle as a mesh keeps it: what rays are traced against, laid out anew for each.

use fearless_simd::{Level, Simd, dispatch};

use super::frame::Frame;
use super::outline::Outline;
use super::patch::Patch;
use super::ray::{Ray, beyond};
use super::record::PatchRecord;
use super::vector::Vector;

/// A triangle's vertices.
#[derive(Clone, Copy, Debug)]
pub struct Corners {
    /// Their positions.
    pub positions: [Vector<f32>; 3],
    /// Their normals, unit.
    pub normals: [Vector<f32>; 3],
}

impl Corners {
    /// The unit of length of the patch over them: a power of two, at most the longest side; 1 where there
    /// is no patch.
    pub fn size(&self) -> f32 {
        Frame::new(&self.positions, &self.normals).map_or(1.0, |frame| frame.size)
    }
}

/// A curved triangle's vertices and its record: all that is kept of a patch.
#[derive(Clone, Copy, Debug)]
pub struct KeptPatch<'a> {
    corners: Corners,
    /// The record's, so that the record is read when the vertices are.
    pub(super) slab: [f32; 2],
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

    pub(super) fn corners(&self) -> &Corners {
        &self.corners
    }

    pub(super) fn record(&self) -> &'a PatchRecord {
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

    /// The same as [`Patch::beyond`].
    pub fn beyond(&self, ray: &Ray<f32>, t: f32) -> f32 {
        beyond(self.corners.positions[0], self.outline().size(), ray, t)
    }
}
