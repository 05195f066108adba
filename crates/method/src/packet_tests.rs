//! Packets against single rays: every lane bit for bit, at every level of this machine's that fuses products and
//! sums; to rounding at the others.

use fearless_simd::Level;

use super::*;
use crate::tests::{Random, V, fuses, rounded};

/// Every instruction set this machine has, best first.
fn all_levels() -> Vec<Level> {
    use fearless_simd::Simd;
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    let further = [
        best.as_avx2().map(Simd::level),
        best.as_sse4_2().map(Simd::level),
        best.as_sse2().map(Simd::level),
    ];
    #[cfg(not(target_arch = "x86_64"))]
    let further = [Some(Level::baseline())];
    std::iter::once(best)
        .chain(further.into_iter().flatten())
        .collect()
}

/// Those whose lanes are numbers alone.
fn levels() -> Vec<Level> {
    let levels = all_levels();
    levels.into_iter().filter(|level| fuses(*level)).collect()
}

/// A patch's own vertices and its packed patch.
struct Triangle {
    positions: [Vector<f32>; 3],
    normals: [Vector<f32>; 3],
    packed: PackedPatch,
}

impl Triangle {
    fn new(p: [V; 3], n: [V; 3], flags: PatchFlags) -> Self {
        let (positions, normals) = (rounded(p), rounded(n));
        let packed = Patch::new(positions, normals, flags).pack(flags);
        Self {
            positions,
            normals,
            packed,
        }
    }
    fn packed_triangle(&self) -> PackedTriangle<'_> {
        PackedTriangle::new(
            TriangleVertices {
                positions: self.positions,
                normals: self.normals,
            },
            &self.packed,
        )
    }
    fn patch(&self) -> Patch<f32> {
        Patch::unpack(self.positions, self.normals, &self.packed)
    }
}

/// Rays that hit, graze, pass the patch by, end before it, or are not numbers.
fn odd_ray(random: &mut Random, patch: &Patch<f32>) -> Ray<f32> {
    let [u, v] = random.inside();
    let size = f64::from(patch.size());
    let beside = random.direction() * (size * 0.5 * random.unit() * random.unit());
    let target = patch.point(u as f32, v as f32).position.to_f64() + beside;
    let away = random.between(0.1, 20.0);
    let direction = random.direction() * random.between(0.3, 3.0);
    let mut ray = Ray {
        origin: Vector::from_f64(target - direction * (size * away)),
        direction: Vector::<f32>::from_f64(direction * size),
        tnear: 0.0,
        tfar: f32::INFINITY,
    };
    match (random.unit() * 12.0) as u32 {
        0 => ray.tfar = away as f32 * 0.8,
        1 => ray.tnear = away as f32 * 1.2,
        2 => ray.tfar = away as f32,
        3 => ray.origin.x = f32::NAN,
        4 => ray.direction = ray.direction * 0.0,
        _ => {}
    }
    ray
}

/// The same; some begin at their own hit, or begin and end there.
fn odd_ray_or_cut(random: &mut Random, patch: &Patch<f32>) -> Ray<f32> {
    let ray = odd_ray(random, patch);
    let hit = patch.intersect(&ray, Solver::default());
    match (random.unit() * 6.0) as u32 {
        0 if hit.found => Ray {
            tnear: hit.t,
            ..ray
        },
        1 if hit.found => Ray {
            tnear: hit.t,
            tfar: hit.t,
            ..ray
        },
        _ => ray,
    }
}

fn solvers() -> [Solver; 3] {
    [
        Solver::default(),
        Solver::Bracketing { parts: 3 },
        Solver::Ita { bits: 24, step: 3 },
    ]
}

/// Rays, a column a component.
struct Columns([Vec<f32>; 8]);

impl Columns {
    fn new(rays: &[Ray<f32>]) -> Self {
        let column = |of: fn(&Ray<f32>) -> f32| rays.iter().map(of).collect();
        Self([
            column(|ray| ray.origin.x),
            column(|ray| ray.origin.y),
            column(|ray| ray.origin.z),
            column(|ray| ray.direction.x),
            column(|ray| ray.direction.y),
            column(|ray| ray.direction.z),
            column(|ray| ray.tnear),
            column(|ray| ray.tfar),
        ])
    }

