//! What a triangle turned out to be, and by which rule it is curved.

use super::flags::Surface;

/// Why a triangle stays flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FlatReason {
    /// It was requested.
    Requested,
    /// Its surface lies in its plane anyway, to within rounding.
    Plane,
    /// So thin that its plane is uncertain.
    Sliver,
    /// A vertex normal points away from the plane's normal, or nearly so.
    BackNormal,
    /// The normals bend so much that a sphere of a vertex could be missed by the guide.
    Bend,
    /// The guide field would fold over near an edge.
    Fold,
}

/// What a triangle turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PatchKind {
    /// Curved, by the requested surface.
    Curved,
    /// Curved by the angular rule, because the curvature tensor is too wild here.
    Fallback,
    /// Flat, with straight edges.
    Flat(FlatReason),
    /// No area or not finite: there is no surface, and no ray hits it.
    Degenerate,
}

/// How the curvature at a point follows from the edges' curvatures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    Angular,
    Tensor,
    Flat,
}

impl Rule {
    pub fn of(surface: Surface) -> Self {
        match surface {
            Surface::Angular => Rule::Angular,
            Surface::Tensor | Surface::Smooth => Rule::Tensor,
        }
    }
}
