use glam::DVec3;

use super::*;
use crate::{NormalOptions, RawMesh};

fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]], crease: f32) -> Mesh {
    let raw = RawMesh {
        positions: positions.iter().map(|&p| p.into()).collect(),
        corners: triangles.to_vec(),
        ..RawMesh::default()
    };
    let options = NormalOptions {
        crease_angle_degrees: Some(crease),
        ..NormalOptions::default()
    };
    raw.into_mesh(&options).unwrap().0
}

const TETRAHEDRON: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

#[test]
fn a_smooth_tetrahedron_has_six_smooth_edges() {
    let topology = Topology::new(&mesh(&TETRAHEDRON, &FACES, 180.0));
    let expected = TopologyCounts {
        places: 4,
        smooth: 6,
        ..TopologyCounts::default()
    };
    assert_eq!(*topology.counts(), expected);
    assert!(topology.counts().is_closed());
    assert_eq!(topology.neighbours(0), [3, 2, 1]);
    assert_eq!(topology.neighbours(2), [0, 3, 1]);
    assert_eq!(topology.edges(1), [EdgeKind::Smooth; 3]);
}

#[test]
fn a_creased_tetrahedron_has_six_hard_sides_and_stays_closed() {
    let creased = mesh(&TETRAHEDRON, &FACES, 30.0);
    assert_eq!(creased.positions().len(), 12);
    let topology = Topology::new(&creased);
    assert_eq!(topology.counts().hard, 6);
    assert_eq!(topology.counts().places, 4);
    assert!(topology.counts().is_closed());
    assert_eq!(topology.neighbours(0), [3, 2, 1]);
    assert_eq!(topology.edges(3), [EdgeKind::Hard; 3]);
}

#[test]
fn a_missing_face_leaves_boundaries() {
    let topology = Topology::new(&mesh(&TETRAHEDRON, &FACES[1..], 180.0));
    assert_eq!(topology.counts().boundary, 3);
    assert_eq!(topology.edge(0, 0), EdgeKind::Boundary);
    assert_eq!(topology.neighbours(0)[0], NO_TRIANGLE);
    assert!(!topology.counts().is_closed());
}

#[test]
fn a_flipped_face_has_flipped_edges() {
    let mut faces = FACES;
    faces[0].swap(0, 1);
    let topology = Topology::new(&mesh(&TETRAHEDRON, &faces, 30.0));
    assert_eq!(topology.counts().flipped, 3);
    assert_eq!(topology.counts().hard, 3);
    assert_eq!(topology.edges(0), [EdgeKind::Flipped; 3]);
    assert_eq!(topology.neighbours(0).map(|t| t != NO_TRIANGLE), [true; 3]);
}

#[test]
fn opposite_winding_under_the_same_normals_still_joins() {
    let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]
        .map(DVec3::from)
        .to_vec();
    let normals = Some(vec![DVec3::Z; 4]);
    let mesh = Mesh::new(positions, normals, vec![[0, 1, 2], [0, 3, 2]]).unwrap();
    let topology = Topology::new(&mesh);
    assert_eq!(topology.edge(0, 2), EdgeKind::Smooth);
    assert_eq!(topology.counts().smooth, 1);
}

#[test]
fn a_surface_folded_onto_itself_is_flipped() {
    let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0.9, 0.5, 0.]]
        .map(DVec3::from)
        .to_vec();
    let normals = Some(vec![DVec3::Z; 4]);
    let mesh = Mesh::new(positions, normals, vec![[0, 1, 2], [3, 1, 2]]).unwrap();
    assert_eq!(Topology::new(&mesh).counts().flipped, 1);
}

#[test]
fn three_triangles_at_a_side_are_non_manifold() {
    let mut positions = TETRAHEDRON.to_vec();
    positions.push([-1.0, -1.0, -1.0]);
    let topology = Topology::new(&mesh(&positions, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]], 30.0));
    assert_eq!(topology.counts().non_manifold, 1);
    assert_eq!(topology.counts().boundary, 6);
    for triangle in 0..3 {
        assert_eq!(topology.edge(triangle, 0), EdgeKind::NonManifold);
        assert_eq!(topology.neighbours(triangle)[0], NO_TRIANGLE);
    }
}

#[test]
fn a_triangle_with_two_corners_in_one_place_does_not_part_its_neighbours() {
    let topology = Topology::new(&mesh(
        &TETRAHEDRON,
        &[[0, 1, 2], [0, 2, 0], [2, 1, 3], [0, 2, 3]],
        180.0,
    ));
    assert_eq!(topology.counts().degenerate_triangles, 1);
    assert_eq!(topology.neighbours(0), [NO_TRIANGLE, 2, 3]);
    assert_eq!(topology.neighbours(1), [NO_TRIANGLE; 3]);
    assert_eq!(topology.edges(1), [EdgeKind::Hard; 3]);
    assert_eq!(topology.counts().hard, 0);
}

