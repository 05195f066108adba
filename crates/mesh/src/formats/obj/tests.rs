use glam::Vec3;
use proptest::prelude::*;

use super::*;
use crate::error::chain;
use crate::formats::text::decode;
use crate::{LoadError, Loaded, Loader, Mesh, NO_TRIANGLE, NormalsPolicy, Topology, obj_text};

fn read_text(text: &str) -> Result<Loaded, LoadError> {
    Loader::new().load_bytes(text.into(), "models/test.obj")
}

fn error_of(text: &str) -> String {
    chain(&read_text(text).unwrap_err())
}

/// Four vertices of a square, lines 1 to 4.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn square(faces: &str) -> String {
    format!("{SQUARE}{faces}")
}

/// The corners of each triangle of a mesh in the xy plane.
fn corners(loaded: &Loaded) -> Vec<[[f32; 2]; 3]> {
    let mesh = &loaded.mesh;
    (0..mesh.triangles().len())
        .map(|t| mesh.triangle_positions(t).map(|p| [p.x, p.y]))
        .collect()
}

const A: [f32; 2] = [0., 0.];
const B: [f32; 2] = [1., 0.];
const C: [f32; 2] = [1., 1.];
const D: [f32; 2] = [0., 1.];

#[test]
fn faces_of_all_sizes_come_in_file_order() {
    let loaded = read_text(&square("f 1 2 3 4\nf 4 2 1\nf 1/5 2/6 3/7\n")).unwrap();
    assert_eq!(
        corners(&loaded),
        [[A, B, C], [A, C, D], [D, B, A], [A, B, C]]
    );
    assert_eq!(loaded.report.polygons, 3);
    assert_eq!(loaded.report.normals.made, 12);
    assert_eq!(loaded.report.warnings, [] as [String; 0]);
}

#[test]
fn file_order_holds_across_groups_objects_and_materials() {
    let text = square(
        "o one\nusemtl red\nf 1 2 3\nusemtl blue\nf 2 3 4\ng a b\nf 3 4 1\nusemtl red\nf 4 1 2\n\
         o one\nusemtl\nf 1 2 4\n",
    );
    let loaded = read_text(&text).unwrap();
    assert_eq!(
        corners(&loaded),
        [[A, B, C], [B, C, D], [C, D, A], [D, A, B], [A, B, D]]
    );
}

#[test]
fn negative_indices_count_back_from_the_face() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n";
    assert_eq!(corners(&read_text(text).unwrap()), [[A, B, C], [A, C, D]]);
}

#[test]
fn faces_may_come_before_their_vertices() {
    let loaded = read_text(&format!("f 1 2 3\no x\n{SQUARE}")).unwrap();
    assert_eq!(corners(&loaded), [[A, B, C]]);
}

#[test]
fn continuations_comments_colours_and_texture_lines_are_no_obstacle() {
    let text = "# caf\u{e9} \\\nv 0 0 \\\n 0 1 0.5 0.25\nv 1 0 0 # corner\nv 1 1 0 0.1 0.2 0.3 1\n\
                vt 0.5\nvt x y\nf 1/1 \\\r\n2/1 \\\r\n3/1\n";
    let latin1: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let path = Path::new("x.obj");
    let loaded = Loader::new().load_bytes(latin1, path).unwrap();
    assert_eq!(corners(&loaded), [[A, B, C]]);
}

#[test]
fn utf16_reads_like_utf8() {
    let text = square("f 1 2 3 4\n");
    let big_endian = text.encode_utf16().flat_map(u16::to_be_bytes);
    let bytes = [0xfe, 0xff].into_iter().chain(big_endian).collect();
    let loaded = Loader::new().load_bytes(bytes, "x.obj").unwrap();
    assert_eq!(loaded.mesh, read_text(&text).unwrap().mesh);
}

#[test]
fn lines_points_and_small_faces_are_skipped_and_counted() {
    let loaded = read_text(&square("l 1 2 3 4\np 1\nf 1 2\nf 1 2 3\nf 1\n")).unwrap();
    assert_eq!(corners(&loaded), [[A, B, C]]);
    assert_eq!(loaded.report.skipped_elements, 4);
    assert_eq!(
        loaded.report.warnings,
        [
            "4 lines, points, curves or faces of fewer than three corners are no surface and were \
             skipped",
            "1 vertex is in no face and was left out",
        ]
    );
}

