//! Makes edges straight towards triangles that stay flat, so that no gap opens beside them.

use rayon::prelude::*;

use super::edge_flags::straight_towards;
use super::patches::bounds_of;
use crate::curved::triangle::{is_flat, vertices};
use crate::embree::Bounds;
use crate::mesh::{Mesh, Topology};
use curvetri_method::{BuiltPatch, PackedPatch};

/// Makes every edge straight that leads to a flat or degenerate triangle.
///
/// A triangle with one more straight edge may turn flat itself, so this goes on until nothing changes. Each
/// step only makes edges straight that were not, so it ends.
pub(super) fn straighten_towards_flat(
    mesh: &Mesh,
    topology: &Topology,
    records: &mut [PackedPatch],
    bounds: &mut [Bounds],
) {
    let mut flat: Vec<u32> = (0..records.len() as u32)
        .into_par_iter()
        .filter(|&triangle| {
            let record = &records[triangle as usize];
            // The edges of a surface that is its plane are straight enough as they are.
            is_flat(record) && !record.flags().is_plane()
        })
        .collect();
    while let Some(triangle) = flat.pop() {
        for neighbour in topology.neighbours(triangle as usize) {
            let Some(old) = records.get(neighbour as usize).copied() else {
                continue; // no neighbour across this edge
            };
            let flags = straight_towards(topology, old.flags(), neighbour as usize, triangle);
            if flags == old.flags() || is_flat(&old) {
                continue;
            }
            let new = BuiltPatch::new(&vertices(mesh, neighbour as usize), flags);
            records[neighbour as usize] = new.packed;
            bounds[neighbour as usize] = bounds_of(&new);
            if is_flat(&new.packed) {
                flat.push(neighbour);
            }
        }
    }
}
