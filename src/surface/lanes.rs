//! SIMD lanes as the kernel's numbers: as many `f32` as a register of this processor holds.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::prelude::*;

use super::real::{Mask, Real, atan2};

/// One `f32` a lane, of the instruction set `S`.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd>(pub S::f32s);

/// One truth value a lane.
#[derive(Clone, Copy)]
pub(super) struct LaneMask<S: Simd>(pub S::mask32s);

macro_rules! arithmetic {
    ($($operation:ident $function:ident),*) => {$(
        impl<S: Simd> $operation for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self($operation::$function(self.0, other.0))
            }
        }
    )*};
}

arithmetic!(Add add, Sub sub, Mul mul, Div div);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> BitAnd for LaneMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl<S: Simd> BitOr for LaneMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl<S: Simd> Not for LaneMask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl<S: Simd> Mask for LaneMask<S> {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any_true()
    }
    #[inline(always)]
    fn count(self) -> u32 {
        self.0.to_bitmask().count_ones()
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = LaneMask<S>;
    type Scalar = f32;

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Self(S::f32s::splat(self.0.token(), value))
    }
    #[inline(always)]
    fn mask(self, value: bool) -> LaneMask<S> {
        LaneMask(S::mask32s::splat(self.0.token(), value))
    }
    #[inline(always)]
    fn less(self, other: Self) -> LaneMask<S> {
        LaneMask(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> LaneMask<S> {
        LaneMask(self.0.simd_le(other.0))
    }
    #[inline(always)]
    fn select(mask: LaneMask<S>, yes: Self, no: Self) -> Self {
        Self(mask.0.select(yes.0, no.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        atan2(self, x)
    }
    #[inline(always)]
    fn apart<T>(self, call: impl FnOnce() -> T) -> T {
        self.0.token().vectorize(call)
    }
}
