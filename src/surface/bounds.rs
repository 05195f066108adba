//! Height bounds, tight boxes, and whether the method can take a triangle: all conservative.
//!
//! The height over a foot is `h = sum b_i C_i q_i`, where `C_i` is how far the foot is from the
//! sphere of vertex i and `q_i = 1 / (B_i + sqrt(B_i^2 - A_i C_i))`. The products `b_i C_i` are
//! cubic Bernstein forms with coefficients that follow from the sides' curvatures, and `q_i` stays
//! within a range over the triangle; so ten coefficients, each with a range, bound the height, and
//! with the control points of the plane triangle they bound the surface itself.

use super::height::MIN_DAMPING_FACTOR;
use super::patch::{Patch, Rule, next};
use super::range::Range;
use super::real::Scalar;
use super::vector::Vector;

/// Least share of `n.nc` that `B` must keep for the guides to reach the spheres.
const MIN_REACH: f64 = 0.1;
/// Least `(B^2 - A C) / B^2` at which the curvature tensor is taken.
const MIN_DISCRIMINANT: f64 = 0.1;
/// Largest share of the way to the median by which a guide on the side may lean over at the
/// surface's height, before the guide field counts as folded.
const MAX_FOLD: f64 = 0.7;
/// Greatest bound on the height, in units of the patch's size, at which a triangle is still taken:
/// beyond it the normals contradict the triangle, and its box would cover half the scene.
const MAX_HEIGHT: f64 = 8.0;
/// The same in units of the sides' greatest bend. The angular rule blows up on needles: a little
/// angle away from a long side it adds much of the short side's curvature, all along the length.
const MAX_HEIGHT_TO_BEND: f64 = 8.0;

/// What bounds the heights that one vertex's sphere asks for.
#[derive(Clone, Copy)]
struct VertexSpread<S> {
    /// Bernstein coefficients of `C_i`: at the side midpoints ij, ik, jk and the corners j, k.
    middles: [Range<S>; 3],
    corners: [Range<S>; 2],
    /// Range of `B_i`.
    half_b: Range<S>,
    /// Least `B_i^2 - A_i C_i`.
    discriminant: S,
    /// Range of `q_i`.
    reach: Range<S>,
}

/// Greatest curvature, in units of the longest side, at which the angular rule is taken: it takes
/// the difference of two angles times this, and in `f32` the rest is rounding.
const MAX_ANGULAR_CURVATURE: f64 = 30.0;

/// Greatest slope between the middles of two sides.
const MAX_SHEAR: f64 = 1.0;

/// The ranges of everything the heights depend on.
pub(super) struct Spread<S> {
    vertices: [VertexSpread<S>; 3],
    damping: Range<S>,
    /// Whether the rule is well conditioned on a triangle of this shape.
    conditioned: bool,
}

/// Bounds what each vertex's sphere asks for, under the patch's present rule.
pub(super) fn spread<S: Scalar>(patch: &Patch<S>) -> Spread<S> {
    let (zero, one) = (S::from_f64(0.0), S::from_f64(1.0));
    let damping = patch
        .sides
        .iter()
        .fold(zero, |most, side| most.greater(side.damping));
    // kappa_12 b1 b2 + kappa_23 b2 b3 + kappa_31 b3 b1 is at most a third of the greatest kappa.
    let least = (one - damping * S::from_f64(1.0 / 3.0)).greater(S::from_f64(MIN_DAMPING_FACTOR));
    let damping = Range { lo: least, hi: one };
    let length2 = patch
        .sides
        .iter()
        .fold(zero, |most, side| most.greater(side.length2));
    let most = S::from_f64(MAX_ANGULAR_CURVATURE);
    let conditioned = patch.rule != Rule::Angular
        || (0..3).all(|i| curvature_range(patch, i).max_abs() * length2 < most);
    Spread {
        vertices: [0, 1, 2].map(|i| vertex_spread(patch, i)),
        damping,
        conditioned,
    }
}

fn vertex_spread<S: Scalar>(patch: &Patch<S>, i: usize) -> VertexSpread<S> {
    let zero = S::from_f64(0.0);
    let curvature = curvature_range(patch, i);
    let (middles, corners) = offset_coefficients(patch, i, curvature);
    let offset = middles
        .iter()
        .chain(&corners)
        .fold(Range::zero(), |hull, &range| hull.hull(range));
    let (half_b, guide2) = half_b_range(patch, i, curvature);
    let product = curvature.times(guide2).times(offset);
    let low = half_b.lo.greater(zero);
    let discriminant = low * low - product.hi.greater(zero);
    let most = (half_b.hi * half_b.hi - product.lo.lesser(zero)).sqrt();
    let one = S::from_f64(1.0);
    let reach = Range {
        lo: one / (half_b.hi + most),
        hi: one / (low + discriminant.greater(zero).sqrt()),
    };
    VertexSpread {
        middles,
        corners,
        half_b,
        discriminant,
        reach,
    }
}

