//! Nanoseconds of one kernel call: one triangle of a finely cut torus against rays that hit it,
//! that its clip rejects, and that come past the clip but miss the surface; in our own form and in the
//! paper's, whose clip lets other rays past.
//!
//! Run with `cargo bench --bench kernel`; every figure is for one call, so one of a packet is for
//! sixteen rays.

use curvetri_method::{
    BoundsKind, PackedPatch, PackedTriangle, Patch, PatchFlags, Ray, RayLanes, Solver, Surface,
    TriangleVertices, Vector, vector,
};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// What becomes of a ray.
#[derive(Clone, Copy, Debug)]
enum Fate {
    Hit,
    ClipMiss,
    RootMiss,
}

/// The form of the method.
#[derive(Clone, Copy, Debug)]
enum Method {
    Default,
    Paper,
}

impl Method {
    fn solver(self) -> Solver {
        match self {
            Method::Default => Solver::default(),
            Method::Paper => Solver::ITA,
        }
    }

    fn triangle(self) -> Triangle {
        Triangle::new(match self {
            Method::Default => PatchFlags::default(),
            Method::Paper => PatchFlags::new(Surface::Angular).with_bounds(BoundsKind::Sphere),
        })
    }
}

/// What becomes of a ray in which form.
const CASES: [(Method, Fate); 6] = [
    (Method::Default, Fate::Hit),
    (Method::Default, Fate::ClipMiss),
    (Method::Default, Fate::RootMiss),
    (Method::Paper, Fate::Hit),
    (Method::Paper, Fate::ClipMiss),
    (Method::Paper, Fate::RootMiss),
];
const SURFACES: [Surface; 3] = Surface::ALL;
/// Rays of each fate; a power of two.
const RAYS: usize = 256;

struct Triangle {
    positions: [Vector<f32>; 3],
    normals: [Vector<f32>; 3],
    packed: PackedPatch,
}

impl Triangle {
    /// A triangle of a torus of radii 1 and 1/4, cut into 48 by 64 quadrangles, on its outer edge.
    fn new(flags: PatchFlags) -> Self {
        let corner = |around: f32, tube: f32| {
            let normal = vector(
                tube.cos() * around.cos(),
                tube.cos() * around.sin(),
                tube.sin(),
            );
            let ring = vector(around.cos(), around.sin(), 0.0);
            (ring + normal * 0.25, normal)
        };
        let (step, turn) = (std::f32::consts::TAU / 64.0, std::f32::consts::TAU / 48.0);
        let corners = [
            corner(0.3, 0.2),
            corner(0.3 + step, 0.2),
            corner(0.3, 0.2 + turn),
        ];
        let (positions, normals) = (corners.map(|c| c.0), corners.map(|c| c.1));
        let packed = Patch::new(positions, normals, flags).pack(flags);
        Self {
            positions,
            normals,
            packed,
        }
    }

    fn packed_triangle(&self) -> PackedTriangle<'_> {
        let corners = TriangleVertices {
            positions: black_box(self.positions),
            normals: black_box(self.normals),
        };
        PackedTriangle::new(corners, black_box(&self.packed))
    }

    /// Rays of one fate, from about one unit away.
    fn rays(&self, fate: Fate) -> Vec<Ray<f32>> {
        let patch = self.packed_triangle().unpack();
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

/// The whole call of a single ray, as the callback makes it.
#[divan::bench(args = CASES)]
fn single(bencher: Bencher<'_, '_>, (method, fate): (Method, Fate)) {
    let (triangle, solver) = (method.triangle(), method.solver());
    let rays = triangle.rays(fate);
    let mut n = 0;
    bencher.bench_local(|| {
        n = (n + 1) % RAYS;
        let ray = black_box(&rays[n]);
        triangle.packed_triangle().intersect(ray, solver, true)
    });
}

/// The whole call of sixteen rays.
#[divan::bench(args = CASES)]
fn packet_of_16(bencher: Bencher<'_, '_>, (method, fate): (Method, Fate)) {
    let (triangle, solver) = (method.triangle(), method.solver());
    let rays = triangle.rays(fate);
    let column = |of: fn(&Ray<f32>) -> f32| rays.iter().map(of).collect::<Vec<_>>();
    let origin = [
        column(|r| r.origin.x),
        column(|r| r.origin.y),
        column(|r| r.origin.z),
    ];
    let direction = [
        column(|r| r.direction.x),
        column(|r| r.direction.y),
        column(|r| r.direction.z),
    ];
    let (tnear, tfar) = (column(|r| r.tnear), column(|r| r.tfar));
    let mut n = 0;
    bencher.bench_local(|| {
        n = (n + 16) % RAYS;
        let packet = RayLanes {
            origin: origin.each_ref().map(|x| &x[n..n + 16]),
            direction: direction.each_ref().map(|x| &x[n..n + 16]),
            tnear: &tnear[n..n + 16],
            tfar: &tfar[n..n + 16],
        };
        triangle
            .packed_triangle()
            .intersect_packet(black_box(&packet), 0xffff, solver, true)
    });
}

/// One evaluation of F for one ray.
#[divan::bench(args = SURFACES)]
fn evaluation(bencher: Bencher<'_, '_>, surface: Surface) {
    let triangle = Triangle::new(PatchFlags::new(surface));
    let rays = triangle.rays(Fate::Hit);
    let patch = triangle.packed_triangle().unpack();
    let segments: Vec<_> = rays
        .iter()
        .map(|ray| patch.segment(ray, &patch.clip(ray, true)))
        .collect();
    let mut n = 0;
    bencher.bench_local(|| {
        n = (n + 1) % RAYS;
        black_box(&patch).clearance(black_box(&segments[n]), black_box(1e-3))
    });
}

/// The patch from its packed form.
#[divan::bench]
fn unpack(bencher: Bencher<'_, '_>) {
    let triangle = Triangle::new(PatchFlags::default());
    bencher.bench_local(|| black_box(triangle.packed_triangle().unpack()));
}
