//! Packets of curved triangles, of every width and with any lanes left out, give what single rays give.

use crate::queries::*;
use curvetri::embree::{QueryOptions, Ray};
use curvetri::method::BoundsKind;
use glam::DVec3;

#[test]
fn packets_of_every_width_give_what_single_rays_give() {
    let mut agreement = Agreement::default();
    for body in curvetri_test_support::closed_bodies() {
        for options in all_options() {
            let scene = scene(&body, &options);
            let rays = rays(&scene, 4_000, 41);
            let single = singly(&scene, &rays, None);
            assert!((200..3_800).contains(&single.met()), "{}", single.met());
            for (how, said) in by_all_packets(&scene, &rays, None) {
                agreement.compare(&single, &said, &format!("{} {options:?}, {how}", body.name));
            }
        }
    }
    agreement.assert_ties_are_rare();
}

#[test]
fn what_occludes_is_what_is_hit() {
    for body in few_bodies() {
        for options in all_options() {
            let scene = scene(&body, &options);
            let rays = rays(&scene, 4_000, 42);
            let said = singly(&scene, &rays, None);
            let hit: Vec<bool> = said.hits.iter().map(Option::is_some).collect();
            assert!(said.occluded == hit, "{} {options:?}", body.name);
        }
    }
}

#[test]
fn rays_see_the_geometries_whose_mask_they_share() {
    let mut agreement = Agreement::default();
    let device = curvetri::linked::device().unwrap();
    let bodies = few_bodies();
    for options in all_options() {
        // Both around the origin, one through the other.
        let [one, two] = [&bodies[0], &bodies[1]].map(|body| geometry(&device, body, &options));
        let both = scene_of(&device, [one.mask(0b01), two.mask(0b10)]);
        let alone = [&bodies[0], &bodies[1]].map(|body| scene(body, &options));
        let mut rays = rays(&both, 5_000, 43);
        for (n, ray) in rays.iter_mut().enumerate() {
            ray.mask = n as u32 % 4;
        }
        let single = singly(&both, &rays, None);
        for (ray, hit) in rays.iter().zip(&single.hits) {
            let seen = (0..2_u32).filter(|geometry| ray.mask & 1 << geometry != 0);
            let nearest = seen
                .filter_map(|geometry| {
                    let everything = Ray { mask: !0, ..*ray };
                    let scene = &alone[geometry as usize];
                    let hit = scene.intersect1(&everything, &QueryOptions::default())?;
                    Some((hit.t, geometry, hit.prim_id))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(hit.map(|hit| (hit.t, hit.geom_id, hit.prim_id)), nearest);
        }
        for (how, said) in by_all_packets(&both, &rays, None) {
            agreement.compare(&single, &said, &format!("{options:?}, {how}"));
        }
    }
    agreement.assert_ties_are_rare();
}

#[test]
fn longer_directions_have_lesser_t() {
    for body in few_bodies() {
        for options in all_options() {
            let scene = scene(&body, &options);
            for ray in rays(&scene, 2_000, 44) {
                let hit = scene.intersect1(&ray, &QueryOptions::default());
                // By powers of two, which round nothing.
                for scale in [0.125, 1024.0] {
                    let longer = Ray {
                        direction: ray.direction * scale,
                        ..ray.between(ray.tnear / scale, ray.tfar / scale)
                    };
                    let other = scene.intersect1(&longer, &QueryOptions::default());
                    let [point, other_point] = [(ray, hit), (longer, other)].map(|(ray, hit)| {
                        hit.map(|hit| {
                            let along = f64::from(hit.t) * ray.direction.as_dvec3();
                            (hit.prim_id, ray.origin.as_dvec3() + along)
                        })
                    });
                    let apart = |a: DVec3, b: DVec3| (a - b).length() / bounds_size(&scene);
                    let same = match (point, other_point) {
                        (Some((prim, a)), Some((other_prim, b))) => {
                            prim == other_prim && apart(a, b) < 1e-5
                        }
                        (None, None) => true,
                        _ => false,
                    };
                    assert!(same, "{} {options:?}: {hit:?}, {other:?}", body.name);
                }
            }
        }
    }
}

fn bounds_size(scene: &curvetri::embree::Scene) -> f64 {
    let bounds = scene.bounds();
    f64::from((bounds.upper - bounds.lower).length())
}

/// Rays that meet one patch twice, in places this much apart at the least, with where they do.
fn through_one_patch(scene: &curvetri::embree::Scene, apart: f32) -> Vec<(Ray, [f32; 2])> {
    let mut found = Vec::new();
    for ray in rays(scene, 30_000, 45) {
        let roots = offered(scene, &ray);
        if let [first, second] = &roots[..]
            && first.hit.prim_id == second.hit.prim_id
            && second.hit.t > (1.0 + apart) * first.hit.t
        {
            found.push((ray, [first.hit.t, second.hit.t]));
        }
    }
    found
}

#[test]
fn rays_may_begin_and_end_inside_a_patch() {
    let mut agreement = Agreement::default();
    let body = &few_bodies()[0];
    for options in all_options() {
        let scene = scene(body, &options);
        // Segments within spheres are longer, and so are the steps along them: a ray that begins right
        // before two close roots may step over both.
        let apart = match options.bounds {
            BoundsKind::Tight => 0.01,
            BoundsKind::Sphere => 0.03,
        };
        let all = through_one_patch(&scene, apart);
        assert!(all.len() > 100, "{}", all.len());
        let (mut rays, mut expected) = (Vec::new(), Vec::new());
        for (ray, [first, second]) in all {
            let at = |share: f32| first + share * (second - first);
            for (tnear, tfar, t) in [
                (ray.tnear, at(0.5), Some(first)),
                (at(0.5), ray.tfar, Some(second)),
                (at(0.25), at(0.75), None),
                (at(0.1), at(1.1).min(ray.tfar), Some(second)),
                (ray.tnear.max(at(-0.1)), at(0.9), Some(first)),
            ] {
                rays.push(ray.between(tnear, tfar));
                expected.push(t);
            }
        }
        let single = singly(&scene, &rays, None);
        for (((ray, hit), occluded), t) in (rays.iter())
            .zip(&single.hits)
            .zip(&single.occluded)
            .zip(expected)
        {
            let found = (hit.is_some(), *occluded);
            let expected = (t.is_some(), t.is_some());
            assert_eq!(found, expected, "{options:?}: {t:?} on {ray:?}");
            if let (Some(hit), Some(t)) = (hit, t) {
                assert!(
                    (hit.t - t).abs() < 1e-4 * t,
                    "{options:?}: {hit:?}, not {t}"
                );
            }
        }
        for (how, said) in by_all_packets(&scene, &rays, None) {
            agreement.compare(&single, &said, &format!("{options:?}, {how}"));
        }
    }
    agreement.assert_ties_are_rare();
}

#[test]
fn a_ray_that_begins_or_ends_at_its_own_hit_has_it() {
    let mut agreement = Agreement::default();
    for body in few_bodies() {
        for options in all_options() {
            let scene = scene(&body, &options);
            let whole = rays(&scene, 2_000, 46);
            let (mut cut, mut expected) = (Vec::new(), Vec::new());
            for (ray, hit) in whole.iter().zip(singly(&scene, &whole, None).hits) {
                let Some(hit) = hit else {
                    continue;
                };
                for (tnear, tfar) in [(hit.t, hit.t), (hit.t, ray.tfar), (ray.tnear, hit.t)] {
                    cut.push(ray.between(tnear, tfar));
                    expected.push(hit.t);
                }
            }
            assert!(cut.len() > 300, "{}", cut.len());
            let single = singly(&scene, &cut, None);
            let found = single.hits.iter().map(|hit| hit.map(|hit| hit.t));
            for ((ray, found), expected) in cut.iter().zip(found).zip(expected) {
                assert_eq!(found, Some(expected), "{} {options:?}: {ray:?}", body.name);
            }
            assert!(single.occluded.iter().all(|occluded| *occluded));
            for (how, said) in by_all_packets(&scene, &cut, None) {
                agreement.compare(&single, &said, &format!("{} {options:?}, {how}", body.name));
            }
        }
    }
    agreement.assert_ties_are_rare();
}
