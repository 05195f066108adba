//! `curvetri accuracy` as a whole program.

use crate::program::{Workshop, stdout};
use serde_json::Value;

const BODIES: [(&str, u64); 9] = [
    ("sphere-tetrahedron", 4),
    ("sphere-cube", 12),
    ("cylinder", 16),
    ("cone", 8),
    ("torus", 96),
    ("torus-12x16", 384),
    ("torus-24x32", 1536),
    ("torus-48x64", 6144),
    ("torus-96x128", 24576),
];
const OURS: [&str; 5] = ["flat", "paper", "angular", "tensor", "smooth"];

fn json(args: &[&str]) -> Value {
    let shop = Workshop::new();
    let args = [&["accuracy", "--json", "--samples", "400"], args].concat();
    serde_json::from_str(&stdout(&shop.succeeds(&args))).unwrap()
}

/// `loses`: whether the paper's rays are looked at triangle by triangle, so that those into a folded
/// triangle's holes are lost; through the whole body they go on to what is behind.
fn check_rows(report: &Value, surfaces: &[&str], loses: bool) {
    let mut rows = report["rows"].as_array().unwrap().iter();
    for (body, triangles) in BODIES {
        for &surface in surfaces {
            let row = rows.next().unwrap();
            assert_eq!(row["body"], body);
            assert_eq!(row["triangles"], triangles);
            assert_eq!(row["surface"], surface);
            let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key}: {row}"));
            assert!(number("max") >= number("mean") && number("mean") > 0.0);
            assert!(number("normal_deg") > 0.0);
            if body == "cone" {
                assert!(row["jump_deg"].is_null());
            } else {
                assert!(number("jump_deg") > 0.0);
            }
            let points = number("points") + number("missed");
            let folds = loses && surface == "paper" && row["flat_by_default"] != 0;
            assert!(
                number("missed") <= if folds { 0.05 * points } else { 0.0 },
                "{row}"
            );
        }
    }
    assert!(rows.next().is_none());
}

#[test]
fn json_has_a_row_for_every_body_and_surface() {
    let report = json(&[]);
    check_rows(&report, &OURS, true);
    assert!(report.get("needed").is_none());
}

#[test]
fn traced_json_has_the_same_rows() {
    check_rows(&json(&["--traced"]), &OURS, false);
}

#[test]
fn peers_come_with_their_orders_and_triangle_counts() {
    let report = json(&["--peers"]);
    let surfaces = [&OURS[..], &["pn", "phong", "nagata"]].concat();
    check_rows(&report, &surfaces, true);
    let convergence = report["convergence"].as_array().unwrap();
    assert_eq!(convergence.len(), 4 * surfaces.len());
    let last = |surface: &str| {
        let mut rows = convergence.iter().rev();
        let row = rows.find(|row| row["surface"] == surface).unwrap();
        assert_eq!(
            (&row["from"], &row["to"]),
            (&"torus-48x64".into(), &"torus-96x128".into())
        );
        row["mean"].as_f64().unwrap()
    };
    assert!((last("flat") - 2.0).abs() < 0.1 && last("smooth") > 3.0);
    let needed = report["needed"].as_array().unwrap();
    assert_eq!(needed.len(), 4 * surfaces.len());
    for row in needed {
        let pieces = |n: usize| row["pieces"][n].as_u64().unwrap();
        assert_eq!(row["triangles"], 2 * pieces(0) * pieces(1));
        assert_eq!(pieces(0) * 4, pieces(1) * 3);
    }
}

#[test]
fn the_table_for_people_names_everything() {
    let shop = Workshop::new();
    let text = stdout(&shop.succeeds(&["accuracy", "--samples", "400"]));
    for (body, _) in BODIES {
        assert!(text.contains(body), "{text}");
    }
    assert!(text.contains("48 flat by default"), "{text}");
    assert!(text.matches("points missed").count() <= 1, "{text}");
}

#[test]
fn odd_arguments_are_refused() {
    let shop = Workshop::new();
    for args in [
        &["accuracy", "--samples", "0"][..],
        &["accuracy", "--samples", "many"],
        &["accuracy", "--traced", "--peers"],
        &["accuracy", "mesh.obj"],
    ] {
        let output = shop.run(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
    }
}
