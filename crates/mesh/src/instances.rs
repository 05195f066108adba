//! Meshes and their instances.

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::mesh::{Mesh, holds_length, holds_shape, longest_edge};

/// Meshes, each once, and where they are placed.
///
/// ```
/// use curvetri_mesh::{Mesh, Parts, Placement};
/// use glam::{DAffine3, DVec3};
///
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
/// let mut parts = Parts::from(Mesh::new(positions, None, vec![[0, 1, 2]])?);
/// parts.placements.push(Placement {
///     part: 0,
///     to_user: DAffine3::from_translation(5.0 * DVec3::Z),
/// });
/// assert_eq!((parts.meshes.len(), parts.triangles()), (1, 2));
/// assert_eq!(parts.bounds().map(|bounds| bounds.max.z), Some(5.0));
/// # Ok::<(), curvetri_mesh::MeshError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Parts {
    /// The meshes, each in a space of its own.
    pub meshes: Vec<Mesh>,
    /// Where they are placed.
    pub placements: Vec<Placement>,
}

/// One instance of a mesh.
///
/// ```
/// use curvetri_mesh::Placement;
///
/// assert!(Placement::in_place(3).is_in_place());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The mesh's number among the parts.
    pub part: usize,
    /// From the mesh's space ([`Mesh::origin`] taken into account) to the user's. It may mirror: a
    /// triangle's front stays its front.
    pub to_user: DAffine3,
}

impl Placement {
    /// A part that is in the user's space as it is.
    pub fn in_place(part: usize) -> Placement {
        Placement {
            part,
            to_user: DAffine3::IDENTITY,
        }
    }

    /// Whether the part is in the user's space as it is.
    pub fn is_in_place(&self) -> bool {
        self.to_user == DAffine3::IDENTITY
    }

    /// A box around where a box is put.
    fn box_of(&self, own: &Bounds) -> Bounds {
        if self.is_in_place() {
            return *own;
        }
        let corners = own.corners().into_iter();
        Bounds::around(corners.map(|p| self.to_user.transform_point3(p)))
    }

    /// The bounds of a mesh's vertices where they are put.
    fn bounds_of(&self, mesh: &Mesh) -> Bounds {
        if self.is_in_place() {
            return mesh.bounds();
        }
        let place = |p: &Vec3| self.to_user.transform_point3(mesh.origin() + p.as_dvec3());
        Bounds::around(mesh.positions().iter().map(place))
    }
}

impl Parts {
    /// Puts other parts behind these.
    pub fn append(&mut self, other: Parts) {
        let first = self.meshes.len();
        self.meshes.extend(other.meshes);
        let placements = other.placements.into_iter().map(|placement| Placement {
            part: first + placement.part,
            ..placement
        });
        self.placements.extend(placements);
    }

    /// How many triangles all instances have together.
    pub fn triangles(&self) -> usize {
        let of = |placement: &Placement| self.meshes[placement.part].triangles().len();
        self.placements.iter().map(of).sum()
    }

    /// The bounds of all vertices where they are placed, in the user's space; `None` if there is
    /// no placement.
    pub fn bounds(&self) -> Option<Bounds> {
        Some(self.extent()?.0)
    }

    /// Whether each mesh is placed only once, in the user's space as it is. Such meshes can be
    /// geometries of a scene themselves, around one origin, while others are instances.
    #[must_use]
    pub fn placed_once(&self) -> Vec<bool> {
        let mut placements = vec![0_usize; self.meshes.len()];
        for placement in &self.placements {
            // Any transform makes an instance, as two placements do.
            placements[placement.part] += if placement.is_in_place() { 1 } else { 2 };
        }
        placements.into_iter().map(|count| count == 1).collect()
    }