/// Ranges of `B_i = n.g - c d.g` and of `|g|^2`.
fn half_b_range<S: Scalar>(
    patch: &Patch<S>,
    i: usize,
    curvature: Range<S>,
) -> (Range<S>, Range<S>) {
    let zero = S::from_f64(0.0);
    let vertex = &patch.vertices[i];
    let mut half_b = Range::of(vertex.normal);
    let mut guide2 = Range::of(S::from_f64(1.0));
    for (k, side) in patch.sides.iter().enumerate() {
        // In the sub-triangle of side k the guide is nc + lean (1 - s) w, and d.w is y, at most a
        // third of the height, less the vertex's own y.
        let own = if k == next(i) { side.height } else { zero };
        let third = side.height * S::from_f64(1.0 / 3.0);
        let way = Range {
            lo: -own,
            hi: third - own,
        };
        let inward = curvature.times(way).scaled(S::from_f64(-1.0));
        let inward = inward.plus(Range::of(vertex.inward[k]));
        let leaning = Range::between(zero, side.lean).times(inward);
        half_b = half_b.hull(leaning.plus(Range::of(vertex.normal)));
        guide2.hi = guide2.hi.greater(S::from_f64(1.0) + side.lean * side.lean);
    }
    (half_b, guide2)
}

/// The curvatures that occur at vertex `i`.
fn curvature_range<S: Scalar>(patch: &Patch<S>, i: usize) -> Range<S> {
    let (j, k) = (next(i), next(next(i)));
    let (to_j, to_k) = (&patch.sides[i], &patch.sides[k]);
    let (at_j, at_k) = (to_j.bend[0] / to_j.length2, to_k.bend[1] / to_k.length2);
    let ends = Range::between(at_j, at_k);
    if patch.rule != Rule::Tensor {
        return ends;
    }
    // c(phi) = mean + radius cos(2 (phi - phi0)) over the angle at the vertex: beside its ends it
    // has an extreme inside exactly if it falls, or rises, away from both.
    let half = S::from_f64(0.5);
    let (length_j, length_k) = (to_j.length2.sqrt(), to_k.length2.sqrt());
    let product = length_j * length_k;
    let (cosine, sine) = (patch.vertices[i].between / product, patch.area2 / product);
    let mixed = (to_j.bend[0] + to_k.bend[1] - patch.mean_bend(j)) * half / product;
    let away_from_k = (mixed - at_k * cosine) / sine;
    let away_from_j = (mixed - at_j * cosine) / sine;
    let perpendicular =
        (at_j - at_k * cosine * cosine - away_from_k * cosine * sine * S::from_f64(2.0))
            / (sine * sine);
    let mean = (at_k + perpendicular) * half;
    let difference = (at_k - perpendicular) * half;
    let radius = (difference * difference + away_from_k * away_from_k).sqrt();
    let zero = S::from_f64(0.0);
    let rises = zero.at_most(away_from_k) && zero.at_most(away_from_j);
    let falls = away_from_k.at_most(zero) && away_from_j.at_most(zero);
    let highest = if rises {
        ends.hi.greater(mean + radius)
    } else {
        ends.hi
    };
    let lowest = if falls {
        ends.lo.lesser(mean - radius)
    } else {
        ends.lo
    };
    Range {
        lo: lowest,
        hi: highest,
    }
}

/// Quadratic Bernstein coefficients of `C_i`, before damping.
fn offset_coefficients<S: Scalar>(
    patch: &Patch<S>,
    i: usize,
    curvature: Range<S>,
) -> ([Range<S>; 3], [Range<S>; 2]) {
    let (j, k) = (next(i), next(next(i)));
    let (to_j, to_k) = (&patch.sides[i], &patch.sides[k]);
    let half = S::from_f64(-0.5);
    let (bend_j, bend_k) = (to_j.bend[0], to_k.bend[1]);
    let (near_j, near_k) = (Range::of(bend_j * half), Range::of(bend_k * half));
    if patch.rule == Rule::Tensor {
        let across = Range::of(patch.mean_bend(j) * half);
        return ([near_j, near_k, across], [Range::zero(); 2]);
    }
    // C = c |d|^2 - 2 n.d with c anywhere between the two sides' curvatures.
    let between = patch.vertices[i].between;
    let anywhere = (
        [
            near_j,
            near_k,
            curvature.scaled(between).plus(near_j).plus(near_k),
        ],
        [
            curvature.scaled(to_j.length2).plus(Range::of(-bend_j)),
            curvature.scaled(to_k.length2).plus(Range::of(-bend_k)),
        ],
    );
    let by_angle = by_angle(patch, i);
    let width = |of: &([Range<S>; 3], [Range<S>; 2])| {
        of.0[2].max_abs() + of.1[0].max_abs() + of.1[1].max_abs()
    };
    if width(&by_angle) < width(&anywhere) {
        by_angle
    } else {
        anywhere
    }
}

