//! Packets of every width against analytic hits and against single rays.

use std::sync::Arc;

use glam::Vec3;

use super::sphere::*;
use curvetri_embree::*;

/// Embree's own choice, and every narrower instruction set: they take different ways through Embree.
pub fn devices() -> Vec<Device> {
    let configs = ["", "isa=sse2", "isa=sse4.2", "isa=avx", "isa=avx2"];
    configs
        .iter()
        .map(|config| linked::device_with_config(config).unwrap())
        .collect()
}

fn check_width<const N: usize>(device: &Device)
where
    Width<N>: Traced,
{
    let spheres = many(200, 1);
    let scene = sphere_scene(device, spheres.clone());
    let rays = random_rays(2000, 2);
    for options in [QueryOptions::INCOHERENT, QueryOptions::COHERENT] {
        let hits = hits::<N>(&scene, &rays, &options);
        let shadows = shadows::<N>(&scene, &rays, &options);
        let mut met = 0;
        for ((ray, hit), shadow) in rays.iter().zip(hits).zip(shadows) {
            let expected = spheres.nearest(ray);
            assert_eq!(
                hit.map(|hit| (hit.t, hit.prim_id)),
                expected,
                "{device:?} {N}"
            );
            assert_eq!(shadow, expected.is_some(), "{device:?} {N}");
            if let Some(hit) = hit {
                met += 1;
                let away = hit.ng.dot(ray.direction) <= 0.0;
                assert_eq!((hit.u, hit.v), (if away { 0.0 } else { 1.0 }, 0.25));
                assert_eq!(hit.ng, ray.at(hit.t) - spheres.0[hit.prim_id as usize].0);
                assert_eq!((hit.geom_id, hit.inst_id), (0, [Hit::NONE]));
                assert_eq!(hit.inst_prim_id, [Hit::NONE]);
            }
        }
        assert!(
            met > 500 && met < 1900,
            "{met} of {} rays meet something",
            rays.len()
        );
    }
}

#[test]
fn every_width_finds_the_analytic_hits() {
    for device in devices() {
        check_width::<1>(&device);
        check_width::<4>(&device);
        check_width::<8>(&device);
        check_width::<16>(&device);
    }
}

#[test]
#[cfg(target_arch = "x86_64")]
fn a_device_can_be_limited_to_an_instruction_set() {
    let isa = |config| {
        let device = linked::device_with_config(config).unwrap();
        (device.isa(), device.native_width())
    };
    assert_eq!(isa("isa=sse2"), ("SSE2".to_owned(), 4));
    let (name, width) = isa("");
    assert!(
        [4, 8, 16].contains(&width) && !name.is_empty(),
        "{name} {width}"
    );
}

fn check_sparse<const N: usize>(device: &Device)
where
    Width<N>: Traced,
{
    let spheres = many(100, 3);
    let scene = sphere_scene(device, spheres.clone());
    let rays = random_rays(40 * N, 4);
    for (chunk, lanes) in rays
        .chunks(N)
        .zip((1_u32..).map(|i| i.wrapping_mul(0x9e37_79b9) >> 7))
    {
        for coherent in [false, true] {
            let options = QueryOptions {
                coherent,
                filter: None,
            };
            let full = RayPacket::<N>::from_rays(chunk);
            let mut packet = full.clone();
            packet.set_active(lanes);
            let mut shadowed = packet.clone();
            scene.intersect(&mut packet, &options);
            let occluded = scene.occluded(&mut shadowed, &options);
            for (lane, ray) in chunk.iter().enumerate() {
                let traced = lanes & 1 << lane != 0;
                let expected = if traced { spheres.nearest(ray) } else { None };
                let hit = packet.hit(lane).map(|hit| (hit.t, hit.prim_id));
                assert_eq!(hit, expected);
                assert_eq!(occluded & 1 << lane != 0, expected.is_some());
                if !traced {
                    assert_eq!(packet.ray(lane), *ray);
                    assert_eq!(shadowed.ray(lane), *ray);
                }
            }
        }
    }
}

