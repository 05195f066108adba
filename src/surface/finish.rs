//! The first root along a ray segment with a superlinear finish: the paper's sampling to separate
//! the roots, then a bracketing method.

use super::ita::{Root, differ};
use super::real::{Mask, Real, Scalar};

/// Most parts that a segment is sampled in.
pub const MAX_PARTS: usize = 16;
/// How often a suspected pair of close roots is looked into.
const MAX_PROBES: usize = 5;
/// Most steps of the bracketing method; far fewer are ever needed.
const MAX_STEPS: usize = 60;

/// An interval with values of different sign at its ends.
#[derive(Clone, Copy)]
struct Bracket<V: Real> {
    from: V,
    to: V,
    at_from: V,
    at_to: V,
    found: V::Mask,
}

impl<V: Real> Bracket<V> {
    #[inline(always)]
    fn replace(&mut self, mask: V::Mask, from: (V, V), to: (V, V)) {
        self.from = V::select(mask, from.0, self.from);
        self.at_from = V::select(mask, from.1, self.at_from);
        self.to = V::select(mask, to.0, self.to);
        self.at_to = V::select(mask, to.1, self.at_to);
        self.found = self.found | mask;
    }
}

/// The first root within [0, length], to within `tolerance` of the parameter.
///
/// Samples `parts` equal parts; where three consecutive samples of one sign lie on a parabola that
/// comes near to zero, it looks there, which finds the two close roots of a grazing ray.
#[inline(always)]
pub(super) fn first_root<V: Real>(
    mut f: impl FnMut(V) -> V,
    length: V,
    tolerance: V,
    alive: V::Mask,
    parts: usize,
) -> Root<V> {
    debug_assert!((2..=MAX_PARTS).contains(&parts));
    let part = length * V::constant(1.0 / parts as f64);
    let at = |n: usize| part * V::constant(n as f64);
    let zero = V::constant(0.0);
    let mut values = [zero; MAX_PARTS + 1];
    for (n, value) in values.iter_mut().enumerate().take(parts + 1) {
        *value = f(at(n));
    }
    let mut bracket =
        Bracket { from: zero, to: length, at_from: zero, at_to: zero, found: V::Mask::splat(false) };
    for n in (0..parts).rev() {
        let change = differ(values[n], values[n + 1]);
        bracket.replace(change, (at(n), values[n]), (at(n + 1), values[n + 1]));
    }
    probe_minima(&mut f, &values[..=parts], part, alive, &mut bracket);
    let found = bracket.found & alive;
    Root { at: chandrupatla(f, bracket, tolerance, found), found }
}

/// Looks between the samples before the bracket for a change of sign that they miss.
#[inline(always)]
fn probe_minima<V: Real>(
    f: &mut impl FnMut(V) -> V,
    values: &[V],
    part: V,
    alive: V::Mask,
    bracket: &mut Bracket<V>,
) {
    let (zero, half, one) = (V::constant(0.0), V::constant(0.5), V::constant(1.0));
    let mut least = values[0].abs();
    for value in &values[1..] {
        least = least.lesser(value.abs());
    }
    let mut settled = V::Mask::splat(false);
    let mut probes = 0;
    for (n, three) in values.windows(3).enumerate() {
        let [l, m, r] = [three[0], three[1], three[2]];
        let middle = part * V::constant((n + 1) as f64);
        let changes = differ(l, m) | differ(m, r);
        // Only what lies before the first change of sign matters: after it the first root is known.
        settled = settled | changes;
        let bend = l - m - m + r;
        let slope = (r - l) * half;
        let curved = zero.less(bend.abs());
        let vertex = V::select(curved, -slope, zero) / V::select(curved, bend, one);
        let lowest = m + vertex * slope * half;
        let inside = vertex.abs().at_most(one);
        let promising = lowest.abs().less(least * half) | differ(lowest, m);
        let look = alive & !settled & curved & inside & promising;
        if probes == MAX_PROBES || !look.any() {
            continue;
        }
        probes += 1;
        let place = middle + vertex * part;
        let value = f(place);
        let crossed = look & differ(value, m);
        let right = zero.less(vertex);
        let from = V::select(right, middle, middle - part);
        let at_from = V::select(right, m, l);
        bracket.replace(crossed, (from, at_from), (place, value));
        settled = settled | crossed;
    }
}