#[test]
fn a_missing_material_library_is_a_warning() {
    let loaded = read_text(&square("mtllib no such.mtl\nusemtl x\nf 1 2 3 4\n")).unwrap();
    assert_eq!(
        loaded.report.warnings,
        ["the material library no such.mtl was not found; the mesh is read without it"]
    );
}

#[test]
fn very_many_material_libraries_are_counted_only() {
    let lines: String = (0..100).map(|k| format!("mtllib no such {k}\n")).collect();
    let loaded = read_text(&square(&(lines + "f 1 2 3 4\n"))).unwrap();
    let warnings = loaded.report.warnings;
    assert_eq!(warnings.len(), 65);
    assert_eq!(
        warnings[64],
        "36 lines name further material libraries, which were not looked for"
    );
}

#[test]
fn stored_normals_are_used_and_missing_or_unusable_ones_made() {
    let text = square(
        "vn 0 0 3\nvn 0 0 0\nvn 0.6 0 0.8\nvn -nan(ind) 0 1.#QNAN\n\
         f 1//1 2//2 3//3\nf 1/7/-4 3 4//-1\n",
    );
    let loaded = read_text(&text).unwrap();
    let tilted = Vec3::new(0.6, 0.0, 0.8);
    assert_eq!(loaded.mesh.triangle_normals(0), [Vec3::Z, Vec3::Z, tilted]);
    assert_eq!(loaded.mesh.triangle_normals(1), [Vec3::Z; 3]);
    let normals = loaded.report.normals;
    assert_eq!((normals.stored, normals.made), (3, 3));
    assert_eq!((normals.unusable, normals.renormalised), (2, 2));
    assert_eq!(
        loaded.report.warnings,
        ["2 triangle corners have a normal that is zero or not finite; theirs were made"]
    );
}

#[test]
fn normals_that_no_face_names_are_made() {
    let loaded = read_text(&square("vn 1 0 0\nf 1 2 3\n")).unwrap();
    assert_eq!(loaded.mesh.triangle_normals(0), [Vec3::Z; 3]);
    assert_eq!(loaded.report.normals.made, 3);
}

#[test]
fn texture_seams_are_no_hard_edges() {
    let text = square("vn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1/4/1 3/5/1 4/6/1\n");
    let mesh = read_text(&text).unwrap().mesh;
    assert_eq!(mesh.positions().len(), 4);
    assert_eq!(Topology::new(&mesh).counts().smooth, 1);
}

#[test]
fn concave_polygons_are_cut_inside() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nf 5 1 2 3 4\n";
    let loaded = read_text(text).unwrap();
    let areas: Vec<f32> = corners(&loaded)
        .iter()
        .map(|[a, b, c]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        .collect();
    assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
    assert_eq!(areas.iter().sum::<f32>(), 5.0);
}

#[test]
fn a_homogeneous_coordinate_divides() {
    let loaded = read_text("v 0 0 0 1\nv 2 0 0 2\nv 4 4 0 4\nf 1 2 3\n").unwrap();
    assert_eq!(corners(&loaded), [[A, B, C]]);
}

#[test]
fn digits_beyond_single_precision_survive_far_out() {
    let text = "v 4500000.001 0 0\nv 4500000.002 0 0\nv 4500000.002 0.001 0\nf 1 2 3\n";
    let mesh = read_text(text).unwrap().mesh;
    assert!((mesh.bounds().min.x - 4_500_000.001).abs() < 1e-9);
    assert!((mesh.bounds().max.x - 4_500_000.002).abs() < 1e-9);
}

#[test]
fn empty_files_and_points_alone_are_refused() {
    let error = error_of("");
    assert!(
        error.starts_with("models/test.obj: the file is empty"),
        "{error}"
    );
    let points = "models/test.obj: no mesh can be made of it: the mesh has 4 points, no faces";
    for text in [SQUARE, &square("l 1 2\n")] {
        let error = error_of(text);
        assert!(error.starts_with(points), "{error}");
    }
    let error = error_of("mtllib x\n");
    assert!(
        error.ends_with("the mesh is empty: it has no triangles"),
        "{error}"
    );
}

