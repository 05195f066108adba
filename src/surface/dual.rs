//! Values with their partial derivatives, so that tangents and normals come from the very source
//! that computes the surface.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::real::{Jet, Real};

/// A value and its `N` partial derivatives (forward mode).
#[derive(Clone, Copy, Debug)]
pub struct Dual<V, const N: usize> {
    /// The value.
    pub value: V,
    /// Its partial derivatives.
    pub parts: [V; N],
}

impl<V: Real, const N: usize> Dual<V, N> {
    /// The `index`-th independent variable.
    #[inline(always)]
    pub fn variable(value: V, index: usize) -> Self {
        let mut parts = [value.constant(0.0); N];
        parts[index] = value.constant(1.0);
        Self { value, parts }
    }

    #[inline(always)]
    fn with(value: V, part: impl Fn(usize) -> V) -> Self {
        let mut parts = [value; N];
        for (n, slot) in parts.iter_mut().enumerate() {
            *slot = part(n);
        }
        Self { value, parts }
    }
}

impl<V: Real, const N: usize> Add for Dual<V, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::with(
            self.value + other.value,
            #[inline(always)]
            |n| self.parts[n] + other.parts[n],
        )
    }
}

impl<V: Real, const N: usize> Sub for Dual<V, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::with(
            self.value - other.value,
            #[inline(always)]
            |n| self.parts[n] - other.parts[n],
        )
    }
}

impl<V: Real, const N: usize> Mul for Dual<V, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::with(
            self.value * other.value,
            #[inline(always)]
            |n| self.parts[n] * other.value + self.value * other.parts[n],
        )
    }
}

impl<V: Real, const N: usize> Div for Dual<V, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = other.value.constant(1.0) / other.value;
        let value = self.value * inverse;
        Self::with(
            value,
            #[inline(always)]
            |n| (self.parts[n] - value * other.parts[n]) * inverse,
        )
    }
}

impl<V: Real, const N: usize> Neg for Dual<V, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::with(
            -self.value,
            #[inline(always)]
            |n| -self.parts[n],
        )
    }
}

impl<V: Real, const N: usize> Jet<V> for Dual<V, N> {
    #[inline(always)]
    fn lift(value: V) -> Self {
        Self {
            value,
            parts: [value.constant(0.0); N],
        }
    }
    #[inline(always)]
    fn value(self) -> V {
        self.value
    }
    #[inline(always)]
    fn times(self, factor: V) -> Self {
        Self::with(
            self.value * factor,
            #[inline(always)]
            |n| self.parts[n] * factor,
        )
    }
    #[inline(always)]
    fn plus(self, term: V) -> Self {
        Self {
            value: self.value + term,
            ..self
        }
    }
    #[inline(always)]
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        Self::with(
            V::select(mask, yes.value, no.value),
            #[inline(always)]
            |n| V::select(mask, yes.parts[n], no.parts[n]),
        )
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let (zero, half) = (self.value.constant(0.0), self.value.constant(0.5));
        let root = Real::sqrt(self.value);
        let slope = V::select(zero.less(root), half / root, zero);
        Self::with(
            root,
            #[inline(always)]
            |n| self.parts[n] * slope,
        )
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let (zero, one) = (self.value.constant(0.0), self.value.constant(1.0));
        let square = self.value * self.value + x.value * x.value;
        let inverse = V::select(zero.less(square), one / square, zero);
        Self::with(
            Real::atan2(self.value, x.value),
            #[inline(always)]
            |n| (x.value * self.parts[n] - self.value * x.parts[n]) * inverse,
        )
    }
}

/// The greater of a jet and a constant.
#[inline(always)]
pub(super) fn at_least<V: Real, T: Jet<V>>(jet: T, floor: V) -> T {
    T::select(jet.value().less(floor), T::lift(floor), jet)
}

/// The lesser of a jet and a constant.
#[inline(always)]
pub(super) fn capped<V: Real, T: Jet<V>>(jet: T, cap: V) -> T {
    T::select(cap.less(jet.value()), T::lift(cap), jet)
}

/// The lesser of two jets.
#[inline(always)]
pub(super) fn lesser<V: Real, T: Jet<V>>(a: T, b: T) -> T {
    T::select(a.value().less(b.value()), a, b)
}

/// `value / divisor`, and zero where the divisor is too small to divide by.
#[inline(always)]
pub(super) fn ratio_or_zero<V: Real, T: Jet<V>>(value: T, divisor: T, tiny: V) -> T {
    let usable = tiny.less(divisor.value());
    let zero = T::lift(tiny.constant(0.0));
    let one = T::lift(tiny.constant(1.0));
    T::select(usable, value, zero) / T::select(usable, divisor, one)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expression<T: Jet<f64>>(x: T, y: T) -> T {
        (x * y).plus(3.0).sqrt() / y.atan2(x) - (-x).times(0.5)
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (x, y, step) = (0.7, 1.3, 1e-6);
        let dual: Dual<f64, 2> = expression(Dual::variable(x, 0), Dual::variable(y, 1));
        assert_eq!(dual.value, expression(x, y));
        let dx = (expression(x + step, y) - expression(x - step, y)) / (2.0 * step);
        let dy = (expression(x, y + step) - expression(x, y - step)) / (2.0 * step);
        assert!((dual.parts[0] - dx).abs() < 1e-8, "{} {dx}", dual.parts[0]);
        assert!((dual.parts[1] - dy).abs() < 1e-8, "{} {dy}", dual.parts[1]);
    }

    #[test]
    fn a_ratio_by_almost_nothing_is_zero() {
        assert_eq!(ratio_or_zero(1.0f32, 1e-35, 1e-30), 0.0);
        assert_eq!(ratio_or_zero(1.0f32, 2.0, 1e-30), 0.5);
    }
}
