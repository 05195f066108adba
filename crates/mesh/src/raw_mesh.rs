//! What a file says, before it is a mesh: checks, the local origin, and the way to a [`Mesh`].

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::error::{MeshError, check_position, check_sizes};
use crate::mesh::{Mesh, holds_shape};
use crate::normals::{self, GivenNormals, NO_NORMAL, NormalOptions, NormalsPolicy};
use crate::report::LoadReport;
use crate::topology::{count_degenerate, snap, weld};

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
///     smoothing_groups: None,
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
    /// The smoothing group of each triangle, or `None` if the file knows none. Made normals are
    /// smooth across edges whose two triangles are of the same group. Group 0 is smooth nowhere.
    pub smoothing_groups: Option<Vec<u32>>,
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
        let used = self.check()?;
        let used_positions = || self.positions.iter().zip(&used).filter(|(_, used)| **used);
        let origin = Bounds::around(used_positions().map(|(&p, _)| p)).local_origin();
        let unused_vertices = (self.positions.len() - used_positions().count()) as u64;
        drop(used);
        let imprecise_triangles = count_imprecise(&self.positions, &self.corners, origin);
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
        let given = GivenNormals {
            stored: self.normal_corners.as_deref().map(|c| (&*self.normals, c)),
            smoothing_groups: self.smoothing_groups.as_deref(),
        };
        let vertices = normals::assign(&places, &corners, given, options);
        let mesh = Mesh {
            origin,
            positions: vertices.positions,
            normals: vertices.normals,
            triangles: vertices.triangles,
        };
        let report = LoadReport {
            triangles: mesh.triangles().len() as u64,
            degenerate_triangles: count_degenerate(&mesh),
            imprecise_triangles,
            unused_vertices,
            snapped,
            normals: vertices.report,
            ..LoadReport::default()
        };
        Ok((mesh, report))
    }

    /// Checks what the triangles name; which vertices that is.
    fn check(&self) -> Result<Vec<bool>, MeshError> {
        let indices = 3 * self.corners.len() as u64;
        if indices == 0 {
            return Err(match self.positions.len() {
                0 => MeshError::Empty,
                points => MeshError::NoFaces { points },
            });
        }
        check_sizes(indices, self.positions.len().max(self.normals.len()) as u64)?;
        let vertices = self.positions.len();
        if let Some((face, index)) = out_of_range(&self.corners, vertices, None) {
            return Err(MeshError::VertexOutOfRange {
                face,
                index,
                vertices,
            });
        }
        let mut used = vec![false; vertices];
        for &corner in self.corners.as_flattened() {
            used[corner as usize] = true;
        }
        // What no triangle names may be anything: scans have invalid points, exporters stray ones.
        let of_used = self.positions.iter().enumerate().zip(&used);
        for ((vertex, &position), _) in of_used.filter(|(_, used)| **used) {
            check_position(vertex, position)?;
        }
        self.check_normals()?;
        self.check_groups()?;
        Ok(used)
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

    fn check_groups(&self) -> Result<(), MeshError> {
        match &self.smoothing_groups {
            Some(groups) if groups.len() != self.corners.len() => Err(MeshError::GroupCount {
                groups: groups.len(),
                triangles: self.corners.len(),
            }),
            _ => Ok(()),
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
            smoothing_groups: None,
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

/// Triangles whose corners single precision around this origin moves by more than a fiftieth of
/// their longest edge.
fn count_imprecise(positions: &[DVec3], triangles: &[[u32; 3]], origin: DVec3) -> u64 {
    let is_imprecise = |t: &&[u32; 3]| {
        let corners = t.map(|v| positions[v as usize]);
        !holds_shape(corners, corners.map(|p| p - origin))
    };
    triangles.par_iter().filter(is_imprecise).count() as u64
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
        let origin = |points: [DVec3; 2]| Bounds::around(points).local_origin();
        assert_eq!(origin(cube), DVec3::ZERO);
        assert_eq!(origin(cube.map(|p| p + 10.0)), DVec3::ZERO);
        assert_eq!(origin(cube.map(|p| p + 1e6)), DVec3::splat(1_000_001.0));
        assert_eq!(origin([DVec3::splat(3.7); 2]), DVec3::splat(3.7));
    }

    #[test]
    fn vertices_that_no_triangle_names_decide_nothing_and_are_counted() {
        let far = DVec3::new(456_789.25, 5_123_456.5, 314.25);
        for stray in [DVec3::ZERO, DVec3::NAN, DVec3::splat(1e300)] {
            let mut raw = one_triangle();
            raw.positions.iter_mut().for_each(|p| *p = 1e-3 * *p + far);
            raw.positions.insert(1, stray);
            raw.corners = vec![[0, 2, 3]];
            let (mesh, report) = raw.into_mesh(&NormalOptions::default()).unwrap();
            assert_eq!((report.unused_vertices, report.imprecise_triangles), (1, 0));
            assert!(
                mesh.bounds().min.distance(far) < 1e-9,
                "{}",
                mesh.bounds().min
            );
            assert!((mesh.bounds().diagonal() - 1e-3 * 2f64.sqrt()).abs() < 1e-9);
            assert_eq!(mesh.positions().len(), 3);
        }
    }

    #[test]
    fn used_vertices_are_checked_wherever_they_are() {
        for (bad, what) in [(f64::INFINITY, "is not finite"), (2e18, "lies too far out")] {
            let mut raw = one_triangle();
            raw.positions[2].y = bad;
            let error = raw.into_mesh(&NormalOptions::default()).unwrap_err();
            let start = format!("vertex 2 {what}");
            assert!(error.to_string().starts_with(&start), "{error}");
        }
    }

    #[test]
    fn parts_too_far_apart_for_single_precision_are_counted() {
        let far = DVec3::new(456_789.25, 5_123_456.5, 314.25);
        let both = |away: DVec3| {
            let mut raw = one_triangle();
            raw.positions
                .extend(one_triangle().positions.iter().map(|&p| p + away));
            raw.corners.push([3, 4, 5]);
            let (_, report) = raw.into_mesh(&NormalOptions::default()).unwrap();
            report.imprecise_triangles
        };
        assert_eq!(both(far), 1);
        assert_eq!(both(1e-3 * far), 0);
        // What is of little use at 200 km is good at 20.
        assert_eq!((both(4e-1 * far), both(4e-2 * far)), (1, 0));
    }

    #[test]
    fn points_alone_and_triangles_without_area_are_told() {
        let mut raw = one_triangle();
        raw.corners.clear();
        let error = raw
            .clone()
            .into_mesh(&NormalOptions::default())
            .unwrap_err();
        assert!(error.to_string().contains("3 points, no faces"), "{error}");
        raw.positions.truncate(1);
        let error = raw.into_mesh(&NormalOptions::default()).unwrap_err();
        assert!(error.to_string().contains("1 point, no faces"), "{error}");
        let mut raw = one_triangle();
        raw.corners = vec![[0, 1, 1], [2, 2, 2]];
        let (_, report) = raw.into_mesh(&NormalOptions::default()).unwrap();
        assert_eq!((report.triangles, report.degenerate_triangles), (2, 2));
    }

    #[test]
    fn smoothing_groups_must_be_as_many_as_triangles() {
        let mut raw = one_triangle();
        raw.smoothing_groups = Some(vec![1, 2]);
        let error = raw.into_mesh(&NormalOptions::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "2 smoothing groups do not match 1 triangles"
        );
    }

    #[test]
    fn negative_zeros_become_positive() {
        let raw = RawMesh {
            positions: vec![DVec3::new(-0.0, 0.0, -0.0), DVec3::X, DVec3::Y],
            corners: vec![[0, 1, 2]],
            normals: vec![DVec3::new(-0.0, -0.0, 1.0)],
            normal_corners: Some(vec![[0, 0, 0]]),
            ..RawMesh::default()
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
        let error = Mesh::new(vec![], None, vec![]).unwrap_err();
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
