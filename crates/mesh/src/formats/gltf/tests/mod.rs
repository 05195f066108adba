mod pose;
mod scenery;
mod sharing;

use base64::Engine;
use glam::DVec3;
use gltf::json::mesh::Mode;
use proptest::prelude::*;

use super::meshes::triangles;
use super::*;
use crate::formats::{check, damaged};
use crate::{Loaded, Loader};

/// A buffer of numbers and the views into it.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<String>,
}

impl Data {
    fn view(&mut self, bytes: &[u8]) -> usize {
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{length}}}"
        ));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn floats(&mut self, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.view(&bytes)
    }
}

/// A square in the xy plane, and its normal; view 2 has indices of 8 bits, 3 of 16 and 4 of 32.
fn data() -> Data {
    let mut data = Data::default();
    data.floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    data.floats(&[0., 0., 1.].repeat(4));
    let order = [0u8, 1, 2, 0, 2, 3];
    data.view(&order);
    let wide: Vec<u8> = order
        .iter()
        .flat_map(|&i| u16::from(i).to_le_bytes())
        .collect();
    data.view(&wide);
    let wider: Vec<u8> = order
        .iter()
        .flat_map(|&i| u32::from(i).to_le_bytes())
        .collect();
    data.view(&wider);
    data
}

const ACCESSORS: &str = r#"
    {"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
    {"bufferView":1,"componentType":5126,"count":4,"type":"VEC3"},
    {"bufferView":2,"componentType":5121,"count":6,"type":"SCALAR"},
    {"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"},
    {"bufferView":4,"componentType":5125,"count":6,"type":"SCALAR"}"#;

fn primitive(indices: usize) -> String {
    format!("{{\"attributes\":{{\"POSITION\":0,\"NORMAL\":1}},\"indices\":{indices}}}")
}

fn json(data: &Data, accessors: &str, primitives: &str, nodes: &str, uri: bool) -> String {
    let encoded = base64::engine::general_purpose::STANDARD.encode(&data.bytes);
    let uri = if uri {
        format!(",\"uri\":\"data:application/octet-stream;base64,{encoded}\"")
    } else {
        String::new()
    };
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"accessors\":[{accessors}],\
         \"meshes\":[{{\"name\":\"square\",\"primitives\":[{primitives}]}}],\"nodes\":[{nodes}],\
         \"bufferViews\":[{}],\"buffers\":[{{\"byteLength\":{}{uri}}}]}}",
        data.views.join(","),
        data.bytes.len(),
    )
}

/// Text as a GLB with a binary chunk.
fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut text = json.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = |n: usize| (n as u32).to_le_bytes();
    [
        b"glTF",
        &[2, 0, 0, 0][..],
        &length(28 + text.len() + binary.len()),
        &length(text.len()),
        b"JSON",
        &text,
        &length(binary.len()),
        b"BIN\0",
        binary,
    ]
    .concat()
}

fn load_text(text: &str) -> Result<Loaded, String> {
    let loaded = Loader::new().load_bytes(text.into(), "x.gltf");
    loaded.map_err(|error| crate::error::chain(&error))
}

/// The square with these primitives under these nodes.
fn loaded(primitives: &str, nodes: &str) -> Loaded {
    load_text(&json(&data(), ACCESSORS, primitives, nodes, true)).unwrap()
}

fn error_of(accessors: &str, primitives: &str, nodes: &str) -> String {
    load_text(&json(&data(), accessors, primitives, nodes, true)).unwrap_err()
}

/// Two triangles, counterclockwise from the origin.
fn assert_square(mesh: &crate::Mesh) {
    let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| glam::Vec3::new(x, y, 0.0));
    let [a, b, c, d] = corners;
    assert_eq!(mesh.triangles().len(), 2);
    assert_eq!(mesh.triangle_positions(0), [a, b, c]);
    assert_eq!(mesh.triangle_positions(1), [a, c, d]);
}

