//! OBJ files.

use curvetri_bodies::{Body, capped_cone};
use curvetri_mesh::obj_text;

use super::{File, Shape, prism, torus, words};

pub fn files() -> Vec<File> {
    let text = obj_text(&Body::torus(3, 4).mesh());
    let utf16 = |mark: &[u8], unit: fn(u16) -> [u8; 2]| {
        let units = plain(&prism()).encode_utf16().flat_map(unit).collect();
        [mark.to_vec(), units].concat()
    };
    vec![
        ("our own", obj_text(&capped_cone(4, 1.0)).into()),
        ("polygons", plain(&prism()).into()),
        ("triangles", plain(&torus()).into()),
        ("negative indices", negative(&prism()).into()),
        ("continuations", continued(&prism()).into()),
        ("windows", text.replace('\n', "\r\n").into()),
        ("carriage returns", text.replace('\n', "\r").into()),
        ("utf16 le", utf16(b"\xff\xfe", u16::to_le_bytes)),
        ("utf16 be", utf16(b"\xfe\xff", u16::to_be_bytes)),
        ("utf8 mark", ["\u{feff}", &text].concat().into()),
        (
            "latin1",
            [b"# by J\xfcrgen\no \xe9\n", text.as_bytes()].concat(),
        ),
        ("everything", EVERYTHING.into()),
        ("mixed line ends", mixed_ends(&text).into()),
        ("smoothing groups", groups(&prism()).into()),
        ("stray vertices", strays(&prism()).into()),
    ]
}

/// Each line ends in another way than the one before.
fn mixed_ends(text: &str) -> String {
    let ends = ["\r", "\n", "\r\n"].into_iter().cycle();
    let lines = text.lines().zip(ends);
    lines.map(|(line, end)| [line, end].concat()).collect()
}

/// A group for each three faces, and some without.
fn groups(shape: &Shape) -> String {
    let group = |number: usize| match number % 9 {
        0 => "s off\n".into(),
        3 | 6 => format!("s {number}\n"),
        _ => String::new(),
    };
    let faces = shape.faces.iter().enumerate();
    let faces = faces.map(|(number, face)| {
        let corners = words(face.iter().map(|v| v + 1));
        format!("{}f {corners}\n", group(number))
    });
    vertices(shape) + &faces.collect::<String>()
}

/// At map coordinates, with vertices that no face names: far away, and not finite.
fn strays(shape: &Shape) -> String {
    let place = |[x, y, z]: [f32; 3]| {
        let [x, y] = [456_789.25 + f64::from(x), 5_123_456.5 + f64::from(y)];
        format!("v {x} {y} {z}\n")
    };
    let vertices: String = shape.positions.iter().map(|&p| place(p)).collect();
    let face = |face: &Vec<u32>| format!("f {}\n", words(face.iter().map(|v| v + 3)));
    let faces: String = shape.faces.iter().map(face).collect();
    format!("v 0 0 0\nv nan 1e300 inf\n{vertices}{faces}")
}

fn vertices(shape: &Shape) -> String {
    let lines = shape.positions.iter();
    lines.map(|&p| format!("v {}\n", words(p))).collect()
}

fn plain(shape: &Shape) -> String {
    let face = |face: &Vec<u32>| format!("f {}\n", words(face.iter().map(|v| v + 1)));
    vertices(shape) + &shape.faces.iter().map(face).collect::<String>()
}

fn negative(shape: &Shape) -> String {
    let count = shape.positions.len() as i64;
    let face =
        |face: &Vec<u32>| format!("f {}\n", words(face.iter().map(|&v| i64::from(v) - count)));
    vertices(shape) + &shape.faces.iter().map(face).collect::<String>()
}

fn continued(shape: &Shape) -> String {
    let face = |face: &Vec<u32>| {
        let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
        format!("f \\\n{}\n", corners.join(" \\\n  "))
    };
    vertices(shape) + &shape.faces.iter().map(face).collect::<String>()
}

const EVERYTHING: &str = "\
mtllib no such.mtl
g a b
o first
v 0 0 0 1 0.5 0
v 2 0 0 2
v 0 1. 0
v -1e-1 +.5E0 0.25 # a comment
vt 0 0
vt 1 0 0
vn 0 0 1
vn nan -nan(ind) 1.#QNAN
vn 0 0 -3
usemtl red
s 1
f 1/1/1 2/2/1 3/1/2
f 1//1 2//1 4//-1
f -4/1 -3/2 -1/-1
f 2 1 3 4
f 1 2
l 1 2 3
p 4
vp 0.5
cstype bezier
deg 3
curv 0 1 1 2 3 4
end
";
