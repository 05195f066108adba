//! The integrators against each other, and against what is known.

use curvetri::curved::CurvedOptions;
use curvetri::mesh::Mesh;
use curvetri::render::{
    Camera, Crop, Film, Form, Ground, Integrator, Lighting, Material, Picture, Projection, Scene,
    Sky, SphereLight, UpAxis, render,
};
use curvetri_bodies::Body;
use glam::{DVec3, Vec3, Vec4};

const DIRECT: Integrator = Integrator::Direct { sky_shadows: false };
const SHADOWED: Integrator = Integrator::Direct { sky_shadows: true };
const OPEN: Integrator = Integrator::AmbientOcclusion {
    distance: f32::INFINITY,
};

fn path(depth: u32) -> Integrator {
    Integrator::Path { depth }
}

fn scene(mesh: Mesh) -> Scene {
    let form = Form::Curved(CurvedOptions::default());
    Scene::new(&curvetri::linked::device().unwrap(), vec![mesh], form).unwrap()
}

/// The unit sphere.
fn ball() -> Scene {
    scene(Body::sphere_tetrahedron().mesh())
}

fn torus() -> Scene {
    scene(Body::torus(24, 32).mesh())
}

/// From a place that sees all of the bodies, z up.
fn picture(side: usize, integrator: Integrator) -> Picture {
    let camera = Camera {
        eye: DVec3::new(1.0, -4.0, 3.0),
        target: DVec3::ZERO,
        up: DVec3::Z,
        projection: Projection::Perspective { fov_degrees: 38.0 },
    };
    Picture {
        integrator,
        ..Picture::new(side, side, camera, UpAxis::Z)
    }
}

/// No light but that of radiance 1 from everywhere.
fn furnace(side: usize, integrator: Integrator) -> Picture {
    let mut picture = picture(side, integrator);
    picture.albedo = 1.0;
    picture.lighting = Lighting {
        sun: Vec3::ZERO,
        sky: Sky::uniform(Vec3::ONE),
        ..picture.lighting
    };
    picture
}

fn rendered(scene: &Scene, picture: &Picture) -> Film {
    render(scene, picture, &|_, _| ()).unwrap().0
}

/// The radiance of the pixels where something is seen.
fn radiances(film: &Film) -> Vec<f32> {
    let seen = film.pixels().iter().filter(|pixel| pixel.w > 0.0);
    let radiances: Vec<f32> = seen
        .flat_map(|pixel| (pixel.truncate() / pixel.w).to_array())
        .collect();
    let all = film.pixels().len();
    assert!(radiances.len() > all / 2, "{} of {all}", radiances.len());
    radiances
}

/// How far radiances are from what all should be, at most.
fn furthest(film: &Film, expected: f32) -> f32 {
    let apart = radiances(film).into_iter().map(|r| (r - expected).abs());
    apart.fold(0.0, f32::max)
}

#[test]
fn a_white_convex_body_in_a_furnace_is_not_seen() {
    let ball = ball();
    for integrator in [DIRECT, SHADOWED, OPEN, path(1), path(3)] {
        let apart = furthest(&rendered(&ball, &furnace(48, integrator)), 1.0);
        assert!(apart < 1e-5, "{integrator:?}: {apart}");
    }
    for integrator in [DIRECT, SHADOWED, path(1), path(3)] {
        let grey = Picture {
            albedo: 0.5,
            ..furnace(48, integrator)
        };
        let apart = furthest(&rendered(&ball, &grey), 0.5);
        assert!(apart < 1e-5, "{integrator:?}: {apart}");
    }
}

#[test]
fn a_white_torus_in_a_furnace_is_not_seen_if_light_may_meet_many_surfaces() {
    let torus = torus();
    let apart = furthest(&rendered(&torus, &furnace(48, path(200))), 1.0);
    assert!(apart < 1e-5, "{apart}");
    let few = radiances(&rendered(&torus, &furnace(48, path(1))));
    let mean = few.iter().sum::<f32>() / few.len() as f32;
    assert!(mean < 0.97, "surfaces hide the sky from each other: {mean}");
    let open = radiances(&rendered(&torus, &furnace(48, OPEN)));
    let same = open.iter().sum::<f32>() / open.len() as f32;
    assert!((mean - same).abs() < 5e-3, "{mean} and {same}");
}

