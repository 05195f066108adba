//! A mesh as one Embree user geometry of curved triangles, with an inline path for those that stay flat;
//! or with those as triangles of Embree's own beside it.

mod advice;
mod cluster;
mod clusters;
mod counters;
mod entries;
mod flat;
mod geometry;
mod inspection;
mod kinds;
mod laid;
mod prepare;
mod spheres;
mod tessellate;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::embree::Bounds;
use crate::mesh::{Mesh, Topology, TopologyCounts};
use crate::method::{
    BoundsKind, PackedPatch, PackedTriangle, Patch, PatchKind, Solver, Surface, TriangleVertices,
    Vector,
};

use cluster::Cluster;
pub use counters::{Counters, counters};
pub use flat::FlatTriangles;
pub use inspection::{Heights, Inspection, MemoryNeed, SideLengths};
pub use kinds::Kinds;
pub use spheres::Spheres;
pub use tessellate::Tessellation;

/// What Embree is given as one primitive. Hits name triangles either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Primitives {
    /// A triangle: the method's plain form.
    Triangles,
    /// A few neighbouring triangles, whose boxes are tested against a ray all at once: a smaller tree
    /// and fewer callbacks.
    #[default]
    Clusters,
}

/// How a mesh's triangles are curved and how rays are solved against them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvedOptions {
    /// The surface the triangles stand for.
    pub surface: Surface,
    /// How a ray's root on a patch is found.
    pub solver: Solver,
    /// What is one primitive to Embree.
    pub primitives: Primitives,
    /// What bounds a triangle's box and a ray's way over it.
    pub bounds: BoundsKind,
    /// Triangles whose surface lies no further than this from their plane stay flat, with straight sides
    /// towards their neighbours; in the mesh's units, 0 for none but those whose surface lies in the plane
    /// to within rounding. Flat triangles are traced faster, and cuts in the shading show sooner than a
    /// height: a hundredth of a pixel is about what goes unseen.
    pub tolerance: f32,
    /// Who traces those that stay flat.
    pub flat: FlatTriangles,
    /// Every triangle as the paper has it, from its own vertices alone: also where its guide field
    /// folds over or bends too much for the method's guarantees, and with curved sides also at hard
    /// edges and towards flat triangles. For measuring the method itself: rays may slip through
    /// where it is used.
    pub unchecked: bool,
}

impl CurvedOptions {
    /// The paper's own form of the method: the angular surface (19), boxes of the sphere of greatest
    /// curvature (3), rays between the three side planes (5) and within that sphere, roots of (44) by
    /// the iterative algorithm (ITA) to `n = 24` binary digits, `n1 = 3` at a time (sections 4.3, 4.4
    /// and 4.8).
    ///
    /// What is ours in it: hard edges and the triangles that the method cannot take are treated as for
    /// all surfaces (the paper has neither), and so are the spheres that the surface would leave and
    /// those of needles: [`Spheres`] counts them.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            surface: Surface::Angular,
            solver: Solver::ITA,
            bounds: BoundsKind::Sphere,
            primitives: Primitives::Triangles,
            tolerance: 0.0,
            flat: FlatTriangles::Inline,
            unchecked: false,
        }
    }
}

/// A mesh whose triangles are curved patches, ready to be an Embree user geometry.
///
/// Rays, hits and bounds are in the mesh's local space: positions relative to
/// [`Mesh::origin`]. A hit's primitive `i` is the mesh's triangle `i`.
pub struct CurvedMesh {
    mesh: Arc<Mesh>,
    records: Vec<PackedPatch>,
    clusters: Option<Box<[Cluster]>>,
    /// Whether the flat triangles are left to another geometry.
    flat_apart: bool,
    /// Tells it from all others that there ever were.
    number: u64,
    solver: Solver,
    kinds: Kinds,
    spheres: Spheres,
    topology: TopologyCounts,
}

/// One more than there were curved meshes.
static COUNT: AtomicU64 = AtomicU64::new(1);

impl CurvedMesh {
    /// Curves every triangle of a mesh, in parallel.
    ///
    /// Hard, flipped and non-manifold sides are straight on both sides of them. A triangle that
    /// the method cannot take stays flat, and its neighbours' sides towards it become straight, so
    /// that no gap opens; [`CurvedMesh::kinds`] counts them.
    pub fn new(mesh: Arc<Mesh>, options: &CurvedOptions) -> Self {
        let topology = Topology::new(&mesh);
        let mut prepared = prepare::prepare(&mesh, &topology, options);
        let flat_apart = options.flat.are_apart(&prepared.kinds);
        if flat_apart {
            prepared.leave_out_flat();
        }
        let clusters = match options.primitives {
            Primitives::Triangles => None,
            Primitives::Clusters => {
                let kept = |triangle: u32| {
                    let triangle = triangle as usize;
                    kept(&mesh, triangle, &prepared.records[triangle])
                };
                Some(clusters::group(&prepared.bounds, kept))
            }
        };
        Self {
            mesh,
            records: prepared.records,
            clusters,
            flat_apart,
            number: COUNT.fetch_add(1, Ordering::Relaxed),
            solver: options.solver,
            kinds: prepared.kinds,
            spheres: prepared.spheres,
            topology: *topology.counts(),
        }
    }

    fn triangle_bounds(&self, triangle: u32) -> Bounds {
        if self.is_apart(triangle) {
            return Bounds::EMPTY;
        }
        let [lower, upper] = self.patch(triangle).bounds();
        Bounds {
            lower: lower.into(),
            upper: upper.into(),
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

    /// How many triangles have which sphere, where spheres were asked for.
    pub fn spheres(&self) -> &Spheres {
        &self.spheres
    }

    /// How the triangles meet at their sides.
    pub fn topology(&self) -> &TopologyCounts {
        &self.topology
    }

    /// Bytes kept beyond the indexed mesh itself.
    pub fn memory(&self) -> usize {
        let clusters = self.clusters.as_ref().map_or(0, |clusters| clusters.len());
        self.records.capacity() * size_of::<PackedPatch>() + clusters * size_of::<Cluster>()
    }

    /// The curved patch of one triangle, in the mesh's local space.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn patch(&self, triangle: u32) -> Patch<f32> {
        self.kept(triangle).unpack()
    }

    #[inline(always)]
    fn kept(&self, triangle: u32) -> PackedTriangle<'_> {
        let triangle = triangle as usize;
        kept(&self.mesh, triangle, &self.records[triangle])
    }

    /// The same patch computed in `f64` from the same vertices: the oracle for the `f32` one.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn oracle(&self, triangle: u32) -> Patch<f64> {
        let TriangleVertices { positions, normals } = corners(&self.mesh, triangle as usize);
        let flags = self.records[triangle as usize].flags();
        let wide = |v: [Vector<f32>; 3]| v.map(Vector::to_f64);
        Patch::new(wide(positions), wide(normals), flags)
    }
}

/// What is kept of a triangle's patch.
#[inline(always)]
fn kept<'a>(mesh: &Mesh, triangle: usize, record: &'a PackedPatch) -> PackedTriangle<'a> {
    PackedTriangle::new(corners(mesh, triangle), record)
}

/// A triangle's positions and normals as the kernel takes them.
#[inline(always)]
fn corners(mesh: &Mesh, triangle: usize) -> TriangleVertices {
    let [a, b, c] = mesh.triangle_positions(triangle);
    let [k, m, n] = mesh.triangle_normals(triangle);
    TriangleVertices {
        positions: [a.into(), b.into(), c.into()],
        normals: [k.into(), m.into(), n.into()],
    }
}
