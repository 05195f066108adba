//! The packed form of a patch, in half a cache line.

use super::codecs::{UNKNOWN, pack_unevenness, power_of_two, unpack_unevenness};
use crate::numbers::Scalar;
use crate::patch::{Enlargement, FlatReason, Patch, PatchFlags, PatchKind};

/// The per-triangle results worth keeping: with the three vertices they give the patch back
/// without computing bounds and correction again.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct PackedPatch {
    /// Least and greatest height, in units of the patch's size.
    pub(crate) slab: [f32; 2],
    /// In units of two to the power of `exponent`: the correction vanishes on the edges, so that
    /// 16 bits are enough for it.
    correction: [[i16; 3]; 3],
    flags: PatchFlags,
    kind: u8,
    /// How far the surface is off a paraboloid, packed by the codecs.
    unevenness: u8,
    exponent: i8,
    /// Of the sphere of greatest curvature, where that bounds the patch.
    pub(crate) enlargement: Enlargement,
}

const _: () = assert!(size_of::<PackedPatch>() == 32, "a packed patch has grown");

/// Every kind; a record holds the place in this list.
const KINDS: [PatchKind; 9] = [
    PatchKind::Curved,
    PatchKind::Fallback,
    PatchKind::Degenerate,
    PatchKind::Flat(FlatReason::Requested),
    PatchKind::Flat(FlatReason::Sliver),
    PatchKind::Flat(FlatReason::BackNormal),
    PatchKind::Flat(FlatReason::Bend),
    PatchKind::Flat(FlatReason::Fold),
    PatchKind::Flat(FlatReason::Plane),
];

impl PackedPatch {
    /// Of a triangle without area, which nothing is known of yet.
    pub fn blank(flags: PatchFlags) -> Self {
        let contents = Contents {
            slab: [0.0; 2],
            correction: [[0.0; 3]; 3],
            unit: 1.0,
            unevenness: UNKNOWN,
        };
        Self::new(PatchKind::Degenerate, flags, &contents)
    }

    /// Of a patch without a sphere.
    #[inline]
    pub(crate) fn new(kind: PatchKind, flags: PatchFlags, contents: &Contents) -> Self {
        let kind = KINDS.iter().position(|&listed| listed == kind);
        let per_unit = 1.0 / contents.unit;
        Self {
            slab: contents.slab,
            correction: contents
                .correction
                .map(|edge| edge.map(|c| (c * per_unit) as i16)),
            flags,
            kind: kind.expect("every kind is in the list") as u8,
            unevenness: contents.unevenness,
            exponent: (((contents.unit.to_bits() >> 23) & 0xff) as i32 - 127) as i8,
            enlargement: Enlargement::default(),
        }
    }

    /// The flags the patch was made with.
    pub fn flags(&self) -> PatchFlags {
        self.flags
    }

    /// What the triangle turned out to be.
    #[inline(always)]
    pub fn kind(&self) -> PatchKind {
        KINDS[usize::from(self.kind)]
    }

    /// Whether there is a surface, and not in the triangle's plane.
    #[inline(always)]
    pub(crate) fn is_curved(&self) -> bool {
        matches!(self.kind(), PatchKind::Curved | PatchKind::Fallback)
    }

    /// Least and greatest height, unless the triangle is plane.
    #[inline(always)]
    pub(crate) fn slab(&self) -> Option<[f32; 2]> {
        self.is_curved().then_some(self.slab)
    }

    /// How far the surface's slope is off a paraboloid's at the most; infinite where that is not known.
    #[inline(always)]
    pub(crate) fn unevenness(&self) -> f32 {
        unpack_unevenness(self.unevenness)
    }

    /// The correction's coefficients, an edge each.
    #[inline(always)]
    pub(crate) fn correction(&self) -> [[f32; 3]; 3] {
        let unit = power_of_two(self.exponent.into());
        // Not by `map`, which is called, and the vectors' halves of it wait for each other.
        three!(|k| {
            let edge = &self.correction[k];
            three!(|n| f32::from(edge[n]) * unit)
        })
    }
}