    /// The origin that all meshes which are [placed once](Parts::placed_once) can share: their own
    /// where they have the same, so that not a bit of them changes, and there is nothing else.
    /// Otherwise one that suits these bounds, those of all.
    ///
    /// # Panics
    ///
    /// If there are no meshes.
    #[must_use]
    pub fn common_origin(&self, bounds: &Bounds) -> DVec3 {
        let first = self.meshes[0].origin();
        let same = self.meshes.iter().all(|mesh| mesh.origin() == first);
        if same && self.placed_once().iter().all(|&once| once) {
            first
        } else {
            bounds.local_origin()
        }
    }

    /// Triangles so small, and so far from the [common origin](Parts::common_origin), that single
    /// precision around it moves their corners, or rays at them, by more than a fiftieth of their
    /// longest edge. What that loses is lost where the meshes share a scene; each alone is as it was.
    ///
    /// Instances keep their shape, and only rays lose digits; all triangles of one count, or none, by
    /// their median size.
    #[must_use]
    pub fn imprecise_triangles(&self) -> u64 {
        let Some(bounds) = self.bounds() else {
            return 0;
        };
        let origin = self.common_origin(&bounds);
        let placed_once = self.placed_once();
        let moved = self.meshes.iter().zip(&placed_once);
        let moved = moved.filter(|(mesh, once)| **once && mesh.origin() != origin);
        let imprecise = |mesh: &Mesh| {
            let shift = mesh.origin() - origin;
            let triangles = (0..mesh.triangles().len()).into_par_iter();
            let is_imprecise = |&triangle: &usize| {
                let corners = mesh.triangle_positions(triangle).map(|p| p.as_dvec3());
                !holds_shape(corners, corners.map(|p| p + shift))
            };
            triangles.filter(is_imprecise).count() as u64
        };
        let once: u64 = moved.map(|(mesh, _)| imprecise(mesh)).sum();
        let sizes: Vec<f64> = (self.meshes.iter().zip(&placed_once))
            .map(|(mesh, &once)| if once { 0.0 } else { median_edge(mesh) })
            .collect();
        let own: Vec<Bounds> = self.meshes.iter().map(Mesh::bounds).collect();
        let of_instance = |placement: &Placement| {
            let part = placement.part;
            let scale = placement.to_user.matrix3.determinant().abs().cbrt();
            let reach = placement.box_of(&own[part]).reach_from(origin);
            let is_held = sizes[part] == 0.0 || holds_length(scale * sizes[part], reach);
            match is_held {
                true => 0,
                false => self.meshes[part].triangles().len() as u64,
            }
        };
        let instances = (self.placements.iter()).filter(|p| !placed_once[p.part]);
        once + instances.map(of_instance).sum::<u64>()
    }

    /// The bounds, and the placements' numbers, those furthest from the middle first.
    pub fn extent(&self) -> Option<(Bounds, Vec<u32>)> {
        let own: Vec<Bounds> = self.meshes.iter().map(Mesh::bounds).collect();
        let boxes: Vec<Bounds> = (self.placements.iter())
            .map(|placement| placement.box_of(&own[placement.part]))
            .collect();
        let middle = boxes.iter().copied().reduce(Bounds::union)?.centre();
        let away = |n: u32| boxes[n as usize].centre().distance_squared(middle);
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        order.sort_by(|&a, &b| away(b).total_cmp(&away(a)));
        let mut bounds = Bounds::around([]);
        for &n in &order {
            let (placement, around) = (&self.placements[n as usize], boxes[n as usize]);
            // Most are within the outermost ones' bounds, so that their vertices do not matter.
            if bounds.union(around) != bounds {
                bounds = bounds.union(placement.bounds_of(&self.meshes[placement.part]));
            }
        }
        Some((bounds, order))
    }
}

/// The median of the lengths of triangles' longest edges.
fn median_edge(mesh: &Mesh) -> f64 {
    let corners = |t| mesh.triangle_positions(t).map(|p| p.as_dvec3());
    let mut lengths: Vec<f64> = (0..mesh.triangles().len())
        .map(|t| longest_edge(corners(t)))
        .collect();
    let middle = lengths.len() / 2;
    match lengths.is_empty() {
        true => 0.0,
        false => *lengths.select_nth_unstable_by(middle, f64::total_cmp).1,
    }
}

