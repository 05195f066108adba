//! What a file says, before it is a mesh: checks, the local origin, and the way to a [`Mesh`].

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::error::{MAX_COORDINATE, MeshError, check_sizes};
use crate::mesh::Mesh;
use crate::normals::{self, NO_NORMAL, NormalOptions, NormalsPolicy};
use crate::report::LoadReport;
use crate::topology::{snap, weld};

/// Triangles as a file has them: positions and normals with an index each. Every reader makes one.
///
/// ```
/// use curvetri_mesh::{NO_NORMAL, NormalOptions, RawMesh};
/// use glam::DVec3;
///
/// let raw = RawMesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
///     corners: vec![[0, 1, 2]],
///     normals: vec![DVec3::Z],
///     normal_corners: Some(vec![[0, 0, NO_NORMAL]]),
/// };
/// let (mesh, report) = raw.into_mesh(&NormalOptions::default())?;
/// assert_eq!((report.normals.stored, report.normals.made), (2, 1));
/// assert_eq!(mesh.positions().len(), 3);
/// # Ok::<(), curvetri_mesh::MeshError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// Positions in the user's space.
    pub positions: Vec<DVec3>,
    /// The positions of the triangles' corners, in file order.
    pub corners: Vec<[u32; 3]>,
    /// Stored normals, of any length; zero or not finite ones are made anew.
    pub normals: Vec<DVec3>,
    /// The normals of the triangles' corners ([`NO_NORMAL`] where there is none), or `None` if no
    /// corner has one.
    pub normal_corners: Option<Vec<[u32; 3]>>,
}

impl RawMesh {
    /// Checks everything, makes missing normals, merges corners of the same position and normal
    /// into vertices, puts vertices that are meant to be one into one place and chooses the local
    /// origin. The report counts what was needed of it.
    ///
    /// # Errors
    ///
    /// [`MeshError`]; see its variants.
    pub fn into_mesh(self, options: &NormalOptions) -> Result<(Mesh, LoadReport), MeshError> {
        self.check()?;
        let origin = local_origin(&self.positions);
        // Adding zero turns -0 into +0, so that equal positions have equal bits.
        let positions: Vec<Vec3> = self
            .positions
            .par_iter()
            .map(|&p| (p - origin).as_vec3() + Vec3::ZERO)
            .collect();
        drop(self.positions);
        let (place_of, place_count) = weld(&positions);
        let mut places = vec![Vec3::ZERO; place_count];
        for (&place, &p) in place_of.iter().zip(&positions) {
            places[place as usize] = p;
        }
        drop(positions);
        let mut corners = self.corners;
        corners
            .par_iter_mut()
            .for_each(|t| *t = t.map(|v| place_of[v as usize]));
        drop(place_of);
        let snapped = snap(&places, &mut corners);
        let stored = self.normal_corners.as_deref().map(|c| (&*self.normals, c));
        let vertices = normals::assign(&places, &corners, stored, options);
        let mesh = Mesh {
            origin,
            positions: vertices.positions,
            normals: vertices.normals,
            triangles: vertices.triangles,
        };
        let report = LoadReport {
            snapped,
            normals: vertices.report,
            ..LoadReport::default()
        };
        Ok((mesh, report))
    }

    fn check(&self) -> Result<(), MeshError> {
        let indices = 3 * self.corners.len() as u64;
        if indices == 0 {
            return Err(MeshError::Empty);
        }
        check_sizes(indices, self.positions.len().max(self.normals.len()) as u64)?;
        for (vertex, p) in self.positions.iter().enumerate() {
            let DVec3 { x, y, z } = *p;
            if !p.is_finite() {
                return Err(MeshError::NotFinite { vertex, x, y, z });
            }
            if p.abs().max_element() > MAX_COORDINATE {
                return Err(MeshError::TooFar { vertex, x, y, z });
            }
        }
        let vertices = self.positions.len();
        if let Some((face, index)) = out_of_range(&self.corners, vertices, None) {
            return Err(MeshError::VertexOutOfRange {
                face,
                index,
                vertices,
            });
        }
        self.check_normals()
    }

