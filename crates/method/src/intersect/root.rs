//! Roots along a segment, and samples that they are looked for between.

use crate::numbers::Real;

/// Where a function changes sign first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root<V: Real> {
    /// The root, in the segment's parameter; undefined where none was found.
    pub at: V,
    /// Whether one was found.
    pub found: V::Mask,
    /// The lesser of the absolute values at the two ends of the last interval: not near zero where
    /// the function jumps past it.
    pub value: V,
    /// Width of the last interval.
    pub width: V,
}

/// Whether the two values lie on different sides of zero, which counts as positive.
#[inline(always)]
pub(crate) fn differ<V: Real>(a: V, b: V) -> V::Mask {
    let zero = a.zero();
    let (a, b) = (a.less(zero), b.less(zero));
    (a & !b) | (!a & b)
}

/// Most parts that a segment is sampled in.
pub const MAX_PARTS: usize = 16;

/// The values at the ends of all parts.
pub(crate) type Samples<V> = [V; MAX_PARTS + 1];

/// Equal steps along a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steps<V> {
    /// Where the first part begins, in the segment's parameter.
    pub start: V,
    /// Width of a part.
    pub part: V,
    /// How many there are, up to [`MAX_PARTS`].
    pub parts: usize,
}
