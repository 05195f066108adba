//! The numbers the kernel is written over: one source for `f32`, `f64` and SIMD lanes.
//!
//! Three layers, because a patch, a ray and a derivative are different kinds of number:
//! - [`Constant`]: what a patch's constants are made of; [`Scalar`]s, `f32` or `f64`, of one patch, or a
//!   number a lane, of as many patches that are made at once;
//! - [`Real`]: one value, or one value a lane; compared by masks and chosen by `select`, so that
//!   nothing in an evaluation branches on a value;
//! - [`Jet`]: a [`Real`], or a [`Real`] with its partial derivatives ([`super::dual::Dual`]).

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Three values, of a function of 0, 1 and 2.
///
/// In place of `map`: code for SIMD lanes is only good where all of it is inlined, and the standard
/// library's own loops need not be.
#[inline(always)]
pub fn three<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

/// The closure itself: the language takes the mark that a closure is to be inlined, which those on
/// lanes need, only where it is an argument.
#[inline(always)]
pub fn inlined<F>(closure: F) -> F {
    closure
}

/// An array of three values, of an expression with 0, 1 and 2 in the place of a name.
///
/// No closure, since code for SIMD lanes is only good where all of it is inlined.
macro_rules! three {
    (|$k:ident| $value:expr) => {
        [
            {
                let $k = 0;
                $value
            },
            {
                let $k = 1;
                $value
            },
            {
                let $k = 2;
                $value
            },
        ]
    };
}

/// Does the same with 0, 1 and 2 in the place of a name.
macro_rules! each {
    (|$k:ident| $done:expr) => {{
        {
            let $k = 0;
            $done;
        }
        {
            let $k = 1;
            $done;
        }
        {
            let $k = 2;
            $done;
        }
    }};
}

/// The answer of a comparison, one truth value a lane.
pub trait Mask:
    sealed::Sealed
    + Copy
    + std::fmt::Debug
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Not<Output = Self>
{
    /// Whether any lane holds.
    fn any(self) -> bool;
    /// How many lanes hold.
    fn count(self) -> u32;
    /// Whether every lane holds.
    fn all(self) -> bool {
        !(!self).any()
    }
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn count(self) -> u32 {
        u32::from(self)
    }
}

/// Keeps the traits of numbers to the types of this package.
pub(crate) mod sealed {
    /// Implemented for the numbers of this package alone.
    pub trait Sealed {}

    impl Sealed for bool {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The arithmetic every layer shares.
pub trait Arithmetic:
    sealed::Sealed
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// `self * factor + term`, of single precision rounded once where the processor has an instruction for it.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// `self * factor - term`, the same.
    #[inline(always)]
    fn mul_sub(self, factor: Self, term: Self) -> Self {
        self.mul_add(factor, -term)
    }
    /// `self - left * right`, the same.
    #[inline(always)]
    fn less_product(self, left: Self, right: Self) -> Self {
        (-left).mul_add(right, self)
    }
}

impl Arithmetic for f32 {
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        f32::mul_add(self, factor, term)
    }
}

impl Arithmetic for f64 {
    // What checks single precision need not wait for a library's function.
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }
}

/// One value, or one a lane.
///
/// SIMD lanes exist only where the processor was found to have them, and each value is the proof of
/// that; so constants are made from a value of the same lanes at hand, whatever it holds.
pub trait Real: Arithmetic {
    /// One truth value a lane.
    type Mask: Mask;
    /// What the constants are made of that are the same in every lane.
    type Scalar: Constant;

    /// This value in every lane, as many as `self` has.
    fn splat(self, value: Self::Scalar) -> Self;
    /// This truth of a constant in every lane.
    fn splat_mask(self, value: <Self::Scalar as Real>::Mask) -> Self::Mask;
    /// The same constant in every lane, rounded to the lanes' precision.
    fn constant(self, value: f64) -> Self;
    /// Zero in every lane.
    #[inline(always)]
    fn zero(self) -> Self {
        self.constant(0.0)
    }
    /// One in every lane.
    #[inline(always)]
    fn one(self) -> Self {
        self.constant(1.0)
    }
    /// Two in every lane.
    #[inline(always)]
    fn two(self) -> Self {
        self.constant(2.0)
    }
    /// A half in every lane.
    #[inline(always)]
    fn half(self) -> Self {
        self.constant(0.5)
    }
    /// This truth value in every lane, as many as `self` has.
    fn mask(self, value: bool) -> Self::Mask;
    /// `self < other`, lane by lane; false where either is NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// `self <= other`, lane by lane; false where either is NaN.
    fn at_most(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The square root; NaN below zero.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The angle of the point `(x, self)`, in radians within [-pi, pi]; 0 at the origin.
    fn atan2(self, x: Self) -> Self;

    /// Calls a function whose code is better not copied to each place that calls it.
    #[inline(always)]
    fn out_of_line<T>(self, call: impl FnOnce() -> T) -> T {
        call()
    }
    /// The lesser of the two; `other` where `self` is NaN.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self::select(self.less(other), self, other)
    }
    /// The greater of the two; `other` where `self` is NaN.
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self::select(other.less(self), self, other)
    }
}

/// What a patch's constants are made of: a number, or a number a lane, each of a patch of its own.
pub trait Constant: Real<Scalar = Self> + std::fmt::Debug {
    /// The distance from 1 to the next larger number.
    const PRECISION: f64;

