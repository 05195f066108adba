//! Tests of the kernel as a whole: whole bodies, inverse against forward, bounds, `f32` against
//! `f64`, first roots against dense sampling.

use fearless_simd::Level;
use proptest::prelude::*;

use super::intersect::Segment;
use super::*;

pub(crate) type V = Vector<f64>;

/// Whether a level rounds a product and a sum once, as numbers alone do: then lanes are numbers alone, bit for
/// bit.
pub(crate) fn fuses(level: Level) -> bool {
    #[cfg(target_arch = "x86_64")]
    return level.as_avx2().is_some();
    #[cfg(target_arch = "aarch64")]
    return level.as_neon().is_some();
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    return false;
}

/// splitmix64: random numbers that are the same everywhere.
pub(crate) struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }
    /// Barycentric u, v of a point of the triangle.
    pub fn inside(&mut self) -> [f64; 2] {
        let (u, v) = (self.unit(), self.unit());
        if u + v > 1.0 {
            [1.0 - u, 1.0 - v]
        } else {
            [u, v]
        }
    }
    pub fn direction(&mut self) -> V {
        loop {
            let v = [0; 3].map(|_| self.between(-1.0, 1.0));
            let v = vector(v[0], v[1], v[2]);
            if (0.01..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
    /// A triangle of about unit size with normals tilted by up to `tilt` degrees, `flatness` from
    /// 0 (near equilateral) to 1 (thin or very obtuse), all numbers exact in `f32`.
    pub fn triangle(&mut self, tilt: f64, flatness: f64) -> ([V; 3], [V; 3]) {
        let squash = 1.0 - 0.97 * flatness * self.unit();
        let turn = self.between(0.0, 6.3);
        let wobble: [f64; 3] = std::array::from_fn(|_| self.between(-0.4, 0.4));
        let across = self.direction();
        let aside = across.cross(self.direction()).normalize();
        let up = across.cross(aside);
        let positions = [0, 1, 2].map(|k| {
            let angle = turn + k as f64 * 2.1 + wobble[k];
            in_f32(across * angle.cos() + aside * (angle.sin() * squash))
        });
        let normals = [0, 1, 2].map(|_| {
            let lean = self.between(0.0, tilt.to_radians()).tan();
            let around = self.between(0.0, std::f64::consts::TAU);
            let n = up + across * (lean * around.cos()) + aside * (lean * around.sin());
            in_f32(n.normalize())
        });
        (positions, normals)
    }
}

pub(crate) fn in_f32(v: V) -> V {
    Vector::<f32>::from_f64(v).to_f64()
}

pub(crate) fn rounded(p: [V; 3]) -> [Vector<f32>; 3] {
    p.map(Vector::<f32>::from_f64)
}

fn ray<S: Scalar>(o: V, d: V) -> Ray<S> {
    Ray {
        origin: Vector::from_f64(o),
        direction: Vector::from_f64(d),
        tnear: S::from_f64(0.0),
        tfar: S::HUGE,
    }
}

fn longest(p: [V; 3]) -> f64 {
    let edges = [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
    edges
        .map(|edge| edge.length())
        .into_iter()
        .fold(0.0, f64::max)
}

fn is_curved<S: Scalar>(patch: &Patch<S>) -> bool {
    matches!(patch.kind(), PatchKind::Curved | PatchKind::Fallback)
}

/// The four faces of the regular tetrahedron in the unit sphere; a vertex is its own normal.
fn sphere_tetrahedron() -> [[V; 3]; 4] {
    let s = 1.0 / 3f64.sqrt();
    let p = [
        vector(s, s, s),
        vector(s, -s, -s),
        vector(-s, s, -s),
        vector(-s, -s, s),
    ];
    [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]].map(|f| f.map(|i: usize| p[i]))
}

#[test]
fn four_triangles_make_a_sphere() {
    for surface in Surface::ALL {
        for corners in sphere_tetrahedron() {
            let patch = Patch::new(corners, corners, PatchFlags::new(surface));
            let rough = Patch::new(rounded(corners), rounded(corners), PatchFlags::new(surface));
            assert_eq!(patch.kind(), PatchKind::Curved, "{surface:?}");
            for n in 0..=20 {
                for m in 0..=20 - n {
                    let (u, v) = (f64::from(n) / 20.0, f64::from(m) / 20.0);
                    let point = patch.point(u, v);
                    let error = (point.position.length() - 1.0).abs();
                    assert!(error < 1e-14, "{surface:?} {error:e}");
                    let turn = point.normal.cross(point.position).length();
                    assert!(turn < 1e-4, "{surface:?} {n} {m} {turn} {point:?}");
                    let point = rough.point(u as f32, v as f32);
                    let error = (point.position.to_f64().length() - 1.0).abs();
                    assert!(error < 2e-6, "{surface:?} {error:e}");
                }
            }
        }
    }
}

#[test]
fn the_foot_under_a_surface_point_is_where_it_stands() {
    let mut random = Random(1);
    for (tilt, flatness) in [(10.0, 0.0), (25.0, 0.5), (40.0, 0.5), (30.0, 1.0)] {
        for surface in Surface::ALL {
            for _ in 0..1000 {
                let (p, n) = random.triangle(tilt, flatness);
                let patch = Patch::new(p, n, PatchFlags::new(surface));
                for _ in 0..if is_curved(&patch) { 20 } else { 0 } {
                    let [u, v] = random.inside();
                    let point = patch.point(u, v).position;
                    // Straight down onto the plane, by a ray along its normal.
                    let down = ray::<f64>(point, -patch.plane_normal());
                    let over = Segment::unclipped_at_start(&patch, &down);
                    let foot = patch.foot_under(over.projection(0.0), over.z(0.0));
                    let error = (foot.b[1] - u).abs().max((foot.b[2] - v).abs());
                    assert!(
                        error < 1e-8,
                        "{surface:?} {tilt} {flatness}: {error:e} {p:?} {n:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn no_surface_point_leaves_the_bounds() {
    let mut random = Random(2);
    for surface in Surface::ALL {
        for tilt in [10.0, 30.0, 45.0, 60.0] {
            let (mut curved, mut boxes, mut truth) = (0, 0.0, 0.0);
            for _ in 0..1000 {
                let (p, n) = random.triangle(tilt, 0.7);
                let patch = Patch::new(p, n, PatchFlags::new(surface));
                let [lo, hi] = patch.bounds();
                let [zmin, zmax] = patch.heights();
                let (mut least, mut most) = (p[0], p[0]);
                for _ in 0..100 {
                    let [u, v] = random.inside();
                    let r = patch.point(u, v).position;
                    let inside = lo.x <= r.x && r.x <= hi.x && lo.y <= r.y && r.y <= hi.y;
                    assert!(
                        inside && lo.z <= r.z && r.z <= hi.z,
                        "{surface:?} {tilt} {p:?} {n:?}"
                    );
                    let z = (r - p[0]).dot(patch.plane_normal());
                    assert!(
                        zmin - 1e-15 <= z && z <= zmax + 1e-15,
                        "{surface:?} {tilt} {z}"
                    );
                    least = vector(least.x.min(r.x), least.y.min(r.y), least.z.min(r.z));
                    most = vector(most.x.max(r.x), most.y.max(r.y), most.z.max(r.z));
                }
                for v in p {
                    least = vector(least.x.min(v.x), least.y.min(v.y), least.z.min(v.z));
                    most = vector(most.x.max(v.x), most.y.max(v.y), most.z.max(v.z));
                }
                curved += usize::from(is_curved(&patch));
                boxes += half_area(hi - lo);
                truth += half_area(most - least);
            }
            let ratio = boxes / truth;
            println!(
                "{surface:?} tilted by up to {tilt}: {curved} of 1000 curved, box {ratio:.2} of the true one's area"
            );
            assert!(tilt > 20.0 || ratio < 1.3, "{surface:?} {tilt}: {ratio}");
            assert!(
                curved > if tilt > 50.0 { 500 } else { 900 },
                "{surface:?} {tilt}: {curved}"
            );
        }
    }
}

fn half_area(d: V) -> f64 {
    d.x * d.y + d.y * d.z + d.z * d.x
}

#[test]
fn normals_at_the_vertices_are_the_given_ones() {
    let mut random = Random(4);
    let mut worst = 0.0f64;
    for _ in 0..2000 {
        let (p, n) = random.triangle(10.0, 0.3);
        let patch = Patch::<f32>::new(rounded(p), rounded(n), PatchFlags::new(Surface::Smooth));
        assert!(is_curved(&patch));
        for (i, (u, v)) in [(0.0005f32, 0.0005f32), (0.999, 0.0005), (0.0005, 0.999)]
            .into_iter()
            .enumerate()
        {
            let normal = patch.normal_at(u, v).to_f64();
            let turn = normal.cross(n[i]).length().asin().to_degrees();
            worst = worst.max(turn);
        }
    }
    println!("normal at b = 0.999 off by up to {worst:.3} degrees");
    assert!(worst < 0.1, "{worst}");
}

/// Where a ray first meets a patch, by sampling it densely.
fn dense_first_root(patch: &Patch<f64>, ray: &Ray<f64>) -> Option<f64> {
    const PARTS: usize = 2000;
    let segment = Segment::new(patch, ray, &patch.clip(ray, true));
    let f = |at: f64| {
        let z = segment.z(at);
        z - patch.height(&patch.foot_under(segment.projection(at), z))
    };
    let at = |n: usize| segment.length * n as f64 / PARTS as f64;
    let mut last = f(0.0);
    (1..=if segment.alive { PARTS } else { 0 }).find_map(|n| {
        let value = f(at(n));
        let crossed = (value < 0.0) != (last < 0.0);
        last = value;
        crossed.then(|| segment.start + 0.5 * (at(n - 1) + at(n)))
    })
}

#[test]
fn the_first_root_is_the_first() {
    let mut random = Random(5);
    let (mut total, mut wrong) = (0, 0);
    for _ in 0..600 {
        let (p, n) = random.triangle(20.0, 0.5);
        let flags = PatchFlags::new(Surface::Smooth);
        let patch = Patch::<f64>::new(p, n, flags);
        let single = Patch::<f32>::new(rounded(p), rounded(n), flags);
        for _ in 0..if is_curved(&patch) { 60 } else { 0 } {
            let [u, v] = random.inside();
            let target = patch.point(u, v).position + random.direction() * 0.3;
            let d = in_f32(random.direction());
            let o = in_f32(target - d * 5.0);
            let first = dense_first_root(&patch, &ray(o, d));
            let hit = single.intersect(&ray::<f32>(o, d), Solver::default());
            total += 1;
            wrong += usize::from(match first {
                Some(t) => !(hit.found && (f64::from(hit.t) - t).abs() < 5e-3),
                // Dense sampling misses closer pairs of roots than the solver does.
                None => false,
            });
        }
    }
    println!("first root wrong for {wrong} of {total} rays");
    assert!(
        total > 10_000 && wrong as f64 <= 1e-4 * f64::from(total),
        "{wrong} of {total}"
    );
}

#[test]
fn both_solvers_agree() {
    let mut random = Random(6);
    let (mut hits, mut differ) = (0, 0);
    for _ in 0..500 {
        let (p, n) = random.triangle(20.0, 0.5);
        let patch = Patch::<f64>::new(p, n, PatchFlags::new(Surface::Tensor));
        for _ in 0..if is_curved(&patch) { 20 } else { 0 } {
            let [u, v] = random.inside();
            let d = random.direction();
            let r = ray::<f64>(patch.point(u, v).position - d * 3.0, d);
            let finish = patch.intersect(&r, Solver::default());
            let ita = patch.intersect(&r, Solver::Ita { bits: 36, step: 3 });
            hits += usize::from(finish.found);
            let same = finish.found == ita.found && (finish.t - ita.t).abs() < 1e-7;
            differ += usize::from(!same);
        }
    }
    println!("the solvers differ on {differ} of {hits} hits");
    assert!(hits > 5000 && differ * 500 < hits, "{differ} of {hits}");
}

#[test]
fn feet_stay_in_their_triangle_however_far_rays_come_from() {
    let mut random = Random(17);
    let mut met = 0;
    for n in 0..20_000 {
        let (p, v) = random.triangle([0.0, 3.0, 20.0][n % 3], 0.3);
        let patch = Patch::<f32>::new(rounded(p), rounded(v), PatchFlags::default());
        let away = 10f64.powi((n % 15) as i32);
        let target = p[0] + (p[1] - p[0]) * random.unit() + (p[2] - p[0]) * random.unit();
        let way = random.direction();
        let hit = patch.intersect(&ray(target - way * away, way * away), Solver::default());
        if hit.found {
            met += 1;
            let inside = -1e-4..=1.0 + 1e-4f32;
            let b = [hit.u, hit.v, 1.0 - hit.u - hit.v];
            assert!(b.iter().all(|b| inside.contains(b)), "{b:?} from {away}");
        }
    }
    assert!(met > 5_000, "{met}");
}

/// Found by fuzzing: the coordinates, rounded apart, once told a foot half the triangle outside.
#[test]
fn a_needle_s_foot_stays_in_it_under_a_ray_from_very_far() {
    let positions: [Vector<f32>; 3] = [
        vector(-0.22622448, 0.3204025, -0.94894063),
        vector(-0.20649645, 0.23771979, -0.95014507),
        vector(-0.33088812, 0.21944325, -1.0070412),
    ];
    let across = (positions[1] - positions[0]).cross(positions[2] - positions[0]);
    let normals = [across.normalize(); 3];
    let patch = Patch::<f32>::new(positions, normals, PatchFlags::default().with_flat());
    let ray = Ray {
        origin: vector(0.23109266, 401274.3, 2.6413533e13),
        direction: vector(-8.3699e-12, -321018.9, -2.1130826e13),
        tnear: 0.0,
        tfar: f32::INFINITY,
    };
    let hit = patch.intersect(&ray, Solver::default());
    assert!(hit.found);
    let inside = -1e-4..=1.0 + 2e-4f32;
    let b = [hit.u, hit.v, 1.0 - hit.u - hit.v];
    assert!(b.iter().all(|b| inside.contains(b)), "{b:?}");
}

/// Found by fuzzing: so fast a ray overflows in units of so small a triangle, and what is no number passed for
/// inside.
#[test]
fn a_ray_beyond_all_numbers_hits_nothing_that_is_none() {
    let positions: [Vector<f32>; 3] = [
        vector(5.180671e-27, 5.1807204e-27, 5.180671e-27),
        vector(5.1807204e-27, 5.180671e-27, 5.1807204e-27),
        vector(5.180671e-27, 5.1785017e-27, 5.1807204e-27),
    ];
    let normals = [vector(1.0, 1.0, 1.0).normalize(); 3];
    for (surface, solver) in Surface::ALL
        .into_iter()
        .flat_map(|surface| [(surface, Solver::ITA), (surface, Solver::default())])
    {
        let flags = PatchFlags::new(surface).with_unchecked();
        let patch = Patch::<f32>::new(positions, normals, flags);
        for speed in [1.0, 1e4, 1e8, 1.9581848e8, 1e9, 1e12] {
            let ray = Ray {
                origin: vector(5.1806468e-27, -4.2479703e-22, -4.247955e-22),
                direction: vector(0.0, speed, speed * 0.9999965),
                tnear: 0.0,
                tfar: f32::INFINITY,
            };
            let hit = patch.intersect(&ray, solver);
            let finite = [hit.t, hit.u, hit.v].iter().all(|x| x.is_finite());
            assert!(finite || !hit.found, "{speed} {hit:?}");
        }
    }
}

/// Neighbours overlap beyond a straight edge, and a ray that meets the edge must not touch the surface there
/// and leave it again, as at a kink.
#[test]
fn the_surface_goes_on_beyond_a_straight_edge() {
    for (n, positions) in capped_wall().into_iter().enumerate() {
        let normals = positions.map(|p| vector(p.x, p.y, 0.0));
        let flags = (0..3)
            .filter(|&k| positions[k].z == positions[(k + 1) % 3].z)
            .fold(PatchFlags::default(), PatchFlags::with_straight);
        let patch = Patch::<f64>::new(positions, normals, flags);
        assert!(is_curved(&patch), "triangle {n}");
        for k in (0..3).filter(|&k| flags.is_straight(k)) {
            for step in 1..10 {
                let along = f64::from(step) / 10.0;
                let [inside, outside] = [1e-4, -1e-5].map(|off| {
                    let mut b = [0.0; 3];
                    b[(k + 2) % 3] = off;
                    b[(k + 1) % 3] = along;
                    b[k] = 1.0 - along - off;
                    patch.normal_at(b[1], b[2])
                });
                let turn = inside.cross(outside).length();
                assert!(
                    turn < 1e-3,
                    "triangle {n} at {along}: {inside:?} {outside:?}"
                );
            }
        }
    }
}

/// The two triangles of a wall of a cylinder of five, with right angles at its rims.
fn capped_wall() -> [[V; 3]; 2] {
    let corner = |n: f64, z: f64| {
        let (sine, cosine) = (n * std::f64::consts::TAU / 5.0).sin_cos();
        vector(cosine, sine, z)
    };
    let [a, b, c, d] = [
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.5),
        corner(0.0, 1.5),
    ];
    [[a, b, c], [a, c, d]]
}

#[test]
fn odd_input_makes_no_surface_and_no_panic() {
    let good = [
        vector(0.0, 0.0, 0.0),
        vector(1.0, 0.0, 0.0),
        vector(0.0, 1.0, 0.0),
    ];
    let up = [vector(0.0, 0.0, 1.0); 3];
    let flags = PatchFlags::default();
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let mut p = good;
        p[1].x = odd;
        assert_eq!(
            Patch::new(p, up, flags).kind(),
            PatchKind::Degenerate,
            "{odd}"
        );
        let mut n = up;
        n[2].y = odd;
        let kind = Patch::new(good, n, flags).kind();
        assert!(matches!(kind, PatchKind::Flat(_)), "{odd} {kind:?}");
    }
    let point = Patch::new([good[0]; 3], up, flags);
    assert_eq!(point.kind(), PatchKind::Degenerate);
    let hit = point.intersect(
        &ray::<f64>(vector(0.0, 0.0, 1.0), vector(0.0, 0.0, -1.0)),
        Solver::default(),
    );
    assert!(!hit.found);
    let [lo, hi] = point.bounds();
    assert!(lo.x > hi.x, "a degenerate triangle has no box");
}

#[test]
fn a_record_gives_the_patch_back() {
    let mut random = Random(8);
    for surface in Surface::ALL {
        for _ in 0..300 {
            let (p, n) = random.triangle(40.0, 0.8);
            let (p, n) = (rounded(p), rounded(n));
            let flags = PatchFlags::new(surface).with_straight(1);
            let patch = Patch::new(p, n, flags);
            let again = Patch::unpack(p, n, &patch.pack(flags));
            assert_eq!(patch.kind(), again.kind());
            assert_eq!(patch.heights(), again.heights());
            let (a, b) = (patch.point(0.3f32, 0.4), again.point(0.3f32, 0.4));
            assert_eq!(a.position, b.position);
            assert_eq!(a.normal, b.normal);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// What `f32` finds is on the `f64` surface, and where `f64` finds it: over ten decades of
    /// size, far offsets, gentle to steep normals, equilateral to very obtuse triangles.
    #[test]
    fn f32_agrees_with_f64(
        seed in any::<u64>(),
        tilt in 0.0..60.0f64,
        flatness in 0.0..1.0f64,
        decade in -5.0..5.0f64,
        offset in 0.0..30.0f64,
        away in 0.5..30.0f64,
        surface in 0usize..3,
    ) {
        let mut random = Random(seed);
        let (p, n) = random.triangle(tilt, flatness);
        let scale = 10f64.powf(decade);
        let shift = random.direction() * offset;
        let p = p.map(|v| in_f32((v + shift) * scale));
        let flags = PatchFlags::new(Surface::ALL[surface]);
        let oracle = Patch::<f64>::new(p, n, flags);
        let single = Patch::<f32>::new(rounded(p), rounded(n), flags);
        // A triangle right at a threshold may fall on either side of it.
        prop_assume!(oracle.kind() == single.kind());
        let [u, v] = random.inside();
        let d = in_f32(random.direction() * random.between(0.3, 3.0));
        let o = in_f32(oracle.point(u, v).position - d * (scale * away));
        let hit = single.intersect(&ray::<f32>(o, d), Solver::default());
        let expected = oracle.intersect(&ray::<f64>(o, d), Solver::default());
        if hit.found {
            check_hit(&oracle, &single, p, (o, d), (hit, expected));
        }
    }
}

fn check_hit(
    oracle: &Patch<f64>,
    single: &Patch<f32>,
    p: [V; 3],
    (o, d): (V, V),
    (hit, expected): (Hit<f32>, Hit<f64>),
) {
    let epsilon = f64::from(f32::EPSILON);
    let (size, t) = (longest(p), f64::from(hit.t));
    let point = oracle.point(f64::from(hit.u), f64::from(hit.v));
    let error = (point.position - (o + d * t)).length();
    let allowed = 1e-5 * size + 8.0 * epsilon * (o.length() + t * d.length());
    assert!(error <= allowed, "residual {error:e} of {allowed:e}");
    let normal = single.normal_at(hit.u, hit.v).to_f64();
    let turn = normal
        .cross(point.normal)
        .length()
        .atan2(normal.dot(point.normal))
        .to_degrees();
    assert!(turn <= 0.5, "normal off by {turn} degrees");
    let b = [1.0 - hit.u - hit.v, hit.u, hit.v];
    assert!(b.iter().all(|b| (-1e-4..=1.0 + 1e-4).contains(b)), "{b:?}");
    // The parameters differ by rounding over the slope at which the ray meets the surface; where it grazes
    // the surface first, rounding may leave that root out.
    let slope_of = |normal: V| normal.dot(d).abs() / d.length();
    let first = oracle.normal_at(expected.u, expected.v);
    let slope = slope_of(point.normal).min(slope_of(first)).max(1e-3);
    let near = 1e-4 * size + 8.0 * epsilon * ((o - p[0]).length() + t * d.length());
    let way = (expected.t - t).abs() * d.length();
    if expected.found && slope > 0.1 {
        assert!(
            way <= near / slope,
            "t {t} but {}, {way:e} of {near:e}",
            expected.t
        );
    }
}
