//! Scenes placed in scenes.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};

use super::packets::devices;
use super::sphere::*;
use curvetri_embree::*;

/// Turned, sheared, mirrored, and moved.
fn transforms() -> Vec<Affine3A> {
    let turned = Affine3A::from_rotation_translation(
        Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7),
        Vec3::new(0.4, -0.2, 0.9),
    );
    let stretched = Affine3A::from_scale(Vec3::new(2.0, 0.3, -1.5)) * turned;
    vec![Affine3A::IDENTITY, turned, stretched, turned * stretched]
}

fn instances(device: &Device, scene: &Scene) -> Scene {
    let mut builder = SceneBuilder::new(device).unwrap();
    for (number, transform) in transforms().into_iter().enumerate() {
        let instance = Geometry::instance(device, scene, transform).unwrap();
        let instance = instance.mask(1 << number).commit().unwrap();
        assert!(instance.instanced_scene().is_some());
        assert_eq!(builder.attach(&instance) as usize, number);
    }
    builder.commit().unwrap()
}

fn check<const N: usize>(device: &Device)
where
    Width<N>: Traced,
{
    let spheres = many(100, 13);
    let inner = sphere_scene(device, spheres.clone());
    let outer = instances(device, &inner);
    for (number, transform) in transforms().into_iter().enumerate() {
        let rays: Vec<Ray> = random_rays(300, 14)
            .into_iter()
            .map(|ray| Ray {
                origin: transform.transform_point3(ray.origin),
                direction: transform.transform_vector3(ray.direction),
                mask: 1 << number,
                ..ray
            })
            .collect();
        let hits = hits::<N>(&outer, &rays, &QueryOptions::COHERENT);
        let shadows = shadows::<N>(&outer, &rays, &QueryOptions::COHERENT);
        let (mut met, mut differ) = (0, 0);
        for ((ray, hit), shadow) in rays.iter().zip(hits).zip(shadows) {
            assert_eq!(hit.is_some(), shadow);
            let inverse = transform.inverse();
            let local = Ray {
                origin: inverse.transform_point3(ray.origin),
                direction: inverse.transform_vector3(ray.direction),
                ..*ray
            };
            let expected = spheres.nearest(&local);
            // rounding of the transforms decides a few grazing rays
            if hit.map(|hit| hit.prim_id) != expected.map(|expected| expected.1) {
                differ += 1;
                continue;
            }
            let (Some(hit), Some((t, prim))) = (hit, expected) else {
                continue;
            };
            met += 1;
            assert!((hit.t - t).abs() <= 1e-4 * t + 1e-3, "{hit:?}, but t = {t}");
            assert_eq!((hit.geom_id, hit.inst_id), (0, [number as u32]));
            assert_eq!(
                hit.inst_prim_id,
                [if device.version().major == 3 {
                    Hit::NONE
                } else {
                    0
                }]
            );
            // the normal is in the instanced scene's space
            let center = spheres.0[prim as usize].0;
            assert!(hit.ng.distance(local.at(hit.t) - center) < 1e-3);
        }
        assert!(met > 50 && differ <= 3, "{met} meet, {differ} differ");
    }
}

#[test]
fn instances_are_hit_where_their_transform_puts_them() {
    for device in devices() {
        check::<1>(&device);
        check::<4>(&device);
        check::<8>(&device);
        check::<16>(&device);
    }
}

#[test]
fn an_instance_keeps_its_scene() {
    let device = linked::device().unwrap();
    let spheres = many(20, 15);
    let weak = Arc::downgrade(&spheres);
    let outer = instances(&device, &sphere_scene(&device, spheres));
    drop(device);
    let rays = random_rays(100, 16);
    assert!(
        hits::<8>(&outer, &rays, &QueryOptions::default())
            .iter()
            .any(Option::is_some)
    );
    assert!(weak.upgrade().is_some());
    drop(outer);
    assert!(weak.upgrade().is_none());
}

#[test]
fn instances_nest_as_deep_as_the_library_allows() {
    let device = linked::device().unwrap();
    let mut scene = sphere_scene(&device, Arc::new(Spheres(vec![(Vec3::ZERO, 1.0)])));
    let levels = Hit::LEVELS;
    for _ in 0..levels {
        let moved = Affine3A::from_translation(Vec3::X);
        let instance = Geometry::instance(&device, &scene, moved).unwrap();
        scene = scene_of(&device, instance);
    }
    let refused = Geometry::instance(&device, &scene, Affine3A::IDENTITY).err();
    assert_eq!(refused, Some(Error::Nesting { depth: levels + 1 }));
    let ray = Ray::new(Vec3::new(levels as f32, 0.0, -3.0), Vec3::Z);
    let hit = hits::<1>(&scene, &[ray], &QueryOptions::default())[0].unwrap();
    assert_eq!((hit.t, hit.inst_id.len()), (2.0, levels));
    assert!(hit.inst_id.iter().all(|id| *id == 0));
}

