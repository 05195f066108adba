//! Small files in every format that is read, plain and with the oddities that people's files have.
//! All of them can be read.

mod gltf;
mod obj;
mod off;
mod ply;
mod stl;

use std::io::Read;

use curvetri_bodies::{Blob, Body, capped_cone, capped_cylinder};
use curvetri_mesh::Mesh;
use flate2::Compression;
use flate2::read::GzEncoder;

/// A file.
pub struct Seed {
    /// The fuzz target it is for.
    pub format: &'static str,
    /// What is odd about it.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// All of them.
pub fn all() -> Vec<Seed> {
    let formats = [
        ("obj", obj::files()),
        ("ply", ply::files()),
        ("stl", stl::files()),
        ("off", off::files()),
        ("gltf", gltf::files()),
    ];
    let seed = |format, (name, bytes): (&str, Vec<u8>)| Seed {
        format,
        name: name.to_owned(),
        bytes,
    };
    formats
        .into_iter()
        .flat_map(|(format, files)| files.into_iter().map(move |file| seed(format, file)))
        .collect()
}

/// The gzip file of some bytes.
pub fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    let mut encoder = GzEncoder::new(bytes, Compression::best());
    encoder
        .read_to_end(&mut packed)
        .expect("memory has no faults");
    packed
}

/// A name and content.
type File = (&'static str, Vec<u8>);

/// What a file says.
#[derive(Clone)]
pub struct Shape {
    /// Where its vertices are.
    pub positions: Vec<[f32; 3]>,
    /// One a position, or none.
    pub normals: Vec<[f32; 3]>,
    /// The vertices of each face, in order.
    pub faces: Vec<Vec<u32>>,
}

impl Shape {
    /// A mesh's vertices and triangles.
    pub fn of(mesh: &Mesh) -> Shape {
        Shape {
            positions: mesh.positions().iter().map(|p| p.to_array()).collect(),
            normals: mesh.normals().iter().map(|n| n.to_array()).collect(),
            faces: mesh.triangles().iter().map(|t| t.to_vec()).collect(),
        }
    }

    /// The triangles' vertices in a row; of polygons the first corners.
    pub fn indices(&self) -> Vec<u32> {
        self.faces
            .iter()
            .flat_map(|face| face[..3].to_vec())
            .collect()
    }
}

/// The sphere as twelve triangles.
pub fn ball() -> Shape {
    Shape::of(&Body::sphere_cube().mesh())
}

/// A coarse one.
pub fn torus() -> Shape {
    Shape::of(&Body::torus(4, 5).mesh())
}

/// Normals are split at its hard edges.
pub fn cone() -> Shape {
    Shape::of(&capped_cone(5, 1.5))
}

/// With its caps; normals are split at its hard edges.
pub fn cylinder() -> Shape {
    Shape::of(&capped_cylinder(7, 1.0))
}

/// Irregular, with slivers.
pub fn blob() -> Shape {
    let blob = Blob {
        cells: 5,
        seed: 3,
        least_share: 0.01,
        rim: false,
        split: true,
    };
    Shape::of(&blob.mesh())
}

/// An L with a thickness: two concave polygons, one with a corner on a straight side, and quads.
pub fn prism() -> Shape {
    const OUTLINE: [[f32; 2]; 7] = [
        [0., 0.],
        [2., 0.],
        [2., 1.],
        [1., 1.],
        [1., 2.],
        [0., 2.],
        [0., 1.],
    ];
    let count = OUTLINE.len() as u32;
    let at = |z: f32| OUTLINE.map(|[x, y]| [x, y, z]);
    let top = (0..count).map(|i| count + i).collect();
    let wall = |i: u32| {
        let next = (i + 1) % count;
        vec![i, next, count + next, count + i]
    };
    Shape {
        positions: [at(0.0), at(0.5)].concat(),
        normals: Vec::new(),
        faces: [(0..count).rev().collect(), top]
            .into_iter()
            .chain((0..count).map(wall))
            .collect(),
    }
}

/// Numbers as the words of a line.
pub fn words<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    let words: Vec<String> = numbers.into_iter().map(|n| n.to_string()).collect();
    words.join(" ")
}
