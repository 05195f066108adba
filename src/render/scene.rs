//! Meshes under one Embree tree.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use thiserror::Error;

use super::stats::{MemoryParts, Times};
use crate::curved::{CurvedMesh, CurvedOptions, Kinds, Spheres};
use crate::embree::{self, Device, Geometry, Hit, Ray, SceneBuilder};
use crate::mesh::{Bounds, Mesh};
use crate::surface::PatchKind;

/// What a mesh's triangles stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Themselves: Embree's own triangles.
    Flat,
    /// Curved patches.
    Curved(CurvedOptions),
}

/// A mesh in a scene. Its number there is the hits' `geom_id`.
pub enum Shape {
    /// Embree's own triangles.
    Flat(Arc<Mesh>),
    /// Curved patches.
    Curved(Arc<CurvedMesh>),
}

/// Meshes under one Embree tree, in a local space: rays and hits are relative to
/// [`Scene::origin`]. Primitive `i` of geometry `g` is triangle `i` of mesh `g`.
pub struct Scene {
    origin: DVec3,
    bounds: Bounds,
    shapes: Vec<Shape>,
    tree: embree::Scene,
    times: Times,
}

/// Why no scene could be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// There is no mesh.
    #[error("a scene needs at least one mesh")]
    Empty,
    /// Embree's own reason.
    #[error(transparent)]
    Embree(#[from] embree::Error),
}

impl Scene {
    /// Curves the meshes, if asked for, and builds the tree.
    ///
    /// # Errors
    /// If there is no mesh, or not enough memory.
    pub fn new(device: &Device, meshes: Vec<Mesh>, form: Form) -> Result<Self, SceneError> {
        Self::build(device, meshes, form, false)
    }

    /// The same for queries that bring a [filter](embree::QueryOptions::filter), as
    /// [`all_hits`](Self::all_hits) does; flat triangles are a little slower to trace then.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_filters(
        device: &Device,
        meshes: Vec<Mesh>,
        form: Form,
    ) -> Result<Self, SceneError> {
        Self::build(device, meshes, form, true)
    }

    fn build(
        device: &Device,
        meshes: Vec<Mesh>,
        form: Form,
        filters: bool,
    ) -> Result<Self, SceneError> {
        let start = Instant::now();
        let bounds = meshes.iter().map(Mesh::bounds).reduce(Bounds::union);
        let bounds = bounds.ok_or(SceneError::Empty)?;
        let origin = common_origin(&meshes, &bounds);
        let shapes: Vec<Shape> = meshes
            .into_iter()
            .map(|mesh| Shape::new(Arc::new(mesh.rebased(origin)), form))
            .collect();
        let curved = Instant::now();
        // Flat triangles get the same promise as curved ones: no ray slips between them.
        let mut builder = SceneBuilder::new(device)?
            .robust(true)
            .query_filters(filters);
        for shape in &shapes {
            builder.attach(&shape.geometry(device)?);
        }
        let tree = builder.commit()?;
        let times = Times {
            curve: curved - start,
            build: curved.elapsed(),
            ..Times::default()
        };
        Ok(Self {
            origin,
            bounds,
            shapes,
            tree,
            times,
        })
    }

    /// What rays and hits are relative to, in the user's space.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The bounds of all vertices, in the user's space; curved surfaces may bulge out of it.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The meshes, by `geom_id`.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The tree.
    pub fn tree(&self) -> &embree::Scene {
        &self.tree
    }

    /// Triangles by kind, of all meshes.
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
            records: sum(Shape::memory),
            embree: self.tree.device().memory().current,
        }
    }

    /// Time to curve and to build; the other times are zero.
    pub fn times(&self) -> Times {
        self.times
    }

    /// How far the surface may be from the point of a hit along its normal: see
    /// [`CurvedMesh::error_bound`].
    ///
    /// # Panics
    /// If the hit is not one of this scene's.
    pub fn error_bound(&self, hit: &Hit, ray: &Ray) -> f32 {
        match &self.shapes[hit.geom_id as usize] {
            Shape::Flat(mesh) => {
                let corners = mesh.triangle_positions(hit.prim_id as usize);
                let around = corners.map(|p| p.abs().max_element());
                rounding(around.into_iter().fold(reach(ray, hit.t), f32::max))
            }
            Shape::Curved(mesh) => mesh.error_bound(hit.prim_id, ray, hit.t),
        }
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

    /// The height of the lowest point of the surface along `up` (a unit vector), in the local space.
    ///
    /// Of a curved triangle only the vertices and a grid of points are looked at.
    pub fn lowest(&self, up: Vec3) -> f32 {
        let lowest = self.shapes.iter().map(|shape| shape.lowest(up));
        lowest.fold(f32::INFINITY, f32::min)
    }
}