    fn rays(&self) -> RayLanes<'_> {
        let [x, y, z, dx, dy, dz, tnear, tfar] = self.0.each_ref().map(Vec::as_slice);
        RayLanes {
            origin: [x, y, z],
            direction: [dx, dy, dz],
            tnear,
            tfar,
        }
    }
}

/// Checks every lane of a packet at every level; gives how many hits and misses there were.
fn check(triangle: &Triangle, rays: &[Ray<f32>], valid: u32, solver: Solver) -> [usize; 2] {
    let columns = Columns::new(rays);
    let packet = columns.rays();
    let patch = triangle.patch();
    let packed_triangle = triangle.packed_triangle();
    let mut count = [0; 2];
    for level in levels() {
        let hits = packed_triangle.intersect_packet_at(level, &packet, valid, solver, true);
        let mut evaluations = 0;
        for (lane, ray) in rays.iter().enumerate() {
            let found = hits.found >> lane & 1 != 0;
            if valid >> lane & 1 == 0 {
                assert!(!found, "{level:?} {solver:?}: lane {lane} is not valid");
                continue;
            }
            let single = patch.intersect(ray, solver);
            let (sampled, ng) = packed_triangle.intersect_at(level, ray, solver, true);
            evaluations += sampled.evaluations;
            let answer = |hit: &Hit<f32>| {
                let place = [hit.t, hit.u, hit.v].map(f32::to_bits);
                hit.found.then_some(place)
            };
            assert_eq!(
                answer(&sampled),
                answer(&single),
                "{level:?} {solver:?} {ray:?}"
            );
            let what = format!("{level:?} {solver:?} lane {lane} {ray:?} {single:?}");
            assert_eq!(found, single.found, "{what}");
            count[usize::from(!found)] += 1;
            if found {
                assert_eq!(ng, patch.normal_at(single.u, single.v));
                let lane_of = |of: &[f32; 16]| of[lane].to_bits();
                let bits = |v: f32| v.to_bits();
                assert_eq!(lane_of(&hits.t), bits(single.t), "t: {what}");
                assert_eq!(lane_of(&hits.u), bits(single.u), "u: {what}");
                assert_eq!(lane_of(&hits.v), bits(single.v), "v: {what}");
                let normal = hits.normal.each_ref().map(lane_of);
                assert_eq!(normal, ng.to_array().map(bits), "ng: {what}");
            }
        }
        match solver {
            Solver::Bracketing { .. } => {
                assert_eq!(hits.evaluations, evaluations, "{level:?} {solver:?}");
            }
            // All samples of a single ray's step are taken at once, needed or not.
            Solver::Ita { .. } => assert!(hits.evaluations <= evaluations, "{level:?} {solver:?}"),
        }
    }
    count
}

#[test]
fn every_lane_is_its_ray_alone() {
    let mut random = Random(11);
    let mut counts = [0; 2];
    for surface in Surface::ALL {
        for (tilt, flatness) in [(15.0, 0.3), (40.0, 0.8), (70.0, 1.0)] {
            for n in 0..60 {
                let (p, normals) = random.triangle(tilt, flatness);
                let mut flags = PatchFlags::new(surface);
                if n % 5 == 0 {
                    flags = flags.with_straight(n % 3);
                }
                if n % 3 == 1 {
                    flags = flags.with_bounds(BoundsKind::Sphere);
                }
                if n % 13 == 0 {
                    flags = flags.with_flat();
                }
                let triangle = Triangle::new(p, normals, flags);
                let width = [1, 4, 8, 16, 7][n % 5];
                let patch = triangle.patch();
                let rays: Vec<_> = (0..width)
                    .map(|_| odd_ray_or_cut(&mut random, &patch))
                    .collect();
                let valid = [u32::MAX, 0, 0x5a5a, 0xf7ff][n % 4];
                for solver in solvers() {
                    let [hits, misses] = check(&triangle, &rays, valid, solver);
                    counts[0] += hits;
                    counts[1] += misses;
                }
            }
        }
    }
    println!("{counts:?} hits and misses at {} levels", levels().len());
    assert!(counts[0] > 5000 && counts[1] > 2000, "{counts:?}");
}

