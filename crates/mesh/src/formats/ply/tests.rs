use proptest::prelude::*;

use super::*;
use crate::formats::{check, damaged};

const HEADER: &str = "element vertex 4\nproperty uchar red\nproperty float z\nproperty double y\n\
                      property list uchar float weights\nproperty short x\nelement face 2\n\
                      property list uchar int vertex_indices\nproperty char flags\nend_header\n";

fn file(format: &str, body: &[u8]) -> Vec<u8> {
    [
        format!("ply\nformat {format} 1.0\n{HEADER}").as_bytes(),
        body,
    ]
    .concat()
}

fn ascii() -> Vec<u8> {
    let vertices = "255 0 0 0 0\n0 .0 0. 2 .5 .5 1\n\n1 0 1e0 0 1\n1 -0 1 1 7 0\n";
    file(
        "ascii",
        format!("{vertices}4 0 1 2 3 -7\n3 2 1 0 0\n").as_bytes(),
    )
}

/// The same with numbers from the most or the least significant byte on.
fn binary(big: bool) -> Vec<u8> {
    let bytes = |le: &[u8]| {
        let mut le = le.to_vec();
        if big {
            le.reverse();
        }
        le
    };
    let mut body = Vec::new();
    for (x, y, weights) in [(0i16, 0., 0), (1, 0., 2), (1, 1., 0), (0, 1., 1)] {
        body.push(200);
        body.extend(bytes(&0f32.to_le_bytes()));
        body.extend(bytes(&f64::to_le_bytes(y)));
        body.push(weights);
        body.extend(vec![9; 4 * usize::from(weights)]);
        body.extend(bytes(&x.to_le_bytes()));
    }
    for face in [&[0i32, 1, 2, 3][..], &[2, 1, 0]] {
        body.push(face.len() as u8);
        body.extend(face.iter().flat_map(|i| bytes(&i.to_le_bytes())));
        body.push(255);
    }
    let format = if big {
        "binary_big_endian"
    } else {
        "binary_little_endian"
    };
    file(format, &body)
}

fn strict(bytes: Vec<u8>) -> Result<Parsed, Fault> {
    read(bytes, Skipped::new(false))
}

fn line_fault(bytes: Vec<u8>) -> (usize, String) {
    match strict(bytes) {
        Err(Fault::Line(line, what)) => (line, what),
        other => panic!("{:?}", other.map(|p| p.model)),
    }
}

fn content_fault(bytes: Vec<u8>) -> String {
    match strict(bytes) {
        Err(Fault::Content(what)) => what,
        other => panic!("{:?}", other.map(|p| p.model)),
    }
}

fn replaced(from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(ascii()).unwrap();
    assert!(text.contains(from));
    text.replacen(from, to, 1).into_bytes()
}

#[test]
fn all_encodings_and_orders_say_the_same() {
    for bytes in [ascii(), binary(false), binary(true)] {
        let parsed = strict(bytes).unwrap();
        let square = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(DVec3::from);
        assert_eq!(parsed.model.parts[0].positions[..3], square[..3]);
        assert_eq!(
            parsed.model.parts[0].corners,
            [[0, 1, 2], [0, 2, 3], [2, 1, 0]]
        );
        assert_eq!(parsed.model.parts[0].normal_corners, None);
        assert_eq!(parsed.report.polygons, 2);
    }
}

#[test]
fn headers_may_have_any_line_ends_blank_lines_and_latin1() {
    let text = String::from_utf8(ascii()).unwrap();
    let dressed = text.replacen("1.0\n", "1.0 \n\n  comment caf\u{e9}\n", 1);
    for ends in ["\n", "\r\n", "\r"] {
        let bytes = dressed
            .replace('\n', ends)
            .chars()
            .map(|c| c as u8)
            .collect();
        assert_eq!(
            strict(bytes)
                .unwrap()
                .model
                .flatten()
                .unwrap()
                .corners
                .len(),
            3,
            "{ends:?}"
        );
    }
}

#[test]
fn normals_need_all_three_coordinates() {
    let with = |properties: &str| {
        let bytes = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\n{properties}element face 1\n\
             property list uchar uint vertex_index\nend_header\n\
             0 0 0 0 0 1\n1 0 0 0 0 2\n0 1 0 nan 0 1\n3 0 1 2\n"
        );
        strict(bytes.into_bytes()).unwrap().model.flatten().unwrap()
    };
    let raw = with("property float nx\nproperty float ny\nproperty float nz\n");
    assert_eq!(raw.normals[1], DVec3::new(0.0, 0.0, 2.0));
    assert!(raw.normals[2].x.is_nan());
    assert_eq!(raw.normal_corners, Some(vec![[0, 1, 2]]));
    let raw = with("property float nx\nproperty float ny\nproperty float q\n");
    assert_eq!((raw.normals.len(), raw.normal_corners), (0, None));
}

