//! What is in a mesh and what the method does with it.

use std::sync::Arc;

use rayon::prelude::*;

use crate::curved::build::{Kinds, Spheres};
use crate::curved::curved_mesh::CurvedMesh;
use crate::curved::geometries::flat_geometry_bytes;
use crate::curved::options::CurvedOptions;
use crate::embree::UserGeometry;
use crate::mesh::{Bounds, LoadReport, Loaded, Mesh, Topology, TopologyCounts, t_junctions};
use curvetri_method::{Patch, PatchKind};

/// Bytes of Embree's tree for each curved triangle: up to 109 with Embree 3.13.
const TREE_BYTES: u64 = 109;

/// Where heights are measured, as barycentric coordinates `u`, `v`: the middles of the triangle, of
/// its edges, and between.
const MEASURED: [[f32; 2]; 7] = [
    [1.0 / 3.0, 1.0 / 3.0],
    [0.5, 0.0],
    [0.5, 0.5],
    [0.0, 0.5],
    [1.0 / 6.0, 1.0 / 6.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
];

/// What is in a mesh and what the method does with it.
///
/// ```
/// use curvetri::curved::{Advice, CurvedOptions, EdgeLengths, Inspection};
/// use curvetri::mesh::Loader;
///
/// let text = b"v 0 0 0\nv 3 0 0\nv 0 4 0\nf 1 2 3\n".to_vec();
/// let loaded = Loader::new().load_bytes(text, "triangle.obj")?;
/// let inspection = Inspection::new(loaded, &CurvedOptions::default());
/// assert_eq!(inspection.edges, EdgeLengths { least: 3.0, mean: 4.0, greatest: 5.0 });
/// assert_eq!((inspection.kinds.flat_plane, inspection.heights.greatest), (1, 0.0));
/// assert_eq!(inspection.advice()[0], Advice::BoundaryEdges(3));
/// assert!(inspection.memory.total() > inspection.memory.tree);
/// # Ok::<(), curvetri::mesh::LoadError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Inspection {
    /// What was found in the file.
    pub report: LoadReport,
    /// Triangles.
    pub triangles: u64,
    /// Vertices, distinct in position and normal.
    pub vertices: u64,
    /// The mesh's bounds in the user's space, of its vertices.
    pub bounds: Bounds,
    /// What the work is done relative to; zero unless the mesh lies far out.
    pub origin: glam::DVec3,
    /// Lengths of the triangles' edges.
    pub edges: EdgeLengths,
    /// How the triangles meet.
    pub topology: TopologyCounts,
    /// Open edges with another open edge's end within them.
    pub t_junctions: u64,
    /// Triangles by kind.
    pub kinds: Kinds,
    /// Curved triangles by the sphere that bounds them, where spheres were requested.
    pub spheres: Spheres,
    /// How far the curved surface lies off its triangles.
    pub heights: SurfaceHeights,
    /// Memory to expect.
    pub memory: MemoryNeed,
}

/// Lengths of edges, in the mesh's units. An edge of two triangles counts twice.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EdgeLengths {
    /// The shortest that is not zero; zero if all are.
    pub least: f64,
    /// The mean.
    pub mean: f64,
    /// The longest.
    pub greatest: f64,
}

/// How far the curved surface lies off its triangles at the most, as measured at seven points of
/// each.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SurfaceHeights {
    /// The greatest height, in the mesh's units.
    pub greatest: f64,
    /// The triangle it is over.
    pub greatest_at: u32,
    /// The greatest height in lengths of its triangle's longest edge.
    pub steepest: f64,
    /// The triangle it is over.
    pub steepest_at: u32,
}

/// Memory to expect, in bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MemoryNeed {
    /// Positions, normals and indices.
    pub mesh: u64,
    /// The record of each curved patch, and the clusters.
    pub records: u64,
    /// Embree's tree, at most, with its copies of flat triangles that are
    /// [separate](crate::curved::FlatTriangles::Separate).
    pub tree: u64,
}

impl MemoryNeed {
    /// All together.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.mesh + self.records + self.tree
    }
}

impl Inspection {
    /// Looks at a mesh as it was read, curved with these options.
    #[must_use]
    pub fn new(loaded: Loaded, options: &CurvedOptions) -> Inspection {
        let Loaded { mesh, report, .. } = loaded;
        Inspection::of(report, &CurvedMesh::new(Arc::new(mesh), options))
    }

    /// Looks at a curved mesh, whose file this was found in.
    #[must_use]
    pub fn of(report: LoadReport, curved: &CurvedMesh) -> Inspection {
        let mesh = curved.mesh();
        let triangles = mesh.triangles().len() as u64;
        Inspection {
            report,
            triangles,
            vertices: mesh.positions().len() as u64,
            bounds: mesh.bounds(),
            origin: mesh.origin(),
            edges: EdgeLengths::of(mesh),
            topology: *curved.topology(),
            t_junctions: match curved.topology().boundary {
                0 => 0,
                _ => t_junctions(mesh, &Topology::new(mesh)),
            },
            kinds: *curved.kinds(),
            spheres: *curved.spheres(),
            heights: SurfaceHeights::of(curved),
            memory: MemoryNeed {
                mesh: mesh.memory() as u64,
                records: curved.memory() as u64,
                tree: TREE_BYTES * u64::from(curved.primitives()) + flat_geometry_bytes(curved),
            },
        }
    }
}

