//! `curvetri inspect` as a whole program.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::program::{Workshop, stderr, stdout};
use serde_json::Value;

/// A prism of 18 sides, stored as most programs store one: a flat normal for each facet.
fn prism() -> String {
    let mut text = String::from("solid prism\n");
    let mut facet = |corners: [[f64; 3]; 3]| {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in corners {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    };
    let around = |k: u32, z: f64| {
        let angle = f64::from(k % 18) / 18.0 * std::f64::consts::TAU;
        [angle.cos(), angle.sin(), z]
    };
    for k in 0..18 {
        facet([around(k, 0.0), around(k + 1, 0.0), around(k + 1, 1.0)]);
        facet([around(k, 0.0), around(k + 1, 1.0), around(k, 1.0)]);
        facet([[0., 0., 1.], around(k, 1.0), around(k + 1, 1.0)]);
        facet([[0., 0., 0.], around(k + 1, 0.0), around(k, 0.0)]);
    }
    text + "endsolid prism\n"
}

fn json(shop: &Workshop, args: &[&str]) -> Value {
    let args = [&["inspect", "--json"], args].concat();
    serde_json::from_str(&stdout(&shop.succeeds(&args))).unwrap()
}

#[test]
fn a_report_tells_counts_kinds_and_advice() {
    let shop = Workshop::new();
    let mesh = shop.write("prism.stl", prism());
    let report = json(&shop, &[&mesh]);
    assert_eq!(report["triangles"], 72);
    assert_eq!(report["places"], 38);
    assert_eq!(report["closed"], true);
    assert_eq!(report["edges"]["hard"], 36);
    assert_eq!(report["normals"]["made"], 216);
    let kinds = report["kinds"].as_object().unwrap();
    let total: u64 = kinds.values().map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(total, 72);
    // The walls' curve over an edge that turns by 20 degrees.
    let height = report["heights"]["greatest"].as_f64().unwrap();
    let arrow = 1.0 - 10f64.to_radians().cos();
    assert!(
        (height - arrow).abs() < 0.1 * arrow,
        "{height} is not {arrow}"
    );
    assert!(
        report["advice"][0]
            .as_str()
            .unwrap()
            .contains("--crease-angle")
    );

    let text = stdout(&shop.succeeds(&["inspect", &mesh]));
    assert!(text.contains("closed     yes"), "{text}");
    assert!(text.contains("edges      72 smooth, 36 hard"), "{text}");
}

#[test]
fn spheres_are_counted_where_they_are_asked_for() {
    let shop = Workshop::new();
    // Two normals that lean far out over the edge between them.
    let mesh = shop.write(
        "steep.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 -0.7 0.71\nf 1//2 2//2 3//1\n",
    );
    let tight = json(&shop, &[&mesh]);
    assert_eq!(tight["spheres"]["enlarged"], 0);
    for options in [&["--method", "paper"][..], &["--bounds", "sphere"]] {
        let report = json(&shop, &[options, &[mesh.as_str()]].concat());
        let curved = [&report["kinds"]["curved"], &report["kinds"]["fallback"]];
        let curved: u64 = curved.iter().map(|count| count.as_u64().unwrap()).sum();
        let spheres = report["spheres"].as_object().unwrap();
        let total: u64 = spheres.values().map(|count| count.as_u64().unwrap()).sum();
        assert_eq!((curved, total), (1, 1), "{report}");
    }
    let text = stdout(&shop.succeeds(&["inspect", "--method", "paper", &mesh]));
    assert!(text.contains("spheres    1 enlarged"), "{text}");
    let text = stdout(&shop.succeeds(&["inspect", &mesh]));
    assert!(!text.contains("spheres"), "{text}");
}

#[test]
fn options_decide_what_is_hard() {
    let shop = Workshop::new();
    let mesh = shop.write("prism.stl", prism());
    let hard = |angle| json(&shop, &["--crease-angle", angle, &mesh])["edges"]["hard"].clone();
    assert_eq!([hard("19"), hard("21"), hard("91")], [54, 36, 0]);
}

#[test]
fn standard_input_is_read_and_named() {
    let shop = Workshop::new();
    let run = |content: &str| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_curvetri"))
            .args(["inspect", "--json", "-"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut input = child.stdin.take().unwrap();
        input.write_all(content.as_bytes()).unwrap();
        drop(input);
        child.wait_with_output().unwrap()
    };
    let read = run(&prism());
    let report: Value = serde_json::from_str(&stdout(&read)).unwrap();
    let mesh = shop.write("prism.stl", prism());
    assert_eq!(report, json(&shop, &[&mesh]));
    let refused = run("OFF\n1 x\n");
    assert_eq!(refused.status.code(), Some(1));
    let said = stderr(&refused);
    assert!(
        said.contains("standard input:2: \"x\" is no number"),
        "{said}"
    );
}

#[test]
fn a_picture_shows_the_kinds_in_their_colours() {
    let shop = Workshop::new();
    // Two triangles, of which one has a normal that points away.
    let file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 3 0 0\nv 2 1 0\nvn 0 0 1\nvn 0 0 -1\n\
                f 1//1 2//1 3//1\nf 4//1 5//1 6//2\n";
    let mesh = shop.write("two.obj", file);
    let picture = shop.path("kinds.png");
    let red = |mesh: &str| {
        let text = stdout(&shop.succeeds(&["inspect", "--image", &picture, mesh]));
        assert!(
            text.contains("colours    grey: curved, blue: fallback"),
            "{text}"
        );
        let pixels = image::open(&picture).unwrap().to_rgb8();
        let is_red = |pixel: &&image::Rgb<u8>| {
            let [r, g, b] = pixel.0.map(u32::from);
            r > 60 && r > 2 * g.max(b)
        };
        pixels.pixels().filter(is_red).count()
    };
    assert!(red(&mesh) > 10_000, "{}", red(&mesh));
    let good = shop.write("good.obj", file.replace("6//2", "6//1"));
    assert_eq!(red(&good), 0);
    let said = shop.fails(2, &["inspect", "--image", "kinds.jpg", &mesh]);
    assert!(said.contains("kinds.jpg does not end in .png"), "{said}");
}

#[test]
fn what_cannot_be_inspected_is_refused() {
    let shop = Workshop::new();
    let mesh = shop.write("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let said = shop.fails(2, &["inspect", "--surface", "flat", &mesh]);
    assert!(said.contains("--surface flat"), "{said}");
    let said = shop.fails(
        1,
        &["inspect", &shop.write("x.ply", "ply\nformat ascii 1.0\n")],
    );
    assert!(
        said.contains("x.ply: the header of the PLY file has no \"end_header\""),
        "{said}"
    );
}