#[test]
fn glass_in_a_furnace_is_not_seen() {
    let glass = Picture {
        material: Material::Glass { index: 1.5 },
        ..furnace(48, path(200))
    };
    let apart = furthest(&rendered(&ball(), &glass), 1.0);
    assert!(apart < 1e-5, "{apart}");
    // Around a torus some light goes on and on, as in a fibre.
    let film = rendered(&torus(), &glass);
    let [light, coverage] = [|p: &Vec4| p.x, |p: &Vec4| p.w].map(|of| {
        let values = film.pixels().iter().map(of);
        values.sum::<f32>()
    });
    let lost = 1.0 - light / coverage;
    assert!((-1e-5..2e-3).contains(&lost), "{lost}");
}

#[test]
fn a_lamp_in_a_closed_ball_lights_it_as_the_series_of_reflections_says() {
    let mut picture = picture(32, path(1));
    picture.camera.eye = DVec3::new(0.3, -0.4, 0.2);
    picture.camera.target = DVec3::new(0.0, 1.0, 0.1);
    picture.albedo = 0.6;
    picture.lighting = Lighting {
        sun: Vec3::ZERO,
        sky: Sky::uniform(Vec3::ZERO),
        lamp: Some(SphereLight {
            centre: DVec3::ZERO,
            radius: 0.25,
            radiance: Vec3::splat(16.0),
        }),
        ..picture.lighting
    };
    let ball = ball();
    // The lamp's (radius / distance)^2 times its radiance is 1 all over; so is its reflection.
    for (depth, expected) in [(1, 0.6), (2, 0.6 + 0.36), (4, 0.6 + 0.36 + 0.216 + 0.1296)] {
        picture.integrator = path(depth);
        let film = rendered(&ball, &picture);
        let apart = furthest(&film, expected);
        assert!(apart < 2e-3 * expected, "depth {depth}: {apart}");
    }
}

#[test]
fn a_lamp_is_seen_through_glass_and_not_without() {
    let mut picture = picture(17, path(2));
    picture.camera.eye = DVec3::new(0.0, -4.0, 0.0);
    picture.material = Material::Glass { index: 1.0 };
    picture.lighting = Lighting {
        sun: Vec3::ZERO,
        sky: Sky::uniform(Vec3::splat(0.25)),
        lamp: Some(SphereLight {
            centre: DVec3::new(0.0, 3.0, 0.0),
            radius: 0.5,
            radiance: Vec3::new(3.0, 2.0, 1.0),
        }),
        ..picture.lighting
    };
    let film = rendered(&ball(), &picture);
    let middle = film.pixels()[8 * 17 + 8];
    let expected = Vec4::new(3.25, 2.25, 1.25, 1.0);
    assert!((middle - expected).abs().max_element() < 1e-5, "{middle}");
    let aside = film.pixels()[8 * 17 + 13];
    let expected = Vec3::splat(0.25).extend(1.0);
    assert!((aside - expected).abs().max_element() < 1e-5, "{aside}");
    assert_eq!(film.pixels()[0], Vec4::ZERO);
}

/// All three lights, and a ground.
fn many_lights(integrator: Integrator) -> Picture {
    let mut picture = picture(48, integrator);
    picture.ground = Ground::Plane;
    picture.samples = 256;
    picture.lighting.lamp = Some(SphereLight {
        centre: DVec3::new(1.0, -0.5, 2.0),
        radius: 0.4,
        radiance: Vec3::new(9.0, 7.0, 4.0),
    });
    picture
}

