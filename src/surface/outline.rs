//! The half of a patch that tells most rays that they miss it.

use super::flags::BoundsKind;
use super::patch::{Patch, PatchKind, Rule};
use super::ray::{Ray, Segment};
use super::real::{Real, Scalar};
use super::record::PatchRecord;
use super::sphere::Sphere;
use super::vector::Vector;

/// A patch's plane, side planes and slab: what tells most rays that they miss, for half of what the
/// whole patch costs.
#[derive(Clone, Copy, Debug)]
pub struct Outline<'a, S> {
    patch: Patch<S>,
    edges: [Vector<S>; 3],
    normals: [Vector<S>; 3],
    record: &'a PatchRecord,
}

impl<'a, S: Scalar> Outline<'a, S> {
    /// The outline of the patch of these vertices, from what [`Patch::record`] kept of it.
    #[inline]
    pub fn new(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        record: &'a PatchRecord,
    ) -> Self {
        let mut patch = Patch::empty(positions[0]);
        let edges = patch.lay_out(positions, normals);
        patch.kind = record.kind();
        let [least, most] = record.slab;
        patch.slab = [S::from_f64(least.into()), S::from_f64(most.into())];
        match patch.kind {
            PatchKind::Curved => patch.rule = Rule::of(record.flags().surface()),
            PatchKind::Fallback => patch.rule = Rule::Angular,
            PatchKind::Flat(reason) => patch.flatten(reason),
            PatchKind::Degenerate => {}
        }
        if record.flags().bounds() == BoundsKind::Sphere && patch.rule != Rule::Flat {
            patch.sphere = Some(Sphere::of_record(&patch, record.enlargement));
        }
        Self {
            patch,
            edges: edges.unwrap_or(patch.gradients),
            normals,
            record,
        }
    }

    /// Where the ray can meet the surface at all, in the valid lanes.
    #[inline(always)]
    pub fn clip<V: Real<Scalar = S>>(&self, ray: &Ray<V>, valid: V::Mask) -> Segment<V> {
        self.patch.clip(ray, valid)
    }

    /// The same as [`Patch::sphere`].
    pub fn sphere(&self) -> Option<&Sphere<S>> {
        self.patch.sphere()
    }

    /// The same as [`Patch::beyond`].
    pub fn beyond(&self, ray: &Ray<S>, t: S) -> S {
        self.patch.beyond(ray, t)
    }

    /// The whole patch.
    #[inline]
    pub fn complete(self) -> Patch<S> {
        let mut patch = self.patch;
        if patch.rule == Rule::Flat {
            return patch;
        }
        patch.lay_surface(self.edges, self.normals, self.record.flags());
        if patch.rule == Rule::Angular {
            patch.set_angles();
        }
        for (side, kept) in patch.sides.iter_mut().zip(self.record.correction()) {
            side.correction = kept;
        }
        patch
    }
}
