//! Meshes under one Embree tree.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use thiserror::Error;

use super::placed_shape::{Instance, PlacedShape};
use super::shape::{Form, Shape};
use super::stats::{MemoryParts, Times};
use super::tree::Tree;
use crate::curved::{Kinds, Spheres};
use crate::embree::{self, Device, Hit};
use crate::mesh::{Bounds, Parts};

/// Meshes under one Embree tree, in a local space: rays and hits are relative to
/// [`Scene::origin`].
///
/// What has one use, in place, is attached itself: primitive `i` of geometry `g` is triangle `i` of
/// the mesh of placement `g`. A mesh with other or more uses is curved and built once, in a tree of its
/// own, and each use is an instance of it: a hit's `inst_id` is the placement, `prim_id` the triangle,
/// and `ng` is in the mesh's space ([`Scene::normal`] is in the scene's). Instances do not know what is
/// beside them: edges along which they meet are boundaries of each. Flat triangles that are
/// [separate](crate::curved::FlatTriangles::Separate) are in geometries of their own, after all placements':
/// [`Scene::placement_of`] tells whose.
///
/// ```
/// use curvetri::embree::{QueryOptions, Ray};
/// use curvetri::mesh::{Mesh, Parts, Placement};
/// use curvetri::render::{Form, Scene, SceneError, Shape};
/// use glam::{DAffine3, DVec3, Vec3};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let device = curvetri::linked::device()?;
/// let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], None, vec![[0, 1, 2]])?;
/// let mut parts = Parts::from(vec![mesh]);
/// parts.placements.push(Placement { part: 0, to_user: DAffine3::from_translation(DVec3::Z) });
/// let scene = Scene::new(&device, parts, Form::Flat)?;
/// assert!(matches!(scene.shapes()[0], Shape::Flat(_)));
///
/// let from = DVec3::new(0.25, 0.25, 5.0) - scene.origin();
/// let ray = Ray::new(from.as_vec3(), Vec3::NEG_Z);
/// let hit = scene.tree().intersect1(&ray, &QueryOptions::default()).expect("it hits");
/// assert!((hit.t - 4.0).abs() < 1e-5);
/// assert_eq!((scene.placement_of(&hit), scene.normal(&hit)), (1, Vec3::Z));
///
/// let nothing = Scene::new(&device, Parts::default(), Form::Flat);
/// assert!(matches!(nothing.err(), Some(SceneError::Empty)));
/// # Ok(())
/// # }
/// ```
pub struct Scene {
    origin: DVec3,
    bounds: Bounds,
    shapes: Vec<Shape>,
    placed: Vec<PlacedShape>,
    outermost_first: Vec<u32>,
    tree: Tree,
    times: Times,
}

/// Why no scene could be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// There is no mesh, or none is put anywhere.
    #[error("a scene needs at least one mesh")]
    Empty,
    /// Embree refused or failed.
    #[error(transparent)]
    Embree(#[from] embree::Error),
}

impl Scene {
    /// Curves the meshes, where the form is a curved one, and builds the tree. Meshes in the user's space need no
    /// placements: `vec![mesh]` will do.
    ///
    /// # Errors
    /// If no mesh is put anywhere, an instance's transform is too extreme, or there is not enough
    /// memory.
    ///
    /// # Panics
    /// If a placement is of a mesh that is not there.
    pub fn new(device: &Device, parts: impl Into<Parts>, form: Form) -> Result<Self, SceneError> {
        Self::build(device, parts.into(), form, false)
    }

