//! Cases of the kernel whose instructions `ci/instructions.sh` counts under callgrind.
//!
//!     instructions              prints the SIMD instructions in use, then the cases
//!     instructions CASE         runs a case, and prints how often it called the kernel
//!
//! Only what [`measured`] does is counted.

use std::hint::black_box;
use std::process::ExitCode;

use curvetri_method::{BuiltPatch, PATCHES, PairHits, PatchBlock, PatchFlags};
use fearless_simd::{Level, dispatch, prelude::*};

#[path = "../benches/cases/mod.rs"]
mod cases;

use cases::{Fate, Method, RAYS, RayColumns, Triangle};

/// How many triangles are unpacked, and made.
const TRIANGLES: usize = 256;

/// A case, which tells how often it called the kernel.
type Case = fn() -> usize;

const CASES: [(&str, Case); 11] = [
    ("single-hit", || single(Method::Default, Fate::Hit)),
    ("single-clip-miss", || {
        single(Method::Default, Fate::ClipMiss)
    }),
    ("single-root-miss", || {
        single(Method::Default, Fate::RootMiss)
    }),
    ("single-flat-hit", || single(Method::Flat, Fate::Hit)),
    ("single-paper-hit", || single(Method::Paper, Fate::Hit)),
    ("packet-of-16", packet),
    ("block-of-8-by-packet-of-16", block),
    ("unpack-patch", unpack_patch),
    ("unpack-block-of-8", unpack_block),
    ("make-patch", make_patch),
    ("evaluate-f", evaluate),
];

fn main() -> ExitCode {
    let Some(name) = std::env::args().nth(1) else {
        let level = format!("{:?}", Level::new()); // e.g. "Avx2(…)"
        println!("{}", level.split('(').next().unwrap_or_default());
        for (name, _) in CASES {
            println!("{name}");
        }
        return ExitCode::SUCCESS;
    };
    let Some((_, case)) = CASES.into_iter().find(|(case, _)| *case == name) else {
        eprintln!("there is no case '{name}'");
        return ExitCode::from(2);
    };
    println!("{}", case());
    ExitCode::SUCCESS
}

/// What is counted; callgrind is told this name. There is one such function, since it is not generic.
#[inline(never)]
fn measured(calls: &mut dyn FnMut()) {
    calls();
}

/// The whole call of a single ray.
fn single(method: Method, fate: Fate) -> usize {
    let (triangle, solver) = (method.triangle(), method.solver());
    let rays = triangle.rays(fate);
    measured(&mut || {
        for ray in &rays {
            let patch = triangle.packed();
            black_box(patch.intersect(black_box(ray), solver, true));
        }
    });
    rays.len()
}

/// The whole call of sixteen rays: half of them hit, a quarter each is clipped and misses the surface.
fn packet() -> usize {
    let (triangle, solver) = (Method::Default.triangle(), Method::Default.solver());
    let [hits, clipped, missed] =
        [Fate::Hit, Fate::ClipMiss, Fate::RootMiss].map(|fate| triangle.rays(fate));
    let four = |n: usize| [hits[2 * n], clipped[n], hits[2 * n + 1], missed[n]];
    let rays: Vec<_> = (0..RAYS / 4).flat_map(four).collect();
    let columns = RayColumns::new(&rays);
    measured(&mut || {
        for first in (0..RAYS).step_by(16) {
            let (patch, packet) = (triangle.packed(), columns.packet(first));
            black_box(patch.intersect_packet(black_box(&packet), 0xffff, solver, true));
        }
    });
    RAYS / 16
}

fn triangles() -> Vec<Triangle> {
    let triangle = |n| Triangle::new(n, PatchFlags::default());
    (0..TRIANGLES).map(triangle).collect()
}

fn unpack(block: &mut PatchBlock, triangles: &[Triangle]) {
    block.clear();
    block.unpack(&std::array::from_fn(|n| Some(triangles[n].packed())));
}

/// Sixteen rays at a block of eight patches, each at the patch that it hits and at the next one.
fn block() -> usize {
    let (triangles, solver) = (triangles(), Method::Default.solver());
    let at_each: Vec<_> = (triangles[..PATCHES].iter())
        .map(|triangle| triangle.rays(Fate::Hit))
        .collect();
    let rays: Vec<_> = (0..RAYS)
        .map(|n| at_each[n % PATCHES][n / PATCHES])
        .collect();
    let columns = RayColumns::new(&rays);
    let lanes = |patch: usize| 0x0101 << patch;
    let lanes: [u32; PATCHES] =
        std::array::from_fn(|n| lanes(n) | lanes((n + PATCHES - 1) % PATCHES));
    let (mut block, mut hits) = (PatchBlock::default(), PairHits::default());
    unpack(&mut block, &triangles[..PATCHES]);
    measured(&mut || {
        for first in (0..RAYS).step_by(16) {
            let (block, packet) = (black_box(&block), columns.packet(first));
            block.intersect_packet(black_box(&packet), &lanes, solver, true, &mut hits);
            black_box(&hits);
        }
    });
    RAYS / 16
}

fn unpack_patch() -> usize {
    let triangles = triangles();
    measured(&mut || {
        for triangle in &triangles {
            black_box(triangle.packed().unpack());
        }
    });
    TRIANGLES
}

fn unpack_block() -> usize {
    let triangles = triangles();
    let mut block = PatchBlock::default();
    measured(&mut || {
        for triangles in triangles.chunks(PATCHES) {
            unpack(&mut block, black_box(triangles));
            black_box(&block);
        }
    });
    TRIANGLES / PATCHES
}

/// Patches and their boxes from vertices, in lanes.
fn make_patch() -> usize {
    let vertices: Vec<_> = triangles()
        .iter()
        .map(|triangle| triangle.vertices)
        .collect();
    measured(&mut || {
        BuiltPatch::each(black_box(&vertices), PatchFlags::default(), |_, built| {
            black_box(built);
        });
    });
    TRIANGLES
}

/// One evaluation of F for one ray.
fn evaluate() -> usize {
    let triangle = Method::Default.triangle();
    let patch = triangle.packed().unpack();
    let segments: Vec<_> = (triangle.rays(Fate::Hit).iter())
        .map(|ray| patch.segment(ray, &patch.clip(ray, true)))
        .collect();
    measured(&mut || {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || {
                for segment in &segments {
                    black_box(black_box(&patch).clearance(black_box(segment), black_box(1e-3)));
                }
            }
        ));
    });
    segments.len()
}
