//! Which triangles share an edge, and how they meet there.
//!
//! Edges are matched by the positions of their ends, bit for bit: [`RawMesh::into_mesh`] has already
//! put vertices that are meant to be one into one place. Normals and texture coordinates split
//! vertices, but not edges. What is done at each kind of edge, so that no gap opens between two
//! triangles that share one:
//!
//! | edge | the surface there |
//! |---|---|
//! | smooth: two triangles, equal normals at both ends | curved; both make the same curve of the same numbers |
//! | doubled: sheets that lie in each other | curved, each sheet joined to its own continuation |
//! | hard: two triangles, a normal differs | straight for both |
//! | flipped: the two do not agree on the front | straight for both |
//! | non-manifold: three triangles or more | straight for all |
//! | boundary: one triangle | curved as its own normals say: there is no neighbour to meet |
//! | of a triangle without area | none: no ray hits it, and the triangles beside it are neighbours |
//!
//! A **T-junction**, where a vertex lies within a longer edge of another triangle, is no shared edge
//! but three boundaries. On a curved surface they need not meet: the long edge bends away from the
//! vertex by what its triangle bulges. Such meshes have to be cut so that vertices meet vertices.
//!
//! [`RawMesh::into_mesh`]: crate::RawMesh::into_mesh

mod edge_uses;
mod snap;
mod t_junctions;
mod weld;

use std::borrow::Cow;
use std::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::{Mesh, SAME_NORMAL_ANGLE};
use edge_uses::{EdgeUse, EdgesByPlace};

pub(crate) use snap::snap;
pub use t_junctions::t_junctions;
pub(crate) use weld::Groups;
pub use weld::weld;

/// No neighbour: in place of a triangle's index.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// How a triangle meets its neighbour at an edge.
///
/// ```
/// use curvetri_mesh::EdgeKind;
///
/// assert!(EdgeKind::Hard.is_straight());
/// assert!(!EdgeKind::Smooth.is_straight());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum EdgeKind {
    /// Exactly one neighbour, with the same normals at both ends bit for bit: the curved surfaces
    /// join there.
    ///
    /// Also where several sheets lie in each other (a surface stored with both its faces, or
    /// twice): normals that are the same or opposite at both ends, to 0.1 degrees, make the same
    /// edge of all sheets, and so each sheet's two triangles are each other's neighbours. The two
    /// faces of one sheet are neighbours at its boundary.
    Smooth,
    /// Exactly one neighbour, but the normals differ at an end: a hard edge, straight for both
    /// triangles. Also the edges of a triangle that has two corners in one place. It has no
    /// neighbours: the triangles beside it are each other's.
    Hard,
    /// No neighbour: the edge is curved as its own two normals say.
    Boundary,
    /// Three or more triangles have the edge: straight for all of them.
    NonManifold,
    /// Exactly one neighbour, on whose front the edge runs in the same direction: one of the two
    /// shows its back. Straight for both.
    Flipped,
}

impl EdgeKind {
    /// Whether the edge has to be straight for the surface to stay closed there.
    #[must_use]
    pub fn is_straight(self) -> bool {
        matches!(self, Self::Hard | Self::NonManifold | Self::Flipped)
    }

    fn from_bits(bits: u16) -> EdgeKind {
        match bits & 7 {
            0 => Self::Smooth,
            1 => Self::Hard,
            2 => Self::Boundary,
            3 => Self::NonManifold,
            _ => Self::Flipped,
        }
    }
}

/// What a mesh's edges and triangles are, counted. An edge of two triangles counts once, and so
/// does one of many.
///
/// ```
/// use curvetri_mesh::{Mesh, Topology};
/// use glam::DVec3;
///
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let tetrahedron = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let counts = *Topology::new(&Mesh::new(positions, None, tetrahedron)?).counts();
/// assert_eq!((counts.hard, counts.boundary), (6, 0));
/// assert!(counts.is_closed());
/// # Ok::<(), curvetri_mesh::MeshError>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TopologyCounts {
    /// Places in space that vertices take; vertices that differ by normal only are one place.
    pub places: u64,
    /// Edges where curved surfaces join.
    pub smooth: u64,
    /// Hard edges.
    pub hard: u64,
    /// Edges with one triangle.
    pub boundary: u64,
    /// Edges with three triangles or more, other than doubled ones.
    pub non_manifold: u64,
    /// Edges with four triangles or more that are sheets lying in each other, and so smooth.
    pub doubled: u64,
    /// Edges whose two triangles do not agree on the front.
    pub flipped: u64,
    /// Triangles without area: two corners in one place, or all three on a line as far as single
    /// precision shows.
    pub degenerate_triangles: u64,
    /// Triangles with the same three places as an earlier one.
    pub duplicate_triangles: u64,
}

