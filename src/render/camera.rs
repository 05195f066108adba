//! The perspective camera.

use glam::{DVec3, Vec3};
use thiserror::Error;

use super::framing::Wedges;
use super::scene::{Body, Scene};
use crate::embree::Ray;

/// How much further away than necessary a framing camera stands, as a share of its distance.
const MARGIN: f64 = 0.05;

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
    /// A camera that looks at a scene from above, in front and a little to the right, as near as
    /// shows all of it in a picture of this width over height.
    ///
    /// Flat and curved scenes of the same meshes are framed the same.
    pub fn framing(scene: &Scene, up: UpAxis, fov_degrees: f64, aspect: f64) -> Self {
        let towards_eye = up.turn(DVec3::new(0.5, 0.42, 1.0)).normalize();
        let axes = Axes::new(-towards_eye, up.vector());
        let slope = (0.5 * fov_degrees).to_radians().tan();
        let centre = (scene.bounds().centre() - scene.origin()).as_vec3();
        let meshes = scene.bodies().iter().map(Body::mesh);
        let wedges = meshes
            .map(|mesh| Wedges::around(mesh, centre, &axes, [slope * aspect, slope]))
            .fold(Wedges::NONE, Wedges::union);
        let eye = wedges.eye(1.0 + MARGIN);
        // A single point, too, is looked at from somewhere.
        let middle = scene.bounds().centre();
        let least = (f64::from(f32::EPSILON) * middle.abs().max_element()).max(1e-30);
        let [x, y, z] = [eye[0], eye[1], eye[2].max(least)];
        let target = middle + x * axes.right + y * axes.up;
        Self {
            eye: target + z * towards_eye,
            target,
            up: up.vector(),
            fov_degrees,
        }
    }

    /// Prepares the camera for a picture's size, in the space relative to `origin`.
    ///
    /// # Errors
    /// If the camera sees nothing.
    pub(super) fn lens(
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
        let pixel = 2.0 * (0.5 * self.fov_degrees).to_radians().tan() / height as f64;
        let corner = forward - 0.5 * pixel * (width as f64 * right - height as f64 * up);
        Ok(Lens {
            eye: (self.eye - origin).as_vec3(),
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
    fn new(forward: DVec3, up: DVec3) -> Self {
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
pub(super) struct Lens {
    eye: Vec3,
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
}

#[cfg(test)]
mod tests {
    use super::super::scene::Form;
    use super::*;
    use crate::embree::Device;
    use crate::mesh::Mesh;

    fn scene(positions: Vec<DVec3>) -> Scene {
        let triangles = (2..positions.len() as u32).map(|i| [0, i - 1, i]).collect();
        let mesh = Mesh::new(positions, None, triangles).unwrap();
        Scene::new(&Device::new().unwrap(), vec![mesh], Form::Flat).unwrap()
    }

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
    fn framed_vertices_are_in_the_picture_and_nearly_fill_it() {
        let offset = DVec3::new(3e5, 1.0, 2.0);
        let corners = [
            DVec3::ZERO,
            DVec3::new(9.0, 0.0, 1.0),
            DVec3::new(8.0, 3.0, 0.0),
        ];
        let scene = scene(corners.map(|p| p + offset).to_vec());
        for up in [UpAxis::Y, UpAxis::Z] {
            for size in [[300_usize, 100], [100, 300]] {
                let aspect = size[0] as f64 / size[1] as f64;
                let camera = Camera::framing(&scene, up, 35.0, aspect);
                let lens = camera.lens(scene.origin(), size[0], size[1]).unwrap();
                let seen = scene.bodies()[0].mesh().positions().iter();
                let seen: Vec<_> = seen.map(|&p| seen_at(&lens, p)).collect();
                let shares = [0, 1].map(|axis| {
                    let of = |fold: fn(f32, f32) -> f32, start| {
                        seen.iter()
                            .map(|p| p[axis] / size[axis] as f32)
                            .fold(start, fold)
                    };
                    [of(f32::min, 1.0), of(f32::max, 0.0)]
                });
                assert!(
                    shares.iter().all(|[low, high]| *low > 0.0 && *high < 1.0),
                    "{shares:?}"
                );
                let fills = shares.iter().any(|[low, high]| high - low > 0.85);
                assert!(fills, "{shares:?}");
            }
        }
    }

    #[test]
    fn a_scene_of_one_point_is_looked_at_from_somewhere() {
        let camera = Camera::framing(&scene(vec![DVec3::ONE; 3]), UpAxis::Y, 35.0, 1.0);
        assert!(camera.lens(DVec3::ZERO, 9, 9).is_ok(), "{camera:?}");
    }

    /// Where a point is in the picture, in pixels.
    fn seen_at(lens: &Lens, point: Vec3) -> [f32; 2] {
        let matrix = glam::Mat3::from_cols(lens.across, lens.down, lens.corner);
        let p = matrix.inverse() * (point - lens.eye);
        assert!(p.z > 0.0, "behind the camera");
        [p.x / p.z, p.y / p.z]
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
