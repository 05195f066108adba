//! No point of the surface leaves its triangle's box, and boxes are hardly larger than they must be.

mod support;

use curvetri::embree::{Bounds, UserGeometry};
use curvetri::surface::Surface;
use glam::Vec3;
use support::{Body, Random};

/// Mean area of the boxes over that of the true ones.
const MAX_RATIO: f64 = 1.3;

fn half_area(bounds: &Bounds) -> f64 {
    let d = (bounds.upper - bounds.lower).as_dvec3();
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// Checks a body's boxes by points of the `f64` surface; the ratio of the areas.
fn check(body: &Body, surface: Surface) -> f64 {
    let curved = body.traced(surface).curved;
    let mut random = Random(17);
    let (mut boxes, mut truth) = (0.0, 0.0);
    for triangle in 0..curved.primitives() {
        let bounds = curved.bounds(triangle, 0);
        if bounds.is_empty() {
            continue; // a degenerate triangle
        }
        let oracle = curved.oracle(triangle);
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let inside = (0..30).map(|_| {
            let b = random.barycentric();
            [f64::from(b[1]), f64::from(b[2])]
        });
        let mut tight = Bounds::EMPTY;
        for [u, v] in corners.into_iter().chain(inside) {
            let p = oracle.point(u, v).position;
            let within =
                |lower: f32, p: f64, upper: f32| f64::from(lower) <= p && p <= f64::from(upper);
            let (l, h) = (bounds.lower, bounds.upper);
            let ok = within(l.x, p.x, h.x) && within(l.y, p.y, h.y) && within(l.z, p.z, h.z);
            assert!(
                ok,
                "{} {surface:?} triangle {triangle}: {p:?} {bounds:?}",
                body.name
            );
            tight = tight.including(Vec3::new(p.x as f32, p.y as f32, p.z as f32));
        }
        boxes += half_area(&bounds);
        truth += half_area(&tight);
    }
    boxes / truth
}

#[test]
fn boxes_of_made_meshes_hold_the_surface() {
    for body in support::made_bodies() {
        for surface in Surface::ALL {
            let ratio = check(&body, surface);
            println!(
                "{} {surface:?}: boxes {ratio:.3} of the true ones",
                body.name
            );
        }
    }
}

#[test]
fn boxes_of_real_meshes_are_tight() {
    let names = [
        "spot/spot_triangulated.obj",
        "bunny_2k.obj",
        "armadillo_29k.obj",
    ];
    for body in support::real_meshes(&names) {
        for surface in Surface::ALL {
            let ratio = check(&body, surface);
            println!(
                "{} {surface:?}: boxes {ratio:.3} of the true ones",
                body.name
            );
            assert!(ratio < MAX_RATIO, "{} {surface:?}: {ratio}", body.name);
        }
    }
}
