//! The camera, perspective or orthographic.

use glam::{DVec3, Vec3};
use thiserror::Error;

use super::vicinity::Vicinity;
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

/// A camera in the user's space.
///
/// ```
/// use curvetri::render::{Camera, Projection, UpAxis};
/// use glam::DVec3;
///
/// let up = UpAxis::Z;
/// let camera = Camera {
///     eye: up.turn(DVec3::new(0.0, 1.0, 4.0)), // above and in front
///     target: DVec3::ZERO,
///     up: up.vector(),
///     projection: Projection::Perspective { fov_degrees: 90.0 },
/// };
/// assert_eq!(camera.eye, DVec3::new(0.0, -4.0, 1.0));
///
/// // Of the same size at the target, and however far away.
/// let height = camera.height_at(camera.target);
/// let projection = Projection::Orthographic { height };
/// let parallel = Camera { projection, ..camera };
/// assert_eq!(parallel.height_at(DVec3::new(0.0, 100.0, 0.0)), height);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is. What is behind it is not seen; of an orthographic one, what is behind the plane through this
    /// point.
    pub eye: DVec3,
    /// The point in the middle of the picture.
    pub target: DVec3,
    /// Upwards in the picture, roughly; need not be unit nor perpendicular to the view. Along the
    /// view itself another direction takes its place.
    pub up: DVec3,
    /// How much it sees.
    pub projection: Projection,
}

/// How a camera's rays run, and how much its picture's height covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays through one point: what is further away is smaller.
    Perspective {
        /// The angle that the picture's height covers, in degrees, above 0 and below 180.
        fov_degrees: f64,
    },
    /// Parallel rays: what is further away is as large.
    Orthographic {
        /// What the picture's height covers, in the space's units, above 0.
        height: f64,
    },
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
    /// The height that an orthographic picture covers is no number above 0.
    #[error("the height that an orthographic picture covers must be a number above 0, not {0}")]
    Height(f64),
}

impl Camera {
    /// The least size of a pixel on what is within a box, in the space's units; 0 if a perspective camera may be
    /// within. For a picture of so many pixels.
    pub fn least_pixel(&self, bounds: &Bounds, width: usize, height: usize) -> f64 {
        let pixel = self.projection.pixel(height);
        if let Projection::Orthographic { .. } = self.projection {
            return pixel;
        }
        let distance = self.eye.distance(self.eye.clamp(bounds.min, bounds.max));
        // A pixel grows with the way straight ahead, which is least in the picture's corners.
        let corner = 0.5 * pixel * (width as f64).hypot(height as f64);
        pixel * distance / corner.hypot(1.0)
    }

    /// What the picture's height covers as far ahead as a point is, in the space's units.
    pub fn height_at(&self, point: DVec3) -> f64 {
        let ahead = (self.target - self.eye).normalize_or_zero();
        match self.projection {
            Projection::Perspective { .. } => {
                self.projection.pixel(1) * (point - self.eye).dot(ahead).abs()
            }
            Projection::Orthographic { height } => height,
        }
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
        self.projection.check()?;
        let forward = (self.target - self.eye)
            .try_normalize()
            .ok_or(CameraError::NoDirection(self.eye))?;
        let Axes { forward, right, up } = Axes::new(forward, self.up);
        let pixel = self.projection.pixel(height);
        Ok(Lens {
            origin,
            eye: self.eye,
            forward,
            corner: -0.5 * pixel * (width as f64 * right - height as f64 * up),
            across: pixel * right,
            down: -pixel * up,
            parallel: matches!(self.projection, Projection::Orthographic { .. }),
            vicinity: Vicinity::EVERYWHERE,
        })
    }
}

impl Projection {
    /// The size of a pixel of a picture with so many rows: one unit straight ahead, or anywhere.
    fn pixel(&self, height: usize) -> f64 {
        let whole = match *self {
            Self::Perspective { fov_degrees } => 2.0 * (0.5 * fov_degrees).to_radians().tan(),
            Self::Orthographic { height } => height,
        };
        whole / height as f64
    }

    fn check(&self) -> Result<(), CameraError> {
        match *self {
            Self::Perspective { fov_degrees } if !(fov_degrees > 0.0 && fov_degrees < 180.0) => {
                Err(CameraError::Fov(fov_degrees))
            }
            Self::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                Err(CameraError::Height(height))
            }
            _ => Ok(()),
        }
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

/// A camera prepared for a picture's size. Its rays are in a scene's local space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    /// That space's origin; the rest is in the user's space.
    origin: DVec3,
    eye: DVec3,
    /// Unit, straight ahead.
    forward: DVec3,
    /// From the picture's middle to its upper left corner: one unit straight ahead, or anywhere.
    corner: DVec3,
    /// From pixel to pixel to the right.
    across: DVec3,
    /// From pixel to pixel downwards.
    down: DVec3,
    /// Whether all rays lead straight ahead.
    parallel: bool,
    /// What rays from far away are moved to.
    vicinity: Vicinity,
}

