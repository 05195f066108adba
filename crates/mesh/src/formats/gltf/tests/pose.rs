//! Skins and morph targets.

use glam::{DVec3, Vec3};

use super::{ACCESSORS, Data, data, json, load_text, primitive};
use crate::{Loaded, Mesh};

/// The square of [`data`], moved by two joints: the first two vertices by the first, the others by
/// both in equal shares. Accessors: 5 joints, 6 weights, 7 inverse bind matrices.
fn skinned_data() -> (Data, String) {
    let mut data = data();
    let joints = data.view(&[0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]);
    let weights = data.view(&[255, 0, 0, 0, 255, 0, 0, 0, 127, 127, 0, 0, 127, 127, 0, 0]);
    let mut bind = [0.0; 32];
    for k in 0..4 {
        bind[5 * k] = 1.0;
        bind[16 + 5 * k] = 1.0;
    }
    // The second joint was bound at (0, 0, 3).
    bind[16 + 14] = -3.0;
    let bind = data.floats(&bind);
    let accessors = format!(
        "{ACCESSORS},\
         {{\"bufferView\":{joints},\"componentType\":5121,\"count\":4,\"type\":\"VEC4\"}},\
         {{\"bufferView\":{weights},\"componentType\":5121,\"normalized\":true,\"count\":4,\
         \"type\":\"VEC4\"}},\
         {{\"bufferView\":{bind},\"componentType\":5126,\"count\":2,\"type\":\"MAT4\"}}"
    );
    (data, accessors)
}

const SKINNED: &str = "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":5,\"WEIGHTS_0\":6},\
                       \"indices\":2}";

fn skinned_text(primitives: &str, nodes: &str, skin: &str) -> String {
    let (data, accessors) = skinned_data();
    let text = json(&data, &accessors, primitives, nodes, true);
    text.replacen('{', &format!("{{\"skins\":[{skin}],"), 1)
}

fn skinned(nodes: &str, skin: &str) -> Loaded {
    load_text(&skinned_text(SKINNED, nodes, skin)).unwrap()
}

/// The places of the square's four vertices.
fn corners(mesh: &Mesh) -> [Vec3; 4] {
    let [a, b, c] = mesh.triangle_positions(0);
    [a, b, c, mesh.triangle_positions(1)[2]]
}

fn assert_at(mesh: &Mesh, expected: [[f32; 3]; 4]) {
    for (found, expected) in corners(mesh).into_iter().zip(expected) {
        assert!(
            found.distance(expected.into()) < 1e-6,
            "{found} is not {expected:?}"
        );
    }
}

const SKIN: &str = "{\"joints\":[1,2],\"inverseBindMatrices\":7}";

#[test]
fn the_own_transform_of_a_node_with_a_skin_does_not_matter() {
    let turned = "{\"mesh\":0,\"skin\":0,\"scale\":[100,100,100],\
                  \"rotation\":[0.7071068,0,0,0.7071068]}";
    let bound = "{\"name\":\"first\"},{\"translation\":[0,0,3]}";
    let loaded = skinned(&format!("{turned},{bound}"), SKIN);
    let square = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_at(&loaded.mesh, square);
    assert_eq!(loaded.report.warnings, [] as [String; 0]);
    // Nor does that of its parents.
    let nodes = format!("{turned},{bound},{{\"children\":[0],\"translation\":[7,7,7]}}");
    assert_at(&skinned(&nodes, SKIN).mesh, square);
}

#[test]
fn vertices_follow_their_joints_by_weight() {
    // The second joint moves by (2, 0, 4) from where it was bound, half of it counts.
    let nodes = "{\"mesh\":0,\"skin\":0},{},{\"translation\":[2,0,7]}";
    let mesh = skinned(nodes, SKIN).mesh;
    assert_at(
        &mesh,
        [[0., 0., 0.], [1., 0., 0.], [2., 1., 2.], [1., 1., 2.]],
    );
    // Joints stand in each other, and need not be in the scene.
    let nodes = "{\"mesh\":0,\"skin\":0},{\"children\":[2],\"translation\":[0,5,0]},\
                 {\"translation\":[0,0,3]}";
    let text = skinned_text(SKINNED, nodes, SKIN);
    let scene = text.replacen('{', "{\"scenes\":[{\"nodes\":[0]}],", 1);
    for text in [text, scene] {
        let mesh = load_text(&text).unwrap().mesh;
        assert_at(
            &mesh,
            [[0., 5., 0.], [1., 5., 0.], [1., 6., 0.], [0., 6., 0.]],
        );
    }
}

