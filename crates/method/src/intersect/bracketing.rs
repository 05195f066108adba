//! The first root along a ray segment with a superlinear finish: the paper's sampling to separate
//! the roots, then a bracketing method.

use super::root::{MAX_PARTS, Root, Samples, differ};
use crate::numbers::{Mask, Real, inlined};

/// How often a suspected pair of close roots is looked into.
const MAX_PROBES: f64 = 8.0;
/// A place is worth a look where a parabola comes down to this share of the least sample there.
const PROMISE: f64 = 1.0;
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

/// The first root within [0, length], to within `tolerance` of the parameter or to where the
/// function is within `noise` of zero.
///
/// Samples up to `parts` equal parts; where three consecutive samples of one sign lie on a parabola
/// that comes near to zero, it looks there, which finds the two close roots of a grazing ray. Where
/// there is none, an end counts as one at which the function is as near to zero as `ends` say. `f`
/// is given the lanes whose value matters. `samples` are its values at the parts' ends where those
/// are known already.
#[inline(always)]
pub(crate) fn first_root<V: Real>(
    mut f: impl FnMut(V, V::Mask) -> V,
    length: V,
    [tolerance, noise]: [V; 2],
    ends: [V; 2],
    alive: V::Mask,
    parts: usize,
    samples: Option<&Samples<V>>,
) -> Root<V> {
    debug_assert!((2..=MAX_PARTS).contains(&parts));
    let zero = length.zero();
    let part = length * length.constant(1.0 / parts as f64);
    let mut bracket = Bracket {
        from: zero,
        to: length,
        at_from: zero,
        at_to: zero,
        found: length.mask(false),
    };
    let mut probes = zero;
    let first = match samples {
        Some(known) => known[0],
        None => f(zero, alive),
    };
    let mut left = (zero, first);
    let mut middle = left;
    for n in 1..=parts {
        let seeking = alive & !bracket.found;
        if !seeking.any() {
            break;
        }
        let place = part * part.constant(n as f64);
        let value = match samples {
            Some(known) => known[n],
            None => f(place, seeking),
        };
        let right = (place, value);
        let change = seeking & differ(middle.1, right.1);
        bracket.replace(change, middle, right);
        if n > 1 {
            let dip = Dip {
                left,
                middle,
                right,
            };
            probe_minimum(&mut f, dip, seeking & !change, &mut probes, &mut bracket);
        }
        (left, middle) = (middle, right);
    }
    let found = bracket.found;
    let mut root = chandrupatla(f, bracket, [tolerance, noise], found);
    for ((at, value), tolerance) in [(zero, first), middle].into_iter().zip(ends) {
        root.or_end(at, value.abs(), alive & value.abs().at_most(tolerance));
    }
    root
}

impl<V: Real> Root<V> {
    /// Makes an end of the segment the root, of those lanes that have none.
    #[inline(always)]
    fn or_end(&mut self, at: V, value: V, here: V::Mask) {
        let here = here & !self.found;
        self.at = V::select(here, at, self.at);
        self.value = V::select(here, value, self.value);
        self.width = V::select(here, at.zero(), self.width);
        self.found = self.found | here;
    }
}

/// Looks between three consecutive samples of one sign for a change of sign that they miss: a
/// parabola through them says where the function comes nearest to zero, and each look there makes
/// the next parabola narrower.
#[inline(always)]
fn probe_minimum<V: Real>(
    f: &mut impl FnMut(V, V::Mask) -> V,
    mut dip: Dip<V>,
    mut look: V::Mask,
    probes: &mut V,
    bracket: &mut Bracket<V>,
) {
    let (one, most) = (probes.one(), probes.constant(MAX_PROBES));
    loop {
        let (place, promising) = dip.lowest();
        look = look & promising & probes.less(most);
        if !look.any() {
            break;
        }
        *probes = V::select(look, *probes + one, *probes);
        let probe = (place, f(place, look));
        let crossed = look & differ(probe.1, dip.middle.1);
        bracket.replace(crossed, dip.before(place), probe);
        look = look & !crossed;
        dip.narrow(probe);
    }
}

/// Three places with values of one sign, in order.
struct Dip<V> {
    left: (V, V),
    middle: (V, V),
    right: (V, V),
}

impl<V: Real> Dip<V> {
    /// Where the parabola through the three comes nearest to zero, and whether it is worth a look.
    #[inline(always)]
    fn lowest(&self) -> (V, V::Mask) {
        let lanes = self.middle.0;
        let (zero, one) = (lanes.zero(), lanes.one());
        let (to_left, to_right) = (self.left.0 - self.middle.0, self.right.0 - self.middle.0);
        let (rise_left, rise_right) = (self.left.1 - self.middle.1, self.right.1 - self.middle.1);
        // middle + slope x + bend x^2 in the distance x from the middle, times a common divisor.
        let divisor = to_left * to_right * (to_left - to_right);
        let bend = rise_left * to_right - rise_right * to_left;
        let slope = rise_right * to_left * to_left - rise_left * to_right * to_right;
        let curved = zero.less(bend.abs()) & zero.less(divisor.abs());
        let x = V::select(curved, -slope, zero) / V::select(curved, bend + bend, one);
        let value = self.middle.1 + x * lanes.half() * slope / V::select(curved, divisor, one);
        let inside = to_left.less(x) & x.less(to_right);
        let least = self
            .left
            .1
            .abs()
            .lesser(self.middle.1.abs())
            .lesser(self.right.1.abs());
        let nears =
            value.abs().less(least * lanes.constant(PROMISE)) | differ(value, self.middle.1);
        (self.middle.0 + x, curved & inside & nears)
    }

