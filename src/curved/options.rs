//! How a mesh is curved, and how rays are solved against it.

use curvetri_method::{BoundsKind, Solver, Surface};

/// How a mesh's triangles are curved and how rays are solved against them.
///
/// ```
/// use curvetri::curved::{CurvedOptions, FlatTriangles, Primitives};
/// use curvetri::method::Surface;
///
/// let options = CurvedOptions {
///     surface: Surface::Angular,
///     tolerance: 1e-4,
///     flat: FlatTriangles::Separate,
///     ..CurvedOptions::default()
/// };
/// assert_eq!(options.primitives, Primitives::Clusters);
/// assert_eq!(CurvedOptions::paper().surface, Surface::Angular);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvedOptions {
    /// The surface the triangles stand for.
    pub surface: Surface,
    /// How a ray's root on a patch is found.
    pub solver: Solver,
    /// What is one primitive to Embree.
    pub primitives: Primitives,
    /// What bounds a triangle's box and a ray's segment over it.
    pub bounds: BoundsKind,
    /// Triangles whose surface lies no further than this from their plane stay flat, with straight edges
    /// towards their neighbours. In the mesh's units; 0 for none but those whose surface lies in the plane
    /// to within rounding. Flat triangles are traced faster. Cuts in the shading show sooner than a
    /// height does: about a hundredth of a pixel goes unseen.
    pub tolerance: f32,
    /// Who traces the triangles that stay flat.
    pub flat: FlatTriangles,
    /// Every triangle as the paper has it, from its own vertices alone: also where its guide field
    /// folds over or bends too much for the method's guarantees, and with curved edges also at hard
    /// edges and towards flat triangles. For measuring the method itself: rays may slip through
    /// where it is used.
    pub unchecked: bool,
}

/// What Embree is given as one primitive. Hits name triangles either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Primitives {
    /// A triangle: the method's plain form.
    Triangles,
    /// A few neighbouring triangles, whose boxes are tested against a ray all at once: a smaller tree
    /// and fewer callbacks.
    #[default]
    Clusters,
}

/// Who traces the triangles that stay flat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlatTriangles {
    /// The curved mesh itself: it is one geometry of Embree's.
    #[default]
    Inline,
    /// Embree, as triangles of its own in a [second geometry](super::CurvedMesh::flat_geometry), where there
    /// are so many that it pays. These are the triangles whose surface is their plane or within the
    /// [tolerance](CurvedOptions::tolerance) of it.
    Separate,
}

impl CurvedOptions {
    /// The paper's own form of the method: the angular surface (19), boxes of the sphere of greatest
    /// curvature (3), rays between the three edge planes (5) and within that sphere, roots of (44) by
    /// the iterative algorithm (ITA) to `n = 24` binary digits, `n1 = 3` at a time (sections 4.3, 4.4
    /// and 4.8).
    ///
    /// What is ours in it: hard edges and the triangles that the method cannot take are treated as for
    /// all surfaces (the paper has neither), and so are the spheres that the surface would leave and
    /// those of needles: [`Spheres`](super::Spheres) counts them.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            surface: Surface::Angular,
            solver: Solver::ITA,
            bounds: BoundsKind::Sphere,
            primitives: Primitives::Triangles,
            tolerance: 0.0,
            flat: FlatTriangles::Inline,
            unchecked: false,
        }
    }
}
