//! The rendered outline of a coarse torus against the true torus's.

use std::f32::consts::TAU;

use curvetri::bodies::Body;
use curvetri::curved::CurvedOptions;
use curvetri::embree::Device;
use curvetri::render::{Camera, Film, Form, Picture, Scene, UpAxis, render};
use glam::{DVec2, DVec3, Vec2};

/// Pixels a side of the picture; the torus nearly fills it.
const SIDE: usize = 600;
/// Directions in which the outline is looked for.
const DIRECTIONS: usize = 240;
/// How far outside and inside the true outline the rendered one is looked for, in pixels.
const WIDEST: f32 = 9.0;
/// How far apart the looks along a direction are before they are refined, in pixels.
const STEP: f32 = 0.25;

fn camera(eye: DVec3) -> Camera {
    Camera {
        eye,
        target: DVec3::ZERO,
        up: DVec3::new(0.0, 1.0, 1.0),
        fov_degrees: 35.0,
    }
}

fn rendered(device: &Device, body: &Body, form: Form, camera: Camera) -> Film {
    let scene = Scene::new(device, vec![body.mesh()], form).unwrap();
    let picture = Picture {
        samples: 9,
        ..Picture::new(SIDE, SIDE, camera, UpAxis::Z)
    };
    render(&scene, &picture, &|_, _| ()).unwrap().0
}

/// The place farthest along a line, from `far` to `near`, where something is.
fn first_inside(inside: impl Fn(f32) -> bool, far: f32, near: f32) -> f32 {
    assert!(!inside(far), "the line begins inside");
    let mut out = far;
    while !inside(out - STEP) {
        out -= STEP;
        assert!(out > near, "the line meets nothing");
    }
    let mut within = out - STEP;
    for _ in 0..12 {
        let middle = 0.5 * (within + out);
        *(if inside(middle) {
            &mut within
        } else {
            &mut out
        }) = middle;
    }
    within
}

/// Points of the true outline, in pixels from the picture's middle, and their normals outwards.
fn true_outline(body: &Body, camera: &Camera) -> Vec<[Vec2; 2]> {
    let at = |angle: f32| {
        let way = Vec2::from_angle(angle);
        let inside = |distance: f32| truth_is_inside(body, camera, distance * way);
        first_inside(inside, 0.5 * SIDE as f32 - 2.0, 0.0) * way
    };
    (0..DIRECTIONS)
        .map(|n| TAU * n as f32 / DIRECTIONS as f32)
        .map(|angle| {
            [
                at(angle),
                -(at(angle + 2e-3) - at(angle - 2e-3)).perp().normalize(),
            ]
        })
        .collect()
}

/// How far the rendered outline is off the true one at the most, in pixels along its normals.
fn off(film: &Film, outline: &[[Vec2; 2]]) -> f32 {
    let distances = outline.iter().map(|&[point, normal]| {
        let inside = |distance: f32| film_is_inside(film, point + distance * normal);
        first_inside(inside, WIDEST, -WIDEST).abs()
    });
    distances.fold(0.0, f32::max)
}

/// Whether half of a pixel around an offset from the film's middle is covered, between pixels by
/// interpolation.
fn film_is_inside(film: &Film, offset: Vec2) -> bool {
    let [x, y] = (offset + 0.5 * SIDE as f32 - 0.5).to_array();
    let covered = |x: f32, y: f32| film.pixels()[y as usize * SIDE + x as usize].w;
    let (left, top) = (x.floor(), y.floor());
    let (right, bottom) = (x - left, y - top);
    let row = |y: f32| (1.0 - right) * covered(left, y) + right * covered(left + 1.0, y);
    (1.0 - bottom) * row(top) + bottom * row(top + 1.0) > 0.5
}

/// Whether the ray through an offset from the picture's middle meets the true body, by steps of its
/// distance.
fn truth_is_inside(body: &Body, camera: &Camera, offset: Vec2) -> bool {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let pixel = 2.0 * (0.5 * camera.fov_degrees).to_radians().tan() / SIDE as f64;
    let DVec2 { x, y } = offset.as_dvec2() * pixel;
    let direction = (forward + x * right - y * right.cross(forward)).normalize();
    let mut t = 0.0;
    while t < 2.0 * camera.eye.length() {
        let distance = body.signed_distance(camera.eye + t * direction);
        if distance < 1e-5 {
            return true;
        }
        t += distance;
    }
    false
}

#[test]
fn the_curved_outline_is_the_true_one_and_the_flat_one_is_not() {
    let device = Device::new().unwrap();
    let body = Body::torus(20, 16);
    for eye in [
        DVec3::new(0.0, 0.0, 4.4),
        DVec3::new(1.3, -3.3, 2.6),
        DVec3::new(4.3, 0.9, 0.3),
    ] {
        let camera = camera(eye);
        let outline = true_outline(&body, &camera);
        let error = |form: Form| off(&rendered(&device, &body, form, camera), &outline);
        let curved = error(Form::Curved(CurvedOptions::default()));
        let flat = error(Form::Flat);
        assert!(
            curved <= 0.5,
            "from {eye}: the curved outline is {curved} pixels off"
        );
        assert!(
            flat >= 3.0,
            "from {eye}: the flat outline is only {flat} pixels off"
        );
    }
}