impl<S: Scalar> Patch<S> {
    /// What [`Patch::unpack`] needs to know beside the vertices.
    pub fn pack(&self, flags: PatchFlags) -> PackedPatch {
        let single = |value: S| value.to_f64() as f32;
        let contents = Contents {
            slab: self.slab.map(single),
            correction: self.edges.map(|edge| edge.correction.map(single)),
            unit: single(self.correction_unit()),
            unevenness: pack_unevenness(self.unevenness),
        };
        let sphere = self.sphere();
        PackedPatch {
            enlargement: sphere.map_or_else(Default::default, |sphere| sphere.enlargement()),
            ..PackedPatch::new(self.kind, flags, &contents)
        }
    }
}

/// What a record keeps of a patch's contents.
pub(crate) struct Contents {
    pub slab: [f32; 2],
    /// Rounded to whole units.
    pub correction: [[f32; 3]; 3],
    /// A power of two.
    pub unit: f32,
    pub unevenness: u8,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::{Vector, vector};
    use crate::patch::Surface;

    fn patch(correction: [[f64; 3]; 3]) -> Patch<f64> {
        let mut patch = Patch::empty(vector(0.0, 0.0, 0.0));
        for (edge, c) in patch.edges.iter_mut().zip(correction) {
            edge.correction = c;
        }
        patch
    }

    #[test]
    fn every_kind_is_kept() {
        let mut patch = patch([[0.0; 3]; 3]);
        for kind in KINDS {
            patch.kind = kind;
            assert_eq!(patch.pack(PatchFlags::default()).kind(), kind);
        }
    }

    #[test]
    fn a_correction_keeps_fifteen_digits_and_rounding_is_done_once() {
        for greatest in [1e-20, 3e-7, 0.5, 1.0, 0.999_999_9, 1.999_999_9, 4e3] {
            let wanted = [
                [greatest, -0.3 * greatest, 0.0],
                [0.1 * greatest, -greatest, 1e-9 * greatest],
                [0.0, 0.7 * greatest, -0.9 * greatest],
            ];
            let mut patch = patch(wanted);
            patch.round_correction();
            let rounded = patch.edges.map(|edge| edge.correction);
            for (rounded, wanted) in rounded.iter().flatten().zip(wanted.iter().flatten()) {
                let error = (rounded - wanted).abs();
                assert!(
                    error <= greatest * 2.0f64.powi(-14),
                    "{rounded} for {wanted}"
                );
            }
            let packed = patch.pack(PatchFlags::default());
            assert_eq!(packed.correction().map(|edge| edge.map(f64::from)), rounded);
            patch.round_correction();
            assert_eq!(patch.edges.map(|edge| edge.correction), rounded);
        }
    }

    #[test]
    fn a_patch_comes_back_bit_for_bit() {
        let positions = [
            vector(0.0f32, 0.0, 0.0),
            vector(1.0, 0.0, 0.1),
            vector(0.2, 0.9, -0.1),
        ];
        let normals = [
            vector(-0.2f32, -0.1, 1.0),
            vector(0.3, 0.0, 1.0),
            vector(0.0, 0.2, 1.0),
        ]
        .map(|n: Vector<f32>| n * (1.0 / n.length()));
        for surface in Surface::ALL {
            let flags = PatchFlags::new(surface);
            let patch = Patch::new(positions, normals, flags);
            let again = Patch::unpack(positions, normals, &patch.pack(flags));
            // The angles at the vertices are set where the rule needs them.
            assert_eq!((patch.kind, patch.rule), (again.kind, again.rule));
            assert_eq!(patch.slab, again.slab);
            assert_eq!(format!("{:?}", patch.edges), format!("{:?}", again.edges));
        }
    }
}
