//! The indexed triangle mesh.

use glam::{DVec3, Vec3};

use crate::bounds::Bounds;

/// Normals at one position closer than this (radians; 0.1 degrees) are one. Two of them would make a
/// hard edge of what is meant to be smooth.
pub(crate) const SAME_NORMAL_ANGLE: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// How far rounding may move the corners of a triangle, as a share of its longest edge.
const MOST_ROUNDING: f64 = 0.02;

/// Whether single precision moves nothing that is so far from the origin by much of this length.
pub(crate) fn holds_length(length: f64, reach: f64) -> bool {
    0.5 * f64::from(f32::EPSILON) * reach <= MOST_ROUNDING * length
}

/// The length of a triangle's longest edge.
pub(crate) fn longest_edge([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// Whether single precision around a local origin keeps the shape of a triangle with these corners,
/// which are at these places around the origin. A triangle without size has no shape to lose.
pub(crate) fn holds_shape(corners: [DVec3; 3], around_origin: [DVec3; 3]) -> bool {
    let longest = longest_edge(corners);
    let reach = around_origin
        .iter()
        .fold(0.0, |reach: f64, p| reach.max(p.abs().max_element()));
    longest == 0.0 || holds_length(longest, reach)
}

/// A triangle mesh with unit vertex normals and one index for both.
///
/// - Vertices are distinct in (position, normal): two corners share a vertex exactly if both agree
///   bit for bit. Where normals are split (a hard edge), several vertices have the same position.
///   Normals at one position that differ by less than 0.1 degrees have been made one.
/// - Zeros are positive: two positions or normals are equal exactly if their bits are.
/// - Triangle `i` is the file's `i`-th, polygons cut in place. Degenerate triangles stay in the mesh.
/// - Positions are relative to [`Mesh::origin`].
///
/// ```
/// use curvetri_mesh::Mesh;
/// use glam::{DVec3, Vec3};
///
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
/// let mesh = Mesh::new(positions, None, vec![[0, 1, 2]])?;
/// assert_eq!(mesh.triangle_normals(0), [Vec3::Z; 3]);
/// # Ok::<(), curvetri_mesh::MeshError>(())
/// ```
///
/// # The local origin
///
/// Positions are held in single precision. Where the mesh lies far out (a coordinate of its bounds'
/// centre exceeds eight times the bounds' diagonal) that would lose digits the file has, so a
/// local origin near the centre is chosen from the double-precision positions, on a power-of-two
/// grid of the size of the diagonal so that it is exact. Otherwise the origin is zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    pub(crate) origin: DVec3,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh of arrays that are taken as they are: positions relative to `origin` (in the user's space), one
    /// unit normal a vertex, and triangles of vertex indices.
    ///
    /// # Panics
    ///
    /// If there are not as many normals as positions, or an index is out of range.
    #[must_use]
    pub fn from_local(
        origin: DVec3,
        positions: Vec<Vec3>,
        normals: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
    ) -> Mesh {
        assert_eq!(positions.len(), normals.len(), "one normal a vertex");
        let greatest = triangles.iter().flatten().max();
        assert!(
            greatest.is_none_or(|&index| (index as usize) < positions.len()),
            "an index is out of range: {greatest:?} of {} vertices",
            positions.len()
        );
        Mesh {
            origin,
            positions,
            normals,
            triangles,
        }
    }

    /// What positions are relative to, in the user's space.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The same mesh around another origin, so that several can share one. Positions are rounded
    /// anew unless the origin stays the same.
    #[must_use]
    pub fn rebased(mut self, origin: DVec3) -> Mesh {
        if origin != self.origin {
            let shift = self.origin - origin;
            for p in &mut self.positions {
                // Adding zero turns -0 into +0, so that equal positions have equal bits.
                *p = (p.as_dvec3() + shift).as_vec3() + Vec3::ZERO;
            }
            self.origin = origin;
        }
        self
    }

    /// The vertices' positions relative to the origin.
    #[must_use]
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The vertices' unit normals, as many as positions.
    #[must_use]
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// The triangles' vertices, in file order.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The positions of a triangle's corners relative to the origin.
    ///
    /// # Panics
    ///
    /// If there is no such triangle.
    #[must_use]
    pub fn triangle_positions(&self, triangle: usize) -> [Vec3; 3] {
        // not by `map`, which need not be inlined, and rays wait for it
        let [a, b, c] = self.triangles[triangle];
        [
            self.positions[a as usize],
            self.positions[b as usize],
            self.positions[c as usize],
        ]
    }

    /// The unit normals at a triangle's corners.
    ///
    /// # Panics
    ///
    /// If there is no such triangle.
    #[must_use]
    pub fn triangle_normals(&self, triangle: usize) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[triangle];
        [
            self.normals[a as usize],
            self.normals[b as usize],
            self.normals[c as usize],
        ]
    }

    /// A vertex's position in the user's space.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    #[must_use]
    pub fn world_position(&self, vertex: usize) -> DVec3 {
        self.origin + self.positions[vertex].as_dvec3()
    }

    /// The bounds of the vertices in the user's space.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &p in &self.positions {
            min = min.min(p);
            max = max.max(p);
        }
        Bounds {
            min: self.origin + min.as_dvec3(),
            max: self.origin + max.as_dvec3(),
        }
    }

    /// The bytes the mesh's arrays take.
    #[must_use]
    pub fn memory(&self) -> usize {
        size_of_val(&*self.positions) + size_of_val(&*self.normals) + size_of_val(&*self.triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec3> {
        vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]
    }

    #[test]
    fn a_rebased_mesh_stays_where_it_is() {
        let mesh = Mesh::new(square(), None, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let origin = DVec3::new(1.0, 0.0, -4.0);
        let moved = mesh.clone().rebased(origin);
        assert_eq!(moved.origin(), origin);
        assert_eq!(moved.positions()[1], Vec3::new(0.0, 0.0, 4.0));
        assert_eq!(moved.bounds(), mesh.bounds());
        assert_eq!(moved.rebased(DVec3::ZERO), mesh);
    }
}
