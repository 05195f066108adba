//! The perspective camera.

use glam::{DVec3, Vec3};
use thiserror::Error;

use crate::embree::Ray;
use crate::mesh::Bounds;

/// Which axis points up in the meshes' space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// Most OBJ files.
    #[default]
    Y,
    /// CAD, terrain, Blender.
    Z,
}

impl UpAxis {
    /// The unit vector upwards.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }

    /// A direction given for y up, turned so that it means the same here.
    pub fn turn(self, direction: DVec3) -> DVec3 {
        match self {
            Self::Y => direction,
            Self::Z => DVec3::new(direction.x, -direction.z, direction.y),
        }
    }
}

/// A perspective camera in the user's space.
///
/// ```
/// use curvetri::render::{Camera, UpAxis};
/// use glam::DVec3;
///
/// let up = UpAxis::Z;
/// let camera = Camera {
///     eye: up.turn(DVec3::new(0.0, 1.0, 4.0)), // above and in front
///     target: DVec3::ZERO,
///     up: up.vector(),
///     fov_degrees: 35.0,
/// };
/// assert_eq!(camera.eye, DVec3::new(0.0, -4.0, 1.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is.
    pub eye: DVec3,
    /// The point in the middle of the picture.
    pub target: DVec3,
    /// Upwards in the picture, roughly; need not be unit nor perpendicular to the view. Along the
    /// view itself another direction takes its place.
    pub up: DVec3,
    /// The angle that the picture's height covers, in degrees, above 0 and below 180.
    pub fov_degrees: f64,
}

/// A camera that sees nothing.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CameraError {
    /// Eye and target are the same point.
    #[error("the camera's eye and target are the same point ({0})")]
    NoDirection(DVec3),
    /// A coordinate is infinite or NaN, or the up vector is zero.
    #[error("the camera's eye, target and up vector must be finite, and the up vector not zero")]
    NotFinite,
    /// The angle of view is not between 0 and 180 degrees.
    #[error("the angle of view must be above 0 and below 180 degrees, not {0}")]
    Fov(f64),
}

impl Camera {
    /// The least size of a pixel on what is within a box, in the space's units; 0 if the camera may be
    /// within. For a picture of so many pixels.
    pub fn least_pixel(&self, bounds: &Bounds, width: usize, height: usize) -> f64 {
        let distance = self.eye.distance(self.eye.clamp(bounds.min, bounds.max));
        let pixel = self.pixel(height);
        // A pixel grows with the way straight ahead, which is least in the picture's corners.
        let corner = 0.5 * pixel * (width as f64).hypot(height as f64);
        pixel * distance / corner.hypot(1.0)
    }

    /// The size of a pixel one unit straight ahead, of a picture with so many rows.
    fn pixel(&self, height: usize) -> f64 {
        2.0 * (0.5 * self.fov_degrees).to_radians().tan() / height as f64
    }

    /// Prepares the camera for a picture's size, in the space relative to `origin`.
    ///
    /// # Errors
    /// If the camera sees nothing.
    pub(crate) fn lens(
        &self,
        origin: DVec3,
        width: usize,
        height: usize,
    ) -> Result<Lens, CameraError> {
        let finite = self.eye.is_finite() && self.target.is_finite() && self.up.is_finite();
        if !finite || self.up == DVec3::ZERO {
            return Err(CameraError::NotFinite);
        }
        if !(self.fov_degrees > 0.0 && self.fov_degrees < 180.0) {
            return Err(CameraError::Fov(self.fov_degrees));
        }
        let forward = (self.target - self.eye)
            .try_normalize()
            .ok_or(CameraError::NoDirection(self.eye))?;
        let Axes { forward, right, up } = Axes::new(forward, self.up);
        let pixel = self.pixel(height);
        let corner = forward - 0.5 * pixel * (width as f64 * right - height as f64 * up);
        Ok(Lens {
            eye: (self.eye - origin).as_vec3(),
            forward: forward.as_vec3(),
            corner: corner.as_vec3(),
            across: (pixel * right).as_vec3(),
            down: (-pixel * up).as_vec3(),
        })
    }
}

