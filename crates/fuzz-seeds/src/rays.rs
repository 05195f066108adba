//! Meshes with rays at them, in the bytes that the target `rays` reads (`fuzz/src/cast.rs`).

use curvetri_fuzz_seeds::{Shape, ball, blob, cone, cylinder, torus};

/// Names and contents.
pub fn all() -> Vec<(String, Vec<u8>)> {
    let shapes = [
        ("ball", ball()),
        ("torus", torus()),
        ("cone", cone()),
        ("cylinder", cylinder()),
        ("blob", blob()),
    ];
    let mut all = Vec::new();
    for (name, shape) in shapes {
        // Each bit on and off, with each other and with each surface.
        for bits in (0..128).step_by(7) {
            let bytes = bytes(&shape, bits % 3, bits);
            all.push((format!("{name} {bits}"), bytes));
        }
    }
    all
}

fn bytes(shape: &Shape, surface: u8, bits: u8) -> Vec<u8> {
    let (single, stored) = (bits & 4 != 0, bits & 16 != 0);
    let vertices = shape.positions.len().min(48);
    let known = |face: &&Vec<u32>| face.iter().all(|&v| (v as usize) < vertices);
    let faces: Vec<_> = shape.faces.iter().filter(known).take(64).collect();
    let mut bytes = vec![surface, bits, 30, vertices as u8 - 1, faces.len() as u8 - 1];
    for &x in shape.positions[..vertices].as_flattened() {
        match single {
            true => bytes.extend(x.to_le_bytes()),
            false => bytes.extend(f64::from(x).to_le_bytes()),
        }
    }
    if stored {
        let normals = shape.normals[..vertices].as_flattened();
        bytes.extend(normals.iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes.extend(faces.iter().flat_map(|face| face.iter().map(|&v| v as u8)));
    for ray in 0..16u8 {
        // At all places of triangles, from far and near; some are cut off, some have a place of their own.
        let how = [1, 3, 5, 0][usize::from(ray) % 4];
        let towards = |k: u8| f32::from((ray + 1).wrapping_mul(k) % 16) - 7.5;
        let origin = [5, 3, 11].map(towards);
        bytes.push(how);
        bytes.extend(origin.iter().flat_map(|x| x.to_le_bytes()));
        match how {
            0 => bytes.extend(origin.iter().flat_map(|x| (-x).to_le_bytes())),
            _ => bytes.extend([
                ray.wrapping_mul(5),
                ray.wrapping_mul(8),
                128 - ray.wrapping_mul(8),
            ]),
        }
        if how & 4 != 0 {
            bytes.extend([0.25f32, 1.5].iter().flat_map(|x| x.to_le_bytes()));
        }
    }
    bytes
}
