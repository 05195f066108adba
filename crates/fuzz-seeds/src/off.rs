//! OFF files.

use super::{File, Shape, cone, prism, torus, words};

pub fn files() -> Vec<File> {
    let plain = text("OFF\n", &prism(), "", "");
    vec![
        ("windows", plain.replace('\n', "\r\n").into()),
        ("polygons", plain.into()),
        ("on one line", text("OFF ", &torus(), "", "").into()),
        ("normals", text("NOFF\n", &cone(), "", "").into()),
        (
            "colours",
            text("COFF # a comment\n\n", &prism(), " 0.5 0 1 1", " 255 0 0").into(),
        ),
        ("homogeneous", text("4OFF\n", &prism(), " 2", "").into()),
        (
            "texture",
            text("STOFF\n", &prism(), " 0.25 1e-3", " # a face").into(),
        ),
        ("marked", text("\u{feff}OFF\n", &prism(), "", "").into()),
        (
            "on one line",
            text("CSTOFF\n", &prism(), " 0.5 0 1 0.25 1", "")
                .replace('\n', " ")
                .into(),
        ),
        ("glued", text("OFF", &prism(), "", "").into()),
        (
            "any white space",
            text("off\n", &prism(), "", "").replace(' ', "\r").into(),
        ),
        (
            "normals and colours",
            text("CNOFF\n", &cone(), " 0.5 0 1 1", "").into(),
        ),
        ("colours and normals", coloured(&cone()).into()),
    ]
}

/// Colours before the normals, as MeshLab writes them.
fn coloured(shape: &Shape) -> String {
    let vertices = shape.positions.iter().zip(&shape.normals);
    let vertices = vertices.map(|(&p, &n)| format!("{} 200 30 30 255 {}\n", words(p), words(n)));
    let face = |face: &Vec<u32>| format!("{} {}\n", face.len(), words(face));
    let faces: String = shape.faces.iter().map(face).collect();
    format!(
        "NCOFF\n{} {} 0\n{}{faces}",
        shape.positions.len(),
        shape.faces.len(),
        vertices.collect::<String>()
    )
}

fn text(head: &str, shape: &Shape, behind_vertex: &str, behind_face: &str) -> String {
    let (vertices, faces) = (shape.positions.len(), shape.faces.len());
    let mut text = format!("{head}{vertices} {faces} 0\n");
    for (i, p) in shape.positions.iter().enumerate() {
        let normal = shape.normals.get(i).into_iter().flatten();
        text += &(words(p.iter().chain(normal)) + behind_vertex + "\n");
    }
    for face in &shape.faces {
        text += &format!("{} {}{behind_face}\n", face.len(), words(face));
    }
    text
}
