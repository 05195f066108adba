//! A mesh in a scene: flat triangles of Embree's own, or curved patches.

use std::sync::Arc;

use super::rounding::{reach, rounding};
use crate::curved::{CurvedMesh, CurvedOptions, Kinds, Spheres};
use crate::embree::{self, Device, Geometry, GeometryBuilder, Ray};
use crate::mesh::Mesh;

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

impl Shape {
    pub(super) fn new(mesh: Arc<Mesh>, form: Form) -> Self {
        match form {
            Form::Flat => Self::Flat(mesh),
            Form::Curved(options) => Self::Curved(Arc::new(CurvedMesh::new(mesh, &options))),
        }
    }

    /// Its geometry and, behind it, that of the flat triangles that are separate.
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

    pub(super) fn into_mesh(self) -> Arc<Mesh> {
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

    pub(super) fn spheres(&self) -> Spheres {
        match self {
            Self::Flat(_) => Spheres::default(),
            Self::Curved(mesh) => *mesh.spheres(),
        }
    }

    /// Bytes of memory beyond the mesh itself.
    pub(super) fn memory(&self) -> usize {
        match self {
            Self::Flat(_) => 0,
            Self::Curved(mesh) => mesh.memory(),
        }
    }

    /// As [`Scene::error_bound`](super::Scene::error_bound), in the mesh's space.
    pub(super) fn error_bound(&self, triangle: u32, ray: &Ray, t: f32) -> f32 {
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
