//! The curved surface cut into flat triangles.

use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;
use rayon::prelude::*;

use super::curved_mesh::CurvedMesh;
use super::triangle::{is_flat, vertices};
use crate::mesh::{MAX_INDICES, Mesh, MeshError, NO_TRIANGLE, Topology};
use curvetri_method::{Patch, PatchKind, TriangleVertices, Vector};

/// A curved mesh cut into flat triangles: see [`CurvedMesh::tessellate`].
///
/// ```
/// use std::sync::Arc;
///
/// use curvetri::curved::{CurvedMesh, CurvedOptions, Tessellation};
/// use curvetri::mesh::Mesh;
/// use glam::DVec3;
///
/// let corners = vec![DVec3::X, DVec3::Y, DVec3::Z];
/// let mesh = Arc::new(Mesh::new(corners.clone(), Some(corners), vec![[0, 1, 2]])?);
/// let curved = CurvedMesh::new(mesh, &CurvedOptions::default());
/// let fine: Tessellation = curved.tessellate(4)?;
/// assert_eq!((fine.level(), fine.mesh().triangles().len()), (4, 16));
/// assert_eq!(fine.vertex(0, [4, 0]), 1); // all of the four steps towards the second corner
/// # Ok::<(), curvetri::mesh::MeshError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Tessellation {
    mesh: Mesh,
    lattices: Lattices,
}

/// Where the vertices of the triangles' lattices are.
///
/// The coarse mesh's vertices come first. Then each triangle in turn has those within its edges, of
/// the edges that are its own, and those within itself.
#[derive(Debug, Clone)]
struct Lattices {
    level: u32,
    /// The coarse triangles.
    triangles: Vec<[u32; 3]>,
    /// The first of a triangle's own vertices.
    starts: Vec<u32>,
    /// The first vertex within each edge.
    edges: Vec<[u32; 3]>,
}

impl CurvedMesh {
    /// Cuts every edge into `level` parts and every triangle into `level²` flat triangles, whose
    /// vertices lie on the curved surface and have its normals; those of the mesh keep their own.
    ///
    /// Triangle `i` becomes the triangles from `i level²` on. Triangles that share a curved edge share
    /// its vertices. Where an edge is straight both have vertices of their own in the same places, bit
    /// for bit, since the normals differ. A mesh that is closed stays closed.
    ///
    /// # Errors
    /// [`MeshError::TooManyIndices`].
    ///
    /// # Panics
    /// If `level` is 0.
    pub fn tessellate(&self, level: u32) -> Result<Tessellation, MeshError> {
        assert!(level > 0, "an edge is cut into one part at the least");
        let coarse = self.mesh.triangles();
        let indices = 3 * coarse.len() as u64 * u64::from(level).pow(2);
        if indices > MAX_INDICES {
            return Err(MeshError::TooManyIndices { indices });
        }
        let topology = Topology::new(&self.mesh);
        let lattices = self.lattices(&topology, level);
        let (positions, normals): (Vec<Vec3>, Vec<Vec3>) = (0..coarse.len())
            .into_par_iter()
            .flat_map_iter(|triangle| self.own_vertices(&topology, &lattices, triangle))
            .unzip();
        let triangles = (0..coarse.len())
            .into_par_iter()
            .flat_map_iter(|triangle| lattices.pieces(triangle))
            .collect();
        let mesh = Mesh::from_local(
            self.mesh.origin(),
            [self.mesh.positions(), &positions].concat(),
            [self.mesh.normals(), &normals].concat(),
            triangles,
        );
        Ok(Tessellation { mesh, lattices })
    }

    /// Numbers the vertices.
    fn lattices(&self, topology: &Topology, level: u32) -> Lattices {
        let triangles = self.mesh.triangles().to_vec();
        let owned: Vec<[bool; 3]> = (0..triangles.len())
            .into_par_iter()
            .map(|triangle| [0, 1, 2].map(|k| self.owner(topology, triangle, k).is_none()))
            .collect();
        let within_edge = level - 1;
        let within = within_edge * level.saturating_sub(2) / 2;
        let mut next = self.mesh.positions().len() as u32;
        let mut starts = Vec::with_capacity(triangles.len());
        let mut edges = Vec::with_capacity(triangles.len());
        for owned in &owned {
            starts.push(next);
            edges.push([0, 1, 2].map(|k| {
                let first = next;
                next += if owned[k] { within_edge } else { 0 };
                first
            }));
            next += within;
        }
        let lent: Vec<[u32; 3]> = (0..triangles.len())
            .into_par_iter()
            .map(|triangle| {
                [0, 1, 2].map(|k| match self.owner(topology, triangle, k) {
                    Some((owner, edge)) => edges[owner][edge],
                    None => edges[triangle][k],
                })
            })
            .collect();
        Lattices {
            level,
            triangles,
            starts,
            edges: lent,
        }
    }

