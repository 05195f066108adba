//! A mesh whose triangles are curved patches.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::build::{BuiltPatches, Kinds, Spheres, may_be_separate};
use super::cluster::{Cluster, group};
use super::options::{CurvedOptions, Primitives};
use super::triangle;
use crate::embree::Bounds;
use crate::mesh::{Mesh, Topology, TopologyCounts};
use curvetri_method::{
    PackedPatch, PackedTriangle, Patch, PatchKind, Solver, TriangleVertices, Vector,
};

/// A mesh whose triangles are curved patches, ready to be an Embree user geometry.
///
/// Rays, hits and bounds are in the mesh's local space: positions relative to
/// [`Mesh::origin`]. A hit's primitive `i` is the mesh's triangle `i`.
pub struct CurvedMesh {
    pub(super) mesh: Arc<Mesh>,
    pub(super) records: Vec<PackedPatch>,
    pub(super) clusters: Option<Box<[Cluster]>>,
    /// Whether the flat triangles are left to another geometry.
    pub(super) flat_separate: bool,
    /// Unique in the program's life, so that caches know whose their content is.
    pub(super) id: u64,
    pub(super) solver: Solver,
    kinds: Kinds,
    spheres: Spheres,
    topology: TopologyCounts,
}

/// The id of the next curved mesh. No mesh has id 0.
static NEXT_ID: AtomicU64 = AtomicU64::new(1);

impl CurvedMesh {
    /// Curves every triangle of a mesh, in parallel.
    ///
    /// Hard, flipped and non-manifold edges are straight for both triangles. A triangle that
    /// the method cannot take stays flat, and its neighbours' edges towards it become straight, so
    /// that no gap opens; [`CurvedMesh::kinds`] counts them.
    pub fn new(mesh: Arc<Mesh>, options: &CurvedOptions) -> Self {
        let topology = Topology::new(&mesh);
        let patches = BuiltPatches::new(&mesh, &topology, options);
        let clusters = match options.primitives {
            Primitives::Triangles => None,
            Primitives::Clusters => Some(group(&patches.bounds, |triangle| {
                let triangle = triangle as usize;
                triangle::packed_triangle(&mesh, triangle, &patches.records[triangle])
            })),
        };
        Self {
            mesh,
            records: patches.records,
            clusters,
            flat_separate: patches.flat_separate,
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            solver: options.solver,
            kinds: patches.kinds,
            spheres: patches.spheres,
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

    /// What one triangle turned out to be.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn kind(&self, triangle: u32) -> PatchKind {
        self.records[triangle as usize].kind()
    }

    /// How many triangles have which sphere, where spheres were requested.
    pub fn spheres(&self) -> &Spheres {
        &self.spheres
    }

    /// How the triangles meet at their edges.
    pub fn topology(&self) -> &TopologyCounts {
        &self.topology
    }

    /// Bytes of memory beyond the indexed mesh itself.
    pub fn memory(&self) -> usize {
        let clusters = self.clusters.as_ref().map_or(0, |clusters| clusters.len());
        self.records.capacity() * size_of::<PackedPatch>() + clusters * size_of::<Cluster>()
    }

    /// The curved patch of one triangle, in the mesh's local space.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn patch(&self, triangle: u32) -> Patch<f32> {
        self.packed_triangle(triangle).unpack()
    }

    /// The same patch computed in `f64` from the same vertices: the oracle for the `f32` one.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn oracle(&self, triangle: u32) -> Patch<f64> {
        let TriangleVertices { positions, normals } =
            triangle::vertices(&self.mesh, triangle as usize);
        let flags = self.records[triangle as usize].flags();
        let wide = |v: [Vector<f32>; 3]| v.map(Vector::to_f64);
        Patch::new(wide(positions), wide(normals), flags)
    }

    #[inline(always)]
    pub(super) fn packed_triangle(&self, triangle: u32) -> PackedTriangle<'_> {
        let triangle = triangle as usize;
        triangle::packed_triangle(&self.mesh, triangle, &self.records[triangle])
    }

    /// Whether a triangle is left to the flat geometry.
    pub(super) fn is_separate(&self, triangle: u32) -> bool {
        self.flat_separate && may_be_separate(&self.records[triangle as usize])
    }

    /// A triangle's box, empty where another geometry traces it.
    pub(super) fn triangle_bounds(&self, triangle: u32) -> Bounds {
        if self.is_separate(triangle) {
            return Bounds::EMPTY;
        }
        let [lower, upper] = self.patch(triangle).bounds();
        Bounds {
            lower: lower.into(),
            upper: upper.into(),
        }
    }
}
