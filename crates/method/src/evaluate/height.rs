//! The height of the surface over a plane point, along the guide: equation (33) over the spheres
//! of the three vertices.

use super::guide::Foot;
use crate::numbers::{Constant, Jet, Quadratic, Real, at_least, capped, inlined, ratio_or_zero};
use crate::patch::{Patch, Rule, next};

/// The damping factor's floor: where three edges disagree strongly it would turn negative. An edge
/// alone takes it down to 0.1 at most, so that no edge's slope hangs on which of two equals wins.
pub(crate) const MIN_DAMPING_FACTOR: f64 = 0.09;

/// Where `b1 b2 + b2 b3 + b3 b1` is below the first, outside the triangle, there is no correction;
/// beyond ten times that it is whole.
const FADE_END: f64 = 2e-4;
const FADE_RATE: f64 = 1.0 / (9.0 * FADE_END);

/// What a curvature rule says at a vertex about a plane point at `d` from it.
pub(crate) struct Curvature<T> {
    /// The curvature times the squared distance.
    pub times_distance2: T,
    /// `c |d|^2 - 2 n.d`: how far the plane point is from the vertex's sphere, before damping.
    pub offset: T,
}

impl<S: Constant> Patch<S> {
    /// The surface's height along the guide over the foot, in units of the patch's size.
    #[inline(always)]
    pub(crate) fn height<V: Real<Scalar = S>, T: Jet<V>>(&self, foot: &Foot<V, T>) -> T {
        let h = self.uncorrected(foot);
        match self.rule {
            Rule::Flat => h,
            _ => h + self.correction(foot.b),
        }
    }

    /// The height without the cross-edge correction.
    #[inline(always)]
    pub(crate) fn uncorrected<V: Real<Scalar = S>, T: Jet<V>>(&self, foot: &Foot<V, T>) -> T {
        let lanes = foot.lean.value();
        if self.rule == Rule::Flat {
            return T::lift(lanes.zero());
        }
        let b = foot.b;
        let damping = self.damping_factor(b);
        let guide2 = foot.lean.mul_add(foot.lean, T::lift(lanes.one()));
        let height = foot.choice.constant(|k| self.edges[k].height);
        let up = foot.choice.pick([b[2], b[0], b[1]]).times(height);
        let spheres = three!(|i| self.on_sphere(i, foot, damping, guide2, up, height));
        T::near_roots(b, spheres)
    }

    /// What vanishes where the guide line meets the sphere of vertex `i`: its root near the plane is the line's
    /// parameter there. Everything is multiplied by `|d|^2`, so that nothing divides at the vertex.
    #[inline(always)]
    fn on_sphere<V: Real<Scalar = S>, T: Jet<V>>(
        &self,
        i: usize,
        foot: &Foot<V, T>,
        damping: T,
        guide2: T,
        up: T,
        height: V,
    ) -> Quadratic<T> {
        let (j, k) = (next(i), next(next(i)));
        let lanes = height;
        let (b_j, b_k) = (foot.b[j], foot.b[k]);
        let vertex = &self.vertices[i];
        let length2 = inlined(
            #[inline(always)]
            |edge: usize| lanes.splat(self.edges[edge].length2),
        );
        let between = (b_j * b_k).times(lanes.splat(vertex.between + vertex.between));
        let distance2 =
            (b_j * b_j).times_add(length2(i), (b_k * b_k).times_add(length2(k), between));
        let curvature = match self.rule {
            Rule::Angular => self.angular(i, foot.b, distance2),
            _ => self.tensor(i, foot.b),
        };
        let normal_guide = foot.lean.times_add(
            foot.choice.constant(|edge| vertex.inward[edge]),
            T::lift(lanes.splat(vertex.normal)),
        );
        // Of the way from the vertex only the part along the lean meets the guide.
        let opposite = V::select(foot.choice.is(j), height, lanes.zero());
        let way_guide = foot.lean * up.plus(-opposite);
        let a = curvature.times_distance2 * guide2;
        let half_b = distance2.mul_sub(normal_guide, curvature.times_distance2 * way_guide);
        let c = distance2 * curvature.offset * damping;
        Quadratic { a, half_b, c }
    }

    /// The paper's rule (19): curvature by the angle at the vertex.
    #[inline(always)]
    pub(crate) fn angular<V: Real<Scalar = S>, T: Jet<V>>(
        &self,
        i: usize,
        b: [T; 3],
        distance2: T,
    ) -> Curvature<T> {
        let (j, k) = (next(i), next(next(i)));
        let (to_j, to_k) = (&self.edges[i], &self.edges[k]);
        let lanes = distance2.value();
        let sideways = b[j].times(lanes.splat(self.area2));
        let ahead = b[k].times(lanes.splat(to_k.length2))
            + b[j].times(lanes.splat(self.vertices[i].between));
        let share = sideways
            .atan2(ahead)
            .times(lanes.splat(self.vertices[i].inverse_angle));
        let (at_j, at_k) = (to_j.bend[0] / to_j.length2, to_k.bend[1] / to_k.length2);
        let c = share
            .times(lanes.splat(at_j - at_k))
            .plus(lanes.splat(at_k));
        let times_distance2 = c * distance2;
        let tangential =
            b[j].times(lanes.splat(to_j.bend[0])) + b[k].times(lanes.splat(to_k.bend[1]));
        Curvature {
            times_distance2,
            offset: times_distance2 - tangential,
        }
    }

