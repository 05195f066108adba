//! Rays from far away, moved along themselves to near a scene before they are traced: single precision, in which
//! rays are traced, then keeps the scene's digits.

use glam::DVec3;

use crate::embree::Ray;
use crate::mesh::Bounds;

/// Rays are moved that begin more than so many radii from the middle of a vicinity.
const FAR: f64 = 16.0;

/// A ball around all that rays may meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vicinity {
    centre: DVec3,
    radius: f64,
}

/// A ray in single precision, which may have been moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NearRay {
    /// From t = 0 to infinity.
    pub ray: Ray,
    /// What to add to its parameters for those of the ray as it was.
    pub shift: f64,
}

impl Vicinity {
    /// Nothing is far from this.
    pub const EVERYWHERE: Self = Self {
        centre: DVec3::ZERO,
        radius: f64::INFINITY,
    };

    /// Around all that lies within bounds, with room for what bulges out of them.
    pub fn of(bounds: &Bounds) -> Self {
        Self {
            centre: bounds.centre(),
            radius: bounds.diagonal(),
        }
    }

    /// With another ball as well.
    pub fn including(self, centre: DVec3, radius: f64) -> Self {
        let radius = self.radius.max(self.centre.distance(centre) + radius);
        Self { radius, ..self }
    }

    /// A ray of this space in the space relative to `origin`. If it begins far away and leads this way, it begins
    /// anew before it enters the ball.
    pub fn localized(&self, from: DVec3, along: DVec3, origin: DVec3) -> NearRay {
        let shift = self.shift(from, along);
        let start = (from - origin) + shift * along;
        NearRay {
            ray: Ray::new(start.as_vec3(), along.as_vec3()),
            shift,
        }
    }

    /// By how much of its parameter a ray is moved.
    fn shift(&self, from: DVec3, along: DVec3) -> f64 {
        let way = self.centre - from;
        if way.length() <= FAR * self.radius {
            return 0.0;
        }
        let length = along.length();
        let nearest = way.dot(along / length);
        let shift = (nearest - self.radius) / length;
        // Not one for a ray that leads nowhere, or comes from no place.
        if shift > 0.0 && shift.is_finite() {
            shift
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A cube of side 2.
    fn cube() -> Bounds {
        Bounds {
            min: DVec3::new(9.0, -1.0, -1.0),
            max: DVec3::new(11.0, 1.0, 1.0),
        }
    }

    #[test]
    fn a_ray_from_far_away_begins_anew_in_front_of_what_is_there() {
        let vicinity = Vicinity::of(&cube());
        let (from, along) = (DVec3::new(10.25, 0.5, 1e9), DVec3::new(0.0, 0.0, -2.0));
        let near = vicinity.localized(from, along, DVec3::new(10.0, 0.0, 0.0));
        assert_eq!(near.ray.direction, along.as_vec3());
        assert_eq!([near.ray.origin.x, near.ray.origin.y], [0.25, 0.5]);
        assert!((1.0..4.0).contains(&near.ray.origin.z), "{near:?}");
        let moved = from + near.shift * along;
        assert!((moved.z - f64::from(near.ray.origin.z)).abs() < 1e-6);
    }

    #[test]
    fn other_rays_stay_as_they_are() {
        let vicinity = Vicinity::of(&cube());
        let far = DVec3::new(0.0, 0.0, 1e6);
        for (from, along) in [
            (DVec3::new(10.0, 0.0, 8.0), DVec3::NEG_Z), // near
            (far, DVec3::Z),                            // away from it
            (far, DVec3::NEG_X),                        // past it
            (far, DVec3::ZERO),
            (DVec3::splat(f64::INFINITY), DVec3::X),
            (DVec3::splat(f64::NAN), DVec3::X),
        ] {
            assert_eq!(vicinity.localized(from, along, DVec3::ZERO).shift, 0.0);
        }
        let near = Vicinity::EVERYWHERE.localized(far, DVec3::NEG_Z, DVec3::ZERO);
        assert_eq!(
            (near.shift, near.ray.origin),
            (0.0, Vec3::new(0.0, 0.0, 1e6))
        );
        let larger = vicinity.including(far, 10.0);
        assert_eq!(larger.localized(far, DVec3::NEG_Z, DVec3::ZERO).shift, 0.0);
    }
}
