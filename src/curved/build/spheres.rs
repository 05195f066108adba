//! How many triangles have which sphere of greatest curvature.

use std::ops::Add;

use curvetri_method::{Scalar, Sphere};

/// Curved triangles by the sphere that bounds them; all zero unless
/// [`BoundsKind::Sphere`](crate::method::BoundsKind::Sphere) was requested. Triangles that stay flat
/// have none.
///
/// ```
/// use curvetri::curved::Spheres;
///
/// let spheres = Spheres { circumscribed: 7, enlarged: 2, limited: 1 };
/// assert_eq!(spheres.total(), 10);
/// assert_eq!(spheres.named()[1], ("enlarged", 2));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spheres {
    /// The paper's own: that on the triangle's circumscribed circle.
    pub circumscribed: usize,
    /// Larger, because the surface may leave the paper's.
    pub enlarged: usize,
    /// Smaller, because the triangle is so thin or obtuse that the paper's is many times its size.
    pub limited: usize,
}

impl Spheres {
    /// One triangle with this sphere. One that was limited and then enlarged counts as enlarged.
    pub(super) fn of<S: Scalar>(sphere: Option<&Sphere<S>>) -> Self {
        let mut spheres = Self::default();
        if let Some(sphere) = sphere {
            *if sphere.is_enlarged() {
                &mut spheres.enlarged
            } else if sphere.is_limited() {
                &mut spheres.limited
            } else {
                &mut spheres.circumscribed
            } = 1;
        }
        spheres
    }

    /// The counts with their names, in the order they are reported.
    pub fn named(&self) -> [(&'static str, usize); 3] {
        [
            ("circumscribed", self.circumscribed),
            ("enlarged", self.enlarged),
            ("limited", self.limited),
        ]
    }

    /// All triangles with a sphere.
    pub fn total(&self) -> usize {
        self.named().iter().map(|(_, count)| count).sum()
    }
}

impl Add for Spheres {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            circumscribed: self.circumscribed + other.circumscribed,
            enlarged: self.enlarged + other.enlarged,
            limited: self.limited + other.limited,
        }
    }
}
