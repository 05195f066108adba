//! What a file holds: its meshes, each once, and where they are placed.

use glam::{DAffine3, DMat3, DVec3};

use crate::bounds::Bounds;
use crate::error::{Fault, MAX_INDICES, MeshError};
use crate::instances::Placement;
use crate::normals::NO_NORMAL;
use crate::raw_mesh::RawMesh;

/// The most triangles that copies of the same meshes may add up to.
const MAX_FLATTENED: u64 = 50_000_000;
/// Placements that stretch one direction this many times as much as another, that grow or shrink by
/// more than this, or that put a mesh further out, are applied to a copy in double precision: rays
/// would lose their digits, or leave Embree's range, on the way to the mesh's space.
const MOST_STRETCH: f64 = 1e4;
const MOST_SCALE: f64 = 1e6;
const FURTHEST: f64 = 1e11;

/// Meshes and where they are placed.
#[derive(Debug, Default)]
pub(crate) struct Model {
    pub parts: Vec<RawMesh>,
    pub placements: Vec<Placement>,
}

impl From<RawMesh> for Model {
    /// One mesh in the user's space.
    fn from(raw: RawMesh) -> Model {
        Model {
            parts: vec![raw],
            placements: vec![Placement::in_place(0)],
        }
    }
}

impl Model {
    /// Puts all placements of all meshes into one, in the user's space.
    pub fn flatten(mut self) -> Result<RawMesh, Fault> {
        if let [only] = self.placements[..]
            && only.to_user == DAffine3::IDENTITY
        {
            return Ok(self.parts.swap_remove(only.part));
        }
        flattened(&self.parts, &self.placements)
    }

    /// Puts meshes that are placed once into one part, in the user's space, the first. Those that
    /// are placed more often stay parts of their own, but for placements whose transform no instance
    /// can have.
    pub fn split(mut self) -> Result<Model, Fault> {
        let has_faces = |u: &Placement| !self.parts[u.part].corners.is_empty();
        // Where there are no faces at all, the points are counted in what is said of it.
        if self.placements.iter().any(has_faces) {
            self.placements.retain(has_faces);
        }
        let mut counts = vec![0_usize; self.parts.len()];
        self.placements.iter().for_each(|u| counts[u.part] += 1);
        let boxes: Vec<_> = (self.parts.iter().zip(&counts))
            .map(|(part, &count)| {
                (count > 1).then(|| Bounds::around(part.positions.iter().copied()))
            })
            .collect();
        let fits = |u: &Placement| boxes[u.part].is_some_and(|b| can_be_instance(&u.to_user, b));
        let mut instanced = vec![0_usize; self.parts.len()];
        (self.placements.iter().filter(|u| fits(u))).for_each(|u| instanced[u.part] += 1);
        let (mut instances, rest): (Vec<_>, Vec<_>) =
            (self.placements.iter()).partition(|u| instanced[u.part] > 1 && fits(u));
        if instances.is_empty() {
            return Ok(self.flatten()?.into());
        }
        let mut split = match &rest[..] {
            [] => Model::default(),
            rest => flattened(&self.parts, rest)?.into(),
        };
        let mut new_number = vec![0; self.parts.len()];
        for (number, part) in self.parts.into_iter().enumerate() {
            if instanced[number] > 1 {
                new_number[number] = split.parts.len();
                split.parts.push(part);
            }
        }
        for instance in &mut instances {
            instance.part = new_number[instance.part];
        }
        split.placements.append(&mut instances);
        Ok(split)
    }
}

/// Whether a mesh in this box can be put there by an instance's transform.
fn can_be_instance(to_user: &DAffine3, bounds: Bounds) -> bool {
    let size = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    let [grows, shrinks] = [to_user.matrix3, to_user.matrix3.inverse()].map(size);
    let near = |p: DVec3| p.abs().max_element() <= FURTHEST;
    let mut corners = bounds.corners().into_iter();
    // NaN is not below anything.
    grows * shrinks <= MOST_STRETCH
        && grows.max(shrinks) <= MOST_SCALE
        && corners.all(|p| near(p) && near(to_user.transform_point3(p)))
}

/// Some placements of parts as one mesh.
fn flattened(parts: &[RawMesh], placements: &[Placement]) -> Result<RawMesh, Fault> {
    let size = |part: usize| parts[part].corners.len() as u64;
    let total: u64 = placements.iter().map(|u| size(u.part)).sum();
    let own: u64 = (0..parts.len()).map(size).sum();
    if 3 * total > MAX_INDICES {
        return Err(MeshError::TooManyIndices { indices: 3 * total }.into());
    }
    if total > own.max(MAX_FLATTENED) {
        return Err(Fault::Content(format!(
            "its copies of meshes add up to {total} triangles, but at most {MAX_FLATTENED} are \
             put into one mesh"
        )));
    }
    let mut raw = RawMesh::default();
    let mut normal_corners = Vec::new();
    for one in placements {
        let part = &parts[one.part];
        let vertices = raw.positions.len() + part.positions.len();
        if u32::try_from(vertices.max(raw.normals.len() + part.normals.len())).is_err() {
            return Err(Fault::Content("the mesh has too many vertices".into()));
        }
        append(part, one.to_user, &mut raw, &mut normal_corners);
    }
    raw.normal_corners = (!raw.normals.is_empty()).then_some(normal_corners);
    Ok(raw)
}

