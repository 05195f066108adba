//! A glass ball of four triangles: light goes through it as through a true one.

use curvetri::curved::CurvedOptions;
use curvetri::embree::Ray;
use curvetri::method::Surface;
use curvetri::render::{Form, Scene};
use curvetri_bodies::{Body, SplitMix};
use glam::DVec3;

/// Of glass to air.
const INDEX: f64 = 1.5;
const RADIUS: f64 = 1.0;

/// Where light meets a surface, which way the surface's outer unit normal points there.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    point: DVec3,
    normal: DVec3,
}

/// Snell's law: the unit direction behind a surface; `ratio` is the index before it to that behind it.
fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let facing = -normal * normal.dot(direction).signum();
    let cosine = -facing.dot(direction);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    assert!(rest > 0.0, "light that came in through a ball leaves it");
    ratio * direction + (ratio * cosine - rest.sqrt()) * facing
}

/// The way through the true ball: in, out, and the direction after it.
fn true_way(origin: DVec3, direction: DVec3) -> (Meeting, Meeting, DVec3) {
    let at = |point: DVec3| Meeting {
        point,
        normal: point / RADIUS,
    };
    let along = origin.dot(direction);
    let inside = along * along - origin.length_squared() + RADIUS * RADIUS;
    let entry = at(origin - (along + inside.sqrt()) * direction);
    let within = refracted(direction, entry.normal, 1.0 / INDEX);
    let exit = at(entry.point - 2.0 * entry.point.dot(within) * within);
    (entry, exit, refracted(within, exit.normal, INDEX))
}

/// The same through the scene: in at the first root, out at the next one behind it.
fn traced_way(scene: &Scene, origin: DVec3, direction: DVec3) -> (Meeting, Meeting, DVec3) {
    let ray = Ray::new(origin.as_vec3(), direction.as_vec3());
    let all = scene.all_hits1(&ray);
    assert_eq!(all.len(), 2, "in and out: {all:?}");
    let meeting = |ray: &Ray, hit: &curvetri::embree::Hit| Meeting {
        point: ray.origin.as_dvec3() + f64::from(hit.t) * ray.direction.as_dvec3(),
        normal: hit.ng.as_dvec3().normalize(),
    };
    let entry = meeting(&ray, &all[0]);
    let within = refracted(direction, entry.normal, 1.0 / INDEX);
    let start = scene.leaving_point(&all[0], &ray, -entry.normal.as_vec3());
    let inside = Ray::new(start, within.as_vec3());
    let out = scene.all_hits1(&inside);
    assert_eq!(out.len(), 1, "from inside there is one way out: {out:?}");
    let exit = meeting(&inside, &out[0]);
    (entry, exit, refracted(within, exit.normal, INDEX))
}

fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.angle_between(b).to_degrees()
}

#[test]
fn light_goes_through_four_triangles_as_through_a_ball() {
    let device = curvetri::linked::device().unwrap();
    for surface in Surface::ALL {
        let form = Form::Curved(CurvedOptions {
            surface,
            ..CurvedOptions::default()
        });
        let mesh = Body::sphere_tetrahedron().mesh();
        let scene = Scene::with_filters(&device, vec![mesh], form).unwrap();
        assert_eq!(scene.origin(), DVec3::ZERO);
        let mut random = SplitMix::new(71);
        let [mut position, mut normal, mut bend] = [0.0_f64; 3];
        for _ in 0..20_000 {
            // From everywhere, over the disc that is seen of the ball but for its rim, where t is
            // as uncertain as the ray is long.
            let direction = random.direction();
            let aside = direction.cross(random.direction()).normalize() * random.unit_f32().sqrt();
            let origin = (aside * 0.99 - 4.0 * direction).as_dvec3();
            let direction = direction.as_dvec3().normalize();
            let expected = true_way(origin, direction);
            let found = traced_way(&scene, origin, direction);
            for (found, expected) in [(found.0, expected.0), (found.1, expected.1)] {
                position = position.max(found.point.distance(expected.point) / (2.0 * RADIUS));
                normal = normal.max(degrees(found.normal, expected.normal));
            }
            bend = bend.max(degrees(found.2, expected.2));
        }
        println!(
            "{surface:?}: position {position:.2e} of the size, normals {normal:.4} degrees, direction {bend:.4} degrees"
        );
        assert!(position < 1e-5, "{surface:?}: {position}");
        assert!(normal < 0.05, "{surface:?}: {normal}");
        assert!(bend < 0.05, "{surface:?}: {bend}");
    }
}
