//! Meshes under one Embree tree.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec3};
use thiserror::Error;

use super::place::{Instance, Place};
use super::stats::{MemoryParts, Times};
use super::tree::Tree;
use crate::curved::{CurvedMesh, CurvedOptions, Kinds, Spheres};
use crate::embree::{self, Device, Geometry, GeometryBuilder, Hit, Ray};
use crate::mesh::{Bounds, Mesh, Parts};

/// What a mesh's triangles stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Themselves: Embree's own triangles.
    Flat,
    /// Curved patches.
    Curved(CurvedOptions),
}

/// A mesh in a scene.
pub enum Shape {
    /// Embree's own triangles.
    Flat(Arc<Mesh>),
    /// Curved patches.
    Curved(Arc<CurvedMesh>),
}

/// Meshes under one Embree tree, in a local space: rays and hits are relative to
/// [`Scene::origin`].
///
/// What has one use, in place, is attached itself: primitive `i` of geometry `g` is triangle `i` of
/// the mesh of placement `g`. A mesh with other or more uses is curved and built once, in a tree of its
/// own, and each use is an instance of it: a hit's `inst_id` is the placement, `prim_id` the triangle,
/// and `ng` is in the mesh's space ([`Scene::normal`] is in the scene's). Instances do not know what is
/// beside them: sides along which they meet are boundaries of each. Flat triangles that are
/// [apart](crate::curved::FlatTriangles::Apart) are in geometries of their own, after all placements':
/// [`Scene::place_of`] tells whose.
pub struct Scene {
    origin: DVec3,
    bounds: Bounds,
    shapes: Vec<Shape>,
    places: Vec<Place>,
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
    /// Embree's own reason.
    #[error(transparent)]
    Embree(#[from] embree::Error),
}

impl Scene {
    /// Curves the meshes, if asked for, and builds the tree. Meshes in the user's space need no
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
        let in_place = in_place(&parts);
        let origin = common_origin(&parts, &in_place, &bounds);
        let Parts { meshes, placements } = parts;
        let shapes: Vec<Shape> = (meshes.into_iter().zip(&in_place))
            .map(|(mesh, &in_place)| if in_place { mesh.rebased(origin) } else { mesh })
            .map(|mesh| Shape::new(Arc::new(mesh), form))
            .collect();
        let places: Vec<Place> = (placements.iter())
            .map(|placement| {
                let shape = placement.part;
                let away = || Instance::new(placement, shapes[shape].mesh().origin(), origin);
                Place {
                    shape,
                    instance: (!in_place[shape]).then(away),
                }
            })
            .collect();
        let curved = Instant::now();
        let tree = Tree::new(device, &shapes, &places, filters)?;
        let times = Times {
            curve: curved - start,
            build: curved.elapsed(),
            ..Times::default()
        };
        Ok(Self {
            origin,
            bounds,
            shapes,
            places,
            outermost_first,
            tree,
            times,
        })
    }

    /// The same meshes at the same places in another form, without filters.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn curved_anew(self, device: &Device, form: Form) -> Result<Self, SceneError> {
        let start = Instant::now();
        let Self {
            shapes,
            places,
            tree,
            ..
        } = self;
        drop(tree); // the memory is for the new one
        let shapes: Vec<Shape> = shapes
            .into_iter()
            .map(|shape| Shape::new(shape.into_mesh(), form))
            .collect();
        let curved = Instant::now();
        let tree = Tree::new(device, &shapes, &places, false)?;
        Ok(Self {
            shapes,
            places,
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
        let scale = |place: &Place| {
            place
                .instance
                .as_ref()
                .map_or(1.0, Instance::greatest_scale)
        };
        self.places.iter().map(scale).fold(0.0, f32::max)
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
    pub fn place_of(&self, hit: &Hit) -> u32 {
        self.tree.place_of(hit)
    }

    /// The mesh of a placement, by the placement's number.
    ///
    /// # Panics
    /// If there is no such placement.
    pub fn shape_at(&self, place: u32) -> &Shape {
        &self.shapes[self.places[place as usize].shape]
    }

    /// The placements, with their numbers: those furthest from the middle first.
    pub(super) fn outermost_first(&self) -> impl Iterator<Item = (u32, &Place)> {
        let places = self.outermost_first.iter();
        places.map(|&number| (number, &self.places[number as usize]))
    }

    pub(super) fn place(&self, hit: &Hit) -> &Place {
        &self.places[self.place_of(hit) as usize]
    }

    /// How many placements are instances.
    pub fn instances(&self) -> usize {
        let instances = self.places.iter().filter(|place| place.instance.is_some());
        instances.count()
    }

    /// The unit normal of a hit in the scene's space: the surface's own, on the front of the triangle
    /// by its winding (of a mirrored instance the image of the front); zero where the hit has none.
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn normal(&self, hit: &Hit) -> Vec3 {
        self.place(hit).normal(hit.ng)
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
            records: sum(Shape::memory) + size_of_val(&*self.places) as u64,
            embree: self.tree().device().memory().current,
        }
    }

    /// Time to curve and to build; the other times are zero.
    pub fn times(&self) -> Times {
        self.times
    }

    /// How far the surface may be from the point of a hit along its normal: see
    /// [`CurvedMesh::error_bound`]. On an instance, with the rounding of its transform.
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn error_bound(&self, hit: &Hit, ray: &Ray) -> f32 {
        let place = self.place(hit);
        let shape = &self.shapes[place.shape];
        let Some(instance) = &place.instance else {
            return shape.error_bound(hit.prim_id, ray, hit.t);
        };
        let bound = shape.error_bound(hit.prim_id, &instance.localized(ray), hit.t);
        instance.error_bound(bound, hit.ng, ray, hit.t)
    }

    /// Where a secondary ray starts that leaves a hit's surface on the side of `normal`, one of its
    /// two unit normals there: off the surface by the hit's error, so that the ray does not meet the
    /// surface it leaves, and by no more, so that it meets whatever is near.
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn leaving_point(&self, hit: &Hit, ray: &Ray, normal: Vec3) -> Vec3 {
        ray.at(hit.t) + self.error_bound(hit, ray) * normal
    }
}

impl Shape {
    fn new(mesh: Arc<Mesh>, form: Form) -> Self {
        match form {
            Form::Flat => Self::Flat(mesh),
            Form::Curved(options) => Self::Curved(Arc::new(CurvedMesh::new(mesh, &options))),
        }
    }

