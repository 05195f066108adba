//! Who owns what, on how many threads, and what Embree says when it refuses.

use std::sync::{Arc, Weak};
use std::thread;

use glam::{Affine3A, Vec3};

use super::sphere::*;
use curvetri_embree::*;

#[test]
fn a_scene_keeps_what_it_needs() {
    let device = linked::device().unwrap();
    let spheres = many(50, 7);
    let weak: Weak<Spheres> = Arc::downgrade(&spheres);
    let rays = random_rays(200, 8);
    let expected: Vec<_> = rays.iter().map(|ray| spheres.nearest(ray)).collect();
    let geometry = Geometry::user(&device, spheres).unwrap().commit().unwrap();
    let mut builder = SceneBuilder::new(&device).unwrap();
    builder.attach(&geometry);
    let scene = builder.commit().unwrap();
    drop(geometry);
    drop(device);

    let other = scene.clone();
    drop(scene);
    let found = hits::<8>(&other, &rays, &QueryOptions::default());
    let found: Vec<_> = found
        .iter()
        .map(|hit| hit.map(|hit| (hit.t, hit.prim_id)))
        .collect();
    assert_eq!(found, expected);
    assert!(weak.upgrade().is_some());
    drop(other);
    assert!(weak.upgrade().is_none(), "the geometry outlives the scene");
}

#[test]
fn a_geometry_may_be_in_several_scenes() {
    let device = linked::device().unwrap();
    let spheres = many(50, 9);
    let geometry = Geometry::user(&device, spheres.clone())
        .unwrap()
        .commit()
        .unwrap();
    let scenes: Vec<Scene> = thread::scope(|scope| {
        let build = || {
            let mut builder = SceneBuilder::new(&device).unwrap();
            builder.attach(&geometry);
            builder.commit().unwrap()
        };
        let builds: Vec<_> = (0..4).map(|_| scope.spawn(build)).collect();
        builds
            .into_iter()
            .map(|build| build.join().unwrap())
            .collect()
    });
    let rays = random_rays(100, 10);
    let first = hits::<4>(&scenes[0], &rays, &QueryOptions::default());
    assert!(first.iter().any(Option::is_some));
    for scene in &scenes {
        assert_eq!(hits::<4>(scene, &rays, &QueryOptions::default()), first);
        assert_eq!(scene.bounds(), scenes[0].bounds());
        assert!(scene.geometry(0).is_some() && scene.geometry(1).is_none());
    }
}

#[test]
fn many_threads_trace_one_scene() {
    let device = linked::device_with_config("threads=4").unwrap();
    let spheres = many(300, 11);
    let scene = sphere_scene(&device, spheres.clone());
    thread::scope(|scope| {
        for seed in 0..8 {
            let (scene, spheres) = (&scene, &spheres);
            scope.spawn(move || {
                let rays = random_rays(2000, 100 + seed);
                let hits = hits::<16>(scene, &rays, &QueryOptions::COHERENT);
                for (ray, hit) in rays.iter().zip(hits) {
                    assert_eq!(hit.map(|hit| (hit.t, hit.prim_id)), spheres.nearest(ray));
                }
            });
        }
    });
}

#[test]
fn memory_is_counted_and_given_back() {
    let device = linked::device().unwrap();
    let before = device.memory().current;
    let scene = sphere_scene(&device, many(20_000, 12));
    let during = device.memory();
    assert!(
        during.current > before + 20_000 * 20,
        "{during:?}, {before} before"
    );
    assert!(during.peak >= during.current);
    drop(scene);
    let after = device.memory();
    assert!(
        after.current < before + 20_000,
        "{after:?}, {before} before"
    );
    assert_eq!(after.peak, during.peak);
}

#[test]
fn a_device_tells_what_it_is() {
    let device = linked::device().unwrap();
    let version = device.version();
    let compiled_for = linked::embree().unwrap().version();
    assert!(version >= compiled_for && version.major == compiled_for.major);
    assert_eq!(device.clone().version(), version);
    assert!(!device.isa().is_empty());
    assert!(format!("{device:?}").contains(&version.to_string()));
}

#[test]
fn embree_s_errors_come_with_their_message() {
    let device = linked::device().unwrap();
    let scene = sphere_scene(&device, many(3, 20));
    let instance = Geometry::instance(&device, &scene, Affine3A::IDENTITY).unwrap();
    let refused = instance.intersect_filter(|_| true).commit().err();
    let expected = Error::Embree {
        doing: "set a geometry's filter",
        code: ErrorCode::InvalidOperation,
        message: "filter functions not supported for this geometry".to_owned(),
    };
    assert_eq!(refused, Some(expected));
    // and it is gone
    let instance = Geometry::instance(&device, &scene, Affine3A::IDENTITY).unwrap();
    instance.commit().unwrap();
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = linked::device_with_config("threads=1\0").err();
    assert_eq!(
        refused,
        Some(Error::Configuration("threads=1\0".to_owned()))
    );

    let (one, other) = (linked::device().unwrap(), linked::device().unwrap());
    let triangle =
        Geometry::triangles(&one, &[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]]).unwrap();
    let mut builder = SceneBuilder::new(&other).unwrap();
    builder.attach(&triangle.commit().unwrap());
    assert_eq!(builder.commit().err(), Some(Error::OtherDevice("geometry")));
}