#[test]
fn lanes_left_out_are_left_alone() {
    for device in devices() {
        check_sparse::<1>(&device);
        check_sparse::<4>(&device);
        check_sparse::<8>(&device);
        check_sparse::<16>(&device);
    }
}

fn check_masks<const N: usize>(device: &Device)
where
    Width<N>: Traced,
{
    let corners = [
        Vec3::new(-9.0, -9.0, 0.0),
        Vec3::new(9.0, -9.0, 0.0),
        Vec3::new(0.0, 9.0, 0.0),
    ];
    let at = |z: f32| Arc::new(Spheres(vec![(Vec3::new(0.0, 0.0, z), 0.5)]));
    let geometries = [
        Geometry::user(device, at(2.0)).unwrap().mask(0b0011),
        Geometry::user(device, at(4.0)).unwrap().mask(0b0110),
        Geometry::triangles(device, &corners.map(|p| p + 6.0 * Vec3::Z), &[[0, 1, 2]])
            .unwrap()
            .mask(0b1000),
        Geometry::user(device, at(8.0)).unwrap(), // as every bit
        Geometry::user(device, at(1.0)).unwrap().mask(0),
    ];
    let mut builder = SceneBuilder::new(device).unwrap();
    for geometry in geometries {
        builder.attach(&geometry.commit().unwrap());
    }
    let scene = builder.commit().unwrap();
    let expected = [
        (0b0001, Some(0)),
        (0b0010, Some(0)),
        (0b0100, Some(1)),
        (0b1000, Some(2)),
        (0x8000_0000, Some(3)),
        (0b1100, Some(1)),
        (!0, Some(0)),
        (0, None),
    ];
    let rays: Vec<Ray> = (0..48)
        .map(|i| Ray {
            mask: expected[i % 8].0,
            ..Ray::new(Vec3::ZERO, Vec3::Z)
        })
        .collect();
    let options = QueryOptions::COHERENT;
    let hits = hits::<N>(&scene, &rays, &options);
    let shadows = shadows::<N>(&scene, &rays, &options);
    for (i, (hit, shadow)) in hits.iter().zip(shadows).enumerate() {
        assert_eq!(
            hit.map(|hit| hit.geom_id),
            expected[i % 8].1,
            "{device:?} {N} {i}"
        );
        assert_eq!(shadow, hit.is_some(), "{device:?} {N} {i}");
    }
}

#[test]
fn rays_see_geometries_with_a_common_bit() {
    for device in devices() {
        assert!(device.tests_ray_masks());
        check_masks::<1>(&device);
        check_masks::<4>(&device);
        check_masks::<8>(&device);
        check_masks::<16>(&device);
    }
}

#[test]
fn a_ray_that_leads_hardly_back_takes_no_hits_from_others_of_a_coherent_packet() {
    for device in devices() {
        let scene = sphere_scene(&device, many(200, 3));
        for tiny in [-1e-17, -1e-18, -9e-19, -1e-30, -1e-40, -0.0, 0.0, 1e-30] {
            let mut rays = random_rays(2000, 4);
            for (n, ray) in rays.iter_mut().enumerate().step_by(5) {
                ray.direction[n % 3] = tiny;
            }
            let single = hits::<1>(&scene, &rays, &QueryOptions::INCOHERENT);
            let met = |hits: &[Option<Hit>]| {
                hits.iter()
                    .map(|hit| hit.map(|hit| hit.prim_id))
                    .collect::<Vec<_>>()
            };
            let expected = met(&single);
            assert_eq!(
                met(&hits::<4>(&scene, &rays, &QueryOptions::COHERENT)),
                expected,
                "{tiny:e}"
            );
            assert_eq!(
                met(&hits::<8>(&scene, &rays, &QueryOptions::COHERENT)),
                expected,
                "{tiny:e}"
            );
            assert_eq!(
                met(&hits::<16>(&scene, &rays, &QueryOptions::COHERENT)),
                expected,
                "{tiny:e}"
            );
            let shadows = shadows::<16>(&scene, &rays, &QueryOptions::COHERENT);
            assert!(
                shadows
                    .iter()
                    .zip(&single)
                    .all(|(&shadow, hit)| shadow == hit.is_some())
            );
        }
    }
}
