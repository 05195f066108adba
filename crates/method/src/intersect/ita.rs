//! The paper's iterative algorithm (ITA, section 4.4): the first root of a function along a ray
//! segment, a fixed number of binary digits of it.

use super::root::{Root, Samples, differ};
use crate::numbers::Real;

/// `bits` binary digits of the first root within [0, length], `step` digits at a time.
///
/// Each step samples the ends of `2^step` equal parts and goes on in the first part with a change
/// of sign (the paper's case 2); where there is none, next to the least absolute value, on the
/// side where the neighbour's is less (case 1), which finds the two close roots of a grazing ray.
/// No change of sign after the last step is a miss.
///
/// `sampler` may know the function at the ends of all parts of a step, of its start and the width of a
/// part; they are then not evaluated one by one.
#[inline(always)]
pub(crate) fn first_root<V: Real>(
    mut f: impl FnMut(V, V::Mask) -> V,
    sampler: impl Fn(V, V) -> Option<Samples<V>>,
    length: V,
    alive: V::Mask,
    bits: u32,
    step: u32,
) -> Root<V> {
    let parts = 1u32 << step;
    let share = length.constant(1.0 / f64::from(parts));
    let (mut start, mut width) = (length.zero(), length);
    let (mut left, mut right) = (f(start, alive), f(start + width, alive));
    let mut found = length.mask(false);
    for _ in 0..bits.div_ceil(step) {
        let part = width * share;
        let samples = sampler(start, part);
        let mut scan = Scan::new(start, left);
        for n in 1..=parts {
            let at = start + part * part.constant(f64::from(n));
            let value = match &samples {
                _ if n == parts => right,
                Some(samples) => samples[n as usize],
                None => f(at, alive),
            };
            scan.next(at, value);
        }
        (start, left, right, found) = scan.chosen();
        width = part;
    }
    let (zero, one) = (length.zero(), length.one());
    let drop = left - right;
    let moves = zero.less(drop.abs());
    let share = V::select(moves, left, zero) / V::select(moves, drop, one);
    Root {
        at: start + width * share,
        found: found & alive,
        value: left.abs().lesser(right.abs()),
        width,
    }
}

/// One pass over the samples of a step.
struct Scan<V: Real> {
    previous: (V, V),
    /// First part with a change of sign: its start and the values at its ends.
    change: (V, V, V),
    changed: V::Mask,
    /// The part next to the least absolute value: its start, the values at its ends.
    near: (V, V, V),
    least: V,
    /// Whether the sample just before was the least, so that the part after it may be the one.
    fresh: V::Mask,
    before: V,
}

impl<V: Real> Scan<V> {
    #[inline(always)]
    fn new(at: V, value: V) -> Self {
        Self {
            previous: (at, value),
            change: (at, value, value),
            changed: value.mask(false),
            near: (at, value, value),
            least: value.abs(),
            fresh: value.mask(true),
            before: value.constant(f64::INFINITY),
        }
    }

    #[inline(always)]
    fn next(&mut self, at: V, value: V) {
        let (from, last) = self.previous;
        let first = differ(last, value) & !self.changed;
        self.change = select3(first, (from, last, value), self.change);
        self.changed = self.changed | first;
        // The part after the least sample, if its far end is nearer to zero than the near part's.
        let after = self.fresh & value.abs().less(self.before);
        self.near = select3(after, (from, last, value), self.near);
        let lower = value.abs().less(self.least);
        self.near = select3(lower, (from, last, value), self.near);
        self.before = V::select(lower, last.abs(), self.before);
        self.least = V::select(lower, value.abs(), self.least);
        self.fresh = lower;
        self.previous = (at, value);
    }

    #[inline(always)]
    fn chosen(self) -> (V, V, V, V::Mask) {
        let (start, left, right) = select3(self.changed, self.change, self.near);
        (start, left, right, self.changed)
    }
}

#[inline(always)]
fn select3<V: Real>(mask: V::Mask, yes: (V, V, V), no: (V, V, V)) -> (V, V, V) {
    (
        V::select(mask, yes.0, no.0),
        V::select(mask, yes.1, no.1),
        V::select(mask, yes.2, no.2),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(f: impl Fn(f64) -> f64, step: u32) -> Root<f64> {
        first_root(|at, _| f(at), |_, _| None, 1.0, true, 24, step)
    }

    #[test]
    fn the_first_of_several_roots_is_found() {
        for step in 1..=4 {
            let root = solve(|x| (x - 0.3) * (x - 0.55) * (x - 0.9), step);
            assert!(root.found, "step {step}");
            if step > 1 {
                assert!((root.at - 0.3).abs() < 1e-7, "step {step}: {}", root.at);
            }
        }
    }

    #[test]
    fn two_close_roots_of_a_grazing_ray_are_found() {
        for step in 1..=4 {
            let root = solve(|x| (x - 0.4) * (x - 0.4001), step);
            assert!(root.found, "step {step}");
            assert!((root.at - 0.4).abs() < 2e-4, "step {step}: {}", root.at);
        }
    }

    #[test]
    fn no_root_is_a_miss() {
        assert!(!solve(|x| x * x - x + 0.3, 3).found);
    }
}
