//! Which triangles share a side, and how they meet there.
//!
//! Sides are matched by the positions of their ends, bit for bit; [`RawMesh::into_mesh`] has put
//! vertices that are meant to be one into one place before. Normals and texture coordinates split
//! vertices, but no sides. What is done at each kind of side, so that no two triangles that share
//! one part from each other:
//!
//! | side | the surface there |
//! |---|---|
//! | smooth: two triangles, equal normals at both ends | curved; both make the same curve of the same numbers |
//! | doubled: sheets that lie in each other | curved, each sheet joined to its own continuation |
//! | hard: two triangles, a normal differs | straight on both hands |
//! | flipped: the two do not agree on the front | straight on both hands |
//! | non-manifold: three triangles or more | straight on all hands |
//! | boundary: one triangle | curved as its own normals say: nobody is there to part from |
//! | of a triangle without area | none: no ray hits it, and those beside it are each other's |
//!
//! A **T-junction**, where a vertex lies within a longer side of another triangle, is no shared side
//! but three boundaries. On a curved surface they need not meet: the long side bends away from the
//! vertex by what its triangle bulges. Such meshes have to be cut so that vertices meet vertices.
//!
//! [`RawMesh::into_mesh`]: super::RawMesh::into_mesh

use glam::Vec3;

use super::Mesh;
use super::normals::SAME_NORMAL_ANGLE;
use super::weld::{Groups, weld};

/// No neighbour: in place of a triangle's index.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// How a triangle meets its neighbour at a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum SideKind {
    /// Exactly one neighbour, with the same normals at both ends bit for bit: the curved surfaces
    /// join there.
    ///
    /// Also where several sheets lie in each other (a surface stored with both its faces, or
    /// twice): normals that are the same or opposite at both ends, to 0.1 degrees, make the same
    /// side of all sheets, and so each sheet's two triangles are each other's neighbours. The two
    /// faces of one sheet are neighbours at its boundary.
    Smooth,
    /// Exactly one neighbour, but the normals differ at an end: a hard edge, straight on both
    /// sides. Also the sides of a triangle that has two corners in one place, which has no
    /// neighbours: those beside it are each other's.
    Hard,
    /// No neighbour: the side is curved as its own two normals say.
    Boundary,
    /// Three or more triangles have the side: straight for all of them.
    NonManifold,
    /// One neighbour, on whose front the side runs in the same direction: one of the two shows its
    /// back. Straight on both sides.
    Flipped,
}

impl SideKind {
    /// Whether the side has to be straight for the surface to stay closed there.
    #[must_use]
    pub fn is_straight(self) -> bool {
        matches!(self, Self::Hard | Self::NonManifold | Self::Flipped)
    }

    fn from_bits(bits: u16) -> SideKind {
        match bits & 7 {
            0 => Self::Smooth,
            1 => Self::Hard,
            2 => Self::Boundary,
            3 => Self::NonManifold,
            _ => Self::Flipped,
        }
    }
}

/// What a mesh's sides and triangles are, counted. A side of two triangles counts once, and so
/// does one of many.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TopologyCounts {
    /// Places in space that vertices take; vertices that differ by normal only are one place.
    pub places: u64,
    /// Sides where curved surfaces join.
    pub smooth: u64,
    /// Hard edges.
    pub hard: u64,
    /// Sides with one triangle.
    pub boundary: u64,
    /// Sides with three triangles or more, other than doubled ones.
    pub non_manifold: u64,
    /// Sides with four triangles or more that are sheets lying in each other, and so smooth.
    pub doubled: u64,
    /// Sides whose two triangles do not agree on the front.
    pub flipped: u64,
    /// Triangles without area: two corners in one place, or all three on a line as far as single
    /// precision tells.
    pub degenerate_triangles: u64,
    /// Triangles with the same three places as an earlier one.
    pub duplicate_triangles: u64,
}

impl TopologyCounts {
    /// Whether each side has exactly two triangles that agree on the front: the mesh encloses a
    /// volume.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.boundary + self.non_manifold + self.doubled + self.flipped == 0
    }
}

