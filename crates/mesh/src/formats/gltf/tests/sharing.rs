//! Accessors that many primitives share: cost is by the file and not by the use.

use super::{ACCESSORS, Data, data, json, load_text, primitive};
use crate::{Loaded, Loader};

/// `meshes` meshes of one triangle each, which share positions and normals of `vertices` vertices.
fn shared(meshes: usize, vertices: usize, attributes: impl Fn(usize) -> [usize; 2]) -> Loaded {
    let mut data = Data::default();
    let numbers: Vec<f32> = (0..vertices)
        .flat_map(|v| [v as f32, (v % 7) as f32, (v % 3) as f32])
        .collect();
    data.floats(&numbers);
    data.floats(&[0., 0., 1.].repeat(vertices));
    let mut accessors = Vec::new();
    let mut vectors = |view: usize| {
        accessors.push(format!(
            "{{\"bufferView\":{view},\"componentType\":5126,\"count\":{vertices},\
             \"type\":\"VEC3\"}}"
        ));
    };
    for _ in 0..=meshes {
        vectors(0);
        vectors(1);
    }
    let mut all = Vec::new();
    for mesh in 0..meshes {
        let first = (3 * mesh % (vertices - 2)) as u32;
        let indices: Vec<u8> = (first..first + 3).flat_map(u32::to_le_bytes).collect();
        let view = data.view(&indices);
        accessors.push(format!(
            "{{\"bufferView\":{view},\"componentType\":5125,\"count\":3,\"type\":\"SCALAR\"}}"
        ));
        let [positions, normals] = attributes(mesh);
        all.push(format!(
            "{{\"primitives\":[{{\"attributes\":{{\"POSITION\":{positions},\"NORMAL\":{normals}}},\
             \"indices\":{}}}]}}",
            accessors.len() - 1
        ));
    }
    let nodes: Vec<String> = (0..meshes)
        .map(|mesh| format!("{{\"mesh\":{mesh}}}"))
        .collect();
    let text = json(&data, &accessors.join(","), "", &nodes.join(","), true);
    let meshes = format!("\"meshes\":[{}],\"nodes\"", all.join(","));
    let start = text.find("\"meshes\"").unwrap();
    let end = text.find("\"nodes\"").unwrap();
    let text = format!(
        "{}{meshes}{}",
        &text[..start],
        &text[end + "\"nodes\"".len()..]
    );
    load_text(&text).unwrap()
}

#[test]
fn hundreds_of_meshes_may_share_the_accessors_of_their_vertices() {
    let loaded = shared(340, 34_000, |_| [0, 1]);
    assert_eq!(loaded.mesh.triangles().len(), 340);
    assert_eq!(loaded.mesh.positions().len(), 3 * 340);
    assert_eq!(loaded.report.unused_vertices, 34_000 - 3 * 340);
    assert_eq!(loaded.report.normals.stored, 3 * 340);
}

#[test]
fn accessors_that_are_the_same_count_once() {
    let loaded = shared(340, 34_000, |mesh| [2 * mesh, 2 * mesh + 1]);
    assert_eq!(loaded.mesh.positions().len(), 3 * 340);
    assert_eq!(loaded.report.unused_vertices, 34_000 - 3 * 340);
}

#[test]
fn vertices_that_no_index_names_may_be_anything_and_are_counted() {
    let mut data = data();
    let [infinite, far] = [f32::INFINITY, 1e30].map(f32::to_le_bytes);
    data.bytes[36..40].copy_from_slice(&infinite);
    data.bytes[40..44].copy_from_slice(&far);
    // The first triangle does not name vertex 3.
    let accessors = ACCESSORS.replacen("\"count\":6", "\"count\":3", 1);
    let text = json(&data, &accessors, &primitive(2), "{\"mesh\":0}", true);
    let loaded = load_text(&text).unwrap();
    assert_eq!(loaded.mesh.bounds().max, glam::DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(
        loaded.report.warnings,
        ["1 vertex is in no face and was left out"]
    );
}

#[test]
fn corners_used_again_have_a_limit() {
    // A hundred thousand zeros for indices, made of nothing, in very many meshes.
    let zeros = "{\"componentType\":5125,\"count\":60000,\"type\":\"SCALAR\",\"sparse\":{\"count\":0,\
                 \"indices\":{\"bufferView\":2,\"componentType\":5121},\"values\":{\"bufferView\":4}}}";
    let accessors = format!("{ACCESSORS},{zeros}");
    let primitives = vec![primitive(5); 400].join(",");
    let text = json(&data(), &accessors, &primitives, "{\"mesh\":0}", true);
    let error = load_text(&text).unwrap_err();
    assert!(
        error.contains("accessor 5: it uses 60000 corners again, too many for a file of this size"),
        "{error}"
    );
}

#[test]
fn a_wrong_corner_is_named_with_what_lenient_skips() {
    let five = ACCESSORS.replacen("\"count\":6", "\"count\":5", 1);
    let text = json(&data(), &five, &primitive(2), "{\"mesh\":0}", true);
    let what = "mesh 0 \"square\", primitive 0: its 5 corners are no whole triangles";
    assert_eq!(
        load_text(&text).unwrap_err(),
        format!("x.gltf: {what}; --lenient skips the last 2")
    );
    let lenient = Loader::new().lenient(true);
    let report = lenient.load_bytes(text.into(), "x.gltf").unwrap().report;
    assert_eq!((report.polygons, report.skipped_faults), (1, 1));
    assert_eq!(
        report.warnings[1],
        format!("1 wrong element was skipped: {what}")
    );
    // A primitive that cannot be read at all, beside one that can.
    let both = format!("{},{{\"attributes\":{{\"POSITION\":9}}}}", primitive(2));
    let text = json(&data(), ACCESSORS, &both, "{\"mesh\":0}", true);
    let error = load_text(&text).unwrap_err();
    let what = "mesh 0 \"square\", primitive 1: accessor 9: there is no such accessor";
    assert_eq!(
        error,
        format!("x.gltf: {what}; --lenient skips the primitive")
    );
    let report = lenient.load_bytes(text.into(), "x.gltf").unwrap().report;
    assert_eq!((report.polygons, report.skipped_faults), (2, 1));
    // A corner of a vertex that is not there.
    let mut wrong = data();
    let at = wrong.bytes.len() - 24;
    wrong.bytes[at] = 9;
    let text = json(&wrong, ACCESSORS, &primitive(4), "{\"mesh\":0}", true);
    let error = load_text(&text).unwrap_err();
    assert!(
        error.ends_with(
            "it names vertex 9, but there are only 4 (0 is the first); --lenient skips the triangle"
        ),
        "{error}"
    );
    let report = lenient.load_bytes(text.into(), "x.gltf").unwrap().report;
    assert_eq!((report.polygons, report.skipped_faults), (1, 1));
    // With nothing left there is no mesh.
    let text = json(&data(), ACCESSORS, &primitive(9), "{\"mesh\":0}", true);
    let error = lenient
        .load_bytes(text.into(), "x.gltf")
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("; nothing is left"), "{error}");
}
