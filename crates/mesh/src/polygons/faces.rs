//! Polygons as a file lists them, on their way to triangles.

use glam::DVec3;

use super::cutter::PolygonCutter;
use crate::error::{MeshError, check_sizes};

/// The corners of polygons one after the other. Keeps no sizes as long as all are triangles.
#[derive(Default)]
pub(crate) struct Faces {
    corners: Vec<u32>,
    /// Corners of each polygon; empty if all have three.
    arities: Vec<u32>,
    /// Index values that the triangles will have.
    indices: u64,
    /// Polygons of three corners or more.
    pub(crate) polygons: u64,
    /// Polygons of fewer corners, which are no surface.
    pub(crate) skipped: u64,
}

impl Faces {
    /// Adds a polygon; one of fewer than three corners is counted only.
    ///
    /// # Errors
    ///
    /// If there are more triangles than a mesh may have.
    pub(crate) fn push(&mut self, polygon: &[u32]) -> Result<(), MeshError> {
        if polygon.len() < 3 {
            self.skipped += 1;
            return Ok(());
        }
        self.indices += 3 * (polygon.len() as u64 - 2);
        check_sizes(self.indices, 0)?;
        if polygon.len() > 3 && self.arities.is_empty() {
            self.arities = vec![3; self.polygons as usize];
        }
        if polygon.len() > 3 || !self.arities.is_empty() {
            self.arities.push(polygon.len() as u32);
        }
        self.corners.extend_from_slice(polygon);
        self.polygons += 1;
        Ok(())
    }

    /// Index values that the triangles will have.
    pub(crate) fn indices(&self) -> u64 {
        self.indices
    }

    /// The triangles, and the same of other numbers that the corners have; there may be none of
    /// those. Every corner must be one of the positions.
    pub(crate) fn into_triangles_with(
        self,
        others: Vec<u32>,
        positions: &[DVec3],
    ) -> (Vec<[u32; 3]>, Vec<[u32; 3]>) {
        let cut = cut(&self.arities, &self.corners, positions);
        let triangles = |numbers: Vec<u32>| match &cut {
            _ if numbers.is_empty() => Vec::new(),
            Some(cut) => cut.iter().map(|t| t.map(|c| numbers[c as usize])).collect(),
            None => numbers.as_chunks::<3>().0.to_vec(),
        };
        (triangles(self.corners), triangles(others))
    }

    /// The triangles. Every corner must be one of the positions.
    pub(crate) fn into_triangles(self, positions: &[DVec3]) -> Vec<[u32; 3]> {
        self.into_triangles_with(Vec::new(), positions).0
    }
}

/// The triangles of faces of the given numbers of corners, as numbers into the corners of all
/// faces; `None` where all faces are triangles.
fn cut(arities: &[u32], corners: &[u32], positions: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    if arities.is_empty() {
        return None;
    }
    let mut cutter = PolygonCutter::new();
    let mut outline = Vec::new();
    let mut triangles = Vec::new();
    let mut first = 0;
    for &arity in arities {
        let face = &corners[first as usize..(first + arity) as usize];
        outline.clear();
        outline.extend(face.iter().map(|&v| positions[v as usize]));
        triangles.extend(cutter.cut(&outline).iter().map(|t| t.map(|k| first + k)));
        first += arity;
    }
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_of_mixed_sizes_keep_their_order() {
        let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        let positions = square.map(|[x, y]| DVec3::new(x, y, 0.0));
        let mut faces = Faces::default();
        for polygon in [&[0, 1, 2][..], &[0, 1], &[0, 1, 2, 3], &[3, 2, 1]] {
            faces.push(polygon).unwrap();
        }
        assert_eq!((faces.polygons, faces.skipped), (3, 1));
        assert_eq!(
            faces.into_triangles(&positions),
            [[0, 1, 2], [0, 1, 2], [0, 2, 3], [3, 2, 1]]
        );
    }
}
