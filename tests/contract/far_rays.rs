//! Rays from very far away, as hosts bring them that cannot move rays: single precision loses none of the
//! surface's digits, though it does lose those of t.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::queries::*;
use curvetri::embree::{Device, Geometry, Hit, QueryOptions, Ray, Scene, SceneBuilder};
use curvetri::mesh::Mesh;
use curvetri_bodies::SplitMix;
use curvetri_test_support::Body;
use glam::DVec3;

/// A unit sphere of so many meridians and parallels.
fn sphere(around: usize, down: usize) -> Body {
    let mut positions = vec![DVec3::Y];
    for row in 1..down {
        for column in 0..around {
            let (polar, azimuth) = (
                std::f64::consts::PI * row as f64 / down as f64,
                std::f64::consts::TAU * column as f64 / around as f64,
            );
            let (sin, cos) = polar.sin_cos();
            positions.push(DVec3::new(sin * azimuth.cos(), cos, sin * azimuth.sin()));
        }
    }
    positions.push(DVec3::NEG_Y);
    let last = positions.len() as u32 - 1;
    let place = |row: usize, column: usize| match row {
        0 => 0,
        row if row == down => last,
        row => (1 + (row - 1) * around + column % around) as u32,
    };
    let mut triangles = Vec::new();
    for row in 0..down {
        for column in 0..around {
            let [a, b] = [place(row, column), place(row, column + 1)];
            let [c, d] = [place(row + 1, column), place(row + 1, column + 1)];
            triangles.extend(
                [[a, b, c], [b, d, c]]
                    .into_iter()
                    .filter(|[a, b, c]| a != b && b != c),
            );
        }
    }
    Body {
        name: format!("sphere of {around} x {down}"),
        mesh: Arc::new(Mesh::new(positions.clone(), Some(positions), triangles).unwrap()),
    }
}

/// A scene of one body as Embree's own triangles.
fn flat_scene(device: &Device, body: &Body) -> Scene {
    let (positions, triangles) = (body.mesh.positions(), body.mesh.triangles());
    let flat = Geometry::triangles(device, positions, triangles).unwrap();
    let mut builder = SceneBuilder::new(device).unwrap().robust(true);
    builder.attach(&flat.commit().unwrap());
    builder.commit().unwrap()
}

/// Rays at the unit sphere from so many radii away; each with itself, moved near in double precision.
fn far_and_near(distance: f64, count: usize) -> Vec<(Ray, Ray)> {
    let mut random = SplitMix::new(51);
    let mut rays = Vec::new();
    while rays.len() < count {
        let origin = (distance * random.direction().as_dvec3()).as_vec3();
        let target = random.in_cube();
        if target.length() > 1.0 {
            continue;
        }
        let length = random.between(0.5, 2.0);
        let direction = (target.as_dvec3() - origin.as_dvec3()).normalize() * length;
        let far = Ray::new(origin, direction.as_vec3());
        let (from, along) = (origin.as_dvec3(), far.direction.as_dvec3());
        let way = -from.dot(along) / along.dot(along) - 3.0 / along.length();
        rays.push((far, Ray::new((from + way * along).as_vec3(), far.direction)));
    }
    rays
}

/// How well rays from far away see what they see when moved near.
#[derive(Debug)]
struct Likeness {
    /// The share of the hits whose triangle is the same.
    same: f64,
    /// The share of the hits that are lost.
    lost: f64,
    /// The angles between the normals in degrees, where both hit: the median and the greatest.
    angles: [f64; 2],
    /// The share of them above 0.2 degrees.
    tilted: f64,
}

