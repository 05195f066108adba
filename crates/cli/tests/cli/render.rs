//! `curvetri render` as a whole program.

use std::fs;

use crate::program::{Workshop, stderr, stdout};

#[test]
fn a_mesh_becomes_a_picture_with_background_and_body() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let picture = shop.path("ball.png");
    let view = ["--size", "90x60", "--eye", "0,0,5", "--target", "0,0,0"];
    let args = ["render", &mesh, "-o", &picture, "--sun-direction", "0,0,1"];
    shop.succeeds(&[&args[..], &view].concat());
    let image = image::open(&picture).unwrap().into_rgb8();
    assert_eq!(image.dimensions(), (90, 60));
    let [corner, middle] = [(0, 0), (45, 30)].map(|(x, y)| image.get_pixel(x, y).0);
    assert!(
        corner[2] > corner[0],
        "the background is blue above: {corner:?}"
    );
    assert!(
        middle[0] > 200 && middle[0] > middle[2],
        "the sun is warm: {middle:?}"
    );
    assert_eq!(shop.names(), ["ball.obj", "ball.png"]);
}

#[test]
fn the_curved_silhouette_is_round_and_the_flat_one_is_not() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let covered = |surface: &str| {
        let picture = shop.path(&format!("{surface}.png"));
        let view = [
            "--eye", "0,0,5", "--target", "0,0,0", "--fov", "40", "--size", "100x100",
        ];
        let args = [
            "render",
            &mesh,
            "-o",
            &picture,
            "--transparent",
            "--surface",
            surface,
        ];
        shop.succeeds(&[&args[..], &view[..]].concat());
        let image = image::open(&picture).unwrap().into_rgba8();
        image
            .pixels()
            .map(|pixel| f64::from(pixel.0[3]) / 255.0)
            .sum::<f64>()
    };
    // The unit sphere from 5 away: the tangent of its rim's angle over that of half the view.
    let radius = 50.0 * (1.0 / 24_f64.sqrt()) / 20_f64.to_radians().tan();
    let disc = std::f64::consts::PI * radius * radius;
    for surface in ["angular", "tensor", "smooth"] {
        let share = covered(surface) / disc;
        assert!(
            (share - 1.0).abs() < 2e-3,
            "{surface} covers {share} of the disc"
        );
    }
    assert!(covered("flat") < 0.8 * disc);
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let picture = |threads: &str| {
        let path = shop.path(&format!("{threads}.png"));
        let args = ["render", &mesh, "-o", &path, "--size", "70x50", "--ground"];
        shop.succeeds(&[&args[..], &["--threads", threads]].concat());
        fs::read(path).unwrap()
    };
    let first = picture("1");
    assert!(first == picture("2"), "1 and 2 threads differ");
    assert!(first == picture("5"), "1 and 5 threads differ");
}

#[test]
fn the_ground_takes_the_shadow() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let picture = |name: &str, more: &[&str]| {
        let path = shop.path(name);
        let view = [
            "--eye", "0,9,0.01", "--target", "0,0,0", "--size", "120x120",
        ];
        let sun = ["--sun-direction", "1,1,0"];
        let args = ["render", &mesh, "-o", &path];
        shop.succeeds(&[&args[..], &view, &sun, more].concat());
        image::open(path).unwrap().into_rgb8()
    };
    let (with, without) = (
        picture("with.png", &["--ground"]),
        picture("without.png", &[]),
    );
    // From above, with the sun from the right, the shadow is to the left of the ball.
    let shade = |x: u32| with.get_pixel(x, 60).0[0];
    assert!(
        shade(28) < shade(92) - 40,
        "{} against {}",
        shade(28),
        shade(92)
    );
    assert_ne!(with.get_pixel(92, 60), without.get_pixel(92, 60));
    assert_eq!(with.get_pixel(60, 60), without.get_pixel(60, 60));
}

#[test]
fn several_meshes_share_a_picture() {
    let shop = Workshop::new();
    let near = shop.sphere("near.obj");
    let far = shop.moved_sphere("far.obj", [3.0, 0.0, 0.0]);
    let output = shop.succeeds(&[
        "render",
        &near,
        &far,
        "-o",
        &shop.path("two.png"),
        "--size",
        "80x60",
        "--json",
    ]);
    let stats: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(stats["triangles"]["total"], 8);
    let image = image::open(shop.path("two.png")).unwrap().into_rgb8();
    let behind = image.get_pixel(0, 30).0;
    let differs = |x: u32| {
        image
            .get_pixel(x, 30)
            .0
            .iter()
            .zip(behind)
            .any(|(a, b)| a.abs_diff(b) > 12)
    };
    assert!(differs(20) && differs(60), "a ball on either side");
}

