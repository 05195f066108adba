//! Axis-aligned boxes.

use glam::{BVec3, DVec3};

/// An axis-aligned box in the user's space.
///
/// ```
/// use curvetri_mesh::Bounds;
/// use glam::DVec3;
///
/// let bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(3.0, 4.0, 0.0) };
/// assert_eq!(bounds.centre(), DVec3::new(1.5, 2.0, 0.0));
/// assert_eq!(bounds.diagonal(), 5.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner with the least coordinates.
    pub min: DVec3,
    /// The corner with the greatest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The box's centre.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// The length of the box's diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// The box's corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|n| {
            let [x, y, z] = [1, 2, 4].map(|bit| n & bit != 0);
            DVec3::select(BVec3::new(x, y, z), self.max, self.min)
        })
    }

    /// The greatest distance along an axis of any of its points from this one.
    pub(crate) fn reach_from(&self, point: DVec3) -> f64 {
        let [min, max] = [self.min, self.max].map(|p| (p - point).abs());
        min.max(max).max_element()
    }

    /// The least box around points; of none one that [`union`](Self::union) ignores.
    pub(crate) fn around(points: impl IntoIterator<Item = DVec3>) -> Bounds {
        let none = Bounds {
            min: DVec3::INFINITY,
            max: DVec3::NEG_INFINITY,
        };
        let points = points.into_iter();
        points.fold(none, |around, p| around.union(Bounds { min: p, max: p }))
    }

    /// The least box around both.
    pub(crate) fn union(self, other: Bounds) -> Bounds {
        Bounds {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The local origin for meshes with these bounds, as [`Mesh`](crate::Mesh) describes it.
    #[must_use]
    pub fn local_origin(&self) -> DVec3 {
        let (centre, diagonal) = (self.centre(), self.diagonal());
        if centre.abs().max_element() <= 8.0 * diagonal {
            return DVec3::ZERO;
        }
        // A point has no size: then the origin is the point itself.
        if diagonal == 0.0 {
            return centre;
        }
        let grid = diagonal.log2().floor().exp2();
        (centre / grid).round() * grid
    }
}