#[test]
fn normals_and_winding_follow_the_joints() {
    // Both joints turn a quarter around x: z points along -y.
    let turn = "\"rotation\":[0.7071068,0,0,0.7071068]";
    let nodes = format!("{{\"mesh\":0,\"skin\":0}},{{{turn}}},{{\"translation\":[0,-3,0],{turn}}}");
    let mesh = skinned(&nodes, SKIN).mesh;
    assert_at(
        &mesh,
        [[0., 0., 0.], [1., 0., 0.], [1., 0., 1.], [0., 0., 1.]],
    );
    assert!(mesh.normals().iter().all(|n| n.distance(-Vec3::Y) < 1e-6));
    // Mirrored along x: the front stays the front.
    let nodes = "{\"mesh\":0,\"skin\":0},{\"scale\":[-1,1,1]},\
                 {\"scale\":[-1,1,1],\"translation\":[0,0,3]}";
    let loaded = skinned(nodes, SKIN);
    let [a, b, c] = loaded.mesh.triangle_positions(0);
    assert!((b - a).cross(c - a).z > 0.0);
    assert_eq!(loaded.report.normals.against_face, 0);
}

#[test]
fn a_skin_without_bind_matrices_and_vertices_without_weights_are_placed() {
    let nodes = "{\"mesh\":0,\"skin\":0},{\"translation\":[0,5,0]},{\"translation\":[0,5,0]}";
    let text = skinned_text(SKINNED, nodes, "{\"joints\":[1,2]}");
    // The weights of zeros in place of the second accessor.
    for text in [
        text.clone(),
        text.replace("\"WEIGHTS_0\":6", "\"WEIGHTS_0\":5"),
    ] {
        let mesh = load_text(&text).unwrap().mesh;
        assert_at(
            &mesh,
            [[0., 5., 0.], [1., 5., 0.], [1., 6., 0.], [0., 6., 0.]],
        );
    }
}

#[test]
fn a_skin_at_several_nodes_and_poses_is_read_once_a_pose() {
    let nodes = "{\"mesh\":0,\"skin\":0},{},{\"translation\":[0,0,3]},{\"mesh\":0,\"skin\":1},\
                 {\"mesh\":0,\"translation\":[9,0,0]}";
    let mesh = skinned(nodes, &format!("{SKIN},{{\"joints\":[2,1]}}")).mesh;
    let first = |triangle: usize| mesh.triangle_positions(triangle)[0].to_array();
    assert_eq!(mesh.triangles().len(), 6);
    assert_eq!(
        [first(0), first(2), first(4)],
        [[0., 0., 0.], [0., 0., 3.], [9., 0., 0.]]
    );
}

#[test]
fn wrong_skins_are_refused_by_the_place_that_is_wrong() {
    let nodes = "{\"mesh\":0,\"skin\":0},{},{}";
    let error = |skin: &str| load_text(&skinned_text(SKINNED, nodes, skin)).unwrap_err();
    assert_eq!(
        error("{\"joints\":[1,2,1],\"inverseBindMatrices\":7}"),
        "x.gltf: skin 0: it has 2 inverse bind matrices for 3 joints"
    );
    assert_eq!(
        error("{\"joints\":[1,9]}"),
        "x.gltf: skin 0: there is no node 9"
    );
    assert_eq!(
        error("{\"joints\":[1]}"),
        "x.gltf: mesh 0 \"square\", primitive 0: vertex 2 names joint 1, but its skin has only 1 (0 \
         is the first); --lenient skips the triangle"
    );
    let nodes = "{\"mesh\":0,\"skin\":4},{},{}";
    let error = load_text(&skinned_text(SKINNED, nodes, SKIN)).unwrap_err();
    assert_eq!(error, "x.gltf: there is no skin 4");
    // A joint that is its own ancestor, outside the scene.
    let nodes = "{\"mesh\":0,\"skin\":0},{\"children\":[2]},{\"children\":[1]}";
    let text = skinned_text(SKINNED, nodes, SKIN);
    let text = text.replacen('{', "{\"scenes\":[{\"nodes\":[0]}],", 1);
    let error = load_text(&text).unwrap_err();
    assert!(error.contains("is its own parent"), "{error}");
}

