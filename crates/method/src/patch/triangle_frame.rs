//! A triangle's edges and plane, before anything of its surface: what the clip and the patch share.

use super::choice::Choice;
use crate::numbers::{Constant, Real, Scalar, Vector};

/// Twice the area over the squared size, below which there is no plane to speak of ...
const DEGENERATE_AREA: f64 = 1e-12;
/// ... and below which the plane's normal is too uncertain in `f32` to build a curved surface on.
pub(crate) const SLIVER_AREA: f64 = 1e-4;
/// A flat triangle lower than this, in units of its size, is thin: the guard's share of its height
/// does not make up for rounding of the triangle itself, nor for how far along its plane a ray at a
/// grazing angle is moved by its own.
pub(crate) const THIN: f64 = 1.0 / 32.0;

/// Extents below this have no square.
const TINY: f64 = 1e-30;

/// A triangle in units of its size, with the first vertex as the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleFrame<S: Real> {
    pub origin: Vector<S>,
    /// A power of two, at most the longest edge.
    pub size: S,
    /// Every edge by direct subtraction of its ends, never as a sum of other edges.
    pub edge_vectors: [Vector<S>; 3],
    /// The edges' squared lengths.
    pub lengths2: [S; 3],
    /// The longest edge.
    pub longest: Choice<S>,
    /// Along the normal of the vertices' counterclockwise order, twice the area long.
    pub cross: Vector<S>,
    /// Twice the area.
    pub area2: S,
    /// +1 where the vertex normals agree with `cross`, else -1.
    pub winding: S,
}

impl<S: Constant> TriangleFrame<S> {
    /// The frame of a triangle that is neither degenerate nor a sliver; of any other it is nothing.
    #[inline(always)]
    pub fn of_sound(positions: &[Vector<S>; 3], normals: &[Vector<S>; 3]) -> Self {
        let edge_vectors = edge_vectors(positions);
        Self::scaled(positions[0], edge_vectors, extent(&edge_vectors)).oriented(normals)
    }

    /// Whether the triangle over these positions, of which this is the frame, is finite and neither degenerate nor
    /// a sliver: so large as single precision takes it.
    #[inline(always)]
    pub fn is_sound(&self, positions: &[Vector<S>; 3]) -> S::Mask {
        let lanes = self.area2;
        let extent = extent(&edge_vectors(positions));
        let Vector { x, y, z } = positions[0] * lanes.zero();
        // What is not finite is no number by now, and fails any comparison.
        lanes.constant(TINY).less(extent)
            & extent.less(lanes.constant(f64::from(f32::HUGE)))
            & (x + y + z).at_most(lanes.zero())
            & lanes.constant(SLIVER_AREA).less(self.area2)
    }

    /// All but the winding.
    #[inline(always)]
    fn scaled(origin: Vector<S>, edge_vectors: [Vector<S>; 3], extent: S) -> Self {
        let one = extent.one();
        let size = extent.power_of_two();
        let unit = size.per_power_of_two();
        let edge_vectors = three!(|k| edge_vectors[k] * unit);
        let lengths2 = three!(|k| edge_vectors[k].dot(edge_vectors[k]));
        let longest = Choice::longest(lengths2);
        let [a, b, c] = edge_vectors;
        // The two shortest edges give the most certain vector product.
        let cross = longest
            .pick_vector([b, c, a])
            .cross(longest.pick_vector([c, a, b]));
        Self {
            origin,
            size,
            edge_vectors,
            lengths2,
            longest,
            cross,
            area2: cross.length(),
            winding: one,
        }
    }

    #[inline(always)]
    pub fn oriented(self, normals: &[Vector<S>; 3]) -> Self {
        let one = self.area2.one();
        let agreement = self.cross.dot(normals[0] + normals[1] + normals[2]);
        let winding = S::select(agreement.less(one.zero()), -one, one);
        Self { winding, ..self }
    }
}

/// The edges from vertex to vertex.
#[inline(always)]
fn edge_vectors<S: Real>(positions: &[Vector<S>; 3]) -> [Vector<S>; 3] {
    [
        positions[1] - positions[0],
        positions[2] - positions[1],
        positions[0] - positions[2],
    ]
}

#[inline(always)]
fn extent<S: Real>([a, b, c]: &[Vector<S>; 3]) -> S {
    a.max_abs().greater(b.max_abs()).greater(c.max_abs())
}

impl<S: Scalar> TriangleFrame<S> {
    /// The frame, unless there is no area or something is not finite.
    #[inline(always)]
    pub fn new(positions: &[Vector<S>; 3], normals: &[Vector<S>; 3]) -> Option<Self> {
        let edge_vectors = edge_vectors(positions);
        let extent = extent(&edge_vectors);
        if !(S::from_f64(TINY).less(extent) && extent < S::HUGE && positions[0].is_finite()) {
            return None;
        }
        let mut frame = Self::scaled(positions[0], edge_vectors, extent);
        if !(S::from_f64(SLIVER_AREA) < frame.area2) {
            (frame.cross, frame.area2) = thin_plane(positions, frame.size)?;
        }
        Some(frame.oriented(normals))
    }

    /// Whether the triangle, if flat, is so thin that rounding along its plane matters.
    #[inline(always)]
    pub fn is_thin(&self) -> bool {
        self.area2 < self.longest.pick(self.lengths2).sqrt() * S::from_f64(THIN)
    }
}

/// The vector product of a thin triangle's edges and its length; in single precision it would drown in
/// rounding. The plane has to be right all the same: rays may meet it at a grazing angle.
#[cold]
#[inline(never)]
fn thin_plane<S: Scalar>(positions: &[Vector<S>; 3], size: S) -> Option<(Vector<S>, S)> {
    let unit = 1.0 / size.to_f64();
    let [a, b, c] = positions.map(Vector::to_f64);
    let cross = ((b - a) * unit).cross((c - a) * unit);
    let area2 = cross.length();
    (DEGENERATE_AREA < area2).then(|| (Vector::from_f64(cross), S::from_f64(area2)))
}