    /// Its geometry and, behind it, that of the flat triangles that are apart.
    pub(super) fn geometries(&self, device: &Device) -> Result<Vec<Geometry>, embree::Error> {
        let geometries = match self {
            Self::Flat(mesh) => {
                let flat = Geometry::triangles(device, mesh.positions(), mesh.triangles())?;
                vec![flat]
            }
            Self::Curved(mesh) => mesh.geometries(device)?,
        };
        geometries
            .into_iter()
            .map(GeometryBuilder::commit)
            .collect()
    }

    fn into_mesh(self) -> Arc<Mesh> {
        match self {
            Self::Flat(mesh) => mesh,
            Self::Curved(mesh) => mesh.mesh().clone(),
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        match self {
            Self::Flat(mesh) => mesh,
            Self::Curved(mesh) => mesh.mesh(),
        }
    }

    /// Triangles by kind.
    pub fn kinds(&self) -> Kinds {
        match self {
            Self::Flat(mesh) => Kinds {
                flat_tolerance: mesh.triangles().len(),
                ..Kinds::default()
            },
            Self::Curved(mesh) => *mesh.kinds(),
        }
    }

    fn spheres(&self) -> Spheres {
        match self {
            Self::Flat(_) => Spheres::default(),
            Self::Curved(mesh) => *mesh.spheres(),
        }
    }

    /// Bytes kept beyond the mesh itself.
    fn memory(&self) -> usize {
        match self {
            Self::Flat(_) => 0,
            Self::Curved(mesh) => mesh.memory(),
        }
    }

    /// As [`Scene::error_bound`], in the mesh's space.
    fn error_bound(&self, triangle: u32, ray: &Ray, t: f32) -> f32 {
        match self {
            Self::Flat(mesh) => {
                let corners = mesh.triangle_positions(triangle as usize);
                let around = corners.map(|p| p.abs().max_element());
                rounding(around.into_iter().fold(reach(ray, t), f32::max))
            }
            Self::Curved(mesh) => mesh.error_bound(triangle, ray, t),
        }
    }
}

/// How far out the points are that a ray's hit was computed from.
pub(super) fn reach(ray: &Ray, t: f32) -> f32 {
    ray.origin.abs().max_element() + t * ray.direction.abs().max_element()
}

/// How far off a plane a computed point of it may be, by the magnitude of what it was computed from.
pub(super) fn rounding(magnitude: f32) -> f32 {
    8.0 * f32::EPSILON * magnitude
}

/// Which meshes are attached themselves: those that are used once, as they are.
fn in_place(parts: &Parts) -> Vec<bool> {
    let mut uses = vec![0_usize; parts.meshes.len()];
    for placement in &parts.placements {
        // Any transform makes an instance, as two uses do.
        uses[placement.part] += if placement.is_in_place() { 1 } else { 2 };
    }
    uses.into_iter().map(|uses| uses == 1).collect()
}

/// The origin of the meshes that are attached themselves where they have the same, so that not a bit
/// of them changes, and there is nothing else; otherwise one that suits the common bounds.
fn common_origin(parts: &Parts, in_place: &[bool], bounds: &Bounds) -> DVec3 {
    let first = parts.meshes[0].origin();
    let same = parts.meshes.iter().all(|mesh| mesh.origin() == first);
    if same && in_place.iter().all(|&in_place| in_place) {
        first
    } else {
        bounds.local_origin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curved::FlatTriangles;
    use crate::embree::{QueryOptions, RayPacket};
    use crate::mesh::Placement;
    use glam::DAffine3;

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
    fn flat_triangles_apart_are_told_as_those_of_their_placements() {
        let device = crate::linked::device().unwrap();
        let form = Form::Curved(CurvedOptions {
            flat: FlatTriangles::Apart,
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
        assert_eq!(scene.place_of(&hit(0.1, 0.1)), 0, "curved");
        for (place, x) in [(1, 9.0), (2, 20.0), (3, 30.0)] {
            for (prim_id, y) in [(0, 0.25), (1, 0.75)] {
                let hit = hit(x + 0.5, y);
                assert_eq!((scene.place_of(&hit), hit.prim_id), (place, prim_id));
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