impl TopologyCounts {
    /// Whether each edge has exactly two triangles that agree on the front: the mesh encloses a
    /// volume.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.boundary + self.non_manifold + self.doubled + self.flipped == 0
    }

    fn plus(self, other: Self) -> Self {
        Self {
            places: self.places + other.places,
            smooth: self.smooth + other.smooth,
            hard: self.hard + other.hard,
            boundary: self.boundary + other.boundary,
            non_manifold: self.non_manifold + other.non_manifold,
            doubled: self.doubled + other.doubled,
            flipped: self.flipped + other.flipped,
            degenerate_triangles: self.degenerate_triangles + other.degenerate_triangles,
            duplicate_triangles: self.duplicate_triangles + other.duplicate_triangles,
        }
    }
}

/// Adjacency of a mesh's triangles by position.
///
/// ```
/// use curvetri_mesh::{EdgeKind, Mesh, NO_TRIANGLE, Topology};
/// use glam::DVec3;
///
/// // A square of two triangles.
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
/// let mesh = Mesh::new(positions, None, vec![[0, 1, 2], [0, 2, 3]])?;
/// let topology = Topology::new(&mesh);
/// assert_eq!(topology.edge(0, 2), EdgeKind::Smooth);
/// assert_eq!(topology.neighbours(0), [NO_TRIANGLE, NO_TRIANGLE, 1]);
/// # Ok::<(), curvetri_mesh::MeshError>(())
/// ```
///
/// Vertices in the same place are one for adjacency only, so that vertices split for their normals
/// or texture coordinates open no cracks. Edge `k` of a triangle runs from corner `k` to corner
/// `k + 1`, cyclically.
#[derive(Debug, Clone)]
pub struct Topology {
    neighbours: Vec<[u32; 3]>,
    /// Three bits an edge, edge 0 in the lowest.
    kinds: Vec<u16>,
    counts: TopologyCounts,
}

impl Topology {
    /// Finds the neighbours of all triangles and classifies all edges, in parallel.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Topology {
        let (place_of, places) = weld(&mesh.positions);
        let corners = corners(mesh, &place_of, places);
        let build = Build::new(mesh, places < place_of.len());
        let mut counts = build.match_edges(&EdgesByPlace::new(&corners, places));
        counts.places = places as u64;
        counts.degenerate_triangles = count_degenerate(mesh);
        Topology {
            kinds: build.kinds.par_iter().map(packed).collect(),
            neighbours: (build.neighbours.into_par_iter())
                .map(|edges| edges.map(AtomicU32::into_inner))
                .collect(),
            counts,
        }
    }

    /// How a triangle meets its neighbour at edge `k`.
    ///
    /// # Panics
    ///
    /// If there is no such triangle.
    #[must_use]
    pub fn edge(&self, triangle: usize, k: usize) -> EdgeKind {
        EdgeKind::from_bits(self.kinds[triangle] >> (3 * k))
    }

    /// The kinds of a triangle's three edges.
    ///
    /// # Panics
    ///
    /// If there is no such triangle.
    #[must_use]
    pub fn edges(&self, triangle: usize) -> [EdgeKind; 3] {
        [0, 1, 2].map(|k| self.edge(triangle, k))
    }

    /// The triangles at a triangle's three edges, [`NO_TRIANGLE`] where there is none or more than
    /// one.
    ///
    /// # Panics
    ///
    /// If there is no such triangle.
    #[must_use]
    pub fn neighbours(&self, triangle: usize) -> [u32; 3] {
        self.neighbours[triangle]
    }

    /// How many there are of each.
    #[must_use]
    pub fn counts(&self) -> &TopologyCounts {
        &self.counts
    }
}

/// The places of each triangle's corners.
fn corners<'a>(mesh: &'a Mesh, place_of: &[u32], places: usize) -> Cow<'a, [[u32; 3]]> {
    if places == place_of.len() {
        // Each vertex is in a place of its own, which has the same number.
        return Cow::Borrowed(&mesh.triangles);
    }
    let places = |triangle: &[u32; 3]| triangle.map(|v| place_of[v as usize]);
    mesh.triangles
        .par_iter()
        .map(places)
        .collect::<Vec<_>>()
        .into()
}

