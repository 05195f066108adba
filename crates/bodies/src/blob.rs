//! An implicit blob, cut irregularly: what stands in for meshes as people have them.

use std::collections::HashMap;

use glam::{DVec3, IVec3};

use super::splitmix::SplitMix;
use curvetri_mesh::{Mesh, NormalOptions, RawMesh};

/// Half the edge of the cube in which the blob lies.
const REACH: f64 = 1.6;

/// The level at which the sum of the balls' fields is the surface.
const LEVEL: f64 = 0.3;

/// How many balls there are: enough to make necks, dents and handles.
const BALLS: usize = 14;

/// How far the lattice's points are moved, in cells. Cubes and the tetrahedra in them stay what they
/// are up to a fifth.
const JITTER: f64 = 0.2;

/// A closed implicit surface of a few soft balls, cut by marching tetrahedra over an irregular
/// lattice, with its true normals: irregular triangles of all shapes, slivers among them.
///
/// It lies around the origin with a radius of about 1, and may be more than one piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    /// How many lattice cells there are along each axis, at least 4. There are about
    /// 12 triangles per cell of one face of the lattice.
    pub cells: usize,
    /// Which blob: its balls and its lattice.
    pub seed: u64,
    /// How near to an end, as a share of its length, a lattice edge may be crossed (0 to 0.5): the
    /// smaller, the thinner the slivers. Crossings nearer than this are moved off the level set, and
    /// have the normal of the level set they are moved to.
    pub least_share: f64,
    /// Whether the part above a plane is cut off, which leaves a flat face with a hard rim.
    pub rim: bool,
    /// Whether vertices are split along seams, as texture coordinates do: the triangles of each
    /// octant of space have vertices of their own, with the same normals up to rounding in the
    /// seventh digit.
    pub split: bool,
}

impl Default for Blob {
    fn default() -> Blob {
        Blob {
            cells: 20,
            seed: 1,
            least_share: 0.02,
            rim: false,
            split: false,
        }
    }
}

impl Blob {
    /// The blob as a mesh.
    ///
    /// # Panics
    ///
    /// If there are fewer than 4 cells, or more than 1000.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        self.raw()
            .into_mesh(&NormalOptions::default())
            .expect("a blob is a mesh")
            .0
    }

    /// The blob as a file would have it, split vertices included.
    ///
    /// # Panics
    ///
    /// If there are fewer than 4 cells, or more than 1000.
    #[must_use]
    pub fn raw(&self) -> RawMesh {
        assert!((4..=1000).contains(&self.cells), "4 to 1000 cells");
        let mut march = March::new(self);
        march.all_cubes();
        let mut raw = march.raw;
        raw.normal_corners.get_or_insert_default();
        if self.split {
            split_by_octant(&mut raw);
        }
        raw
    }
}

/// Soft balls: centres and radii.
struct Field(Vec<(DVec3, f64)>);

impl Field {
    fn new(random: &mut SplitMix) -> Field {
        let mut between = |low, high| random.between(low, high);
        Field(
            (0..BALLS)
                .map(|_| {
                    let centre = [(); 3].map(|()| between(-0.8, 0.8));
                    (centre.into(), between(0.25, 0.42))
                })
                .collect(),
        )
    }

    /// Negative inside.
    fn value(&self, p: DVec3) -> f64 {
        let sum: f64 = self.0.iter().map(|b| soft(b, p)).sum();
        LEVEL - sum
    }

    /// The unit vector in which the value grows fastest.
    fn normal(&self, p: DVec3) -> DVec3 {
        let gradient: DVec3 = self
            .0
            .iter()
            .map(|b| soft(b, p) * 2.0 / (b.1 * b.1) * (p - b.0))
            .sum();
        gradient.normalize()
    }
}

fn soft(&(centre, radius): &(DVec3, f64), p: DVec3) -> f64 {
    (-p.distance_squared(centre) / (radius * radius)).exp()
}

/// A point of the irregular lattice.
#[derive(Clone, Copy)]
struct Node {
    number: u32,
    at: DVec3,
    inside: bool,
}

struct March<'a> {
    blob: &'a Blob,
    field: Field,
    nodes: Vec<Node>,
    /// The layer at which the blob is cut off, if it is.
    lid: Option<i32>,
    /// The positions on lattice edges (from lower to higher number) and, inside the flat face, at
    /// nodes (twice the same number).
    crossings: HashMap<(u32, u32), u32>,
    raw: RawMesh,
}