/// The same for the angular rule on thin triangles, where the direction to a point at the far end
/// of a long side is all but that side's own.
///
/// With u the share of the angle, `u |d|^2 = b_j l_j |d| (theta' / theta) (sin theta / sin theta')`,
/// which lies between `s b_j l_j (b_j l_j + b_k l_k cos theta)`, s being `sin theta / theta`, and
/// `b_j l_j (b_j l_j + b_k l_k)`; likewise for `1 - u`.
fn by_angle<S: Scalar>(patch: &Patch<S>, i: usize) -> ([Range<S>; 3], [Range<S>; 2]) {
    let k = next(next(i));
    let (to_j, to_k) = (&patch.sides[i], &patch.sides[k]);
    let between = patch.vertices[i].between;
    let (bend_j, bend_k) = (to_j.bend[0], to_k.bend[1]);
    let half = S::from_f64(0.5);
    let product = (to_j.length2 * to_k.length2).sqrt();
    let least = patch.area2 / product * patch.vertices[i].inverse_angle;
    let share = Range {
        lo: (least * between).lesser(S::from_f64(0.0)),
        hi: product,
    }
    .scaled(half);
    let mixed = share
        .scaled(bend_j / to_j.length2)
        .plus(share.scaled(bend_k / to_k.length2))
        .plus(Range::of(-(bend_j + bend_k) * half));
    let corner = |bend: S| Range::between(bend * (least - S::from_f64(1.0)), S::from_f64(0.0));
    (
        [Range::of(-bend_j * half), Range::of(-bend_k * half), mixed],
        [corner(bend_j), corner(bend_k)],
    )
}

impl<S: Scalar> Spread<S> {
    /// Whether the curvature tensor may be used: no guide comes near to missing a sphere.
    pub fn is_tame(&self) -> bool {
        let share = S::from_f64(MIN_DISCRIMINANT);
        self.reaches()
            && self.vertices.iter().all(|vertex| {
                let b = vertex.half_b.lo;
                share * b * b < vertex.discriminant
            })
    }

    /// Whether every guide meets every vertex's sphere from above (a miss by rounding is taken as
    /// a touch).
    pub fn reaches(&self) -> bool {
        let least = S::from_f64(MIN_REACH);
        self.conditioned
            && self
                .vertices
                .iter()
                .all(|v| least < v.half_b.lo && v.reach.hi.is_finite())
    }
}

/// Whether two sides bulge so differently, for how close they run, that the surface between them
/// would stand like a wall: a needle with one straight side and one curved one.
pub(super) fn shears<S: Scalar>(patch: &Patch<S>) -> bool {
    let least = patch
        .sides
        .iter()
        .fold(S::HUGE, |least, side| least.lesser(side.height));
    // A side's middle is about an eighth of its mean bend off the plane.
    let most = least * S::from_f64(8.0 * MAX_SHEAR);
    (0..3).any(|k| !((patch.mean_bend(k) - patch.mean_bend(next(k))).abs() < most))
}

/// Whether the guides of some side lean over so far, at the surface's height, that they come near
/// to crossing those of the median; where they did, the surface would crack.
///
/// Looks at the limits at both ends of a side, at the median's corner, and halfway.
pub(super) fn folds<S: Scalar>(patch: &Patch<S>) -> bool {
    let (zero, half, one) = (S::from_f64(0.0), S::from_f64(0.5), S::from_f64(1.0));
    let most = S::from_f64(MAX_FOLD);
    patch.sides.iter().enumerate().any(|(k, side)| {
        let centroid = if side.obtuse {
            half
        } else {
            (one + side.foot) * S::from_f64(1.0 / 3.0)
        };
        let rise = if side.obtuse {
            ramp_rise(side.foot)
        } else {
            side.rise
        };
        let places = [
            zero,
            centroid * half,
            centroid,
            (one + centroid) * half,
            one,
        ];
        places.iter().any(|&along| {
            // The height over lambda (1 - lambda), and the median over the same.
            let lift =
                (one - along) * end_lift(patch, k, 0, along) + along * end_lift(patch, k, 1, along);
            let room = if along <= centroid {
                rise[0] / (one - along)
            } else {
                rise[1] / along
            };
            !(side.tilt * lift < most * room)
        })
    })
}

