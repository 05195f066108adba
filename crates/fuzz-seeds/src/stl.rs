//! STL files.

use super::{File, Shape, ball, blob, cone, torus, words};

pub fn files() -> Vec<File> {
    let of = |shape| text(&shape, "a solid");
    vec![
        ("text", of(ball()).into()),
        ("text of several solids", (of(cone()) + &of(ball())).into()),
        ("text in capitals", of(ball()).to_uppercase().into()),
        ("text windows", of(ball()).replace('\n', "\r\n").into()),
        (
            "text without an end",
            of(ball())
                .replace("endsolid", "")
                .replace("a solid", "")
                .into(),
        ),
        ("binary", binary(&torus(), b"binary")),
        (
            "binary that calls itself solid",
            binary(&blob(), b"solid or not"),
        ),
        (
            "binary with more behind",
            [binary(&ball(), b"x"), vec![0; 9]].concat(),
        ),
        (
            "text padded",
            (of(cone()).replace("a solid", "a\0\0\0") + "\0\0\x1a").into(),
        ),
        (
            "text on one line",
            of(torus())
                .split_ascii_whitespace()
                .collect::<Vec<_>>()
                .join(" ")
                .into(),
        ),
        (
            "text coloured",
            of(ball())
                .replace("endloop", "endloop\ncolor 0.5 0 1")
                .replace("endfacet", "end facet")
                .into(),
        ),
        ("text marked", ["\u{feff}", &of(ball())].concat().into()),
        ("binary with attributes", attributes(&torus())),
        ("binary without a number", without_number(&ball(), 0)),
        ("binary with all ones", without_number(&ball(), u32::MAX)),
    ]
}

/// Bytes behind each facet, as its attribute byte count says.
fn attributes(shape: &Shape) -> Vec<u8> {
    let bytes = binary(shape, b"attributes");
    let (head, facets) = bytes.split_at(84);
    let facets = facets.chunks(50).enumerate().flat_map(|(number, facet)| {
        let length = number % 7;
        let attributes = vec![number as u8; length];
        [&facet[..48], &(length as u16).to_le_bytes(), &attributes].concat()
    });
    head.iter().copied().chain(facets).collect()
}

/// As programs leave the number of facets that write before they have counted.
fn without_number(shape: &Shape, number: u32) -> Vec<u8> {
    let mut bytes = binary(shape, b"streamed");
    bytes[80..84].copy_from_slice(&number.to_le_bytes());
    bytes
}

fn facets(shape: &Shape) -> impl Iterator<Item = ([f32; 3], [[f32; 3]; 3])> {
    // Not the facet's own: programs write zeros and worse.
    let normals = [[0.0; 3], [0.0, 0.0, 1.0], [f32::NAN; 3]]
        .into_iter()
        .cycle();
    let corner = |v: u32| shape.positions[v as usize];
    let corners = shape
        .faces
        .iter()
        .map(move |f| [f[0], f[1], f[2]].map(corner));
    normals.zip(corners)
}

fn text(shape: &Shape, name: &str) -> String {
    let mut text = format!("solid {name}\n");
    for (normal, corners) in facets(shape) {
        let vertices = corners
            .map(|p| format!("   vertex {}\n", words(p)))
            .concat();
        text += &format!(
            " facet normal {}\n  outer loop\n{vertices}  endloop\n endfacet\n",
            words(normal)
        );
    }
    text + "endsolid " + name + "\n"
}

fn binary(shape: &Shape, head: &[u8]) -> Vec<u8> {
    let mut bytes = head.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((shape.faces.len() as u32).to_le_bytes());
    for (normal, corners) in facets(shape) {
        let numbers = normal.into_iter().chain(corners.into_iter().flatten());
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}
