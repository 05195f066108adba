//! Filters of geometries and of queries.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;

use super::packets::devices;
use super::sphere::*;
use curvetri_embree::*;

/// Rays down a row of three spheres and three triangles, some meeting all, some none.
fn rays() -> Vec<Ray> {
    let ray = |i: usize| {
        let x = if i % 3 == 2 { 50.0 } else { 0.01 * i as f32 };
        Ray {
            id: i as u32,
            ..Ray::new(Vec3::new(x, 0.0, -3.0), Vec3::Z)
        }
    };
    (0..40).map(ray).collect()
}

fn spheres() -> Arc<Spheres> {
    Arc::new(Spheres(
        [0.0, 4.0, 8.0]
            .map(|z| (Vec3::new(0.0, 0.0, z), 1.0))
            .to_vec(),
    ))
}

fn stack(device: &Device) -> GeometryBuilder {
    let corners = (0..3).flat_map(|i| {
        let z = Vec3::Z * (1.5 + 4.0 * i as f32);
        [
            Vec3::new(-9.0, -9.0, 0.0),
            Vec3::new(9.0, -9.0, 0.0),
            Vec3::new(0.0, 9.0, 0.0),
        ]
        .map(|corner| corner + z)
    });
    let corners: Vec<Vec3> = corners.collect();
    Geometry::triangles(device, &corners, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]).unwrap()
}

/// Accepts only primitive 1, and of a sphere only its far side.
fn far_side_of_1(candidate: &Candidate) -> bool {
    let hit = &candidate.hit;
    assert_eq!(candidate.ray.tfar, hit.t);
    assert_eq!((hit.geom_id, hit.inst_id), (0, [Hit::NONE]));
    assert!(candidate.ray.id % 3 != 2, "a ray that meets nothing");
    hit.prim_id == 1 && hit.ng.dot(candidate.ray.direction) >= 0.0
}

fn check<const N: usize>(scene: &Scene, options: &QueryOptions<'_>, accepted: bool)
where
    Width<N>: Traced,
{
    let rays = rays();
    for coherent in [false, true] {
        let options = QueryOptions {
            coherent,
            ..*options
        };
        let hits = hits::<N>(scene, &rays, &options);
        let shadows = shadows::<N>(scene, &rays, &options);
        for ((ray, hit), shadow) in rays.iter().zip(hits).zip(shadows) {
            let expected = (accepted && ray.id % 3 != 2).then_some(1);
            assert_eq!(hit.map(|hit| hit.prim_id), expected, "{N} {ray:?}");
            assert_eq!(shadow, expected.is_some(), "{N} {ray:?}");
            if let Some(hit) = hit {
                assert!(hit.ng.dot(ray.direction) > 0.0);
            }
        }
    }
}

fn check_all(scene: &Scene, options: &QueryOptions<'_>, accepted: bool) {
    check::<1>(scene, options, accepted);
    check::<4>(scene, options, accepted);
    check::<8>(scene, options, accepted);
    check::<16>(scene, options, accepted);
}

type Build = fn(&Device) -> GeometryBuilder;
const GEOMETRIES: [Build; 2] = [|device| Geometry::user(device, spheres()).unwrap(), stack];

#[test]
fn a_geometry_s_filters_choose_its_hits() {
    for device in devices() {
        for build in GEOMETRIES {
            let geometry = build(&device)
                .intersect_filter(far_side_of_1)
                .occluded_filter(far_side_of_1);
            let scene = scene_of(&device, geometry);
            check_all(&scene, &QueryOptions::default(), true);
            let geometry = build(&device)
                .intersect_filter(|_| false)
                .occluded_filter(|_| false);
            let scene = scene_of(&device, geometry);
            check_all(&scene, &QueryOptions::default(), false);
        }
    }
}

fn filterable(device: &Device, geometry: GeometryBuilder) -> Scene {
    let mut builder = SceneBuilder::new(device).unwrap().query_filters(true);
    builder.attach(&geometry.commit().unwrap());
    builder.commit().unwrap()
}

#[test]
fn a_query_s_filter_chooses_its_hits() {
    for device in devices() {
        for build in GEOMETRIES {
            let scene = filterable(&device, build(&device));
            let calls = AtomicUsize::new(0);
            let filter = |candidate: &Candidate| {
                calls.fetch_add(1, Ordering::Relaxed);
                far_side_of_1(candidate)
            };
            check_all(&scene, &QueryOptions::default().with_filter(&filter), true);
            assert!(calls.load(Ordering::Relaxed) > 0);
            check_all(
                &scene,
                &QueryOptions::default().with_filter(&|_| false),
                false,
            );
        }
    }
}

#[test]
fn a_hit_needs_both_filters() {
    for device in devices() {
        for build in GEOMETRIES {
            let geometry = build(&device)
                .intersect_filter(|candidate| candidate.hit.prim_id >= 1)
                .occluded_filter(|candidate| candidate.hit.prim_id >= 1);
            let scene = filterable(&device, geometry);
            let filter = |candidate: &Candidate| {
                assert!(
                    candidate.hit.prim_id >= 1,
                    "the geometry's filter goes first"
                );
                far_side_of_1(candidate)
            };
            check_all(&scene, &QueryOptions::default().with_filter(&filter), true);
            check_all(
                &scene,
                &QueryOptions::default().with_filter(&|_| false),
                false,
            );
        }
    }
}

#[test]
#[should_panic(expected = "a query filter needs a scene made with")]
fn a_query_filter_needs_a_scene_made_for_it() {
    let device = linked::device().unwrap();
    let scene = sphere_scene(&device, spheres());
    let mut packet = RayPacket::<1>::from_rays(&rays()[..1]);
    scene.intersect(&mut packet, &QueryOptions::default().with_filter(&|_| true));
}