#[test]
fn strips_are_cut_into_triangles_that_wind_one_way() {
    let bytes = b"ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
        property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 3 4\n";
    let raw = strict(bytes.to_vec()).unwrap().model.flatten().unwrap();
    assert_eq!(raw.corners, [[0, 1, 2], [2, 1, 3]]);
}

#[test]
fn errors_in_text_name_line_and_element() {
    assert_eq!(
        line_fault(replaced("1e0", "x")),
        (16, "vertex 2: \"x\" is not a number".into())
    );
    let names = "face 0: it names vertex 4, but there are only 4 (0 is the first); --lenient skips the \
                 face";
    assert_eq!(
        line_fault(replaced("0 1 2 3", "0 1 2 4")),
        (18, names.into())
    );
    let names = names.replace("vertex 4", "vertex -1");
    assert_eq!(line_fault(replaced("0 1 2 3", "0 1 2 -1")), (18, names));
    let fewer = "face 0: its line has fewer values than the header declares";
    assert_eq!(line_fault(replaced("3 -7", "3")), (18, fewer.into()));
    let more = "face 1: its line has more values than the header declares";
    assert_eq!(
        line_fault(replaced("2 1 0 0", "2 1 0 0 0")),
        (19, more.into())
    );
    let length = "face 0: -3 is no length of a list";
    assert_eq!(line_fault(replaced("4 0 1", "-3 0 1")), (18, length.into()));
    let ends = "face 1: the file ends before it";
    assert_eq!(
        line_fault(replaced("3 2 1 0 0\n", "            \n")),
        (19, ends.into())
    );
}

#[test]
fn any_white_space_separates_the_numbers_of_a_text() {
    let expected = strict(ascii()).unwrap().model.flatten().unwrap();
    let text = String::from_utf8(ascii()).unwrap();
    let (header, body) = text.split_at(text.find("end_header\n").unwrap() + 11);
    let words: Vec<&str> = body.split_ascii_whitespace().collect();
    for (number, separators) in [[" ", " "], ["\n", "\r\n"], [" \r", "\t"]]
        .into_iter()
        .enumerate()
    {
        let body: String = (words.iter().zip(separators.iter().cycle()))
            .map(|(word, separator)| format!("{word}{separator}"))
            .collect();
        let raw = strict(format!("{header}{body}").into())
            .unwrap()
            .model
            .flatten()
            .unwrap();
        assert_eq!(raw, expected, "{number}");
    }
    // As scanners' programs write it: position, normal and colour on lines of their own.
    let bytes = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
        property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 \n0 0 1 \n200\n1 0 0 \n0 0 1 \n10\n0 1 0 \n0 0 1 \n10 \n3 0 1 2\n";
    let raw = strict(bytes.to_vec()).unwrap().model.flatten().unwrap();
    assert_eq!((raw.positions[2], raw.normals[1]), (DVec3::Y, DVec3::Z));
    assert_eq!(raw.corners, [[0, 1, 2]]);
}

#[test]
fn what_follows_the_last_element_is_told_or_shows_that_lines_are_too_long() {
    let more = [ascii(), b"1 2 3\n".to_vec()].concat();
    assert_eq!(
        strict(more).unwrap().report.warnings,
        ["the file goes on behind its last element, in line 20; that was not read"]
    );
    // A vertex's line with a value too many, and a face that runs over two lines.
    let wrong = replaced("0 .0 0. 2", "0 0 .0 0. 2");
    let wrong = String::from_utf8(wrong)
        .unwrap()
        .replace("2 1 0 0", "2\n1 0 0");
    let (_, what) = line_fault(wrong.into());
    assert!(
        what.contains("has more values than the header declares"),
        "{what}"
    );
}

