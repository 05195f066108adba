//! The triangles around one position, grouped across edges that are no crease.

use glam::{DVec3, Vec3};

use super::disjoint_sets::DisjointSets;
use super::weights::{Areas, Face};

/// At an edge with more pairs of triangles than this no faces are joined: it is no surface, and
/// trying all pairs would be quadratic.
const MAX_PAIRS: usize = 256;

/// How many thin triangles in a row can take over a normal: passes over the fan, bounded because
/// each costs its size.
const MAX_SPREADS: usize = 8;

/// One triangle's corner at the position.
#[derive(Clone, Copy)]
struct Spoke {
    face: Face,
    triangle: u32,
}

/// Across which edges made normals are smooth.
#[derive(Clone, Copy)]
pub(super) enum Smoothness<'a> {
    /// Those where the cosine of the dihedral angle is at least this.
    Crease(f64),
    /// Those whose two triangles are of the same group, other than 0. There is one for each
    /// triangle.
    Groups(&'a [u32]),
}

/// All corners at one position.
#[derive(Default)]
pub(super) struct Fan {
    spokes: Vec<Spoke>,
    /// Spokes whose faces are smooth into each other.
    groups: DisjointSets,
    /// (place at the other end, false for the edge from here and true for that to here, spoke).
    edges: Vec<(u32, bool, u32)>,
}

impl Fan {
    /// Takes up the given corners (numbers into the flattened `triangles`), all at one place.
    pub(super) fn gather(&mut self, places: &[Vec3], triangles: &[[u32; 3]], corners: &[u32]) {
        self.gather_faces(places, triangles, corners);
        self.edges.clear();
        for (i, &corner) in (0u32..).zip(corners) {
            let [_, next, prev] = around(triangles, corner);
            self.edges.push((next, false, i));
            self.edges.push((prev, true, i));
        }
        self.edges.sort_unstable();
        self.groups.reset(corners.len());
    }

    /// The same for [`face`](Self::face) alone: the corners cannot be joined.
    pub(super) fn gather_faces(
        &mut self,
        places: &[Vec3],
        triangles: &[[u32; 3]],
        corners: &[u32],
    ) {
        self.spokes.clear();
        self.spokes.extend(corners.iter().map(|&corner| {
            let vertices = around(triangles, corner);
            Spoke {
                face: face_at(vertices.map(|v| places[v as usize].as_dvec3())),
                triangle: corner / 3,
            }
        }));
    }

    /// The face of a corner, by its place in the list that was gathered.
    pub(super) fn face(&self, corner: usize) -> Face {
        self.spokes[corner].face
    }

    /// Joins the two faces of each edge that is smooth and at which their windings agree. A triangle too thin to
    /// have a normal takes over that of a neighbour, so that it does not separate the faces beside it.
    pub(super) fn join(&mut self, smoothness: Smoothness<'_>) {
        let edges = std::mem::take(&mut self.edges);
        for _ in 0..MAX_SPREADS {
            if !self.spread_normals(&edges) {
                break;
            }
        }
        for_pairs(&edges, |a, b| {
            let [one, other] = [a, b].map(|spoke| self.spokes[spoke as usize]);
            let is_smooth = match smoothness {
                Smoothness::Crease(cosine) => one.face.normal.dot(other.face.normal) >= cosine,
                Smoothness::Groups(groups) => {
                    let [one, other] = [one, other].map(|s| groups[s.triangle as usize]);
                    one == other && one != 0
                }
            };
            if is_smooth {
                self.groups.unite(a, b);
            }
        });
        self.edges = edges;
    }

    /// Gives thin triangles their neighbour's normal; whether any got one.
    fn spread_normals(&mut self, edges: &[(u32, bool, u32)]) -> bool {
        let mut any = false;
        for_pairs(edges, |a, b| {
            let (a, b) = (a as usize, b as usize);
            let [na, nb] = [a, b].map(|spoke| self.spokes[spoke].face.normal);
            if (na == DVec3::ZERO) != (nb == DVec3::ZERO) {
                self.spokes[a].face.normal = na + nb;
                self.spokes[b].face.normal = na + nb;
                any = true;
            }
        });
        any
    }

    /// Puts the weighted normal of its group in place of each zero normal.
    pub(super) fn replace_zeros(&mut self, normals: &mut [DVec3]) {
        let mut areas = vec![Areas::NONE; self.spokes.len()];
        for i in 0..self.spokes.len() {
            let root = self.groups.root(i as u32) as usize;
            areas[root] = areas[root].with(self.spokes[i].face);
        }
        let mut sums = vec![DVec3::ZERO; self.spokes.len()];
        for i in 0..self.spokes.len() {
            let root = self.groups.root(i as u32) as usize;
            let face = self.spokes[i].face;
            sums[root] += areas[root].weight(face) * face.normal;
        }
        for (i, normal) in normals.iter_mut().enumerate() {
            if *normal == DVec3::ZERO {
                let root = self.groups.root(i as u32) as usize;
                *normal = self.group_normal(root, sums[root]);
            }
        }
    }

    /// The unit normal of a group. Where its faces cancel or have no normals, the root's; a lone
    /// degenerate triangle has no direction at all and gets the z axis.
    fn group_normal(&self, root: usize, sum: DVec3) -> DVec3 {
        if sum.length_squared() > 1e-24 {
            sum.normalize()
        } else if self.spokes[root].face.normal != DVec3::ZERO {
            self.spokes[root].face.normal
        } else {
            DVec3::Z
        }
    }
}

/// The vertices of a corner's triangle, from that corner on.
fn around(triangles: &[[u32; 3]], corner: u32) -> [u32; 3] {
    let (triangle, k) = (triangles[corner as usize / 3], corner as usize % 3);
    [triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]]
}