#[test]
fn bad_coordinates_are_refused_with_their_line() {
    let cases = [
        (
            "# x\nv 0 3.1+e2 0\n",
            "2: vertex 1: \"3.1+e2\" is not a number",
        ),
        (
            "v 0 \\\n\\\n1\n",
            "1: vertex 1 has 2 coordinates instead of 3",
        ),
        ("v 0 0 0 v 1 0 0\n", "1: vertex 1: \"v\" is not a number"),
        ("v 0 0 0 1 1 red\n", "1: vertex 1: \"red\" is not a number"),
        ("vn 0 1\n", "1: normal 1 has 2 coordinates instead of 3"),
        ("vn 0 1 up\n", "1: normal 1: \"up\" is not a number"),
        ("vn 0 0 1 f\n", "1: normal 1: \"f\" is not a number"),
    ];
    for (text, what) in cases {
        assert_eq!(error_of(text), format!("models/test.obj:{what}"));
    }
}

#[test]
fn used_vertices_that_no_mesh_may_have_are_refused_with_their_line() {
    let cases = [
        ("1 NaN 0", "vertex 2 is not finite: 1 NaN 0"),
        ("0 0 1e999", "vertex 2 is not finite: 0 0 1e999"),
        ("0 1.#IND 0", "vertex 2 is not finite: 0 1.#IND 0"),
        (
            "0 0 0 0",
            "vertex 2: its fourth coordinate, which divides, is zero",
        ),
        (
            "0 0 1e20 0.5",
            "vertex 2 lies too far out (0 0 200000000000000000000): coordinates may go up to 1e18; \
             scale the mesh down",
        ),
    ];
    for (vertex, what) in cases {
        let text = |faces: &str| {
            format!("# x\nv 0 0 0\n\nv {vertex}\nv 0 1 0\nv 1 1 0\nv 1 0 0\nf 1 3 4\n{faces}")
        };
        assert_eq!(
            error_of(&text("f 1 2 3 4\n")),
            format!("models/test.obj:4: {what}; --lenient skips the faces that have it")
        );
        let lenient = Loader::new().lenient(true);
        let loaded = lenient.load_bytes(text("f 1 2 3 4\nf 1 2 3\nf 3 4 5").into(), "x.obj");
        let report = loaded.unwrap().report;
        assert_eq!((report.polygons, report.skipped_faults), (2, 2));
        // What no face names does not matter.
        let loaded = read_text(&text("f 3 4 5\n")).unwrap();
        assert_eq!(loaded.mesh.bounds().max, DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(
            loaded.report.warnings,
            ["1 vertex is in no face and was left out"]
        );
    }
}

#[test]
fn a_stray_vertex_does_not_move_the_origin_of_a_mesh_far_out() {
    let text = "v 0 0 0\nv 456789.25 5123456.5 314.25\nv 456789.251 5123456.5 314.25\n\
                v 456789.25 5123456.501 314.25\nf 2 3 4\n";
    let mesh = read_text(text).unwrap().mesh;
    assert!((mesh.bounds().diagonal() - 1e-3 * 2f64.sqrt()).abs() < 1e-9);
}

#[test]
fn any_line_end_ends_a_line_even_where_they_are_mixed() {
    let expected = read_text(&square("f 1 2 3\nf 1 3 4\n")).unwrap().mesh;
    let lines = [
        "# head", "v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "f 1 2 3", "f 1 3 4",
    ];
    for ends in [
        ["\r", "\n"],
        ["\n", "\r"],
        ["\r\n", "\r"],
        ["\r\r", "\n\r\n"],
    ] {
        let text: String = (lines.iter().zip(ends.iter().cycle()))
            .map(|(line, end)| format!("{line}{end}"))
            .collect();
        assert_eq!(read_text(&text).unwrap().mesh, expected, "{ends:?}");
    }
}

/// The loaded mesh's hard edges, with these options.
fn hard_edges(text: &str, loader: Loader<'_>) -> (u64, u64) {
    let loaded = loader.load_bytes(text.into(), "x.obj").unwrap();
    let hard = Topology::new(&loaded.mesh).counts().hard;
    (hard, loaded.report.normals.by_group)
}

#[test]
fn smoothing_groups_decide_what_is_smooth() {
    // A roof whose halves meet at 45 degrees, and a gable that stands on its first half's edge.
    let roof = |first: &str, second: &str| {
        format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 -1\n{first}f 1 2 3\n{second}f 2 1 4\n")
    };
    let loader = Loader::new();
    let smooth = loader.normals(NormalsPolicy::Smooth);
    for loader in [loader, smooth] {
        assert_eq!(hard_edges(&roof("", ""), loader), (1, 0));
        assert_eq!(hard_edges(&roof("s 1\n", ""), loader), (0, 6));
        assert_eq!(hard_edges(&roof("s 7\n", "s 7\n"), loader), (0, 6));
        assert_eq!(hard_edges(&roof("s 1\n", "s 2\n"), loader), (1, 6));
        assert_eq!(hard_edges(&roof("s off\n", ""), loader), (1, 6));
        assert_eq!(hard_edges(&roof("", "s 1\n"), loader), (1, 6));
        let overridden = loader.crease_angle_degrees(50.0);
        assert_eq!(hard_edges(&roof("s off\n", ""), overridden), (0, 0));
        let overridden = loader.crease_angle_degrees(40.0);
        assert_eq!(hard_edges(&roof("s 1\n", ""), overridden), (1, 0));
    }
    // Nearly flat, and still hard.
    let flat = roof("s off\n", "").replace("v 0 -1 -1", "v 0 -1 -0.01");
    assert_eq!(hard_edges(&flat, loader), (1, 6));
    // A file with normals means them; made anew, its groups decide.
    let with_normals = |groups: &str| {
        format!(
            "vn 0 0 1\n{}",
            roof(groups, "").replace("f 1 2 3", "f 1//1 2//1 3//1")
        )
    };
    assert_eq!(hard_edges(&with_normals("s 1\n"), loader), (1, 0));
    assert_eq!(hard_edges(&with_normals("s 1\n"), smooth), (0, 6));
    // Normals that no face names are none.
    assert_eq!(
        hard_edges(&format!("vn 0 0 1\n{}", roof("s 1\n", "")), loader),
        (0, 6)
    );
    assert_eq!(
        error_of("v 0 0 0\ns one\n"),
        "models/test.obj:2: \"one\" is no smoothing group: that is a number or off; \
         --lenient skips the line"
    );
}

#[test]
fn lenient_reading_skips_wrong_smoothing_groups_and_keeps_the_last() {
    let text = square("s 1\nf 1 2 3\ns one\nf 1 3 4\n");
    let loaded = Loader::new().lenient(true).load_bytes(text.into(), "x.obj");
    let loaded = loaded.unwrap();
    assert_eq!(loaded.report.skipped_faults, 1);
    assert_eq!(Topology::new(&loaded.mesh).counts().hard, 0);
    assert_eq!(loaded.report.normals.by_group, 6);
}

#[test]
fn smoothing_groups_hold_over_chunks_and_polygons() {
    let text = square("v 2 0 1\ns 3\nf 1 2 3 4\n# more\ns off\nf 2 5 3\ns 3\nf 1 2 3 4\n");
    for size in [1, 9, 30, 1000] {
        let (raw, _) = read_in(&text, size).unwrap();
        assert_eq!(raw.smoothing_groups, Some(vec![3, 3, 0, 3, 3]), "{size}");
    }
}

#[test]
fn wrong_corners_are_named_with_what_lenient_skips() {
    let text = square("f 1 2 3\nf 1/1/1 2/2/1 3 4\nf 1 2 9\n");
    assert_eq!(
        error_of(&text),
        "models/test.obj:6: corner \"1/1/1\" names normal 1, but the file has 0 (1 is the first); \
         --lenient skips the corner's normal"
    );
    let lenient = Loader::new().lenient(true);
    let loaded = lenient.load_bytes(text.into(), "x.obj").unwrap();
    assert_eq!(corners(&loaded), [[A, B, C], [A, B, C], [A, C, D]]);
    assert_eq!(
        (loaded.report.polygons, loaded.report.skipped_faults),
        (2, 3)
    );
    assert_eq!(
        loaded.report.warnings,
        [
            "3 wrong elements were skipped; the first: line 6: corner \"1/1/1\" names normal 1, but the \
          file has 0 (1 is the first)"
        ]
    );
}

#[test]
fn bad_indices_are_refused_with_their_line() {
    let cases = [
        (
            "f 1 2 5",
            "\"5\" names vertex 5, but the file has 4 (1 is the first)",
        ),
        (
            "f 1 0 2",
            "\"0\" names vertex 0, but the file has 4 (1 is the first)",
        ),
        (
            "f 1 2 -5",
            "\"-5\" names vertex -5, but the file has 4 (1 is the first)",
        ),
        (
            "f 1 2 3//1",
            "\"3//1\" names normal 1, but the file has 0 (1 is the first)",
        ),
        ("f 1 2 x/3/4", "\"x/3/4\" is not made of whole numbers"),
        ("f 1 2 3.5", "\"3.5\" is not made of whole numbers"),
        ("f 1 2 //", "\"//\" is not made of whole numbers"),
        ("f 1 2 3/1/1/1", "\"3/1/1/1\" has more than three parts"),
        (
            "f 1 2 9223372036854775807",
            "\"9223372036854775807\" names vertex 9223372036854775807, but the file has 4 \
             (1 is the first)",
        ),
        (
            "f 1 2 -9223372036854775808",
            "\"-9223372036854775808\" names vertex -9223372036854775808, but the file has 4 \
             (1 is the first)",
        ),
    ];
    for (face, what) in cases {
        let skipped = if what.contains("normal") {
            "corner's normal"
        } else {
            "face"
        };
        assert_eq!(
            error_of(&square(&format!("f 1 2 3\n{face}\n"))),
            format!("models/test.obj:6: corner {what}; --lenient skips the {skipped}")
        );
    }
}

/// What is read of a text in chunks of this size.
fn read_in(text: &str, size: usize) -> Result<(RawMesh, LoadReport), Fault> {
    let skipped = Skipped::new(false);
    let parsed = read_by(text, Path::new("x.obj"), skipped, &|_| {}, size)?;
    Ok((parsed.model.flatten().unwrap(), parsed.report))
}

/// A sheet of `columns` by 30 squares, bent into a cylinder's wall with hard edges every `hard` columns.
fn bent_sheet(columns: u32, hard: u32) -> Mesh {
    let place = |column: u32, row: u32| {
        let angle = f64::from(column / hard * hard) * 0.2;
        DVec3::new(
            angle.cos() * f64::from(column),
            angle.sin(),
            f64::from(row) * 0.1,
        )
    };
    let corners = (0..30).flat_map(|row| (0..=columns).map(move |column| (column, row)));
    let positions = corners.map(|(column, row)| place(column, row)).collect();
    let vertex = |column: u32, row: u32| row * (columns + 1) + column;
    let squares = (0..29).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let triangles = squares.flat_map(|(column, row)| {
        let [a, b] = [vertex(column, row), vertex(column + 1, row)];
        let [c, d] = [vertex(column + 1, row + 1), vertex(column, row + 1)];
        [[a, b, c], [a, c, d]]
    });
    Mesh::new(positions, None, triangles.collect()).unwrap()
}

#[test]
fn a_well_known_reader_reads_the_same() {
    for mesh in [bent_sheet(30, 1), bent_sheet(12, 4)] {
        let text = decode(obj_text(&mesh).into_bytes());
        let options = tobj::LoadOptions::default();
        let none = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
        let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, none).unwrap();
        let theirs = &models[0].mesh;
        let (ours, _) = read_in(&text, 1000).unwrap();
        assert_eq!(models.len(), 1);
        let vector = |flat: &[f64], i: u32| DVec3::from_slice(&flat[3 * i as usize..]);
        let ours_normals = ours.normal_corners.unwrap();
        assert_eq!(ours.corners.len() * 3, theirs.indices.len());
        for (corner, (&p, &n)) in (0..).zip(theirs.indices.iter().zip(&theirs.normal_indices)) {
            let own_p = ours.corners.as_flattened()[corner] as usize;
            let own_n = ours_normals.as_flattened()[corner] as usize;
            assert_eq!(ours.positions[own_p], vector(&theirs.positions, p));
            assert_eq!(ours.normals[own_n], vector(&theirs.normals, n));
        }
    }
}

