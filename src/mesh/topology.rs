//! Which triangles share a side, and how they meet there.

use glam::Vec3;

use super::Mesh;
use super::weld::{Groups, weld};

/// No neighbour: in place of a triangle's index.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// How a triangle meets its neighbour at a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum SideKind {
    /// Exactly one neighbour, with the same normals at both ends bit for bit: the curved surfaces
    /// join there.
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
    /// Sides with three triangles or more.
    pub non_manifold: u64,
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
        self.boundary == 0 && self.non_manifold == 0 && self.flipped == 0
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
                self.topology.neighbours[a as usize / 3][a as usize % 3] = b / 3;
                self.topology.neighbours[b as usize / 3][b as usize % 3] = a / 3;
                self.meeting(a, b)
            }
            _ => SideKind::NonManifold,
        };
        for &(_, side) in uses {
            self.set(side, kind);
        }
        let counts = &mut self.topology.counts;
        match kind {
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
        } else if same_normals {
            SideKind::Smooth
        } else {
            SideKind::Hard
        }
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
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::{LoadOptions, RawMesh};

    fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]], crease: f32) -> Mesh {
        let raw = RawMesh {
            positions: positions.iter().map(|&p| p.into()).collect(),
            corners: triangles.to_vec(),
            ..RawMesh::default()
        };
        let options = LoadOptions {
            crease_angle_degrees: crease,
        };
        raw.into_mesh(&options).unwrap().0
    }

    const TETRAHEDRON: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_smooth_tetrahedron_has_six_smooth_sides() {
        let topology = Topology::new(&mesh(&TETRAHEDRON, &FACES, 180.0));
        let expected = TopologyCounts {
            places: 4,
            smooth: 6,
            ..TopologyCounts::default()
        };
        assert_eq!(*topology.counts(), expected);
        assert!(topology.counts().is_closed());
        assert_eq!(topology.neighbours(0), [3, 2, 1]);
        assert_eq!(topology.neighbours(2), [0, 3, 1]);
        assert_eq!(topology.sides(1), [SideKind::Smooth; 3]);
    }

    #[test]
    fn a_creased_tetrahedron_has_six_hard_sides_and_stays_closed() {
        let creased = mesh(&TETRAHEDRON, &FACES, 30.0);
        assert_eq!(creased.positions().len(), 12);
        let topology = Topology::new(&creased);
        assert_eq!(topology.counts().hard, 6);
        assert_eq!(topology.counts().places, 4);
        assert!(topology.counts().is_closed());
        assert_eq!(topology.neighbours(0), [3, 2, 1]);
        assert_eq!(topology.sides(3), [SideKind::Hard; 3]);
    }

    #[test]
    fn a_missing_face_leaves_boundaries() {
        let topology = Topology::new(&mesh(&TETRAHEDRON, &FACES[1..], 180.0));
        assert_eq!(topology.counts().boundary, 3);
        assert_eq!(topology.side(0, 0), SideKind::Boundary);
        assert_eq!(topology.neighbours(0)[0], NO_TRIANGLE);
        assert!(!topology.counts().is_closed());
    }

    #[test]
    fn a_flipped_face_has_flipped_sides() {
        let mut faces = FACES;
        faces[0].swap(0, 1);
        let topology = Topology::new(&mesh(&TETRAHEDRON, &faces, 30.0));
        assert_eq!(topology.counts().flipped, 3);
        assert_eq!(topology.counts().hard, 3);
        assert_eq!(topology.sides(0), [SideKind::Flipped; 3]);
        assert_eq!(topology.neighbours(0).map(|t| t != NO_TRIANGLE), [true; 3]);
    }

    #[test]
    fn opposite_winding_under_the_same_normals_still_joins() {
        let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]
            .map(DVec3::from)
            .to_vec();
        let normals = Some(vec![DVec3::Z; 4]);
        let mesh = Mesh::new(positions, normals, vec![[0, 1, 2], [0, 3, 2]]).unwrap();
        let topology = Topology::new(&mesh);
        assert_eq!(topology.side(0, 2), SideKind::Smooth);
        assert_eq!(topology.counts().smooth, 1);
    }

    #[test]
    fn a_surface_folded_onto_itself_is_flipped() {
        let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0.9, 0.5, 0.]]
            .map(DVec3::from)
            .to_vec();
        let normals = Some(vec![DVec3::Z; 4]);
        let mesh = Mesh::new(positions, normals, vec![[0, 1, 2], [3, 1, 2]]).unwrap();
        assert_eq!(Topology::new(&mesh).counts().flipped, 1);
    }

    #[test]
    fn three_triangles_at_a_side_are_non_manifold() {
        let mut positions = TETRAHEDRON.to_vec();
        positions.push([-1.0, -1.0, -1.0]);
        let topology = Topology::new(&mesh(&positions, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]], 30.0));
        assert_eq!(topology.counts().non_manifold, 1);
        assert_eq!(topology.counts().boundary, 6);
        for triangle in 0..3 {
            assert_eq!(topology.side(triangle, 0), SideKind::NonManifold);
            assert_eq!(topology.neighbours(triangle)[0], NO_TRIANGLE);
        }
    }

    #[test]
    fn a_triangle_with_two_corners_in_one_place_does_not_part_its_neighbours() {
        let topology = Topology::new(&mesh(
            &TETRAHEDRON,
            &[[0, 1, 2], [0, 2, 0], [2, 1, 3], [0, 2, 3]],
            180.0,
        ));
        assert_eq!(topology.counts().degenerate_triangles, 1);
        assert_eq!(topology.neighbours(0), [NO_TRIANGLE, 2, 3]);
        assert_eq!(topology.neighbours(1), [NO_TRIANGLE; 3]);
        assert_eq!(topology.sides(1), [SideKind::Hard; 3]);
        assert_eq!(topology.counts().hard, 0);
    }

    #[test]
    fn collinear_corners_are_degenerate() {
        let positions = [[0.1, 0.2, 0.3], [0.3, 0.6, 0.9], [0.7, 1.4, 2.1]];
        let topology = Topology::new(&mesh(&positions, &[[0, 1, 2]], 30.0));
        assert_eq!(topology.counts().degenerate_triangles, 1);
    }

    #[test]
    fn duplicates_are_counted_whichever_way_they_wind() {
        let faces = [FACES[0], FACES[1], [3, 0, 1], [1, 0, 3], FACES[2]];
        let topology = Topology::new(&mesh(&TETRAHEDRON, &faces, 30.0));
        assert_eq!(topology.counts().duplicate_triangles, 2);
        assert_eq!(topology.sides(1), [SideKind::NonManifold; 3]);
    }

    #[test]
    fn vertices_split_by_texture_only_are_no_edge_and_those_split_by_normal_are() {
        // A square of two triangles that share no vertex, as at a seam.
        let square = |normal: DVec3| {
            let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]].map(DVec3::from);
            let second = [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(DVec3::from);
            let normals = [[DVec3::Z; 3], [normal; 3]].concat();
            let mesh = Mesh::new(
                [positions, second].concat(),
                Some(normals),
                vec![[0, 1, 2], [3, 4, 5]],
            );
            *Topology::new(&mesh.unwrap()).counts()
        };
        assert_eq!(square(DVec3::Z).smooth, 1);
        let nearly = DVec3::new(1e-3, 0.0, 1.0);
        assert_eq!(square(nearly).smooth, 1, "0.06 degrees are made none");
        let apart = DVec3::new(2e-3, 0.0, 1.0);
        assert_eq!(square(apart).hard, 1, "0.11 degrees are an edge");
    }
}
