//! A triangle's plane.

use super::triangle_frame::TriangleFrame;
use crate::numbers::{Constant, Real, Vector};

/// A triangle's plane.
pub(crate) struct TrianglePlane<S> {
    /// `nc`: the unit normal, turned to agree with the vertex normals.
    pub normal: Vector<S>,
    /// Gradients of the three barycentric coordinates.
    pub gradients: [Vector<S>; 3],
    /// Each edge's unit perpendicular.
    pub inward: [Vector<S>; 3],
    /// Heights over the edges, and one over them.
    pub(crate) heights: [S; 2 * 3],
    /// One over each edge's length and its square.
    pub(crate) per_length: [S; 3],
    pub per_length2: [S; 3],
}

impl<S: Constant> TrianglePlane<S> {
    #[inline(always)]
    pub fn new(frame: &TriangleFrame<S>) -> Self {
        let one = frame.area2.one();
        let per_area = one / frame.area2;
        let per_length2 = ratios([one; 3], frame.lengths2);
        let lengths = roots(frame.lengths2);
        let per_length = three!(|k| lengths[k] * per_length2[k]);
        let geometric = frame.cross * per_area;
        let across = three!(|k| geometric.cross(frame.edge_vectors[k]));
        let heights = three!(|k| frame.area2 * per_length[k]);
        let per_heights = three!(|k| lengths[k] * per_area);
        Self {
            normal: geometric * frame.winding,
            // Edge k is opposite to vertex k + 2.
            gradients: [
                across[1] * per_area,
                across[2] * per_area,
                across[0] * per_area,
            ],
            inward: three!(|k| across[k] * per_length[k]),
            heights: [
                heights[0],
                heights[1],
                heights[2],
                per_heights[0],
                per_heights[1],
                per_heights[2],
            ],
            per_length,
            per_length2,
        }
    }
}

/// Three square roots at once.
#[inline(always)]
pub(crate) fn roots<S: Constant>([a, b, c]: [S; 3]) -> [S; 3] {
    // Of four, for which there is one instruction.
    let root = <S as Real>::sqrt;
    let [a, b, c, _] = [root(a), root(b), root(c), root(c)];
    [a, b, c]
}

/// Three quotients at once.
#[inline(always)]
pub(crate) fn ratios<S: Constant>([a, b, c]: [S; 3], [p, q, r]: [S; 3]) -> [S; 3] {
    let [a, b, c, _] = [a / p, b / q, c / r, c / r];
    [a, b, c]
}