    fn check_normals(&self) -> Result<(), MeshError> {
        let Some(normal_corners) = &self.normal_corners else {
            return Ok(());
        };
        if normal_corners.len() != self.corners.len() {
            return Err(MeshError::NormalCount {
                normals: normal_corners.len(),
                expected: format!("{} triangles", self.corners.len()),
            });
        }
        let normals = self.normals.len();
        match out_of_range(normal_corners, normals, Some(NO_NORMAL)) {
            Some((face, index)) => Err(MeshError::NormalOutOfRange {
                face,
                index,
                normals,
            }),
            None => Ok(()),
        }
    }
}

impl Mesh {
    /// A mesh from arrays: positions in the user's space, optionally one normal a vertex (of any
    /// length but zero), and triangles of vertex indices.
    ///
    /// Normals that are missing (`None`, or zero or NaN at single vertices) are made with
    /// [`NormalOptions::default`]'s crease angle; all others are used. Use [`RawMesh::into_mesh`] for a choice of it, and
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
        let options = NormalOptions {
            // Who has the normals at hand means them.
            policy: NormalsPolicy::Stored,
            ..NormalOptions::default()
        };
        Ok(raw.into_mesh(&options)?.0)
    }
}

/// The first face with an index of `count` or more, and that index.
fn out_of_range(faces: &[[u32; 3]], count: usize, allowed: Option<u32>) -> Option<(usize, u32)> {
    faces.iter().enumerate().find_map(|(face, corners)| {
        let bad = corners
            .iter()
            .find(|&&i| i as usize >= count && Some(i) != allowed)?;
        Some((face, *bad))
    })
}

/// Zero, or for meshes far out (see [`Mesh`]) a point near the centre.
fn local_origin(positions: &[DVec3]) -> DVec3 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &p in positions {
        min = min.min(p);
        max = max.max(p);
    }
    Bounds { min, max }.local_origin()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_triangle() -> RawMesh {
        RawMesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            corners: vec![[0, 1, 2]],
            ..RawMesh::default()
        }
    }

    #[test]
    fn a_normal_out_of_range_is_refused_with_its_face() {
        let raw = RawMesh {
            normals: vec![DVec3::Z],
            normal_corners: Some(vec![[0, NO_NORMAL, 1]]),
            ..one_triangle()
        };
        let error = raw.into_mesh(&NormalOptions::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "face 0 names normal 1, but there are only 1 (0 is the first)"
        );
    }

    #[test]
    fn normal_corners_must_be_as_many_as_triangles() {
        let raw = RawMesh {
            normal_corners: Some(vec![]),
            ..one_triangle()
        };
        let error = raw.into_mesh(&NormalOptions::default()).unwrap_err();
        assert_eq!(error.to_string(), "0 normals do not match 1 triangles");
    }

    #[test]
    fn the_origin_stays_zero_near_it_and_is_exact_far_out() {
        let cube = [DVec3::ZERO, DVec3::ONE];
        assert_eq!(local_origin(&cube), DVec3::ZERO);
        assert_eq!(local_origin(&cube.map(|p| p + 10.0)), DVec3::ZERO);
        assert_eq!(
            local_origin(&cube.map(|p| p + 1e6)),
            DVec3::splat(1_000_001.0)
        );
        assert_eq!(local_origin(&[DVec3::splat(3.7); 2]), DVec3::splat(3.7));
    }

    #[test]
    fn negative_zeros_become_positive() {
        let raw = RawMesh {
            positions: vec![DVec3::new(-0.0, 0.0, -0.0), DVec3::X, DVec3::Y],
            corners: vec![[0, 1, 2]],
            normals: vec![DVec3::new(-0.0, -0.0, 1.0)],
            normal_corners: Some(vec![[0, 0, 0]]),
        };
        let mesh = raw.into_mesh(&NormalOptions::default()).unwrap().0;
        assert_eq!(mesh.positions[0].to_array().map(f32::to_bits), [0; 3]);
        assert_eq!(mesh.normals[0].x.to_bits(), 0);
    }

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
}