/// Adjacency of a mesh's triangles by position.
///
/// Vertices in the same place are one for adjacency only, so that vertices split for their normals
/// or texture coordinates open no cracks. Side `k` of a triangle runs from corner `k` to corner
/// `k + 1`, cyclically.
#[derive(Debug, Clone)]
pub struct Topology {
    neighbours: Vec<[u32; 3]>,
    /// Three bits a side, side 0 in the lowest.
    kinds: Vec<u16>,
    counts: TopologyCounts,
}

impl Topology {
    /// Finds the neighbours of all triangles and classifies all sides.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Topology {
        let (place_of, places) = weld(&mesh.positions);
        let mut build = Build {
            mesh,
            place_of,
            topology: Topology {
                neighbours: vec![[NO_TRIANGLE; 3]; mesh.triangles.len()],
                kinds: vec![0; mesh.triangles.len()],
                counts: TopologyCounts {
                    places: places as u64,
                    ..TopologyCounts::default()
                },
            },
        };
        build.match_sides(places);
        build.count_degenerate();
        build.topology
    }

    /// How a triangle meets its neighbour at side `k`.
    ///
    /// # Panics
    ///
    /// If there is no such triangle.
    #[must_use]
    pub fn side(&self, triangle: usize, k: usize) -> SideKind {
        SideKind::from_bits(self.kinds[triangle] >> (3 * k))
    }

    /// The kinds of a triangle's three sides.
    ///
    /// # Panics
    ///
    /// If there is no such triangle.
    #[must_use]
    pub fn sides(&self, triangle: usize) -> [SideKind; 3] {
        [0, 1, 2].map(|k| self.side(triangle, k))
    }

    /// The triangles at a triangle's three sides, [`NO_TRIANGLE`] where there is none or more than
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

    /// The bytes the arrays take.
    #[must_use]
    pub fn memory(&self) -> usize {
        size_of_val(&*self.neighbours) + size_of_val(&*self.kinds)
    }
}

/// One use of a side by a triangle: the place at its other end, and triangle and side in one.
type Use = (u32, u32);

struct Build<'a> {
    mesh: &'a Mesh,
    place_of: Vec<u32>,
    topology: Topology,
}

