//! The shadow terminator: flat triangles that are lit by interpolated normals darken pixels that the
//! sun shines on. `scenes/terminator.obj` shows it.

use curvetri::curved::CurvedOptions;
use curvetri::method::Surface;
use curvetri::render::{
    Aovs, Camera, Film, Form, Lighting, Picture, Projection, Scene, Shading, Sky, UpAxis, aovs,
    render,
};
use glam::{DVec3, Vec3};

/// A sun from the side, low.
const TOWARDS_SUN: Vec3 = Vec3::new(0.95, -0.2, 0.24);
/// Cosines to the sun below this are too near the light's end to tell by pixels.
const NEAR: f32 = 0.02;

fn picture() -> Picture {
    let camera = Camera {
        eye: DVec3::new(0.0, -5.0, 1.0),
        target: DVec3::ZERO,
        up: DVec3::Z,
        projection: Projection::Perspective { fov_degrees: 25.0 },
    };
    let picture = Picture::new(200, 200, camera, UpAxis::Z);
    Picture {
        samples: 1,
        albedo: 1.0,
        shading: Shading::Interpolated,
        lighting: Lighting {
            towards_sun: TOWARDS_SUN.normalize(),
            sun: Vec3::ONE,
            sky: Sky::uniform(Vec3::ZERO),
            ..picture.lighting
        },
        ..picture
    }
}

/// A form's picture and normals.
fn seen(form: Form) -> (Film, Aovs) {
    let scene = Scene::new(
        &curvetri::linked::device().unwrap(),
        vec![curvetri_bodies::terminator()],
        form,
    )
    .unwrap();
    let film = render(&scene, &picture(), &|_, _| ()).unwrap().0;
    (film, aovs(&scene, &picture()).unwrap())
}

/// The share of the pixels lit on the true sphere that are black although the normals that they are
/// lit by face the sun.
fn darkened((film, aovs): &(Film, Aovs)) -> f64 {
    let towards_sun = picture().lighting.towards_sun;
    let (mut lit, mut darkened) = (0, 0);
    for (n, pixel) in film.pixels().iter().enumerate() {
        let truly = aovs.position[n]
            .as_vec3()
            .normalize_or_zero()
            .dot(towards_sun);
        if pixel.w < 1.0 || truly < NEAR {
            continue;
        }
        lit += 1;
        let faces = aovs.normal[n].dot(towards_sun) > NEAR;
        darkened += u32::from(faces && pixel.x == 0.0);
    }
    assert!(lit > 5000, "{lit} pixels are too few to tell");
    f64::from(darkened) / f64::from(lit)
}

#[test]
fn flat_triangles_darken_what_curved_ones_leave_lit() {
    let flat = darkened(&seen(Form::Flat));
    println!("flat: {:.2} % of the lit pixels", 100.0 * flat);
    assert!(flat > 0.02, "flat triangles shadow themselves: {flat}");
    let surfaces = Surface::ALL.map(|surface| CurvedOptions {
        surface,
        ..CurvedOptions::default()
    });
    for options in surfaces.into_iter().chain([CurvedOptions::paper()]) {
        let share = darkened(&seen(Form::Curved(options)));
        println!("{options:?}: {:.3} % of the lit pixels", 100.0 * share);
        assert!(share < 1e-3, "{options:?}: {share}");
    }
}
