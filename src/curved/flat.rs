//! The triangles that stay flat: traced by the curved mesh itself, or by Embree beside it.

use std::iter;
use std::sync::Arc;

use super::prepare::PreparedMesh;
use super::{CurvedMesh, Kinds};
use crate::embree::{Bounds, Device, Error, Geometry, GeometryBuilder};
use crate::method::{FlatReason, PackedPatch, PatchKind};

/// Who traces the triangles that stay flat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlatTriangles {
    /// The curved mesh itself: it is one geometry of Embree's.
    #[default]
    Inline,
    /// Embree, as triangles of its own in a [second geometry](CurvedMesh::flat_geometry), those whose surface
    /// is their plane or within the [tolerance](super::CurvedOptions::tolerance) of it, where there are so
    /// many that it pays.
    Apart,
}

/// Of how many triangles one has to be flat for a second tree to pay, which every ray goes through as well.
/// Where one in two is, all kinds of rays gain, those from a camera threefold; where one in five is, those
/// and diffuse ones gain a tenth, but bounces lose more.
const LEAST_SHARE: usize = 3;

/// What Embree's copy of a vertex takes, and that of a triangle's indices.
const COPY_BYTES: usize = 12;
/// What a triangle takes of Embree's tree at most.
const TREE_BYTES: usize = 120;

impl FlatTriangles {
    /// Whether those of a mesh with these triangles are.
    pub(super) fn are_apart(self, kinds: &Kinds) -> bool {
        let flat = count(kinds);
        self == Self::Apart && flat > 0 && flat * LEAST_SHARE >= kinds.total()
    }
}

/// Whether a triangle is one that may be apart: not one that is flat because the method cannot take it. Its
/// neighbours are the wildest of patches, and on a side between them a ray may be found by neither where
/// the flat one ends sharp, as Embree's do.
fn may_be_apart(record: &PackedPatch) -> bool {
    matches!(
        record.kind(),
        PatchKind::Flat(FlatReason::Plane | FlatReason::Requested)
    )
}

/// How many of a mesh's triangles [may be apart](may_be_apart).
fn count(kinds: &Kinds) -> usize {
    kinds.flat_plane + kinds.flat_tolerance
}

impl PreparedMesh {
    /// Gives the triangles that are apart empty boxes, so that no ray is asked to be tested against them.
    pub(super) fn leave_out_flat(&mut self) {
        for (bounds, record) in self.bounds.iter_mut().zip(&self.records) {
            if may_be_apart(record) {
                *bounds = Bounds::EMPTY;
            }
        }
    }
}

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

    /// Whether a triangle is left to the flat geometry.
    pub(super) fn is_apart(&self, triangle: u32) -> bool {
        self.flat_apart && may_be_apart(&self.records[triangle as usize])
    }

    /// What Embree takes at most for those that are apart.
    pub(super) fn flat_bytes(&self) -> u64 {
        if !self.flat_apart {
            return 0;
        }
        let (triangles, vertices) = (self.records.len(), self.mesh.positions().len());
        let flat = count(&self.kinds);
        (COPY_BYTES * (triangles + vertices) + TREE_BYTES * flat) as u64
    }

    /// The triangles that are flat, as Embree's own, where they were asked to be [`FlatTriangles::Apart`]
    /// and are a third of all or more. They are to be attached beside the curved mesh, to a scene that is
    /// [robust](crate::embree::SceneBuilder::robust), so that no ray slips between the two. Both number the
    /// triangles as the mesh does; the flat ones' normals are not unit. Embree keeps copies of all vertices
    /// and indices, some 18 bytes a triangle of the mesh.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn flat_geometry(&self, device: &Device) -> Result<Option<GeometryBuilder>, Error> {
        if !self.flat_apart {
            return Ok(None);
        }
        let keep = |n: usize| may_be_apart(&self.records[n]);
        let (positions, triangles) = (self.mesh.positions(), self.mesh.triangles());
        Geometry::some_triangles(device, positions, triangles, keep).map(Some)
    }
}
