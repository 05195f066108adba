//! Height bounds, and whether the method can take a triangle: all conservative.
//!
//! The height over a foot is `h = sum b_i C_i q_i`, where `C_i` is how far the foot is from the
//! sphere of vertex i and `q_i = 1 / (B_i + sqrt(B_i^2 - A_i C_i))`. The products `b_i C_i` are
//! cubic Bernstein forms with coefficients that follow from the edges' curvatures, and `q_i` stays
//! within a range over the triangle; so ten coefficients, each with a range, bound the height, and
//! with the control points of the plane triangle they bound the surface itself.

use crate::evaluate::MIN_DAMPING_FACTOR;
use crate::numbers::{Constant, Interval, Real, inlined};
use crate::patch::{Patch, Rule, next};

/// Least share of `n.nc` that `B` must keep for the guides to reach the spheres.
const MIN_REACH: f64 = 0.1;
/// Least `(B^2 - A C) / B^2` at which the curvature tensor is taken.
const MIN_DISCRIMINANT: f64 = 0.1;
/// Greatest bound on the height, in units of the patch's size, at which a triangle is still taken:
/// beyond it the normals contradict the triangle, and its box would cover half the scene.
const MAX_HEIGHT: f64 = 8.0;
/// The same in units of the edges' greatest bend. The angular rule blows up on needles: a little
/// angle away from a long edge it adds much of the short edge's curvature, all along the length.
const MAX_HEIGHT_TO_BEND: f64 = 8.0;

/// What bounds the heights over one vertex's sphere.
#[derive(Clone, Copy)]
struct VertexIntervals<S> {
    /// Bernstein coefficients of `C_i`: at the edge midpoints ij, ik, jk and the corners j, k.
    middles: [Interval<S>; 3],
    corners: [Interval<S>; 2],
    /// Interval of `B_i`.
    half_b: Interval<S>,
    /// Least `B_i^2 - A_i C_i`.
    discriminant: S,
    /// Interval of `q_i`.
    reach: Interval<S>,
}

/// Greatest curvature, in units of the longest edge, at which the angular rule is taken: it takes
/// the difference of two angles times this, and in `f32` the rest is rounding.
const MAX_ANGULAR_CURVATURE: f64 = 30.0;

/// The ranges of everything the heights depend on.
pub(crate) struct HeightIntervals<S: Real> {
    vertices: [VertexIntervals<S>; 3],
    damping: Interval<S>,
    /// Whether the rule is well conditioned on a triangle of this shape.
    conditioned: S::Mask,
}

/// Bounds the heights over each vertex's sphere, by the patch's present rule.
#[inline(always)]
pub(crate) fn height_intervals<S: Constant>(patch: &Patch<S>) -> HeightIntervals<S> {
    let lanes = patch.area2;
    let one = lanes.one();
    let [a, b, c] = &patch.edges;
    let damping = a.damping.greater(b.damping).greater(c.damping);
    // kappa_12 b1 b2 + kappa_23 b2 b3 + kappa_31 b3 b1 is at most a third of the greatest kappa.
    let least =
        (one - damping * lanes.constant(1.0 / 3.0)).greater(lanes.constant(MIN_DAMPING_FACTOR));
    let curvatures = three!(|i| curvature_range(patch, i));
    let mut conditioned = one.mask(true);
    if patch.rule == Rule::Angular {
        let length2 = a.length2.greater(b.length2).greater(c.length2);
        each!(|i| {
            let bent = curvatures[i].max_abs() * length2;
            conditioned = conditioned & bent.less(lanes.constant(MAX_ANGULAR_CURVATURE));
        });
    }
    HeightIntervals {
        vertices: three!(|i| vertex_intervals(patch, i, curvatures[i])),
        damping: Interval { lo: least, hi: one },
        conditioned,
    }
}

#[inline(always)]
fn vertex_intervals<S: Constant>(
    patch: &Patch<S>,
    i: usize,
    curvature: Interval<S>,
) -> VertexIntervals<S> {
    let (zero, one) = (patch.area2.zero(), patch.area2.one());
    let (middles, corners) = offset_coefficients(patch, i, curvature);
    let offset = Interval::of(zero).hull(middles[0]).hull(middles[1]);
    let offset = offset.hull(middles[2]).hull(corners[0]).hull(corners[1]);
    let (half_b, guide2) = half_b_range(patch, i, curvature);
    let product = curvature.times(guide2).times(offset);
    let low = half_b.lo.greater(zero);
    let discriminant = low * low - product.hi.greater(zero);
    let most = Real::sqrt(half_b.hi * half_b.hi - product.lo.lesser(zero));
    let reach = Interval {
        lo: one / (half_b.hi + most),
        hi: one / (low + Real::sqrt(discriminant.greater(zero))),
    };
    VertexIntervals {
        middles,
        corners,
        half_b,
        discriminant,
        reach,
    }
}

