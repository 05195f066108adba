//! What a patch is made from beside its three vertices: one word.

/// Which smooth surface a curved triangle stands for.
///
/// ```
/// use curvetri_method::Surface;
///
/// assert_eq!(Surface::default().name(), "smooth");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Surface {
    /// The paper's curvature rule, equation (19): by the angle at the vertex. Continuous, but its
    /// normals jump across edges.
    Angular,
    /// Curvature as a quadratic form in the direction (Euler's formula), fixed by the three edges'
    /// curvatures. Normals across edges agree for practical purposes on fine meshes.
    Tensor,
    /// `Tensor`, damped where an edge's two ends say different curvatures, and corrected so that
    /// the tangent planes of neighbours agree along their edge (C1).
    #[default]
    Smooth,
}

impl Surface {
    /// Every surface, roughest first.
    pub const ALL: [Surface; 3] = [Surface::Angular, Surface::Tensor, Surface::Smooth];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Surface::Angular => "angular",
            Surface::Tensor => "tensor",
            Surface::Smooth => "smooth",
        }
    }
}

/// What bounds a patch: its box for Embree, and what its rays are clipped to beside the edge planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BoundsKind {
    /// What is known of the surface's heights: a box hardly larger than it must be, and a slab
    /// between the least and the greatest height.
    #[default]
    Tight,
    /// The paper's: the sphere of greatest curvature (3), that on the triangle's circumscribed circle,
    /// and its box (sections 4.4 and 4.8). It is larger where the surface may leave it, and smaller on
    /// needles; see [`Sphere::is_enlarged`](super::Sphere::is_enlarged) and
    /// [`Sphere::is_limited`](super::Sphere::is_limited). Flat triangles have their tight boxes.
    Sphere,
}

impl BoundsKind {
    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            BoundsKind::Tight => "tight",
            BoundsKind::Sphere => "sphere",
        }
    }
}

/// The surface, the edges that must stay straight, and whether the triangle is to stay flat.
///
/// Edge `k` runs from vertex `k` to vertex `k + 1` (cyclically, from 0).
///
/// ```
/// use curvetri_method::{BoundsKind, PatchFlags, Surface};
///
/// let flags = PatchFlags::new(Surface::Tensor)
///     .with_straight(2)
///     .with_bounds(BoundsKind::Sphere);
/// assert!(flags.is_straight(2) && !flags.is_straight(0));
/// assert_eq!(flags.surface(), Surface::Tensor);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct PatchFlags(u16);

impl Default for PatchFlags {
    fn default() -> Self {
        Self::new(Surface::default())
    }
}

impl PatchFlags {
    const FLAT: u16 = 1 << 3;
    const SURFACE_SHIFT: u16 = 4;
    const UNCHECKED: u16 = 1 << 6;
    const SPHERE: u16 = 1 << 7;
    const PLANE: u16 = 1 << 8;

    /// All edges curved.
    pub const fn new(surface: Surface) -> Self {
        Self((surface as u16) << Self::SURFACE_SHIFT)
    }
    /// With edge `edge` (0, 1 or 2) straight, as it has to be where the neighbour across it does
    /// not share the two vertices' normals.
    ///
    /// # Panics
    /// If `edge` is above 2.
    #[must_use]
    pub const fn with_straight(self, edge: usize) -> Self {
        assert!(edge < 3, "a triangle has the edges 0, 1 and 2");
        Self(self.0 | 1 << edge)
    }
    /// The whole triangle stays in its plane.
    #[must_use]
    pub const fn with_flat(self) -> Self {
        Self(self.0 | Self::FLAT)
    }
    /// The whole triangle stays in its plane, where its surface lies anyway.
    #[must_use]
    pub const fn with_plane(self) -> Self {
        Self(self.0 | Self::FLAT | Self::PLANE)
    }
    /// Curved even where the guide field folds over or guides may miss the spheres, as the paper
    /// has it: for measuring the method's own error on cuts too coarse for it. A folded patch has
    /// holes for rays, and its bounds are no longer proven.
    #[must_use]
    pub const fn with_unchecked(self) -> Self {
        Self(self.0 | Self::UNCHECKED)
    }
    /// Bounded in this way.
    #[must_use]
    pub const fn with_bounds(self, bounds: BoundsKind) -> Self {
        match bounds {
            BoundsKind::Tight => Self(self.0 & !Self::SPHERE),
            BoundsKind::Sphere => Self(self.0 | Self::SPHERE),
        }
    }
    /// Whether edge `edge` is straight.
    pub const fn is_straight(self, edge: usize) -> bool {
        self.0 & (1 << edge) != 0
    }
    /// Whether the triangle was requested to stay flat.
    pub const fn is_flat(self) -> bool {
        self.0 & Self::FLAT != 0
    }
    /// Whether that is because its surface lies in its plane anyway.
    pub const fn is_plane(self) -> bool {
        self.0 & Self::PLANE != 0
    }
    /// Whether the checks for folds and bends are left out.
    pub const fn is_unchecked(self) -> bool {
        self.0 & Self::UNCHECKED != 0
    }
    /// What bounds the patch.
    pub const fn bounds(self) -> BoundsKind {
        if self.0 & Self::SPHERE != 0 {
            BoundsKind::Sphere
        } else {
            BoundsKind::Tight
        }
    }
    /// The surface.
    pub const fn surface(self) -> Surface {
        match (self.0 >> Self::SURFACE_SHIFT) & 3 {
            0 => Surface::Angular,
            1 => Surface::Tensor,
            _ => Surface::Smooth,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_is_kept_apart() {
        for surface in Surface::ALL {
            let flags = PatchFlags::new(surface).with_straight(1);
            assert_eq!(flags.surface(), surface);
            assert_eq!(
                [0, 1, 2].map(|k| flags.is_straight(k)),
                [false, true, false]
            );
            assert!(!flags.is_flat() && flags.with_flat().is_flat());
            assert_eq!(flags.with_flat().surface(), surface);
            let plane = flags.with_plane();
            assert!(plane.is_flat() && plane.is_plane() && !flags.with_flat().is_plane());
            let round = flags.with_bounds(BoundsKind::Sphere);
            assert_eq!((round.surface(), round.is_flat()), (surface, false));
            assert_eq!(round.bounds(), BoundsKind::Sphere);
            assert_eq!(round.with_bounds(BoundsKind::Tight), flags);
            assert_eq!(flags.bounds(), BoundsKind::Tight);
        }
    }
}
