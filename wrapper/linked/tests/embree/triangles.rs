//! Embree's own triangles.

use glam::Vec3;

use super::packets::devices;
use super::sphere::*;
use curvetri_embree::*;

fn check_widths(device: &Device, build: impl Fn(SceneBuilder) -> SceneBuilder) {
    // a square in the plane z = 1, of two triangles
    let corners = [
        Vec3::Z,
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::ONE,
        Vec3::new(0.0, 1.0, 1.0),
    ];
    let square = Geometry::triangles(device, &corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let mut builder = build(SceneBuilder::new(device).unwrap());
    builder.attach(&square.commit().unwrap());
    let scene = builder.commit().unwrap();
    assert_eq!(
        scene.bounds(),
        Bounds {
            lower: Vec3::Z,
            upper: Vec3::ONE
        }
    );

    let rays: Vec<Ray> = random_rays(500, 5)
        .into_iter()
        .map(|ray| Ray {
            origin: ray.origin * Vec3::new(1.0, 1.0, 0.0),
            ..ray
        })
        .collect();
    let all = [
        hits::<1>(&scene, &rays, &QueryOptions::INCOHERENT),
        hits::<4>(&scene, &rays, &QueryOptions::COHERENT),
        hits::<8>(&scene, &rays, &QueryOptions::COHERENT),
        hits::<16>(&scene, &rays, &QueryOptions::INCOHERENT),
        hits::<16>(&scene, &rays, &QueryOptions::COHERENT),
    ];
    for hits in all {
        let mut met = 0;
        for (ray, hit) in rays.iter().zip(hits) {
            let t = 1.0 / ray.direction.z;
            let point = ray.at(t);
            let margin = point.x.min(point.y).min(1.0 - point.x).min(1.0 - point.y);
            if margin.abs() < 1e-4 || (point.x - point.y).abs() < 1e-4 {
                continue; // too close to a side to tell
            }
            assert_eq!(hit.is_some(), margin > 0.0 && t > 0.0, "{ray:?}");
            let Some(hit) = hit else { continue };
            met += 1;
            let [a, b, c] = if hit.prim_id == 0 {
                [0, 1, 2]
            } else {
                [0, 2, 3]
            }
            .map(|i| corners[i]);
            let on_triangle = a + hit.u * (b - a) + hit.v * (c - a);
            assert!((hit.t / t - 1.0).abs() < 1e-5);
            assert!(on_triangle.distance(point) < 1e-5);
            assert!(hit.ng.normalize().distance(Vec3::Z) < 1e-6);
        }
        assert!(met > 30, "{met}");
    }
}

#[test]
fn triangles_are_hit_where_they_are() {
    for device in devices() {
        check_widths(&device, |builder| builder);
        check_widths(&device, |builder| builder.robust(true));
        check_widths(&device, |builder| {
            builder.compact(true).build_quality(BuildQuality::High)
        });
        check_widths(&device, |builder| {
            builder.dynamic(true).build_quality(BuildQuality::Low)
        });
    }
}

#[test]
fn indices_out_of_range_are_refused() {
    let device = linked::device().unwrap();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let refused = Geometry::triangles(&device, &corners, &[[0, 1, 2], [0, 3, 1]]).err();
    assert_eq!(
        refused,
        Some(Error::Index {
            triangle: 1,
            index: 3,
            vertices: 3
        })
    );
    let message = refused.unwrap().to_string();
    assert_eq!(
        message,
        "triangle 1 names vertex 3, but there are 3 vertices"
    );
}

#[test]
fn nothing_is_hit_in_an_empty_scene() {
    for device in devices() {
        let empty = SceneBuilder::new(&device).unwrap().commit().unwrap();
        let no_triangles = scene_of(&device, Geometry::triangles(&device, &[], &[]).unwrap());
        let no_spheres = sphere_scene(&device, many(0, 0));
        for scene in [empty, no_triangles, no_spheres] {
            assert!(scene.bounds().is_empty());
            let rays = random_rays(20, 6);
            assert_eq!(
                hits::<16>(&scene, &rays, &QueryOptions::COHERENT),
                vec![None; 20]
            );
            assert_eq!(
                shadows::<1>(&scene, &rays, &QueryOptions::default()),
                vec![false; 20]
            );
        }
    }
}

#[test]
fn triangles_without_finite_vertices_are_never_hit() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30].map(Vec3::splat);
    let good = [
        Vec3::new(-9.0, -9.0, 5.0),
        Vec3::new(9.0, -9.0, 5.0),
        Vec3::new(0.0, 9.0, 5.0),
    ];
    let corners: Vec<Vec3> = bad.into_iter().chain(good).collect();
    // with one bad corner each, one of no area, and a good one
    let indices = [
        [0, 4, 5],
        [4, 1, 5],
        [4, 5, 2],
        [3, 5, 6],
        [4, 4, 4],
        [4, 5, 6],
    ];
    for device in devices() {
        let scene = scene_of(
            &device,
            Geometry::triangles(&device, &corners, &indices).unwrap(),
        );
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let hit = scene.intersect1(&ray, &QueryOptions::default()).unwrap();
        // Embree divides by the processor's estimate of a reciprocal, which they round differently.
        assert!((hit.t - 5.0).abs() < 1e-5 && hit.prim_id == 5, "{hit:?}");
        assert!(scene.occluded1(&ray, &QueryOptions::default()));
        assert!(!scene.occluded1(&ray.between(0.0, 4.9), &QueryOptions::default()));
        assert_eq!(
            hits::<16>(&scene, &[ray; 16], &QueryOptions::COHERENT),
            vec![Some(hit); 16]
        );
    }
}
