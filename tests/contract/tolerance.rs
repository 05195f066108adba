//! Triangles that stay flat because their surface is, or is within the tolerance.

use curvetri::curved::{CurvedMesh, CurvedOptions};
use curvetri::method::PatchKind;
use curvetri_bodies::SplitMix;
use curvetri_test_support::{Body, first_hit, lost_rays};

fn options(tolerance: f32) -> CurvedOptions {
    CurvedOptions {
        tolerance,
        ..CurvedOptions::default()
    }
}

fn body(name: &str, mesh: curvetri::mesh::Mesh) -> Body {
    Body {
        name: name.to_owned(),
        mesh: mesh.into(),
    }
}

/// How far the triangles' surfaces reach off their planes, in rising order.
fn heights(curved: &CurvedMesh) -> Vec<f32> {
    let count = curved.mesh().triangles().len() as u32;
    let heights = (0..count).map(|n| curved.patch(n).heights());
    let mut heights: Vec<f32> = heights.map(|[lower, upper]| upper.max(-lower)).collect();
    heights.sort_by(f32::total_cmp);
    heights
}

fn median_height(curved: &CurvedMesh) -> f32 {
    let heights = heights(curved);
    heights[heights.len() / 2]
}

#[test]
fn the_caps_of_a_cylinder_are_flat_and_its_wall_is_not() {
    let segments = 16;
    let traced = body("cylinder", curvetri_bodies::capped_cylinder(segments, 1.5))
        .traced_with(&options(0.0));
    let kinds = traced.curved.kinds();
    assert!(kinds.flat_plane >= 2 * (segments - 2), "{kinds:?}");
    assert!(kinds.curved >= 2 * segments, "{kinds:?}");
    assert_eq!(kinds.flat_tolerance, 0);
    for n in 0..traced.curved.mesh().triangles().len() as u32 {
        let p = traced.curved.mesh().triangle_positions(n as usize);
        let level = p[0].z == p[1].z && p[1].z == p[2].z;
        let flat = matches!(traced.curved.kind(n), PatchKind::Flat(_));
        assert_eq!(level, flat, "triangle {n} {p:?} {kinds:?}");
    }
}

#[test]
fn no_ray_is_lost_where_some_triangles_are_flat_by_tolerance() {
    for body in curvetri_test_support::made_bodies() {
        let heights = heights(&body.traced_with(&options(0.0)).curved);
        for part in [0.3, 0.7] {
            let tolerance = heights[(part * heights.len() as f32) as usize];
            let traced = body.traced_with(&options(tolerance));
            let kinds = traced.curved.kinds();
            let lost = lost_rays(&traced, 20_000);
            println!("{} {part}: {lost:?} {kinds:?}", body.name);
            assert!(kinds.flat_tolerance > 0 || tolerance < 1e-6, "{kinds:?}");
            assert!(lost.share() <= 5e-5, "{} {part}: {lost:?}", body.name);
        }
    }
}

#[test]
fn what_is_hit_is_as_near_as_the_tolerance() {
    let body = body("bumpy torus", curvetri_bodies::bumpy_torus(5_000));
    let exact = body.traced_with(&options(0.0));
    let tolerance = median_height(&exact.curved);
    let flattened = body.traced_with(&options(tolerance));
    let kinds = flattened.curved.kinds();
    assert!(
        kinds.flat_tolerance > 500 && kinds.curved > 500,
        "{kinds:?}"
    );
    let mut random = SplitMix::new(5);
    let (mut met, mut furthest) = (0, 0.0f32);
    for _ in 0..20_000 {
        let target = glam::Vec3::from_array(std::array::from_fn(|_| random.unit_f32() * 2.0 - 1.0));
        let direction = random.direction();
        let ray = curvetri::embree::Ray::new(target - 5.0 * direction, direction);
        let (Some(a), Some(b)) = (
            first_hit(&exact.scene, &ray),
            first_hit(&flattened.scene, &ray),
        ) else {
            continue;
        };
        // along the normal, where the ray grazes neither surface, which may be another wall
        let [slope, other] = [a, b].map(|hit| hit.ng.normalize().dot(direction).abs());
        if slope.min(other) > 0.5 {
            met += 1;
            furthest = furthest.max((a.t - b.t).abs() * slope);
        }
    }
    assert!(met > 1000, "{met}");
    // a triangle that stays curved between flat ones bends less than by itself
    assert!(furthest <= 3.0 * tolerance, "{furthest} of {tolerance}");
    assert!(furthest > 0.1 * tolerance, "{furthest} of {tolerance}");
}

#[test]
fn all_is_flat_within_a_great_tolerance() {
    let body = body("torus", curvetri_bodies::Body::torus(12, 16).mesh());
    let traced = body.traced_with(&options(f32::INFINITY));
    let kinds = traced.curved.kinds();
    assert_eq!(
        kinds.flat_tolerance,
        body.mesh.triangles().len(),
        "{kinds:?}"
    );
    assert_eq!(heights(&traced.curved).last(), Some(&0.0));
}
