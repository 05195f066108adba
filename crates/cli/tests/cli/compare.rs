//! `curvetri compare` as a whole program.

use std::fs;

use crate::program::{Workshop, stderr, stdout};
use curvetri::mesh::{Mesh, obj_text};
use curvetri_bodies::Body;
use serde_json::Value;

const SMALL: [&str; 4] = ["--size", "240x180", "--samples", "4"];

fn torus(shop: &Workshop, name: &str, ring: usize, tube: usize) -> String {
    written(shop, name, &Body::torus(ring, tube).mesh())
}

fn written(shop: &Workshop, name: &str, mesh: &Mesh) -> String {
    shop.write(name, obj_text(mesh))
}

/// The figures of a comparison in small pictures.
fn figures(shop: &Workshop, args: &[&str]) -> Value {
    let sheet = shop.path("sheet.png");
    let first = ["compare", "--json", "-o", &sheet];
    let output = shop.succeeds(&[&first[..], &SMALL, args].concat());
    serde_json::from_str(&stdout(&output)).unwrap()
}

fn at(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path);
    let found = found.unwrap_or_else(|| panic!("there is no {path} in {value:#}"));
    found
        .as_f64()
        .unwrap_or_else(|| panic!("{path} is {found}"))
}

#[test]
fn beside_a_fine_torus_the_curved_one_is_nearer_than_the_flat_one_by_every_measure() {
    let shop = Workshop::new();
    let coarse = torus(&shop, "coarse.obj", 18, 24);
    let fine = torus(&shop, "fine.obj", 150, 200);
    let figures = figures(&shop, &[&coarse, "--reference", &fine, "--up-axis", "z"]);
    let names: Vec<&str> = figures["forms"]
        .as_array()
        .unwrap()
        .iter()
        .map(|form| form["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        ["flat", "curved", "paper", "interpolated", "reference"]
    );
    // At least so many times nearer; the floor is the reference's own: its shadows' flat edges, and
    // the few samples along them.
    let gains = [
        ("rmse", 2.0),
        ("flip", 2.0),
        ("outline/mean", 5.0),
        ("outline/max", 5.0),
        ("shading_normal/mean", 3.0),
        ("geometric_normal/mean", 5.0),
    ];
    for (measure, gain) in gains {
        let [flat, curved] = [0, 1].map(|n| at(&figures, &format!("/forms/{n}/apart/{measure}")));
        assert!(
            curved * gain < flat,
            "{measure}: curved {curved}, flat {flat}, wanted {gain} times"
        );
    }
    assert!(figures["forms"][4]["apart"].is_null());
    // Normals that are interpolated bring no shadows of flat triangles with them.
    let [flat, curved, interpolated] =
        [0, 1, 3].map(|n| at(&figures, &format!("/forms/{n}/darkened/share")));
    assert!(
        flat > 0.01 && curved < 0.2 * flat && interpolated < 0.2 * flat,
        "flat {flat}, curved {curved}, with interpolated normals {interpolated}"
    );
    let [curved, interpolated] =
        [1, 3].map(|n| at(&figures, &format!("/forms/{n}/apart/outline/mean")));
    assert_eq!(curved, interpolated, "the outline is the geometry's");
    let sheet = image::open(shop.path("sheet.png")).unwrap();
    assert_eq!(sheet.width(), 4 * 240 + 5 * 8, "four pictures and gaps");
    let findings = figures["findings"].as_array().unwrap();
    let favoured: Vec<&Value> = findings.iter().map(|finding| &finding["favours"]).collect();
    assert_eq!(favoured[..5], ["curved"; 5], "{findings:#?}");
    let told = findings[5]["text"].as_str().unwrap();
    assert!(
        told.contains("interpolated") && told.contains("own normals"),
        "{told}"
    );
}

#[test]
fn a_mesh_as_its_own_reference_has_no_error_as_flat_triangles() {
    let shop = Workshop::new();
    let mesh = torus(&shop, "torus.obj", 12, 16);
    let args = [
        "--reference",
        &mesh,
        "--also",
        "facets,tensor,smooth",
        "--ground",
    ];
    let figures = figures(&shop, &[&[&mesh[..]], &args[..]].concat());
    let apart = &figures["forms"][0]["apart"];
    for measure in ["/rmse", "/flip", "/shading_normal/max"] {
        assert_eq!(at(apart, measure), 0.0, "{measure}");
    }
    assert!(at(apart, "/outline/max") < 1e-4, "{apart}");
    // what is not the same has errors, and facets see the same outline
    for (n, name) in [(1, "curved"), (2, "facets"), (3, "tensor")] {
        let form = &figures["forms"][n];
        assert_eq!(form["name"], name);
        assert!(at(form, "/apart/rmse") > 0.005, "{name}");
    }
    assert!(at(&figures["forms"][2], "/apart/outline/max") < 1e-4);
    assert_eq!(
        figures["forms"].as_array().unwrap().len(),
        5,
        "smooth is there already"
    );
    assert_eq!(figures["findings"][0]["favours"], "flat");
}

#[test]
fn without_a_reference_the_difference_is_told_and_no_error() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let figures = figures(&shop, &[&mesh, "--repeat", "2"]);
    assert_eq!(figures["errors_against"], "flat");
    assert!(figures["forms"][0]["apart"].is_null());
    assert!(
        at(&figures, "/forms/1/apart/outline/mean") > 5.0,
        "a tetrahedron in a ball"
    );
    assert!(
        figures["findings"][0]["text"]
            .as_str()
            .unwrap()
            .contains("--reference")
    );
    let sheet = image::open(shop.path("sheet.png")).unwrap();
    assert_eq!(sheet.width(), 3 * 240 + 4 * 8, "three pictures and gaps");
    for n in [0, 1] {
        let form = &figures["forms"][n];
        for (least, middle, most) in [
            (
                "/seconds/render_least",
                "/seconds/render",
                "/seconds/render_most",
            ),
            (
                "/over_flat/render_least",
                "/over_flat/render",
                "/over_flat/render_most",
            ),
        ] {
            let [least, middle, most] = [least, middle, most].map(|path| at(form, path));
            assert!(0.0 < least && least <= middle && middle <= most, "{form}");
        }
        let parts: f64 = ["mesh", "records", "embree"]
            .map(|part| at(form, &format!("/bytes/{part}")))
            .iter()
            .sum();
        assert_eq!(at(form, "/bytes/total"), parts);
        assert!(at(form, "/mray_per_second") > 0.0);
    }
    assert_eq!(at(&figures, "/forms/0/over_flat/bytes"), 1.0);
    assert!(at(&figures, "/forms/1/bytes/records") > 0.0);
}

