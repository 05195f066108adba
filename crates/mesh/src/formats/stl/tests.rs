use proptest::prelude::*;

use super::*;
use crate::formats::{check, damaged};

const FACET: &str = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  \
                     vertex 0 1.0000000001 0\n endloop\nendfacet\n";

fn record(normal: [f32; 3], corners: [[f32; 3]; 3]) -> Vec<u8> {
    let numbers = [&normal[..], corners.as_flattened()].concat();
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([7, 7]);
    bytes
}

fn binary(promised: u32, records: &[Vec<u8>]) -> Vec<u8> {
    let head = [&[b'x'; 80][..], &promised.to_le_bytes()].concat();
    [head, records.concat()].concat()
}

const CORNERS: [[f32; 3]; 3] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];

fn strict_text(text: &str) -> Result<Parsed, Fault> {
    read_text(text, Skipped::new(false))
}

fn strict_binary(bytes: &[u8]) -> Result<Parsed, Fault> {
    read_binary(bytes, Skipped::new(false))
}

fn line_fault(text: &str) -> (usize, String) {
    match read_text(text, Skipped::new(false)) {
        Err(Fault::Line(line, what)) => {
            let hint = "; --lenient skips the facet";
            let what = what.strip_suffix(hint).expect("what lenient skips is told");
            (line, what.to_owned())
        }
        other => panic!("{:?}", other.map(|p| p.model)),
    }
}