fn likeness(scene: &Scene, rays: &[(Ray, Ray)]) -> Likeness {
    let hit = |ray: &Ray| scene.intersect1(ray, &QueryOptions::default());
    let (mut hits, mut same, mut lost, mut angles) = (0, 0, 0, Vec::new());
    for (far, near) in rays {
        let Some(expected) = hit(near) else {
            continue;
        };
        hits += 1;
        let Some(found) = hit(far) else {
            lost += 1;
            continue;
        };
        same += usize::from(found.prim_id == expected.prim_id);
        let normal = |hit: Hit| hit.ng.as_dvec3().normalize();
        let chord = (normal(found) - normal(expected)).length();
        angles.push((2.0 * (0.5 * chord).asin()).to_degrees());
    }
    assert!(hits > 1000, "{hits}");
    angles.sort_by(f64::total_cmp);
    let tilted = angles.iter().filter(|angle| **angle > 0.2).count();
    Likeness {
        same: same as f64 / hits as f64,
        lost: lost as f64 / hits as f64,
        angles: [angles[angles.len() / 2], angles[angles.len() - 1]],
        tilted: tilted as f64 / angles.len() as f64,
    }
}

#[test]
fn from_far_away_the_curved_surface_is_seen_as_well_as_flat_triangles() {
    let device = curvetri::linked::device().unwrap();
    let body = sphere(32, 16);
    let flat_scene = flat_scene(&device, &body);
    for distance in [1e3, 1e4, 1e5, 1e6] {
        let rays = far_and_near(distance, 4_000);
        let flat = likeness(&flat_scene, &rays);
        for options in all_options() {
            let curved = likeness(&scene(&body, &options), &rays);
            let what = format!("from {distance:e}: {curved:?}, flat {flat:?}, {options:?}");
            // Nearest to where rays are not moved any more those along edges meet either neighbour.
            let less = if distance < 1e4 { 0.002 } else { 0.0 };
            assert!(curved.same >= flat.same - less, "{what}");
            assert!(curved.lost <= flat.lost, "{what}");
            assert!(curved.angles[0] < 1e-3 && curved.tilted < 0.005, "{what}");
            println!("{what}");
        }
    }
}

#[test]
fn from_far_away_all_widths_give_what_single_rays_give() {
    let mut agreement = Agreement::default();
    let body = sphere(32, 16);
    for options in all_options() {
        let scene = scene(&body, &options);
        // Some of a packet's rays come from near by.
        let rays = far_and_near(1e5, 1_000).into_iter();
        let mut rays: Vec<Ray> = rays.flat_map(|(far, near)| [far, near, far]).collect();
        let single = singly(&scene, &rays, None);
        for (how, said) in by_all_packets(&scene, &rays, None) {
            agreement.compare(&single, &said, &format!("{options:?}, {how}"));
        }
        // The same where they begin at their hits, as far as t tells these from others.
        for (ray, hit) in rays.iter_mut().zip(&single.hits) {
            if let Some(hit) = hit {
                *ray = ray.between(hit.t, f32::INFINITY);
            }
        }
        let cut = singly(&scene, &rays, None);
        let t =
            |said: &Said| -> Vec<_> { said.hits.iter().map(|hit| hit.map(|hit| hit.t)).collect() };
        let lost = t(&single)
            .into_iter()
            .zip(t(&cut))
            .filter(|(a, b)| a != b)
            .count();
        // Embree tests its boxes in digits as coarse as t's.
        assert!(
            lost * 200 <= single.met(),
            "{lost} of {}: {options:?}",
            single.met()
        );
    }
    agreement.assert_ties_are_rare();
}

#[test]
fn from_far_away_filters_are_offered_the_hits_that_they_are_from_near() {
    let body = sphere(32, 16);
    for options in all_options() {
        let scene = scene(&body, &options);
        let (mut all, mut differ) = (0, 0);
        for (far, near) in far_and_near(1e5, 500) {
            let [far, near] = [far, near].map(|ray| {
                let hits = offered(&scene, &ray);
                hits.iter()
                    .map(|offer| offer.hit.prim_id)
                    .collect::<BTreeSet<_>>()
            });
            all += near.len();
            differ += usize::from(far != near);
        }
        assert!(all >= 900 && differ <= 5, "{differ} of {all}: {options:?}");
    }
}