/// Chandrupatla's method: inverse quadratic interpolation where that is safe, else bisection; the
/// bracket never widens. The first guess is the secant's.
#[inline(always)]
fn chandrupatla<V: Real>(
    mut f: impl FnMut(V) -> V,
    bracket: Bracket<V>,
    tolerance: V,
    found: V::Mask,
) -> V {
    let (zero, half, one) = (V::constant(0.0), V::constant(0.5), V::constant(1.0));
    let (mut a, mut b) = (bracket.from, bracket.to);
    let (mut fa, mut fb) = (bracket.at_from, bracket.at_to);
    let mut active = found;
    let mut best = V::select(fa.abs().less(fb.abs()), a, b);
    let drop = fa - fb;
    let safe = zero.less(drop.abs());
    let mut share = V::select(safe, fa, zero) / V::select(safe, drop, one);
    for _ in 0..MAX_STEPS {
        let width = (b - a).abs();
        let margin = tolerance / V::select(zero.less(width), width, one);
        active = active & zero.less(width) & margin.less(half);
        if !active.any() {
            break;
        }
        let share_in = share.greater(margin).lesser(one - margin);
        let place = a + (b - a) * share_in;
        let value = f(place);
        let same = !differ(value, fa);
        let (c, fc) = (V::select(same, a, b), V::select(same, fa, fb));
        b = V::select(active, V::select(same, b, a), b);
        fb = V::select(active, V::select(same, fb, fa), fb);
        a = V::select(active, place, a);
        fa = V::select(active, value, fa);
        best = V::select(active, V::select(fa.abs().less(fb.abs()), a, b), best);
        active = active & zero.less(value.abs());
        share = next_share(a, b, c, fa, fb, fc);
    }
    best
}

/// Where between `a` and `b` to look next, as a share from `a`; `c` is the point left behind.
#[inline(always)]
fn next_share<V: Real>(a: V, b: V, c: V, fa: V, fb: V, fc: V) -> V {
    let (zero, half, one) = (V::constant(0.0), V::constant(0.5), V::constant(1.0));
    let divide = |value: V, by: V| {
        let usable = zero.less(by.abs());
        V::select(usable, value, zero) / V::select(usable, by, one)
    };
    let xi = divide(a - b, c - b);
    let phi = divide(fa - fb, fc - fb);
    let rest = one - phi;
    let quadratic = (phi * phi).less(xi) & (rest * rest).less(one - xi);
    let by_b = divide(fa, fb - fa) * divide(fc, fb - fc);
    let by_c = divide(c - a, b - a) * divide(fa, fc - fa) * divide(fb, fc - fb);
    V::select(quadratic, by_b + by_c, half)
}

/// The tolerance at which a root along a segment is as good as the precision allows: `speed` is
/// the direction's length in units of the patch, `start` the segment's place on the ray.
#[inline(always)]
pub(super) fn tolerance<V: Real>(speed: V, start: V) -> V {
    let epsilon = V::splat(V::Scalar::EPSILON);
    epsilon / speed + epsilon * V::constant(0.25) * start.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(f: impl FnMut(f64) -> f64, parts: usize) -> Root<f64> {
        first_root(f, 1.0, 1e-14, true, parts)
    }

    #[test]
    fn the_first_of_several_roots_is_found_to_all_digits() {
        for parts in [4, 8, 16] {
            let root = solve(|x| (x - 0.3) * (x - 0.55) * (x - 0.9), parts);
            assert!(root.found && (root.at - 0.3).abs() < 1e-13, "{parts}: {}", root.at);
        }
    }

    #[test]
    fn two_close_roots_between_samples_are_found() {
        let root = solve(|x| (x - 0.4) * (x - 0.401), 8);
        assert!(root.found && (root.at - 0.4).abs() < 1e-12, "{}", root.at);
    }

    #[test]
    fn no_root_is_a_miss_and_a_dead_lane_stays_dead() {
        assert!(!solve(|x| x * x - x + 0.3, 8).found);
        assert!(!first_root(|x: f64| x - 0.5, 1.0, 1e-14, false, 8).found);
    }

    #[test]
    fn it_ends_within_few_evaluations() {
        let mut calls = 0;
        let root = solve(
            |x| {
                calls += 1;
                (x * 3.0).sin() - 0.5
            },
            8,
        );
        assert!(root.found && ((root.at * 3.0).sin() - 0.5).abs() < 1e-13);
        assert!(calls <= 9 + 7, "{calls}");
    }
}
