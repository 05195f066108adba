//! A triangle's vertices.

use super::triangle_frame::TriangleFrame;
use crate::numbers::{Cursor, Fields, Real, Vector};

/// The three vertices of a triangle, in counterclockwise order as seen from its front; of one triangle, or of
/// one a lane.
#[derive(Clone, Copy, Debug)]
pub struct TriangleVertices<V = f32> {
    /// Their positions.
    pub positions: [Vector<V>; 3],
    /// Their normals, of unit length.
    pub normals: [Vector<V>; 3],
}

impl TriangleVertices {
    /// The unit of length of the patch over them: a power of two, at most the longest edge; 1 where there
    /// is no patch.
    pub fn size(&self) -> f32 {
        TriangleFrame::new(&self.positions, &self.normals).map_or(1.0, |frame| frame.size)
    }
}

impl<V: Real> TriangleVertices<V> {
    /// All vertices at one place.
    #[inline(always)]
    pub(crate) fn blank(zero: V) -> Self {
        let vector = Vector {
            x: zero,
            y: zero,
            z: zero,
        };
        Self {
            positions: [vector; 3],
            normals: [vector; 3],
        }
    }
}

impl<V: Real> Fields<V> for TriangleVertices<V> {
    const COUNT: usize = 18;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<V>) {
        let [a, b, c] = &mut self.positions;
        let [p, q, r] = &mut self.normals;
        cursor.vector(a);
        cursor.vector(b);
        cursor.vector(c);
        cursor.vector(p);
        cursor.vector(q);
        cursor.vector(r);
    }
}
