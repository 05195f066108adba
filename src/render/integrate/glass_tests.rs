//! A glass ball of four triangles shows what a true glass ball shows.

use glam::{DVec3, Vec3, Vec4};

use super::sampler::{PixelSampler, Sample};
use crate::curved::CurvedOptions;
use crate::embree::Ray;
use crate::render::Projection;
use crate::render::{
    Camera, Form, Integrator, Lighting, Material, Picture, Scene, Sky, UpAxis, render,
};
use curvetri_bodies::Body;
use curvetri_method::Surface;

const INDEX: f64 = 1.5;
const SIDE: usize = 64;
const SAMPLES: u32 = 16;
const DEPTH: u32 = 8;

/// A picture that the ball fills for the most part, under a sky on which errors show.
fn picture() -> Picture {
    let camera = Camera {
        eye: DVec3::new(1.5, 2.0, 4.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_degrees: 25.0 },
    };
    let mut picture = Picture::new(SIDE, SIDE, camera, UpAxis::Y);
    picture.samples = SAMPLES;
    picture.integrator = Integrator::Path { depth: DEPTH };
    picture.material = Material::Glass {
        index: INDEX as f32,
    };
    picture.lighting = Lighting {
        sun: Vec3::ZERO,
        sky: Sky {
            above: Vec3::new(0.9, 0.8, 1.0),
            below: Vec3::new(0.5, 0.6, 0.4),
            checker: 0.4,
            ..Sky::uniform(Vec3::ONE)
        },
        ..picture.lighting
    };
    picture
}

/// Where a line meets the unit sphere.
fn ball(origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
    let along = -origin.dot(direction);
    let half = 1.0 - (origin + along * direction).length_squared();
    (half > 0.0).then(|| [along - half.sqrt(), along + half.sqrt()])
}

/// The share reflected, and the direction behind the surface, by Fresnel and Snell; `normal` is on the
/// side that the light comes from.
fn split(direction: DVec3, normal: DVec3, ratio: f64) -> (f64, DVec3) {
    let cosine = -direction.dot(normal);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if rest <= 0.0 {
        return (1.0, direction);
    }
    let behind = rest.sqrt();
    let perpendicular = (ratio * cosine - behind) / (ratio * cosine + behind);
    let parallel = (cosine - ratio * behind) / (cosine + ratio * behind);
    (
        0.5 * (perpendicular.powi(2) + parallel.powi(2)),
        ratio * direction + (ratio * cosine - behind) * normal,
    )
}

/// What the true ball shows along a camera ray, by the same random choices as the path has.
fn reference(ray: &Ray, sample: &Sample, sky: &Sky, index: f64) -> Vec4 {
    let mut origin = ray.origin.as_dvec3();
    let mut direction = ray.direction.as_dvec3().normalize();
    let Some([entry, _]) = ball(origin, direction) else {
        return Vec4::ZERO;
    };
    origin += entry * direction;
    let mut inside = false;
    for surface in 0..DEPTH {
        let (outer, choice) = (origin.normalize(), sample.numbers(2 * surface)[2]);
        let (normal, ratio) = if inside {
            (-outer, index)
        } else {
            (outer, 1.0 / index)
        };
        let (reflected, through) = split(direction, normal, ratio);
        if f64::from(choice) >= reflected {
            direction = through;
            inside = !inside;
        } else {
            direction -= 2.0 * direction.dot(normal) * normal;
        }
        if !inside {
            return sky.radiance(direction.as_vec3()).extend(1.0);
        }
        origin -= 2.0 * origin.dot(direction) * direction;
    }
    Vec3::ZERO.extend(1.0)
}

/// The true ball's picture, from the same camera rays.
fn reference_picture(picture: &Picture, index: f64) -> Vec<Vec4> {
    let lens = picture.camera.lens(DVec3::ZERO, SIDE, SIDE).unwrap();
    let pixel = |n: usize| {
        let [x, y] = [n % SIDE, n / SIDE];
        let sampler = PixelSampler::new(x as u32, y as u32, picture.seed);
        let values = (0..SAMPLES).map(|n| {
            let [dx, dy] = sampler.point(n);
            let ray = lens.ray(x as f32 + dx, y as f32 + dy);
            reference(&ray, &sampler.sample(n), &picture.lighting.sky, index)
        });
        values.sum::<Vec4>() / SAMPLES as f32
    };
    (0..SIDE * SIDE).map(pixel).collect()
}

/// The root of the mean square of the differences of all colours, where white is 1.
fn rmse(a: &[Vec4], b: &[Vec4]) -> f64 {
    let squares = a
        .iter()
        .zip(b)
        .map(|(a, b)| f64::from((a - b).truncate().length_squared()));
    (squares.sum::<f64>() / (3 * a.len()) as f64).sqrt()
}

#[test]
fn a_glass_ball_of_four_triangles_shows_what_a_true_one_shows() {
    let device = crate::linked::device().unwrap();
    let picture = picture();
    let truth = reference_picture(&picture, INDEX);
    // A wrong refractive index would show: so much do pictures differ where refraction does.
    let other = rmse(&reference_picture(&picture, 1.01 * INDEX), &truth);
    assert!(other > 0.02, "the sky shows errors of refraction: {other}");
    let surfaces = Surface::ALL.map(|surface| CurvedOptions {
        surface,
        ..CurvedOptions::default()
    });
    for options in surfaces.into_iter().chain([CurvedOptions::paper()]) {
        let form = Form::Curved(options);
        let scene = Scene::new(&device, vec![Body::sphere_tetrahedron().mesh()], form).unwrap();
        let (film, _) = render(&scene, &picture, &|_, _| ()).unwrap();
        let error = rmse(film.pixels(), &truth);
        println!("{options:?}: RMSE {error:.2e}");
        assert!(error < 0.01, "{options:?}: {error}");
    }
}
