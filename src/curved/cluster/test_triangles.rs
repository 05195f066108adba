//! Triangles that the tests of clusters are made with.

use glam::{Vec3, vec3};
use rand::{Rng, SeedableRng, rngs::SmallRng};

use super::grouping::group;
use super::layout::Cluster;
use crate::embree::Bounds;
use curvetri_method::{BuiltPatch, PackedTriangle, PatchFlags, TriangleVertices};

/// Curved triangles.
pub struct TestTriangles(Vec<(TriangleVertices, BuiltPatch)>);

impl TestTriangles {
    /// Some in a cube of this size, each a tenth as large.
    pub fn new(seed: u64, count: usize, size: f32, lower: Vec3) -> Self {
        let mut random = SmallRng::seed_from_u64(seed);
        let mut point = || vec3(random.random(), random.random(), random.random());
        Self::of((0..count).map(|_| {
            let first = lower + point() * size;
            let corners = [
                first,
                first + point() * 0.1 * size,
                first + point() * 0.1 * size,
            ];
            let upright = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let upright = upright.normalize_or(Vec3::X);
            let normals = [(); 3].map(|()| (upright + (point() - 0.5) * 0.5).normalize());
            (corners, normals)
        }))
    }

    /// Those over these positions with these normals.
    pub fn of(triangles: impl Iterator<Item = ([Vec3; 3], [Vec3; 3])>) -> Self {
        let patch = |(positions, normals): ([Vec3; 3], [Vec3; 3])| {
            let corners = TriangleVertices {
                positions: positions.map(Into::into),
                normals: normals.map(Into::into),
            };
            (corners, BuiltPatch::new(&corners, PatchFlags::default()))
        };
        Self(triangles.map(patch).collect())
    }

    pub fn boxes(&self) -> Vec<Bounds> {
        let bounds = self.0.iter().map(|(_, patch)| patch.bounds.map(Vec3::from));
        bounds
            .map(|[lower, upper]| Bounds { lower, upper })
            .collect()
    }

    pub fn clusters(&self) -> Box<[Cluster]> {
        group(&self.boxes(), |triangle| self.packed_triangle(triangle))
    }

    /// Some point of a triangle's surface.
    pub fn point(&self, triangle: u32, random: &mut SmallRng) -> Vec3 {
        let [mut u, mut v]: [f32; 2] = random.random();
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let patch = self.packed_triangle(triangle).unpack();
        patch.point(u, v).position.into()
    }

    pub fn packed_triangle(&self, triangle: u32) -> PackedTriangle<'_> {
        let (corners, BuiltPatch { packed, .. }) = &self.0[triangle as usize];
        PackedTriangle::new(*corners, packed)
    }
}
