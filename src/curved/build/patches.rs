//! Makes the patch of every triangle, many at once.

use rayon::prelude::*;

use super::edge_flags::flags_of;
use super::flatness::flattened;
use crate::curved::options::CurvedOptions;
use crate::curved::triangle::vertices;
use crate::embree::Bounds;
use crate::mesh::{Mesh, Topology};
use curvetri_method::{BuiltPatch, PackedPatch, PatchFlags};

/// Triangles of one job: so many that those with the same flags fill the lanes.
const CHUNK: usize = 512;

/// Every triangle as its own edges and the tolerance have it.
pub(super) fn build(
    mesh: &Mesh,
    topology: &Topology,
    options: &CurvedOptions,
) -> (Vec<PackedPatch>, Vec<Bounds>) {
    let count = mesh.triangles().len();
    let blank = PackedPatch::blank(PatchFlags::new(options.surface));
    let (mut records, mut bounds) = (vec![blank; count], vec![Bounds::EMPTY; count]);
    records
        .par_chunks_mut(CHUNK)
        .zip(bounds.par_chunks_mut(CHUNK))
        .enumerate()
        .for_each(|(n, (records, bounds))| {
            let first = n * CHUNK;
            let mut flags = [PatchFlags::default(); CHUNK];
            for (place, flags) in flags[..records.len()].iter_mut().enumerate() {
                *flags = flags_of(topology, first + place, options);
            }
            build_chunk(mesh, first, &flags[..records.len()], |place, patch| {
                let patch = if options.unchecked {
                    patch
                } else {
                    flattened(patch, mesh, first + place, options.tolerance)
                };
                records[place] = patch.packed;
                bounds[place] = bounds_of(&patch);
            });
        });
    (records, bounds)
}

/// The triangles from `first` on, as many as there are flags. `take` gets each with its place among these.
fn build_chunk(
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
        triangles.extend(same.iter().map(|place| vertices(mesh, first + place)));
        BuiltPatch::each(&triangles, common, |n, patch| take(same[n], patch));
    }
}

/// A patch's box.
pub(super) fn bounds_of(patch: &BuiltPatch) -> Bounds {
    let [lower, upper] = patch.bounds;
    Bounds {
        lower: lower.into(),
        upper: upper.into(),
    }
}
