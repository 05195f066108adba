//! The strongest test: what a ray hits is on the surface, by the `f64` oracle.

use std::cell::OnceCell;

use curvetri::embree::Ray;
use curvetri::method::{Patch, Vector};
use curvetri_bodies::SplitMix;
use curvetri_test_support::{Body, Traced, first_hit};
use glam::Vec3;

/// A hit's point may be this far from the oracle's, in units of the triangle's longest side ...
const MAX_RESIDUAL: f64 = 1e-5;
/// ... and this many epsilons of the ray's coordinates.
const RAY_ULPS: f64 = 8.0;
const MAX_NORMAL_DEGREES: f64 = 0.5;
const MAX_OUTSIDE: f32 = 1e-4;

#[derive(Debug, Default)]
struct Worst {
    hits: usize,
    /// Residual over what is allowed.
    residual: f64,
    normal_degrees: f64,
    outside: f32,
}

/// A mesh's patches in `f64`, made when they are first asked for.
type Oracles = [OnceCell<Patch<f64>>];

fn check(traced: &Traced, oracles: &Oracles, ray: &Ray, worst: &mut Worst) {
    let Some(hit) = first_hit(&traced.scene, ray) else {
        return;
    };
    if hit.geom_id != 0 {
        // What is apart is Embree's own triangle, u and v rounded its way.
        return;
    }
    let triangle = hit.prim_id as usize;
    let oracle = oracles[triangle].get_or_init(|| traced.curved.oracle(hit.prim_id));
    let point = oracle.point(f64::from(hit.u), f64::from(hit.v));
    let wide = |v: Vec3| Vector::<f64>::from(v);
    let (o, d, t) = (wide(ray.origin), wide(ray.direction), f64::from(hit.t));
    let mesh = traced.curved.mesh();
    let p = mesh.triangle_positions(triangle);
    let longest = [p[1] - p[0], p[2] - p[1], p[0] - p[2]].map(Vec3::length);
    let size = f64::from(longest.into_iter().fold(0.0, f32::max));
    let ulps = RAY_ULPS * f64::from(f32::EPSILON) * (o.length() + t * d.length());
    let residual = (point.position - (o + d * t)).length() / (MAX_RESIDUAL * size + ulps);
    let ng = wide(hit.ng).normalize();
    let turn = ng
        .cross(point.normal)
        .length()
        .atan2(ng.dot(point.normal))
        .to_degrees();
    let b = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let outside = b
        .into_iter()
        .fold(0.0f32, |out, b| out.max(-b).max(b - 1.0));
    worst.hits += 1;
    worst.residual = worst.residual.max(residual);
    worst.normal_degrees = worst.normal_degrees.max(turn);
    worst.outside = worst.outside.max(outside);
    assert!(
        residual <= 1.0,
        "{:?} {:?}{}: {residual} of what is allowed, {ray:?} {hit:?}",
        oracle.kind(),
        longest,
        traced.name
    );
    assert!(
        turn <= MAX_NORMAL_DEGREES,
        "{}: {turn} degrees, {ray:?} {hit:?}",
        traced.name
    );
    assert!(
        outside <= MAX_OUTSIDE,
        "{}: {outside} outside, {ray:?} {hit:?}",
        traced.name
    );
}

/// Rays at random through the body's bounds, from near and far.
fn shoot(traced: &Traced, count: usize) -> Worst {
    let mut random = SplitMix::new(3);
    let mut worst = Worst::default();
    let bounds = traced.scene.bounds();
    let (centre, half) = (
        (bounds.lower + bounds.upper) * 0.5,
        (bounds.upper - bounds.lower) * 0.5,
    );
    let oracles = vec![OnceCell::new(); traced.curved.mesh().triangles().len()];
    for n in 0..count {
        let target = centre + half * random.in_cube();
        let direction = random.direction() * [1.0, 0.01, 100.0][n % 3];
        let away = [0.0, 1.5, 30.0][n / 3 % 3] * half.length() / direction.length();
        check(
            traced,
            &oracles,
            &Ray::new(target - direction * away, direction),
            &mut worst,
        );
    }
    worst
}

fn check_all(bodies: Vec<Body>, count: usize) {
    for body in bodies {
        for options in curvetri_test_support::all_forms() {
            let traced = body.traced_with(&options);
            let worst = shoot(&traced, count);
            println!(
                "{} {options:?}: {worst:?} {:?}",
                body.name,
                traced.curved.kinds()
            );
        }
    }
}

#[test]
fn hits_on_made_meshes_lie_on_the_surface() {
    check_all(curvetri_test_support::made_bodies(), 50_000);
}

#[test]
fn hits_on_real_meshes_lie_on_the_surface() {
    let names = [
        "spot/spot_triangulated.obj",
        "spot/spot_control_mesh.obj",
        "bunny_2k.obj",
        "armadillo_29k.obj",
        "teapot_1k.obj",
        "fish_low.obj",
        "umbrella/umbrellaFolded.obj",
        "cooktop/mano_cooktop.obj",
        "offset_shells.obj",
        "spider/spider.obj",
        "wuson.obj",
    ];
    check_all(curvetri_test_support::real_meshes(&names), 100_000);
}