/// What [`Side::rise`](super::patch::Side::rise) is to the paper's planes, for the ramp of obtuse
/// triangles: the ramp `b_m / min(b_i, b_j)` is steepest at the median or at the side.
fn ramp_rise<S: Scalar>(foot: S) -> [S; 2] {
    let one = S::from_f64(1.0);
    let steepness = |reach: S| one / (reach * reach).greater(one);
    [steepness(one + foot), steepness(one + one - foot)]
}

/// `t_i / (lambda (1 - lambda) b_i)` on side `k`, where the guide is perpendicular to the side.
fn end_lift<S: Scalar>(patch: &Patch<S>, k: usize, end: usize, along: S) -> S {
    let side = &patch.sides[k];
    let vertex = &patch.vertices[if end == 0 { k } else { next(k) }];
    let one = S::from_f64(1.0);
    let share = along * (one - along);
    let bend =
        -side.bend[end] * (one - side.damping * share).greater(S::from_f64(MIN_DAMPING_FACTOR));
    let half_b = vertex.normal + side.lean * vertex.inward[k];
    let a = side.bend[end] / side.length2 * (one + side.lean * side.lean);
    let discriminant = half_b * half_b - a * bend * share;
    bend / (half_b + discriminant.greater(S::from_f64(0.0)).sqrt())
}

/// Bernstein coefficients of the height, each with its range: the three corners are zero, then
/// the sides' inner points and the centre.
pub(super) struct HeightNet<S> {
    /// `[near first, near second]` of each side.
    pub sides: [[Range<S>; 2]; 3],
    pub centre: Range<S>,
}

impl<S: Scalar> HeightNet<S> {
    pub fn new(patch: &Patch<S>, spread: &Spread<S>) -> Self {
        let third = S::from_f64(1.0 / 3.0);
        let reach = |i: usize| spread.vertices[i].reach.times(spread.damping);
        let middle = |i: usize, at: usize| spread.vertices[i].middles[at].times(reach(i));
        let corner = |i: usize, at: usize| spread.vertices[i].corners[at].times(reach(i));
        let loose = loose_reach(patch) * S::from_f64(1.0 / 9.0);
        let sides = [0, 1, 2].map(|k| {
            let (i, j) = (k, next(k));
            // b_i^2 b_j: twice from vertex i's middle, once from vertex j's corner at i.
            let near_first = middle(i, 0).plus(middle(i, 0)).plus(corner(j, 1));
            let near_second = middle(j, 1).plus(middle(j, 1)).plus(corner(i, 0));
            [near_first.scaled(third), near_second.scaled(third)].map(|near| near.widened(loose))
        });
        let across = middle(0, 2)
            .plus(middle(1, 2))
            .plus(middle(2, 2))
            .scaled(third);
        let sixth = S::from_f64(1.0 / 6.0);
        let centre = across.plus(correction_range(patch).scaled(sixth));
        Self { sides, centre }
    }

    fn ranges(&self) -> impl Iterator<Item = Range<S>> + '_ {
        self.sides.iter().flatten().copied().chain([self.centre])
    }

    /// Whether the heights stay within what a triangle of this size, with sides that bend this
    /// much, may stand for.
    pub fn is_low(&self, patch: &Patch<S>) -> bool {
        let hull = self.ranges().fold(Range::zero(), Range::hull);
        let bends = patch.sides.iter().flat_map(|side| side.bend);
        let bend = bends.fold(S::from_f64(0.0), |most, bend| most.greater(bend.abs()));
        let most = (bend * S::from_f64(MAX_HEIGHT_TO_BEND)).lesser(S::from_f64(MAX_HEIGHT));
        hull.max_abs().at_most(most)
    }

    /// Least and greatest height, with room for rounding.
    pub fn slab(&self) -> [S; 2] {
        let hull = self.ranges().fold(Range::zero(), Range::hull);
        let room = hull.max_abs() * S::from_f64(1e-3) + S::EPSILON * S::from_f64(32.0);
        let hull = hull.widened(room);
        [hull.lo, hull.hi]
    }
}