#[test]
fn text_keeps_all_digits_and_all_solids() {
    let text = format!(
        "solid a b\n{FACET}endsolid a b\nSOLID\n{}ENDSOLID\n",
        FACET.to_uppercase()
    );
    let parsed = strict_text(&text).unwrap();
    assert_eq!(parsed.model.parts[0].corners, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(parsed.model.parts[0].positions[5].y, 1.0000000001);
    assert_eq!(parsed.report.warnings, [] as [String; 0]);
}

#[test]
fn text_that_ends_early_is_refused_or_warned_of() {
    let warned = strict_text(&format!("solid\n{FACET}")).unwrap();
    assert_eq!(
        warned.report.warnings,
        ["the file ends without \"endsolid\"; it may be cut off"]
    );
    let cut = &FACET[..FACET.len() - 9];
    assert_eq!(
        line_fault(&format!("solid\n{cut}")),
        (7, "the file ends in a facet".into())
    );
}

#[test]
fn text_errors_name_their_line() {
    let with =
        |from: &str, to: &str| line_fault(&format!("solid\n{}", FACET.replacen(from, to, 1)));
    assert_eq!(
        with("vertex 1 0 0", "vertex 1 0"),
        (5, "there are 2 coordinates instead of 3".into())
    );
    assert_eq!(with("1 0 0", "1 O 0"), (5, "\"O\" is not a number".into()));
    assert_eq!(with("vertex 1 0 0\n", "\n").0, 8);
    assert_eq!(with(" endloop", " vertex 1 2 3").0, 7);
    assert_eq!(
        with("endfacet", "facet"),
        (8, "\"facet\" does not belong here".into())
    );
    assert_eq!(with("normal", "ordinary").0, 2);
    assert_eq!(
        with("facet", "f"),
        (2, "\"f\" is no keyword of an STL file".into())
    );
}

#[test]
fn binary_facets_become_triangles_and_normals_against_the_winding_are_told() {
    let records = [[0., 0., 1.], [0., 0., 0.], [0., 0., -1.], [f32::NAN; 3]];
    let records = records.map(|n| record(n, CORNERS));
    let parsed = strict_binary(&binary(4, &records)).unwrap();
    assert_eq!(parsed.model.parts[0].corners.len(), 4);
    assert_eq!(parsed.model.parts[0].positions[11], DVec3::Y);
    assert_eq!(
        parsed.report.warnings,
        ["1 facets have a normal that points against their winding; the winding counts"]
    );
}

#[test]
fn a_binary_file_that_is_cut_off_or_not_finite_is_refused_by_facet() {
    let what = |bytes: &[u8]| match strict_binary(bytes) {
        Err(Fault::Content(what)) => what,
        other => panic!("{:?}", other.map(|p| p.model)),
    };
    let one = record([0.; 3], CORNERS);
    assert_eq!(
        what(&binary(7, std::slice::from_ref(&one))),
        "the file ends in facet 2, but its header promises 7 facets; --lenient skips the facets that are \
             missing"
    );
    assert_eq!(what(&[0; 83]), "the file is too short for a binary STL");
    let mut infinite = CORNERS;
    infinite[1][2] = f32::INFINITY;
    assert_eq!(
        what(&binary(2, &[one, record([0.; 3], infinite)])),
        "facet 2: vertex 2 is not finite: 1 0 inf; --lenient skips the facet"
    );
}

#[test]
fn bytes_behind_the_last_facet_are_told() {
    let bytes = binary(1, &[record([0.; 3], CORNERS), vec![0; 9]]);
    assert_eq!(
        strict_binary(&bytes).unwrap().report.warnings,
        ["9 bytes after the last facet were not read"]
    );
}

#[test]
fn white_space_of_any_kind_separates_keywords_and_numbers() {
    let expected = strict_text(&format!("solid a\n{FACET}{FACET}endsolid a\n")).unwrap();
    let facets = format!("{FACET}{FACET}");
    let one_line = facets
        .split_ascii_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    let one_word = facets
        .split_ascii_whitespace()
        .collect::<Vec<_>>()
        .join("\r");
    let texts = [
        format!("solid a {one_line} endsolid a"),
        format!("solid\n{one_word}\rendsolid\r"),
        format!("solid my facet part\n{facets}endsolid my facet part\n"),
        format!("{facets}endsolid\n\x1a\n"),
        format!("solid a\nendsolid a solid b {one_line} endsolid"),
        format!(
            "solid a\n{}end solid a\n",
            facets
                .replace("endfacet", "end facet")
                .replace("endloop", "END loop")
        ),
        format!(
            "solid a\ncolor 0.5 0.5 1\n{}endsolid\n",
            facets.replace(" endloop", " color 1 0 0\n endloop")
        ),
        format!("solid a\0\0\0\n{facets}endsolid a\n\0\0\0\0"),
        format!("solid a\n{FACET}endsolid\n\x1asolid b\n{FACET}endsolid b\n\x1a"),
        format!(
            "solid a\n{}endsolid a\n",
            facets.replace("vertex 1 0 0", "vertex 1 0 0 0.5 0.5")
        ),
    ];
    for text in texts {
        let parsed = strict_text(&text).unwrap_or_else(|fault| panic!("{text}: {}", fault.text()));
        assert_eq!(
            parsed.model.parts[0].positions, expected.model.parts[0].positions,
            "{text}"
        );
        assert_eq!(parsed.report.warnings, [] as [String; 0], "{text}");
    }
}

/// A facet with bytes behind it.
fn with_attributes(corners: [[f32; 3]; 3], attributes: &[u8]) -> Vec<u8> {
    let mut bytes = record([0., 0., 1.], corners);
    bytes.truncate(48);
    bytes.extend((attributes.len() as u16).to_le_bytes());
    bytes.extend(attributes);
    bytes
}

const OTHERS: [[f32; 3]; 3] = [[1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

fn loaded(bytes: Vec<u8>, name: &str) -> crate::Loaded {
    crate::Loader::new().load_bytes(bytes, name).unwrap()
}

#[test]
fn bytes_behind_each_facet_are_left_out_where_the_length_agrees() {
    let records = [
        with_attributes(CORNERS, b"abcd"),
        with_attributes(OTHERS, b"efghijk"),
    ];
    // Known by its length, whatever the name.
    for name in ["x.stl", "x.obj"] {
        let loaded = loaded(binary(2, &records), name);
        assert_eq!(
            loaded.mesh.triangle_positions(1)[0].to_array(),
            [1., 0., 0.]
        );
        assert_eq!(loaded.mesh.bounds().max, DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(loaded.report.warnings, [] as [String; 0]);
    }
    // Most programs put colours there, which are no count.
    let coloured = [CORNERS, OTHERS].map(|c| record([0., 0., 1.], c));
    assert_eq!(
        loaded(binary(2, &coloured), "x.stl").mesh.triangles().len(),
        2
    );
    let cut = [records.concat(), vec![0; 9]].concat();
    let loaded = loaded(binary(1, &[cut]), "x.stl");
    assert_eq!(loaded.mesh.triangles().len(), 1);
    assert_eq!(loaded.report.warnings.len(), 1);
}

#[test]
fn a_number_of_facets_that_says_nothing_is_taken_from_the_length() {
    let plain = [CORNERS, OTHERS].map(|c| with_attributes(c, b""));
    let padded = [CORNERS, OTHERS].map(|c| with_attributes(c, b"xyz"));
    for promised in [0, u32::MAX] {
        for (records, name) in [(&plain, "x.stl"), (&plain, "x"), (&padded, "x")] {
            let loaded = loaded(binary(promised, records), name);
            assert_eq!(loaded.mesh.bounds().max, DVec3::new(1.0, 1.0, 0.0));
            assert_eq!(
                loaded.report.warnings,
                [format!(
                    "the header says {promised} facets, which is wrong; 2 were read, as the file's \
                     length says"
                )]
            );
        }
    }
    let empty = crate::Loader::new()
        .load_bytes(binary(0, &[]), "x.stl")
        .unwrap_err();
    assert!(
        crate::error::chain(&empty).contains("it has no triangles"),
        "{empty}"
    );
}

#[test]
fn lenient_reading_skips_facets_that_are_wrong() {
    let lenient = crate::Loader::new().lenient(true);
    let mut infinite = CORNERS;
    infinite[1][2] = f32::INFINITY;
    let records = [record([0.; 3], CORNERS), record([0.; 3], infinite)];
    let report = lenient
        .load_bytes(binary(3, &records), "x.stl")
        .unwrap()
        .report;
    assert_eq!((report.polygons, report.skipped_faults), (1, 2));
    let wrong = [
        FACET.replace("1 0 0", "1 O 0"),
        FACET.replace("1 0 0", "1 0"),
        FACET.replace("vertex 1 0 0", ""),
        FACET.replace("normal", "ordinary"),
        FACET.replace("vertex 1 0 0", "vertex inf 0 0"),
        FACET.replace(" endloop", " vertex 1 2 3"),
    ];
    for facet in wrong {
        let text = format!("solid\n{facet}{FACET}endsolid\n");
        let report = lenient
            .load_bytes(text.clone().into(), "x.stl")
            .unwrap()
            .report;
        assert_eq!((report.polygons, report.skipped_faults), (1, 1), "{text}");
    }
}

proptest! {
    #[test]
    fn damaged_files_are_refused_or_read(
        file in damaged(vec![
            format!("solid a\n{FACET}{FACET}endsolid\n").into(),
            binary(3, &vec![record([0., 0., 1.], CORNERS); 3]),
        ]),
    ) {
        check(file)?;
    }
}
