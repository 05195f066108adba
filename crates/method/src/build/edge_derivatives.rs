//! The surface at an edge, before its correction: its height and how that changes, by hand, since it
//! is computed nine times a patch. Dual numbers say the same, in the tests.
//!
//! The variables are the share `s` along the edge and the opposite vertex's coordinate `w`; the
//! edge's own vertices have `1 - s - (1 - foot) w` and `s - foot w`. Where w = 0
//! - the lean is the edge's, all along, and inward it falls as the ramp says;
//! - the opposite vertex's sphere has the weight w, so that only its parameter counts;
//! - the spheres of the edge's vertices meet the guide where `c g^2 t^2 - 2 (n.g - c d.g) t + o = 0`: c the
//!   curvature, g the guide, d the way from the vertex, o the damped offset over its square. There
//!   `d.g` is zero, and along the edge only o changes. The equation itself says how t does.

use crate::evaluate::Curvature;
use crate::numbers::{Constant, Quadratic, Real, inlined};
use crate::patch::{Patch, Rule, next};

/// The surface at a place on an edge.
pub(crate) struct Place<S> {
    /// The height along the guide.
    pub height: S,
    /// How the height changes with the share along the edge ...
    pub along: S,
    /// ... and with the opposite vertex's coordinate.
    pub across: S,
    /// How the lean does.
    pub lean_across: S,
}

/// What the places on an edge have in common.
pub(crate) struct EdgeDerivatives<'a, S: Constant> {
    patch: &'a Patch<S>,
    k: usize,
    ends: [End<S>; 2],
    per_length2: S,
    /// The guide's square.
    guide2: S,
    /// One over the ramp is the greater of these, each over the share from its end.
    per_ramp: [S; 2],
}

/// One of an edge's two vertices.
struct End<S> {
    /// The edge's bend there.
    bend: S,
    /// Normal times guide.
    normal_guide: S,
    /// Normal times the edge's inward perpendicular, times the lean.
    leaning: S,
    /// How the curvature changes with w, times the edge's squared length and the share from here.
    twist: S,
    /// What the offset changes with w besides.
    skew: S,
    /// How the damping factor changes with w, as the share of the other end.
    damping: S,
}

/// A place on an edge, as the sphere of either end sees it.
struct Damped<S> {
    /// `s (1 - s)`.
    bubble: S,
    /// The damping factor, which an edge alone holds above its floor.
    factor: S,
    /// How it changes with w.
    factor_across: S,
    /// How it changes along the edge, times the bubble.
    along: S,
    /// One over the ramp.
    per_ramp: S,
}

/// The guide's parameter on a sphere, and how it changes.
struct SphereRoot<S> {
    at: S,
    along: S,
    across: S,
}

impl<S: Constant> End<S> {
    /// The first or the second vertex of edge `k`.
    #[inline(always)]
    fn new(patch: &Patch<S>, k: usize, second: bool) -> Self {
        let edge = &patch.edges[k];
        let (after, before) = (next(k), next(next(k)));
        // The vertex's other edge, its bend there, and the edge opposite to it.
        let (vertex, bend, foot, other, other_bend, opposite) = if second {
            let other = &patch.edges[after];
            let foot = edge.foot.one() - edge.foot;
            (after, edge.bend[1], foot, other, other.bend[0], before)
        } else {
            let other = &patch.edges[before];
            (k, edge.bend[0], edge.foot, other, other.bend[1], after)
        };
        let vertex = &patch.vertices[vertex];
        let leaning = vertex.inward[k] * edge.lean;
        let twist = match patch.rule {
            Rule::Angular => {
                let change = other_bend / other.length2 - bend / edge.length2;
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
            damping: foot * edge.damping - other.damping,
        }
    }
}

impl<'a, S: Constant> EdgeDerivatives<'a, S> {
    #[inline(always)]
    pub fn new(patch: &'a Patch<S>, k: usize) -> Self {
        let edge = &patch.edges[k];
        let (one, two) = (edge.foot.one(), edge.foot.two());
        Self {
            patch,
            k,
            ends: [End::new(patch, k, false), End::new(patch, k, true)],
            per_length2: one / edge.length2,
            guide2: edge.lean * edge.lean + one,
            // One over `rise`.
            per_ramp: [
                S::select(edge.obtuse, one, one + edge.foot),
                S::select(edge.obtuse, one, two - edge.foot),
            ],
        }
    }

