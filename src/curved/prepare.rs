//! Decides which sides stay straight and which triangles stay flat, and computes what is kept of
//! each patch.

use rayon::prelude::*;

use super::kinds::Kinds;
use super::spheres::Spheres;
use super::{CurvedOptions, corners, kept};
use crate::embree::Bounds;
use crate::mesh::{Mesh, Topology};
use crate::method::{BoundsKind, BuiltPatch, PackedPatch, PatchFlags, PatchKind};

/// Triangles that are made together, such that those with the same flags fill the lanes.
const TOGETHER: usize = 512;

/// A surface with a slab no higher than this, in units of the patch's size, is its plane but for rounding:
/// 8 epsilons, and the 32 that every slab has as room.
const PLANE_HEIGHT: f32 = 40.0 * f32::EPSILON;

/// What is kept of each triangle, and what is needed of it until the mesh is grouped.
pub(super) struct PreparedMesh {
    pub records: Vec<PackedPatch>,
    pub bounds: Vec<Bounds>,
    pub kinds: Kinds,
    pub spheres: Spheres,
}

pub(super) fn prepare(mesh: &Mesh, topology: &Topology, options: &CurvedOptions) -> PreparedMesh {
    let (mut records, mut bounds) = make(mesh, topology, options);
    if !options.unchecked {
        straighten_neighbours(mesh, topology, &mut records, &mut bounds);
    }
    let kinds = records
        .par_iter()
        .map(|record| Kinds::of(record.kind()))
        .reduce(Kinds::default, |a, b| a + b);
    PreparedMesh {
        spheres: spheres(mesh, &records, options.bounds),
        records,
        bounds,
        kinds,
    }
}

/// Every triangle as its own sides ask for.
fn make(
    mesh: &Mesh,
    topology: &Topology,
    options: &CurvedOptions,
) -> (Vec<PackedPatch>, Vec<Bounds>) {
    let count = mesh.triangles().len();
    let blank = PackedPatch::blank(PatchFlags::new(options.surface));
    let (mut records, mut bounds) = (vec![blank; count], vec![Bounds::EMPTY; count]);
    records
        .par_chunks_mut(TOGETHER)
        .zip(bounds.par_chunks_mut(TOGETHER))
        .enumerate()
        .for_each(|(n, (records, bounds))| {
            let first = n * TOGETHER;
            let mut flags = [PatchFlags::default(); TOGETHER];
            for (place, flags) in flags[..records.len()].iter_mut().enumerate() {
                *flags = flags_of(topology, first + place, options);
            }
            make_some(mesh, first, &flags[..records.len()], |place, prepared| {
                let prepared = if options.unchecked {
                    prepared
                } else {
                    flattened(prepared, mesh, first + place, options.tolerance)
                };
                records[place] = prepared.packed;
                bounds[place] = bounds_of(&prepared);
            });
        });
    (records, bounds)
}

/// The triangle made flat where its surface lies in its plane anyway or is within the tolerance of it.
fn flattened(prepared: BuiltPatch, mesh: &Mesh, triangle: usize, tolerance: f32) -> BuiltPatch {
    let Some(height) = prepared.greatest_height() else {
        return prepared;
    };
    let flags = prepared.packed.flags();
    if height <= PLANE_HEIGHT {
        return BuiltPatch::new(&corners(mesh, triangle), flags.with_plane());
    }
    if tolerance > 0.0 {
        let corners = corners(mesh, triangle);
        if height * corners.size() <= tolerance {
            return BuiltPatch::new(&corners, flags.with_flat());
        }
    }
    prepared
}

/// The triangles from the first on, as many as there are flags.
fn make_some(
    mesh: &Mesh,
    first: usize,
    flags: &[PatchFlags],
    mut take: impl FnMut(usize, BuiltPatch),
) {
    let mut left: Vec<usize> = (0..flags.len()).collect();
    let mut same = Vec::with_capacity(flags.len());
    let mut triangles = Vec::with_capacity(flags.len());
    while let Some(&place) = left.first() {
        let common = flags[place];
        same.clear();
        left.retain(|&place| {
            let other = flags[place] != common;
            if !other {
                same.push(place);
            }
            other
        });
        triangles.clear();
        triangles.extend(same.iter().map(|place| corners(mesh, first + place)));
        BuiltPatch::each(&triangles, common, |n, prepared| take(same[n], prepared));
    }
}

fn bounds_of(prepared: &BuiltPatch) -> Bounds {
    let [lower, upper] = prepared.bounds;
    Bounds {
        lower: lower.into(),
        upper: upper.into(),
    }
}

/// Counts the spheres, where those were asked for.
fn spheres(mesh: &Mesh, records: &[PackedPatch], bounds: BoundsKind) -> Spheres {
    if bounds != BoundsKind::Sphere {
        return Spheres::default();
    }
    (records.par_iter().enumerate())
        .map(|(triangle, record)| Spheres::of(kept(mesh, triangle, record).sphere().as_ref()))
        .reduce(Spheres::default, |a, b| a + b)
}

/// What the sides alone ask for.
fn flags_of(topology: &Topology, triangle: usize, options: &CurvedOptions) -> PatchFlags {
    let none = PatchFlags::new(options.surface).with_bounds(options.bounds);
    if options.unchecked {
        return none.with_unchecked();
    }
    let sides = topology.edges(triangle);
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
fn straighten_neighbours(
    mesh: &Mesh,
    topology: &Topology,
    records: &mut [PackedPatch],
    bounds: &mut [Bounds],
) {
    let mut flat: Vec<u32> = (0..records.len() as u32)
        .into_par_iter()
        .filter(|&triangle| {
            let record = &records[triangle as usize];
            // sides of what lies in its plane anyway are straight enough as they are
            is_plane(record) && !record.flags().is_plane()
        })
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
            let new = BuiltPatch::new(&corners(mesh, neighbour as usize), flags);
            records[neighbour as usize] = new.packed;
            bounds[neighbour as usize] = bounds_of(&new);
            if is_plane(&new.packed) {
                flat.push(neighbour);
            }
        }
    }
}

pub(super) fn is_plane(record: &PackedPatch) -> bool {
    matches!(record.kind(), PatchKind::Flat(_) | PatchKind::Degenerate)
}
