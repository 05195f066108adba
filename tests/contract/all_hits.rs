//! All hits along a ray: from outside a closed body they are even in number and alternate front and
//! back.

use curvetri::embree::{Hit, QueryOptions, Ray, RayPacket, Traced, Width};
use curvetri::render::{Form, Scene};
use curvetri_bodies::SplitMix;
use curvetri_test_support::{Body, Tally};
use rayon::prelude::*;

/// Share of rays from outside that must cross a closed body evenly and alternately.
const MIN_EVEN: f64 = 0.9999;

fn forms() -> Vec<Form> {
    let curved: Vec<Form> = curvetri_test_support::all_forms()
        .into_iter()
        .map(Form::Curved)
        .collect();
    [&[Form::Flat], &curved[..]].concat()
}

fn scene(body: &Body, form: Form) -> Scene {
    let device = curvetri::linked::device().unwrap();
    Scene::with_filters(&device, vec![body.mesh.as_ref().clone()], form).unwrap()
}

/// A ray from outside a scene towards somewhere within its bounds.
fn ray_from_outside(scene: &Scene, random: &mut SplitMix) -> Ray {
    let bounds = scene.tree().bounds();
    let (centre, half) = (
        (bounds.lower + bounds.upper) * 0.5,
        (bounds.upper - bounds.lower) * 0.5,
    );
    let target = centre + half * random.in_cube();
    let direction = random.direction();
    Ray::new(target - direction * (half.length() * 3.0), direction)
}

fn crosses_evenly(ray: &Ray, hits: &[Hit]) -> bool {
    let ordered = hits.is_sorted_by(|a, b| a.t <= b.t);
    let mut sides = hits
        .iter()
        .map(|hit| hit.ng.dot(ray.direction) < 0.0)
        .enumerate();
    ordered && hits.len().is_multiple_of(2) && sides.all(|(n, front)| front == (n % 2 == 0))
}

#[test]
fn from_outside_all_hits_alternate_and_are_even_in_number() {
    curvetri_test_support::closed_bodies()
        .par_iter()
        .for_each(|body| {
            for form in forms() {
                let scene = scene(body, form);
                let mut random = SplitMix::new(23);
                let mut odd = Tally::default();
                let mut hits = [const { Vec::new() }; 8];
                let mut most = 0;
                for _ in 0..6_250 {
                    let rays: [Ray; 8] =
                        std::array::from_fn(|_| ray_from_outside(&scene, &mut random));
                    scene.all_hits(&RayPacket::<8>::from_rays(&rays), false, &mut hits);
                    for (ray, hits) in rays.iter().zip(&hits) {
                        most = most.max(hits.len());
                        odd.add(*ray, !crosses_evenly(ray, hits));
                    }
                }
                println!("{} {form:?}: at most {most} hits, odd {odd:?}", body.name);
                assert!(most >= 2, "{} {form:?}: nothing is hit", body.name);
                assert!(
                    1.0 - odd.share() >= MIN_EVEN,
                    "{} {form:?}: {odd:?}",
                    body.name
                );
            }
        });
}

/// All hits by packets of N, ray by ray.
fn by_packets<const N: usize>(scene: &Scene, rays: &[Ray], coherent: bool) -> Vec<Vec<Hit>>
where
    Width<N>: Traced,
{
    let mut hits = [const { Vec::new() }; N];
    let chunks = rays.chunks(N).map(|chunk| {
        scene.all_hits(&RayPacket::<N>::from_rays(chunk), coherent, &mut hits);
        hits[..chunk.len()].to_vec()
    });
    chunks.flatten().collect()
}

#[test]
fn packets_find_the_hits_that_single_rays_find() {
    for body in curvetri_test_support::made_bodies() {
        for form in forms() {
            let scene = scene(&body, form);
            let mut random = SplitMix::new(29);
            let rays: Vec<Ray> = (0..2003)
                .map(|_| ray_from_outside(&scene, &mut random))
                .collect();
            let single: Vec<_> = rays.iter().map(|ray| scene.all_hits1(ray)).collect();
            assert!(single.iter().any(|hits| hits.len() >= 2));
            for coherent in [false, true] {
                // No hit ends the search, so the tree's order does not show.
                let name = &body.name;
                assert!(by_packets::<1>(&scene, &rays, coherent) == single, "{name}");
                assert!(by_packets::<4>(&scene, &rays, coherent) == single, "{name}");
                assert!(by_packets::<8>(&scene, &rays, coherent) == single, "{name}");
                assert!(
                    by_packets::<16>(&scene, &rays, coherent) == single,
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn the_first_of_all_hits_is_the_nearest() {
    for body in curvetri_test_support::made_bodies() {
        for form in forms() {
            let scene = scene(&body, form);
            let mut random = SplitMix::new(31);
            for _ in 0..2000 {
                let ray = ray_from_outside(&scene, &mut random);
                let nearest = scene.tree().intersect1(&ray, &QueryOptions::default());
                let all = scene.all_hits1(&ray);
                assert_eq!(nearest.is_some(), !all.is_empty(), "{} {ray:?}", body.name);
                if let (Some(nearest), Some(first)) = (nearest, all.first()) {
                    let ulps = (nearest.t - first.t).abs() / (nearest.t * f32::EPSILON);
                    assert!(ulps <= 4.0, "{}: {nearest:?}, {first:?}", body.name);
                }
            }
        }
    }
}

#[test]
fn empty_and_untraceable_lanes_have_no_hits() {
    let body = &curvetri_test_support::made_bodies()[0];
    let scene = scene(body, forms()[3]);
    let ray = Ray::new([0.1, 0.2, 5.0].into(), [0.0, 0.0, -1.0].into());
    let mut packet = RayPacket::<8>::new();
    packet.set_ray(1, &ray);
    packet.set_ray(3, &ray.between(f32::NAN, 1.0));
    packet.set_ray(6, &ray.between(5.0, f32::INFINITY));
    // What is in them from before goes.
    let old = scene.all_hits1(&ray);
    let mut hits = std::array::from_fn(|_| old.clone());
    scene.all_hits(&packet, false, &mut hits);
    assert_eq!(hits.map(|hits| hits.len()), [0, 2, 0, 0, 0, 0, 1, 0]);
}

#[test]
#[should_panic(expected = "a query filter needs a scene made with")]
fn all_hits_need_a_scene_made_for_them() {
    let mesh = curvetri_test_support::made_bodies()[0]
        .mesh
        .as_ref()
        .clone();
    let scene = Scene::new(&curvetri::linked::device().unwrap(), vec![mesh], Form::Flat).unwrap();
    scene.all_hits1(&Ray::new([0.0; 3].into(), [0.0, 0.0, 1.0].into()));
}