#[test]
fn the_body_starts_behind_the_end_of_the_headers_last_line() {
    // The first byte of the first vertex is a line feed: -10 in a signed byte's complement.
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\n\
                  property char y\nproperty char z\nelement face 1\n\
                  property list uchar uchar vertex_indices\nend_header\n";
    let body = [10, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2];
    for ends in ["\n", "\r\n", "\r"] {
        let bytes = [header.replace('\n', ends).as_bytes(), &body].concat();
        let raw = strict(bytes).unwrap().model.flatten().unwrap();
        assert_eq!(raw.positions[0], 10.0 * DVec3::X, "{ends:?}");
    }
    // Lines that end in one and the other.
    let mixed = header
        .replacen('\n', "\r", 3)
        .replace("end_header\n", "end_header\r\n");
    let raw = strict([mixed.as_bytes(), &body].concat())
        .unwrap()
        .model
        .flatten()
        .unwrap();
    assert_eq!(raw.positions[0], 10.0 * DVec3::X);
    let capitals = header.replacen("ply\n", "\n\n PLY \n", 1);
    assert!(strict([capitals.as_bytes(), &body].concat()).is_ok());
    let all = header.to_ascii_uppercase();
    assert!(strict([all.as_bytes(), &body].concat()).is_ok());
    let wrong = capitals.replace("element face", "elements face");
    assert_eq!(line_fault([wrong.as_bytes(), &body].concat()).0, 9);
}

#[test]
fn invalid_points_that_no_face_names_do_not_matter() {
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                  end_header\n";
    let body = "nan nan nan\n0 0 0\n1 0 0\n0 1 0\n3 1 2 3\n";
    let loaded = crate::Loader::new().load_bytes(format!("{header}{body}").into(), "x.ply");
    let loaded = loaded.unwrap();
    assert_eq!(loaded.mesh.positions().len(), 3);
    assert_eq!(loaded.report.unused_vertices, 1);
    let used = body.replace("3 1 2 3", "3 0 2 3");
    let error = strict(format!("{header}{used}").into()).err().unwrap();
    assert_eq!(
        error.text(),
        "vertex 0 is not finite: NaN NaN NaN; --lenient skips the faces that have it"
    );
}

#[test]
fn wrong_faces_are_skipped_where_that_is_asked_for() {
    for bytes in [ascii(), binary(false), binary(true)] {
        // The header is the same, and so is the place of its second face's first index.
        let text_face = bytes.windows(9).position(|w| w == b"3 2 1 0 0");
        let mut wrong = bytes.clone();
        match text_face {
            Some(at) => wrong[at + 2] = b'9',
            None => {
                let at = wrong.len() - 13;
                wrong[at..at + 4].fill(9);
            }
        }
        let fault = strict(wrong.clone()).err().unwrap().text();
        assert!(fault.ends_with("; --lenient skips the face"), "{fault}");
        let parsed = read(wrong, Skipped::new(true)).unwrap();
        assert_eq!(
            (parsed.report.polygons, parsed.report.skipped_faults),
            (1, 1)
        );
    }
}

#[test]
fn headers_that_are_wrong_are_refused() {
    let what = "\"element vertex many\" does not belong into the header of a PLY file";
    assert_eq!(
        line_fault(replaced("vertex 4", "vertex many")),
        (3, what.into())
    );
    assert_eq!(
        content_fault(replaced("end_header", "end")),
        "the header of the PLY file has no \"end_header\""
    );
    assert_eq!(
        content_fault(replaced("float z", "short x")),
        "the header of the PLY file declares an element or property twice"
    );
    assert_eq!(
        content_fault(replaced("float z", "float w")),
        "the PLY file's vertices have no z"
    );
    assert_eq!(
        content_fault(replaced("element vertex", "element points")),
        "the PLY file has no vertices"
    );
    assert_eq!(
        content_fault(replaced("vertex_indices", "corners")),
        "the PLY file's faces have no list \"vertex_indices\""
    );
    assert_eq!(line_fault(replaced("ascii 1.0\n", "ascii\n")).0, 2);
    assert_eq!(
        content_fault(replaced("format ascii 1.0\n", "")),
        "the header of the PLY file is wrong: No format line found."
    );
}

#[test]
fn headers_that_promise_too_much_are_refused_before_anything_is_kept() {
    let what = content_fault(replaced("vertex 4", "vertex 18446744073709551615"));
    assert_eq!(
        what,
        "the header promises 18446744073709551615 elements \"vertex\", but only 79 bytes follow it"
    );
    let bytes = "ply\nformat ascii 1.0\nelement vertex 1000000000000\nend_header\n";
    assert_eq!(
        content_fault(bytes.into()),
        "the PLY file's vertices have no x"
    );
}

#[test]
fn binary_files_that_are_cut_off_name_the_element() {
    let mut bytes = binary(false);
    bytes.truncate(bytes.len() - 6);
    assert_eq!(content_fault(bytes), "face 1: the file ends in it");
}

proptest! {
    #[test]
    fn damaged_files_are_refused_or_read(
        file in damaged(vec![ascii(), binary(false), binary(true)]),
    ) {
        check(file)?;
    }
}
