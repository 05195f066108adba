//! SIMD lanes as the kernel's numbers: as many `f32` as a register of this processor holds, or four.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::{f32x4, mask32x4, prelude::*};

use super::real::{Mask, Real, atan2};

macro_rules! arithmetic {
    ($lanes:ident: $($operation:ident $function:ident),*) => {$(
        impl<S: Simd> $operation for $lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self($operation::$function(self.0, other.0))
            }
        }
    )*};
}

macro_rules! lanes {
    ($(#[$doc:meta])* $lanes:ident: $register:ty, $mask:ident: $mask_register:ty) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(super) struct $lanes<S: Simd>(pub $register);

        /// One truth value a lane.
        #[derive(Clone, Copy)]
        pub(super) struct $mask<S: Simd>(pub $mask_register);

        arithmetic!($lanes: Add add, Sub sub, Mul mul, Div div);
        arithmetic!($mask: BitAnd bitand, BitOr bitor);

        impl<S: Simd> Neg for $lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl<S: Simd> Not for $mask<S> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }

        impl<S: Simd> Mask for $mask<S> {
            #[inline(always)]
            fn any(self) -> bool {
                self.0.any_true()
            }
            #[inline(always)]
            fn count(self) -> u32 {
                self.0.to_bitmask().count_ones()
            }
        }

        impl<S: Simd> Real for $lanes<S> {
            type Mask = $mask<S>;
            type Scalar = f32;

            #[inline(always)]
            fn splat(self, value: f32) -> Self {
                Self(<$register>::splat(self.0.token(), value))
            }
            #[inline(always)]
            fn mask(self, value: bool) -> $mask<S> {
                $mask(<$mask_register>::splat(self.0.token(), value))
            }
            #[inline(always)]
            fn less(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_lt(other.0))
            }
            #[inline(always)]
            fn at_most(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_le(other.0))
            }
            #[inline(always)]
            fn select(mask: $mask<S>, yes: Self, no: Self) -> Self {
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
    };
}

lanes! {
    /// One `f32` a lane, as many as a register of the instruction set `S` has.
    Lanes: S::f32s, LaneMask: S::mask32s
}
lanes! {
    /// Four lanes of `f32`, with the same ray in each: a single ray is faster in a register's lanes, where
    /// choices take no branches and no detours.
    Quad: f32x4<S>, QuadMask: mask32x4<S>
}