#[test]
fn levels_that_round_twice_agree_to_rounding() {
    let mut random = Random(14);
    let levels = all_levels().into_iter().filter(|level| !fuses(*level));
    let levels: Vec<Level> = levels.collect();
    let (mut rays, mut differ) = (0, 0);
    for n in 0..400 {
        let (p, normals) = random.triangle(15.0, 0.5);
        let triangle = Triangle::new(p, normals, PatchFlags::new(Surface::ALL[n % 3]));
        let patch = triangle.patch();
        let packet: Vec<_> = (0..16).map(|_| odd_ray(&mut random, &patch)).collect();
        let columns = Columns::new(&packet);
        for &level in &levels {
            let solver = Solver::default();
            let packed_triangle = triangle.packed_triangle();
            let hits =
                packed_triangle.intersect_packet_at(level, &columns.rays(), u32::MAX, solver, true);
            for (lane, ray) in packet.iter().enumerate() {
                let (alone, _) = packed_triangle.intersect_at(level, ray, solver, true);
                let fused = patch.intersect(ray, solver);
                let near = |hit: &Hit<f32>, t: f32| (hit.t - t).abs() < 1e-5 * (1.0 + t.abs());
                let found = hits.found >> lane & 1 != 0;
                let same = [&alone, &fused]
                    .into_iter()
                    .all(|hit| hit.found == found && (!found || near(hit, hits.t[lane])));
                rays += 1;
                differ += usize::from(!same);
            }
        }
    }
    println!("{differ} of {rays} differ at {} levels", levels.len());
    assert!(differ * 200 <= rays, "{differ} of {rays}");
}

#[test]
fn a_degenerate_patch_has_no_hits() {
    let p = [vector(0.0, 0.0, 0.0); 3];
    let up = [vector(0.0, 0.0, 1.0); 3];
    let triangle = Triangle::new(p, up, PatchFlags::default());
    let ray = Ray {
        origin: vector(0.0, 0.0, 1.0),
        direction: vector(0.0, 0.0, -1.0),
        tnear: 0.0,
        tfar: f32::INFINITY,
    };
    let counts = check(&triangle, &[ray; 16], u32::MAX, Solver::default());
    assert_eq!(counts, [0, 16 * levels().len()]);
}

/// A triangle that fits a block, of a surface.
fn fitting(random: &mut Random, surface: Surface) -> Triangle {
    loop {
        let (p, normals) = random.triangle(25.0, 0.8);
        let triangle = Triangle::new(p, normals, PatchFlags::new(surface));
        if triangle.packed_triangle().fits_block() {
            return triangle;
        }
    }
}