    /// Curvature as the quadratic form that the three edges determine.
    #[inline(always)]
    fn tensor<V: Real<Scalar = S>, T: Jet<V>>(&self, i: usize, b: [T; 3]) -> Curvature<T> {
        let (j, k) = (next(i), next(next(i)));
        let (bend_j, bend_k) = (self.edges[i].bend[0], self.edges[k].bend[1]);
        let across = self.mean_bend(j);
        let lanes = b[0].value();
        let (b_ij, b_ik, b_jk) = (b[i] * b[j], b[i] * b[k], b[j] * b[k]);
        let mixed = b_jk.times(lanes.splat(bend_j + bend_k - across));
        let times_distance2 = (b[j] * b[j]).times_add(
            lanes.splat(bend_j),
            (b[k] * b[k]).times_add(lanes.splat(bend_k), mixed),
        );
        let opposite = b_jk.times(lanes.splat(across));
        let offset = -b_ij.times_add(
            lanes.splat(bend_j),
            b_ik.times_add(lanes.splat(bend_k), opposite),
        );
        Curvature {
            times_distance2,
            offset,
        }
    }

    /// `1 - 4 (kappa_12 b1 b2 + ...)`, held above a floor: 1 at the vertices.
    #[inline(always)]
    fn damping_factor<V: Real<Scalar = S>, T: Jet<V>>(&self, b: [T; 3]) -> T {
        let lanes = b[0].value();
        let damping = inlined(
            #[inline(always)]
            |k: usize, rest: T| {
                (b[k] * b[next(k)]).times_add(lanes.splat(-self.edges[k].damping), rest)
            },
        );
        let factor = damping(0, damping(1, damping(2, T::lift(lanes.one()))));
        at_least(factor, lanes.constant(MIN_DAMPING_FACTOR))
    }

    /// The cross-edge correction: a cubic bubble that turns the surface about each edge.
    #[inline(always)]
    fn correction<V: Real<Scalar = S>, T: Jet<V>>(&self, b: [T; 3]) -> T {
        let lanes = b[0].value();
        let (zero, one) = (lanes.zero(), lanes.one());
        let weights = three!(|k| b[k] * b[next(k)]);
        let [first, second, third] = three!(|k| {
            let edge = &self.edges[k];
            let free = b[next(next(k))].times_add(lanes.splat(edge.foot), b[next(k)]);
            let along = capped(at_least(free, zero), one);
            let [c0, c1, c2] = three!(|n| lanes.splat(edge.correction[n]));
            let mut slope = along.mul_add(along.times_add(c2, T::lift(c1)), T::lift(c0));
            if self.any_loose {
                slope = slope / loosened(edge.loose, free, b[k], b[next(k)]);
            }
            slope
        });
        let sum = weights[0].mul_add(first, weights[1].mul_add(second, weights[2] * third));
        let share = weights[0] + weights[1] + weights[2];
        let bubble = weights[0] * b[2];
        // Outside a vertex the weights' sum can vanish, so there the correction fades out.
        let least = b[0].value().lesser(b[1].value()).lesser(b[2].value());
        let inside = zero.at_most(least);
        let near = share
            .plus(lanes.constant(-FADE_END))
            .times(lanes.constant(FADE_RATE));
        let fade = T::select(inside, T::lift(one), capped(at_least(near, zero), one));
        ratio_or_zero(bubble * sum * fade, share, lanes.constant(1e-20))
    }
}

/// What an edge's slope is divided by for its loose ends: the shares `along` and `1 - along`, held
/// up where the triangle reaches beyond the edge's ends.
#[inline(always)]
fn loosened<V: Real, T: Jet<V>>(loose: [bool; 2], along: T, b_i: T, b_j: T) -> T {
    let lanes = along.value();
    let (half, tiny) = (lanes.half(), lanes.constant(1e-6));
    let one = T::lift(lanes.one());
    let first = if loose[0] {
        held(along, b_j, half, tiny)
    } else {
        one
    };
    let second = if loose[1] {
        held(one - along, b_i, half, tiny)
    } else {
        one
    };
    first * second
}

/// A share, held off zero by a part of the coordinate it stands for: above it in the triangle. Outside, where
/// neighbours overlap, the share may have changed its sign with the coordinate; then it is held below, so
/// that the surface goes on as it was.
#[inline(always)]
fn held<V: Real, T: Jet<V>>(share: T, b: T, part: V, tiny: V) -> T {
    let zero = tiny.zero();
    let outside = b.value().less(zero);
    let least = at_least(T::select(outside, -b, b).times(part), tiny);
    let below = outside & share.value().less(zero);
    let size = T::select(below, -share, share);
    let size = T::select(size.value().less(least.value()), least, size);
    T::select(below, -size, size)
}
