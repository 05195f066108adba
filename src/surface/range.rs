//! Ranges of values, for bounds.

use super::real::Scalar;

/// Closed range of values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range<S> {
    pub lo: S,
    pub hi: S,
}

impl<S: Scalar> Range<S> {
    pub fn of(value: S) -> Self {
        Self {
            lo: value,
            hi: value,
        }
    }
    pub fn zero() -> Self {
        Self::of(S::from_f64(0.0))
    }
    pub fn between(a: S, b: S) -> Self {
        Self {
            lo: a.lesser(b),
            hi: a.greater(b),
        }
    }
    pub fn hull(self, other: Self) -> Self {
        Self {
            lo: self.lo.lesser(other.lo),
            hi: self.hi.greater(other.hi),
        }
    }
    pub fn plus(self, other: Self) -> Self {
        Self {
            lo: self.lo + other.lo,
            hi: self.hi + other.hi,
        }
    }
    pub fn scaled(self, factor: S) -> Self {
        Self::between(self.lo * factor, self.hi * factor)
    }
    pub fn times(self, other: Self) -> Self {
        self.scaled(other.lo).hull(self.scaled(other.hi))
    }
    pub fn widened(self, by: S) -> Self {
        Self {
            lo: self.lo - by,
            hi: self.hi + by,
        }
    }
    pub fn max_abs(self) -> S {
        self.lo.abs().greater(self.hi.abs())
    }
}