impl Lens {
    /// The same camera, for what is in this vicinity: its rays begin near it.
    pub fn near(self, vicinity: Vicinity) -> Self {
        Self { vicinity, ..self }
    }

    /// The ray through a point of the picture: in pixels from the upper left corner. Its direction
    /// is of unit length. It may begin in front of the camera.
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        let aside = self.corner + f64::from(x) * self.across + f64::from(y) * self.down;
        let (from, along) = if self.parallel {
            (self.eye + aside, self.forward)
        } else {
            (self.eye, (self.forward + aside).normalize())
        };
        self.vicinity.localized(from, along, self.origin).ray
    }

    /// How far straight ahead a point of the local space is.
    pub fn depth(&self, point: Vec3) -> f32 {
        (point.as_dvec3() - (self.eye - self.origin)).dot(self.forward) as f32
    }

    /// Where a point of the local space is in the picture, in pixels; `None` behind the camera.
    #[cfg(test)]
    pub fn seen_at(&self, point: Vec3) -> Option<[f32; 2]> {
        let way = point.as_dvec3() - (self.eye - self.origin);
        let depth = way.dot(self.forward);
        let way = if self.parallel { way } else { way / depth };
        let place = |axis: DVec3| ((way - self.corner).dot(axis) / axis.dot(axis)) as f32;
        (depth > 0.0).then(|| [place(self.across), place(self.down)])
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
            projection: Projection::Perspective { fov_degrees: 90.0 },
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
            projection: Projection::Perspective { fov_degrees: 40.0 },
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
            projection: Projection::Perspective { fov_degrees: 35.0 },
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
                projection: Projection::Perspective { fov_degrees: 180.0 },
                ..camera
            }),
            CameraError::Fov(180.0)
        );
        for height in [0.0, -1.0, f64::INFINITY] {
            let projection = Projection::Orthographic { height };
            assert_eq!(
                refused(Camera {
                    projection,
                    ..camera
                }),
                CameraError::Height(height)
            );
        }
    }

    #[test]
    fn an_orthographic_camera_s_rays_are_parallel_and_a_pixel_apart() {
        let camera = Camera {
            eye: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 5.0 },
        };
        let lens = camera.lens(DVec3::new(0.0, 0.0, 1.0), 200, 100).unwrap();
        for (x, y, origin) in [
            (100.0, 50.0, Vec3::new(0.0, 0.0, 9.0)),
            (101.0, 50.0, Vec3::new(0.05, 0.0, 9.0)),
            (100.0, 51.0, Vec3::new(0.0, -0.05, 9.0)),
            (0.0, 0.0, Vec3::new(-5.0, 2.5, 9.0)),
            (200.0, 100.0, Vec3::new(5.0, -2.5, 9.0)),
        ] {
            let ray = lens.ray(x, y);
            assert_eq!(ray.direction, Vec3::NEG_Z);
            assert!((ray.origin - origin).length() < 1e-6, "{ray:?}");
            let [u, v] = lens.seen_at(ray.at(3.0)).unwrap();
            assert!((u - x).abs() < 1e-4 && (v - y).abs() < 1e-4, "{u} {v}");
            assert!((lens.depth(ray.at(3.0)) - 3.0).abs() < 1e-6);
        }
        let bounds = Bounds {
            min: DVec3::splat(-1.0),
            max: DVec3::ONE,
        };
        assert_eq!(camera.least_pixel(&bounds, 200, 100), 0.05);
    }

    #[test]
    fn from_far_away_the_rays_of_both_projections_are_the_same() {
        let bounds = Bounds {
            min: DVec3::splat(-1.0),
            max: DVec3::ONE,
        };
        let far = 1e7_f64;
        let fov_degrees = 2.0 * (1.5 / far).atan().to_degrees();
        let rays = [
            Projection::Perspective { fov_degrees },
            Projection::Orthographic { height: 3.0 },
        ]
        .map(|projection| {
            let camera = Camera {
                eye: far * DVec3::new(0.6, 0.0, 0.8),
                target: DVec3::ZERO,
                up: DVec3::Y,
                projection,
            };
            let lens = camera.lens(DVec3::ZERO, 100, 100).unwrap();
            lens.near(Vicinity::of(&bounds)).ray(10.25, 70.5)
        });
        let [a, b] = rays;
        assert!((a.direction - b.direction).length() < 1e-6);
        // Both begin near the bounds, and pass the middle in the same place.
        assert!(a.origin.length() < 5.0 && b.origin.length() < 5.0);
        let passes = |ray: Ray| ray.at(-ray.origin.dot(ray.direction));
        assert!((passes(a) - passes(b)).length() < 2e-6, "{rays:?}");
    }
}
