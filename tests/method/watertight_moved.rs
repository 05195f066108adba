//! Closed bodies stay closed wherever they lie, however they are turned and whatever their size:
//! the programs' own bodies, and all closed meshes of `CURVETRI_MESHES`.

use std::sync::Arc;

use curvetri::curved::CurvedOptions;
use curvetri::embree::Ray;
use curvetri::mesh::{Mesh, Topology};
use curvetri::method::Surface;
use curvetri::render::{Form, Scene};
use curvetri_bodies::SplitMix;
use curvetri_test_support::{Body, Tally, lost_rays};
use glam::{DAffine3, DQuat, DVec3};
use rayon::prelude::*;

/// Share of rays that may be lost: what Embree's own watertight test allows.
const MAX_LOST: f64 = 2e-5;
/// Share of rays from outside that must enter a body as often as they leave it.
const MIN_EVEN: f64 = 0.9999;
/// Rays a body in each of its places: for all of them together a few seconds.
const RAYS: usize = 6_000;

/// Places, turns and sizes.
fn transforms() -> [(&'static str, DAffine3); 5] {
    let turn = DQuat::from_axis_angle(DVec3::new(0.6, -0.48, 0.64), 1.1);
    let far = DVec3::new(1e6, -1e6, 1e6);
    [
        ("as it is", DAffine3::IDENTITY),
        ("turned", DAffine3::from_quat(turn)),
        ("far out", DAffine3::from_translation(far)),
        ("small", DAffine3::from_scale(DVec3::splat(1e-4))),
        ("large", DAffine3::from_scale(DVec3::splat(1e4))),
    ]
}

/// The body at another place, by its positions in double precision as a file would have them.
fn moved(body: &Body, by: DAffine3) -> Body {
    let mesh = &body.mesh;
    let positions = 0..mesh.positions().len();
    let positions = positions.map(|v| by.transform_point3(mesh.world_position(v)));
    let normals = mesh.normals().iter();
    let normals = normals.map(|n| by.transform_vector3(n.as_dvec3()));
    let triangles = mesh.triangles().to_vec();
    let moved = Mesh::new(positions.collect(), Some(normals.collect()), triangles);
    Body {
        name: body.name.clone(),
        mesh: Arc::new(moved.expect("a moved mesh is a mesh")),
    }
}

/// Whether a body is as thin, on the average, as rounding of its coordinates: it has no inside then.
fn is_thinner_than_rounding(mesh: &Mesh) -> bool {
    let (mut volume, mut area, mut reach) = (0.0, 0.0, 0.0f64);
    for triangle in 0..mesh.triangles().len() {
        let [a, b, c] = mesh.triangle_positions(triangle).map(|p| p.as_dvec3());
        volume += a.dot(b.cross(c)) / 6.0;
        area += (b - a).cross(c - a).length() / 2.0;
        reach = reach.max(a.abs().max_element());
    }
    2.0 * volume.abs() / area < 16.0 * f64::from(f32::EPSILON) * reach
}

/// Runs a check on all bodies in all places and adds up what failed in each place.
fn in_all_places(check: impl Fn(&Body) -> Tally + Sync) -> Vec<(&'static str, Tally)> {
    let mut bodies = curvetri_test_support::all_closed_bodies();
    bodies.retain(|body| {
        let thin = is_thinner_than_rounding(&body.mesh);
        if thin {
            println!("skipped, because thinner than rounding: {}", body.name);
        }
        !thin
    });
    assert!(bodies.len() >= curvetri_test_support::made_bodies().len());
    let places = transforms().into_iter();
    let sums = places.map(|(place, by)| {
        let tallies: Vec<(String, Tally)> = bodies
            .par_iter()
            .map(|body| (body.name.clone(), check(&moved(body, by))))
            .collect();
        let mut sum = Tally::default();
        for (name, tally) in tallies {
            if tally.failed > 0 {
                println!("{name}, {place}: {tally:?}");
            }
            sum.failed += tally.failed;
            sum.total += tally.total;
        }
        println!("{place}: {} of {}", sum.failed, sum.total);
        (place, sum)
    });
    sums.collect()
}

#[test]
fn no_ray_from_inside_is_lost() {
    for (place, sum) in in_all_places(|body| lost_rays(&body.traced(Surface::default()), RAYS)) {
        assert!(sum.share() <= MAX_LOST, "{place}: {sum:?}");
    }
}

/// As many hits on the front as on the back: bodies may overlap themselves, so that hits need not
/// alternate.
fn uneven_rays(body: &Body) -> Tally {
    let device = curvetri::linked::device().expect("Embree is installed");
    let form = Form::Curved(CurvedOptions::default());
    let scene = Scene::with_filters(&device, vec![(*body.mesh).clone()], form).unwrap();
    let bounds = scene.tree().bounds();
    let (centre, half) = (
        (bounds.lower + bounds.upper) * 0.5,
        (bounds.upper - bounds.lower) * 0.5,
    );
    let mut random = SplitMix::new(11);
    let mut tally = Tally::default();
    for _ in 0..RAYS {
        let target = centre + half * random.in_cube();
        let direction = random.direction();
        let ray = Ray::new(target - direction * (half.length() * 3.0), direction);
        let hits = scene.all_hits1(&ray);
        let entering = hits.iter().filter(|hit| hit.ng.dot(direction) < 0.0);
        tally.add(ray, 2 * entering.count() != hits.len());
    }
    tally
}

#[test]
fn rays_from_outside_leave_as_often_as_they_enter() {
    for (place, sum) in in_all_places(uneven_rays) {
        assert!(1.0 - sum.share() >= MIN_EVEN, "{place}: {sum:?}");
    }
}

#[test]
fn moving_keeps_what_a_body_is_made_of() {
    for body in curvetri_test_support::made_bodies() {
        let counts = |body: &Body| *Topology::new(&body.mesh).counts();
        for (place, by) in transforms() {
            let moved = moved(&body, by);
            assert_eq!(counts(&moved), counts(&body), "{} {place}", body.name);
        }
    }
}
