//! Polygons as a file lists them, on their way to triangles.

use std::iter::repeat_n;

use glam::DVec3;
use rayon::prelude::*;

use super::cutter::PolygonCutter;
use crate::error::{Fault, MeshError, check_position, check_sizes};
use crate::skipped::Skipped;

/// The corners of polygons one after the other. Stores no sizes as long as all are triangles.
#[derive(Default)]
pub(crate) struct Faces {
    corners: Vec<u32>,
    /// Other numbers that each corner has; empty if they have none.
    others: Vec<u32>,
    /// A number that each face has; empty if they have none.
    groups: Vec<u32>,
    /// Corners of each polygon; empty if all have three.
    arities: Vec<u32>,
    /// Index values that the triangles will have.
    indices: u64,
    /// Polygons of three corners or more.
    pub(crate) polygons: u64,
    /// Polygons of fewer corners, which are no surface.
    pub(crate) too_small: u64,
}

/// The triangles of faces.
#[derive(Default)]
pub(crate) struct Triangles {
    /// Their corners.
    pub(crate) corners: Vec<[u32; 3]>,
    /// The corners' other numbers; empty if they have none.
    pub(crate) others: Vec<[u32; 3]>,
    /// The number of each triangle's face; empty if they have none.
    pub(crate) groups: Vec<u32>,
}

/// What is said of a polygon besides its corners' positions. The same for all faces: either all
/// have it or none.
#[derive(Clone, Copy, Default)]
pub(crate) struct Attributes<'a> {
    /// Other numbers of its corners.
    pub(crate) others: Option<&'a [u32]>,
    /// A number of its own.
    pub(crate) group: Option<u32>,
}

impl Faces {
    /// Adds a polygon without attributes; one of fewer than three corners is counted only.
    ///
    /// # Errors
    ///
    /// If there are more triangles than a mesh may have.
    pub(crate) fn push(&mut self, polygon: &[u32]) -> Result<(), MeshError> {
        self.push_with(polygon, Attributes::default())
    }

    /// The same with attributes.
    pub(crate) fn push_with(
        &mut self,
        polygon: &[u32],
        attributes: Attributes<'_>,
    ) -> Result<(), MeshError> {
        if polygon.len() < 3 {
            self.too_small += 1;
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
        self.others
            .extend_from_slice(attributes.others.unwrap_or_default());
        self.groups.extend(attributes.group);
        self.polygons += 1;
        Ok(())
    }

    /// Index values that the triangles will have.
    pub(crate) fn indices(&self) -> u64 {
        self.indices
    }

    /// Skips faces with a corner that is not finite or too far out. `fault` says what is wrong with
    /// a vertex, and where.
    pub(crate) fn check_positions(
        self,
        positions: &[DVec3],
        skipped: &mut Skipped,
        fault: impl Fn(u32, MeshError) -> Fault,
    ) -> Result<Faces, Fault> {
        let is_wrong = |v: u32| check_position(v as usize, positions[v as usize]).is_err();
        if !self.corners.par_iter().any(|&v| is_wrong(v)) {
            return Ok(self);
        }
        let mut checked = Faces {
            too_small: self.too_small,
            ..Faces::default()
        };
        let mut first = 0;
        for face in 0..self.polygons as usize {
            let arity = self.arities.get(face).map_or(3, |&arity| arity as usize);
            let range = first..first + arity;
            first += arity;
            let polygon = &self.corners[range.clone()];
            if let Some(&vertex) = polygon.iter().find(|&&v| is_wrong(v)) {
                let wrong = check_position(vertex as usize, positions[vertex as usize]);
                if let Err(error) = wrong {
                    skipped.skip("the faces that have it", fault(vertex, error))?;
                }
                continue;
            }
            let attributes = Attributes {
                others: self.others.get(range),
                group: self.groups.get(face).copied(),
            };
            checked.push_with(polygon, attributes)?;
        }
        Ok(checked)
    }

    /// The triangles. Every corner must be one of the positions.
    pub(crate) fn into_triangles(self, positions: &[DVec3]) -> Triangles {
        let Some(cut) = cut(&self.arities, &self.corners, positions) else {
            let triangles = |numbers: Vec<u32>| numbers.as_chunks().0.to_vec();
            return Triangles {
                corners: triangles(self.corners),
                others: triangles(self.others),
                groups: self.groups,
            };
        };
        let triangles = |numbers: Vec<u32>| -> Vec<[u32; 3]> {
            if numbers.is_empty() {
                return Vec::new();
            }
            cut.iter().map(|t| t.map(|c| numbers[c as usize])).collect()
        };
        let groups = self.groups.iter().zip(&self.arities);
        let groups = groups.flat_map(|(&group, &arity)| repeat_n(group, arity as usize - 2));
        Triangles {
            groups: groups.collect(),
            corners: triangles(self.corners),
            others: triangles(self.others),
        }
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
        let polygon = &corners[first as usize..(first + arity) as usize];
        outline.clear();
        outline.extend(polygon.iter().map(|&v| positions[v as usize]));
        triangles.extend(cutter.cut(&outline).iter().map(|t| t.map(|k| first + k)));
        first += arity;
    }
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> [DVec3; 4] {
        [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| DVec3::new(x, y, 0.0))
    }

    #[test]
    fn polygons_of_mixed_sizes_keep_their_order_and_attributes() {
        let mut faces = Faces::default();
        let polygons = [&[0, 1, 2][..], &[0, 1], &[0, 1, 2, 3], &[3, 2, 1]];
        for (group, polygon) in (0..).zip(polygons) {
            let attributes = Attributes {
                others: (polygon.len() > 2).then_some(polygon),
                group: (polygon.len() > 2).then_some(group),
            };
            faces.push_with(polygon, attributes).unwrap();
        }
        assert_eq!((faces.polygons, faces.too_small), (3, 1));
        let triangles = faces.into_triangles(&square());
        let expected = [[0, 1, 2], [0, 1, 2], [0, 2, 3], [3, 2, 1]];
        assert_eq!(triangles.corners, expected);
        assert_eq!(triangles.others, expected);
        assert_eq!(triangles.groups, [0, 2, 2, 3]);
    }

    #[test]
    fn faces_with_a_corner_that_is_not_finite_are_refused_or_skipped() {
        let mut positions = square();
        positions[3].x = f64::NAN;
        let faces = || {
            let mut faces = Faces::default();
            for polygon in [&[0, 1, 2][..], &[0, 1, 2, 3], &[3, 2, 1]] {
                faces.push(polygon).unwrap();
            }
            faces
        };
        let fault = |vertex, _| Fault::Content(format!("vertex {vertex}"));
        let mut strict = Skipped::new(false);
        let refused = faces().check_positions(&positions, &mut strict, fault);
        assert_eq!(
            refused.err().unwrap().text(),
            "vertex 3; --lenient skips the faces that have it"
        );
        let mut lenient = Skipped::new(true);
        let checked = faces().check_positions(&positions, &mut lenient, fault);
        let triangles = checked.unwrap().into_triangles(&positions);
        assert_eq!((triangles.corners, lenient.count()), (vec![[0, 1, 2]], 2));
    }
}