#[test]
fn the_scene_of_the_shadow_terminator_shows_it() {
    let shop = Workshop::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/terminator.obj");
    let sun = ["--up-axis", "z", "--sun-direction", "0.95,-0.2,0.24"];
    let figures = figures(&shop, &[&[scene], &sun[..]].concat());
    let share = at(&figures, "/forms/0/darkened/share");
    assert!(
        (0.02..0.1).contains(&share),
        "flat triangles darken {share}"
    );
    assert_eq!(figures["shadows_against"], "curved");
    assert!(
        at(&figures, "/forms/2/darkened/share") < 1e-3,
        "the paper's surface"
    );
    let findings = figures["findings"].as_array().unwrap();
    let told = findings.iter().find(|finding| {
        let text = finding["text"].as_str().unwrap();
        text.starts_with("Shadow terminator: flat triangles darken")
    });
    assert_eq!(told.unwrap()["favours"], "curved", "{findings:#?}");
}

#[test]
fn for_people_there_is_a_table_with_a_column_a_form() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let sheet = shop.path("sheet.png");
    let args = ["compare", &mesh, "-o", &sheet, "--also", "angular"];
    let text = stdout(&shop.succeeds(&[&args[..], &SMALL].concat()));
    let heads: Vec<&str> = text.lines().next().unwrap().split_whitespace().collect();
    assert_eq!(heads, ["COST", "flat", "curved", "angular"]);
    for row in [
        "load, s",
        "build the tree, s",
        "memory: Embree, MB",
        "speed, Mray/s",
        "picture, FLIP",
        "outline, mean, px",
        "darkened, %",
        "- Rendering the curved surface takes ",
    ] {
        assert!(
            text.lines().any(|line| line.starts_with(row)),
            "{row}: {text}"
        );
    }
}