/// Calls `pair` for every two corners that have an edge in common in opposite directions.
fn for_pairs(edges: &[(u32, bool, u32)], mut pair: impl FnMut(u32, u32)) {
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        let (out, back) = edge.split_at(edge.partition_point(|s| !s.1));
        if out.len() * back.len() > MAX_PAIRS {
            continue;
        }
        for a in out {
            for b in back {
                if a.2 != b.2 {
                    pair(a.2, b.2);
                }
            }
        }
    }
}

/// A triangle as a face at its first corner; all zero where it is so thin that single-precision positions do
/// not determine its plane.
fn face_at(corners: [DVec3; 3]) -> Face {
    let normal = plane_normal(corners);
    if normal == DVec3::ZERO {
        return Face::default();
    }
    let [here, next, prev] = corners;
    let (a, b) = (next - here, prev - here);
    let area = a.cross(b).length();
    Face {
        normal,
        angle: area.atan2(a.dot(b)),
        area,
    }
}

/// The unit normal of a triangle, zero where it is so thin that single-precision positions do not
/// tell its plane.
pub(super) fn plane_normal([here, next, prev]: [DVec3; 3]) -> DVec3 {
    let (a, b) = (next - here, prev - here);
    let cross = a.cross(b);
    let longest_squared = a
        .length_squared()
        .max(b.length_squared())
        .max(next.distance_squared(prev));
    let reach = here.abs().max(next.abs()).max(prev.abs()).max_element();
    let longest = longest_squared.sqrt();
    let rounding = 4.0 * f64::from(f32::EPSILON) * reach;
    // The doubled area over the longest edge is the height.
    if cross.length() <= longest * rounding.max(1e-6 * longest) {
        return DVec3::ZERO;
    }
    cross.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals_at(places: &[Vec3], triangles: &[[u32; 3]], place: u32, crease: f64) -> Vec<DVec3> {
        let corners: Vec<u32> = (0u32..)
            .zip(triangles.as_flattened())
            .filter(|(_, v)| **v == place)
            .map(|(c, _)| c)
            .collect();
        let mut fan = Fan::default();
        fan.gather(places, triangles, &corners);
        fan.join(Smoothness::Crease(crease.to_radians().cos()));
        let mut normals = vec![DVec3::ZERO; corners.len()];
        fan.replace_zeros(&mut normals);
        normals
    }

    /// Two triangles over the edge 0-1, the second tilted by `degrees`.
    fn roof(degrees: f32) -> Vec<Vec3> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.0, -cos, -sin)]
    }

    #[test]
    fn faces_join_below_the_crease_angle_and_part_above_it() {
        let triangles = [[0, 1, 2], [1, 0, 3]];
        let smooth = normals_at(&roof(29.0), &triangles, 0, 30.0);
        assert_eq!(smooth[0], smooth[1]);
        let expected = DVec3::new(0.0, -14.5f64.to_radians().sin(), 14.5f64.to_radians().cos());
        assert!(smooth[0].distance(expected) < 1e-6, "{smooth:?}");
        let creased = normals_at(&roof(31.0), &triangles, 0, 30.0);
        assert!(creased[0].distance(DVec3::Z) < 1e-6);
        assert!((creased[1].angle_between(DVec3::Z).to_degrees() - 31.0).abs() < 1e-4);
    }

    #[test]
    fn normals_are_weighted_by_angle_and_not_by_number_of_triangles() {
        // A cube's corner with one of its three squares cut into two triangles at the corner.
        let places = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::Y,
            Vec3::Z,
            Vec3::new(1.0, 1.0, 0.0),
        ];
        let triangles = [[0, 1, 4], [0, 4, 2], [0, 2, 3], [0, 3, 1]];
        let normals = normals_at(&places, &triangles, 0, 180.0);
        assert!(normals[0].distance(DVec3::ONE.normalize()) < 1e-12);
    }

    #[test]
    fn faces_of_opposite_winding_do_not_join() {
        let normals = normals_at(&roof(0.0), &[[0, 1, 2], [0, 1, 3]], 0, 179.0);
        assert_eq!(normals, [DVec3::Z, -DVec3::Z]);
    }

    #[test]
    fn a_triangle_without_area_does_not_part_its_neighbours() {
        // The edge 0-1 carries a vertex 4 in the middle on one side of a triangle without area.
        let mut places = roof(20.0);
        places.push(0.5 * Vec3::X);
        let triangles = [[0, 1, 2], [1, 0, 4], [0, 3, 4], [4, 3, 1]];
        let at_0 = normals_at(&places, &triangles, 0, 30.0);
        assert_eq!(at_0[0], at_0[1]);
        assert_eq!(at_0[0], at_0[2]);
        assert!(at_0[0].is_normalized());
    }

    #[test]
    fn a_lone_triangle_without_area_still_gets_a_unit_normal() {
        let places = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X];
        assert_eq!(normals_at(&places, &[[0, 1, 2]], 0, 30.0), [DVec3::Z]);
        assert_eq!(normals_at(&places, &[[0, 0, 0]], 0, 30.0), [DVec3::Z; 3]);
    }

    #[test]
    fn a_side_with_very_many_triangles_joins_nothing() {
        let places = roof(0.0);
        let triangles: Vec<[u32; 3]> = (0..40)
            .map(|i| if i % 2 == 0 { [0, 1, 2] } else { [1, 0, 3] })
            .collect();
        let normals = normals_at(&places, &triangles, 0, 30.0);
        assert!(normals.iter().all(|n| *n == DVec3::Z));
    }
}
