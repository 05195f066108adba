//! SIMD lanes as the kernel's numbers: as many `f32` as a register of this processor holds, or four.

use std::fmt;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::{
    f32x4, f32x8, f32x16, mask32x4, mask32x8, mask32x16, prelude::*, u32x8, u32x16,
};

use super::scalar::{Arithmetic, Constant, Mask, Real, atan2, sealed};

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

macro_rules! masks {
    ($(#[$doc:meta])* $mask:ident: $register:ty) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $mask<S: Simd>(pub $register);

        arithmetic!($mask: BitAnd bitand, BitOr bitor);

        impl<S: Simd> Not for $mask<S> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }

        impl<S: Simd> fmt::Debug for $mask<S> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{:b}", self.0.to_bitmask())
            }
        }

        impl<S: Simd> sealed::Sealed for $mask<S> {}

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
    };
}

macro_rules! lanes {
    (
        $(#[$doc:meta])*
        $lanes:ident: $register:ty, $mask:ident: $mask_register:ty, $scalar:ty,
        |$same:ident, $value:ident| $splat:expr, $splat_mask:expr
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $lanes<S: Simd>(pub $register);

        arithmetic!($lanes: Add add, Sub sub, Mul mul, Div div);

        impl<S: Simd> Neg for $lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl<S: Simd> sealed::Sealed for $lanes<S> {}

        impl<S: Simd> Arithmetic for $lanes<S> {
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                Self(self.0.mul_add(factor.0, term.0))
            }
        }

        impl<S: Simd> Real for $lanes<S> {
            type Mask = $mask<S>;
            type Scalar = $scalar;

            #[inline(always)]
            fn splat(self, value: $scalar) -> Self {
                let ($same, $value) = (self, value);
                $splat
            }
            #[inline(always)]
            fn splat_mask(self, value: <$scalar as Real>::Mask) -> $mask<S> {
                let ($same, $value) = (self, value);
                $splat_mask
            }
            #[inline(always)]
            fn constant(self, value: f64) -> Self {
                Self(<$register>::splat(self.0.token(), value as f32))
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
            fn out_of_line<T>(self, call: impl FnOnce() -> T) -> T {
                self.0.token().vectorize(call)
            }
        }
    };
}

masks! {
    /// One truth value a lane.
    LaneMask: S::mask32s
}
masks! {
    /// The same for [`Quad`].
    QuadMask: mask32x4<S>
}
lanes! {
    /// One `f32` a lane, as many as a register of the instruction set `S` has.
    Lanes: S::f32s, LaneMask: S::mask32s, f32,
    |lanes, value| Self(S::f32s::splat(lanes.0.token(), value)), lanes.mask(value)
}
lanes! {
    /// Four lanes of `f32`, with the same ray in each: a single ray is faster in a register's lanes, where
    /// choices take no branches and no detours.
    Quad: f32x4<S>, QuadMask: mask32x4<S>, f32,
    |lanes, value| Self(f32x4::splat(lanes.0.token(), value)), lanes.mask(value)
}
masks! {
    /// The same for [`Patches`].
    PatchMask: mask32x8<S>
}
lanes! {
    /// Constants of eight patches, one `f32` each; and what rays are at them, one each.
    Patches: f32x8<S>, PatchMask: mask32x8<S>, Self,
    |_lanes, value| value, value
}

masks! {
    /// The same for [`ManyPatches`].
    ManyMask: mask32x16<S>
}
lanes! {
    /// The same of sixteen.
    ManyPatches: f32x16<S>, ManyMask: mask32x16<S>, Self,
    |_lanes, value| value, value
}

/// How many patches [`Patches`] are of.
pub const PATCHES: usize = 8;

impl<S: Simd> Patches<S> {
    /// The numbers, one a patch.
    #[inline(always)]
    pub fn numbers(self) -> [f32; PATCHES] {
        let mut numbers = [0.0; PATCHES];
        self.0.store_slice(&mut numbers);
        numbers
    }
}

macro_rules! constants {
    ($lanes:ident: $register:ident, $bits:ident) => {
        impl<S: Simd> Constant for $lanes<S> {
            const PRECISION: f64 = f32::EPSILON as f64;

            #[inline(always)]
            fn power_of_two(self) -> Self {
                Self($register::from_bits(self.0.to_bits() & 0x7f80_0000))
            }
            #[inline(always)]
            fn per_power_of_two(self) -> Self {
                let twice_one = $bits::splat(self.0.token(), 2 * 1f32.to_bits());
                Self($register::from_bits(twice_one - self.0.to_bits()))
            }
        }
    };
}

constants! { Patches: f32x8, u32x8 }
constants! { ManyPatches: f32x16, u32x16 }

/// Most rays of a packet.
pub const MAX_LANES: usize = 16;

/// A register's lanes of a packet from `first` on; zeros beyond the end.
#[inline(always)]
pub fn load_lanes<S: Simd>(simd: S, from: &[f32], first: usize) -> S::f32s {
    let rest = &from[first..];
    match rest.get(..S::f32s::LEN) {
        Some(lanes) => S::f32s::from_slice(simd, lanes),
        None => {
            let mut lanes = [0.0; MAX_LANES];
            lanes[..rest.len()].copy_from_slice(rest);
            S::f32s::from_slice(simd, &lanes[..S::f32s::LEN])
        }
    }
}

impl<S: Simd> Lanes<S> {
    /// A register's numbers of a packet from `first` on; zeros beyond the end.
    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[f32], first: usize) -> Self {
        Self(load_lanes(simd, from, first))
    }

    /// Writes the numbers to where those from `first` on belong.
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f32; MAX_LANES], first: usize) {
        self.0.store_slice(&mut to[first..][..S::f32s::LEN]);
    }
}
