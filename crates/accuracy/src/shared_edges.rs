//! The jump of the normal across the edges that two triangles share.

use rayon::prelude::*;

use super::probe::{SurfaceProbe, angle};
use super::sampling::{self, on_edge};
use curvetri::mesh::{EdgeKind, Mesh, Topology};
use curvetri_bodies::Body;

/// An edge that two triangles share: the triangles and the edge's number in each.
struct SharedEdge {
    triangles: [usize; 2],
    edges: [usize; 2],
}

/// Mean angle, in radians, between the normals of two neighbours at the same point of the edge they
/// share, over as many points on each edge whose normals agree. `None` if no edge was measured.
pub(super) fn mean_jump(
    body: &Body,
    probe: &impl SurfaceProbe,
    samples: usize,
    seed: u64,
) -> Option<f64> {
    let jumps: Vec<(usize, f64)> = shared_edges(&body.mesh())
        .into_par_iter()
        .map(|edge| jumps(probe, &edge, samples, seed))
        .collect();
    let count: usize = jumps.iter().map(|edge| edge.0).sum();
    let sum: f64 = jumps.iter().map(|edge| edge.1).sum();
    (count > 0).then(|| sum / count as f64)
}

/// How many points of an edge were measured, and the sum of the jumps there.
fn jumps(probe: &impl SurfaceProbe, edge: &SharedEdge, samples: usize, seed: u64) -> (usize, f64) {
    let [t, other] = edge.triangles;
    let [k, across] = edge.edges;
    let (mut count, mut sum) = (0, 0.0);
    for along in sampling::places(samples, seed, 3 * t + k) {
        // Neighbours run along their edge in opposite directions.
        let here = probe.normal_on_edge(t, on_edge(k, along));
        let there = probe.normal_on_edge(other, on_edge(across, 1.0 - along));
        if let (Some(here), Some(there)) = (here, there) {
            count += 1;
            sum += angle(here, there);
        }
    }
    (count, sum)
}

/// Every edge whose two triangles have the same normals there, once.
fn shared_edges(mesh: &Mesh) -> Vec<SharedEdge> {
    let topology = Topology::new(mesh);
    let mut shared = Vec::new();
    for t in 0..mesh.triangles().len() {
        for k in 0..3 {
            let other = topology.neighbours(t)[k] as usize;
            if topology.edge(t, k) != EdgeKind::Smooth || other <= t {
                continue;
            }
            let [from, to] = ends(mesh, t, k);
            let across = (0..3).find(|&m| ends(mesh, other, m) == [to, from]);
            shared.push(SharedEdge {
                triangles: [t, other],
                edges: [k, across.expect("smooth neighbours share two vertices")],
            });
        }
    }
    shared
}

fn ends(mesh: &Mesh, triangle: usize, k: usize) -> [u32; 2] {
    let vertices = mesh.triangles()[triangle];
    [vertices[k], vertices[(k + 1) % 3]]
}