impl Shape {
    fn new(mesh: Arc<Mesh>, form: Form) -> Self {
        match form {
            Form::Flat => Self::Flat(mesh),
            Form::Curved(options) => Self::Curved(Arc::new(CurvedMesh::new(mesh, &options))),
        }
    }

    fn geometry(&self, device: &Device) -> Result<Geometry, embree::Error> {
        match self {
            Self::Flat(mesh) => Geometry::triangles(device, mesh.positions(), mesh.triangles()),
            Self::Curved(mesh) => Geometry::user(device, mesh.clone()),
        }?
        .commit()
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
                flat_asked: mesh.triangles().len(),
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

    fn lowest(&self, up: Vec3) -> f32 {
        let height = |p: &Vec3| p.dot(up);
        let vertices = self.mesh().positions().iter().map(height);
        let lowest = vertices.fold(f32::INFINITY, f32::min);
        match self {
            Self::Flat(_) => lowest,
            Self::Curved(mesh) => (0..mesh.mesh().triangles().len() as u32)
                .into_par_iter()
                .map(|triangle| lowest_of_patch(mesh, triangle, up, lowest))
                .reduce(|| lowest, f32::min),
        }
    }
}

/// Points a side of the grid that [`Scene::lowest`] looks at.
const GRID: u32 = 12;

/// The least height on a patch where it is below `least` at all.
fn lowest_of_patch(mesh: &CurvedMesh, triangle: u32, up: Vec3, least: f32) -> f32 {
    let patch = mesh.patch(triangle);
    let [lower, upper] = patch.bounds().map(Vec3::from);
    let bottom = Vec3::select(up.cmpgt(Vec3::ZERO), lower, upper).dot(up);
    if patch.kind() == PatchKind::Degenerate || bottom >= least {
        return least;
    }
    let share = |n: u32| n as f32 / GRID as f32;
    (0..=GRID)
        .flat_map(|i| (0..=GRID - i).map(move |j| (share(i), share(j))))
        .map(|(u, v)| Vec3::from(patch.point(u, v).position).dot(up))
        .fold(least, f32::min)
}

/// How far out the points are that a ray's hit was computed from.
pub(super) fn reach(ray: &Ray, t: f32) -> f32 {
    ray.origin.abs().max_element() + t * ray.direction.abs().max_element()
}

/// How far off a plane a computed point of it may be, by the magnitude of what it was computed from.
pub(super) fn rounding(magnitude: f32) -> f32 {
    8.0 * f32::EPSILON * magnitude
}

/// The meshes' own origin where they have the same, so that not a bit of them changes; otherwise one
/// that suits their common bounds.
fn common_origin(meshes: &[Mesh], bounds: &Bounds) -> DVec3 {
    let first = meshes[0].origin();
    if meshes.iter().all(|mesh| mesh.origin() == first) {
        first
    } else {
        bounds.local_origin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embree::{QueryOptions, RayPacket};

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
        let device = Device::new().unwrap();
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
    fn a_single_mesh_is_not_moved() {
        let device = Device::new().unwrap();
        let mesh = square(DVec3::new(1e6, 0.3, 0.1));
        let scene = Scene::new(&device, vec![mesh.clone()], Form::Flat).unwrap();
        assert_eq!(scene.origin(), mesh.origin());
        assert_eq!(scene.shapes()[0].mesh(), &mesh);
    }

    #[test]
    fn no_mesh_is_an_error() {
        let device = Device::new().unwrap();
        let error = Scene::new(&device, vec![], Form::Flat).err().unwrap();
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
        let device = Device::new().unwrap();
        let scene = Scene::new(&device, vec![mesh], curved()).unwrap();
        assert!(
            (scene.lowest(Vec3::Y) + 1.0).abs() < 0.02,
            "{}",
            scene.lowest(Vec3::Y)
        );
        assert!((scene.lowest(Vec3::NEG_Z) + 1.0).abs() < 0.02);
    }
}