impl Build<'_> {
    fn places(&self, triangle: usize) -> [u32; 3] {
        self.mesh.triangles[triangle].map(|v| self.place_of[v as usize])
    }

    /// Groups all sides by the lower of their two places, then by the higher.
    fn match_sides(&mut self, places: usize) {
        let lower_ends = (0..self.mesh.triangles.len()).flat_map(|t| {
            let p = self.places(t);
            [0, 1, 2].map(|k| p[k].min(p[(k + 1) % 3]))
        });
        let by_lower = Groups::new(lower_ends, places);
        let mut uses: Vec<Use> = Vec::new();
        for place in 0..places {
            uses.clear();
            for &side in by_lower.of(place) {
                let p = self.places(side as usize / 3);
                if p[0] == p[1] || p[1] == p[2] || p[2] == p[0] {
                    self.set(side, SideKind::Hard);
                    continue;
                }
                let k = side as usize % 3;
                uses.push((p[k].max(p[(k + 1) % 3]), side));
            }
            uses.sort_unstable();
            for same in uses.chunk_by(|a, b| a.0 == b.0) {
                self.classify(place as u32, same);
            }
        }
    }

    /// Classifies one side from all its uses.
    fn classify(&mut self, lower: u32, uses: &[Use]) {
        let kind = match *uses {
            [_] => SideKind::Boundary,
            [(_, a), (_, b)] => {
                self.join(a, b);
                self.meeting(a, b)
            }
            _ => match self.sheets(lower, uses) {
                Some(sheets) => {
                    sheets.iter().for_each(|&[a, b]| self.join(a, b));
                    SideKind::Smooth
                }
                None => SideKind::NonManifold,
            },
        };
        for &(_, side) in uses {
            self.set(side, kind);
        }
        let counts = &mut self.topology.counts;
        match kind {
            SideKind::Smooth if uses.len() > 2 => counts.doubled += 1,
            SideKind::Smooth => counts.smooth += 1,
            SideKind::Hard => counts.hard += 1,
            SideKind::Boundary => counts.boundary += 1,
            SideKind::NonManifold => counts.non_manifold += 1,
            SideKind::Flipped => counts.flipped += 1,
        }
        if uses.len() > 1 {
            self.count_duplicates(lower, uses);
        }
    }

    /// Makes two triangles neighbours at a side.
    fn join(&mut self, a: u32, b: u32) {
        self.topology.neighbours[a as usize / 3][a as usize % 3] = b / 3;
        self.topology.neighbours[b as usize / 3][b as usize % 3] = a / 3;
    }

    /// How the only two triangles at a side meet.
    fn meeting(&self, a: u32, b: u32) -> SideKind {
        let [a0, a1] = self.ends(a);
        let [b0, b1] = self.ends(b);
        let same_direction = self.place_of[a0 as usize] == self.place_of[b0 as usize];
        let (b_first, b_second) = if same_direction { (b0, b1) } else { (b1, b0) };
        // Vertices are distinct in position and normal, so equal normals are equal vertices.
        let same_normals = a0 == b_first && a1 == b_second;
        if same_direction && !(same_normals && self.is_backward(a) != self.is_backward(b)) {
            SideKind::Flipped
        } else if same_normals || self.are_opposite(a0, b_first) && self.are_opposite(a1, b_second)
        {
            SideKind::Smooth
        } else {
            SideKind::Hard
        }
    }

    /// Pairs the sides of three triangles or more if they are those of sheets lying in each other.
    fn sheets(&self, lower: u32, uses: &[Use]) -> Option<Vec<[u32; 2]>> {
        // The ends in one order for all, and which way the side runs on the front that the
        // normals show: two triangles of one sheet have the same ends and opposite ways.
        let mut sides: Vec<([u32; 2], bool, u32)> = uses
            .iter()
            .map(|&(_, side)| {
                let [from, to] = self.ends(side);
                let rises = self.place_of[from as usize] == lower;
                let ends = if rises { [from, to] } else { [to, from] };
                (ends, rises != self.is_backward(side), side)
            })
            .collect();
        let first = sides[0].0;
        let agrees = |end: u32, with: u32| end == with || self.are_opposite(end, with);
        let all_agree = sides.iter().all(|(ends, ..)| {
            // Not one end the same and the other opposite.
            *ends == first || (0..2).all(|i| agrees(ends[i], first[i]) && ends[i] != first[i])
        });
        if !all_agree {
            return None;
        }
        sides.sort_unstable();
        let mut pairs = Vec::with_capacity(sides.len() / 2);
        for sheet in sides.chunk_by(|a, b| a.0 == b.0) {
            let (falling, rising) = sheet.split_at(sheet.partition_point(|side| !side.1));
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

    /// The vertices a triangle's side runs between.
    fn ends(&self, side: u32) -> [u32; 2] {
        let t = self.mesh.triangles[side as usize / 3];
        let k = side as usize % 3;
        [t[k], t[(k + 1) % 3]]
    }

    /// Whether a triangle's own normals say that its front is where it winds clockwise. The method
    /// goes by the normals, so two triangles of different winding still join if one is backward.
    fn is_backward(&self, side: u32) -> bool {
        let triangle = side as usize / 3;
        let sum: Vec3 = self.mesh.triangle_normals(triangle).iter().sum();
        doubled_area(self.mesh.triangle_positions(triangle)).dot(sum.as_dvec3()) < 0.0
    }

    /// Counts triangles of the same three places once, at the side between their lower two.
    fn count_duplicates(&mut self, lower: u32, uses: &[Use]) {
        let higher = uses[0].0;
        let mut opposite: Vec<u32> = uses
            .iter()
            .map(|&(_, side)| self.places(side as usize / 3)[(side as usize + 2) % 3])
            .filter(|&place| place > higher && place > lower)
            .collect();
        opposite.sort_unstable();
        let repeated = opposite.windows(2).filter(|w| w[0] == w[1]).count();
        self.topology.counts.duplicate_triangles += repeated as u64;
    }

    fn set(&mut self, side: u32, kind: SideKind) {
        self.topology.kinds[side as usize / 3] |= (kind as u16) << (3 * (side % 3));
    }

    fn count_degenerate(&mut self) {
        let count = (0..self.mesh.triangles.len())
            .filter(|&t| is_degenerate(self.mesh.triangle_positions(t)))
            .count();
        self.topology.counts.degenerate_triangles = count as u64;
    }
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
#[path = "topology_tests.rs"]
mod tests;
