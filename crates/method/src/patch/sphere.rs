//! A sphere that bounds a patch.

use crate::numbers::{Scalar, Vector};

/// By what a sphere is enlarged: a number from 1 on, of four binary digits, in one byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Enlargement(pub(crate) u8);

impl Enlargement {
    /// Bits of a single that are left out.
    const DROPPED: u32 = 19;
    const ONE: u32 = 1f32.to_bits();

    /// The least one that is no less than this, rounding included; the greatest, some 60,000,
    /// where there is none.
    pub(crate) fn at_least(ratio: f64) -> Self {
        if ratio <= 1.0 {
            return Self(0);
        }
        let ratio = (ratio * (1.0 + 1e-6)) as f32;
        let steps = (ratio.to_bits() - Self::ONE).div_ceil(1 << Self::DROPPED);
        Self(steps.min(u8::MAX.into()) as u8)
    }

    pub(crate) fn factor<S: Scalar>(self) -> S {
        let bits = Self::ONE + (u32::from(self.0) << Self::DROPPED);
        S::from_f64(f32::from_bits(bits).into())
    }
}

/// The sphere of greatest curvature of a patch, as it is used: see [`BoundsKind::Sphere`].
///
/// [`BoundsKind::Sphere`]: super::BoundsKind::Sphere
#[derive(Clone, Copy, Debug)]
pub struct Sphere<S> {
    /// From the patch's origin, in units of its size, like the radius.
    pub(crate) centre: Vector<S>,
    pub(crate) radius: S,
    pub(crate) enlargement: Enlargement,
    pub(crate) limited: bool,
}

impl<S: Scalar> Sphere<S> {
    /// What to keep of it.
    pub(crate) fn enlargement(&self) -> Enlargement {
        self.enlargement
    }

    /// Whether it is larger than the paper's, because the surface may leave that.
    pub fn is_enlarged(&self) -> bool {
        self.enlargement != Enlargement::default()
    }

    /// Whether it is smaller than the paper's, because that is far larger than the triangle.
    pub fn is_limited(&self) -> bool {
        self.limited
    }
}
