//! What `curvetri` says when something is wrong: each error its own, naming the place.

use crate::program::{Workshop, stderr, stdout};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// What `render` says of a mesh file that it cannot work with.
fn refusal(shop: &Workshop, mesh: &str) -> String {
    shop.fails(
        1,
        &["render", mesh, "-o", &shop.path("out.png"), "--size", "8x8"],
    )
}

#[test]
fn a_missing_file_is_named() {
    let shop = Workshop::new();
    let said = refusal(&shop, &shop.path("nowhere.obj"));
    assert!(
        said.contains("nowhere.obj") && said.contains("No such file"),
        "{said}"
    );
    assert!(
        shop.names().is_empty(),
        "nothing is left behind: {:?}",
        shop.names()
    );
}

#[test]
fn an_empty_mesh_is_named() {
    let shop = Workshop::new();
    let said = refusal(&shop, &shop.write("empty.obj", "v 0 0 0\n"));
    assert!(
        said.contains("empty.obj") && said.contains("1 point, no faces"),
        "{said}"
    );
}

#[test]
fn lenient_skips_and_counts_what_is_refused_without() {
    let shop = Workshop::new();
    let wrong = shop.write("wrong.obj", format!("{TRIANGLE}f 1 2 9\nf 1//7 2 3\n"));
    let said = shop.fails(1, &["inspect", &wrong]);
    assert!(
        said.contains("wrong.obj:5") && said.contains("--lenient skips the face"),
        "{said}"
    );
    let json = stdout(&shop.succeeds(&["inspect", &wrong, "--lenient", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["warnings"].as_array().unwrap().len(), 1, "{json}");
    let output = shop.succeeds(&["inspect", &wrong, "--lenient"]);
    let (told, said) = (stdout(&output), stderr(&output));
    assert!(told.contains("2 skipped faults"), "{told}");
    assert!(
        said.contains("2 wrong elements were skipped; the first: line 5"),
        "{said}"
    );
}

#[test]
fn a_number_that_is_none_is_named_with_its_line() {
    let shop = Workshop::new();
    let said = refusal(
        &shop,
        &shop.write("nan.obj", TRIANGLE.replace("v 1 0 0", "v 1 nan 0")),
    );
    assert!(said.contains("nan.obj:2"), "{said}");
}

#[test]
fn an_index_out_of_range_is_named_with_its_line() {
    let shop = Workshop::new();
    let said = refusal(
        &shop,
        &shop.write("far.obj", TRIANGLE.replace("f 1 2 3", "f 1 2 4")),
    );
    assert!(said.contains("far.obj:4"), "{said}");
}

#[test]
fn an_output_that_cannot_be_written_is_named_before_the_work() {
    let shop = Workshop::new();
    let mesh = shop.write("m.obj", TRIANGLE);
    let png = shop.path("no/such/place.png");
    let said = shop.fails(1, &["render", &mesh, "-o", &png]);
    assert!(
        said.contains("cannot write") && said.contains("no/such/place.png"),
        "{said}"
    );
    // A file where a directory should be.
    let png = shop.path("m.obj/out.png");
    let said = shop.fails(1, &["render", &mesh, "-o", &png]);
    assert!(
        said.contains("cannot write") && said.contains("m.obj/out.png"),
        "{said}"
    );
    std::fs::create_dir(shop.path("dir.png")).unwrap();
    let said = shop.fails(1, &["render", &mesh, "-o", &shop.path("dir.png")]);
    assert!(
        said.contains("cannot write") && said.contains("directory"),
        "{said}"
    );
}

#[test]
fn a_failed_run_leaves_the_old_picture() {
    let shop = Workshop::new();
    let png = shop.write("old.png", "precious");
    shop.fails(1, &["render", &shop.path("nowhere.obj"), "-o", &png]);
    assert_eq!(std::fs::read(png).unwrap(), b"precious");
    assert_eq!(shop.names(), ["old.png"]);
}

#[test]
fn nonsense_is_a_usage_error() {
    let shop = Workshop::new();
    let mesh = shop.write("m.obj", TRIANGLE);
    let png = shop.path("out.png");
    for nonsense in [
        &["--samples", "0"][..],
        &["--samples", "-3"],
        &["--samples", "99999999"],
        &["--size", "0x10"],
        &["--size", "10"],
        &["--size", "1000000x2"],
        &["--size", "65535x65535"],
        &["--width", "0"],
        &["--width", "10", "--size", "5x5"],
        &["--fov", "nan"],
        &["--fov", "180"],
        &["--eye", "1,2"],
        &["--eye", "1,2,nan"],
        &["--eye", "1,2,3", "--target", "1,2,3"],
        &["--up", "0,0,0"],
        &["--sun-direction", "0,0,0"],
        &["--surface", "bumpy"],
        &["--surface", "flat", "--ita-bits", "9"],
        &["--surface", "flat", "--method", "paper"],
        &["--surface", "flat", "--bounds", "tight"],
        &["--surface", "flat", "--solver", "finish"],
        &["--surface", "flat", "--tolerance", "0.1"],
        &["--tolerance", "-1"],
        &["--tolerance", "0.1cm"],
        &["--tolerance", "NaNpx"],
        &["--solver", "finish", "--ita-step", "2"],
        &["--method", "best"],
        &["--ita-bits", "0"],
        &["--ita-step", "40"],
        &["--crease-angle", "NaN"],
        &["--crease-angle", "-1"],
        &["--threads", "0"],
        &["--exposure", "inf"],
        &["--albedo", "2"],
        &["--no-such-option"],
        &["-q", "-v"],
    ] {
        let args = [&["render", &mesh, "-o", &png][..], nonsense].concat();
        let said = shop.fails(2, &args);
        assert!(said.contains("--help"), "{said}");
    }
    for args in [
        &["render", &mesh][..],
        &["render", "-o", &png],
        &["render", &mesh, "-o", &shop.path("out.jpg")],
        &["trace", &mesh],
        &["paint"],
        &["-v"],
    ] {
        shop.fails(2, args);
    }
    assert_eq!(shop.names(), ["m.obj"]);
}

#[test]
fn contradicting_parts_of_the_method_are_told_with_what_to_do() {
    let shop = Workshop::new();
    let mesh = shop.write("m.obj", TRIANGLE);
    let said = |args: &[&str]| shop.fails(2, &[&["inspect", &mesh], args].concat());
    let flat = said(&["--surface", "flat", "--method", "paper"]);
    assert!(
        flat.contains("--method paper is for curved surfaces"),
        "{flat}"
    );
    assert!(flat.contains("leave it out, or --surface flat"), "{flat}");
    let digits = said(&["--method", "paper", "--solver", "finish", "--ita-bits", "9"]);
    assert!(
        digits.contains("are for --solver ita; leave them out"),
        "{digits}"
    );
}

#[test]
fn the_version_names_embree_and_its_instruction_set() {
    let shop = Workshop::new();
    for option in ["--version", "-V"] {
        let text = stdout(&shop.succeeds(&[option]));
        assert!(
            text.starts_with(concat!("curvetri ", env!("CARGO_PKG_VERSION"), "\n")),
            "{text}"
        );
        let device = curvetri::linked::device().unwrap();
        let embree = format!("Embree {} ({})\n", device.version(), device.isa());
        assert!(text.ends_with(&embree), "{text}");
    }
}

#[test]
fn help_is_a_result_and_its_absence_a_usage_error() {
    let shop = Workshop::new();
    for args in [&["--help"][..], &["render", "--help"], &["trace", "-h"]] {
        assert!(stdout(&shop.succeeds(args)).contains("Usage: curvetri"));
    }
    let output = shop.run(&[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("Usage: curvetri"));
}

#[test]
fn options_of_other_integrators_materials_and_formats_are_refused() {
    let shop = Workshop::new();
    let mesh = shop.write("m.obj", TRIANGLE);
    let (png, exr) = (shop.path("a.png"), shop.path("a.exr"));
    for (output, options, reason) in [
        (&png, "--depth 3", "--depth is for --integrator path"),
        (
            &png,
            "--integrator path --ao-distance 1",
            "--ao-distance is for",
        ),
        (
            &png,
            "--integrator ao --sky-shadows",
            "--sky-shadows is for",
        ),
        (&png, "--material glass", "needs --integrator path"),
        (
            &png,
            "--integrator path --ior 1.4",
            "--ior is for --material glass",
        ),
        (
            &png,
            "--size 9x9 --crop 5,0,5x1",
            "not within the picture of 9x9",
        ),
        (&exr, "--exposure 1", "--exposure is for .png"),
    ] {
        let options = options.split(' ').collect::<Vec<_>>();
        let said = shop.fails(
            2,
            &[&["render", &mesh, "-o", output], &options[..]].concat(),
        );
        assert!(said.contains(reason), "{options:?}: {said}");
    }
    let said = shop.fails(2, &["render", &mesh, "-o", &shop.path("a.jpg")]);
    assert!(said.contains("neither in .png nor in .exr"), "{said}");
    assert_eq!(shop.names(), ["m.obj"]);
}
