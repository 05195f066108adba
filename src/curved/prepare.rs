//! Decides which sides stay straight and which triangles stay flat, and computes what is kept of
//! each patch.

use rayon::prelude::*;

use super::kinds::Kinds;
use super::spheres::Spheres;
use super::{CurvedOptions, corners, kept};
use crate::mesh::{Mesh, Topology};
use crate::surface::{Patch, PatchFlags, PatchKind, PatchRecord};

pub(super) struct Prepared {
    pub records: Vec<PatchRecord>,
    pub kinds: Kinds,
    pub spheres: Spheres,
}

pub(super) fn prepare(mesh: &Mesh, topology: &Topology, options: &CurvedOptions) -> Prepared {
    let count = mesh.triangles().len();
    let mut records: Vec<PatchRecord> = (0..count)
        .into_par_iter()
        .map(|triangle| record(mesh, triangle, flags(topology, triangle, options)))
        .collect();
    if !options.unchecked {
        straighten_neighbours(mesh, topology, &mut records);
    }
    let kinds = records
        .par_iter()
        .map(|record| Kinds::of(record.kind()))
        .reduce(Kinds::default, |a, b| a + b);
    let spheres = (records.par_iter().enumerate())
        .map(|(triangle, record)| Spheres::of(kept(mesh, triangle, record).outline().sphere()))
        .reduce(Spheres::default, |a, b| a + b);
    Prepared {
        records,
        kinds,
        spheres,
    }
}

fn record(mesh: &Mesh, triangle: usize, flags: PatchFlags) -> PatchRecord {
    let (positions, normals) = corners(mesh, triangle);
    Patch::new(positions, normals, flags).record(flags)
}

/// What the sides alone ask for.
fn flags(topology: &Topology, triangle: usize, options: &CurvedOptions) -> PatchFlags {
    let none = PatchFlags::new(options.surface).with_bounds(options.bounds);
    if options.unchecked {
        return none.with_unchecked();
    }
    let sides = topology.sides(triangle);
    (0..3).fold(none, |flags, k| {
        if sides[k].is_straight() {
            flags.with_straight(k)
        } else {
            flags
        }
    })
}

/// Makes straight every side towards a flat or degenerate triangle. A triangle whose side becomes
/// straight may turn flat itself, so this goes on until nothing changes; each step only ever makes
/// a side straight that was not, so it ends.
fn straighten_neighbours(mesh: &Mesh, topology: &Topology, records: &mut [PatchRecord]) {
    let mut flat: Vec<u32> = (0..records.len() as u32)
        .into_par_iter()
        .filter(|&triangle| is_plane(&records[triangle as usize]))
        .collect();
    while let Some(triangle) = flat.pop() {
        for neighbour in topology.neighbours(triangle as usize) {
            let Some(old) = records.get(neighbour as usize).copied() else {
                continue; // no neighbour across this side
            };
            let towards = topology.neighbours(neighbour as usize);
            let flags = (0..3).fold(old.flags(), |flags, k| {
                if towards[k] == triangle {
                    flags.with_straight(k)
                } else {
                    flags
                }
            });
            if flags == old.flags() || is_plane(&old) {
                continue;
            }
            let new = record(mesh, neighbour as usize, flags);
            records[neighbour as usize] = new;
            if is_plane(&new) {
                flat.push(neighbour);
            }
        }
    }
}

pub(super) fn is_plane(record: &PatchRecord) -> bool {
    matches!(record.kind(), PatchKind::Flat(_) | PatchKind::Degenerate)
}