    /// The largest power of two that is not larger than this positive normal number.
    ///
    /// Dividing by it is exact, so two triangles that share an edge get bit-equal numbers of it,
    /// whatever their own sizes.
    fn power_of_two(self) -> Self;

    /// One over a power of two that is neither the least nor the greatest: exact, and without waiting for a
    /// division.
    fn per_power_of_two(self) -> Self;
}

/// `f32` or `f64`.
pub trait Scalar: Constant<Mask = bool> + PartialOrd {
    /// The distance from 1 to the next larger value.
    const EPSILON: Self;
    /// A finite value larger than any a scene holds.
    const HUGE: Self;

    /// Rounded from `f64`.
    fn from_f64(value: f64) -> Self;
    /// The same value as `f64`; exact.
    fn to_f64(self) -> f64;
    /// Whether it is neither infinite nor NaN.
    fn is_finite(self) -> bool;
}

macro_rules! scalar {
    ($float:ident, $huge:expr, $exponent_bits:expr, $atan2:expr) => {
        impl Real for $float {
            type Mask = bool;
            type Scalar = $float;

            #[inline(always)]
            fn splat(self, value: $float) -> Self {
                value
            }
            #[inline(always)]
            fn splat_mask(self, value: bool) -> bool {
                value
            }
            #[inline(always)]
            fn constant(self, value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn mask(self, value: bool) -> bool {
                value
            }
            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn at_most(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $float::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $float::abs(self)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
        }

        impl Constant for $float {
            const PRECISION: f64 = $float::EPSILON as f64;

            #[inline(always)]
            fn power_of_two(self) -> Self {
                $float::from_bits(self.to_bits() & $exponent_bits)
            }
            #[inline(always)]
            fn per_power_of_two(self) -> Self {
                // Exponents are stored with the bias added, which the exponent of one is: 0 turned round.
                $float::from_bits((2 * $float::to_bits(1.0)).wrapping_sub(self.to_bits()))
            }
        }

        impl Scalar for $float {
            const EPSILON: Self = $float::EPSILON;
            const HUGE: Self = $huge;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }
        }
    };
}

scalar!(f32, 1e30, 0x7f80_0000, atan2);
scalar!(f64, 1e200, 0x7ff0_0000_0000_0000, f64::atan2);

/// `atan(a) / a` for `a` in [0, 1] as a polynomial in the square of `a`, highest power first, within
/// 2e-8: Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.49.
const ARC_TANGENT: [f64; 9] = [
    0.0028662257,
    -0.0161657367,
    0.0429096138,
    -0.0752896400,
    0.1065626393,
    -0.1420889944,
    0.1999355085,
    -0.3333314528,
    1.0,
];

/// [`Real::atan2`] to the precision of `f32`, of the same operations in every lane.
#[inline(always)]
pub(crate) fn atan2<V: Real>(y: V, x: V) -> V {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (zero, one) = (x.zero(), x.one());
    let (ahead, sideways) = (x.abs(), y.abs());
    let (near, far) = (ahead.lesser(sideways), ahead.greater(sideways));
    let ratio = near / V::select(zero.less(far), far, one);
    let square = ratio * ratio;
    let [first, rest @ ..] = ARC_TANGENT;
    let mut sum = x.constant(first);
    for c in rest {
        sum = sum.mul_add(square, x.constant(c));
    }
    let angle = ratio * sum;
    let angle = V::select(ahead.less(sideways), x.constant(FRAC_PI_2) - angle, angle);
    let angle = V::select(x.less(zero), x.constant(PI) - angle, angle);
    V::select(y.less(zero), -angle, angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_of_two_divides_exactly() {
        for value in [1.0f32, 1.5, 3.999, 1e-20, 7e30, 0.1] {
            let power = value.power_of_two();
            assert!(power <= value && value < 2.0 * power);
            assert_eq!((value / power) * power, value);
        }
        assert_eq!(5.0f64.power_of_two(), 4.0);
    }

    #[test]
    fn the_angle_is_right_all_around() {
        for n in 0..10_000 {
            let angle = (f64::from(n) / 5_000.0 - 1.0) * std::f64::consts::PI;
            let radius = 10f64.powi(n % 20 - 10);
            let (x, y) = ((radius * angle.cos()) as f32, (radius * angle.sin()) as f32);
            let exact = f64::from(y).atan2(f64::from(x));
            let error = (f64::from(Real::atan2(y, x)) - exact).abs();
            assert!(error < 3e-7, "{x} {y}: {error:e}");
        }
        assert_eq!(Real::atan2(0.0f32, 0.0), 0.0);
    }

    #[test]
    fn one_over_a_power_of_two_is_exact() {
        for exponent in -125..126 {
            let power = 2f32.powi(exponent);
            assert_eq!(power.per_power_of_two(), 1.0 / power);
            assert_eq!(f64::from(power).per_power_of_two(), 1.0 / f64::from(power));
        }
    }

    #[test]
    fn lesser_and_greater_drop_a_nan_on_the_left() {
        assert_eq!(f32::NAN.lesser(2.0), 2.0);
        assert_eq!(f32::NAN.greater(2.0), 2.0);
        assert_eq!(1.0f32.lesser(2.0), 1.0);
        assert_eq!(1.0f32.greater(2.0), 2.0);
    }
}
