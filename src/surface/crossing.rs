//! Steep rays: those that climb faster than the surface does anywhere, so that they cross it once at
//! most. Nothing need be sampled to separate roots then, and a good first guess is at hand: the
//! surface is near to a paraboloid through the sides' curves.

use super::patch::{Patch, next};
use super::ray::Segment;
use super::real::{Constant, Mask, Real, Scalar, each, inlined};

/// Most evaluations; a ray that needs more is searched as one that is not steep.
const MAX_STEPS: usize = 8;
/// How wrong the slope of the first guess may be, as a share of it.
const FIRST_DOUBT: f64 = 0.25;
/// The same of a secant's slope, for where the surface has a kink in its derivatives (on medians). The
/// last step, which is not checked by another evaluation, is short then: where a kink is far stronger,
/// on needles with leaning normals, it still does no harm.
const KINK: f64 = 0.016;
/// What F's second derivative may be, in units of the paraboloid's.
const BEND_ROOM: f64 = 2.0;
/// F's slope along a steep ray, in units of that of the ray's height, is held between these.
const SLOPES: [f64; 2] = [1.0 / 16.0, 8.0];

/// What became of steep rays.
#[derive(Clone, Copy)]
pub(super) struct Crossing<V: Real> {
    /// The root, in the segment's parameter.
    pub at: V,
    /// Where there is one.
    pub found: V::Mask,
    /// Where there is none. What is neither is undecided.
    pub missed: V::Mask,
}

/// A guess of a steep ray's root.
struct Guess<V> {
    at: V,
    /// F's slope there, taken positive.
    slope: V,
    /// The absolute value of F's second derivative.
    bend: V,
}

impl<S: Constant> Patch<S> {
    /// Whether a ray is steep.
    #[inline(always)]
    pub(super) fn is_steep<V: Real<Scalar = S>>(&self, segment: &Segment<V>) -> V::Mask {
        let climb = segment.z_rate * segment.z_rate;
        let least = segment.speed * segment.speed * climb.splat(self.steep);
        least.less(climb)
    }

    /// The root of the paraboloid in the surface's place.
    #[inline(always)]
    fn guess<V: Real<Scalar = S>>(&self, segment: &Segment<V>) -> Guess<V> {
        let (b, rate) = (segment.b, segment.b_rate);
        let (mut c0, mut c1) = (segment.z, segment.z_rate);
        let mut c2 = c0.constant(0.0);
        each(
            #[inline(always)]
            |k| {
                let (i, j) = (k, next(k));
                let bulge = c0.splat(self.sides[k].bulge);
                c0 = c0 - bulge * (b[i] * b[j]);
                c1 = c1 - bulge * (b[i] * rate[j] + rate[i] * b[j]);
                c2 = c2 - bulge * (rate[i] * rate[j]);
            },
        );
        // c0 + c1 t + c2 t^2, of its two roots the one where it changes as the ray's height does.
        let zero = c0.constant(0.0);
        let rising = zero.less(segment.z_rate);
        let upward = inlined(
            #[inline(always)]
            |c: V| V::select(rising, c, -c),
        );
        let [c0, c1, c2] = [upward(c0), upward(c1), upward(c2)];
        let twice = c2 + c2;
        let slope = (c1 * c1 - (twice + twice) * c0).greater(zero).sqrt();
        let sum = c1 + slope;
        let open = zero.less(sum);
        Guess {
            at: V::select(open, -(c0 + c0), zero) / V::select(open, sum, c0.constant(1.0)),
            slope,
            bend: twice.abs(),
        }
    }

