//! Fits the cross-edge correction: on each edge both neighbours turn their surfaces to one tangent
//! plane, which they both know without knowing each other.
//!
//! At the share `lambda` along an edge the common normal is `(1 - lambda) n_i + lambda n_j`, made
//! perpendicular to the edge's curve. The slope that brings the uncorrected surface there is
//! sampled at three places and interpolated by a quadratic: the slope over `lambda (1 - lambda)`
//! where it vanishes at both ends, without the factor of an end that is loose. See the method's notes in
//! ARCHITECTURE.md.

use super::edge_derivatives::EdgeDerivatives;
use crate::numbers::{Constant, Real, inlined};
use crate::patch::{Patch, PatchFlags, next};

/// Where along an edge the slope is sampled.
const SAMPLES: [f64; 3] = [0.2, 0.5, 0.8];
/// Greatest slope the correction adds across an edge.
const MAX_TURN: f64 = 0.5;
/// Cosine of the steepest vertex normal to the plane's: below the first a correction does more
/// harm than good, from the second on it is taken in full.
const STEEP: [f64; 2] = [0.3, 0.5];
/// Twice the area over the square of the longest edge: below the first the slopes drown in
/// rounding, from the second on they are taken in full.
const THIN: [f64; 2] = [3e-3, 1e-2];

/// Sets the correction of every curved edge.
#[inline(always)]
pub(crate) fn fit<S: Constant>(patch: &mut Patch<S>, flags: PatchFlags) {
    let strength = strength(patch);
    // A loop, so that what is inlined is there once.
    for k in 0..3 {
        if flags.is_straight(k) {
            continue;
        }
        let [first, second] = patch.edges[k].loose;
        let rim = EdgeDerivatives::new(patch, k);
        // The places next to each other, so that none waits for another's roots.
        let slopes = three!(|n| {
            let at = SAMPLES[n];
            let at_first = if first { 1.0 } else { at };
            let at_second = if second { 1.0 } else { 1.0 - at };
            let scale = strength.constant(1.0 / (at_first * at_second));
            slope(patch, &rim, k, at) * strength * scale
        });
        patch.edges[k].correction = quadratic(slopes);
    }
}

/// 1 for ordinary triangles, fading to 0 where they are very steep or very thin.
#[inline(always)]
fn strength<S: Constant>(patch: &Patch<S>) -> S {
    let [a, b, c] = &patch.vertices;
    let [p, q, r] = &patch.edges;
    let fade = inlined(
        #[inline(always)]
        |value: S, [from, to]: [f64; 2]| {
            let share = (value - value.constant(from)) * value.constant(1.0 / (to - from));
            share.greater(value.zero()).lesser(value.one())
        },
    );
    let steepest = a.normal.lesser(b.normal).lesser(c.normal);
    let longest2 = p.length2.greater(q.length2).greater(r.length2);
    fade(steepest, STEEP) * fade(patch.area2 / longest2, THIN)
}

/// The bubble's slope `nu` at a share of edge `k`, times `share (1 - share)`.
#[inline(always)]
fn slope<S: Constant>(patch: &Patch<S>, rim: &EdgeDerivatives<S>, k: usize, share: f64) -> S {
    let edge = &patch.edges[k];
    let lanes = edge.lean;
    let surface = rim.at(share);
    // In the frame (along, inward, up) a point is (x, y + lean h, h). One tangent is by the share along the
    // edge, the other by the opposite vertex's coordinate.
    let tangent = [edge.lean * surface.along, surface.along];
    let across = [
        edge.height + edge.lean * surface.across + surface.lean_across * surface.height,
        surface.across,
    ];
    let (first, second) = (&patch.vertices[k], &patch.vertices[next(k)]);
    let mix = inlined(
        #[inline(always)]
        |a: S, b: S| a * lanes.constant(1.0 - share) + b * lanes.constant(share),
    );
    let normal = [
        mix(first.inward[k], second.inward[k]),
        mix(first.normal, second.normal),
    ];
    // Made perpendicular to the tangent, whose part along the edge is the edge; times its square, which
    // cancels.
    let along = mix(edge.bend[0], -edge.bend[1]) * lanes.half();
    let part = along + normal[0] * tangent[0] + normal[1] * tangent[1];
    let square = edge.length2 + tangent[0] * tangent[0] + tangent[1] * tangent[1];
    let [inward, up] = [
        normal[0] * square - tangent[0] * part,
        normal[1] * square - tangent[1] * part,
    ];
    let most = edge.height * lanes.constant(MAX_TURN);
    let turn = -((across[0] * inward + across[1] * up) / (edge.lean * inward + up));
    turn.greater(-most).lesser(most)
}

