//! The options for lights, ground and background.

use anyhow::Result;
use clap::{Args, ValueEnum};
use curvetri::render::{Background, Ground, Lighting, Scene, Shading, SphereLight, UpAxis};
use glam::DVec3;

use super::{usage, values};

#[derive(Args)]
#[command(next_help_heading = "Light and ground")]
pub struct LightArgs {
    /// The direction towards the sun [default: that of the files' first directional light, or to the
    /// upper left, in front]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    sun_direction: Option<DVec3>,

    /// Brightness of the sun, as a factor
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    sun: f32,

    /// Brightness of the sky, as a factor
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    sky: f32,

    /// Contrast of a checkerboard on the sky, 0 to 1; glass shows it, and --show-sky
    #[arg(long, value_name = "SHARE", default_value = "0", value_parser = values::share)]
    sky_checker: f32,

    /// Show the sky where nothing else is, instead of the background
    #[arg(long)]
    show_sky: bool,

    /// A shining ball: its centre and radius, in the meshes' space. Its shadows are soft; the camera
    /// does not see it, glass does
    #[arg(long, value_name = "X,Y,Z,RADIUS", value_parser = values::ball, allow_hyphen_values = true)]
    area_light: Option<(DVec3, f64)>,

    /// Brightness of the area light, as a factor: at 1 it lights the meshes' middle as the sun does
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    area_brightness: f32,

    /// Share of light that diffuse surfaces reflect
    #[arg(long, value_name = "SHARE", default_value = "0.7", value_parser = values::share)]
    pub albedo: f32,

    /// What flat triangles are lit by; curved ones have a normal of their own [default: geometric]
    #[arg(long, value_enum)]
    shading: Option<ShadingChoice>,

    /// Exposure in stops, over the default; for .png
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::stops,
        allow_hyphen_values = true)]
    pub exposure: f32,

    /// Put the meshes on a plane that takes their shadows
    #[arg(long)]
    ground: bool,

    /// Leave the background transparent (.exr always does)
    #[arg(long)]
    transparent: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShadingChoice {
    /// Their own normals
    Geometric,
    /// The vertices' normals between them: a smooth look, while shadows stay those of flat triangles
    Interpolated,
}

impl LightArgs {
    /// Refuses what has no effect on curved surfaces.
    pub fn check(&self, flat: bool) -> Result<()> {
        if self.shading.is_some() && !flat {
            return usage(
                "--shading is for --surface flat: a curved surface has normals of its own",
            );
        }
        Ok(())
    }

    /// The lights of a scene whose files have these suns.
    pub fn lighting(&self, up: UpAxis, scene: &Scene, suns: &[DVec3]) -> Lighting {
        let mut lighting = Lighting::daylight(up);
        if let Some(direction) = self.sun_direction.or(suns.first().copied()) {
            lighting.towards_sun = direction.as_vec3().normalize();
        }
        lighting.lamp = self.area_light.map(|(centre, radius)| {
            // A ball at a distance gives (radius / distance)^2 of its radiance.
            let distance = centre.distance(scene.bounds().centre()).max(radius);
            let gain = self.area_brightness * (distance / radius).powi(2) as f32;
            SphereLight {
                centre,
                radius,
                radiance: gain * lighting.sun,
            }
        });
        lighting.sun *= self.sun;
        lighting.sky.above *= self.sky;
        lighting.sky.below *= self.sky;
        lighting.sky.checker = self.sky_checker;
        lighting
    }

    /// The ground.
    pub fn ground(&self) -> Ground {
        if self.ground {
            Ground::Plane
        } else {
            Ground::None
        }
    }

    /// What flat triangles are lit by.
    pub fn shading(&self) -> Shading {
        match self.shading {
            None | Some(ShadingChoice::Geometric) => Shading::Geometric,
            Some(ShadingChoice::Interpolated) => Shading::Interpolated,
        }
    }

    /// Whether the sky is seen.
    pub fn show_sky(&self) -> bool {
        self.show_sky
    }

    /// What shows where nothing is.
    pub fn background(&self) -> Background {
        if self.transparent {
            Background::Transparent
        } else {
            Background::default()
        }
    }
}
