//! Meshes on bodies that programs make.

use curvetri_bodies::{Blob, capped_cylinder};
use curvetri_mesh::{Mesh, Topology, t_junctions};

#[test]
fn a_closed_body_has_no_t_junctions() {
    let closed = capped_cylinder(12, 1.0);
    assert_eq!(t_junctions(&closed, &Topology::new(&closed)), 0);
}

/// The mean of how far apart in memory a triangle's vertices are.
fn spread(mesh: &Mesh) -> f64 {
    let way = |[a, b, c]: &[u32; 3]| f64::from(a.max(b).max(c) - a.min(b).min(c));
    mesh.triangles().iter().map(way).sum::<f64>() / mesh.triangles().len() as f64
}

#[test]
fn ordering_keeps_triangles_and_brings_neighbours_near() {
    let mesh = Blob::default().mesh();
    // its vertices in an order that has nothing to do with place
    let count = mesh.positions().len();
    let moved = |n: usize| n * 1013 % count;
    assert_ne!(count % 1013, 0);
    let (mut positions, mut normals) = (mesh.positions().to_vec(), mesh.normals().to_vec());
    for n in 0..count {
        positions[moved(n)] = mesh.positions()[n];
        normals[moved(n)] = mesh.normals()[n];
    }
    let mut triangles = mesh.triangles().to_vec();
    for triangle in &mut triangles {
        *triangle = triangle.map(|vertex| moved(vertex as usize) as u32);
    }
    let mixed = Mesh::from_local(mesh.origin(), positions, normals, triangles);
    let ordered = mixed.clone().ordered();
    assert_eq!(ordered.origin(), mesh.origin());
    for triangle in 0..mesh.triangles().len() {
        assert_eq!(
            ordered.triangle_positions(triangle),
            mesh.triangle_positions(triangle)
        );
        assert_eq!(
            ordered.triangle_normals(triangle),
            mesh.triangle_normals(triangle)
        );
    }
    assert!(
        3.0 * spread(&ordered) < spread(&mixed),
        "{}",
        spread(&ordered)
    );
    assert_eq!(ordered.clone().ordered(), ordered);
}