#[test]
fn a_skin_on_a_mesh_without_joints_is_told_and_the_node_places_it() {
    let nodes = "{\"mesh\":0,\"skin\":0,\"translation\":[0,5,0]},{},{}";
    let loaded = load_text(&skinned_text(&primitive(2), nodes, SKIN)).unwrap();
    assert_eq!(corners(&loaded.mesh)[0], Vec3::new(0.0, 5.0, 0.0));
    assert_eq!(
        loaded.report.warnings,
        ["1 meshes with a skin do not say which joints move them; they are where their nodes are"]
    );
}

#[test]
fn a_primitive_without_joints_is_where_the_node_of_its_skin_is() {
    let both = format!("{SKINNED},{}", primitive(2));
    let nodes = "{\"mesh\":0,\"skin\":0,\"translation\":[0,5,0]},{\"translation\":[2,0,0]},\
                 {\"translation\":[2,0,3]},{\"mesh\":0,\"skin\":0,\"translation\":[0,7,0]}";
    let loaded = load_text(&skinned_text(&both, nodes, SKIN)).unwrap();
    let first = |triangle: usize| loaded.mesh.triangle_positions(triangle)[0].to_array();
    assert_eq!([0, 4].map(first), [[2., 0., 0.]; 2]);
    assert_eq!([2, 6].map(first), [[0., 5., 0.], [0., 7., 0.]]);
    assert_eq!(loaded.report.warnings, [] as [String; 0]);
}

/// The square with two morph targets: the first lifts vertex 2 by 4 and tilts its normal, the second
/// moves all along x by 1.
fn morphed(mesh_weights: &str, node: &str) -> Result<Loaded, String> {
    let mut data = data();
    let lift = data.floats(&[0., 0., 0., 0., 0., 0., 0., 0., 4., 0., 0., 0.]);
    let tilt = data.floats(&[0., 0., 0., 0., 0., 0., 1., 0., 0., 0., 0., 0.]);
    let along = data.floats(&[1., 0., 0.].repeat(4));
    let vectors = |view: usize| {
        format!("{{\"bufferView\":{view},\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}}")
    };
    let accessors = [
        ACCESSORS.to_owned(),
        vectors(lift),
        vectors(tilt),
        vectors(along),
    ]
    .join(",");
    let primitive = "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2,\
                     \"targets\":[{\"POSITION\":5,\"NORMAL\":6},{\"POSITION\":7}]}";
    let text = json(&data, &accessors, primitive, node, true);
    load_text(&text.replacen(
        "\"primitives\"",
        &format!("{mesh_weights}\"primitives\""),
        1,
    ))
}

#[test]
fn morph_targets_count_by_their_default_weights() {
    let mesh = |weights: &str, node: &str| morphed(weights, node).unwrap().mesh;
    let square = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_at(&mesh("", "{\"mesh\":0}"), square);
    assert_at(&mesh("\"weights\":[0,0],", "{\"mesh\":0}"), square);
    let moved = [[2., 0., 0.], [3., 0., 0.], [3., 1., 2.], [2., 1., 0.]];
    let posed = mesh("\"weights\":[0.5,2],", "{\"mesh\":0}");
    assert_at(&posed, moved);
    let tilted = Vec3::new(0.5, 0.0, 1.0).normalize();
    assert!(posed.triangle_normals(0)[2].distance(tilted) < 1e-6);
    // The node's own weights come first; the transform of the node comes after them.
    let node = "{\"mesh\":0,\"weights\":[0.5,2],\"translation\":[0,0,1]}";
    let above = moved.map(|[x, y, z]| [x, y, z + 1.0]);
    assert_at(&mesh("\"weights\":[9,9],", node), above);
}

#[test]
fn one_mesh_in_several_poses_is_several_shapes() {
    let nodes = "{\"mesh\":0},{\"mesh\":0,\"weights\":[0,1]},{\"mesh\":0,\"weights\":[0,2]}";
    let mesh = morphed("", nodes).unwrap().mesh;
    let first = |triangle: usize| mesh.triangle_positions(triangle)[0].x;
    assert_eq!([first(0), first(2), first(4)], [0.0, 1.0, 2.0]);
    let error = morphed("\"weights\":[1],", "{\"mesh\":0}").map(|loaded| loaded.mesh.bounds().max);
    assert_eq!(error.unwrap(), DVec3::new(1.0, 1.0, 4.0));
}