/// The three kinds in one number.
fn packed(kinds: &[AtomicU8; 3]) -> u16 {
    let [a, b, c] = [0, 1, 2].map(|k| u16::from(kinds[k].load(Relaxed)));
    a | b << 3 | c << 6
}

/// What is known of the edges so far. Every edge is written once, by whoever has its lower place.
struct Build<'a> {
    mesh: &'a Mesh,
    /// Whether several vertices are in one place.
    has_split: bool,
    neighbours: Vec<[AtomicU32; 3]>,
    kinds: Vec<[AtomicU8; 3]>,
}

impl<'a> Build<'a> {
    fn new(mesh: &'a Mesh, has_split: bool) -> Self {
        let triangles = mesh.triangles.par_iter();
        let blank = |_: &[u32; 3]| [0, 1, 2].map(|_| AtomicU32::new(NO_TRIANGLE));
        // What collapsed triangles have.
        let hard = |_: &[u32; 3]| [0, 1, 2].map(|_| AtomicU8::new(EdgeKind::Hard as u8));
        Self {
            mesh,
            has_split,
            neighbours: triangles.clone().map(blank).collect(),
            kinds: triangles.map(hard).collect(),
        }
    }

    /// Groups the edges of each lower place by the higher.
    fn match_edges(&self, edges: &EdgesByPlace) -> TopologyCounts {
        (0..edges.places())
            .into_par_iter()
            .with_min_len(1 << 10)
            .fold(
                || (TopologyCounts::default(), Vec::new()),
                |(mut counts, mut uses), place| {
                    uses.clear();
                    uses.extend(edges.of(place));
                    uses.sort_unstable();
                    for same in uses.chunk_by(|a, b| a.higher == b.higher) {
                        self.classify(same, &mut counts);
                    }
                    (counts, uses)
                },
            )
            .map(|(counts, _)| counts)
            .reduce(TopologyCounts::default, TopologyCounts::plus)
    }

    /// Classifies one edge from all its uses.
    fn classify(&self, uses: &[EdgeUse], counts: &mut TopologyCounts) {
        let kind = match uses {
            [_] => EdgeKind::Boundary,
            [a, b] => {
                self.join(a.edge, b.edge);
                self.meeting(a, b)
            }
            _ => match self.sheets(uses) {
                Some(sheets) => {
                    sheets.iter().for_each(|&[a, b]| self.join(a, b));
                    EdgeKind::Smooth
                }
                None => EdgeKind::NonManifold,
            },
        };
        for edge_use in uses {
            self.set(edge_use.edge, kind);
        }
        match kind {
            EdgeKind::Smooth if uses.len() > 2 => counts.doubled += 1,
            EdgeKind::Smooth => counts.smooth += 1,
            EdgeKind::Hard => counts.hard += 1,
            EdgeKind::Boundary => counts.boundary += 1,
            EdgeKind::NonManifold => counts.non_manifold += 1,
            EdgeKind::Flipped => counts.flipped += 1,
        }
        if uses.len() > 1 {
            counts.duplicate_triangles += duplicates(uses);
        }
    }

    /// Makes two triangles neighbours at an edge.
    fn join(&self, a: u32, b: u32) {
        for (edge, other) in [(a, b), (b, a)] {
            self.neighbours.as_flattened()[edge as usize].store(other / 3, Relaxed);
        }
    }

    /// How the only two triangles at an edge meet.
    fn meeting(&self, a: &EdgeUse, b: &EdgeUse) -> EdgeKind {
        let same_direction = a.rises == b.rises;
        let same_normals = !self.has_split || self.ends(a) == self.ends(b);
        if same_direction && !(same_normals && self.is_backward(a.edge) != self.is_backward(b.edge))
        {
            EdgeKind::Flipped
        } else if same_normals || self.have_opposite_normals(a, b) {
            EdgeKind::Smooth
        } else {
            EdgeKind::Hard
        }
    }

    fn have_opposite_normals(&self, a: &EdgeUse, b: &EdgeUse) -> bool {
        let ([a0, a1], [b0, b1]) = (self.ends(a), self.ends(b));
        self.are_opposite(a0, b0) && self.are_opposite(a1, b1)
    }