#[test]
fn indices_of_all_widths_and_none_make_the_same_square() {
    for indices in 2..5 {
        let mesh = loaded(&primitive(indices), "{\"mesh\":0}").mesh;
        assert_square(&mesh);
        assert_eq!(mesh.normals(), [glam::Vec3::Z; 4]);
    }
    let fan = "{\"attributes\":{\"POSITION\":0},\"mode\":6}";
    assert_square(&loaded(fan, "{\"mesh\":0}").mesh);
    let strip = triangles(Mode::TriangleStrip, &[0, 1, 2, 3, 3, 4, 5]);
    // Two equal corners only turn the strip.
    assert_eq!(strip, [[0, 1, 2], [2, 1, 3], [3, 4, 5]]);
}

#[test]
fn a_binary_file_reads_like_text() {
    let data = data();
    let text = json(&data, ACCESSORS, &primitive(3), "{\"mesh\":0}", false);
    let bytes = glb(&text, &data.bytes);
    let binary = Loader::new().load_bytes(bytes, "x.glb").unwrap();
    assert_eq!(binary.mesh, loaded(&primitive(3), "{\"mesh\":0}").mesh);
}

#[test]
fn nodes_place_turn_and_mirror_their_meshes() {
    let nodes = r#"{"children":[1,2],"scale":[2,1,1]},
        {"mesh":0,"translation":[0,0,5]},
        {"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}"#;
    let mesh = loaded(&primitive(2), nodes).mesh;
    assert_eq!(mesh.triangles().len(), 4);
    let at = |t: usize| mesh.triangle_positions(t).map(|p| p.to_array());
    assert_eq!(at(0), [[0., 0., 5.], [2., 0., 5.], [2., 1., 5.]]);
    // Mirrored: it winds the other way, so that its front stays where its normals point.
    assert_eq!(at(2), [[0., 0., 0.], [-2., 1., 0.], [-2., 0., 0.]]);
    assert!(mesh.normals().iter().all(|&n| n == glam::Vec3::Z));
}

#[test]
fn normals_stay_perpendicular_under_uneven_scales() {
    let mut data = data();
    let slope = data.floats(&[1., 0., 0., 0., 1., 0., 0., 0., 1.]);
    let normal = data.floats(&[1.; 9]);
    let vectors = |view: usize| {
        format!("{{\"bufferView\":{view},\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}}")
    };
    let accessors = [vectors(slope), vectors(normal)].join(",");
    let primitives = "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}";
    for scale in ["[1,2,5]", "[-1,2,5]", "[-1,-2,-5]"] {
        let nodes = format!("{{\"mesh\":0,\"scale\":{scale}}}");
        let mesh = load_text(&json(&data, &accessors, primitives, &nodes, true))
            .unwrap()
            .mesh;
        let [a, b, c] = mesh.triangle_positions(0);
        let facing = (b - a).cross(c - a).normalize();
        for n in mesh.normals() {
            assert!(n.distance(facing) < 1e-6, "{scale}: {n} is not {facing}");
        }
    }
}

#[test]
fn sparse_accessors_replace_some_elements() {
    let mut data = data();
    let at = data.view(&[1, 3]);
    let values = data.floats(&[5., 0., 0., 0., 7., 0.]);
    let sparse = format!(
        "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{{\"count\":2,\
         \"indices\":{{\"bufferView\":{at},\"componentType\":5121}},\
         \"values\":{{\"bufferView\":{values}}}}}}}"
    );
    let square = "{\"attributes\":{\"POSITION\":0},\"mode\":6}";
    let read = |accessor: String| {
        load_text(&json(&data, &accessor, square, "{\"mesh\":0}", true))
            .unwrap()
            .mesh
    };
    let mesh = read(format!("{{\"bufferView\":0,{sparse}"));
    assert_eq!(mesh.triangle_positions(0)[1].x, 5.0);
    assert_eq!(mesh.triangle_positions(1)[1].y, 1.0);
    assert_eq!(mesh.triangle_positions(1)[2].y, 7.0);
    // Without a view all others are zero.
    let mesh = read(format!("{{{sparse}"));
    assert_eq!(mesh.triangle_positions(1)[1], glam::Vec3::ZERO);
}

#[test]
fn whole_numbers_may_stand_for_positions() {
    let mut data = data();
    let view = data.view(&[0, 0, 0, 255, 0, 0, 0, 127, 0]);
    let accessor = format!(
        "{{\"bufferView\":{view},\"componentType\":5121,\"normalized\":true,\"count\":3,\
         \"type\":\"VEC3\"}}"
    );
    let square = "{\"attributes\":{\"POSITION\":0}}";
    let mesh = load_text(&json(&data, &accessor, square, "{\"mesh\":0}", true))
        .unwrap()
        .mesh;
    let [_, second, third] = mesh.triangle_positions(0);
    assert_eq!((second.x, third.y), (1.0, 127.0 / 255.0));
}

#[test]
fn several_primitives_share_their_vertices_and_may_lack_normals() {
    let both = format!("{},{{\"attributes\":{{\"POSITION\":0}}}}", primitive(2));
    let text = json(&data(), ACCESSORS, &both, "{\"mesh\":0}", true);
    let error = load_text(&text).unwrap_err();
    assert_eq!(
        error,
        "x.gltf: mesh 0 \"square\", primitive 1: its 4 corners are no whole triangles; --lenient \
         skips the last 1"
    );
    let both = format!(
        "{},{{\"attributes\":{{\"POSITION\":0}},\"indices\":3}},{{\"attributes\":{{}},\"mode\":1}}",
        primitive(2)
    );
    let loaded = loaded(&both, "{\"mesh\":0}");
    assert_eq!(loaded.mesh.triangles().len(), 4);
    assert_eq!(
        (loaded.report.normals.stored, loaded.report.normals.made),
        (6, 6)
    );
    assert_eq!(loaded.report.skipped_elements, 1);
    assert_eq!(loaded.mesh.positions().len(), 4);
}

#[test]
fn wrong_files_are_refused_by_the_place_that_is_wrong() {
    let node = "{\"mesh\":0}";
    let named = "x.gltf: mesh 0 \"square\", primitive 0: ";
    let skipped = "; --lenient skips the primitive";
    let cases = [
        (
            "\"count\":4",
            "\"count\":5",
            "accessor 0: it reaches beyond its buffer view",
        ),
        (
            "\"count\":4",
            "\"count\":9007199254740993",
            "accessor 0: it reaches beyond its buffer view",
        ),
        (
            "\"bufferView\":0",
            "\"bufferView\":9",
            "accessor 0: buffer view 9 reaches beyond its buffer",
        ),
        ("\"bufferView\":0,", "", "accessor 0: it has no data"),
        (
            "VEC3",
            "VEC2",
            "accessor 0: it does not hold Vec3 elements, as it should",
        ),
        ("5126", "5120", ""),
    ];
    for (from, to, what) in cases {
        let accessors = ACCESSORS.replacen(from, to, 1);
        if what.is_empty() {
            load_text(&json(&data(), &accessors, &primitive(2), node, true)).unwrap();
            continue;
        }
        assert_eq!(
            error_of(&accessors, &primitive(2), node),
            format!("{named}{what}{skipped}")
        );
    }
    assert_eq!(
        error_of(ACCESSORS, &primitive(7), node),
        format!("{named}accessor 7: there is no such accessor{skipped}")
    );
    assert_eq!(
        error_of(ACCESSORS, &primitive(2), "{\"mesh\":3}"),
        "x.gltf: there is no mesh 3"
    );
    assert_eq!(
        error_of(
            ACCESSORS,
            &primitive(2),
            "{\"children\":[1]},{\"children\":[1],\"mesh\":0}"
        ),
        "x.gltf: node 1 has two parents or is its own"
    );
    assert_eq!(
        error_of(ACCESSORS, &primitive(2), "{\"children\":[4]}"),
        "x.gltf: there is no node 4"
    );
    assert_eq!(
        error_of(ACCESSORS, "{\"attributes\":{}}", node),
        format!("{named}it has no positions{skipped}")
    );
}

#[test]
fn a_vertex_that_is_not_finite_is_named() {
    let mut data = data();
    data.bytes[12..16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let text = json(&data, ACCESSORS, &primitive(2), "{\"mesh\":0}", true);
    assert_eq!(
        load_text(&text).unwrap_err(),
        "x.gltf: mesh 0 \"square\", primitive 0: vertex 1 is not finite: inf 0 0; \
         --lenient skips the triangle"
    );
}

#[test]
fn points_and_lines_alone_are_told() {
    for mode in 0..4 {
        let points = format!("{{\"attributes\":{{\"POSITION\":0}},\"mode\":{mode}}}");
        let error = error_of(ACCESSORS, &points, "{\"mesh\":0}");
        assert!(error.contains("has 4 points, no faces"), "{error}");
    }
}

#[test]
fn a_binary_file_may_pad_its_json_with_zeros_and_mark_it() {
    let text = json(&data(), ACCESSORS, &primitive(2), "{\"mesh\":0}", false);
    let text = format!("\u{feff}{text}\0\0\0\0\0\0\0");
    let loaded = Loader::new().load_bytes(glb(&text, &data().bytes), "x.glb");
    assert_eq!(loaded.unwrap().mesh.triangles().len(), 2);
}

#[test]
fn wrong_buffers_json_and_extensions_are_refused() {
    let text = json(&data(), ACCESSORS, &primitive(2), "{\"mesh\":0}", true);
    let with = |from: &str, to: &str| load_text(&text.replacen(from, to, 1)).unwrap_err();
    let error = with("data:application/octet-stream;base64,", "data:;base64,@");
    assert!(
        error.starts_with("x.gltf: buffer 0: its base64 data is wrong: "),
        "{error}"
    );
    let error = with("\"uri\":\"data:", "\"uri\":\"no%20such.bin#");
    assert!(
        error.starts_with("x.gltf: buffer 0: cannot read no such.bin#"),
        "{error}"
    );
    assert!(with("\"uri\":\"data:", "\"uri\":\"https://x/").contains("is not on this machine"));
    assert_eq!(
        with("\"uri\"", "\"url\""),
        "x.gltf: mesh 0 \"square\", primitive 0: accessor 0: buffer 0 has no data: neither a file nor \
         a binary chunk; --lenient skips the primitive"
    );
    let error = with(
        "\"buffers\":[{\"byteLength\":",
        "\"buffers\":[{\"byteLength\":9",
    );
    assert_eq!(error, "x.gltf: buffer 0 has 140 bytes instead of 9140");
    let error = with("\"asset\"", "asset");
    assert!(
        error.starts_with("x.gltf:1: the glTF's JSON is wrong: key must be"),
        "{error}"
    );
    let draco = "{\"extensionsRequired\":[\"KHR_materials_unlit\",\"KHR_draco_mesh_compression\"],";
    assert_eq!(
        with("{", draco),
        "x.gltf: its data is compressed by the glTF extension KHR_draco_mesh_compression, which is \
         not read; export it without compression, or unpack it with `gltf-transform copy`"
    );
}

/// The square once mirrored and moved, as text and as a binary file.
fn files() -> Vec<Vec<u8>> {
    let data = data();
    let nodes = "{\"children\":[1],\"scale\":[2,-1,1]},{\"mesh\":0,\"translation\":[0,0,5]}";
    let text = |uri| json(&data, ACCESSORS, &primitive(3), nodes, uri);
    vec![text(true).into_bytes(), glb(&text(false), &data.bytes)]
}

proptest! {
    #[test]
    fn damaged_files_are_refused_or_read(file in damaged(files())) {
        check(file)?;
    }
}

#[test]
fn a_mesh_of_several_nodes_is_one_part_with_as_many_placements() {
    let nodes = "{\"children\":[1],\"scale\":[2,-1,1]},{\"mesh\":0,\"translation\":[0,0,5]},\
                 {\"mesh\":0},{\"mesh\":0,\"scale\":[1,0,1]}";
    let text = json(&data(), ACCESSORS, &primitive(2), nodes, true).into_bytes();
    let loaded = Loader::new()
        .load_parts_bytes(text, "x.gltf".as_ref())
        .unwrap();
    let triangles = |mesh: &crate::Mesh| mesh.triangles().len();
    let sizes: Vec<_> = loaded.parts.meshes.iter().map(triangles).collect();
    assert_eq!(
        sizes,
        [2, 2],
        "what is squeezed flat is a copy, the first part"
    );
    let placed: Vec<_> = (loaded.parts.placements.iter())
        .map(|p| (p.part, p.to_user.transform_point3(DVec3::ONE)))
        .collect();
    let expected = [
        (0, DVec3::ONE),
        (1, DVec3::new(2.0, -1.0, 6.0)),
        (1, DVec3::ONE),
    ];
    assert_eq!(placed, expected);
    // What is squeezed flat has no normals left.
    let normals = loaded.report.normals;
    assert_eq!((normals.stored, normals.made), (6, 6));
}

#[test]
fn a_backslash_in_the_address_of_a_buffer_stands_for_a_slash() {
    let folder = tempfile::tempdir().unwrap();
    let data = data();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    let file = folder.path().join("data").join("square 1.bin");
    std::fs::write(file, &data.bytes).unwrap();
    let text = json(&data, ACCESSORS, &primitive(2), "{\"mesh\":0}", false);
    let load = |address: &str| {
        let length = data.bytes.len();
        let from = format!("\"byteLength\":{length}}}");
        assert!(text.contains(&from));
        let to = format!("\"byteLength\":{length},\"uri\":\"{address}\"}}");
        let text = text.replace(&from, &to);
        Loader::new().load_bytes(text.into(), folder.path().join("x.gltf"))
    };
    for address in [
        "data/square%201.bin",
        r"data\\square%201.bin",
        r".\\data\\square 1.bin",
        "data%5Csquare 1.bin",
    ] {
        assert_square(&load(address).unwrap().mesh);
    }
    let error = load(r"other\\square.bin").unwrap_err().to_string();
    assert!(error.contains("cannot read"), "{error}");
    // Elsewhere it may be part of a name.
    let file = folder.path().join(r"data\other.bin");
    if std::fs::write(file, &data.bytes).is_ok() {
        assert_square(&load(r"data\\other.bin").unwrap().mesh);
    }
}

#[test]
fn gltf_1_is_told_however_it_says_so() {
    for text in [
        r#"{"asset":{"version":"1.0"},"meshes":{"m":{"primitives":[]}}}"#,
        r#"{"asset":{"version":1.1},"meshes":{"m":{"primitives":[]}}}"#,
        r#"{"asset":{"version":"1.0"}}"#,
        r#"{"asset":{},"nodes":{"n":{"meshes":["m"]}}}"#,
        r#"{"scene":"s","accessors":{},"meshes":{"m":{"primitives":[]}}}"#,
    ] {
        let error = load_text(text).unwrap_err();
        assert!(
            error.starts_with("x.gltf: this is glTF 1.") && error.contains("gltf-pipeline"),
            "{text}: {error}"
        );
    }
    let error = load_text(r#"{"vertices":[0,1,2]}"#).unwrap_err();
    assert!(error.contains("no glTF"), "{error}");
}