/// How far loose ends let the correction reach: it is at most this times a third of
/// `b1 b2 + b2 b3 + b3 b1`, since dividing by a loose end's share at most doubles what is left of
/// the bubble, and `b1 b2 b3` is at most a third of that sum's square.
fn loose_reach<S: Scalar>(patch: &Patch<S>) -> S {
    (0..3).fold(S::from_f64(0.0), |most, k| {
        let ends = patch.sides[k].loose.iter().filter(|&&loose| loose).count();
        let doubled = S::from_f64(f64::from(1u32 << ends));
        let reach = slope_range(patch, k).max_abs() * doubled;
        if ends == 0 { most } else { most.greater(reach) }
    })
}

/// The values a side's slope takes.
fn slope_range<S: Scalar>(patch: &Patch<S>, k: usize) -> Range<S> {
    let [c0, c1, c2] = patch.sides[k].correction;
    let middle = Range::of(c0 + c1 * S::from_f64(0.5));
    Range::of(c0).hull(middle).hull(Range::of(c0 + c1 + c2))
}

/// The values the correction's weighted slope takes.
fn correction_range<S: Scalar>(patch: &Patch<S>) -> Range<S> {
    let of_side = |k| slope_range(patch, k);
    let strict = of_side(0).hull(of_side(1)).hull(of_side(2));
    strict.widened(loose_reach(patch))
}

impl<S: Scalar> Patch<S> {
    /// A box that contains the surface, in the units and axes of the positions: lower and upper
    /// corner. Tight, or the sphere's, as [the flags](super::PatchFlags::with_bounds) ask for. Conservative, rounding included; empty (`lower > upper`) for a degenerate triangle.
    pub fn bounds(&self) -> [Vector<S>; 2] {
        use super::patch::PatchKind;
        if self.kind() == PatchKind::Degenerate {
            let huge = S::HUGE;
            return [huge, -huge].map(|v| Vector { x: v, y: v, z: v });
        }
        if let Some(sphere) = &self.sphere {
            return sphere.bounds(self);
        }
        let net = match self.rule {
            Rule::Flat => None,
            _ => Some(HeightNet::new(self, &spread(self))),
        };
        let axes = [
            self.axis_range(net.as_ref(), |v| v.x),
            self.axis_range(net.as_ref(), |v| v.y),
            self.axis_range(net.as_ref(), |v| v.z),
        ];
        let corner = |of: fn(Range<S>) -> S| Vector {
            x: of(axes[0]),
            y: of(axes[1]),
            z: of(axes[2]),
        };
        [corner(|range| range.lo), corner(|range| range.hi)]
    }

    /// The range of one coordinate over the surface.
    fn axis_range(&self, net: Option<&HeightNet<S>>, of: fn(Vector<S>) -> S) -> Range<S> {
        let zero = S::from_f64(0.0);
        let points = [zero, of(self.spokes[0]), of(self.spokes[1])];
        let mut hull = points
            .iter()
            .fold(Range::zero(), |hull, &p| hull.hull(Range::of(p)));
        if let Some(net) = net {
            let guide = self.guide_range(of);
            let third = S::from_f64(1.0 / 3.0);
            for k in 0..3 {
                let (p, q) = (points[k], points[next(k)]);
                let near = [(p + p + q) * third, (p + q + q) * third];
                for end in 0..2 {
                    let out = net.sides[k][end].times(guide);
                    hull = hull.hull(out.plus(Range::of(near[end])));
                }
            }
            let centre = (points[1] + points[2]) * third;
            hull = hull.hull(net.centre.times(guide).plus(Range::of(centre)));
        }
        self.in_space(hull, of)
    }

    /// A range of one coordinate inside the patch as one of the positions' coordinate, with room for
    /// what rounding moves: inside, and in adding the origin again.
    pub(super) fn in_space(&self, hull: Range<S>, of: fn(Vector<S>) -> S) -> Range<S> {
        let inside = S::EPSILON * S::from_f64(32.0);
        let hull = hull.widened(inside + hull.max_abs() * S::EPSILON * S::from_f64(8.0));
        let origin = of(self.origin);
        let outside = (origin.abs() + hull.max_abs() * self.size) * S::EPSILON * S::from_f64(4.0);
        Range {
            lo: hull.lo * self.size + origin,
            hi: hull.hi * self.size + origin,
        }
        .widened(outside)
    }

    /// The range of one coordinate of the guide vectors.
    fn guide_range(&self, of: fn(Vector<S>) -> S) -> Range<S> {
        let mut guide = Range::of(of(self.normal));
        for (k, side) in self.sides.iter().enumerate() {
            let inward = of(self.gradients[next(next(k))]) * side.height;
            guide = guide.hull(Range::of(of(self.normal) + side.lean * inward));
        }
        guide
    }
}
