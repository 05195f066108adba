//! Curved bodies in instances: any transform, nested as deep as the library allows.

use crate::queries::*;
use curvetri::curved::CurvedOptions;
use curvetri::embree::{Candidate, Device, Error, Geometry, Hit, QueryOptions, Ray, Scene};
use glam::{Affine3A, EulerRot, Quat, Vec3};

/// Turned; stretched and mirrored; sheared; all of it, moved far.
fn transforms() -> Vec<Affine3A> {
    let turned = Affine3A::from_rotation_translation(
        Quat::from_euler(EulerRot::XYZ, 0.3, 1.1, -0.7),
        Vec3::new(0.4, -0.2, 0.9),
    );
    let stretched = Affine3A::from_scale(Vec3::new(2.0, 0.3, -1.5));
    let far = Affine3A::from_translation(Vec3::new(30.0, -20.0, 10.0));
    vec![
        Affine3A::IDENTITY,
        turned,
        stretched,
        turned * stretched * turned,
        far * stretched * turned,
    ]
}

/// One instance of a scene for each transform, visible to rays with the bit of its number.
fn instances(device: &Device, inner: &Scene) -> Scene {
    let instance = |(number, transform)| {
        let instance = Geometry::instance(device, inner, transform).unwrap();
        instance.mask(1_u32 << number)
    };
    scene_of(device, transforms().into_iter().enumerate().map(instance))
}

fn moved(ray: &Ray, transform: &Affine3A) -> Ray {
    Ray {
        origin: transform.transform_point3(ray.origin),
        direction: transform.transform_vector3(ray.direction),
        ..*ray
    }
}

/// Rays at each of the instances, and the number of the one.
fn rays_at_instances(inner: &Scene, count: usize, seed: u64) -> Vec<Ray> {
    let transforms = transforms();
    let at = |(n, ray): (usize, Ray)| {
        let number = n % transforms.len();
        Ray {
            mask: 1 << number,
            ..moved(&ray, &transforms[number])
        }
    };
    let rays = rays(inner, count, seed);
    rays.into_iter().enumerate().map(at).collect()
}

#[test]
fn instances_are_hit_where_their_transform_puts_them() {
    let device = curvetri::linked::device().unwrap();
    for body in few_bodies() {
        for options in all_options() {
            let inner = scene_of(&device, [geometry(&device, &body, &options)]);
            let outer = instances(&device, &inner);
            let transforms = transforms();
            let (mut met, mut differ) = (0, 0);
            for ray in rays_at_instances(&inner, 5_000, 61) {
                let number = ray.mask.trailing_zeros();
                let local = moved(&ray, &transforms[number as usize].inverse());
                let hit = outer.intersect1(&ray, &QueryOptions::default());
                let expected = inner.intersect1(&local, &QueryOptions::default());
                // Rounding of the transforms decides at sides and at the rim.
                let same_prim = hit.map(|hit| hit.prim_id) == expected.map(|hit| hit.prim_id);
                let (Some(hit), Some(expected), true) = (hit, expected, same_prim) else {
                    differ += usize::from(!same_prim);
                    continue;
                };
                met += 1;
                assert_eq!((hit.geom_id, hit.inst_id[0]), (0, number));
                if hit.inst_prim_id[0] != Hit::NONE {
                    assert_eq!(hit.inst_prim_id[0], 0);
                }
                let slope = hit.ng.normalize().dot(local.direction.normalize()).abs();
                let size = (inner.bounds().upper - inner.bounds().lower).length();
                let apart = (local.at(hit.t) - local.at(expected.t)).length() * slope;
                assert!(apart < 2e-5 * size, "{hit:?}, {expected:?}: {apart}");
                // The normal stays in the body's own space.
                if slope > 0.1 {
                    let angle = hit.ng.angle_between(expected.ng);
                    assert!(angle < 1e-2, "{hit:?}, {expected:?}");
                }
            }
            assert!(met > 250, "{met}");
            assert!(differ < 25, "{} {options:?}: {differ} of {met}", body.name);
        }
    }
}