/// The camera's own axes: unit, perpendicular to each other.
pub(super) struct Axes {
    pub forward: DVec3,
    pub right: DVec3,
    pub up: DVec3,
}

impl Axes {
    /// The axes of a camera that looks along `forward`, a unit vector, with `up` roughly upwards.
    pub fn new(forward: DVec3, up: DVec3) -> Self {
        let right = forward.cross(up.normalize());
        let right = if right.length() > 1e-6 {
            right.normalize()
        } else {
            forward.any_orthonormal_vector()
        };
        Self {
            forward,
            right,
            up: right.cross(forward),
        }
    }
}

/// A camera prepared for a picture's size, in the scene's local space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    eye: Vec3,
    /// Unit, straight ahead.
    forward: Vec3,
    /// Direction to the picture's upper left corner.
    corner: Vec3,
    /// From pixel to pixel to the right.
    across: Vec3,
    /// From pixel to pixel downwards.
    down: Vec3,
}

impl Lens {
    /// The ray through a point of the picture: in pixels from the upper left corner. Its direction
    /// is of unit length.
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        Ray::new(
            self.eye,
            (self.corner + x * self.across + y * self.down).normalize(),
        )
    }

    /// How far a vector leads straight ahead.
    pub fn ahead(&self, vector: Vec3) -> f32 {
        vector.dot(self.forward)
    }

    /// Where a point of the local space is in the picture, in pixels; `None` behind the camera.
    #[cfg(test)]
    pub fn seen_at(&self, point: Vec3) -> Option<[f32; 2]> {
        let matrix = glam::Mat3::from_cols(self.across, self.down, self.corner);
        let p = matrix.inverse() * (point - self.eye);
        (p.z > 0.0).then(|| [p.x / p.z, p.y / p.z])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_target_is_in_the_middle_and_right_is_right() {
        let camera = Camera {
            eye: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            fov_degrees: 90.0,
        };
        let lens = camera.lens(DVec3::new(0.0, 0.0, 1.0), 200, 100).unwrap();
        let middle = lens.ray(100.0, 50.0);
        assert_eq!(middle.origin, Vec3::new(0.0, 0.0, 9.0));
        assert!((middle.direction - Vec3::NEG_Z).length() < 1e-6);
        assert!(lens.ray(150.0, 50.0).direction.x > 0.4);
        let top = lens.ray(100.0, 0.0).direction;
        assert!(
            (top.y + top.z).abs() < 1e-6 && top.y > 0.0,
            "45 degrees up: {top}"
        );
    }

    #[test]
    fn looking_along_the_up_vector_still_gives_a_picture() {
        let camera = Camera {
            eye: DVec3::new(0.0, 5.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            fov_degrees: 40.0,
        };
        let lens = camera.lens(DVec3::ZERO, 10, 10).unwrap();
        assert!(lens.ray(0.0, 0.0).direction.is_finite());
        assert_ne!(lens.ray(0.0, 0.0).direction, lens.ray(10.0, 0.0).direction);
    }

    #[test]
    fn a_camera_that_sees_nothing_is_refused() {
        let camera = Camera {
            eye: DVec3::ONE,
            target: DVec3::ZERO,
            up: DVec3::Y,
            fov_degrees: 35.0,
        };
        let refused = |camera: Camera| camera.lens(DVec3::ZERO, 9, 9).unwrap_err();
        let same = Camera {
            target: camera.eye,
            ..camera
        };
        assert_eq!(refused(same), CameraError::NoDirection(camera.eye));
        assert_eq!(
            refused(Camera {
                up: DVec3::ZERO,
                ..camera
            }),
            CameraError::NotFinite
        );
        let nan = DVec3::new(f64::NAN, 0.0, 0.0);
        assert_eq!(
            refused(Camera { eye: nan, ..camera }),
            CameraError::NotFinite
        );
        assert_eq!(
            refused(Camera {
                fov_degrees: 180.0,
                ..camera
            }),
            CameraError::Fov(180.0)
        );
    }
}
