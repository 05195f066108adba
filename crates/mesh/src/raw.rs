//! What a file says, before it is a mesh: checks, the local origin, and the way to a [`Mesh`].

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::error::{MAX_COORDINATE, check_sizes};
use super::normals;
use super::snap::snap;
use super::weld::weld;
use super::{Bounds, LoadOptions, LoadReport, Mesh, MeshError};

/// No normal: the index of a corner whose file names none.
pub const NO_NORMAL: u32 = u32::MAX;

/// Triangles as a file has them: positions and normals with an index each. Every reader makes one.
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
    /// origin. The report tells what of it was needed.
    ///
    /// # Errors
    ///
    /// [`MeshError`]; see its variants.
    pub fn into_mesh(self, options: &LoadOptions) -> Result<(Mesh, LoadReport), MeshError> {
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
        let error = raw.into_mesh(&LoadOptions::default()).unwrap_err();
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
        let error = raw.into_mesh(&LoadOptions::default()).unwrap_err();
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
        let mesh = raw.into_mesh(&LoadOptions::default()).unwrap().0;
        assert_eq!(mesh.positions[0].to_array().map(f32::to_bits), [0; 3]);
        assert_eq!(mesh.normals[0].x.to_bits(), 0);
    }
}