#[test]
fn packets_give_what_single_rays_give_in_instances() {
    let mut agreement = Agreement::default();
    let device = curvetri::linked::device().unwrap();
    for body in few_bodies() {
        for options in all_options() {
            let inner = scene_of(&device, [geometry(&device, &body, &options)]);
            let outer = instances(&device, &inner);
            let mut rays = rays_at_instances(&inner, 4_000, 62);
            // Some see all of them.
            rays.iter_mut().step_by(3).for_each(|ray| ray.mask = !0);
            let single = singly(&outer, &rays, None);
            assert!(single.met() > 200);
            for (how, said) in by_all_packets(&outer, &rays, None) {
                agreement.compare(&single, &said, &format!("{} {options:?}, {how}", body.name));
            }
        }
    }
    agreement.assert_ties_are_rare();
}

#[test]
fn filters_decide_in_instances() {
    let mut agreement = Agreement::default();
    let device = curvetri::linked::device().unwrap();
    for body in few_bodies() {
        let options = CurvedOptions::default();
        // The instance's rays come in the body's own space.
        let back = |c: &Candidate| c.hit.ng.dot(c.ray.direction) > 0.0;
        let odd = |c: &Candidate| {
            assert_eq!(c.ray.tfar, c.hit.t);
            c.hit.inst_id[0] % 2 == 1
        };
        let both = |c: &Candidate| back(c) && odd(c);
        let plain = scene_of(&device, [geometry(&device, &body, &options)]);
        let filtered = geometry(&device, &body, &options)
            .intersect_filter(back)
            .occluded_filter(back);
        let filtered = scene_of(&device, [filtered]);
        let [plain, filtered] = [plain, filtered].map(|inner| instances(&device, &inner));
        let bodies_own = scene(&body, &options);
        let mut rays = rays_at_instances(&bodies_own, 5_000, 63);
        rays.iter_mut().for_each(|ray| ray.mask = !0);
        let single = singly(&filtered, &rays, Some(&odd));
        for (ray, hit) in rays.iter().zip(&single.hits) {
            let expected = offered(&plain, ray).into_iter().find(|c| both(c));
            let expected = expected.map(|c| (c.hit.t, c.hit.prim_id, c.hit.inst_id));
            let hit = hit.map(|hit| (hit.t, hit.prim_id, hit.inst_id));
            assert_eq!(hit, expected, "{}", body.name);
        }
        assert!(single.met() > 100, "{}", single.met());
        for (how, said) in by_all_packets(&filtered, &rays, Some(&odd)) {
            agreement.compare(&single, &said, &format!("{}, {how}", body.name));
        }
    }
    agreement.assert_ties_are_rare();
}

#[test]
fn instances_nest_as_deep_as_the_library_allows() {
    let device = curvetri::linked::device().unwrap();
    let body = &few_bodies()[1];
    let mut scene = scene_of(
        &device,
        [geometry(&device, body, &CurvedOptions::default())],
    );
    let bottom = scene.clone();
    let [near, far] = [0.0, 100.0].map(|x| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0)));
    let mut levels = 0;
    loop {
        let geometries = [far, near].map(|at| Geometry::instance(&device, &scene, at));
        let [Ok(first), Ok(second)] = geometries else {
            let [refused, _] = geometries.map(Result::err);
            let depth = levels + 1;
            assert_eq!(refused, Some(Error::Nesting { depth }));
            break;
        };
        scene = scene_of(&device, [first, second]);
        levels += 1;
    }
    assert!(levels > 0);
    // The far one of the near ones: instance 1 at every level but the innermost.
    let expected: Vec<u32> = (0..levels).map(|n| u32::from(n + 1 < levels)).collect();
    let mut met = 0;
    for local in rays(&bottom, 2_000, 64) {
        let ray = moved(&local, &far);
        let hit = scene.intersect1(&ray, &QueryOptions::default());
        let Some(hit) = hit.filter(|hit| hit.inst_id[..levels] == expected) else {
            continue;
        };
        met += 1;
        assert_eq!(hit.inst_id.len(), levels);
        assert!(
            hit.inst_prim_id
                .iter()
                .all(|id| [0, Hit::NONE].contains(id))
        );
        let point = local.at(hit.t);
        let bounds = bottom.bounds();
        let within = point.cmpge(bounds.lower - 1e-3) & point.cmple(bounds.upper + 1e-3);
        assert!(within.all(), "{point}");
    }
    assert!(met > 500, "{met}");
}
