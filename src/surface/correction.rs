//! Fits the cross-side correction: on each side both neighbours turn their surfaces to one tangent
//! plane, which they both know without knowing each other.
//!
//! At the share `lambda` along a side the common normal is `(1 - lambda) n_i + lambda n_j`, made
//! perpendicular to the side's curve. The slope that brings the uncorrected surface there is
//! sampled at three places and interpolated by a quadratic: the slope over `lambda (1 - lambda)`
//! where it vanishes at both ends, without the factor of an end that is loose. See the method's notes in
//! ARCHITECTURE.md.

use super::choice::Choice;
use super::dual::Dual;
use super::flags::PatchFlags;
use super::patch::{Patch, next};
use super::real::{Constant, Jet, Real, inlined};
use super::vector::vector;

/// Where along a side the slope is sampled.
const SAMPLES: [f64; 3] = [0.2, 0.5, 0.8];
/// Greatest slope the correction adds across a side.
const MAX_TURN: f64 = 0.5;
/// Cosine of the steepest vertex normal to the plane's: below the first a correction does more
/// harm than good, from the second on it is taken in full.
const STEEP: [f64; 2] = [0.3, 0.5];
/// Twice the area over the square of the longest side: below the first the slopes drown in
/// rounding, from the second on they are taken in full.
const THIN: [f64; 2] = [3e-3, 1e-2];

/// Sets the correction of every curved side.
#[inline(always)]
pub(super) fn fit<S: Constant>(patch: &mut Patch<S>, flags: PatchFlags) {
    let strength = strength(patch);
    // Loops, so that what is inlined is there once.
    for k in 0..3 {
        if flags.is_straight(k) {
            continue;
        }
        let [first, second] = patch.sides[k].loose;
        let mut slopes = [strength; 3];
        for (to, at) in slopes.iter_mut().zip(SAMPLES) {
            let at_first = if first { at } else { 1.0 };
            let at_second = if second { 1.0 - at } else { 1.0 };
            let kept = strength.constant(at_first * at_second);
            *to = slope(patch, k, strength.constant(at)) * strength * kept;
        }
        patch.sides[k].correction = quadratic(slopes);
    }
}

/// 1 for ordinary triangles, fading to 0 where they are very steep or very thin.
#[inline(always)]
fn strength<S: Constant>(patch: &Patch<S>) -> S {
    let [a, b, c] = &patch.vertices;
    let [p, q, r] = &patch.sides;
    let fade = inlined(
        #[inline(always)]
        |value: S, [from, to]: [f64; 2]| {
            let share = (value - value.constant(from)) * value.constant(1.0 / (to - from));
            share
                .greater(value.constant(0.0))
                .lesser(value.constant(1.0))
        },
    );
    let steepest = a.normal.lesser(b.normal).lesser(c.normal);
    let longest2 = p.length2.greater(q.length2).greater(r.length2);
    fade(steepest, STEEP) * fade(patch.area2 / longest2, THIN)
}

/// The bubble's slope `nu` at the share `along` of side `k`.
#[inline(always)]
fn slope<S: Constant>(patch: &Patch<S>, k: usize, along: S) -> S {
    let (zero, one) = (along.constant(0.0), along.constant(1.0));
    let side = &patch.sides[k];
    let length = Real::sqrt(side.length2);
    // The surface as a function of x along the side and y inward.
    let x = Dual::<S, 2>::variable(along * length, 0);
    let y = Dual::<S, 2>::variable(zero, 1);
    let constant = Dual::<S, 2>::lift;
    let b_m = y * constant(one / side.height);
    let b_j = x * constant(one / length) - b_m * constant(side.foot);
    let mut b = [constant(zero); 3];
    b[k] = constant(one) - b_j - b_m;
    b[next(k)] = b_j;
    b[next(next(k))] = b_m;
    let foot = patch.foot_in::<S, _>(b, Choice::only(along, k));
    let h = patch.uncorrected(&foot);
    // In the frame (along, inward, up): r = (x, y + lean h, h).
    let out = foot.lean * h;
    let tangent = vector(one, out.parts[0], h.parts[0]);
    let inward = vector(zero, one + out.parts[1], h.parts[1]);
    let (first, second) = (&patch.vertices[k], &patch.vertices[next(k)]);
    let mix = inlined(
        #[inline(always)]
        |a: S, b: S| a * (one - along) + b * along,
    );
    let half = along.constant(0.5) / length;
    let normal = vector(
        mix(side.bend[0] * half, -(side.bend[1] * half)),
        mix(first.inward[k], second.inward[k]),
        mix(first.normal, second.normal),
    );
    let normal = normal - tangent * (normal.dot(tangent) / tangent.dot(tangent));
    let guide = vector(zero, foot.lean.value, one);
    let most = along.constant(MAX_TURN);
    let delta = -(inward.dot(normal) / guide.dot(normal));
    let delta = delta.greater(-most).lesser(most);
    delta * side.height / (along * (one - along))
}

/// Coefficients of the quadratic through the three sampled values.
#[inline(always)]
fn quadratic<S: Real>(values: [S; 3]) -> [S; 3] {
    let [l, m, r] = SAMPLES;
    let step = m - l;
    debug_assert!((r - m - step).abs() < 1e-12);
    let scale = inlined(
        #[inline(always)]
        |x: f64| values[0].constant(x),
    );
    let second = (values[0] - values[1] - values[1] + values[2]) * scale(0.5 / (step * step));
    let first = (values[2] - values[0]) * scale(0.5 / step);
    // value + first (x - m) + second (x - m)^2
    [
        values[1] - first * scale(m) + second * scale(m * m),
        first - second * scale(2.0 * m),
        second,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadratic_goes_through_its_samples() {
        let values = [0.3f64, -1.2, 2.5];
        let [c0, c1, c2] = quadratic(values);
        for (at, value) in SAMPLES.into_iter().zip(values) {
            assert!((c0 + at * (c1 + at * c2) - value).abs() < 1e-12);
        }
    }
}