#[test]
fn filters_see_the_instance() {
    for device in devices() {
        let mut inner = SceneBuilder::new(&device).unwrap().query_filters(true);
        let spheres = Arc::new(Spheres(vec![(Vec3::ZERO, 1.0), (4.0 * Vec3::Z, 1.0)]));
        let geometry = Geometry::user(&device, spheres).unwrap();
        inner.attach(
            &geometry
                .intersect_filter(|c| c.hit.prim_id == 1)
                .commit()
                .unwrap(),
        );
        let corners = [
            Vec3::new(-9.0, -9.0, 0.0),
            Vec3::new(9.0, -9.0, 0.0),
            Vec3::new(0.0, 9.0, 0.0),
        ];
        let triangle = Geometry::triangles(&device, &corners, &[[0, 1, 2]]).unwrap();
        inner.attach(&triangle.commit().unwrap());
        let inner = inner.commit().unwrap();
        let mut outer = SceneBuilder::new(&device).unwrap().query_filters(true);
        for z in [0.0, 20.0] {
            let moved = Affine3A::from_translation(Vec3::new(0.0, 0.0, z));
            outer.attach(
                &Geometry::instance(&device, &inner, moved)
                    .unwrap()
                    .commit()
                    .unwrap(),
            );
        }
        let outer = outer.commit().unwrap();
        let rays = [Ray::new(Vec3::new(0.0, 0.0, -5.0), Vec3::Z); 16];
        let only = |inst: u32, geom: u32| {
            move |candidate: &Candidate| {
                candidate.hit.inst_id[0] == inst && candidate.hit.geom_id == geom
            }
        };
        for (inst, geom, t) in [(0, 0, 8.0), (0, 1, 5.0), (1, 0, 28.0), (1, 1, 25.0)] {
            let filter = only(inst, geom);
            let options = QueryOptions::COHERENT.with_filter(&filter);
            let all = [
                hits::<1>(&outer, &rays, &options),
                hits::<4>(&outer, &rays, &options),
                hits::<8>(&outer, &rays, &options),
                hits::<16>(&outer, &rays, &options),
            ];
            for hit in all.into_iter().flatten() {
                let hit = hit.unwrap();
                // Embree's flat triangles are rounded by the processor.
                assert!((hit.t - t).abs() < 1e-5 * t, "{hit:?}");
                assert_eq!((hit.inst_id, hit.geom_id), ([inst], geom));
            }
            assert_eq!(shadows::<16>(&outer, &rays, &options), vec![true; 16]);
        }
    }
}

#[test]
fn query_filters_go_all_the_way_down() {
    let device = linked::device().unwrap();
    let inner = sphere_scene(&device, many(3, 17));
    let mut outer = SceneBuilder::new(&device).unwrap().query_filters(true);
    let instance = Geometry::instance(&device, &inner, Affine3A::IDENTITY).unwrap();
    outer.attach(&instance.commit().unwrap());
    assert_eq!(outer.commit().err(), Some(Error::QueryFilters));
}

#[test]
fn extreme_transforms_neither_abort_nor_hit_by_chance() {
    for device in devices() {
        let inner = sphere_scene(&device, Arc::new(Spheres(vec![(Vec3::ZERO, 1.0)])));
        for exponent in [-12, -6, 6, 12] {
            let scale = 10_f32.powi(exponent);
            let transform = Affine3A::from_scale(Vec3::splat(scale));
            let scene = scene_of(
                &device,
                Geometry::instance(&device, &inner, transform).unwrap(),
            );
            assert!(scene.reach() <= LARGEST_COMPONENT);
            let near = Ray::new(
                Vec3::new(0.0, 0.0, -3.0 * scale),
                Vec3::new(0.0, 0.0, scale),
            );
            let far = Ray::new(Vec3::new(1.0, 2.0, -1.8e18), Vec3::new(0.0, 0.0, 1e17));
            let rays: Vec<Ray> = (0..16)
                .map(|i| if i % 2 == 0 { near } else { far })
                .collect();
            let all = [
                hits::<1>(&scene, &rays, &QueryOptions::COHERENT),
                hits::<8>(&scene, &rays, &QueryOptions::COHERENT),
                hits::<16>(&scene, &rays, &QueryOptions::COHERENT),
            ];
            for hits in all {
                for (i, hit) in hits.iter().enumerate().filter(|(i, _)| i % 2 == 0) {
                    assert!(
                        hit.is_some_and(|hit| (hit.t - 2.0).abs() < 1e-5),
                        "{exponent} {i}"
                    );
                }
                if exponent < 0 {
                    assert!(
                        hits.iter().skip(1).step_by(2).all(Option::is_none),
                        "{exponent}"
                    );
                }
            }
        }
    }
}

#[test]
fn instances_of_other_devices_and_without_inverse_are_refused() {
    let (device, other) = (linked::device().unwrap(), linked::device().unwrap());
    let scene = sphere_scene(&device, many(3, 18));
    let refused = Geometry::instance(&other, &scene, Affine3A::IDENTITY).err();
    assert_eq!(refused, Some(Error::OtherDevice("scene")));
    let flat = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
    let refused = Geometry::instance(&device, &scene, flat).err();
    assert!(matches!(refused, Some(Error::Transform(_))), "{refused:?}");
}

#[test]
fn an_instance_of_nothing_is_never_hit() {
    for device in devices() {
        let empty = SceneBuilder::new(&device).unwrap().commit().unwrap();
        let scene = instances(&device, &empty);
        let rays = random_rays(50, 19);
        assert_eq!(
            hits::<16>(&scene, &rays, &QueryOptions::COHERENT),
            vec![None; 50]
        );
        assert_eq!(
            hits::<1>(&scene, &rays, &QueryOptions::default()),
            vec![None; 50]
        );
    }
}
