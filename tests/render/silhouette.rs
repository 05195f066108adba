//! The rendered outline of a coarse torus against the true torus's.

use curvetri::compare::Outline;
use curvetri::curved::CurvedOptions;
use curvetri::embree::Device;
use curvetri::render::{Camera, Film, Form, Picture, Projection, Scene, UpAxis, render};
use curvetri_bodies::Body;
use glam::{DVec2, DVec3, Vec2};

/// Pixels a side of the picture; the torus nearly fills it.
const SIDE: usize = 600;

fn camera(eye: DVec3) -> Camera {
    Camera {
        eye,
        target: DVec3::ZERO,
        up: DVec3::new(0.0, 1.0, 1.0),
        projection: Projection::Perspective { fov_degrees: 35.0 },
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

/// Whether half of a pixel around a point of the film is covered, between pixels by interpolation.
fn film_is_inside(film: &Film, point: Vec2) -> bool {
    let [x, y] = (point - 0.5)
        .clamp(Vec2::ZERO, Vec2::splat(SIDE as f32 - 1.001))
        .to_array();
    let covered = |x: f32, y: f32| film.pixels()[y as usize * SIDE + x as usize].w;
    let (left, top) = (x.floor(), y.floor());
    let (right, bottom) = (x - left, y - top);
    let row = |y: f32| (1.0 - right) * covered(left, y) + right * covered(left + 1.0, y);
    (1.0 - bottom) * row(top) + bottom * row(top + 1.0) > 0.5
}

/// Whether the ray through a point of the picture meets the true body, by steps of its distance.
fn truth_is_inside(body: &Body, camera: &Camera, point: Vec2) -> bool {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let pixel = camera.height_at(camera.eye + forward) / SIDE as f64;
    let DVec2 { x, y } = (point - 0.5 * SIDE as f32).as_dvec2() * pixel;
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
    let device = curvetri::linked::device().unwrap();
    let body = Body::torus(20, 16);
    for eye in [
        DVec3::new(0.0, 0.0, 4.4),
        DVec3::new(1.3, -3.3, 2.6),
        DVec3::new(4.3, 0.9, 0.3),
    ] {
        let camera = camera(eye);
        let truth = Outline::new(SIDE, SIDE, |point| truth_is_inside(&body, &camera, point));
        let error = |form: Form| {
            let film = rendered(&device, &body, form, camera);
            let outline = Outline::new(SIDE, SIDE, |point| film_is_inside(&film, point));
            outline
                .distance(&truth)
                .expect("both are in the picture")
                .max
        };
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
