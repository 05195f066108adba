//! The jump of the normal across the sides that two triangles share.

use rayon::prelude::*;

use super::probe::{Probe, angle};
use super::sampling;
use crate::bodies::Body;
use crate::mesh::{Mesh, SideKind, Topology};

/// A side that two triangles share: the triangles and the side's number in each.
struct Shared {
    triangles: [usize; 2],
    sides: [usize; 2],
}

/// Mean angle, in radians, between the normals of two neighbours at the same point of the side they
/// share, over points uniform along all sides whose normals agree. `None` if no side was measured.
pub(super) fn mean_jump(body: &Body, probe: &impl Probe, samples: usize, seed: u64) -> Option<f64> {
    let mesh = body.mesh();
    let jumps: Vec<[f64; 2]> = shared_sides(&mesh)
        .into_par_iter()
        .map(|side| jump(body, probe, &side, samples, seed))
        .collect();
    let [length, sum] = jumps
        .into_iter()
        .fold([0.0; 2], |sum, side| [sum[0] + side[0], sum[1] + side[1]]);
    (length > 0.0).then(|| sum / length)
}

/// The length that was measured, and the jump's integral over it.
fn jump(body: &Body, probe: &impl Probe, side: &Shared, samples: usize, seed: u64) -> [f64; 2] {
    let [t, other] = side.triangles;
    let corners = body.triangles()[t].positions;
    let k = side.sides[0];
    let share = corners[k].distance(corners[(k + 1) % 3]) / samples as f64;
    let mut sums = [0.0; 2];
    for along in sampling::places(samples, seed, 3 * t + k) {
        // Neighbours run along their side in opposite directions.
        let here = probe.normal_on_side(t, on_side(k, along));
        let there = probe.normal_on_side(other, on_side(side.sides[1], 1.0 - along));
        if let (Some(here), Some(there)) = (here, there) {
            sums = [sums[0] + share, sums[1] + share * angle(here, there)];
        }
    }
    sums
}

/// Barycentric coordinates (u, v) of a place on side `k`, from its first end at 0.
fn on_side(k: usize, along: f64) -> [f64; 2] {
    match k {
        0 => [along, 0.0],
        1 => [1.0 - along, along],
        _ => [0.0, 1.0 - along],
    }
}

/// Every side whose two triangles have the same normals there, once.
fn shared_sides(mesh: &Mesh) -> Vec<Shared> {
    let topology = Topology::new(mesh);
    let mut shared = Vec::new();
    for t in 0..mesh.triangles().len() {
        for k in 0..3 {
            let other = topology.neighbours(t)[k] as usize;
            if topology.side(t, k) != SideKind::Smooth || other <= t {
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
