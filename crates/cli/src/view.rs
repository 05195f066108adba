//! The options for the camera.

use anyhow::Result;
use clap::Args;
use curvetri::mesh::FileCamera;
use curvetri::render::{Camera, Framing, Projection, Scene, UpAxis};
use glam::{DVec3, Vec3};

use super::values::UpChoice;
use super::{usage, values};

/// The angle that the picture's height covers where nothing says it, in degrees.
const DEFAULT_FOV: f64 = 35.0;

#[derive(Args)]
#[command(next_help_heading = "Camera")]
pub struct ViewArgs {
    /// Which axis of the meshes points up
    #[arg(long, value_enum, default_value_t = UpChoice::Y)]
    up_axis: UpChoice,

    /// A camera from the files, by its name or its number (the first is 0), or none [default: the
    /// first, unless --eye, --target or --up is given]
    #[arg(long, value_name = "NAME|N|none")]
    camera: Option<String>,

    /// Where the camera is [default: in front, above and a little to the right, and close enough to
    /// just see all meshes]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,

    /// The point in the middle of the picture [default: the middle of the bounds of the meshes]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    target: Option<DVec3>,

    /// The direction that points up in the picture [default: the up axis]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    up: Option<DVec3>,

    /// The angle that the height of the picture covers [default: that of the camera in the file,
    /// else 35]
    #[arg(long, value_name = "DEGREES", value_parser = values::fov)]
    fov: Option<f64>,

    /// An orthographic camera, with parallel rays: what is further away is as large. HEIGHT is what
    /// the height of the picture covers, in units of the meshes [default: all meshes; with an --eye
    /// or a camera of the file what --fov covers at the middle of the meshes]
    #[arg(long, value_name = "HEIGHT", num_args = 0..=1, require_equals = true,
        value_parser = values::film_height)]
    orthographic: Option<Option<f64>>,
}

impl ViewArgs {
    /// Refuses a camera that sees nothing.
    pub fn check(&self) -> Result<()> {
        if self.eye.is_some() && self.eye == self.target {
            return usage("the camera's --eye and --target are the same point");
        }
        Ok(())
    }

    /// Upwards in the meshes' space.
    pub fn up(&self) -> UpAxis {
        self.up_axis.axis()
    }

    /// The camera: as the options or the files have it, or else placed so that all of the scene is seen. With
    /// the direction to the sun in `shadows_of`, shadows on the ground are seen as well.
    pub fn camera(
        &self,
        scene: &Scene,
        cameras: &[FileCamera],
        aspect: f64,
        shadows_of: Option<Vec3>,
    ) -> Result<Camera> {
        let start = match self.file_camera(cameras)? {
            Some(camera) => from_file(camera),
            None => {
                let framing = Framing {
                    up: self.up(),
                    // From a place of its own an orthographic camera sees what a perspective one does there.
                    fov_degrees: (self.orthographic.is_none() || self.eye.is_some())
                        .then(|| self.fov.unwrap_or(DEFAULT_FOV)),
                    aspect,
                    shadows_of,
                };
                framing.camera(scene)
            }
        };
        let camera = self.changed(start);
        Ok(match self.orthographic {
            None => camera,
            Some(height) => {
                let height = height.unwrap_or_else(|| camera.height_at(scene.bounds().centre()));
                Camera {
                    projection: Projection::Orthographic { height },
                    ..camera
                }
            }
        })
    }

    /// The camera of the files that the options choose, or the first where they choose none.
    pub fn file_camera<'a>(&self, cameras: &'a [FileCamera]) -> Result<Option<&'a FileCamera>> {
        let Some(wanted) = &self.camera else {
            let placed = self.eye.is_some() || self.target.is_some() || self.up.is_some();
            return Ok(cameras.first().filter(|_| !placed));
        };
        if wanted == "none" {
            return Ok(None);
        }
        let by_name = cameras.iter().find(|camera| camera.name == *wanted);
        let by_number = || wanted.parse().ok().and_then(|n: usize| cameras.get(n));
        if let Some(camera) = by_name.or_else(by_number) {
            return Ok(Some(camera));
        }
        let names: Vec<String> = cameras.iter().map(|c| format!("{:?}", c.name)).collect();
        usage(match names.len() {
            0 => format!("there is no camera {wanted:?}: the files have none"),
            _ => format!(
                "there is no camera {wanted:?}; there are {}",
                names.join(", ")
            ),
        })
    }

    /// This camera with what the options change of it.
    fn changed(&self, start: Camera) -> Camera {
        let target = self.target.unwrap_or(start.target);
        Camera {
            // A target of its own moves the camera along.
            eye: self.eye.unwrap_or(start.eye + target - start.target),
            target,
            up: self.up.unwrap_or(start.up),
            projection: match (start.projection, self.fov) {
                (Projection::Perspective { .. }, Some(fov_degrees)) => {
                    Projection::Perspective { fov_degrees }
                }
                (projection, _) => projection,
            },
        }
    }
}

fn from_file(camera: &FileCamera) -> Camera {
    Camera {
        eye: camera.eye,
        target: camera.eye + camera.forward,
        up: camera.up,
        projection: Projection::Perspective {
            fov_degrees: camera.fov_degrees,
        },
    }
}