    /// The neighbour that has the vertices of a triangle's edge, and which of its edges that is;
    /// `None` if they are the triangle's own.
    fn owner(&self, topology: &Topology, triangle: usize, k: usize) -> Option<(usize, usize)> {
        let neighbour = topology.neighbours(triangle)[k];
        let first = neighbour == NO_TRIANGLE || neighbour as usize >= triangle;
        if first || self.straight(topology, triangle, k) {
            return None;
        }
        let owner = neighbour as usize;
        let (ours, theirs) = (
            self.mesh.triangle_positions(triangle),
            self.mesh.triangle_positions(owner),
        );
        (0..3)
            .find(|&edge| theirs[edge] == ours[(k + 1) % 3] && theirs[(edge + 1) % 3] == ours[k])
            .filter(|&edge| !self.straight(topology, owner, edge))
            .map(|edge| (owner, edge))
    }

    /// Whether an edge is straight, or so nearly that its neighbour, being flat, has it straight.
    fn straight(&self, topology: &Topology, triangle: usize, k: usize) -> bool {
        let record = &self.records[triangle];
        let beside = self.records.get(topology.neighbours(triangle)[k] as usize);
        record.flags().is_straight(k) || is_flat(record) || beside.is_some_and(is_flat)
    }

    /// The positions and normals of a triangle's own vertices in the order of their numbers.
    fn own_vertices(
        &self,
        topology: &Topology,
        lattices: &Lattices,
        triangle: usize,
    ) -> impl Iterator<Item = (Vec3, Vec3)> {
        let (level, start) = (lattices.level, lattices.starts[triangle]);
        let patch = self.patch(triangle as u32);
        let mut own = Vec::new();
        for k in 0..3 {
            if lattices.edges[triangle][k] < start {
                continue;
            }
            for part in 1..level {
                let (position, normal) = self.at(&patch, triangle, on_edge(level, k, part), level);
                let straight = self.straight(topology, triangle, k);
                let position = if straight {
                    self.on_straight_edge(triangle, k, part, level)
                } else {
                    position
                };
                own.push((position, normal));
            }
        }
        for j in 1..level {
            own.extend((1..level - j).map(|i| self.at(&patch, triangle, [i, j], level)));
        }
        own.into_iter()
    }

    /// Position and normal at a point of a triangle's lattice.
    fn at(
        &self,
        patch: &Patch<f32>,
        triangle: usize,
        [i, j]: [u32; 2],
        level: u32,
    ) -> (Vec3, Vec3) {
        let [u, v] = [i, j].map(|n| (f64::from(n) / f64::from(level)) as f32);
        if patch.kind() == PatchKind::Degenerate {
            let TriangleVertices { positions, normals } = vertices(&self.mesh, triangle);
            let mix = |x: [Vector<f32>; 3]| {
                let [a, b, c] = x.map(Vec3::from);
                a * (1.0 - u - v) + b * u + c * v + Vec3::ZERO
            };
            return (mix(positions), mix(normals).normalize_or(Vec3::Z));
        }
        // With the processor's fused products.
        let point = dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || patch.point(u, v)
        ));
        // Adding zero turns -0 into +0, so that equal positions have equal bits.
        let [position, normal] = [point.position, point.normal].map(|x| Vec3::from(x) + Vec3::ZERO);
        (position, normal)
    }

    /// A point of a straight edge: the same bits for both of its triangles.
    fn on_straight_edge(&self, triangle: usize, k: usize, part: u32, level: u32) -> Vec3 {
        let positions = self.mesh.triangle_positions(triangle);
        let (mut from, mut to, mut part) = (positions[k], positions[(k + 1) % 3], part);
        if from.to_array() > to.to_array() {
            (from, to, part) = (to, from, level - part);
        }
        from + (to - from) * (part as f32 / level as f32) + Vec3::ZERO
    }
}

/// The place in a triangle's lattice that is so many parts along an edge.
fn on_edge(level: u32, edge: usize, part: u32) -> [u32; 2] {
    match edge {
        0 => [part, 0],
        1 => [level - part, part],
        _ => [0, level - part],
    }
}

impl Lattices {
    /// The vertex at `i` parts of a triangle's way to its second corner and `j` of that to its third.
    fn vertex(&self, triangle: usize, [i, j]: [u32; 2]) -> u32 {
        let level = self.level;
        let along = |k: usize, part: u32| {
            let first = self.edges[triangle][k];
            // a neighbour that lends its vertices goes the other way
            let lent = first < self.starts[triangle];
            first + if lent { level - part } else { part } - 1
        };
        let k = level - i - j;
        match [i, j, k] {
            [0, 0, _] => self.triangles[triangle][0],
            [_, 0, 0] => self.triangles[triangle][1],
            [0, _, 0] => self.triangles[triangle][2],
            [_, 0, _] => along(0, i),
            [_, _, 0] => along(1, j),
            [0, _, _] => along(2, level - j),
            _ => {
                let owned = (0..3).filter(|&k| self.edges[triangle][k] >= self.starts[triangle]);
                let edges = owned.count() as u32 * (level - 1);
                // rows below have level - 2, level - 3, ... points within
                let rows = (j - 1) * (2 * level - 2 - j) / 2;
                self.starts[triangle] + edges + rows + i - 1
            }
        }
    }