/// Ranges of `B_i = n.g - c d.g` and of `|g|^2`.
#[inline(always)]
fn half_b_range<S: Constant>(
    patch: &Patch<S>,
    i: usize,
    curvature: Interval<S>,
) -> (Interval<S>, Interval<S>) {
    let (zero, one) = (patch.area2.zero(), patch.area2.one());
    let vertex = &patch.vertices[i];
    let mut half_b = Interval::of(vertex.normal);
    let mut guide2 = Interval::of(one);
    each!(|k| {
        let edge = &patch.edges[k];
        // In the sub-triangle of edge k the guide is nc + lean (1 - s) w, and d.w is y, at most a
        // third of the height, less the vertex's own y.
        let own = if k == next(i) { edge.height } else { zero };
        let third = edge.height * one.constant(1.0 / 3.0);
        let way = Interval {
            lo: -own,
            hi: third - own,
        };
        let inward = curvature.times(way).scaled(-one);
        let inward = inward.plus(Interval::of(vertex.inward[k]));
        let leaning = Interval::between(zero, edge.lean).times(inward);
        half_b = half_b.hull(leaning.plus(Interval::of(vertex.normal)));
        guide2.hi = guide2.hi.greater(one + edge.lean * edge.lean);
    });
    (half_b, guide2)
}

/// The curvatures that occur at vertex `i`.
#[inline(always)]
fn curvature_range<S: Constant>(patch: &Patch<S>, i: usize) -> Interval<S> {
    let (j, k) = (next(i), next(next(i)));
    let (to_j, to_k) = (&patch.edges[i], &patch.edges[k]);
    let (at_j, at_k) = (to_j.bend[0] / to_j.length2, to_k.bend[1] / to_k.length2);
    let ends = Interval::between(at_j, at_k);
    if patch.rule != Rule::Tensor {
        return ends;
    }
    // c(phi) = mean + radius cos(2 (phi - phi0)) over the angle at the vertex: beside its ends it
    // has an extreme inside exactly if it falls, or rises, away from both.
    let (zero, half) = (at_j.zero(), at_j.half());
    let (length_j, length_k) = (Real::sqrt(to_j.length2), Real::sqrt(to_k.length2));
    let product = length_j * length_k;
    let (cosine, sine) = (patch.vertices[i].between / product, patch.area2 / product);
    let mixed = (to_j.bend[0] + to_k.bend[1] - patch.mean_bend(j)) * half / product;
    let away_from_k = (mixed - at_k * cosine) / sine;
    let away_from_j = (mixed - at_j * cosine) / sine;
    let perpendicular =
        (at_j - at_k * cosine * cosine - away_from_k * cosine * sine * at_j.two()) / (sine * sine);
    let mean = (at_k + perpendicular) * half;
    let difference = (at_k - perpendicular) * half;
    let radius = Real::sqrt(difference * difference + away_from_k * away_from_k);
    let rises = zero.at_most(away_from_k) & zero.at_most(away_from_j);
    let falls = away_from_k.at_most(zero) & away_from_j.at_most(zero);
    Interval {
        lo: S::select(falls, ends.lo.lesser(mean - radius), ends.lo),
        hi: S::select(rises, ends.hi.greater(mean + radius), ends.hi),
    }
}

/// Bernstein coefficients of `C_i`: see [`VertexIntervals`].
type Offsets<S> = ([Interval<S>; 3], [Interval<S>; 2]);

