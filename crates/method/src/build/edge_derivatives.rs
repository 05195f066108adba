//! The surface at a side, before its correction: its height and how that changes, by hand, since it
//! is asked for nine times a patch. Dual numbers say the same, in the tests.
//!
//! The variables are the share `s` along the side and the opposite vertex's coordinate `w`; the
//! side's own vertices have `1 - s - (1 - foot) w` and `s - foot w`. Where w = 0
//! - the lean is the side's, all along, and inward it falls as the ramp says;
//! - the opposite vertex's sphere has the weight w, so that only its parameter counts;
//! - the spheres of the side's vertices are met where `c g^2 t^2 - 2 (n.g - c d.g) t + o = 0`: c the
//!   curvature, g the guide, d the way from the vertex, o the damped offset over its square. There
//!   `d.g` is zero, and along the side only o changes. The equation itself says how t does.

use crate::evaluate::Curvature;
use crate::numbers::{Constant, Quadratic, Real, inlined};
use crate::patch::{Patch, Rule, next};

/// The surface at a place on a side.
pub(crate) struct Place<S> {
    /// The height along the guide.
    pub height: S,
    /// How the height changes with the share along the side ...
    pub along: S,
    /// ... and with the opposite vertex's coordinate.
    pub across: S,
    /// How the lean does.
    pub lean_across: S,
}

/// What the places on a side have in common.
pub(crate) struct Rim<'a, S: Constant> {
    patch: &'a Patch<S>,
    k: usize,
    ends: [End<S>; 2],
    per_length2: S,
    /// The guide's square.
    guide2: S,
    /// One over the ramp is the greater of these, each over the share from its end.
    per_ramp: [S; 2],
}

/// One of a side's two vertices.
struct End<S> {
    /// The side's bend there.
    bend: S,
    /// Normal times guide.
    normal_guide: S,
    /// Normal times the side's inward perpendicular, times the lean.
    leaning: S,
    /// How the curvature changes with w, times the side's squared length and the share from here.
    twist: S,
    /// What the offset changes with w besides.
    skew: S,
    /// How the damping factor changes with w, as the share of the other end.
    damping: S,
}

/// A place on a side, as the sphere of either end sees it.
struct Damped<S> {
    /// `s (1 - s)`.
    bubble: S,
    /// The damping factor, which a side alone holds above its floor.
    factor: S,
    /// How it changes with w.
    factor_across: S,
    /// How it changes along the side, times the bubble.
    along: S,
    /// One over the ramp.
    per_ramp: S,
}

/// The guide's parameter on a sphere, and how it changes.
struct Met<S> {
    at: S,
    along: S,
    across: S,
}

impl<S: Constant> End<S> {
    /// The first or the second vertex of side `k`.
    #[inline(always)]
    fn new(patch: &Patch<S>, k: usize, second: bool) -> Self {
        let side = &patch.sides[k];
        let (after, before) = (next(k), next(next(k)));
        // The vertex's other side, its bend there, and the side opposite to it.
        let (vertex, bend, foot, other, other_bend, opposite) = if second {
            let other = &patch.sides[after];
            let foot = side.foot.constant(1.0) - side.foot;
            (after, side.bend[1], foot, other, other.bend[0], before)
        } else {
            let other = &patch.sides[before];
            (k, side.bend[0], side.foot, other, other.bend[1], after)
        };
        let vertex = &patch.vertices[vertex];
        let leaning = vertex.inward[k] * side.lean;
        let twist = match patch.rule {
            Rule::Angular => {
                let change = other_bend / other.length2 - bend / side.length2;
                patch.area2 * vertex.inverse_angle * change
            }
            _ => bend + other_bend - patch.mean_bend(opposite) - (foot + foot) * bend,
        };
        Self {
            bend,
            normal_guide: vertex.normal + leaning,
            leaning,
            twist,
            skew: foot * bend - other_bend,
            damping: foot * side.damping - other.damping,
        }
    }
}

impl<'a, S: Constant> Rim<'a, S> {
    #[inline(always)]
    pub fn new(patch: &'a Patch<S>, k: usize) -> Self {
        let side = &patch.sides[k];
        let (one, two) = (side.foot.constant(1.0), side.foot.constant(2.0));
        Self {
            patch,
            k,
            ends: [End::new(patch, k, false), End::new(patch, k, true)],
            per_length2: one / side.length2,
            guide2: side.lean * side.lean + one,
            // One over `rise`.
            per_ramp: [
                S::select(side.obtuse, one, one + side.foot),
                S::select(side.obtuse, one, two - side.foot),
            ],
        }
    }

