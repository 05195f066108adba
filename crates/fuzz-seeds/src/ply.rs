//! PLY files.

use super::{File, Shape, ball, blob, cone, prism, torus, words};

pub fn files() -> Vec<File> {
    vec![
        ("ascii", ascii(&prism()).into()),
        ("ascii with normals", ascii(&cone()).into()),
        (
            "ascii windows",
            ascii(&torus()).replace('\n', "\r\n").into(),
        ),
        (
            "little endian",
            binary(&blob(), f32::to_le_bytes, u32::to_le_bytes, "little"),
        ),
        (
            "big endian",
            binary(&prism(), f32::to_be_bytes, u32::to_be_bytes, "big"),
        ),
        (
            "with normals",
            binary(&ball(), f32::to_le_bytes, u32::to_le_bytes, "little"),
        ),
        ("other order and types", odd(&prism())),
        ("strips", STRIPS.into()),
        ("many elements", MANY.into()),
        (
            "ascii marked",
            ["\u{feff}", &ascii(&cone())].concat().into(),
        ),
        ("ascii on many lines", ascii_words(&cone(), "\r\n").into()),
        ("ascii on one line", ascii_words(&prism(), "\t").into()),
        ("invalid points", invalid(&prism()).into()),
    ]
}

/// With this between all numbers.
fn ascii_words(shape: &Shape, between: &str) -> String {
    let text = ascii(shape);
    let (header, body) = text.split_once("end_header\n").expect("a header ends");
    let words: Vec<&str> = body.split_ascii_whitespace().collect();
    format!("{header}end_header\n{}", words.join(between))
}

/// A scan with a row of points that no face names.
fn invalid(shape: &Shape) -> String {
    let mut shape = shape.clone();
    shape.positions.extend([[f32::NAN; 3]; 5]);
    ascii(&shape)
}

fn header(shape: &Shape, format: &str) -> String {
    let normals = match shape.normals.is_empty() {
        true => "",
        false => "property float nx\nproperty float ny\nproperty float nz\n",
    };
    format!(
        "ply\nformat {format} 1.0\ncomment a seed\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\n{normals}element face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        shape.positions.len(),
        shape.faces.len()
    )
}

/// The numbers of each vertex.
fn rows(shape: &Shape) -> impl Iterator<Item = Vec<f32>> {
    shape.positions.iter().enumerate().map(|(i, p)| {
        let normal = shape.normals.get(i);
        p.iter()
            .chain(normal.into_iter().flatten())
            .copied()
            .collect()
    })
}

fn ascii(shape: &Shape) -> String {
    let mut text = header(shape, "ascii");
    text.extend(rows(shape).map(|row| words(row) + "\n"));
    text.extend(
        shape
            .faces
            .iter()
            .map(|face| format!("{} {}\n", face.len(), words(face))),
    );
    text
}

fn binary(
    shape: &Shape,
    float: fn(f32) -> [u8; 4],
    int: fn(u32) -> [u8; 4],
    endian: &str,
) -> Vec<u8> {
    let mut bytes = header(shape, &format!("binary_{endian}_endian")).into_bytes();
    bytes.extend(rows(shape).flatten().flat_map(float));
    for face in &shape.faces {
        bytes.push(face.len() as u8);
        bytes.extend(face.iter().copied().flat_map(int));
    }
    bytes
}

/// Faces before vertices, colours between the coordinates, eight bytes a coordinate, short indices
/// under the other name.
fn odd(shape: &Shape) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement face {}\nproperty uchar red\n\
         property list ushort ushort vertex_index\nelement vertex {}\nproperty double z\n\
         property uchar red\nproperty double x\nproperty short s\nproperty double y\nend_header\n",
        shape.faces.len(),
        shape.positions.len(),
    )
    .into_bytes();
    for face in &shape.faces {
        bytes.push(255);
        bytes.extend((face.len() as u16).to_le_bytes());
        bytes.extend(face.iter().flat_map(|&v| (v as u16).to_le_bytes()));
    }
    for &[x, y, z] in &shape.positions {
        bytes.extend(f64::from(z).to_le_bytes());
        bytes.push(128);
        bytes.extend(f64::from(x).to_le_bytes());
        bytes.extend(7i16.to_le_bytes());
        bytes.extend(f64::from(y).to_le_bytes());
    }
    bytes
}

const STRIPS: &str = "\
ply
format ascii 1.0
element vertex 5
property float x
property float y
property float z
element tristrips 1
property list int int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
1 1 0
1e0 1. .5
9 0 1 2 4 -1 2 1 1 0
";

const MANY: &str = "\
ply
format ascii 1.0
obj_info none
element camera 1
property double fov
property list uchar float matrix
element vertex 3
property char x
property uchar y
property int8 z
property uint8 red

element edge 1
property int vertex1
property int vertex2
element face 2
property uint flags
property list uint8 uint32 vertex_indices
property list uchar float texcoord
element nothing 0
property int x
end_header
0.5 4 1 0 0 1
0 0 0 255
1 0 0 255

0 1 -1 255
0 1
7 3 0 1 2 6 0 0 1 0 0 1
7 2 0 1 0
";