    /// Pairs the edges of three triangles or more if they are those of sheets lying in each other.
    fn sheets(&self, uses: &[EdgeUse]) -> Option<Vec<[u32; 2]>> {
        // The ends in one order for all, and which way the edge runs on the front that the
        // normals show: two triangles of one sheet have the same ends and opposite ways.
        let on_front = |edge_use: &EdgeUse| edge_use.rises != self.is_backward(edge_use.edge);
        let mut edges: Vec<([u32; 2], bool, u32)> = uses
            .iter()
            .map(|edge_use| (self.ends(edge_use), on_front(edge_use), edge_use.edge))
            .collect();
        let first = edges[0].0;
        let agrees = |end: u32, with: u32| end == with || self.are_opposite(end, with);
        let all_agree = edges.iter().all(|(ends, ..)| {
            // Not one end the same and the other opposite.
            *ends == first || (0..2).all(|i| agrees(ends[i], first[i]) && ends[i] != first[i])
        });
        if !all_agree {
            return None;
        }
        edges.sort_unstable();
        let mut pairs = Vec::with_capacity(edges.len() / 2);
        for sheet in edges.chunk_by(|a, b| a.0 == b.0) {
            let (falling, rising) = sheet.split_at(sheet.partition_point(|edge| !edge.1));
            if falling.len() != rising.len() {
                return None;
            }
            pairs.extend(falling.iter().zip(rising).map(|(a, b)| [a.2, b.2]));
        }
        Some(pairs)
    }

    /// Whether two vertices have opposite normals, as nearly as normals are made one.
    fn are_opposite(&self, a: u32, b: u32) -> bool {
        let normals = &self.mesh.normals;
        let sum = normals[a as usize] + normals[b as usize];
        f64::from(sum.length()) < SAME_NORMAL_ANGLE
    }

    /// The vertices a triangle's edge runs between, that in the lower place first.
    fn ends(&self, edge_use: &EdgeUse) -> [u32; 2] {
        let t = self.mesh.triangles[edge_use.edge as usize / 3];
        let k = edge_use.edge as usize % 3;
        let (from, to) = (t[k], t[(k + 1) % 3]);
        if edge_use.rises {
            [from, to]
        } else {
            [to, from]
        }
    }

    /// Whether a triangle's own normals say that its front is where it winds clockwise. The method
    /// goes by the normals, so two triangles of different winding still join if one is backward.
    fn is_backward(&self, edge: u32) -> bool {
        let triangle = edge as usize / 3;
        let sum: Vec3 = self.mesh.triangle_normals(triangle).iter().sum();
        doubled_area(self.mesh.triangle_positions(triangle)).dot(sum.as_dvec3()) < 0.0
    }

    fn set(&self, edge: u32, kind: EdgeKind) {
        self.kinds.as_flattened()[edge as usize].store(kind as u8, Relaxed);
    }
}

/// Counts triangles of the same three places once, at the edge between their lower two.
fn duplicates(uses: &[EdgeUse]) -> u64 {
    let counted = |edge_use: &&EdgeUse| edge_use.opposite > edge_use.higher;
    if let [a, b] = uses {
        return u64::from(a.opposite == b.opposite && counted(&a));
    }
    let mut opposite: Vec<u32> = (uses.iter().filter(counted)).map(|u| u.opposite).collect();
    opposite.sort_unstable();
    opposite.windows(2).filter(|w| w[0] == w[1]).count() as u64
}

/// Triangles that are lower than what single precision leaves uncertain in their positions.
pub(crate) fn count_degenerate(mesh: &Mesh) -> u64 {
    let triangles = (0..mesh.triangles.len()).into_par_iter();
    let degenerate = triangles.filter(|&t| is_degenerate(mesh.triangle_positions(t)));
    degenerate.count() as u64
}

fn doubled_area(positions: [Vec3; 3]) -> glam::DVec3 {
    let [a, b, c] = positions.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// Whether a triangle is lower than what single precision leaves uncertain in its positions.
fn is_degenerate(positions: [Vec3; 3]) -> bool {
    let [a, b, c] = positions;
    let longest = (b - a)
        .length_squared()
        .max((c - b).length_squared())
        .max((a - c).length_squared());
    let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
    let rounding = f64::from(f32::EPSILON) * f64::from(reach);
    doubled_area(positions).length() <= f64::from(longest).sqrt() * rounding
}

#[cfg(test)]
mod tests;