    /// The surface at a share of the edge's length from its first vertex.
    #[inline(always)]
    pub fn at(&self, share: f64) -> Place<S> {
        let edge = &self.patch.edges[self.k];
        let lanes = edge.lean;
        let rest = 1.0 - share;
        let mix = inlined(
            #[inline(always)]
            |a: S, b: S| a * lanes.constant(rest) + b * lanes.constant(share),
        );
        let [first, second] = &self.ends;
        let bubble = lanes.constant(share * rest);
        let factor = lanes.one() - edge.damping * bubble;
        let from_first = self.per_ramp[0] * lanes.constant(1.0 / share);
        let from_second = self.per_ramp[1] * lanes.constant(1.0 / rest);
        let place = Damped {
            bubble,
            factor,
            factor_across: mix(first.damping, second.damping),
            along: lanes.constant(rest - share) * (factor - edge.damping * bubble),
            per_ramp: from_first.greater(from_second),
        };
        let (p, q) = (
            self.meet(first, share, &place),
            self.meet(second, rest, &place),
        );
        let shift = p.at + (q.at - p.at) * edge.foot;
        Place {
            height: mix(p.at, q.at),
            along: q.at - p.at + mix(p.along, q.along),
            across: self.opposite(share, &place) - shift + mix(p.across, q.across),
            lean_across: -(edge.lean * place.per_ramp),
        }
    }

    /// Where the guide meets the sphere of an end, the place's share of the edge's length away.
    #[inline(always)]
    fn meet(&self, end: &End<S>, share: f64, place: &Damped<S>) -> SphereRoot<S> {
        let edge = &self.patch.edges[self.k];
        let lanes = end.bend;
        let (zero, one) = (lanes.zero(), lanes.one());
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
        let usable = lanes.constant(1e-30).less(product);
        let inverse = S::select(usable, one, zero) / S::select(usable, product, one);
        let at = c * (twice * inverse);
        let per_twice = sum * inverse;
        let lean2 = edge.lean * edge.lean;
        let a_across = end.twist * self.per_length2 * self.guide2 * lanes.constant(1.0 / share)
            - (curvature + curvature) * lean2 * place.per_ramp;
        let b_across = -(end.leaning * place.per_ramp + curvature * (edge.lean * edge.height));
        let c_across = (end.twist * lanes.constant(share) + end.skew) * place.factor
            - end.bend * (place.bubble * place.factor_across);
        SphereRoot {
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
        let (edge, vertex) = (&patch.edges[k], &patch.vertices[before]);
        let (s, rest) = (edge.foot.constant(share), edge.foot.constant(1.0 - share));
        let beside = s - edge.foot;
        let distance2 = beside * beside * edge.length2 + edge.height * edge.height;
        let curvature = match patch.rule {
            Rule::Angular => {
                let mut b = [s.zero(); 3];
                (b[k], b[after]) = (rest, s);
                patch.angular(before, b, distance2)
            }
            _ => {
                let offset = -(patch.mean_bend(k) * place.bubble);
                let chord = patch.edges[before].bend[0] * rest + patch.edges[after].bend[1] * s;
                Curvature {
                    times_distance2: chord + offset,
                    offset,
                }
            }
        };
        let normal_guide = vertex.normal + vertex.inward[k] * edge.lean;
        let of = Quadratic {
            a: curvature.times_distance2 * self.guide2,
            half_b: distance2 * normal_guide
                + curvature.times_distance2 * (edge.lean * edge.height),
            c: distance2 * curvature.offset * place.factor,
        };
        of.near_root()
    }
}
