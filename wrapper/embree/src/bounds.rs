//! Axis-aligned boxes.

use glam::Vec3;

use super::sys::CurvetriBounds;

/// An axis-aligned box, in the space of whatever it bounds.
///
/// ```
/// use curvetri_embree::Bounds;
/// use glam::Vec3;
///
/// let points = [Vec3::new(1.0, 5.0, 2.0), Vec3::new(3.0, 4.0, 0.0)];
/// let bounds = points.into_iter().fold(Bounds::EMPTY, Bounds::including);
/// assert_eq!(bounds.lower, Vec3::new(1.0, 4.0, 0.0));
/// assert_eq!(bounds.upper, Vec3::new(3.0, 5.0, 2.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner of least coordinates.
    pub lower: Vec3,
    /// The corner of greatest coordinates.
    pub upper: Vec3,
}

impl Bounds {
    /// The box that holds nothing: the neutral element of [`union`](Self::union).
    pub const EMPTY: Self = Self {
        lower: Vec3::INFINITY,
        upper: Vec3::NEG_INFINITY,
    };

    /// Whether the box holds no point; also true where a coordinate is NaN.
    pub fn is_empty(&self) -> bool {
        !self.lower.cmple(self.upper).all()
    }

    /// The smallest box that holds both.
    pub fn union(self, other: Self) -> Self {
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
        }
    }

    /// The smallest box that holds this one and a point.
    pub fn including(self, point: Vec3) -> Self {
        Self {
            lower: self.lower.min(point),
            upper: self.upper.max(point),
        }
    }

    pub(super) fn to_embree(self) -> CurvetriBounds {
        let (lower, upper) = (self.lower, self.upper);
        CurvetriBounds {
            lower_x: lower.x,
            lower_y: lower.y,
            lower_z: lower.z,
            align0: 0.0,
            upper_x: upper.x,
            upper_y: upper.y,
            upper_z: upper.z,
            align1: 0.0,
        }
    }

    pub(super) fn from_embree(bounds: &CurvetriBounds) -> Self {
        Self {
            lower: Vec3::new(bounds.lower_x, bounds.lower_y, bounds.lower_z),
            upper: Vec3::new(bounds.upper_x, bounds.upper_y, bounds.upper_z),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_is_neutral_and_nan_is_empty() {
        let bounds = Bounds {
            lower: Vec3::NEG_ONE,
            upper: Vec3::ONE,
        };
        assert!(Bounds::EMPTY.is_empty());
        assert!(!bounds.is_empty());
        assert_eq!(bounds.union(Bounds::EMPTY), bounds);
        assert_eq!(
            Bounds::EMPTY.including(Vec3::X),
            Bounds {
                lower: Vec3::X,
                upper: Vec3::X
            }
        );
        assert!(
            Bounds {
                lower: Vec3::splat(f32::NAN),
                upper: Vec3::ONE
            }
            .is_empty()
        );
    }
}