#[test]
fn statistics_are_json() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let path = shop.path("ball.png");
    let args = [
        "render",
        &mesh,
        "-o",
        &path,
        "--size",
        "40x20",
        "--samples",
        "3",
        "--stats",
    ];
    let output = shop.succeeds(&[&args[..], &["--json"]].concat());
    let stats: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(stats["triangles"]["curved"], 4);
    assert_eq!(stats["rays"]["primary"], 40 * 20 * 3);
    assert!(stats["rays"]["shadow"].as_u64().unwrap() > 0);
    assert!(stats["bytes"]["embree"].as_u64().unwrap() > 0);
    assert!(stats["bytes"]["records"].as_u64().unwrap() > 0);
    assert!(stats["kernel"]["calls_per_ray"].as_f64().unwrap() > 0.0);
    assert!(stats["kernel"]["evaluations_per_call"].as_f64().unwrap() > 0.0);
    for time in ["load", "curve", "build", "render"] {
        assert!(stats["seconds"][time].is_f64(), "{time}: {stats}");
    }
    let text = stdout(&shop.succeeds(&args));
    assert!(
        text.contains("triangles") && text.contains("Mray/s"),
        "{text}"
    );
}

#[test]
fn the_paper_s_root_finder_can_be_chosen() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let evaluations = |more: &[&str]| {
        let path = shop.path("ball.png");
        let args = ["render", &mesh, "-o", &path, "--size", "40x30", "--json"];
        let output = shop.succeeds(&[&args[..], more].concat());
        let stats: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
        stats["kernel"]["evaluations"].as_u64().unwrap()
    };
    let finish = evaluations(&[]);
    let coarse = evaluations(&["--ita-bits", "8", "--ita-step", "2"]);
    let fine = evaluations(&["--ita-bits", "24", "--ita-step", "2"]);
    assert!(fine > coarse && fine > finish, "{finish} {coarse} {fine}");
}

#[test]
fn a_method_is_its_parts_and_each_can_be_chosen() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let work = |more: &[&str]| {
        let path = shop.path("ball.png");
        let args = ["render", &mesh, "-o", &path, "--size", "40x30", "--json"];
        let output = shop.succeeds(&[&args[..], more].concat());
        let stats: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
        (stats["kernel"].clone(), stats["spheres"].clone())
    };
    let paper = work(&["--method", "paper"]);
    // The bounds cannot tell that the ball's triangles stay within the paper's spheres.
    assert_eq!(paper.1["enlarged"], 4);
    let surface = ["--surface", "angular"];
    let bounds = ["--bounds", "sphere"];
    let solver = ["--solver", "ita"];
    let primitives = ["--primitives", "triangles"];
    let parts = [surface, bounds, solver, primitives].concat();
    assert_eq!(paper, work(&parts));
    let default = work(&[]);
    assert_eq!(default.1["enlarged"], 0);
    assert_eq!(default, work(&["--method", "default"]));
    let ours = [
        ["--surface", "smooth"],
        ["--bounds", "tight"],
        ["--solver", "finish"],
        ["--primitives", "clusters"],
    ]
    .concat();
    assert_eq!(default, work(&[&["--method", "paper"], &ours[..]].concat()));
    // Spheres let more rays through to a patch; fewer digits take fewer evaluations.
    let kernel = |of: &(serde_json::Value, _), what: &str| of.0[what].as_u64().unwrap();
    assert!(kernel(&work(&bounds), "calls") > kernel(&default, "calls"));
    let few = work(&["--method", "paper", "--ita-bits", "9"]);
    assert!(kernel(&few, "evaluations") < kernel(&paper, "evaluations"));
    let path = shop.path("ball.png");
    let args = ["render", &mesh, "-o", &path, "--size", "8x8", "--stats"];
    let text = stdout(&shop.succeeds(&[&args[..], &bounds].concat()));
    assert!(text.contains("spheres    4 (4 enlarged)"), "{text}");
    assert!(!stdout(&shop.succeeds(&args)).contains("spheres"));
}

