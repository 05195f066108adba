//! Rays and cameras from very far away: what they see is what is seen from near.

use curvetri::curved::CurvedOptions;
use curvetri::render::{
    Camera, Film, Form, PacketWidth, Picture, Projection, Scene, UpAxis, UserRay, answer_all_hits,
    answer_occluded, answer_rays, aovs, render,
};
use curvetri_bodies::{Body, SplitMix};
use glam::DVec3;

use crate::batch;

fn torus(form: Form) -> Scene {
    let device = curvetri::linked::device().unwrap();
    Scene::new(&device, vec![Body::torus(48, 64).mesh()], form).unwrap()
}

fn forms() -> [Form; 2] {
    [Form::Flat, Form::Curved(CurvedOptions::default())]
}

/// Rays at a scene from near by, of any length.
fn rays(scene: &Scene, count: usize) -> Vec<UserRay> {
    let mut random = SplitMix::new(61);
    let bounds = *scene.bounds();
    let ray = |_| {
        let from = bounds.centre() + bounds.diagonal() * random.direction().as_dvec3();
        let half = 0.5 * (bounds.max - bounds.min);
        let target = bounds.centre() + half * random.in_cube().as_dvec3();
        UserRay {
            origin: from,
            direction: (target - from) * random.between(0.1, 2.0),
            tnear: 0.0,
            tfar: f64::INFINITY,
        }
    };
    (0..count).map(ray).collect()
}

/// The same ray, begun earlier by so much of its parameter.
fn from_afar(ray: &UserRay, earlier: f64) -> UserRay {
    UserRay {
        origin: ray.origin - earlier * ray.direction,
        direction: ray.direction,
        tnear: ray.tnear + earlier,
        tfar: ray.tfar + earlier,
    }
}

#[test]
fn rays_from_far_away_hit_what_they_hit_from_near() {
    for form in forms() {
        let scene = torus(form);
        let near = rays(&scene, 5_000);
        let expected = answer_rays(&scene, &batch(near.len(), &|n| near[n]), PacketWidth::One);
        assert!(expected.t.iter().filter(|t| t.is_finite()).count() > 2_000);
        for earlier in [1e3, 1e5, 1e7] {
            let far = |n: usize| from_afar(&near[n], earlier);
            for width in [PacketWidth::One, PacketWidth::Sixteen] {
                let found = answer_rays(&scene, &batch(near.len(), &far), width);
                let occluded = answer_occluded(&scene, &batch(near.len(), &far), width);
                let (mut off, mut tilted) = (0, 0);
                for (n, occluded) in occluded.into_iter().enumerate() {
                    let [t, u] = [expected.t[n], found.t[n] - earlier];
                    let same = expected.prim_id[n] == found.prim_id[n]
                        && (t == u || (t - u).abs() < 1e-4 * t);
                    let [a, b] = [&expected, &found].map(|hits| glam::Vec3::from(hits.ng[n]));
                    off += usize::from(!same);
                    tilted += usize::from(same && (a - b).length() > 1e-3);
                    assert_eq!(occluded, found.t[n].is_finite());
                }
                assert!(
                    off * 1000 <= near.len(),
                    "{off} off, from {earlier:e}, {form:?}"
                );
                assert!(
                    tilted * 1000 <= near.len(),
                    "{tilted} tilted, from {earlier:e}"
                );
            }
        }
    }
}