impl EdgeLengths {
    fn of(mesh: &Mesh) -> EdgeLengths {
        let (mut least, mut greatest, mut sum) = (f64::INFINITY, 0.0f64, 0.0);
        for t in 0..mesh.triangles().len() {
            let p = mesh.triangle_positions(t).map(|p| p.as_dvec3());
            for k in 0..3 {
                let length = p[k].distance(p[(k + 1) % 3]);
                if length > 0.0 {
                    least = least.min(length);
                }
                greatest = greatest.max(length);
                sum += length;
            }
        }
        EdgeLengths {
            least: if least.is_finite() { least } else { 0.0 },
            mean: sum / (3 * mesh.triangles().len()) as f64,
            greatest,
        }
    }
}

impl SurfaceHeights {
    fn of(curved: &CurvedMesh) -> SurfaceHeights {
        let count = curved.mesh().triangles().len() as u32;
        let of_one = |triangle: u32| {
            let height = greatest_height(&curved.patch(triangle));
            let p = curved.mesh().triangle_positions(triangle as usize);
            let longest = (0..3).map(|k| p[k].distance(p[(k + 1) % 3]));
            let longest = f64::from(longest.fold(0.0, f32::max));
            SurfaceHeights {
                greatest: height,
                greatest_at: triangle,
                steepest: if longest > 0.0 { height / longest } else { 0.0 },
                steepest_at: triangle,
            }
        };
        let all = (0..count).into_par_iter().map(of_one);
        all.reduce_with(SurfaceHeights::join).unwrap_or_default()
    }

    /// The greater of both; of equal ones that over the lower triangle, so that the order in which
    /// they are joined does not matter.
    fn join(self, other: SurfaceHeights) -> SurfaceHeights {
        let mut joined = self;
        if (other.greatest, self.greatest_at) > (self.greatest, other.greatest_at) {
            (joined.greatest, joined.greatest_at) = (other.greatest, other.greatest_at);
        }
        if (other.steepest, self.steepest_at) > (self.steepest, other.steepest_at) {
            (joined.steepest, joined.steepest_at) = (other.steepest, other.steepest_at);
        }
        joined
    }
}

/// The greatest height over the patch's plane where it is measured.
fn greatest_height(patch: &Patch<f32>) -> f64 {
    if !matches!(patch.kind(), PatchKind::Curved | PatchKind::Fallback) {
        return 0.0;
    }
    let normal = patch.plane_normal();
    let base = patch.point(0.0f32, 0.0).position;
    let heights = MEASURED.map(|[u, v]| (patch.point(u, v).position - base).dot(normal).abs());
    f64::from(heights.into_iter().fold(0.0, f32::max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Loader;

    fn inspected(text: &str) -> Inspection {
        let bytes = text.as_bytes().to_vec();
        let loaded = Loader::new().load_bytes(bytes, "x.obj").unwrap();
        Inspection::new(loaded, &CurvedOptions::default())
    }

    /// A ball of four triangles with its true normals.
    const BALL: &str = "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\n\
                        vn 1 1 1\nvn 1 -1 -1\nvn -1 1 -1\nvn -1 -1 1\n\
                        f 1//1 2//2 3//3\nf 1//1 3//3 4//4\nf 1//1 4//4 2//2\nf 2//2 4//4 3//3\n";

    #[test]
    fn a_ball_is_measured() {
        let ball = inspected(BALL);
        assert_eq!((ball.triangles, ball.vertices), (4, 4));
        assert!(ball.topology.is_closed());
        assert_eq!(ball.bounds.min, glam::DVec3::splat(-1.0));
        let edge = 8f64.sqrt();
        for length in [ball.edges.least, ball.edges.mean, ball.edges.greatest] {
            assert!((length - edge).abs() < 1e-6);
        }
        // The sphere of radius sqrt(3) over planes at a distance of 1 / sqrt(3).
        let height = 3f64.sqrt() - 1.0 / 3f64.sqrt();
        assert!(
            (ball.heights.greatest - height).abs() < 1e-5,
            "{:?}",
            ball.heights
        );
        assert!((ball.heights.steepest - height / edge).abs() < 1e-5);
        assert_eq!(ball.memory.tree, 109, "one cluster of four triangles");
        assert_eq!(ball.memory.mesh, 4 * (24 + 12));
        assert_eq!(ball.memory.records, 4 * 32 + 128);
    }

    #[test]
    fn flat_triangles_have_no_height() {
        let flat = inspected("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        assert_eq!(flat.heights.greatest, 0.0);
        assert_eq!(flat.topology.boundary, 3);
    }

    #[test]
    fn joining_heights_does_not_depend_on_their_order() {
        let of = |greatest, greatest_at| SurfaceHeights {
            greatest,
            greatest_at,
            steepest: -greatest,
            steepest_at: greatest_at,
        };
        let (a, b, c) = (of(1.0, 5), of(1.0, 2), of(0.5, 0));
        let joined = a.join(b).join(c);
        assert_eq!(joined, c.join(a).join(b));
        assert_eq!((joined.greatest_at, joined.steepest_at), (2, 0));
    }
}