impl March<'_> {
    fn new(blob: &Blob) -> March<'_> {
        let mut random = SplitMix::new(blob.seed);
        let field = Field::new(&mut random);
        // A little above the middle, through most balls.
        let lid = blob.rim.then_some((blob.cells * 3 / 5) as i32);
        let side = blob.cells as i32 + 1;
        let cell = 2.0 * REACH / blob.cells as f64;
        let mut nodes = Vec::with_capacity((side * side * side) as usize);
        for z in 0..side {
            for y in 0..side {
                for x in 0..side {
                    let mut jitter = [(); 3].map(|()| random.between(-JITTER, JITTER));
                    if Some(z) == lid {
                        jitter[2] = 0.0;
                    }
                    let place = IVec3::new(x, y, z).as_dvec3() + DVec3::from(jitter);
                    let at = cell * place - REACH;
                    nodes.push(Node {
                        number: nodes.len() as u32,
                        at,
                        inside: field.value(at) < 0.0,
                    });
                }
            }
        }
        March {
            blob,
            field,
            nodes,
            lid,
            crossings: HashMap::new(),
            raw: RawMesh::default(),
        }
    }

    fn all_cubes(&mut self) {
        let cells = self.blob.cells as i32;
        let top = self.lid.unwrap_or(cells);
        for z in 0..top {
            for y in 0..cells {
                for x in 0..cells {
                    self.cube(IVec3::new(x, y, z));
                }
            }
        }
    }

    /// Cuts a cube into the six tetrahedra along its main diagonal (Kuhn's cut), one for each
    /// order of going along the axes.
    fn cube(&mut self, corner: IVec3) {
        const ORDERS: [([usize; 3], bool); 6] = [
            ([0, 1, 2], true),
            ([1, 2, 0], true),
            ([2, 0, 1], true),
            ([0, 2, 1], false),
            ([2, 1, 0], false),
            ([1, 0, 2], false),
        ];
        for (order, even) in ORDERS {
            let mut at = corner;
            let mut places = [corner; 4];
            for (i, &axis) in order.iter().enumerate() {
                at += IVec3::AXES[axis];
                places[i + 1] = at;
            }
            // An even order makes a tetrahedron of positive volume.
            if !even {
                places.swap(2, 3);
            }
            let nodes = places.map(|p| self.node(p));
            self.tetrahedron(nodes);
            if Some(corner.z + 1) == self.lid {
                self.lid_face(places, nodes);
            }
        }
    }

    fn node(&self, place: IVec3) -> Node {
        let side = self.blob.cells as i32 + 1;
        self.nodes[((place.z * side + place.y) * side + place.x) as usize]
    }

    /// Adds the piece of the level set in a tetrahedron of positive volume.
    fn tetrahedron(&mut self, nodes: [Node; 4]) {
        // Even permutations, so that the volume stays positive, that bring a given node first.
        const FIRST: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]];
        let inside: Vec<usize> = (0..4).filter(|&i| nodes[i].inside).collect();
        match *inside {
            [one] => {
                let [a, b, c, d] = FIRST[one].map(|i| nodes[i]);
                self.polygon(&[(a, b), (a, c), (a, d)]);
            }
            [i, j] => {
                // The two inside first, the two outside in the order that keeps the volume positive.
                let outside: Vec<usize> = (0..4).filter(|k| ![i, j].contains(k)).collect();
                let odd = (i + j) % 2 == 0;
                let [k, l] = if odd {
                    [outside[1], outside[0]]
                } else {
                    [outside[0], outside[1]]
                };
                let [a, b, c, d] = [i, j, k, l].map(|i| nodes[i]);
                self.polygon(&[(a, c), (a, d), (b, d), (b, c)]);
            }
            [_, _, _] => {
                let outside = (0..4).find(|&i| !nodes[i].inside).expect("one of four");
                let [a, b, c, d] = FIRST[outside].map(|i| nodes[i]);
                self.polygon(&[(b, a), (d, a), (c, a)]);
            }
            _ => {}
        }
    }

    /// Where a tetrahedron has a face in the plane that cuts the blob off, adds the inner part of
    /// that face.
    fn lid_face(&mut self, places: [IVec3; 4], nodes: [Node; 4]) {
        let on_lid: Vec<usize> = (0..4).filter(|&i| Some(places[i].z) == self.lid).collect();
        let &[i, j, k] = on_lid.as_slice() else {
            return;
        };
        let mut face = [i, j, k].map(|i| nodes[i]);
        let [a, b, c] = face.map(|n| n.at.truncate());
        if (b - a).perp_dot(c - a) < 0.0 {
            face.swap(1, 2);
        }
        let mut outline = Vec::new();
        for (i, &from) in face.iter().enumerate() {
            let to = face[(i + 1) % 3];
            if from.inside {
                outline.push((from, from));
            }
            match (from.inside, to.inside) {
                (true, false) => outline.push((from, to)),
                (false, true) => outline.push((to, from)),
                _ => {}
            }
        }
        if outline.len() > 2 {
            let corners: Vec<u32> = outline.iter().map(|&edge| self.crossing(edge)).collect();
            let up = self.raw.normals.len() as u32;
            self.raw.normals.push(DVec3::Z);
            self.fan(&corners, &vec![up; corners.len()]);
        }
    }

    /// Adds a polygon of crossings of lattice edges, each from inside to outside.
    fn polygon(&mut self, edges: &[(Node, Node)]) {
        let corners: Vec<u32> = edges.iter().map(|&edge| self.crossing(edge)).collect();
        let first = self.raw.normals.len() as u32;
        for &corner in &corners {
            let at = self.raw.positions[corner as usize];
            self.raw.normals.push(self.field.normal(at));
        }
        let normals: Vec<u32> = (first..).take(corners.len()).collect();
        self.fan(&corners, &normals);
    }

    fn fan(&mut self, corners: &[u32], normals: &[u32]) {
        let normal_corners = self.raw.normal_corners.get_or_insert_default();
        for i in 1..corners.len() - 1 {
            self.raw
                .corners
                .push([corners[0], corners[i], corners[i + 1]]);
            normal_corners.push([normals[0], normals[i], normals[i + 1]]);
        }
    }

    /// The position where the edge between two nodes crosses the level set; the node's own if they
    /// are one.
    fn crossing(&mut self, (inside, outside): (Node, Node)) -> u32 {
        let key = (
            inside.number.min(outside.number),
            inside.number.max(outside.number),
        );
        if let Some(&position) = self.crossings.get(&key) {
            return position;
        }
        let position = self.raw.positions.len() as u32;
        self.crossings.insert(key, position);
        let at = if inside.number == outside.number {
            inside.at
        } else {
            let least = self.blob.least_share;
            let share = self.share(inside.at, outside.at).clamp(least, 1.0 - least);
            inside.at.lerp(outside.at, share)
        };
        self.raw.positions.push(at);
        position
    }

    /// The share of the way from inside to outside at which the field is zero, by bisection.
    fn share(&self, inside: DVec3, outside: DVec3) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if self.field.value(inside.lerp(outside, middle)) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// Gives the triangles of each octant vertices and normals of their own.