#[test]
fn the_first_fault_of_the_file_is_shares() {
    let text = format!("{SQUARE}f 1 2 x\nv 0 0\n");
    for size in [1, 20, 1000] {
        let fault = read_in(&text, size).unwrap_err();
        assert!(matches!(fault, Fault::Line(5, _)), "{fault:?}");
    }
}

#[test]
fn progress_ends_at_the_whole() {
    let shares = std::sync::Mutex::new(Vec::new());
    let progress = |share| shares.lock().unwrap().push(share);
    let text = square("f 1 2 3\n");
    let skipped = Skipped::new(false);
    read_by(&text, Path::new("x.obj"), skipped, &progress, 1).unwrap();
    let mut shares = shares.into_inner().unwrap();
    shares.sort_by(f32::total_cmp);
    assert_eq!((shares.len(), shares[4]), (5, 1.0));
}

/// Files of plausible and implausible words.
fn word_soup() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        8 => prop::sample::select(vec![
            "0", "1", "-1", "2", "3", "-3", "0.5", "1e30", "1e-320", "nan", "-inf", "1//1",
            "2/1/2", "3//-1", "-2//", "1/", "/", "\\", "\\\n", "#", "1.#IND", "\u{fc}", "99",
            "-99", "4294967297", "18446744073709551617",
        ]).prop_map(str::to_owned),
        1 => any::<f32>().prop_map(|x| x.to_string()),
    ];
    let keyword = prop::sample::select(vec![
        "v", "v", "vn", "f", "f", "vt", "l", "p", "g", "o", "usemtl", "mtllib", "s", "#", "", "x",
    ]);
    let line = (keyword, prop::collection::vec(word, 0..7))
        .prop_map(|(keyword, words)| format!("{keyword} {}", words.join(" ")));
    // Most files start well, so that they get somewhere.
    (any::<bool>(), prop::collection::vec(line, 0..12)).prop_map(|(start, lines)| {
        let start = if start { SQUARE } else { "" };
        format!("{start}{}", lines.join("\n"))
    })
}

