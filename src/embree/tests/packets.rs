//! Packets of every width against analytic hits and against single rays.

use super::sphere::*;
use crate::embree::*;

/// Embree's own choice, and every narrower instruction set: they take different ways through Embree.
fn devices() -> Vec<Device> {
    let configs = ["", "isa=sse2", "isa=sse4.2", "isa=avx", "isa=avx2"];
    configs
        .iter()
        .map(|config| Device::with_config(config).unwrap())
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