    /// The fine triangles of a coarse one, row by row.
    fn pieces(&self, triangle: usize) -> impl Iterator<Item = [u32; 3]> {
        let level = self.level;
        let at = move |i, j| self.vertex(triangle, [i, j]);
        (0..level).flat_map(move |j| {
            (0..level - j).flat_map(move |i| {
                let upright = [at(i, j), at(i + 1, j), at(i, j + 1)];
                let inverted =
                    (i + j + 1 < level).then(|| [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                std::iter::once(upright).chain(inverted)
            })
        })
    }
}

impl Tessellation {
    /// The flat triangles.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The flat triangles alone.
    #[must_use]
    pub fn into_mesh(self) -> Mesh {
        self.mesh
    }

    /// Into how many parts each edge was cut.
    #[must_use]
    pub fn level(&self) -> u32 {
        self.lattices.level
    }

    /// The vertex of [`mesh`](Self::mesh) that is `steps[0]` of [`level`](Self::level) parts of the way
    /// from a coarse triangle's first corner to its second, and `steps[1]` parts of that to its third.
    ///
    /// # Panics
    /// If there is no such coarse triangle, or the steps are more than `level` together.
    #[must_use]
    pub fn vertex(&self, triangle: usize, steps: [u32; 2]) -> u32 {
        self.lattices.vertex(triangle, steps)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::curved::CurvedOptions;
    use curvetri_bodies::{Blob, capped_cone, capped_cylinder};
    use curvetri_method::Surface;

    fn curved(mesh: Mesh, surface: Surface) -> CurvedMesh {
        let options = CurvedOptions {
            surface,
            ..CurvedOptions::default()
        };
        CurvedMesh::new(Arc::new(mesh), &options)
    }

    #[test]
    fn closed_meshes_stay_closed() {
        let blob = Blob {
            rim: true,
            split: true,
            ..Blob::default()
        };
        for mesh in [blob.mesh(), capped_cylinder(12, 1.5), capped_cone(9, 1.0)] {
            for surface in Surface::ALL {
                let curved = curved(mesh.clone(), surface);
                for level in [1, 2, 3, 7] {
                    let fine = curved.tessellate(level).unwrap().into_mesh();
                    let count = mesh.triangles().len() * (level * level) as usize;
                    assert_eq!(fine.triangles().len(), count);
                    assert_eq!(fine.positions().len(), fine.normals().len());
                    let counts = Topology::new(&fine).counts().to_owned();
                    let (before, hard) =
                        (curved.topology(), u64::from(level) * curved.topology().hard);
                    assert!(counts.is_closed() == before.is_closed(), "{counts:?}");
                    assert!(counts.hard >= hard, "{counts:?}");
                }
            }
        }
    }

    #[test]
    fn the_first_level_is_the_mesh_itself() {
        let mesh = Blob::default().mesh();
        let fine = curved(mesh.clone(), Surface::Smooth).tessellate(1).unwrap();
        assert_eq!(fine.mesh(), &mesh);
    }

    #[test]
    fn vertices_lie_where_they_belong() {
        let curved = curved(Blob::default().mesh(), Surface::Smooth);
        let level = 5;
        let fine = curved.tessellate(level).unwrap();
        for triangle in 0..curved.mesh().triangles().len() {
            let patch = curved.patch(triangle as u32);
            if patch.kind() == PatchKind::Degenerate {
                continue;
            }
            let size = patch.size();
            let lattice = (0..=level).flat_map(|j| (0..=level - j).map(move |i| [i, j]));
            for [i, j] in lattice {
                let vertex = fine.vertex(triangle, [i, j]) as usize;
                let share = |n: u32| n as f32 / level as f32;
                let there = Vec3::from(patch.point(share(i), share(j)).position);
                let off = fine.mesh().positions()[vertex].distance(there);
                assert!(off < 1e-4 * size, "{triangle} {i} {j}: {off}");
            }
        }
    }

    #[test]
    fn pieces_keep_their_triangles_winding_and_area() {
        let curved = curved(capped_cone(9, 1.0), Surface::Smooth);
        let fine = curved.tessellate(4).unwrap().into_mesh();
        let area = |mesh: &Mesh, triangle| {
            let [a, b, c] = mesh.triangle_positions(triangle);
            (b - a).cross(c - a)
        };
        for (triangle, pieces) in (0..fine.triangles().len())
            .collect::<Vec<_>>()
            .chunks(16)
            .enumerate()
        {
            let whole = area(curved.mesh(), triangle);
            let sum: Vec3 = pieces.iter().map(|&piece| area(&fine, piece)).sum();
            assert!(
                pieces
                    .iter()
                    .all(|&piece| area(&fine, piece).dot(whole) > 0.0)
            );
            assert!(sum.distance(whole) < 0.2 * whole.length(), "{triangle}");
        }
    }

    #[test]
    fn more_than_can_be_numbered_is_refused() {
        let curved = curved(capped_cone(9, 1.0), Surface::Smooth);
        assert!(matches!(
            curved.tessellate(10_000),
            Err(MeshError::TooManyIndices { .. })
        ));
    }
}
