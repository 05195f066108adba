//! Numbers that may carry derivatives: the arithmetic that heights are written in.

use super::scalar::{Arithmetic, Real};

/// A [`Real`] that may carry partial derivatives.
///
/// Comparisons look at the value alone, and a `select` takes the chosen side's derivatives with
/// it: the derivative of the branch the value lies on.
pub trait Jet<V: Real>: Arithmetic {
    /// A value whose derivatives are zero.
    fn lift(value: V) -> Self;
    /// The value without derivatives.
    fn value(self) -> V;
    /// The product with a constant.
    fn times(self, factor: V) -> Self;
    /// The sum with a constant.
    fn plus(self, term: V) -> Self;
    /// The product with a constant and a sum.
    fn times_add(self, factor: V, term: Self) -> Self;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self;
    /// The sum of three [near roots](Quadratic::near_root), each times its weight.
    fn near_roots(weights: [Self; 3], of: [Quadratic<Self>; 3]) -> Self;
    /// The angle of the point `(x, self)`; its derivative is zero at the origin.
    fn atan2(self, x: Self) -> Self;
}

impl<V: Real> Jet<V> for V {
    #[inline(always)]
    fn lift(value: V) -> Self {
        value
    }
    #[inline(always)]
    fn value(self) -> V {
        self
    }
    #[inline(always)]
    fn times(self, factor: V) -> Self {
        self * factor
    }
    #[inline(always)]
    fn plus(self, term: V) -> Self {
        self + term
    }
    #[inline(always)]
    fn times_add(self, factor: V, term: V) -> Self {
        self.mul_add(factor, term)
    }
    #[inline(always)]
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        <V as Real>::select(mask, yes, no)
    }
    #[inline(always)]
    fn near_roots(weights: [Self; 3], of: [Quadratic<Self>; 3]) -> Self {
        let parts = three!(|i| {
            let [dividend, divisor] = of[i].fraction();
            [weights[i] * dividend, divisor]
        });
        // One division in place of three.
        let [[p, a], [q, b], [r, c]] = parts;
        let sum = p.mul_add(b, q * a).mul_add(c, r * (a * b));
        sum / (a * b * c)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        Real::atan2(self, x)
    }
}

/// A divisor below this counts as none: it belongs to a point at a vertex, where what is divided vanishes faster.
pub(crate) const TINY: f64 = 1e-30;

/// `a t^2 - 2 half_b t + c`.
#[derive(Clone, Copy)]
pub struct Quadratic<T> {
    /// Factor of the square.
    pub a: T,
    /// Minus half the factor of `t`.
    pub half_b: T,
    /// The value at zero.
    pub c: T,
}

impl<V: Real> Quadratic<V> {
    /// Half the distance between the roots, times `a`; zero where there are none.
    #[inline(always)]
    pub(crate) fn root(&self) -> V {
        let square = self.half_b.mul_sub(self.half_b, self.a * self.c);
        square.greater(square.zero()).sqrt()
    }

    /// The root that vanishes with `c`.
    #[inline(always)]
    pub(crate) fn near_root(&self) -> V {
        let [dividend, divisor] = self.fraction();
        dividend / divisor
    }

    /// What it is the quotient of.
    #[inline(always)]
    fn fraction(&self) -> [V; 2] {
        let (zero, one) = (self.c.zero(), self.c.one());
        let divisor = self.half_b + self.root();
        let usable = zero.constant(TINY).less(divisor);
        [
            V::select(usable, self.c, zero),
            V::select(usable, divisor, one),
        ]
    }
}

/// The greater of a jet and a constant.
#[inline(always)]
pub(crate) fn at_least<V: Real, T: Jet<V>>(jet: T, floor: V) -> T {
    T::select(jet.value().less(floor), T::lift(floor), jet)
}

/// The lesser of a jet and a constant.
#[inline(always)]
pub(crate) fn capped<V: Real, T: Jet<V>>(jet: T, cap: V) -> T {
    T::select(cap.less(jet.value()), T::lift(cap), jet)
}

/// The lesser of two jets.
#[inline(always)]
pub(crate) fn lesser<V: Real, T: Jet<V>>(a: T, b: T) -> T {
    T::select(a.value().less(b.value()), a, b)
}

/// `value / divisor`, and zero where the divisor is too small to divide by.
#[inline(always)]
pub(crate) fn ratio_or_zero<V: Real, T: Jet<V>>(value: T, divisor: T, tiny: V) -> T {
    let usable = tiny.less(divisor.value());
    let zero = T::lift(tiny.zero());
    let one = T::lift(tiny.one());
    T::select(usable, value, zero) / T::select(usable, divisor, one)
}