/// Coordinates from the harmless to the extreme.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-2i8..3).prop_map(f64::from),
        1 => -1e18..1e18f64,
        1 => -1e-18..1e-18f64,
    ]
}

fn check_invariants(mesh: &Mesh) {
    assert!(mesh.positions().iter().all(|p| p.is_finite()));
    assert!(mesh.normals().iter().all(|n| n.is_normalized()));
    assert_eq!(mesh.normals().len(), mesh.positions().len());
    let corners = mesh.triangles().as_flattened();
    assert!(
        corners
            .iter()
            .all(|&v| (v as usize) < mesh.positions().len())
    );
    let bits =
        |v: usize| [mesh.positions()[v], mesh.normals()[v]].map(|x| x.to_array().map(f32::to_bits));
    let distinct: std::collections::HashSet<_> = (0..mesh.positions().len()).map(bits).collect();
    assert_eq!(distinct.len(), mesh.positions().len());
    let topology = Topology::new(mesh);
    for triangle in 0..mesh.triangles().len() {
        for neighbour in topology.neighbours(triangle) {
            if neighbour != NO_TRIANGLE {
                let back = topology.neighbours(neighbour as usize);
                assert!(back.contains(&(triangle as u32)), "neighbours are mutual");
            }
        }
    }
}

proptest! {
    #[test]
    fn chunks_make_no_difference(text in word_soup(), size in 1usize..80) {
        let read = |size| read_in(&text, size).map_err(|fault| fault.of("x.obj".as_ref()).to_string());
        // As texts, in which NaN is equal to itself.
        prop_assert_eq!(format!("{:?}", read(size)), format!("{:?}", read(CHUNK)));
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in word_soup()) {
        match read_text(&text) {
            Ok(loaded) => check_invariants(&loaded.mesh),
            Err(error) => prop_assert!(error.to_string().starts_with("models/test.obj")),
        }
    }

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Loader::new().load_bytes(bytes, "x.obj");
    }

    #[test]
    fn any_finite_polygons_make_a_sound_mesh(
        points in prop::collection::vec([coordinate(), coordinate(), coordinate()], 3..12),
        faces in prop::collection::vec(prop::collection::vec(0usize..100, 3..9), 1..8),
    ) {
        let mut text = String::new();
        for [x, y, z] in &points {
            text += &format!("v {x:e} {y:e} {z:e}\n");
        }
        for face in &faces {
            let corners: Vec<String> =
                face.iter().map(|i| (i % points.len() + 1).to_string()).collect();
            text += &format!("f {}\n", corners.join(" "));
        }
        let loaded = read_text(&text).unwrap();
        let triangles: usize = faces.iter().map(|f| f.len() - 2).sum();
        prop_assert_eq!(loaded.mesh.triangles().len(), triangles);
        check_invariants(&loaded.mesh);
    }
}
