//! glTF files, as text and binary.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{File, Shape, ball, cone, cylinder, torus};

/// A file being put together: each accessor has a view of its own.
#[derive(Default)]
struct Builder {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Builder {
    fn view(&mut self, bytes: impl IntoIterator<Item = u8>) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - offset;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#
        ));
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, component: u32, count: usize, rest: &str) -> usize {
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"count":{count},{rest}}}"#
        ));
        self.accessors.len() - 1
    }

    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let view = self.view(vectors.iter().flatten().flat_map(|x| x.to_le_bytes()));
        self.accessor(view, 5126, vectors.len(), r#""type":"VEC3""#)
    }

    /// Indices of one, two or four bytes.
    fn indices(&mut self, indices: &[u32], width: usize) -> usize {
        let bytes = indices
            .iter()
            .flat_map(|i| i.to_le_bytes().into_iter().take(width));
        let view = self.view(bytes);
        let component = [0, 5121, 5123, 0, 5125][width];
        self.accessor(view, component, indices.len(), r#""type":"SCALAR""#)
    }

    fn primitive(&mut self, shape: &Shape, width: usize) -> String {
        let positions = self.vectors(&shape.positions);
        let normals = self.vectors(&shape.normals);
        let indices = self.indices(&shape.indices(), width);
        format!(
            r#"{{"attributes":{{"POSITION":{positions},"NORMAL":{normals}}},"indices":{indices}}}"#
        )
    }

    fn json(&self, meshes: &str, rest: &str, uri: &str) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"meshes":[{meshes}],{rest},"accessors":[{}],"bufferViews":[{}],"buffers":[{{{uri}"byteLength":{}}}]}}"#,
            self.accessors.join(","),
            self.views.join(","),
            self.bytes.len()
        )
    }

    /// A text file, its data encoded in it.
    fn text(&self, meshes: &str, rest: &str) -> Vec<u8> {
        let data = STANDARD.encode(&self.bytes);
        let uri = format!(r#""uri":"data:application/octet-stream;base64,{data}","#);
        self.json(meshes, rest, &uri).into_bytes()
    }

    /// A binary file.
    fn binary(&self, meshes: &str, rest: &str) -> Vec<u8> {
        let mut text = self.json(meshes, rest, "").into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = |n: usize| (n as u32).to_le_bytes();
        [
            b"glTF",
            &[2, 0, 0, 0][..],
            &length(28 + text.len() + self.bytes.len()),
            &length(text.len()),
            b"JSON",
            &text,
            &length(self.bytes.len()),
            b"BIN\0",
            &self.bytes,
        ]
        .concat()
    }
}

const ONE_NODE: &str = r#""nodes":[{"mesh":0}]"#;

