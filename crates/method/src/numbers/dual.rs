//! Values with their partial derivatives, so that tangents and normals come from the very source
//! that computes the surface.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::jet::{Jet, Quadratic, TINY};
use super::scalar::{Arithmetic, Real, sealed};

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
        let mut parts = [value.zero(); N];
        parts[index] = value.one();
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
            |n| self.parts[n].mul_add(other.value, self.value * other.parts[n]),
        )
    }
}

impl<V: Real, const N: usize> Div for Dual<V, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = other.value.one() / other.value;
        let value = self.value * inverse;
        Self::with(
            value,
            #[inline(always)]
            |n| self.parts[n].less_product(value, other.parts[n]) * inverse,
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

impl<V: Real, const N: usize> sealed::Sealed for Dual<V, N> {}

impl<V: Real, const N: usize> Arithmetic for Dual<V, N> {
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self::with(
            self.value.mul_add(factor.value, term.value),
            #[inline(always)]
            |n| {
                let of_factor = self.value.mul_add(factor.parts[n], term.parts[n]);
                self.parts[n].mul_add(factor.value, of_factor)
            },
        )
    }
}

impl<V: Real, const N: usize> Jet<V> for Dual<V, N> {
    #[inline(always)]
    fn lift(value: V) -> Self {
        Self {
            value,
            parts: [value.zero(); N],
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
    fn times_add(self, factor: V, term: Self) -> Self {
        Self::with(
            self.value.mul_add(factor, term.value),
            #[inline(always)]
            |n| self.parts[n].mul_add(factor, term.parts[n]),
        )
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
    fn near_roots(weights: [Self; 3], of: [Quadratic<Self>; 3]) -> Self {
        let [first, second, third] = three!(|i| near_root(of[i]));
        let rest = weights[1].mul_add(second, weights[2] * third);
        weights[0].mul_add(first, rest)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let (zero, one) = (self.value.zero(), self.value.one());
        let square = self.value.mul_add(self.value, x.value * x.value);
        let inverse = V::select(zero.less(square), one / square, zero);
        Self::with(
            Real::atan2(self.value, x.value),
            #[inline(always)]
            |n| x.value.mul_sub(self.parts[n], self.value * x.parts[n]) * inverse,
        )
    }
}

/// The root of a quadratic that vanishes with `c`. The equation itself says how it changes with its factors.
#[inline(always)]
fn near_root<V: Real, const N: usize>(of: Quadratic<Dual<V, N>>) -> Dual<V, N> {
    let Quadratic { a, half_b, c } = of;
    let (zero, one) = (a.value.zero(), a.value.one());
    let values = Quadratic {
        a: a.value,
        half_b: half_b.value,
        c: c.value,
    };
    let root = values.root();
    let sum = half_b.value + root;
    let turns = zero.less(root);
    let twice = V::select(turns, root + root, one);
    // One division for both.
    let product = sum * twice;
    let usable = zero.constant(TINY).less(product);
    let inverse = V::select(usable, one, zero) / V::select(usable, product, one);
    let at = c.value * (twice * inverse);
    let per_twice = V::select(turns, sum * inverse, zero);
    let (square, double) = (at * at, at + at);
    Dual::with(
        at,
        #[inline(always)]
        |n| {
            let change = c.parts[n].less_product(half_b.parts[n], double);
            a.parts[n].mul_add(square, change) * per_twice
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::ratio_or_zero;

    fn expression<T: Jet<f64>>(x: T, y: T) -> T {
        let of = |shift: f64| Quadratic {
            a: (x * y).times(shift),
            half_b: y.plus(3.0),
            c: x.times_add(0.5, y),
        };
        let roots = T::near_roots([x, y, x - y], [of(1.0), of(-0.4), of(0.0)]);
        roots.mul_add(x, y.plus(3.0)) / y.atan2(x) - (-x).times(0.5)
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (x, y, step) = (0.7, 1.3, 1e-6);
        let dual: Dual<f64, 2> = expression(Dual::variable(x, 0), Dual::variable(y, 1));
        // Of a number alone the roots share a division.
        assert!((dual.value - expression(x, y)).abs() < 1e-14);
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
