//! What the kernel's benchmarks and the count of its instructions (`examples/instructions.rs`) are made on:
//! triangles of a finely cut torus, and rays that hit them, that the clip rejects, and that come past the
//! clip but miss the surface.

use std::f32::consts::TAU;
use std::hint::black_box;

use curvetri_method::{
    BoundsKind, BuiltPatch, PackedPatch, PackedTriangle, PatchFlags, Ray, RayLanes, Solver,
    Surface, TriangleVertices, vector,
};

/// Rays of each fate; a power of two.
pub const RAYS: usize = 256;
/// Into how many quadrangles the torus is cut around its axis, and around its tube.
const CUTS: [usize; 2] = [64, 48];

/// What becomes of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    Hit,
    ClipMiss,
    RootMiss,
}

/// The form of the method.
#[derive(Clone, Copy, Debug)]
pub enum Method {
    Default,
    Paper,
    Flat,
}

impl Method {
    pub fn solver(self) -> Solver {
        match self {
            Method::Default | Method::Flat => Solver::default(),
            Method::Paper => Solver::ITA,
        }
    }

    pub fn flags(self) -> PatchFlags {
        match self {
            Method::Default => PatchFlags::default(),
            Method::Paper => PatchFlags::new(Surface::Angular).with_bounds(BoundsKind::Sphere),
            Method::Flat => PatchFlags::default().with_flat(),
        }
    }

    pub fn triangle(self) -> Triangle {
        Triangle::new(0, self.flags())
    }
}

/// A triangle as a mesh holds it.
pub struct Triangle {
    pub vertices: TriangleVertices,
    packed: PackedPatch,
}

impl Triangle {
    /// A triangle of a torus of radii 1 and 1/4, on its outside. Two that follow each other make up a
    /// quadrangle, and the next two the quadrangle beside it.
    pub fn new(number: usize, flags: PatchFlags) -> Self {
        let (quad, second) = (number / 2, number % 2);
        let [across, along] = [quad % CUTS[0], quad / CUTS[0]];
        let vertex = |[x, y]: [usize; 2]| {
            let around = 0.3 + TAU / CUTS[0] as f32 * (across + x) as f32;
            let tube = 0.2 + TAU / CUTS[1] as f32 * (along + y) as f32;
            let normal = vector(
                tube.cos() * around.cos(),
                tube.cos() * around.sin(),
                tube.sin(),
            );
            let ring = vector(around.cos(), around.sin(), 0.0);
            (ring + normal * 0.25, normal)
        };
        let vertices = [[[0, 0], [1, 0], [0, 1]], [[1, 0], [1, 1], [0, 1]]][second].map(vertex);
        let (positions, normals) = (vertices.map(|v| v.0), vertices.map(|v| v.1));
        let vertices = TriangleVertices { positions, normals };
        let packed = BuiltPatch::new(&vertices, flags).packed;
        Self { vertices, packed }
    }

    /// The triangle as the kernel takes it. The compiler knows nothing of its numbers.
    pub fn packed(&self) -> PackedTriangle<'_> {
        let vertices = TriangleVertices {
            positions: black_box(self.vertices.positions),
            normals: black_box(self.vertices.normals),
        };
        PackedTriangle::new(vertices, black_box(&self.packed))
    }

    /// Rays of one fate, from about one unit away.
    pub fn rays(&self, fate: Fate) -> Vec<Ray<f32>> {
        let patch = self.packed().unpack();
        let mut state = 1u64;
        let mut unit = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let mut rays = Vec::new();
        while rays.len() < RAYS {
            let target = patch.point(unit() * 1.6 - 0.3, unit() * 1.6 - 0.3).position;
            let mut aside = || vector(unit() - 0.5, unit() - 0.5, unit() - 0.5);
            let direction = (aside() * 1.6 - patch.plane_normal()).normalize();
            let target = target + aside() * (patch.size() * 0.02);
            let ray = Ray {
                origin: target - direction,
                direction,
                tnear: 0.0,
                tfar: f32::INFINITY,
            };
            let near = !patch.clip(&ray, true).is_empty();
            let found = patch.intersect(&ray, Solver::default()).found;
            let wanted = match fate {
                Fate::Hit => found,
                Fate::ClipMiss => !near,
                Fate::RootMiss => near && !found,
            };
            if wanted {
                rays.push(ray);
            }
        }
        rays
    }
}

/// Rays, a component each.
pub struct RayColumns([Vec<f32>; 8]);

impl RayColumns {
    pub fn new(rays: &[Ray<f32>]) -> Self {
        let column = |of: fn(&Ray<f32>) -> f32| rays.iter().map(of).collect();
        Self([
            column(|r| r.origin.x),
            column(|r| r.origin.y),
            column(|r| r.origin.z),
            column(|r| r.direction.x),
            column(|r| r.direction.y),
            column(|r| r.direction.z),
            column(|r| r.tnear),
            column(|r| r.tfar),
        ])
    }

    /// Sixteen rays, from this one on.
    pub fn packet(&self, first: usize) -> RayLanes<'_> {
        let columns = self.0.each_ref().map(|column| &column[first..first + 16]);
        let [ox, oy, oz, dx, dy, dz, tnear, tfar] = columns;
        RayLanes {
            origin: [ox, oy, oz],
            direction: [dx, dy, dz],
            tnear,
            tfar,
        }
    }
}