/// Means of squares of 8 by 8 pixels.
fn coarse(film: &Film) -> Vec<Vec4> {
    let side = film.width() / 8;
    let mut means = vec![Vec4::ZERO; side * side];
    for (n, pixel) in film.pixels().iter().enumerate() {
        let [x, y] = [n % film.width(), n / film.width()];
        means[y / 8 * side + x / 8] += pixel / 64.0;
    }
    means
}

/// How far two pictures' squares are apart, at most, in relation to the mean of both.
fn coarsely_apart(a: &Film, b: &Film) -> f32 {
    let pairs = coarse(a).into_iter().zip(coarse(b));
    let apart = pairs.map(|(a, b)| (a - b).abs().max_element() / (0.5 * (a + b)).max_element());
    apart.fold(0.0, f32::max)
}

#[test]
fn direct_light_is_that_of_paths_to_one_surface() {
    for scene in [torus(), ball()] {
        let direct = rendered(&scene, &many_lights(SHADOWED));
        let path = rendered(
            &scene,
            &Picture {
                seed: 7,
                ..many_lights(path(1))
            },
        );
        assert_ne!(direct, path, "the noise is another one");
        let apart = coarsely_apart(&direct, &path);
        assert!(apart < 0.01, "{apart}");
    }
    // On a convex body nothing hides the sky, so its light without shadows is the same.
    let alone = |integrator, seed| Picture {
        ground: Ground::None,
        seed,
        ..many_lights(integrator)
    };
    let ball = ball();
    let apart = coarsely_apart(
        &rendered(&ball, &alone(DIRECT, 0)),
        &rendered(&ball, &alone(path(1), 7)),
    );
    assert!(apart < 0.01, "{apart}");
}

#[test]
fn more_surfaces_bring_more_light() {
    let torus = torus();
    let mean = |depth| {
        let film = rendered(&torus, &many_lights(path(depth)));
        film.pixels().iter().map(|p| p.x).sum::<f32>() / film.pixels().len() as f32
    };
    let means = [1, 2, 8].map(mean);
    assert!(means[0] < means[1] && means[1] < means[2], "{means:?}");
}

#[test]
fn a_crop_is_a_part_of_the_whole_picture_to_the_bit() {
    let torus = torus();
    for integrator in [DIRECT, SHADOWED, OPEN, path(3)] {
        let whole = Picture {
            samples: 3,
            ..many_lights(integrator)
        };
        let crop = Crop {
            x: 13,
            y: 18,
            width: 22,
            height: 9,
        };
        let part = Picture {
            crop: Some(crop),
            ..whole.clone()
        };
        let (whole, part) = (rendered(&torus, &whole), rendered(&torus, &part));
        assert_eq!((part.width(), part.height()), (22, 9));
        for (n, pixel) in part.pixels().iter().enumerate() {
            let [x, y] = [crop.x + n % 22, crop.y + n / 22];
            assert_eq!(
                pixel,
                &whole.pixels()[48 * y + x],
                "{integrator:?}: {x} {y}"
            );
        }
    }
}

#[test]
fn a_seed_gives_the_same_picture_on_any_number_of_threads_and_another_one_another() {
    let torus = torus();
    for integrator in [DIRECT, SHADOWED, OPEN, path(3)] {
        let on = |threads: usize, seed: u32| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let picture = Picture {
                samples: 2,
                seed,
                ..many_lights(integrator)
            };
            pool.build().unwrap().install(|| rendered(&torus, &picture))
        };
        let first = on(1, 5);
        assert_eq!(first, on(3, 5), "{integrator:?}");
        assert_ne!(first, on(1, 6), "{integrator:?}");
    }
}

#[test]
fn what_shows_the_sky_covers_all_of_the_picture() {
    let sky = Picture {
        show_sky: true,
        ..furnace(24, path(1))
    };
    let film = rendered(&ball(), &sky);
    for pixel in film.pixels() {
        assert!((*pixel - Vec4::ONE).abs().max_element() < 1e-5, "{pixel}");
    }
}
