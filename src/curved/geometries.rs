//! What Embree is given of a curved mesh: a user geometry and, beside it, triangles of Embree's own.

use std::iter;
use std::sync::Arc;

use super::build::may_be_separate;
use super::curved_mesh::CurvedMesh;
use crate::embree::{Device, Error, Geometry, GeometryBuilder};

/// Bytes of Embree's copy of a vertex, and of a triangle's indices.
const COPY_BYTES: usize = 12;
/// Bytes of Embree's tree for each triangle at most.
const TREE_BYTES: usize = 120;

impl CurvedMesh {
    /// All that a scene needs of the mesh: the user geometry of its curved triangles and, where there is one,
    /// the [flat geometry](Self::flat_geometry) beside it, in this order.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn geometries(self: &Arc<Self>, device: &Device) -> Result<Vec<GeometryBuilder>, Error> {
        let curved = Geometry::user(device, self.clone())?;
        Ok(iter::once(curved)
            .chain(self.flat_geometry(device)?)
            .collect())
    }

    /// The flat triangles as Embree's own, where they were requested to be
    /// [separate](super::FlatTriangles::Separate) and are a third of all or more. They are to be attached
    /// beside the curved mesh, to a scene that is [robust](crate::embree::SceneBuilder::robust), so that no
    /// ray slips between the two. Both number the triangles as the mesh does. The flat ones' normals are not
    /// unit. Embree copies all vertices and indices, some 18 bytes a triangle of the mesh.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn flat_geometry(&self, device: &Device) -> Result<Option<GeometryBuilder>, Error> {
        if !self.flat_separate {
            return Ok(None);
        }
        let keep = |n: usize| may_be_separate(&self.records[n]);
        let (positions, triangles) = (self.mesh.positions(), self.mesh.triangles());
        Geometry::some_triangles(device, positions, triangles, keep).map(Some)
    }
}

/// Bytes that Embree takes at most for the flat geometry of a mesh; 0 where there is none.
pub(super) fn flat_geometry_bytes(curved: &CurvedMesh) -> u64 {
    if !curved.flat_separate {
        return 0;
    }
    let (triangles, vertices) = (curved.records.len(), curved.mesh.positions().len());
    let flat = curved.kinds().near_plane();
    (COPY_BYTES * (triangles + vertices) + TREE_BYTES * flat) as u64
}