    /// The surface at a share of the side's length from its first vertex.
    #[inline(always)]
    pub fn at(&self, share: f64) -> Place<S> {
        let side = &self.patch.sides[self.k];
        let constant = inlined(
            #[inline(always)]
            |value: f64| side.lean.constant(value),
        );
        let rest = 1.0 - share;
        let mix = inlined(
            #[inline(always)]
            |a: S, b: S| a * constant(rest) + b * constant(share),
        );
        let [first, second] = &self.ends;
        let bubble = constant(share * rest);
        let factor = constant(1.0) - side.damping * bubble;
        let from_first = self.per_ramp[0] * constant(1.0 / share);
        let from_second = self.per_ramp[1] * constant(1.0 / rest);
        let place = Damped {
            bubble,
            factor,
            factor_across: mix(first.damping, second.damping),
            along: constant(rest - share) * (factor - side.damping * bubble),
            per_ramp: from_first.greater(from_second),
        };
        let (p, q) = (
            self.meet(first, share, &place),
            self.meet(second, rest, &place),
        );
        let shift = p.at + (q.at - p.at) * side.foot;
        Place {
            height: mix(p.at, q.at),
            along: q.at - p.at + mix(p.along, q.along),
            across: self.opposite(share, &place) - shift + mix(p.across, q.across),
            lean_across: -(side.lean * place.per_ramp),
        }
    }

    /// Where the guide meets the sphere of an end, the place's share of the side's length away.
    #[inline(always)]
    fn meet(&self, end: &End<S>, share: f64, place: &Damped<S>) -> Met<S> {
        let side = &self.patch.sides[self.k];
        let constant = inlined(
            #[inline(always)]
            |value: f64| end.bend.constant(value),
        );
        let (zero, one) = (constant(0.0), constant(1.0));
        let curvature = end.bend * self.per_length2;
        // a t^2 - 2 b t + c = 0
        let a = curvature * self.guide2;
        let b = end.normal_guide;
        let c = -(end.bend * (place.bubble * place.factor));
        // The product of a and c is not positive.
        let root = Real::sqrt(b * b - a * c);
        let sum = b + root;
        let twice = root + root;
        // One division for both.
        let product = sum * twice;
        let usable = constant(1e-30).less(product);
        let inverse = S::select(usable, one, zero) / S::select(usable, product, one);
        let at = c * (twice * inverse);
        let per_twice = sum * inverse;
        let lean2 = side.lean * side.lean;
        let a_across = end.twist * self.per_length2 * self.guide2 * constant(1.0 / share)
            - (curvature + curvature) * lean2 * place.per_ramp;
        let b_across = -(end.leaning * place.per_ramp + curvature * (side.lean * side.height));
        let c_across = (end.twist * constant(share) + end.skew) * place.factor
            - end.bend * (place.bubble * place.factor_across);
        Met {
            at,
            along: -(end.bend * place.along * per_twice),
            across: ((a_across * at - b_across - b_across) * at + c_across) * per_twice,
        }
    }

    /// Where the guide meets the sphere of the opposite vertex.
    #[inline(always)]
    fn opposite(&self, share: f64, place: &Damped<S>) -> S {
        let (patch, k) = (self.patch, self.k);
        let (after, before) = (next(k), next(next(k)));
        let (side, vertex) = (&patch.sides[k], &patch.vertices[before]);
        let (s, rest) = (side.foot.constant(share), side.foot.constant(1.0 - share));
        let beside = s - side.foot;
        let distance2 = beside * beside * side.length2 + side.height * side.height;
        let curvature = match patch.rule {
            Rule::Angular => {
                let mut b = [s.constant(0.0); 3];
                (b[k], b[after]) = (rest, s);
                patch.angular(before, b, distance2)
            }
            _ => {
                let offset = -(patch.mean_bend(k) * place.bubble);
                let chord = patch.sides[before].bend[0] * rest + patch.sides[after].bend[1] * s;
                Curvature {
                    times_distance2: chord + offset,
                    offset,
                }
            }
        };
        let normal_guide = vertex.normal + vertex.inward[k] * side.lean;
        let of = Quadratic {
            a: curvature.times_distance2 * self.guide2,
            half_b: distance2 * normal_guide
                + curvature.times_distance2 * (side.lean * side.height),
            c: distance2 * curvature.offset * place.factor,
        };
        of.near_root()
    }
}
