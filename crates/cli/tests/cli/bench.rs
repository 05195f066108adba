//! `curvetri bench` as a whole program, on meshes too small to tell anything.

use crate::program::{Workshop, stdout};
use serde_json::Value;

const FEW: [&str; 7] = [
    "bench",
    "--rays=4096",
    "--rounds=2",
    "--forms=smooth,smooth-leaf4,smooth-ita3,tessellated-x16,tessellated-equal,grids-x16,subdivision-4",
    "--kinds=primary,diffuse,shadow",
    "--threads=1",
    "--cpu-time",
];

#[test]
fn json_has_every_field() {
    let shop = Workshop::new();
    let ball = shop.sphere("ball.obj");
    let page = shop.path("bench.md");
    let args = ["--json", "--triangles=800", "--markdown", &page, &ball];
    let output = shop.succeeds(&[&FEW[..], &args].concat());
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let machine = &report["machine"];
    for key in ["processor", "system", "embree", "isa", "curvetri"] {
        assert!(
            machine[key].as_str().is_some_and(|text| !text.is_empty()),
            "{key}"
        );
    }
    let meshes = report["meshes"].as_array().unwrap();
    assert_eq!(meshes.len(), 2);
    assert_eq!(meshes[0]["name"], "bumpy-torus-800");
    assert_eq!(meshes[1]["name"], "ball");
    for mesh in meshes {
        let forms = mesh["forms"].as_array().unwrap();
        assert_eq!(forms.len(), 8);
        for form in forms {
            if mesh["name"] == "ball" && form["name"] == "tessellated-equal" {
                assert_eq!(form["skipped"], "the true surface is not known");
            } else {
                check_form(form);
            }
        }
    }
    let goals = report["goals"].as_array().unwrap();
    let met = goals.iter().filter(|goal| goal["met"].is_boolean()).count();
    assert!(met >= 8, "{goals:?}");
    for goal in goals {
        assert!(goal["least"].is_f64() && goal["aim"].is_f64() && goal["goal"].is_string());
    }
    let page = std::fs::read_to_string(page).unwrap();
    assert!(
        page.contains("## Goals") && page.contains("## Machine"),
        "{page}"
    );
}

fn check_form(form: &Value) {
    let positive = |value: &Value| value.as_f64().is_some_and(|number| number > 0.0);
    assert!(
        positive(&form["bytes"]["total"]) && positive(&form["seconds"]["build"]),
        "{form}"
    );
    let rows = form["rows"].as_array().unwrap();
    for kind in ["primary", "diffuse", "shadow"] {
        assert!(rows.iter().any(|row| row["kind"] == kind), "{kind}: {form}");
    }
    for row in rows {
        assert!(positive(&row["mray_per_second"]["median"]), "{row}");
        assert!(positive(&row["ratio_to_flat"]["median"]), "{row}");
        for key in [
            "calls_per_ray",
            "evaluations_per_ray",
            "lanes_used",
            "hit_share",
        ] {
            assert!(row[key].is_f64(), "{key}: {row}");
        }
        // flat triangles of a coarse ball are much smaller than it
        if row["kind"] == "primary" && form["name"] == "smooth" {
            assert!(row["hit_share"].as_f64().unwrap() >= 0.6, "{row}");
        }
    }
}

#[test]
fn tables_are_printed() {
    let shop = Workshop::new();
    let text = stdout(&shop.succeeds(&[&FEW[..], &["--triangles=800"]].concat()));
    for part in [
        "Machine",
        "Mray/s on 1 thread",
        "the curved kernel",
        "Goals",
        "B/triangle",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn all_are_asked_in_the_ways_that_are_wanted() {
    let shop = Workshop::new();
    let how = ["--triangles=800", "--ways=8c", "--json"];
    let report = stdout(&shop.succeeds(&[&FEW[..], &how].concat()));
    let report: Value = serde_json::from_str(&report).unwrap();
    let forms = report["meshes"][0]["forms"].as_array().unwrap();
    let rows = || {
        forms
            .iter()
            .flat_map(|form| form["rows"].as_array().unwrap())
    };
    assert!(forms.len() > 3 && rows().count() > 3);
    let other = rows().find(|row| row["width"] != 8 || row["coherent"] != true);
    assert!(other.is_none(), "{other:?}");
}

#[test]
fn names_that_are_none_are_refused_with_those_that_are() {
    let shop = Workshop::new();
    let text = shop.fails(2, &["bench", "--forms", "smoth"]);
    assert!(
        text.contains("smoth") && text.contains("tessellated-x16"),
        "{text}"
    );
    let text = shop.fails(2, &["bench", "--kinds", "primary,red"]);
    assert!(text.contains("ambient-occlusion"), "{text}");
    let text = shop.fails(2, &["bench", "--ways", "32"]);
    assert!(text.contains("16c"), "{text}");
    let text = shop.fails(1, &["bench", "absent.obj"]);
    assert!(text.contains("absent.obj"), "{text}");
}