fn mesh(primitives: &[String]) -> String {
    format!(r#"{{"name":"a","primitives":[{}]}}"#, primitives.join(","))
}

pub fn files() -> Vec<File> {
    let mut files = Vec::new();
    for (name, width) in [("bytes", 1), ("shorts", 2), ("ints", 4)] {
        let mut builder = Builder::default();
        let mesh = mesh(&[builder.primitive(&ball(), width)]);
        files.push((name, builder.text(&mesh, ONE_NODE)));
    }
    let mut builder = Builder::default();
    let torus = mesh(&[builder.primitive(&torus(), 2)]);
    files.push(("binary", builder.binary(&torus, ONE_NODE)));
    files.push(("copies", builder.binary(&torus, COPIES)));
    files.push(("tree", builder.text(&torus, TREE)));
    files.push(("several primitives", primitives()));
    files.push(("sparse", sparse()));
    files.push(("modes", modes()));
    files.push(("quantized", quantized()));
    files.push(("shared accessors", shared()));
    files.push(("skin", skin()));
    files.push(("morph targets", morph()));
    files
}

/// Meshes of a few triangles each of the same vertices, which have more that nothing names.
fn shared() -> Vec<u8> {
    let mut builder = Builder::default();
    let shape = cone();
    let mut positions = shape.positions.clone();
    positions.extend([[f32::NAN, 1e30, 0.0]; 3]);
    let mut normals = shape.normals.clone();
    normals.extend([[0.0; 3]; 3]);
    let (positions, normals) = (builder.vectors(&positions), builder.vectors(&normals));
    let meshes: Vec<String> = (shape.indices().chunks(9))
        .map(|indices| {
            let indices = builder.indices(indices, 1);
            mesh(&[format!(
                r#"{{"attributes":{{"POSITION":{positions},"NORMAL":{normals}}},"indices":{indices}}}"#
            )])
        })
        .collect();
    let nodes: Vec<String> = (0..meshes.len())
        .map(|n| format!(r#"{{"mesh":{n}}}"#))
        .collect();
    let nodes = format!(r#""nodes":[{}]"#, nodes.join(","));
    builder.binary(&meshes.join(","), &nodes)
}

/// Two joints, one in the other, and a node whose own transform does not matter.
fn skin() -> Vec<u8> {
    let mut builder = Builder::default();
    let shape = cylinder();
    let count = shape.positions.len();
    let primitive = builder.primitive(&shape, 2);
    let view = builder.view((0..count).flat_map(|v| [0, (v % 2) as u8, 1, 0]));
    let joints = builder.accessor(view, 5121, count, r#""type":"VEC4""#);
    let view = builder.view((0..count).flat_map(|v| [200, (v % 56) as u8, 0, 0]));
    let weights = builder.accessor(view, 5121, count, r#""normalized":true,"type":"VEC4""#);
    let mut matrices = [0.0f32; 32];
    for k in 0..4 {
        matrices[5 * k] = 1.0;
        matrices[16 + 5 * k] = 1.0;
    }
    matrices[16 + 13] = -2.0;
    let view = builder.view(matrices.into_iter().flat_map(f32::to_le_bytes));
    let bind = builder.accessor(view, 5126, 2, r#""type":"MAT4""#);
    let moved = format!(r#""attributes":{{"JOINTS_0":{joints},"WEIGHTS_0":{weights},"#);
    let primitive = primitive.replace(r#""attributes":{"#, &moved);
    let rest = format!(
        r#""skins":[{{"joints":[1,2],"inverseBindMatrices":{bind}}}],"nodes":[{{"mesh":0,"skin":0,"scale":[100,100,100]}},{{"children":[2]}},{{"translation":[0,2,0],"rotation":[0,0.3826834,0,0.9238795]}}]"#
    );
    builder.text(&mesh(&[primitive]), &rest)
}

/// Two targets with default weights, one of them sparse, and a node with weights of its own.
fn morph() -> Vec<u8> {
    let mut builder = Builder::default();
    let shape = ball();
    let count = shape.positions.len();
    let primitive = builder.primitive(&shape, 1);
    let all = builder.vectors(&vec![[0.5, 0.0, 0.25]; count]);
    let at = builder.view([0, 2, 3]);
    let values = builder.view([0.5f32; 9].into_iter().flat_map(f32::to_le_bytes));
    builder.accessors.push(format!(
        r#"{{"componentType":5126,"count":{count},"type":"VEC3","sparse":{{"count":3,"indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{values}}}}}}}"#
    ));
    let some = builder.accessors.len() - 1;
    let targets =
        format!(r#","targets":[{{"POSITION":{all}}},{{"POSITION":{some},"NORMAL":{all}}}]}}"#);
    let primitive = primitive.strip_suffix('}').expect("an object").to_owned() + &targets;
    let weights = r#"{"weights":[0.5,1],"#;
    let mesh = mesh(&[primitive]).replacen('{', weights, 1);
    builder.text(&mesh, r#""nodes":[{"mesh":0},{"mesh":0,"weights":[0,2]}]"#)
}

/// One mesh at many places, and without a scene.
const COPIES: &str = r#""nodes":[{"mesh":0},{"mesh":0,"translation":[3,0,0]},{"mesh":0,"scale":[-1,2,1],"translation":[0,3,0]},{"mesh":0,"rotation":[0,0.7071068,0,0.7071068]}]"#;

/// Nodes in nodes, a mirroring matrix, a camera and a lamp.
const TREE: &str = r#""scene":1,"scenes":[{"nodes":[]},{"nodes":[0,3]}],"nodes":[{"children":[1,2],"matrix":[-1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]},{"mesh":0},{"camera":0,"translation":[0,0,4]},{"extensions":{"KHR_lights_punctual":{"light":0}}}],"cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}],"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"directional","intensity":3}]}}"#;

fn primitives() -> Vec<u8> {
    let mut builder = Builder::default();
    let positions = builder.vectors(&cone().positions);
    let [first, second] = [4, 2].map(|width| builder.indices(&cone().indices(), width));
    let primitives = [
        builder.primitive(&cylinder(), 2),
        format!(r#"{{"attributes":{{"POSITION":{positions}}},"indices":{first}}}"#),
        format!(r#"{{"attributes":{{"POSITION":{positions}}},"indices":{second},"mode":1}}"#),
    ];
    let meshes = [mesh(&primitives), mesh(&primitives[1..2])].join(",");
    builder.binary(&meshes, r#""nodes":[{"mesh":1},{"mesh":0}]"#)
}

/// Three vertices of a ball moved, and a triangle that is zeros but for what is put in.
fn sparse() -> Vec<u8> {
    let mut builder = Builder::default();
    let shape = ball();
    let view = builder.view(
        shape
            .positions
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes()),
    );
    let at = builder.view([0, 1, 2]);
    let values = builder.view([1.5f32; 9].into_iter().flat_map(f32::to_le_bytes));
    let sparse = format!(
        r#""type":"VEC3","sparse":{{"count":3,"indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{values}}}}}"#
    );
    let moved = builder.accessor(view, 5126, shape.positions.len(), &sparse);
    builder
        .accessors
        .push(format!(r#"{{"componentType":5126,"count":6,{sparse}}}"#));
    let zeros = builder.accessors.len() - 1;
    let indices = builder.indices(&shape.indices(), 1);
    let primitives = [
        format!(r#"{{"attributes":{{"POSITION":{moved}}},"indices":{indices}}}"#),
        format!(r#"{{"attributes":{{"POSITION":{zeros}}}}}"#),
    ];
    builder.text(&mesh(&primitives), ONE_NODE)
}

/// Strips and fans.
fn modes() -> Vec<u8> {
    let mut builder = Builder::default();
    let positions = builder.vectors(&ball().positions);
    let indices = builder.indices(&[0, 1, 2, 2, 3, 4, 5, 5, 1], 1);
    let primitive = |mode: u32, indices: &str| {
        format!(r#"{{"attributes":{{"POSITION":{positions}}},"mode":{mode}{indices}}}"#)
    };
    let indices = format!(r#","indices":{indices}"#);
    let primitives = [(5, &*indices), (6, &indices), (5, ""), (6, "")];
    builder.text(
        &mesh(&primitives.map(|(mode, i)| primitive(mode, i))),
        ONE_NODE,
    )
}

/// Whole numbers for positions and normals.
fn quantized() -> Vec<u8> {
    let mut builder = Builder::default();
    let shape = ball();
    let numbers = |v: &[[f32; 3]], most: f32| -> Vec<i16> {
        v.iter().flatten().map(|x| (x * most) as i16).collect()
    };
    let positions = numbers(&shape.positions, 3000.0);
    let view = builder.view(positions.into_iter().flat_map(i16::to_le_bytes));
    let count = shape.positions.len();
    let positions = builder.accessor(view, 5122, count, r#""type":"VEC3""#);
    let normals = numbers(&shape.normals, 127.0);
    let view = builder.view(normals.into_iter().map(|n| n as u8));
    let normals = builder.accessor(view, 5120, count, r#""normalized":true,"type":"VEC3""#);
    let indices = builder.indices(&shape.indices(), 1);
    let primitive = format!(
        r#"{{"attributes":{{"POSITION":{positions},"NORMAL":{normals}}},"indices":{indices}}}"#
    );
    let rest = format!(
        r#""extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"],{ONE_NODE}"#
    );
    builder.text(&mesh(&[primitive]), &rest)
}