    /// The one root of F along steep rays: the secant method from a good guess, held between the ends
    /// of the segment and between the places that are known to lie before and behind the root. Ends
    /// where the root is known to within `close` of the parameter, or F to be within `noise` of zero.
    #[inline(always)]
    pub(super) fn crossing<V: Real<Scalar = S>>(
        &self,
        segment: &Segment<V>,
        steep: V::Mask,
        [close, noise]: [V; 2],
        mut f: impl FnMut(V, V::Mask) -> V,
    ) -> Crossing<V> {
        let guess = self.guess(segment);
        let like = segment.length;
        let (zero, half, one) = (like.constant(0.0), like.constant(0.5), like.constant(1.0));
        let rising = zero.less(segment.z_rate);
        let climb = segment.z_rate.abs();
        let [least, most] = [
            climb * like.constant(SLOPES[0]),
            climb * like.constant(SLOPES[1]),
        ];
        let (mut lo, mut hi) = (zero, segment.length);
        let mut x = guess.at.greater(zero).lesser(hi);
        let (mut last_x, mut last) = (x, zero);
        let mut slope = guess.slope.greater(least).lesser(most);
        let mut doubt = slope * like.constant(FIRST_DOUBT);
        let mut pending = steep;
        let mut crossing = Crossing {
            at: x,
            found: like.mask(false),
            missed: like.mask(false),
        };
        for n in 0..MAX_STEPS {
            // Taken so that it rises along the ray.
            let value = f(x, pending);
            let value = V::select(rising, value, -value);
            if n > 0 {
                let run = x - last_x;
                let moved = zero.less(run.abs());
                let secant = V::select(moved, value - last, slope) / V::select(moved, run, one);
                slope = secant.greater(least).lesser(most);
                doubt =
                    slope * like.constant(KINK) + guess.bend * like.constant(BEND_ROOM) * run.abs();
            }
            let step = -(value / slope);
            let next = (x + step).greater(zero).lesser(segment.length);
            let there = value.abs().at_most(noise);
            let near = (step.abs() * doubt).at_most(close * slope);
            let before = value.less(zero);
            let (late, early) = (
                before & segment.length.at_most(x),
                !before & x.at_most(zero),
            );
            let beyond = late | early;
            let there = there
                | (late & value.abs().at_most(segment.exit_room))
                | (early & value.at_most(segment.entry_room));
            let found = pending & (there | (near & !beyond));
            crossing.at = V::select(found, V::select(there, x, next), crossing.at);
            crossing.found = crossing.found | found;
            crossing.missed = crossing.missed | (pending & beyond & !found);
            pending = pending & !found & !beyond;
            if !pending.any() {
                break;
            }
            lo = V::select(before, x, lo);
            hi = V::select(before, hi, x);
            let stuck =
                (next.at_most(lo) & zero.less(lo)) | (hi.at_most(next) & hi.less(segment.length));
            (last_x, last) = (x, value);
            x = V::select(stuck, (lo + hi) * half, next);
        }
        crossing
    }
}

/// Steepness is kept in steps of one over this.
const STEEPNESS_STEPS: f64 = 64.0;
/// Room for what the places looked at do not show.
const STEEPNESS_ROOM: f64 = 1.3;

/// How fast the surface climbs over its plane at the most, the tangent of the angle, as it is kept:
/// [`u8::MAX`] is more than can be said.
pub(super) fn steepness<S: Scalar>(least_cosine: S) -> u8 {
    let least = least_cosine.to_f64();
    let tangent = (1.0 - least * least).sqrt() / least * STEEPNESS_ROOM;
    let steps = (tangent * STEEPNESS_STEPS).ceil() + 1.0;
    // No number fails the comparison.
    if (0.0..255.0).contains(&steps) {
        steps as u8
    } else {
        u8::MAX
    }
}

/// The least cosine of the angle to its plane that the surface has where it is looked at.
#[inline(always)]
pub(super) fn least_cosine<S: Constant>(patch: &Patch<S>) -> S {
    const PLACES: [[f64; 2]; 4] = [[0.2, 0.2], [0.6, 0.2], [0.2, 0.6], [0.33, 0.34]];
    let like = patch.area2;
    let mut least = like.constant(1.0);
    for vertex in &patch.vertices {
        least = least.lesser(vertex.normal);
    }
    for [u, v] in PLACES {
        let normal = patch.normal_at(like.constant(u), like.constant(v));
        // The cosine also where it is no number.
        least = least.lesser(normal.dot(patch.normal).abs());
    }
    least
}