#[test]
fn rays_from_far_away_end_where_they_say_in_double_precision() {
    let device = curvetri::linked::device().unwrap();
    let mesh = Body::torus(48, 64).mesh();
    let form = Form::Curved(CurvedOptions::default());
    let scene = Scene::with_filters(&device, vec![mesh], form).unwrap();
    let far: Vec<UserRay> = rays(&scene, 1_000)
        .iter()
        .map(|ray| from_afar(ray, 1e6))
        .collect();
    let all = answer_all_hits(&scene, &batch(far.len(), &|n| far[n]), PacketWidth::One, 4);
    let mut cut = Vec::new();
    for (n, ray) in far.iter().enumerate() {
        let t = &all.hits.t[4 * n..][..4];
        if t[0].is_infinite() {
            continue;
        }
        for (tnear, tfar, expected) in [
            (t[0], t[0], t[0]),
            (t[0], f64::INFINITY, t[0]),
            (t[0] + 1e-5, f64::INFINITY, t[1]),
            (0.0, t[0] - 1e-5, f64::INFINITY),
            (0.0, 1e5, f64::INFINITY), // ends long before the scene
        ] {
            cut.push((
                UserRay {
                    tnear,
                    tfar,
                    ..*ray
                },
                expected,
            ));
        }
    }
    assert!(cut.len() > 2_000);
    for width in [
        PacketWidth::One,
        PacketWidth::Four,
        PacketWidth::Eight,
        PacketWidth::Sixteen,
    ] {
        let found = answer_rays(&scene, &batch(cut.len(), &|n| cut[n].0), width);
        let differ = (found.t.iter().zip(&cut)).filter(|(t, (_, expected))| *t != expected);
        // A second hit may lie as near.
        let differ = differ.count();
        assert!(differ * 1000 <= cut.len(), "{differ} of {}", cut.len());
    }
}

fn camera(distance: f64, projection: Projection) -> Camera {
    Camera {
        eye: distance * DVec3::new(0.48, 0.6, 0.64),
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection,
    }
}

fn picture(camera: Camera) -> Picture {
    Picture {
        samples: 4,
        ..Picture::new(96, 64, camera, UpAxis::Y)
    }
}

/// The mean difference of two pictures, and how many pixels differ by a tenth.
fn difference(a: &Film, b: &Film) -> (f32, usize) {
    let differences: Vec<f32> = (a.pixels().iter().zip(b.pixels()))
        .map(|(a, b)| (*a - *b).abs().max_element())
        .collect();
    let mean = differences.iter().sum::<f32>() / differences.len() as f32;
    (mean, differences.iter().filter(|d| **d > 0.1).count())
}

#[test]
fn a_narrow_camera_far_away_and_an_orthographic_one_see_the_same() {
    for form in forms() {
        let scene = torus(form);
        let height = 1.2 * scene.bounds().diagonal();
        let near = picture(camera(2.0 * height, Projection::Orthographic { height }));
        let (expected, _) = render(&scene, &near, &|_, _| ()).unwrap();
        let covered = expected.pixels().iter().filter(|p| p.w > 0.0).count();
        assert!(covered > 500, "{covered}");
        let depth = aovs(&scene, &near).unwrap().depth;
        for distance in [1e5 * height, 1e7 * height] {
            let fov_degrees = 2.0 * (0.5 * height / distance).atan().to_degrees();
            for projection in [
                Projection::Perspective { fov_degrees },
                Projection::Orthographic { height },
            ] {
                let far = picture(camera(distance, projection));
                let (film, _) = render(&scene, &far, &|_, _| ()).unwrap();
                let (mean, pixels) = difference(&expected, &film);
                let what = format!("{mean} {pixels}: {form:?} {projection:?} {distance:e}");
                assert!(mean < 2e-4 && pixels <= 2, "{what}");
                // The depths are the distance more, to single precision.
                let other = aovs(&scene, &far).unwrap().depth;
                let off = depth
                    .iter()
                    .zip(&other)
                    .filter(|(a, b)| a.is_finite() != b.is_finite());
                assert!(off.count() <= 2, "{what}");
            }
        }
    }
}

#[test]
fn an_orthographic_picture_of_a_ball_covers_its_disc() {
    let device = curvetri::linked::device().unwrap();
    let form = Form::Curved(CurvedOptions::default());
    let ball = Body::sphere_tetrahedron().mesh();
    let scene = Scene::new(&device, vec![ball], form).unwrap();
    for distance in [1.5, 1e6] {
        let camera = camera(distance, Projection::Orthographic { height: 4.0 });
        let (film, _) = render(&scene, &picture(camera), &|_, _| ()).unwrap();
        let covered: f32 = film.pixels().iter().map(|pixel| pixel.w).sum();
        let pixel = 4.0 / 64.0;
        let area = covered * pixel * pixel;
        assert!(
            (area / std::f32::consts::PI - 1.0).abs() < 0.01,
            "{area} from {distance}"
        );
    }
}