fn split_by_octant(raw: &mut RawMesh) {
    let RawMesh {
        positions,
        corners,
        normals,
        normal_corners: Some(normal_corners),
        ..
    } = raw
    else {
        return;
    };
    let mut copies: HashMap<(u32, u32), u32> = HashMap::new();
    for (triangle, its_normals) in corners.iter_mut().zip(normal_corners) {
        let middle: DVec3 = triangle.iter().map(|&v| positions[v as usize]).sum();
        let octant = middle.to_array().map(|x| u32::from(x > 0.0));
        let octant = octant[0] + 2 * octant[1] + 4 * octant[2];
        for vertex in triangle {
            *vertex = *copies.entry((octant, *vertex)).or_insert_with(|| {
                positions.push(positions[*vertex as usize]);
                positions.len() as u32 - 1
            });
        }
        for normal in its_normals {
            let turned = normals[*normal as usize] + 1e-7 * f64::from(octant);
            *normal = normals.len() as u32;
            normals.push(turned);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::revolution::tests::check_closed;

    #[test]
    fn blobs_are_closed_and_smooth() {
        for seed in 1..6 {
            let mesh = Blob {
                seed,
                ..Blob::default()
            }
            .mesh();
            assert!(mesh.triangles().len() > 1000);
            assert_eq!(check_closed(&mesh, -1.0).hard, 0);
        }
    }

    #[test]
    fn triangles_are_irregular_with_slivers_among_them() {
        let mesh = Blob::default().mesh();
        // Height over longest side, 0.87 for an equilateral triangle.
        let mut shapes: Vec<f32> = (0..mesh.triangles().len())
            .map(|t| {
                let [a, b, c] = mesh.triangle_positions(t);
                let longest = (b - a).length().max((c - b).length()).max((a - c).length());
                (b - a).cross(c - a).length() / (longest * longest)
            })
            .collect();
        shapes.sort_by(f32::total_cmp);
        let share =
            |below: f32| shapes.partition_point(|&s| s < below) as f32 / shapes.len() as f32;
        assert!(share(0.05) > 0.01 && share(0.2) > 0.1 && share(0.5) < 0.9);
    }

    #[test]
    fn vertices_lie_on_the_level_set_unless_moved_off_it() {
        let blob = Blob {
            least_share: 0.0,
            ..Blob::default()
        };
        let field = Field::new(&mut SplitMix::new(blob.seed));
        for p in blob.raw().positions {
            assert!(field.value(p).abs() < 1e-9);
        }
    }

    #[test]
    fn a_rim_is_hard_and_its_face_flat() {
        for seed in 1..6 {
            let blob = Blob {
                seed,
                rim: true,
                ..Blob::default()
            };
            let mesh = blob.mesh();
            let counts = check_closed(&mesh, -1.0);
            assert!(counts.hard > 20, "{counts:?}");
            let top = mesh.bounds().max.z as f32;
            let on_top = (0..mesh.triangles().len())
                .filter(|&t| mesh.triangle_normals(t) == [glam::Vec3::Z; 3])
                .inspect(|&t| assert!(mesh.triangle_positions(t).iter().all(|p| p.z == top)))
                .count();
            assert!(on_top > 20, "{on_top}");
        }
    }

    #[test]
    fn split_vertices_open_nothing() {
        let blob = Blob {
            rim: true,
            ..Blob::default()
        };
        let split = Blob {
            split: true,
            ..blob
        };
        assert!(split.raw().positions.len() > blob.raw().positions.len() + 100);
        let (whole, split) = (blob.mesh(), split.mesh());
        assert_eq!(check_closed(&split, -1.0), check_closed(&whole, -1.0));
        assert_eq!(split.positions().len(), whole.positions().len());
    }
}
