//! From a mesh to patches: which edges are straight, which triangles stay flat, and what is stored of each.

mod edge_flags;
mod flatness;
mod kinds;
mod patches;
mod separate_flat;
mod spheres;
mod straighten;

use rayon::prelude::*;

use super::options::CurvedOptions;
use super::triangle;
use crate::embree::Bounds;
use crate::mesh::{Mesh, Topology};
use curvetri_method::{BoundsKind, PackedPatch};

pub use kinds::Kinds;
pub(super) use separate_flat::may_be_separate;
pub use spheres::Spheres;

/// The patches of a mesh, and their boxes as long as clusters are made of them.
pub(super) struct BuiltPatches {
    pub records: Vec<PackedPatch>,
    /// Empty for triangles that another geometry traces.
    pub bounds: Vec<Bounds>,
    pub kinds: Kinds,
    pub spheres: Spheres,
    /// Whether another geometry traces the triangles that [may be separate](may_be_separate).
    pub flat_separate: bool,
}

impl BuiltPatches {
    /// Makes the patch of every triangle, in parallel.
    pub fn new(mesh: &Mesh, topology: &Topology, options: &CurvedOptions) -> Self {
        let (mut records, mut bounds) = patches::build(mesh, topology, options);
        if !options.unchecked {
            straighten::straighten_towards_flat(mesh, topology, &mut records, &mut bounds);
        }
        let kinds = records
            .par_iter()
            .map(|record| Kinds::of(record.kind()))
            .reduce(Kinds::default, |a, b| a + b);
        let flat_separate = separate_flat::pays(options.flat, &kinds);
        if flat_separate {
            separate_flat::leave_out(&records, &mut bounds);
        }
        Self {
            spheres: spheres(mesh, &records, options.bounds),
            records,
            bounds,
            kinds,
            flat_separate,
        }
    }
}

/// Counts the spheres, where those were requested.
fn spheres(mesh: &Mesh, records: &[PackedPatch], bounds: BoundsKind) -> Spheres {
    if bounds != BoundsKind::Sphere {
        return Spheres::default();
    }
    (records.par_iter().enumerate())
        .map(|(triangle, record)| {
            let patch = triangle::packed_triangle(mesh, triangle, record);
            Spheres::of(patch.sphere().as_ref())
        })
        .reduce(Spheres::default, |a, b| a + b)
}