#[test]
fn mistakes_are_named() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let png = shop.path("a.png");
    let said = |code, more: &[&str]| shop.fails(code, &[&["compare", &mesh], more].concat());
    let missing = said(1, &["-o", &png, "--reference", &shop.path("nowhere.ply")]);
    assert!(
        missing.contains("nowhere.ply") && missing.contains("No such file"),
        "{missing}"
    );
    let html = said(2, &["-o", &png, "--report", "report.pdf"]);
    assert!(html.contains("report.pdf does not end in .html"), "{html}");
    let jpg = said(2, &["-o", "a.jpg"]);
    assert!(jpg.contains("a.jpg does not end in .png"), "{jpg}");
    let flat = said(2, &["-o", &png, "--surface", "flat"]);
    assert!(flat.contains("--surface flat"), "{flat}");
    let place = said(1, &["-o", &png, "--report", "no/such/report.html"]);
    assert!(place.contains("no/such/report.html"), "{place}");
    let large = said(2, &["-o", &png, "--size", "60000x60000"]);
    assert!(large.contains("pixels"), "{large}");
    assert_eq!(shop.names(), ["ball.obj"], "nothing is left behind");
}

#[test]
fn a_reference_that_can_hardly_be_one_is_told() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let moved = shop.moved_sphere("moved.obj", [0.7, 0.0, 0.0]);
    let args = [
        "compare",
        &mesh,
        "-o",
        &shop.path("a.png"),
        "--reference",
        &moved,
    ];
    let output = shop.succeeds(&[&args[..], &SMALL].concat());
    let said = stderr(&output);
    assert!(
        said.contains("moved.obj: as a reference it should have more triangles"),
        "{said}"
    );
    assert!(said.contains("moved.obj: its bounds are off"), "{said}");
}

#[test]
fn a_camera_that_looks_elsewhere_is_told_and_nothing_differs() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let away = ["--eye", "0,0,9", "--target", "0,0,99", "--also", "none"];
    let args = ["compare", &mesh, "-o", &shop.path("a.png"), "--json"];
    let output = shop.succeeds(&[&args[..], &SMALL, &away].concat());
    let said = stderr(&output);
    assert!(said.contains("sees nothing"), "{said}");
    let figures: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let apart = &figures["forms"][1]["apart"];
    assert_eq!(at(apart, "/rmse"), 0.0);
    assert!(apart["outline"].is_null() && apart["shading_normal"].is_null());
}

#[test]
fn the_report_holds_everything_and_escapes_names() {
    let shop = Workshop::new();
    let mesh = shop.sphere("a<b>&\"c'.obj");
    let html = shop.path("report.html");
    let args = [
        "compare",
        &mesh,
        "-o",
        &shop.path("a.png"),
        "--report",
        &html,
    ];
    shop.succeeds(&[&args[..], &SMALL].concat());
    let page = fs::read_to_string(html).unwrap();
    assert!(
        page.contains("a&lt;b&gt;&amp;&quot;c&#x27;.obj"),
        "the name is there, escaped"
    );
    assert!(!page.contains("a<b>"), "and not as it is");
    let pictures = page.matches("src=\"data:image/png;base64,").count();
    assert_eq!(pictures, page.matches("<figure>").count());
    assert!(
        pictures >= 4,
        "flat, curved, their difference, what is darkened: {pictures}"
    );
    for outside in [
        "http:",
        "https:",
        "url(",
        "@import",
        "src=\"/",
        "<link rel=\"stylesheet",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
}
