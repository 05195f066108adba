//! Tests of the kernel as a whole: whole bodies, inverse against forward, bounds, `f32` against
//! `f64`, residuals.

use super::*;

type V = Vector<f64>;

/// splitmix64: random numbers that are the same everywhere.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }
    /// Barycentric u, v of a point of the triangle.
    fn inside(&mut self) -> [f64; 2] {
        let (u, v) = (self.unit(), self.unit());
        if u + v > 1.0 {
            [1.0 - u, 1.0 - v]
        } else {
            [u, v]
        }
    }
    fn direction(&mut self) -> V {
        loop {
            let v = vector(
                self.between(-1.0, 1.0),
                self.between(-1.0, 1.0),
                self.between(-1.0, 1.0),
            );
            if (0.01..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
    /// A triangle of about unit size with normals tilted by up to `tilt` degrees, `flatness` from
    /// 0 (equilateral) to 1 (very thin or obtuse), all numbers exact in `f32`.
    fn triangle(&mut self, tilt: f64, flatness: f64) -> ([V; 3], [V; 3]) {
        let squash = 1.0 - 0.97 * flatness * self.unit();
        let turn = self.between(0.0, 6.3);
        let corner = |k: f64, wobble: f64| {
            let a = turn + k * 2.1 + wobble;
            (a.cos(), a.sin() * squash)
        };
        let wobble: [f64; 3] = std::array::from_fn(|_| self.between(-0.4, 0.4));
        let across = self.direction();
        let aside = across.cross(self.direction()).normalize();
        let up = across.cross(aside);
        let positions = [0, 1, 2].map(|k| {
            let (x, y) = corner(k as f64, wobble[k]);
            in_f32(across * x + aside * y)
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

fn in_f32(v: V) -> V {
    Vector::<f32>::from_f64(v).to_f64()
}

fn sphere_tetrahedron() -> Vec<[V; 3]> {
    let s = 1.0 / 3f64.sqrt();
    let p = [
        vector(s, s, s),
        vector(s, -s, -s),
        vector(-s, s, -s),
        vector(-s, -s, s),
    ];
    [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
        .map(|f| f.map(|i: usize| p[i]))
        .to_vec()
}

#[test]
fn four_triangles_make_a_sphere() {
    for surface in Surface::ALL {
        for corners in sphere_tetrahedron() {
            let patch = Patch::new(corners, corners, PatchFlags::new(surface));
            assert_eq!(patch.kind(), PatchKind::Curved, "{surface:?}");
            for n in 0..=20 {
                for m in 0..=20 - n {
                    let point = patch.point(f64::from(n) / 20.0, f64::from(m) / 20.0);
                    assert!(
                        (point.position.length() - 1.0).abs() < 1e-14,
                        "{surface:?} {point:?}"
                    );
                    let turn = point.normal.cross(point.position).length();
                    assert!(turn < 1e-4, "{surface:?} {n} {m} {turn} {point:?}");
                }
            }
        }
    }
}

#[test]
fn the_foot_under_a_surface_point_is_where_it_stands() {
    let mut random = Random(1);
    for (tilt, flatness) in [(10.0, 0.0), (25.0, 0.5), (40.0, 0.5), (30.0, 1.0)] {
        let (mut wrong, mut total, mut flat) = (0, 0, 0);
        let mut worst = 0.0f64;
        for _ in 0..3000 {
            let (p, n) = random.triangle(tilt, flatness);
            let patch = Patch::new(p, n, PatchFlags::new(Surface::Smooth));
            if matches!(patch.kind(), PatchKind::Flat(_)) {
                flat += 1;
                continue;
            }
            for _ in 0..20 {
                let [u, v] = random.inside();
                let b = [1.0 - u - v, u, v];
                let foot = patch.foot_at::<f64, f64>(b);
                let h = patch.height(&foot);
                // The vertical projection of the point raised by h along the guide.
                let m = [2, 0, 1][if foot.choice.is(0) {
                    0
                } else if foot.choice.is(1) {
                    1
                } else {
                    2
                }];
                let k = (m + 1) % 3;
                let shift = foot.lean * h / patch.sides[k].height;
                let mu = patch.sides[k].foot;
                let mut above = b;
                above[m] += shift;
                above[(k + 1) % 3] -= shift * mu;
                above[k] -= shift * (1.0 - mu);
                let back = patch.foot_under(above, h);
                let error = (0..3).map(|i| (back.b[i] - b[i]).abs()).fold(0.0, f64::max);
                total += 1;
                if error > 1e-9 {
                    wrong += 1;
                    worst = worst.max(error);
                    if wrong % 20 == 1 {
                        let side = &patch.sides[k];
                        println!(
                            "tilt: obtuse {} foot {:.2} H {:.2} lean {:.2} tilt {:.2} h {:.3} b {:.3?} m {m} shift {:.3} above {:.3?} back {:.3?} bm {:.3} kinds {:?} {:?}",
                            side.obtuse,
                            side.foot,
                            side.height,
                            side.lean,
                            side.tilt,
                            h,
                            b,
                            shift,
                            above,
                            back.b,
                            b[m],
                            patch.kind(),
                            bounds::folds(&patch)
                        );
                    }
                }
            }
        }
        println!(
            "tilt {tilt} flatness {flatness}: {wrong} of {total} wrong, worst {worst:.1e}, flat {flat} of 3000"
        );
    }
}

#[test]
fn probe_bounds() {
    let mut random = Random(2);
    for surface in Surface::ALL {
        for tilt in [10.0, 20.0, 30.0, 45.0, 60.0] {
            let (mut out, mut total, mut kinds) = (0, 0, std::collections::BTreeMap::new());
            let (mut area, mut truth) = (0.0, 0.0);
            let (mut slab, mut slabtrue) = (0.0, 0.0);
            let mut worst = 0.0f64;
            for _ in 0..2000 {
                let (p, n) = random.triangle(tilt, 0.7);
                let patch = Patch::new(p, n, PatchFlags::new(surface));
                *kinds.entry(format!("{:?}", patch.kind())).or_insert(0) += 1;
                if matches!(patch.kind(), PatchKind::Flat(_)) {
                    continue;
                }
                let [lo, hi] = patch.bounds();
                let (mut tlo, mut thi) = (vector(1e9f64, 1e9, 1e9), vector(-1e9f64, -1e9, -1e9));
                let (mut zl, mut zh) = (0.0f64, 0.0f64);
                for _ in 0..300 {
                    let [u, v] = random.inside();
                    let r = patch.point(u, v).position;
                    total += 1;
                    let o = [
                        lo.x - r.x,
                        r.x - hi.x,
                        lo.y - r.y,
                        r.y - hi.y,
                        lo.z - r.z,
                        r.z - hi.z,
                    ]
                    .into_iter()
                    .fold(-1e9, f64::max);
                    if o > 0.0 {
                        out += 1;
                        worst = worst.max(o);
                    }
                    tlo = vector(tlo.x.min(r.x), tlo.y.min(r.y), tlo.z.min(r.z));
                    thi = vector(thi.x.max(r.x), thi.y.max(r.y), thi.z.max(r.z));
                    let z = (r - p[0]).dot(patch.plane_normal());
                    zl = zl.min(z);
                    zh = zh.max(z);
                }
                let a = |d: V| d.x * d.y + d.y * d.z + d.z * d.x;
                area += a(hi - lo);
                truth += a(thi - tlo);
                let [l, h] = patch.heights();
                slab += h - l;
                slabtrue += zh - zl;
            }
            println!(
                "{surface:?} tilt {tilt}: {out} of {total} out ({worst:.1e}), box ratio {:.3} slab {:.2} {kinds:?}",
                area / truth,
                slab / slabtrue
            );
        }
    }
}

fn ray<S: Scalar>(o: V, d: V) -> Ray<S> {
    Ray {
        origin: Vector::from_f64(o),
        direction: Vector::from_f64(d),
        tnear: S::from_f64(0.0),
        tfar: S::HUGE,
    }
}

fn rounded(p: [V; 3]) -> [Vector<f32>; 3] {
    p.map(Vector::<f32>::from_f64)
}

#[test]
fn probe_f32() {
    let mut random = Random(3);
    let eps = f64::from(f32::EPSILON);
    for surface in Surface::ALL {
        for (tilt, flatness, scale, offset, far) in [
            (10.0, 0.3, 1.0, 0.0, 3.0),
            (30.0, 0.3, 1.0, 0.0, 3.0),
            (30.0, 1.0, 1.0, 0.0, 3.0),
            (20.0, 0.3, 1e-5, 0.0, 3.0),
            (20.0, 0.3, 1e5, 0.0, 3.0),
            (20.0, 0.3, 1.0, 100.0, 3.0),
            (20.0, 0.3, 1.0, 0.0, 1000.0),
        ] {
            let (mut total, mut hits32, mut hits64, mut differ, mut missed, mut extra) =
                (0, 0, 0, 0, 0, 0);
            let (mut residual, mut angle, mut evals) = (0.0f64, 0.0f64, 0u64);
            let mut bad = 0;
            let mut badangle = 0;
            for _ in 0..3000 {
                let (p, n) = random.triangle(tilt, flatness);
                let shift = random.direction() * offset;
                let p = p.map(|v| in_f32(v * scale + shift * scale));
                let flags = PatchFlags::new(surface);
                let patch = Patch::<f64>::new(p, n, flags);
                let patch32 = Patch::<f32>::new(rounded(p), rounded(n), flags);
                if patch.kind() != patch32.kind() {
                    differ += 1;
                    continue;
                }
                for _ in 0..20 {
                    let [u, v] = random.inside();
                    let target = patch.point(u, v).position;
                    let d = in_f32(random.direction() * random.between(0.5, 2.0));
                    let o = in_f32(target - d * (scale * far));
                    let (r64, r32) = (ray::<f64>(o, d), ray::<f32>(o, d));
                    let (a, b) = (
                        patch.intersect(&r64, Solver::default()),
                        patch32.intersect(&r32, Solver::default()),
                    );
                    total += 1;
                    hits64 += usize::from(a.found);
                    hits32 += usize::from(b.found);
                    evals += u64::from(b.evaluations);
                    if a.found && !b.found {
                        missed += 1;
                    }
                    if b.found && !a.found {
                        extra += 1;
                    }
                    if b.found {
                        let t = f64::from(b.t);
                        let q = o + d * t;
                        let sp = patch.point(f64::from(b.u), f64::from(b.v));
                        let error = (sp.position - q).length();
                        let s = (p[1] - p[0])
                            .length()
                            .max((p[2] - p[0]).length())
                            .max((p[2] - p[1]).length());
                        let allowed = 1e-5 * s + 8.0 * eps * (o.length() + t * d.length());
                        residual = residual.max(error / allowed);
                        if error > allowed {
                            bad += 1;
                            if bad % 40 == 1 {
                                let at = |tt: f64| {
                                    let seg = super::ray::Segment::clip(&patch, &r64);
                                    let x = tt - seg.start;
                                    let z = seg.z(x);
                                    let foot = patch.foot_under(seg.projection(x), z);
                                    (
                                        z,
                                        patch.height(&foot),
                                        foot.b,
                                        seg.projection(x),
                                        seg.start,
                                        seg.length,
                                    )
                                };
                                println!(
                                    "BAD {:?} {:.3?} {:.3?} cos {:.3?} {error:.2e} allowed {allowed:.1e} u {} v {} t {t} t64 {:?} {:.4?} obtuse {:?} leans {:.3?} slab {:.4?}",
                                    patch.kind(),
                                    patch.sides.map(|s| s.correction),
                                    patch32.sides.map(|s| s.correction),
                                    patch.vertices.map(|v| v.normal),
                                    b.u,
                                    b.v,
                                    a.found.then_some(a.t),
                                    at(t),
                                    patch.sides.map(|s| (s.obtuse, s.foot)),
                                    patch.sides.map(|s| s.lean),
                                    patch.slab
                                );
                            }
                        }
                        let n32 = patch32.normal_at(b.u, b.v).to_f64();
                        let turn = n32.cross(sp.normal).length().asin().to_degrees();
                        angle = angle.max(turn);
                        if turn > 0.5 {
                            badangle += 1;
                        }
                        if a.found
                            && (a.t - t).abs()
                                > 1e-4 * s + 8.0 * eps * ((o - p[0]).length() + t * d.length())
                        {
                            differ += 1;
                        }
                    }
                }
            }
            println!(
                "{surface:?} {tilt} {flatness} {scale:e} {offset} {far}: {total} rays, {hits64} {hits32} missed {missed} extra {extra} differ {differ} residual {residual:.3} bad {bad} angle {angle:.3} {badangle} evals {:.1}",
                evals as f64 / total as f64
            );
        }
    }
}

#[test]
fn probe_first_roots() {
    let mut random = Random(5);
    for (tilt, flatness) in [(15.0, 0.5), (30.0, 0.5)] {
        let solvers = [
            Solver::Ita { bits: 24, step: 3 },
            Solver::Ita { bits: 24, step: 4 },
            Solver::Finish { parts: 8 },
            Solver::Finish { parts: 12 },
            Solver::Finish { parts: 16 },
        ];
        let mut wrong = [0; 5];
        let mut missed = [0; 5];
        let mut evals = [0u64; 5];
        let mut total = 0;
        let mut none = 0;
        let mut roots = [0; 8];
        let mut outside_aim = 0;
        for _ in 0..1000 {
            let (p, n) = random.triangle(tilt, flatness);
            let patch = Patch::<f64>::new(p, n, PatchFlags::new(Surface::Smooth));
            if !matches!(patch.kind(), PatchKind::Curved | PatchKind::Fallback) {
                continue;
            }
            for _ in 0..200 {
                let [u, v] = random.inside();
                let target = patch.point(u, v);
                // half of them grazing
                let mut d = random.direction();
                if random.unit() < 0.0 {
                    d = (d - target.normal * (d.dot(target.normal) * random.between(0.8, 1.0)))
                        .normalize();
                }
                let r = ray::<f64>(target.position + random.direction() * 0.3 - d * 5.0, d);
                let seg = super::ray::Segment::clip(&patch, &r);
                if !seg.alive {
                    outside_aim += 1;
                    continue;
                }
                let f = |at: f64| {
                    let z = seg.z(at);
                    z - patch.height(&patch.foot_under(seg.projection(at), z))
                };
                total += 1;
                let mut last = f(0.0);
                let mut first = None;
                let mut count = 0;
                for k in 1..=2000 {
                    let x = seg.length * k as f64 / 2000.0;
                    let y = f(x);
                    if (y < 0.0) != (last < 0.0) {
                        count += 1;
                        if first.is_none() {
                            first = Some(seg.start + x - seg.length / 4000.0);
                        }
                    }
                    last = y;
                }
                roots[count.min(7)] += 1;
                if first.is_none() {
                    none += 1;
                }
                for (k, s) in solvers.iter().enumerate() {
                    let hit = patch.intersect(&r, *s);
                    evals[k] += hit.evaluations as u64;
                    match (first, hit.found) {
                        (Some(t), true) => {
                            if (t - hit.t).abs() > 1e-3 + seg.length / 1000.0 {
                                wrong[k] += 1
                            }
                        }
                        (Some(_), false) => missed[k] += 1,
                        _ => {}
                    }
                }
            }
        }
        println!(
            "tilt {tilt} {flatness}: {total} rays dead {outside_aim} none {none} roots {roots:?} wrong {wrong:?} missed {missed:?} evals {:.1?}",
            evals.map(|e| e as f64 / total as f64)
        );
    }
}