impl From<Vec<Mesh>> for Parts {
    /// Meshes in the user's space, each placed once.
    fn from(meshes: Vec<Mesh>) -> Parts {
        Parts {
            placements: (0..meshes.len()).map(Placement::in_place).collect(),
            meshes,
        }
    }
}

impl From<Mesh> for Parts {
    /// A mesh in the user's space.
    fn from(mesh: Mesh) -> Parts {
        vec![mesh].into()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn appended_parts_keep_their_meshes() {
        let mesh = |size: f64| {
            let positions = vec![DVec3::ZERO, size * DVec3::X, size * DVec3::Y];
            Mesh::new(positions, None, vec![[0, 1, 2]]).unwrap()
        };
        let mut parts = Parts::from(vec![mesh(1.0), mesh(2.0)]);
        let mut other = Parts::from(mesh(3.0));
        other.placements.push(Placement {
            part: 0,
            to_user: DAffine3::from_scale(DVec3::NEG_ONE),
        });
        parts.append(other);
        let of: Vec<_> = (parts.placements.iter())
            .map(|p| (parts.meshes[p.part].positions()[1].x, p.is_in_place()))
            .collect();
        assert_eq!(parts.triangles(), 4);
        assert_eq!(of, [(1.0, true), (2.0, true), (3.0, true), (3.0, false)]);
    }

    #[test]
    fn meshes_too_far_apart_to_share_an_origin_are_counted() {
        let at = |x: f64| {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| p + x * DVec3::X);
            Mesh::new(corners.to_vec(), None, vec![[0, 1, 2]]).unwrap()
        };
        let imprecise = |meshes: Vec<Mesh>| Parts::from(meshes).imprecise_triangles();
        assert_eq!(imprecise(vec![at(5e6)]), 0);
        assert_eq!(imprecise(vec![at(5e6), at(5e6 + 10.0)]), 0);
        assert_eq!(imprecise(vec![at(0.0), at(5e6)]), 1);
        let far = vec![at(5e7), at(0.0), at(-5e7)];
        assert_eq!(imprecise(far.clone()), 2);
        // Rays lose the same on their way to an instance.
        let mut parts = Parts::from(far);
        parts.placements[0].to_user = DAffine3::from_translation(DVec3::Y);
        assert_eq!(parts.imprecise_triangles(), 2);
        parts.placements[0].to_user = DAffine3::from_translation(-5e7 * DVec3::X);
        assert_eq!(parts.imprecise_triangles(), 1);
        assert_eq!(Parts::default().imprecise_triangles(), 0);
    }

    #[test]
    fn bounds_are_of_vertices_where_they_are_put() {
        let positions = vec![DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), DVec3::Z];
        let mut parts = Parts::from(Mesh::new(positions, None, vec![[0, 1, 2]]).unwrap());
        // An eighth of a turn puts the second vertex on the y axis, within the box's turned corners.
        let turn = DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let moved = DAffine3::from_translation(1e6 * DVec3::X);
        parts.placements = vec![
            Placement {
                part: 0,
                to_user: moved * turn,
            },
            Placement {
                part: 0,
                to_user: DAffine3::from_translation(-0.5 * DVec3::X),
            },
        ];
        let Bounds { min, max } = parts.bounds().unwrap();
        assert!(min.distance(DVec3::new(-0.5, 0.0, 0.0)) < 1e-9, "{min}");
        assert!(
            max.distance(DVec3::new(1e6, 2_f64.sqrt(), 1.0)) < 1e-9,
            "{max}"
        );
        assert_eq!(parts.extent().unwrap().1.len(), 2);
        parts.placements.clear();
        assert_eq!(parts.bounds(), None);
    }
}