    /// The last of the three before a place.
    #[inline(always)]
    fn before(&self, place: V) -> (V, V) {
        let after = self.middle.0.less(place);
        pair(after, self.middle, self.left)
    }

    /// The three around the least of the four that a further place makes.
    #[inline(always)]
    fn narrow(&mut self, probe: (V, V)) {
        let after = self.middle.0.less(probe.0);
        let lower = probe.1.abs().less(self.middle.1.abs());
        let (first, second) = (
            pair(after, self.middle, probe),
            pair(after, probe, self.middle),
        );
        // In order: left, first, second, right. The middle one is the lower of the inner two.
        let keep_second = (after & lower) | (!after & !lower);
        self.left = pair(keep_second, first, self.left);
        self.right = pair(keep_second, self.right, second);
        self.middle = pair(keep_second, second, first);
    }
}

#[inline(always)]
fn pair<V: Real>(mask: V::Mask, yes: (V, V), no: (V, V)) -> (V, V) {
    (V::select(mask, yes.0, no.0), V::select(mask, yes.1, no.1))
}

/// Chandrupatla's method: inverse quadratic interpolation where that is safe, else bisection; the
/// bracket never widens. The first guess is the secant's.
#[inline(always)]
fn chandrupatla<V: Real>(
    mut f: impl FnMut(V, V::Mask) -> V,
    bracket: Bracket<V>,
    [tolerance, noise]: [V; 2],
    found: V::Mask,
) -> Root<V> {
    let lanes = tolerance;
    let (zero, half, one) = (lanes.zero(), lanes.half(), lanes.one());
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
        let value = f(place, active);
        let same = !differ(value, fa);
        let (c, fc) = (V::select(same, a, b), V::select(same, fa, fb));
        b = V::select(active, V::select(same, b, a), b);
        fb = V::select(active, V::select(same, fb, fa), fb);
        a = V::select(active, place, a);
        fa = V::select(active, value, fa);
        best = V::select(active, V::select(fa.abs().less(fb.abs()), a, b), best);
        active = active & noise.less(value.abs());
        share = next_share(a, b, c, fa, fb, fc);
    }
    Root {
        at: best,
        found,
        value: fa.abs().lesser(fb.abs()),
        width: (b - a).abs(),
    }
}

/// Where between `a` and `b` to look next, as a share from `a`; `c` is the point left behind.
#[inline(always)]
fn next_share<V: Real>(a: V, b: V, c: V, fa: V, fb: V, fc: V) -> V {
    let (zero, half, one) = (a.zero(), a.half(), a.one());
    let divide = inlined(
        #[inline(always)]
        |value: V, by: V| {
            let usable = zero.less(by.abs());
            V::select(usable, value, zero) / V::select(usable, by, one)
        },
    );
    let xi = divide(a - b, c - b);
    let phi = divide(fa - fb, fc - fb);
    let rest = one - phi;
    let quadratic = (phi * phi).less(xi) & (rest * rest).less(one - xi);
    let by_b = divide(fa, fb - fa) * divide(fc, fb - fc);
    let by_c = divide(c - a, b - a) * divide(fa, fc - fa) * divide(fb, fc - fb);
    V::select(quadratic, by_b + by_c, half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(mut f: impl FnMut(f64) -> f64, parts: usize) -> Root<f64> {
        first_root(
            |at, _| f(at),
            1.0,
            [1e-14, 0.0],
            [-1.0; 2],
            true,
            parts,
            None,
        )
    }

    #[test]
    fn the_first_of_several_roots_is_found_to_all_digits() {
        for parts in [4, 8, 16] {
            let root = solve(|x| (x - 0.3) * (x - 0.55) * (x - 0.9), parts);
            assert!(
                root.found && (root.at - 0.3).abs() < 1e-13,
                "{parts}: {}",
                root.at
            );
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
        assert!(
            !first_root(
                |x: f64, _| x - 0.5,
                1.0,
                [1e-14, 0.0],
                [1.0; 2],
                false,
                8,
                None
            )
            .found
        );
    }

    #[test]
    fn an_end_is_a_root_where_it_is_near_enough_to_one_and_there_is_no_other() {
        let root = |ends, shift: f64| {
            let f = |x: f64, _| x + shift;
            first_root(f, 1.0, [1e-14, 0.0], ends, true, 8, None)
        };
        let places = [0.01, -1.01, -0.5].map(|shift| root([0.02; 2], shift));
        assert!(places.iter().all(|root| root.found));
        assert_eq!(
            places.map(|root| (root.at * 10.0).round()),
            [0.0, 10.0, 5.0]
        );
        assert!(!root([-1.0, 0.02], 0.01).found && !root([0.02, -1.0], -1.01).found);
        assert!(!root([0.02; 2], 0.03).found);
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
