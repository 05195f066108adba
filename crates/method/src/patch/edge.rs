//! What a patch knows of its plane and its edges, from the triangle's frame: with as few
//! divisions and roots as there can be, and three of a kind at once, since rays wait for it.

use super::cyclic::next;
use super::flags::{PatchFlags, Surface};
use super::plane::{TrianglePlane, ratios};
use super::triangle_frame::TriangleFrame;
use crate::numbers::{Constant, Cursor, Fields, Real, Vector};

/// The centroid's foot on an edge must lie this far inside it, as a share of the edge's length, for
/// the paper's planes to bound a sub-triangle; else the edge takes the ramp of obtuse triangles.
const MIN_CENTROID_FOOT: f64 = 0.1;

/// What a patch knows of an edge, in the edge's frame: x along the edge from its first vertex, y
/// along the inward in-plane perpendicular.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge<S: Real> {
    /// Squared length.
    pub length2: S,
    /// Height of the opposite vertex over the edge.
    pub height: S,
    /// One over the height.
    pub per_height: S,
    /// Foot of the opposite vertex, as a share of the edge's length.
    pub foot: S,
    /// The guide on the edge is `nc + lean w`: the paper's edge plane (5).
    pub lean: S,
    /// `lean / height`.
    pub tilt: S,
    /// One over three times the centroid's foot as a share of the length, from either end.
    pub rise: [S; 2],
    /// Whether the ramp of obtuse triangles takes the place of the paper's planes.
    pub obtuse: S::Mask,
    /// `2 n.(other - own)` at the edge's two ends: reference curvature times squared length.
    pub bend: [S; 2],
    /// Height of the surface over the edge's middle, four times, by the mean of the two bends.
    pub bulge: S,
    /// Four times the damping of this edge.
    pub damping: S,
    /// Coefficients of the correction's slope, a quadratic along the edge.
    pub correction: [S; 3],
    /// Whether the other edge at either end is straight, though the vertex's normal leans along
    /// it: there the surface cannot keep the vertex's tangent plane, and the slope does not vanish.
    pub loose: [bool; 2],
}

/// All numbers of an edge that is not straight and has no loose end.
impl<S: Constant> Fields<S> for Edge<S> {
    const COUNT: usize = 16;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<S>) {
        cursor.number(&mut self.length2);
        cursor.number(&mut self.height);
        cursor.number(&mut self.per_height);
        cursor.number(&mut self.foot);
        cursor.number(&mut self.lean);
        cursor.number(&mut self.tilt);
        cursor.number(&mut self.rise[0]);
        cursor.number(&mut self.rise[1]);
        cursor.truth(&mut self.obtuse);
        cursor.number(&mut self.bend[0]);
        cursor.number(&mut self.bend[1]);
        cursor.number(&mut self.bulge);
        cursor.number(&mut self.damping);
        cursor.number(&mut self.correction[0]);
        cursor.number(&mut self.correction[1]);
        cursor.number(&mut self.correction[2]);
    }
}

/// The three edges, without their corrections.
#[inline(always)]
pub(crate) fn edges<S: Constant>(
    frame: &TriangleFrame<S>,
    plane: &TrianglePlane<S>,
    normals: &[Vector<S>; 3],
    flags: PatchFlags,
) -> [Edge<S>; 3] {
    let lanes = frame.area2;
    let (zero, one, third) = (lanes.zero(), lanes.one(), lanes.constant(1.0 / 3.0));
    let edge_vectors = &frame.edge_vectors;
    let sums = three!(|k| normals[k] + normals[next(k)]);
    let leans = ratios(
        three!(|k| sums[k].dot(plane.inward[k])),
        three!(|k| sums[k].dot(plane.normal)),
    );
    // Where the opposite vertex stands over the edge: from the edge's first vertex.
    let feet = three!(|k| -edge_vectors[next(next(k))].dot(edge_vectors[k]) * plane.per_length2[k]);
    let centroids = three!(|k| (one + feet[k]) * third);
    let shares = ratios([third; 3], three!(|k| centroids[k] * (one - centroids[k])));
    let margin = lanes.constant(MIN_CENTROID_FOOT);
    let smooth = flags.surface() == Surface::Smooth;
    three!(|k| {
        let edge_vector = edge_vectors[k];
        let (straight, per_height) = (flags.is_straight(k), plane.heights[3 + k]);
        let centroid = centroids[k];
        let obtuse = !(margin.less(centroid) & centroid.less(one - margin));
        let (first, second) = (
            normals[k].dot(edge_vector),
            normals[next(k)].dot(edge_vector),
        );
        let twice = lanes.constant(if straight { 0.0 } else { 2.0 });
        let most = lanes.constant(0.9);
        let damping = (sums[k].dot(edge_vector).abs() * plane.per_length[k]).lesser(most);
        let damped = lanes.constant(if smooth && !straight { 4.0 } else { 0.0 });
        Edge {
            length2: frame.lengths2[k],
            height: plane.heights[k],
            per_height,
            foot: feet[k],
            lean: leans[k],
            tilt: leans[k] * per_height,
            rise: [
                S::select(obtuse, one, (one - centroid) * shares[k]),
                S::select(obtuse, one, centroid * shares[k]),
            ],
            obtuse,
            bend: [first * twice, -(second * twice)],
            bulge: zero,
            damping: damping * damped,
            correction: [zero; 3],
            loose: [
                !straight && flags.is_straight(next(next(k))),
                !straight && flags.is_straight(next(k)),
            ],
        }
    })
}