fn append(
    part: &RawMesh,
    to_user: DAffine3,
    raw: &mut RawMesh,
    normal_corners: &mut Vec<[u32; 3]>,
) {
    let linear = to_user.matrix3;
    let mirrored = linear.determinant() < 0.0;
    // The front stays the front: a mirrored triangle winds the other way.
    let wind = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    let [first, first_normal] = [raw.positions.len(), raw.normals.len()].map(|n| n as u32);
    let positions = part.positions.iter().map(|&p| to_user.transform_point3(p));
    raw.positions.extend(positions);
    let turn = normal_matrix(linear);
    raw.normals
        .extend(part.normals.iter().map(|&n| turn_normal(turn, n)));
    let corners = part.corners.iter().map(|t| wind(t.map(|v| first + v)));
    raw.corners.extend(corners);
    match &part.normal_corners {
        Some(corners) => normal_corners.extend(
            corners
                .iter()
                .map(|t| wind(t.map(|n| if n == NO_NORMAL { n } else { first_normal + n }))),
        ),
        None => normal_corners.resize(raw.corners.len(), [NO_NORMAL; 3]),
    }
}

/// The matrix of cofactors, turned so that fronts stay fronts: it is the inverse's transpose up to
/// a positive factor, and exists where that does not.
pub(crate) fn normal_matrix(m: DMat3) -> DMat3 {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if m.determinant() < 0.0 {
        -cofactors
    } else {
        cofactors
    }
}

/// A normal under a normal matrix, as long as it was: its length is checked later.
pub(crate) fn turn_normal(turn: DMat3, normal: DVec3) -> DVec3 {
    let turned = turn * normal;
    let length = turned.length();
    if length > 0.0 {
        turned * (normal.length() / length)
    } else {
        DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles, all the same, of which the first is seen from +z.
    fn part(triangles: usize) -> RawMesh {
        RawMesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            corners: vec![[0, 1, 2]; triangles],
            ..RawMesh::default()
        }
    }

    fn model(placements: &[(usize, DAffine3)]) -> Model {
        Model {
            parts: vec![part(1000), part(10), part(0), part(7)],
            placements: (placements.iter())
                .map(|&(part, to_user)| Placement { part, to_user })
                .collect(),
        }
    }

    fn moved(x: f64) -> DAffine3 {
        DAffine3::from_translation(x * DVec3::X)
    }

    #[test]
    fn copies_that_add_up_to_too_much_are_not_flattened_and_are_fine_as_instances() {
        let copies = |count: usize| model(&vec![(0, DAffine3::IDENTITY); count]);
        assert_eq!(copies(3).flatten().unwrap().corners.len(), 3000);
        let Err(Fault::Content(what)) = copies(50_001).flatten() else {
            panic!("fifty million triangles are the most");
        };
        assert_eq!(
            what,
            "its copies of meshes add up to 50001000 triangles, but at most 50000000 are put into \
             one mesh"
        );
        let refused = copies(1_000_000).flatten();
        assert!(matches!(
            refused,
            Err(Fault::Mesh(MeshError::TooManyIndices { .. }))
        ));
        let split = copies(1_000_000).split().unwrap();
        assert_eq!((split.parts.len(), split.placements.len()), (1, 1_000_000));
    }

    #[test]
    fn what_is_used_once_becomes_one_part_and_what_is_used_often_stays_apart() {
        let placements = [
            (3, moved(1.0)),
            (2, moved(9.0)),
            (1, moved(2.0)),
            (3, moved(3.0)),
            (0, moved(4.0)),
            (2, moved(9.0)),
        ];
        let split = model(&placements).split().unwrap();
        let sizes: Vec<_> = split.parts.iter().map(|p| p.corners.len()).collect();
        assert_eq!(sizes, [1010, 7]);
        assert_eq!(split.parts[0].positions[0], 2.0 * DVec3::X, "in file order");
        let placements: Vec<_> = split
            .placements
            .iter()
            .map(|u| (u.part, u.to_user))
            .collect();
        let [a, b] = [moved(1.0), moved(3.0)];
        assert_eq!(placements, [(0, DAffine3::IDENTITY), (1, a), (1, b)]);
    }

    #[test]
    fn placements_all_once_are_one_part_as_flattened() {
        let model = || model(&[(0, moved(1.0)), (1, DAffine3::from_scale(-DVec3::ONE))]);
        let split = model().split().unwrap();
        assert_eq!(split.placements, [Placement::in_place(0)]);
        assert_eq!(split.parts, [model().flatten().unwrap()]);
    }

    #[test]
    fn transforms_that_no_instance_can_have_are_applied_to_copies() {
        let scaled = |x, y, z| DAffine3::from_scale(DVec3::new(x, y, z));
        let odd = [
            scaled(1.0, 1.0, 0.0),
            scaled(1e7, 1e7, 1e7),
            scaled(1e-7, 1e-7, 1e-7),
            scaled(1e5, 1.0, 1.0),
            moved(1e12),
            moved(f64::NAN),
        ];
        let mut placements = vec![(3, moved(1.0)), (3, scaled(-2.0, 0.01, 5.0))];
        placements.extend(odd.map(|to_user| (3, to_user)));
        let split = model(&placements).split().unwrap();
        assert_eq!(split.placements.len(), 3);
        assert_eq!(split.parts[0].corners.len(), 7 * odd.len());
        // With one proper use left there is nothing to share.
        let split = model(&placements[1..]).split().unwrap();
        assert_eq!(split.placements, [Placement::in_place(0)]);
    }

    #[test]
    fn a_file_without_triangles_is_one_part_of_its_points() {
        let points = model(&[]).parts[2].positions.len();
        for (placements, points) in [(&[(2, moved(0.0))][..], points), (&[], 0)] {
            let split = model(placements).split().unwrap();
            assert_eq!(split.parts.len(), 1);
            assert!(split.parts[0].corners.is_empty());
            assert_eq!(split.parts[0].positions.len(), points);
        }
    }
}
