//! Nanoseconds of one kernel call: one triangle of a finely cut torus against rays that hit it,
//! that its clip rejects, and that come past the clip but miss the surface; in our own form and in the
//! paper's, whose clip lets other rays past; and as a flat triangle.
//!
//! Run with `cargo bench --bench kernel`; every figure is for one call, so one of a packet is for
//! sixteen rays.

use curvetri_method::{PatchFlags, Surface};
use divan::{Bencher, black_box};

mod cases;

use cases::{Fate, Method, RAYS, RayColumns, Triangle};

fn main() {
    divan::main();
}

/// What becomes of a ray in which form.
const CASES: [(Method, Fate); 7] = [
    (Method::Default, Fate::Hit),
    (Method::Default, Fate::ClipMiss),
    (Method::Default, Fate::RootMiss),
    (Method::Paper, Fate::Hit),
    (Method::Paper, Fate::ClipMiss),
    (Method::Paper, Fate::RootMiss),
    (Method::Flat, Fate::Hit),
];
const SURFACES: [Surface; 3] = Surface::ALL;

/// The whole call of a single ray, as the callback makes it.
#[divan::bench(args = CASES)]
fn single(bencher: Bencher<'_, '_>, (method, fate): (Method, Fate)) {
    let (triangle, solver) = (method.triangle(), method.solver());
    let rays = triangle.rays(fate);
    let mut n = 0;
    bencher.bench_local(|| {
        n = (n + 1) % RAYS;
        let ray = black_box(&rays[n]);
        triangle.packed().intersect(ray, solver, true)
    });
}

/// The whole call of sixteen rays.
#[divan::bench(args = CASES)]
fn packet_of_16(bencher: Bencher<'_, '_>, (method, fate): (Method, Fate)) {
    let (triangle, solver) = (method.triangle(), method.solver());
    let columns = RayColumns::new(&triangle.rays(fate));
    let mut n = 0;
    bencher.bench_local(|| {
        n = (n + 16) % RAYS;
        let packet = columns.packet(n);
        triangle
            .packed()
            .intersect_packet(black_box(&packet), 0xffff, solver, true)
    });
}

/// One evaluation of F for one ray.
#[divan::bench(args = SURFACES)]
fn evaluation(bencher: Bencher<'_, '_>, surface: Surface) {
    let triangle = Triangle::new(0, PatchFlags::new(surface));
    let rays = triangle.rays(Fate::Hit);
    let patch = triangle.packed().unpack();
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
    let triangle = Triangle::new(0, PatchFlags::default());
    bencher.bench_local(|| black_box(triangle.packed().unpack()));
}