#[test]
fn nothing_is_said_unless_asked_for() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let args = ["render", &mesh, "-o", &shop.path("a.png"), "--size", "8x8"];
    let output = shop.succeeds(&args);
    assert_eq!(
        (stdout(&output), stderr(&output)),
        (String::new(), String::new())
    );
    let output = shop.succeeds(&[&args[..], &["-v"]].concat());
    assert!(
        stderr(&output).contains("4 triangles"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn warnings_are_told_and_quiet_silences_them() {
    let shop = Workshop::new();
    let mesh = shop.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n");
    let args = ["render", &mesh, "-o", &shop.path("a.png"), "--size", "8x8"];
    let told = stderr(&shop.succeeds(&args));
    assert!(told.starts_with("curvetri: warning: "), "{told}");
    assert!(told.contains("m.obj"), "{told}");
    assert_eq!(stderr(&shop.succeeds(&[&args[..], &["-q"]].concat())), "");
}

#[test]
fn a_mesh_far_from_the_origin_is_rendered_as_one_near_it() {
    let shop = Workshop::new();
    let picture = |mesh: &str, name: &str| {
        let path = shop.path(name);
        shop.succeeds(&["render", mesh, "-o", &path, "--size", "64x48", "--ground"]);
        image::open(path).unwrap().into_rgb8()
    };
    let near = picture(&shop.sphere("near.obj"), "near.png");
    let far = picture(&shop.moved_sphere("far.obj", [4e6, -2e6, 1e6]), "far.png");
    let apart = near
        .iter()
        .zip(far.iter())
        .map(|(a, b)| a.abs_diff(*b))
        .max()
        .unwrap();
    assert!(apart <= 3, "pictures differ by {apart} of 255");
}

/// The unit sphere of many triangles.
fn fine_ball(shop: &Workshop) -> String {
    let mesh = shop.path("fine.obj");
    let ball = shop.sphere("ball.obj");
    shop.succeeds(&["tessellate", &ball, "--level", "8", "-o", &mesh]);
    mesh
}

/// How many triangles of a mesh stay flat by the tolerance among these options.
fn flat_by_tolerance(shop: &Workshop, mesh: &str, options: &[&str]) -> u64 {
    let picture = shop.path("ball.png");
    let args = ["render", mesh, "-o", &picture, "--samples", "1", "--json"];
    let said = stdout(&shop.succeeds(&[&args[..], options].concat()));
    let stats: serde_json::Value = serde_json::from_str(&said).unwrap();
    stats["triangles"]["flat_tolerance"].as_u64().unwrap()
}

#[test]
fn triangles_within_a_tolerance_in_pixels_stay_flat() {
    let shop = Workshop::new();
    let mesh = fine_ball(&shop);
    let flat = |tolerance: &str, size: &str| {
        flat_by_tolerance(&shop, &mesh, &["--size", size, "--tolerance", tolerance])
    };
    assert_eq!(flat("0px", "40x30"), 0);
    let [coarse, fine] = ["40x30", "1200x900"].map(|size| flat("2px", size));
    assert!(coarse > 100 && fine == 0, "{coarse} {fine}");
    let all = flat("10", "40x30");
    assert!(all > 200 && flat("1000px", "40x30") == all, "{all}");
    let [rays, hits] = ["x.npy", "x.npz"].map(|name| shop.path(name));
    let args = [
        "trace",
        &mesh,
        "--rays",
        &rays,
        "-o",
        &hits,
        "--tolerance",
        "1px",
    ];
    let said = shop.fails(2, &args);
    assert!(said.contains("`curvetri render`"), "{said}");
}

#[test]
fn an_orthographic_camera_sees_all_or_as_much_as_is_asked_for() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let covered = |more: &[&str]| {
        let picture = shop.path("ball.png");
        let args = [
            "render",
            &mesh,
            "-o",
            &picture,
            "--transparent",
            "--size",
            "120x80",
        ];
        shop.succeeds(&[&args[..], more].concat());
        let image = image::open(&picture).unwrap().into_rgba8();
        let mut outside = (0..120).flat_map(|x| [(x, 0), (x, 79)]);
        assert!(
            outside.all(|(x, y)| image.get_pixel(x, y).0[3] == 0),
            "{more:?}"
        );
        let alpha = image.pixels().map(|pixel| f64::from(pixel.0[3]) / 255.0);
        alpha.sum::<f64>()
    };
    let disc = |pixels_a_radius: f64| std::f64::consts::PI * pixels_a_radius.powi(2);
    // Wherever the camera is.
    for eye in ["0,0,5", "3e6,4e6,0"] {
        let share = covered(&["--orthographic=4", "--eye", eye, "--target", "0,0,0"]) / disc(20.0);
        assert!((share - 1.0).abs() < 5e-3, "{share} from {eye}");
    }
    // All of it, and not much more.
    let share = covered(&["--orthographic"]) / disc(40.0);
    assert!((0.6..0.95).contains(&share), "{share}");
    // What a perspective camera sees at the middle, from a place of its own.
    let share = covered(&["--orthographic", "--eye", "0,0,5", "--fov", "40"])
        / disc(40.0 / (5.0 * 20_f64.to_radians().tan()));
    assert!((share - 1.0).abs() < 5e-3, "{share}");
    for height in ["0", "-1", "inf", "x"] {
        let height = format!("--orthographic={height}");
        let said = shop.fails(2, &["render", &mesh, "-o", &shop.path("no.png"), &height]);
        assert!(said.contains("--orthographic"), "{said}");
    }
}

#[test]
fn a_tolerance_in_pixels_counts_an_orthographic_camera_s() {
    let shop = Workshop::new();
    let mesh = fine_ball(&shop);
    let flat = |height: &str, eye: &str| {
        let height = format!("--orthographic={height}");
        let view = [&height, "--eye", eye, "--target", "0,0,0"];
        let picture = ["--size", "40x30", "--tolerance", "1px"];
        flat_by_tolerance(&shop, &mesh, &[&view[..], &picture].concat())
    };
    // A pixel of a tenth, from within and from far away, or of a ten-thousandth.
    let near = flat("3", "0,0,1.5");
    assert!(near > 100, "{near}");
    assert_eq!(flat("3", "0,0,1e6"), near);
    assert_eq!(flat("0.003", "0,0,1e6"), 0);
}
