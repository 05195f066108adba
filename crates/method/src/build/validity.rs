//! Whether a triangle's guides or its edges stand so that its surface would fold over or stand upright:
//! conservative.

use crate::evaluate::MIN_DAMPING_FACTOR;
use crate::numbers::{Constant, Real, Vector, inlined};
use crate::patch::{Patch, next};

/// Largest share of the way to the median by which a guide on the edge may lean over at the
/// surface's height, before the guide field counts as folded. At 1 guides cross; the bound looks at five places
/// of an edge, and what it may miss between them is left to the other 0.3. Chosen, not derived.
const MAX_FOLD: f64 = 0.7;
/// Greatest slope between the middles of two edges.
const MAX_SHEAR: f64 = 1.0;

/// Whether two edges bulge so differently, for how close they run, that the surface between them
/// would stand like a wall: a needle with one straight edge and one curved one.
#[inline(always)]
pub(crate) fn shears<S: Constant>(patch: &Patch<S>) -> S::Mask {
    let [a, b, c] = &patch.edges;
    let least = a.height.lesser(b.height).lesser(c.height);
    // An edge's middle is about an eighth of its mean bend off the plane.
    let most = least * least.constant(8.0 * MAX_SHEAR);
    let mut runs = least.mask(true);
    each!(|k| {
        let difference = patch.mean_bend(k) - patch.mean_bend(next(k));
        runs = runs & difference.abs().less(most);
    });
    !runs
}

/// Whether the guides of some edge lean over so far, at the surface's height, that they come near
/// to crossing those of the median; where they did, the surface would crack.
///
/// Looks at the limits at both ends of an edge, at the median's corner, and halfway.
#[inline(always)]
pub(crate) fn folds<S: Constant>(patch: &Patch<S>) -> S::Mask {
    let mut stands = patch.area2.mask(true);
    for k in 0..3 {
        stands = stands & stands_on_edge(patch, k);
    }
    !stands
}

/// Whether the guides of an edge do not fold.
#[inline(always)]
fn stands_on_edge<S: Constant>(patch: &Patch<S>, k: usize) -> S::Mask {
    let edge = &patch.edges[k];
    let lanes = edge.foot;
    let (zero, half, one) = (lanes.zero(), lanes.half(), lanes.one());
    let most = lanes.constant(MAX_FOLD);
    let third = lanes.constant(1.0 / 3.0);
    let centroid = S::select(edge.obtuse, half, (one + edge.foot) * third);
    let ramp = ramp_rise(edge.foot);
    let rise = inlined(
        #[inline(always)]
        |end: usize| S::select(edge.obtuse, ramp[end], edge.rise[end]),
    );
    let places = [
        zero,
        centroid * half,
        centroid,
        (one + centroid) * half,
        one,
    ];
    let mut stands = lanes.mask(true);
    for along in places {
        // The height over lambda (1 - lambda), and the median over the same.
        let lift =
            (one - along) * end_lift(patch, k, 0, along) + along * end_lift(patch, k, 1, along);
        let near_first = along.at_most(centroid);
        let limit =
            S::select(near_first, rise(0), rise(1)) / S::select(near_first, one - along, along);
        stands = stands & (edge.tilt * lift).less(most * limit);
    }
    stands
}

/// What [`Edge::rise`](crate::patch::Edge::rise) is to the paper's planes, for the ramp of obtuse
/// triangles: the ramp `b_m / min(b_i, b_j)` is steepest at the median or at the edge.
#[inline(always)]
fn ramp_rise<S: Constant>(foot: S) -> [S; 2] {
    let one = foot.one();
    let steepness = inlined(
        #[inline(always)]
        |reach: S| one / (reach * reach).greater(one),
    );
    [steepness(one + foot), steepness(one + one - foot)]
}

/// `t_i / (lambda (1 - lambda) b_i)` on edge `k`, where the guide is perpendicular to the edge.
#[inline(always)]
fn end_lift<S: Constant>(patch: &Patch<S>, k: usize, end: usize, along: S) -> S {
    let edge = &patch.edges[k];
    let vertex = &patch.vertices[if end == 0 { k } else { next(k) }];
    let one = along.one();
    let share = along * (one - along);
    let floor = along.constant(MIN_DAMPING_FACTOR);
    let bend = -edge.bend[end] * (one - edge.damping * share).greater(floor);
    let half_b = vertex.normal + edge.lean * vertex.inward[k];
    let a = edge.bend[end] / edge.length2 * (one + edge.lean * edge.lean);
    let discriminant = half_b * half_b - a * bend * share;
    bend / (half_b + Real::sqrt(discriminant.greater(along.zero())))
}

/// Below this cosine between a vertex normal and the triangle's plane normal the method does not
/// take the triangle.
const MIN_NORMAL_COSINE: f64 = 0.1;

impl<S: Constant> Patch<S> {
    /// Whether all vertex normals are on the plane's side.
    #[inline(always)]
    pub(crate) fn agrees(&self, normals: &[Vector<S>; 3]) -> S::Mask {
        let (zero, least) = (self.area2.zero(), self.area2.constant(MIN_NORMAL_COSINE));
        let mut agrees = zero.mask(true);
        each!(|i| {
            // Zero times what is not finite is no number, which fails any comparison.
            let Vector { x, y, z } = normals[i] * zero;
            let finite = (x + y + z).at_most(zero);
            agrees = agrees & least.less(self.vertices[i].normal) & finite;
        });
        agrees
    }
}