/// The squared sine of the angle from which on a ray is steep.
#[inline(always)]
pub(super) fn steep<S: Constant>(kept: S) -> S {
    let tangent = kept * kept.constant(1.0 / STEEPNESS_STEPS);
    let square = tangent * tangent;
    let none = kept.constant(2.0);
    let unknown = kept.constant(u8::MAX.into()).at_most(kept);
    S::select(unknown, none, square / (square + kept.constant(1.0)))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Random, V, rounded};
    use super::super::{PatchFlags, PatchKind, Ray, Solver, Surface, Vector};
    use super::*;

    /// A ray through a point near the surface.
    fn ray(random: &mut Random, patch: &Patch<f32>) -> Ray<f32> {
        let [u, v] = random.inside();
        let beside = random.direction() * (0.3 * random.unit() * f64::from(patch.size()));
        let target: V = patch.point(u as f32, v as f32).position.to_f64() + beside;
        let direction = random.direction();
        Ray {
            origin: Vector::from_f64(target - direction * 3.0),
            direction: Vector::from_f64(direction),
            tnear: 0.0,
            tfar: f32::INFINITY,
        }
    }

    #[test]
    fn steep_rays_hit_what_a_search_finds() {
        let mut random = Random(21);
        let (mut steep, mut hits, mut differ, mut evaluations) = (0, 0, 0, 0);
        for n in 0..3000 {
            let (p, normals) = random.triangle([5.0, 15.0, 30.0][n % 3], 0.6);
            let flags = PatchFlags::new(Surface::ALL[n / 3 % 3]);
            let patch = Patch::<f32>::new(rounded(p), rounded(normals), flags);
            let mut searched = patch;
            searched.set_steepness(u8::MAX);
            for _ in 0..if patch.kind() == PatchKind::Curved {
                30
            } else {
                0
            } {
                let ray = ray(&mut random, &patch);
                let interval = patch.clip(&ray, true);
                if !(interval.alive && patch.is_steep(&patch.segment(&ray, &interval))) {
                    continue;
                }
                let (hit, other) = (
                    patch.intersect(&ray, Solver::default()),
                    searched.intersect(&ray, Solver::default()),
                );
                steep += 1;
                hits += u32::from(hit.found);
                evaluations += hit.evaluations;
                let same = !hit.found || (hit.t - other.t).abs() < 2e-5;
                differ += u32::from(hit.found != other.found || !same);
            }
        }
        println!("{steep} steep rays, {hits} hits, {evaluations} evaluations, {differ} differ");
        assert!(hits > 5000 && steep - hits > 1000, "{hits} of {steep}");
        assert!(differ * 5000 < steep, "{differ} of {steep} differ");
        assert!(evaluations < 4 * steep, "{evaluations} for {steep}");
    }

    #[test]
    fn no_surface_is_steeper_than_is_kept() {
        let mut random = Random(22);
        let (mut total, mut over) = (0, 0);
        for n in 0..2000 {
            let (p, normals) = random.triangle([5.0, 15.0, 30.0, 45.0][n % 4], 0.6);
            let flags = PatchFlags::new(Surface::ALL[n / 4 % 3]);
            let patch = Patch::<f64>::new(p, normals, flags);
            let kept = steep(f64::from(patch.steepness));
            for _ in 0..if patch.kind() == PatchKind::Curved {
                30
            } else {
                0
            } {
                let [u, v] = random.inside();
                let cosine = patch.normal_at(u, v).dot(patch.normal);
                total += 1;
                over += u32::from(kept < 1.0 - cosine * cosine);
            }
        }
        println!("{over} of {total} points are steeper");
        assert!(total > 20_000 && over * 500 < total, "{over} of {total}");
    }
}
