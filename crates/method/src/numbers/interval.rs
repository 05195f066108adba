//! Ranges of values, for bounds.

use super::scalar::Real;

/// Closed range of values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval<V> {
    pub lo: V,
    pub hi: V,
}

impl<V: Real> Interval<V> {
    #[inline(always)]
    pub fn of(value: V) -> Self {
        Self {
            lo: value,
            hi: value,
        }
    }
    /// Zero alone.
    #[inline(always)]
    pub fn zero(lanes: V) -> Self {
        Self::of(lanes.zero())
    }
    #[inline(always)]
    pub fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        Self {
            lo: V::select(mask, yes.lo, no.lo),
            hi: V::select(mask, yes.hi, no.hi),
        }
    }
    #[inline(always)]
    pub fn between(a: V, b: V) -> Self {
        Self {
            lo: a.lesser(b),
            hi: a.greater(b),
        }
    }
    #[inline(always)]
    pub fn hull(self, other: Self) -> Self {
        Self {
            lo: self.lo.lesser(other.lo),
            hi: self.hi.greater(other.hi),
        }
    }
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self {
            lo: self.lo + other.lo,
            hi: self.hi + other.hi,
        }
    }
    #[inline(always)]
    pub fn scaled(self, factor: V) -> Self {
        Self::between(self.lo * factor, self.hi * factor)
    }
    #[inline(always)]
    pub fn times(self, other: Self) -> Self {
        self.scaled(other.lo).hull(self.scaled(other.hi))
    }
    #[inline(always)]
    pub fn widened(self, by: V) -> Self {
        Self {
            lo: self.lo - by,
            hi: self.hi + by,
        }
    }
    #[inline(always)]
    pub fn max_abs(self) -> V {
        self.lo.abs().greater(self.hi.abs())
    }
}