    /// The same for queries that bring a [filter](embree::QueryOptions::filter), as
    /// [`all_hits`](Self::all_hits) does; flat triangles are a little slower to trace then.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_filters(
        device: &Device,
        parts: impl Into<Parts>,
        form: Form,
    ) -> Result<Self, SceneError> {
        Self::build(device, parts.into(), form, true)
    }

    fn build(device: &Device, parts: Parts, form: Form, filters: bool) -> Result<Self, SceneError> {
        let start = Instant::now();
        let (bounds, outermost_first) = parts.extent().ok_or(SceneError::Empty)?;
        let in_place = parts.placed_once();
        let origin = parts.common_origin(&bounds);
        let Parts { meshes, placements } = parts;
        let shapes: Vec<Shape> = (meshes.into_iter().zip(&in_place))
            .map(|(mesh, &in_place)| if in_place { mesh.rebased(origin) } else { mesh })
            .map(|mesh| Shape::new(Arc::new(mesh), form))
            .collect();
        let placed: Vec<PlacedShape> = (placements.iter())
            .map(|placement| {
                let shape = placement.part;
                let away = || Instance::new(placement, shapes[shape].mesh().origin(), origin);
                PlacedShape {
                    shape,
                    instance: (!in_place[shape]).then(away),
                }
            })
            .collect();
        let curved = Instant::now();
        let tree = Tree::new(device, &shapes, &placed, filters)?;
        let times = Times {
            curve: curved - start,
            build: curved.elapsed(),
            ..Times::default()
        };
        Ok(Self {
            origin,
            bounds,
            shapes,
            placed,
            outermost_first,
            tree,
            times,
        })
    }

    /// The same meshes at the same placed in another form, without filters.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn curved_anew(self, device: &Device, form: Form) -> Result<Self, SceneError> {
        let start = Instant::now();
        let Self {
            shapes,
            placed,
            tree,
            ..
        } = self;
        drop(tree); // the memory is for the new one
        let shapes: Vec<Shape> = shapes
            .into_iter()
            .map(|shape| Shape::new(shape.into_mesh(), form))
            .collect();
        let curved = Instant::now();
        let tree = Tree::new(device, &shapes, &placed, false)?;
        Ok(Self {
            shapes,
            placed,
            tree,
            times: Times {
                curve: self.times.curve + (curved - start),
                build: self.times.build + curved.elapsed(),
                ..self.times
            },
            ..self
        })
    }

    /// By how much the largest of the placements enlarges its mesh, at the most; 1 where all are in place.
    pub fn greatest_scale(&self) -> f32 {
        let scale = |place: &PlacedShape| {
            place
                .instance
                .as_ref()
                .map_or(1.0, Instance::greatest_scale)
        };
        self.placed.iter().map(scale).fold(0.0, f32::max)
    }

    /// What rays and hits are relative to, in the user's space.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The bounds of all vertices, in the user's space; curved surfaces may bulge out of it.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The meshes, by their numbers among the parts.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The tree.
    pub fn tree(&self) -> &embree::Scene {
        &self.tree.scene
    }

    /// The number of the placement that a hit is on.
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn placement_of(&self, hit: &Hit) -> u32 {
        self.tree.placement_of(hit)
    }

    /// The mesh of a placement, by the placement's number.
    ///
    /// # Panics
    /// If there is no such placement.
    pub fn shape_at(&self, placement: u32) -> &Shape {
        &self.shapes[self.placed[placement as usize].shape]
    }

    /// The placements, with their numbers: those furthest from the middle first.
    pub(super) fn outermost_first(&self) -> impl Iterator<Item = (u32, &PlacedShape)> {
        let placed = self.outermost_first.iter();
        placed.map(|&number| (number, &self.placed[number as usize]))
    }

    pub(super) fn placed_shape(&self, hit: &Hit) -> &PlacedShape {
        &self.placed[self.placement_of(hit) as usize]
    }

    /// How many placements are instances.
    pub fn instances(&self) -> usize {
        let instances = self.placed.iter().filter(|place| place.instance.is_some());
        instances.count()
    }

    /// Triangles by kind, of all meshes; a mesh counts once, however often it is used.
    pub fn triangles(&self) -> Kinds {
        self.shapes
            .iter()
            .map(Shape::kinds)
            .fold(Kinds::default(), |a, b| a + b)
    }

    /// Curved triangles by the sphere that bounds them, of all meshes.
    pub fn spheres(&self) -> Spheres {
        self.shapes
            .iter()
            .map(Shape::spheres)
            .fold(Spheres::default(), |a, b| a + b)
    }

    /// Memory by part.
    pub fn memory(&self) -> MemoryParts {
        let sum = |of: fn(&Shape) -> usize| self.shapes.iter().map(|shape| of(shape) as u64).sum();
        MemoryParts {
            mesh: sum(|shape| shape.mesh().memory()),
            records: sum(Shape::memory) + size_of_val(&*self.placed) as u64,
            embree: self.tree().device().memory().current,
        }
    }

    /// Time to curve and to build; the other times are zero.
    pub fn times(&self) -> Times {
        self.times
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curved::{CurvedOptions, FlatTriangles};
    use crate::embree::{QueryOptions, Ray, RayPacket};
    use crate::mesh::{Mesh, Placement};
    use glam::{DAffine3, Vec3};

    /// A square of two triangles at this height, facing up.
    fn square(at: DVec3) -> Mesh {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let positions = corners.map(|p| p + at).to_vec();
        Mesh::new(positions, None, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    fn curved() -> Form {
        Form::Curved(CurvedOptions::default())
    }

    #[test]
    fn meshes_with_different_origins_keep_their_places() {
        let device = crate::linked::device().unwrap();
        let far = DVec3::new(3e6, -2e6, 5e5);
        for form in [Form::Flat, curved()] {
            let meshes = vec![square(far), square(far + DVec3::new(5.0, 0.0, 2.0))];
            assert_ne!(
                meshes[0].origin(),
                meshes[1].origin(),
                "the test needs two origins"
            );
            let scene = Scene::new(&device, meshes, form).unwrap();
            let from = far + DVec3::new(5.75, 0.5, 10.0);
            let ray = Ray::new((from - scene.origin()).as_vec3(), Vec3::NEG_Z);
            let mut packet = RayPacket::<1>::from_rays(&[ray]);
            scene
                .tree()
                .intersect(&mut packet, &QueryOptions::default());
            let hit = packet.hit(0).expect("the second square is there");
            assert_eq!((hit.geom_id, hit.prim_id), (1, 0));
            assert!((hit.t - 8.0).abs() < 1e-5, "{}", hit.t);
            assert_eq!(scene.triangles().total(), 4);
        }
    }

    #[test]
    fn separate_flat_triangles_are_known_as_those_of_their_placements() {
        let device = crate::linked::device().unwrap();
        let form = Form::Curved(CurvedOptions {
            flat: FlatTriangles::Separate,
            ..CurvedOptions::default()
        });
        let ball = curvetri_bodies::Body::sphere_tetrahedron().mesh();
        let mut parts = Parts::from(vec![ball, square(DVec3::new(9.0, 0.0, 0.0))]);
        // Once where it is, twice as an instance of another.
        parts.meshes.push(square(DVec3::ZERO));
        for x in [20.0, 30.0] {
            parts.placements.push(Placement {
                part: 2,
                to_user: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)),
            });
        }
        let scene = Scene::new(&device, parts, form).unwrap();
        assert_eq!(scene.triangles().flat(), 4);
        let hit = |x: f64, y: f64| {
            let from = DVec3::new(x, y, 5.0) - scene.origin();
            let mut packet = RayPacket::<1>::from_rays(&[Ray::new(from.as_vec3(), Vec3::NEG_Z)]);
            (scene.tree()).intersect(&mut packet, &QueryOptions::default());
            packet.hit(0).expect("something is there")
        };
        assert_eq!(scene.placement_of(&hit(0.1, 0.1)), 0, "curved");
        for (place, x) in [(1, 9.0), (2, 20.0), (3, 30.0)] {
            for (prim_id, y) in [(0, 0.25), (1, 0.75)] {
                let hit = hit(x + 0.5, y);
                assert_eq!((scene.placement_of(&hit), hit.prim_id), (place, prim_id));
                assert!((scene.normal(&hit) - Vec3::Z).length() < 1e-6);
            }
        }
    }

    #[test]
    fn a_single_mesh_is_not_moved() {
        let device = crate::linked::device().unwrap();
        let mesh = square(DVec3::new(1e6, 0.3, 0.1));
        let scene = Scene::new(&device, vec![mesh.clone()], Form::Flat).unwrap();
        assert_eq!(scene.origin(), mesh.origin());
        assert_eq!(scene.shapes()[0].mesh(), &mesh);
    }

    #[test]
    fn no_mesh_is_an_error() {
        let device = crate::linked::device().unwrap();
        let error = Scene::new(&device, Parts::default(), Form::Flat)
            .err()
            .unwrap();
        assert_eq!(error.to_string(), "a scene needs at least one mesh");
    }

    #[test]
    fn the_lowest_point_of_a_curved_body_is_below_its_vertices() {
        // A tetrahedron with the normals of its circumscribed sphere, which the method makes exact.
        let corners = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)];
        let positions: Vec<DVec3> = corners
            .map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()).normalize())
            .to_vec();
        let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        let mesh = Mesh::new(positions.clone(), Some(positions), triangles).unwrap();
        let device = crate::linked::device().unwrap();
        let scene = Scene::new(&device, vec![mesh], curved()).unwrap();
        assert!(
            (scene.lowest(Vec3::Y) + 1.0).abs() < 0.02,
            "{}",
            scene.lowest(Vec3::Y)
        );
        assert!((scene.lowest(Vec3::NEG_Z) + 1.0).abs() < 0.02);
    }
}