#[test]
fn every_pair_of_a_block_is_its_ray_and_its_patch_alone() {
    let mut random = Random(12);
    let (mut found, mut requested) = (0, 0);
    for n in 0..80 {
        let surface = [Surface::Smooth, Surface::Tensor][n % 2];
        let triangles: Vec<_> = (0..8).map(|_| fitting(&mut random, surface)).collect();
        let width = [16, 4, 8, 1, 7][n % 5];
        let rays: Vec<_> = (0..width)
            .map(|lane| odd_ray_or_cut(&mut random, &triangles[lane % 8].patch()))
            .collect();
        let columns = Columns::new(&rays);
        // Some triangles are not laid out, some later than others, some lanes not requested for.
        let batches = [0b0110_1101, 0b0001_0010 >> (n % 3)];
        let lanes = std::array::from_fn(|k| [0xffff, 0x5a5a, 0, 0xf7ff][(n + k) % 4]);
        for level in levels() {
            let mut block = PatchBlock::default();
            for which in batches {
                let new = which & !block.unpacked();
                let of = |k: usize| (new >> k & 1 != 0).then(|| triangles[k].packed_triangle());
                block.unpack_at(level, &std::array::from_fn(of));
            }
            let mut hits = PairHits::default();
            let solver = Solver::default();
            block.intersect_packet_at(level, &columns.rays(), &lanes, solver, true, &mut hits);
            let mut reported = [[None; 16]; 8];
            for hit in hits.iter() {
                let place = &mut reported[hit.patch][hit.lane];
                assert!(place.is_none(), "{level:?}: reported twice");
                *place = Some((hit.t, hit.u, hit.v, hit.normal));
            }
            for (k, triangle) in triangles.iter().enumerate() {
                let patch = triangle.patch();
                for (lane, reported) in reported[k].into_iter().enumerate() {
                    let valid = lane < width && lanes[k] >> lane & block.unpacked() >> k & 1 != 0;
                    let alone = valid.then(|| patch.intersect(&rays[lane], solver));
                    let alone = alone
                        .filter(|hit| hit.found)
                        .map(|hit| (hit.t, hit.u, hit.v, patch.normal_at(hit.u, hit.v)));
                    assert_eq!(reported, alone, "{level:?}: patch {k}, lane {lane}");
                    requested += usize::from(valid);
                    found += usize::from(alone.is_some());
                }
            }
        }
    }
    println!("{found} hits of {requested}");
    assert!(
        found > 500 && requested > 2 * found,
        "{found} of {requested}"
    );
}

#[test]
fn what_is_not_plainly_curved_fits_no_block() {
    let mut random = Random(13);
    let plain = PatchFlags::default();
    let (p, normals) = random.triangle(10.0, 0.3);
    assert!(
        Triangle::new(p, normals, plain)
            .packed_triangle()
            .fits_block()
    );
    for flags in [
        plain.with_flat(),
        plain.with_plane(),
        plain.with_straight(2),
        plain.with_bounds(BoundsKind::Sphere),
        PatchFlags::new(Surface::Angular),
    ] {
        assert!(
            !Triangle::new(p, normals, flags)
                .packed_triangle()
                .fits_block(),
            "{flags:?}"
        );
    }
    let back = normals.map(|n| -n);
    let mixed = [normals[0], back[1], normals[2]];
    assert!(
        !Triangle::new(p, mixed, plain)
            .packed_triangle()
            .fits_block()
    );
}

#[test]
fn a_ray_that_begins_or_ends_at_its_own_hit_has_it() {
    let mut random = Random(15);
    let mut hits = 0;
    for n in 0..600 {
        let (p, normals) = random.triangle([5.0, 30.0, 60.0][n % 3], 0.6);
        let mut flags = PatchFlags::new(Surface::ALL[n / 3 % 3]);
        if n % 7 == 0 {
            flags = flags.with_flat();
        }
        if n % 5 == 0 {
            flags = flags.with_bounds(BoundsKind::Sphere);
        }
        let patch = Triangle::new(p, normals, flags).patch();
        for solver in solvers() {
            let ray = odd_ray(&mut random, &patch);
            let hit = patch.intersect(&ray, solver);
            if !hit.found {
                continue;
            }
            hits += 1;
            for (tnear, tfar) in [(hit.t, hit.t), (hit.t, ray.tfar), (ray.tnear, hit.t)] {
                let again = patch.intersect(&Ray { tnear, tfar, ..ray }, solver);
                let place = |hit: &Hit<f32>| (hit.found, [hit.t, hit.u, hit.v].map(f32::to_bits));
                assert_eq!(
                    place(&again),
                    place(&hit),
                    "{solver:?} {tnear} {tfar} {ray:?}"
                );
            }
            // The next number is behind it.
            let behind = Ray {
                tnear: hit.t.next_up(),
                tfar: hit.t.next_up(),
                ..ray
            };
            let next = patch.intersect(&behind, solver);
            assert!(!next.found || next.t > hit.t, "{solver:?} {ray:?}");
        }
    }
    assert!(hits > 800, "{hits}");
}