/// Quadratic Bernstein coefficients of `C_i`, before damping.
#[inline(always)]
fn offset_coefficients<S: Constant>(
    patch: &Patch<S>,
    i: usize,
    curvature: Interval<S>,
) -> Offsets<S> {
    let (j, k) = (next(i), next(next(i)));
    let (to_j, to_k) = (&patch.edges[i], &patch.edges[k]);
    let half = patch.area2.constant(-0.5);
    let (bend_j, bend_k) = (to_j.bend[0], to_k.bend[1]);
    let (near_j, near_k) = (Interval::of(bend_j * half), Interval::of(bend_k * half));
    if patch.rule == Rule::Tensor {
        let across = Interval::of(patch.mean_bend(j) * half);
        return ([near_j, near_k, across], [Interval::zero(half); 2]);
    }
    // C = c |d|^2 - 2 n.d with c anywhere between the two edges' curvatures.
    let between = patch.vertices[i].between;
    let anywhere = (
        [
            near_j,
            near_k,
            curvature.scaled(between).plus(near_j).plus(near_k),
        ],
        [
            curvature.scaled(to_j.length2).plus(Interval::of(-bend_j)),
            curvature.scaled(to_k.length2).plus(Interval::of(-bend_k)),
        ],
    );
    let by_angle = by_angle(patch, i);
    let width = |of: &Offsets<S>| of.0[2].max_abs() + of.1[0].max_abs() + of.1[1].max_abs();
    let narrower = width(&by_angle).less(width(&anywhere));
    let choose = |a, b| Interval::select(narrower, a, b);
    (
        three!(|n| choose(by_angle.0[n], anywhere.0[n])),
        [0, 1].map(|n| choose(by_angle.1[n], anywhere.1[n])),
    )
}

/// The same for the angular rule on thin triangles, where the direction to a point at the far end
/// of a long edge is all but that edge's own.
///
/// With u the share of the angle, `u |d|^2 = b_j l_j |d| (theta' / theta) (sin theta / sin theta')`,
/// which lies between `s b_j l_j (b_j l_j + b_k l_k cos theta)`, s being `sin theta / theta`, and
/// `b_j l_j (b_j l_j + b_k l_k)`; likewise for `1 - u`.
fn by_angle<S: Constant>(patch: &Patch<S>, i: usize) -> Offsets<S> {
    let k = next(next(i));
    let (to_j, to_k) = (&patch.edges[i], &patch.edges[k]);
    let between = patch.vertices[i].between;
    let (bend_j, bend_k) = (to_j.bend[0], to_k.bend[1]);
    let [zero, half, one] = [0.0, 0.5, 1.0].map(|value| between.constant(value));
    let product = Real::sqrt(to_j.length2 * to_k.length2);
    let least = patch.area2 / product * patch.vertices[i].inverse_angle;
    let share = Interval {
        lo: (least * between).lesser(zero),
        hi: product,
    }
    .scaled(half);
    let mixed = share
        .scaled(bend_j / to_j.length2)
        .plus(share.scaled(bend_k / to_k.length2))
        .plus(Interval::of(-(bend_j + bend_k) * half));
    let corner = |bend: S| Interval::between(bend * (least - one), zero);
    (
        [
            Interval::of(-bend_j * half),
            Interval::of(-bend_k * half),
            mixed,
        ],
        [corner(bend_j), corner(bend_k)],
    )
}

impl<S: Constant> HeightIntervals<S> {
    /// Whether the curvature tensor may be used: no guide comes near to missing a sphere.
    #[inline(always)]
    pub fn is_tame(&self) -> S::Mask {
        let share = self.damping.hi.constant(MIN_DISCRIMINANT);
        let mut tame = self.reaches();
        each!(|i| {
            let b = self.vertices[i].half_b.lo;
            tame = tame & (share * b * b).less(self.vertices[i].discriminant);
        });
        tame
    }

    /// Whether every guide meets every vertex's sphere from above (a miss by rounding is taken as
    /// a touch).
    #[inline(always)]
    pub fn reaches(&self) -> S::Mask {
        let least = self.damping.hi.constant(MIN_REACH);
        let zero = self.damping.hi.zero();
        let mut reaches = self.conditioned;
        each!(|i| {
            let vertex = &self.vertices[i];
            // Zero times what is not finite is no number.
            let finite = (vertex.reach.hi * zero).at_most(zero);
            reaches = reaches & least.less(vertex.half_b.lo) & finite;
        });
        reaches
    }
}

/// Bernstein coefficients of the height, each with its range: the three corners are zero, then
/// the edges' inner points and the centre.
pub(crate) struct HeightNet<S> {
    /// `[near first, near second]` of each edge.
    pub edges: [[Interval<S>; 2]; 3],
    pub centre: Interval<S>,
}

