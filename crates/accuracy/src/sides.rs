//! The jump of the normal across the sides that two triangles share.

use rayon::prelude::*;

use super::probe::{Probe, angle};
use super::sampling::{self, on_side};
use curvetri::mesh::{EdgeKind, Mesh, Topology};
use curvetri_bodies::Body;

/// A side that two triangles share: the triangles and the side's number in each.
struct Shared {
    triangles: [usize; 2],
    sides: [usize; 2],
}

/// Mean angle, in radians, between the normals of two neighbours at the same point of the side they
/// share, over as many points on each side whose normals agree. `None` if no side was measured.
pub(super) fn mean_jump(body: &Body, probe: &impl Probe, samples: usize, seed: u64) -> Option<f64> {
    let jumps: Vec<(usize, f64)> = shared_sides(&body.mesh())
        .into_par_iter()
        .map(|side| jumps(probe, &side, samples, seed))
        .collect();
    let count: usize = jumps.iter().map(|side| side.0).sum();
    let sum: f64 = jumps.iter().map(|side| side.1).sum();
    (count > 0).then(|| sum / count as f64)
}

/// How many points of a side were measured, and the sum of the jumps there.
fn jumps(probe: &impl Probe, side: &Shared, samples: usize, seed: u64) -> (usize, f64) {
    let [t, other] = side.triangles;
    let [k, across] = side.sides;
    let (mut count, mut sum) = (0, 0.0);
    for along in sampling::places(samples, seed, 3 * t + k) {
        // Neighbours run along their side in opposite directions.
        let here = probe.normal_on_side(t, on_side(k, along));
        let there = probe.normal_on_side(other, on_side(across, 1.0 - along));
        if let (Some(here), Some(there)) = (here, there) {
            count += 1;
            sum += angle(here, there);
        }
    }
    (count, sum)
}

/// Every side whose two triangles have the same normals there, once.
fn shared_sides(mesh: &Mesh) -> Vec<Shared> {
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
            shared.push(Shared {
                triangles: [t, other],
                sides: [k, across.expect("smooth neighbours share two vertices")],
            });
        }
    }
    shared
}

fn ends(mesh: &Mesh, triangle: usize, k: usize) -> [u32; 2] {
    let vertices = mesh.triangles()[triangle];
    [vertices[k], vertices[(k + 1) % 3]]
}