#[test]
fn collinear_corners_are_degenerate() {
    let positions = [[0.1, 0.2, 0.3], [0.3, 0.6, 0.9], [0.7, 1.4, 2.1]];
    let topology = Topology::new(&mesh(&positions, &[[0, 1, 2]], 30.0));
    assert_eq!(topology.counts().degenerate_triangles, 1);
}

#[test]
fn duplicates_are_counted_whichever_way_they_wind() {
    let faces = [FACES[0], FACES[1], [3, 0, 1], [1, 0, 3], FACES[2]];
    let topology = Topology::new(&mesh(&TETRAHEDRON, &faces, 30.0));
    assert_eq!(topology.counts().duplicate_triangles, 2);
    assert_eq!(topology.edges(1), [EdgeKind::NonManifold; 3]);
}

#[test]
fn vertices_split_by_texture_only_are_no_edge_and_those_split_by_normal_are() {
    // A square of two triangles that share no vertex, as at a seam.
    let square = |normal: DVec3| {
        let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]].map(DVec3::from);
        let second = [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(DVec3::from);
        let normals = [[DVec3::Z; 3], [normal; 3]].concat();
        let mesh = Mesh::new(
            [positions, second].concat(),
            Some(normals),
            vec![[0, 1, 2], [3, 4, 5]],
        );
        *Topology::new(&mesh.unwrap()).counts()
    };
    assert_eq!(square(DVec3::Z).smooth, 1);
    let nearly = DVec3::new(1e-3, 0.0, 1.0);
    assert_eq!(square(nearly).smooth, 1, "0.06 degrees are made none");
    let apart = DVec3::new(2e-3, 0.0, 1.0);
    assert_eq!(square(apart).hard, 1, "0.11 degrees are an edge");
}

/// A closed tetrahedron stored with both its faces.
fn two_sided() -> Vec<[u32; 3]> {
    let back = FACES.map(|[a, b, c]| [c, b, a]);
    [FACES, back].concat()
}

#[test]
fn a_surface_stored_with_both_its_faces_is_two_smooth_sheets() {
    let topology = Topology::new(&mesh(&TETRAHEDRON, &two_sided(), 179.0));
    let expected = TopologyCounts {
        places: 4,
        doubled: 6,
        duplicate_triangles: 4,
        ..TopologyCounts::default()
    };
    assert_eq!(*topology.counts(), expected);
    assert_eq!(topology.neighbours(0), [3, 2, 1]);
    // The back of triangle 0 has its edges in the order 1-2, 2-0, 0-1.
    assert_eq!(topology.neighbours(4), [6, 7, 5]);
    assert_eq!(topology.edges(4), [EdgeKind::Smooth; 3]);
}

#[test]
fn both_faces_under_the_same_stored_normals_are_two_smooth_sheets() {
    let positions: Vec<DVec3> = TETRAHEDRON.map(DVec3::from).to_vec();
    let outward = positions.iter().map(|p| p - 0.25).collect();
    let mesh = Mesh::new(positions, Some(outward), two_sided()).unwrap();
    let topology = Topology::new(&mesh);
    assert_eq!(topology.counts().doubled, 6);
    // Never the back of itself, across which an edge would not be straightened for both.
    for triangle in 0..8 {
        for (k, neighbour) in topology.neighbours(triangle).into_iter().enumerate() {
            let [a, b] = [triangle, neighbour as usize].map(|t| {
                let mut places = mesh.triangles()[t];
                places.sort_unstable();
                places
            });
            assert_ne!(a, b, "edge {k} of triangle {triangle}");
            let back = topology.neighbours(neighbour as usize);
            assert!(back.contains(&(triangle as u32)));
        }
    }
}

#[test]
fn the_two_faces_of_a_sheet_are_neighbours_at_its_boundary() {
    let topology = Topology::new(&mesh(&TETRAHEDRON, &[[0, 1, 2], [0, 2, 1]], 30.0));
    assert_eq!(topology.edges(0), [EdgeKind::Smooth; 3]);
    assert_eq!(topology.neighbours(0), [1; 3]);
}

#[test]
fn creased_sheets_that_lie_in_each_other_stay_non_manifold() {
    let topology = Topology::new(&mesh(&TETRAHEDRON, &two_sided(), 30.0));
    assert_eq!(topology.counts().non_manifold, 6);
}
