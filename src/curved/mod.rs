//! A mesh as one Embree user geometry of curved triangles: one primitive a triangle, with an inline
//! path for those that stay flat.

mod advice;
mod counters;
mod geometry;
mod inspection;
mod kinds;
mod prepare;
mod tessellate;

use std::sync::Arc;

use crate::mesh::{Mesh, Topology, TopologyCounts};
use crate::surface::{Patch, PatchRecord, Solver, Surface, Vector};

pub use counters::{Counters, counters};
pub use inspection::{Heights, Inspection, MemoryNeed, SideLengths};
pub use kinds::Kinds;
pub use tessellate::Tessellation;

/// How a mesh's triangles are curved and how rays are solved against them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvedOptions {
    /// The surface the triangles stand for.
    pub surface: Surface,
    /// How a ray's root on a patch is found.
    pub solver: Solver,
    /// Every triangle as the paper has it, from its own vertices alone: also where its guide field
    /// folds over or bends too much for the method's guarantees, and with curved sides also at hard
    /// edges and towards flat triangles. For measuring the method itself: rays may slip through
    /// where it is used.
    pub unchecked: bool,
}

/// A mesh whose triangles are curved patches, ready to be an Embree user geometry.
///
/// Rays, hits and bounds are in the mesh's local space: positions relative to
/// [`Mesh::origin`]. Primitive `i` is the mesh's triangle `i`.
pub struct CurvedMesh {
    mesh: Arc<Mesh>,
    records: Vec<PatchRecord>,
    solver: Solver,
    kinds: Kinds,
    topology: TopologyCounts,
}

impl CurvedMesh {
    /// Curves every triangle of a mesh, in parallel.
    ///
    /// Hard, flipped and non-manifold sides are straight on both sides of them. A triangle that
    /// the method cannot take stays flat, and its neighbours' sides towards it become straight, so
    /// that no gap opens; [`CurvedMesh::kinds`] counts them.
    pub fn new(mesh: Arc<Mesh>, options: &CurvedOptions) -> Self {
        let topology = Topology::new(&mesh);
        let prepared = prepare::prepare(&mesh, &topology, options);
        Self {
            mesh,
            records: prepared.records,
            solver: options.solver,
            kinds: prepared.kinds,
            topology: *topology.counts(),
        }
    }

    /// The mesh it was made from.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// How many triangles turned out to be what.
    pub fn kinds(&self) -> &Kinds {
        &self.kinds
    }

    /// How the triangles meet at their sides.
    pub fn topology(&self) -> &TopologyCounts {
        &self.topology
    }

    /// Bytes kept beyond the indexed mesh itself.
    pub fn memory(&self) -> usize {
        self.records.capacity() * size_of::<PatchRecord>()
    }

    /// The curved patch of one triangle, in the mesh's local space.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn patch(&self, triangle: u32) -> Patch<f32> {
        let (positions, normals) = corners(&self.mesh, triangle as usize);
        Patch::from_record(positions, normals, &self.records[triangle as usize])
    }

    /// The same patch computed in `f64` from the same vertices: the oracle for the `f32` one.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn oracle(&self, triangle: u32) -> Patch<f64> {
        let (positions, normals) = corners(&self.mesh, triangle as usize);
        let flags = self.records[triangle as usize].flags();
        let wide = |v: [Vector<f32>; 3]| v.map(Vector::to_f64);
        Patch::new(wide(positions), wide(normals), flags)
    }
}

/// A triangle's positions and normals as the kernel takes them.
fn corners(mesh: &Mesh, triangle: usize) -> ([Vector<f32>; 3], [Vector<f32>; 3]) {
    let positions = mesh.triangle_positions(triangle).map(Vector::from);
    let normals = mesh.triangle_normals(triangle).map(Vector::from);
    (positions, normals)
}
