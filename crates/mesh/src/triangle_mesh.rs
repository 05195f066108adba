//! The indexed triangle mesh.

use glam::{BVec3, DVec3, Vec3};

use super::raw::RawMesh;
use super::{LoadOptions, MeshError, NormalsPolicy};

/// A triangle mesh with unit vertex normals and one index for both.
///
/// - Vertices are distinct in (position, normal): two corners share a vertex exactly if both agree
///   bit for bit. Where normals are split (a hard edge), several vertices have the same position.
///   Normals at one position that differ by less than 0.1 degrees have been made one.
/// - Zeros are positive: two positions or normals are equal exactly if their bits are.
/// - Triangle `i` is the file's `i`-th, polygons cut in place. Degenerate triangles are kept.
/// - Positions are relative to [`Mesh::origin`].
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

/// An axis-aligned box in the user's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner with the least coordinates.
    pub min: DVec3,
    /// The corner with the greatest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The box's centre.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// The length of the box's diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// The box's corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|n| {
            let [x, y, z] = [1, 2, 4].map(|bit| n & bit != 0);
            DVec3::select(BVec3::new(x, y, z), self.max, self.min)
        })
    }

    /// The least box around points; of none one that [`union`](Self::union) ignores.
    pub(super) fn around(points: impl IntoIterator<Item = DVec3>) -> Bounds {
        let none = Bounds {
            min: DVec3::INFINITY,
            max: DVec3::NEG_INFINITY,
        };
        let points = points.into_iter();
        points.fold(none, |around, p| around.union(Bounds { min: p, max: p }))
    }

    /// The least box around both.
    #[must_use]
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The local origin for meshes with these bounds, as [`Mesh`] describes it.
    #[must_use]
    pub fn local_origin(&self) -> DVec3 {
        let (centre, diagonal) = (self.centre(), self.diagonal());
        if centre.abs().max_element() <= 8.0 * diagonal {
            return DVec3::ZERO;
        }
        // A point has no size: then the origin is the point itself.
        if diagonal == 0.0 {
            return centre;
        }
        let grid = diagonal.log2().floor().exp2();
        (centre / grid).round() * grid
    }
}

impl Mesh {
    /// A mesh from arrays: positions in the user's space, optionally one normal a vertex (of any
    /// length but zero), and triangles of vertex indices.
    ///
    /// Normals that are missing (`None`, or zero or NaN at single vertices) are made with
    /// [`LoadOptions::default`]'s crease angle; all others are used. Use [`RawMesh::into_mesh`] for a choice of it, and
    /// for normals with indices of their own.
    /// Rays on a large mesh are faster once it is [ordered](Mesh::ordered), as those from files are.
    ///
    /// # Errors
    ///
    /// [`MeshError`] for an empty mesh, positions that are not finite or too far out, indices out
    /// of range, too many indices, and normals that are not as many as the positions.
    pub fn new(
        positions: Vec<DVec3>,
        normals: Option<Vec<DVec3>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Mesh, MeshError> {
        let normal_corners = match &normals {
            Some(n) if n.len() != positions.len() => {
                return Err(MeshError::NormalCount {
                    normals: n.len(),
                    expected: format!("{} vertices", positions.len()),
                });
            }
            Some(_) => Some(triangles.clone()),
            None => None,
        };
        let raw = RawMesh {
            positions,
            corners: triangles,
            normals: normals.unwrap_or_default(),
            normal_corners,
        };
        let options = LoadOptions {
            // Who has the normals at hand means them.
            normals: NormalsPolicy::Stored,
            ..LoadOptions::default()
        };
        Ok(raw.into_mesh(&options)?.0)
    }

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
    fn arrays_become_a_mesh_with_made_normals() {
        let mesh = Mesh::new(square(), None, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert!(mesh.normals().iter().all(|&n| n == Vec3::Z));
        assert_eq!(mesh.bounds().min, DVec3::ZERO);
        assert_eq!(mesh.bounds().max, DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.origin(), DVec3::ZERO);
    }

    #[test]
    fn an_empty_mesh_is_refused() {
        let error = Mesh::new(square(), None, vec![]).unwrap_err();
        assert_eq!(error.to_string(), "the mesh is empty: it has no triangles");
    }

    #[test]
    fn nan_is_refused_with_its_vertex() {
        let mut positions = square();
        positions[2].y = f64::NAN;
        let error = Mesh::new(positions, None, vec![[0, 1, 2]]).unwrap_err();
        assert_eq!(error.to_string(), "vertex 2 is not finite: 1 NaN 0");
    }

    #[test]
    fn a_coordinate_too_far_out_is_refused() {
        let mut positions = square();
        positions[1].z = -2e18;
        let error = Mesh::new(positions, None, vec![[0, 1, 2]]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "vertex 1 lies too far out (1 0 -2000000000000000000): coordinates may go up to 1e18; \
             scale the mesh down"
        );
    }

    #[test]
    fn an_index_out_of_range_is_refused_with_its_face() {
        let error = Mesh::new(square(), None, vec![[0, 1, 2], [0, 2, 4]]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "face 1 names vertex 4, but there are only 4 (0 is the first)"
        );
    }

    #[test]
    fn normals_must_be_as_many_as_positions() {
        let error = Mesh::new(square(), Some(vec![DVec3::Z; 3]), vec![[0, 1, 2]]).unwrap_err();
        assert_eq!(error.to_string(), "3 normals do not match 4 vertices");
    }

    #[test]
    fn given_normals_become_unit_length() {
        let mesh = Mesh::new(
            square(),
            Some(vec![DVec3::Z * 7.0; 4]),
            vec![[0, 1, 2], [0, 2, 3]],
        )
        .unwrap();
        assert!(mesh.normals().iter().all(|&n| n == Vec3::Z));
    }

    #[test]
    fn a_far_mesh_keeps_its_digits_around_a_local_origin() {
        let offset = DVec3::new(4.0e6, -5.0e5, 7.0e5);
        let small = square().into_iter().map(|p| 1e-3 * p + offset).collect();
        let mesh = Mesh::new(small, None, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        assert_ne!(mesh.origin(), DVec3::ZERO);
        for (v, p) in square().into_iter().enumerate() {
            let error = (mesh.world_position(v) - (1e-3 * p + offset)).length();
            assert!(error < 1e-9, "vertex {v} is off by {error}");
        }
        assert!((mesh.bounds().diagonal() - 1e-3 * 2f64.sqrt()).abs() < 1e-9);
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