impl<S: Constant> HeightNet<S> {
    /// Without the correction.
    #[inline(always)]
    pub fn new(patch: &Patch<S>, intervals: &HeightIntervals<S>) -> Self {
        let third = patch.area2.constant(1.0 / 3.0);
        let reach = three!(|i| intervals.vertices[i].reach.times(intervals.damping));
        let middle = inlined(
            #[inline(always)]
            |i: usize, at: usize| intervals.vertices[i].middles[at].times(reach[i]),
        );
        let corner = inlined(
            #[inline(always)]
            |i: usize, at: usize| intervals.vertices[i].corners[at].times(reach[i]),
        );
        let edges = three!(|k| {
            let (i, j) = (k, next(k));
            // b_i^2 b_j: twice from vertex i's middle, once from vertex j's corner at i.
            let near_first = middle(i, 0).plus(middle(i, 0)).plus(corner(j, 1));
            let near_second = middle(j, 1).plus(middle(j, 1)).plus(corner(i, 0));
            [near_first.scaled(third), near_second.scaled(third)]
        });
        let across = middle(0, 2).plus(middle(1, 2)).plus(middle(2, 2));
        Self {
            edges,
            centre: across.scaled(third),
        }
    }

    /// With the patch's correction.
    #[inline(always)]
    pub fn corrected(self, patch: &Patch<S>) -> Self {
        let lanes = patch.area2;
        let loose = loose_reach(patch) * lanes.constant(1.0 / 9.0);
        let widened = inlined(
            #[inline(always)]
            |[first, second]: [Interval<S>; 2]| [first.widened(loose), second.widened(loose)],
        );
        let [a, b, c] = self.edges;
        let turned = correction_range(patch).scaled(lanes.constant(1.0 / 6.0));
        Self {
            edges: [widened(a), widened(b), widened(c)],
            centre: self.centre.plus(turned),
        }
    }

    /// The range of all heights.
    #[inline(always)]
    fn hull(&self) -> Interval<S> {
        let mut hull = Interval::zero(self.centre.lo);
        each!(|k| hull = hull.hull(self.edges[k][0]).hull(self.edges[k][1]));
        hull.hull(self.centre)
    }

    /// Whether the heights stay within what a triangle of this size, with edges that bend this
    /// much, may stand for.
    #[inline(always)]
    pub fn is_low(&self, patch: &Patch<S>) -> S::Mask {
        let lanes = patch.area2;
        let mut bend = lanes.zero();
        each!(|k| {
            let [first, second] = patch.edges[k].bend;
            bend = bend.greater(first.abs()).greater(second.abs());
        });
        let most = (bend * lanes.constant(MAX_HEIGHT_TO_BEND)).lesser(lanes.constant(MAX_HEIGHT));
        self.hull().max_abs().at_most(most)
    }

    /// Least and greatest height, with a tolerance for rounding.
    ///
    /// The net is made of some hundred rounded operations, each of which is off by half an epsilon of numbers
    /// up to the patch's size: 32 epsilons for those that add up, as errors of either sign do. A thousandth of
    /// the height is added for the quotients, of which the smallest divisor is a tenth (`MIN_REACH`). An estimate,
    /// not a proof: the tests of the bounds look at a million points, and none leaves them.
    #[inline(always)]
    pub fn slab(&self) -> [S; 2] {
        let hull = self.hull();
        let lanes = hull.lo;
        let tolerance = hull.max_abs() * lanes.constant(1e-3) + lanes.constant(32.0 * S::PRECISION);
        let hull = hull.widened(tolerance);
        [hull.lo, hull.hi]
    }
}

/// How far loose ends let the correction reach: it is at most this times a third of
/// `b1 b2 + b2 b3 + b3 b1`, since dividing by a loose end's share at most doubles what is left of
/// the bubble, and `b1 b2 b3` is at most a third of that sum's square.
#[inline(always)]
fn loose_reach<S: Constant>(patch: &Patch<S>) -> S {
    let mut most = patch.area2.zero();
    each!(|k| {
        let [first, second] = patch.edges[k].loose.map(u32::from);
        if first + second > 0 {
            let doubled = most.constant(f64::from(1u32 << (first + second)));
            most = most.greater(slope_range(patch, k).max_abs() * doubled);
        }
    });
    most
}

/// The values an edge's slope takes.
#[inline(always)]
fn slope_range<S: Constant>(patch: &Patch<S>, k: usize) -> Interval<S> {
    let [c0, c1, c2] = patch.edges[k].correction;
    let middle = Interval::of(c0 + c1 * c1.half());
    Interval::of(c0)
        .hull(middle)
        .hull(Interval::of(c0 + c1 + c2))
}

/// The values the correction's weighted slope takes.
#[inline(always)]
fn correction_range<S: Constant>(patch: &Patch<S>) -> Interval<S> {
    let [a, b, c] = three!(|k| slope_range(patch, k));
    a.hull(b).hull(c).widened(loose_reach(patch))
}