/// Coefficients of the quadratic through the three sampled values.
#[inline(always)]
fn quadratic<S: Real>(values: [S; 3]) -> [S; 3] {
    let [l, m, r] = SAMPLES;
    let step = m - l;
    debug_assert!((r - m - step).abs() < 1e-12);
    let lanes = values[0];
    let second =
        (values[0] - values[1] - values[1] + values[2]) * lanes.constant(0.5 / (step * step));
    let first = (values[2] - values[0]) * lanes.constant(0.5 / step);
    // value + first (x - m) + second (x - m)^2
    [
        values[1] - first * lanes.constant(m) + second * lanes.constant(m * m),
        first - second * lanes.constant(2.0 * m),
        second,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::{Dual, Jet, Scalar, vector};
    use crate::patch::{Choice, PatchKind, Rule, Surface};
    use crate::tests::{Random, rounded};

    #[test]
    fn the_quadratic_goes_through_its_samples() {
        let values = [0.3f64, -1.2, 2.5];
        let [c0, c1, c2] = quadratic(values);
        for (at, value) in SAMPLES.into_iter().zip(values) {
            assert!((c0 + at * (c1 + at * c2) - value).abs() < 1e-12);
        }
    }

    /// What [`slope`] does by hand.
    fn slope_by_dual(patch: &Patch<f64>, k: usize, along: f64) -> f64 {
        let edge = &patch.edges[k];
        let length = edge.length2.sqrt();
        // The surface as a function of x along the edge and y inward.
        let x = Dual::<f64, 2>::variable(along * length, 0);
        let y = Dual::<f64, 2>::variable(0.0, 1);
        let constant = Dual::<f64, 2>::lift;
        let b_m = y * constant(1.0 / edge.height);
        let b_j = x * constant(1.0 / length) - b_m * constant(edge.foot);
        let mut b = [constant(0.0); 3];
        b[k] = constant(1.0) - b_j - b_m;
        b[next(k)] = b_j;
        b[next(next(k))] = b_m;
        let foot = patch.foot_in(b, Choice::only(along, k));
        let h = patch.uncorrected(&foot);
        // In the frame (along, inward, up): r = (x, y + lean h, h).
        let out = foot.lean * h;
        let tangent = vector(1.0, out.parts[0], h.parts[0]);
        let inward = vector(0.0, 1.0 + out.parts[1], h.parts[1]);
        let (first, second) = (&patch.vertices[k], &patch.vertices[next(k)]);
        let mix = |a: f64, b: f64| a * (1.0 - along) + b * along;
        let half = 0.5 / length;
        let normal = vector(
            mix(edge.bend[0] * half, -(edge.bend[1] * half)),
            mix(first.inward[k], second.inward[k]),
            mix(first.normal, second.normal),
        );
        let normal = normal - tangent * (normal.dot(tangent) / tangent.dot(tangent));
        let guide = vector(0.0, foot.lean.value, 1.0);
        let delta = -(inward.dot(normal) / guide.dot(normal));
        delta.clamp(-MAX_TURN, MAX_TURN) * edge.height
    }

    /// The slopes at all places of all edges, over the height of the opposite vertex.
    fn turns<S: Scalar>(
        patch: &Patch<S>,
        turn: impl Fn(&Patch<S>, usize, f64) -> S,
    ) -> [[f64; 3]; 3] {
        [0, 1, 2]
            .map(|k| SAMPLES.map(|at| turn(patch, k, at).to_f64() / patch.edges[k].height.to_f64()))
    }

    fn by_hand<S: Scalar>(patch: &Patch<S>, k: usize, at: f64) -> S {
        slope(patch, &EdgeDerivatives::new(patch, k), k, at)
    }

    #[test]
    fn slopes_by_hand_are_those_by_dual_numbers() {
        let mut random = Random(41);
        let (mut obtuse, mut fallback, mut clamped) = (0, 0, 0);
        let (mut total, mut worst, mut worst_single) = (0, 0.0f64, 0.0f64);
        for n in 0..20_000 {
            let (p, normals) = random.triangle([3.0, 10.0, 25.0, 50.0][n % 4], 0.9);
            let straight = (0..3).filter(|k| n % 5 == 0 && n >> k & 1 != 0);
            let flags = PatchFlags::new(Surface::Smooth);
            let flags = straight.fold(flags, PatchFlags::with_straight);
            let patch = Patch::<f64>::new(p, normals, flags);
            let single = Patch::<f32>::new(rounded(p), rounded(normals), flags);
            let flat = matches!(patch.kind(), PatchKind::Flat(_));
            if flat || patch.kind() != single.kind() {
                continue;
            }
            obtuse += usize::from(patch.any_obtuse);
            fallback += usize::from(patch.rule == Rule::Angular);
            let expected = turns(&patch, slope_by_dual);
            let slopes = turns(&patch, by_hand);
            let in_single = turns(&single, by_hand);
            for (k, at) in (0..9).map(|place| (place / 3, place % 3)) {
                let slope = slopes[k][at];
                total += 1;
                clamped += usize::from(slope.abs() > MAX_TURN - 1e-9);
                worst = worst.max((slope - expected[k][at]).abs());
                worst_single = worst_single.max((slope - in_single[k][at]).abs());
            }
        }
        println!("{total} slopes are off by up to {worst:e}, in f32 by {worst_single:e}");
        assert!(worst < 1e-12, "{worst:e}");
        assert!(worst_single < 1e-5, "{worst_single:e}");
        assert!(obtuse > 1000 && fallback > 500, "{obtuse} {fallback}");
        assert!(
            total > 100_000 && clamped * 20 < total,
            "{clamped} of {total}"
        );
    }
}
