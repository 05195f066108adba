//! A triangle's vertices.

use super::triangle_frame::TriangleFrame;
use crate::numbers::Vector;

/// How many numbers a triangle's vertices are.
pub(crate) const VERTICES: usize = 18;

/// A triangle's vertices.
#[derive(Clone, Copy, Debug)]
pub struct TriangleVertices {
    /// Their positions.
    pub positions: [Vector<f32>; 3],
    /// Their normals, unit.
    pub normals: [Vector<f32>; 3],
}

impl TriangleVertices {
    /// The unit of length of the patch over them: a power of two, at most the longest edge; 1 where there
    /// is no patch.
    pub fn size(&self) -> f32 {
        TriangleFrame::new(&self.positions, &self.normals).map_or(1.0, |frame| frame.size)
    }
}

impl TriangleVertices {
    /// All numbers, the positions first.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [f32; VERTICES] {
        let mut numbers = [0.0; VERTICES];
        self.write(&mut numbers);
        numbers
    }

    /// Writes all numbers, the positions first.
    #[inline(always)]
    pub(crate) fn write(&self, to: &mut [f32]) {
        let vertices = self.positions.iter().chain(&self.normals);
        for (to, from) in to.chunks_exact_mut(3).zip(vertices) {
            to.copy_from_slice(&from.to_array());
        }
    }
}
