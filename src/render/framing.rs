//! How near a camera can come and still see all of a scene.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::camera::Axes;
use crate::mesh::Mesh;

/// Where the four planes through the picture's edges touch something, in the camera's axes around a
/// centre: per picture axis the greatest of `position + slope * nearness` on either side.
#[derive(Clone, Copy)]
pub(super) struct Wedges {
    slopes: [f64; 2],
    touching: [[f64; 2]; 2],
    nearest: f64,
}

impl Wedges {
    /// Around nothing.
    pub const NONE: Self = Self {
        slopes: [1.0; 2],
        touching: [[f64::NEG_INFINITY; 2]; 2],
        nearest: f64::NEG_INFINITY,
    };

    /// Around the vertices, each with a ball as large as the curved surface may bulge there.
    pub fn around(mesh: &Mesh, centre: Vec3, axes: &Axes, slopes: [f64; 2]) -> Self {
        let none = Self {
            slopes,
            ..Self::NONE
        };
        mesh.triangles()
            .par_iter()
            .fold(
                || none,
                |wedges, corners| {
                    let positions = corners.map(|v| mesh.positions()[v as usize]);
                    let normals = corners.map(|v| mesh.normals()[v as usize]);
                    let bulge = f64::from(bulge(&positions, &normals));
                    positions.into_iter().fold(wedges, |wedges, p| {
                        wedges.including((p - centre).as_dvec3(), bulge, axes)
                    })
                },
            )
            .reduce(|| none, Self::union)
    }

    fn including(mut self, p: DVec3, radius: f64, axes: &Axes) -> Self {
        let near = -p.dot(axes.forward);
        for (n, axis) in [axes.right, axes.up].into_iter().enumerate() {
            let slope = self.slopes[n];
            let (at, room) = (p.dot(axis), radius * slope.hypot(1.0));
            let [positive, negative] = &mut self.touching[n];
            *positive = positive.max(at + slope * near + room);
            *negative = negative.max(-at + slope * near + room);
        }
        self.nearest = self.nearest.max(near + radius);
        self
    }

    /// Around both.
    pub fn union(self, other: Self) -> Self {
        let [a, b] = [self.touching, other.touching];
        Self {
            slopes: if self.nearest > f64::NEG_INFINITY {
                self.slopes
            } else {
                other.slopes
            },
            touching: [0, 1].map(|n| [0, 1].map(|side| a[n][side].max(b[n][side]))),
            nearest: self.nearest.max(other.nearest),
        }
    }

    /// The nearest place from which all is within the planes, this much further away: to the right,
    /// up and back.
    pub fn eye(&self, margin: f64) -> [f64; 3] {
        let [[right, left], [top, bottom]] = self.touching;
        let back = [
            (right + left) / self.slopes[0],
            (top + bottom) / self.slopes[1],
        ]
        .into_iter()
        .fold(self.nearest, |back, both| back.max(0.5 * both));
        [0.5 * (right - left), 0.5 * (top - bottom), margin * back]
    }
}

/// How far a curved triangle may bulge out of its plane, roughly: half of how far its vertices'
/// tangent planes pass the other vertices.
fn bulge(positions: &[Vec3; 3], normals: &[Vec3; 3]) -> f32 {
    let passing = |i: usize, j: usize| normals[i].dot(positions[j] - positions[i]).abs();
    let pairs = [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)];
    pairs
        .into_iter()
        .map(|(i, j)| 0.5 * passing(i, j))
        .fold(0.0, f32::max)
}
