//! Smooth means smooth: the normals of neighbours agree along the side they share.

use curvetri::mesh::{EdgeKind, Topology};
use curvetri::method::Surface;
use curvetri_test_support::{Body, Traced};
use glam::Vec3;

/// Angles in degrees between the two one-sided normals along all smooth sides, sorted.
fn jumps(body: &Body, traced: &Traced) -> Vec<f32> {
    let topology = Topology::new(&body.mesh);
    let mut jumps = Vec::new();
    for triangle in 0..body.mesh.triangles().len() {
        let neighbours = topology.neighbours(triangle);
        for (k, neighbour) in neighbours.into_iter().enumerate() {
            let neighbour = neighbour as usize;
            if topology.edge(triangle, k) != EdgeKind::Smooth || neighbour < triangle {
                continue;
            }
            let Some(back) =
                (0..3).find(|&n| topology.neighbours(neighbour)[n] as usize == triangle)
            else {
                continue;
            };
            for along in [0.1, 0.3, 0.5, 0.7, 0.9] {
                let here = side_normal(traced, triangle, k, along);
                let there = side_normal(traced, neighbour, back, 1.0 - along);
                let hard = |t: usize| (0..3).any(|k| topology.edge(t, k) == EdgeKind::Hard);
                let j = here
                    .cross(there)
                    .length()
                    .atan2(here.dot(there))
                    .to_degrees();
                if j > 0.05 {
                    println!(
                        "JUMP {j} {triangle} {neighbour} along {along} hard {} {} {:?} {:?}",
                        hard(triangle),
                        hard(neighbour),
                        traced.curved.patch(triangle as u32).kind(),
                        traced.curved.patch(neighbour as u32).kind()
                    );
                }
                jumps.push(
                    here.cross(there)
                        .length()
                        .atan2(here.dot(there))
                        .to_degrees(),
                );
            }
        }
    }
    jumps.sort_by(f32::total_cmp);
    jumps
}

/// The kernel's normal on side `k`, as seen from this triangle.
fn side_normal(traced: &Traced, triangle: usize, k: usize, along: f32) -> Vec3 {
    let mut b = [0.0; 3];
    b[k] = 1.0 - along;
    b[(k + 1) % 3] = along;
    traced
        .curved
        .patch(triangle as u32)
        .normal_at(b[1], b[2])
        .into()
}

fn percentile(sorted: &[f32], share: f32) -> f32 {
    sorted[((sorted.len() - 1) as f32 * share) as usize]
}

fn check(body: &Body, most: f32) {
    let traced = body.traced(Surface::Smooth);
    let jumps = jumps(body, &traced);
    let (median, high) = (percentile(&jumps, 0.5), percentile(&jumps, 0.95));
    println!(
        "{}: jump {median} median, {high} 95th percentile, {} places",
        body.name,
        jumps.len()
    );
    assert!(high <= most, "{}: {high} degrees", body.name);
}

#[test]
fn neighbours_agree_on_made_meshes() {
    for body in curvetri_test_support::made_bodies() {
        if ["fine torus", "bumpy torus"].contains(&body.name.as_str()) {
            check(&body, 0.05);
        }
    }
}

#[test]
fn neighbours_agree_on_real_meshes() {
    let limits = [
        ("spot/spot_triangulated.obj", 0.05),
        ("armadillo_29k.obj", 0.05),
        ("bunny_2k.obj", 0.1),
    ];
    for (name, most) in limits {
        for body in curvetri_test_support::real_meshes(&[name]) {
            check(&body, most);
        }
    }
}
