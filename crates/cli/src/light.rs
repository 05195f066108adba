//! The options for lights, ground and background.

use clap::{Args, ValueEnum};
use curvetri::mesh::{Bounds, FileCone, FileLamp, Scenery};
use curvetri::render::{
    Background, Cone, Ground, Lighting, PointLight, Scene, Shading, SphereLight, UpAxis,
};
use glam::DVec3;

use super::values;

#[derive(Args)]
#[command(next_help_heading = "Light and ground")]
pub struct LightArgs {
    /// The direction towards the sun [default: that of the first directional light in the files,
    /// else the upper left, in front]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    sun_direction: Option<DVec3>,

    /// Brightness of the sun, as a factor [default: 1; but 0 if the files have point or spot lights
    /// and no directional light, and no --sun-direction is given]
    #[arg(long, value_name = "FACTOR", value_parser = values::brightness)]
    sun: Option<f32>,

    /// Brightness of the point and spot lights in the files, as a factor. At 1 they light the middle
    /// of the meshes, all together, as the sun does. At 0 they are left out
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    file_lights: f32,

    /// Brightness of the sky, as a factor
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    sky: f32,

    /// Contrast of a checkerboard on the sky, 0 to 1. It is seen through glass and with --show-sky
    #[arg(long, value_name = "SHARE", default_value = "0", value_parser = values::share)]
    sky_checker: f32,

    /// Show the sky behind the meshes, instead of the background
    #[arg(long)]
    show_sky: bool,

    /// An area light: a shining ball with this centre and radius, in the space of the meshes. Its
    /// shadows are soft. It is seen through glass, but not by the camera itself
    #[arg(long, value_name = "X,Y,Z,RADIUS", value_parser = values::ball, allow_hyphen_values = true)]
    area_light: Option<(DVec3, f64)>,

    /// Brightness of the area light, as a factor. At 1 it lights the middle of the meshes as the sun
    /// does
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    area_brightness: f32,

    /// Share of light that diffuse surfaces reflect
    #[arg(long, value_name = "SHARE", default_value = "0.7", value_parser = values::share)]
    pub albedo: f32,

    /// Which normals surfaces are lit by, flat and curved
    #[arg(long, value_enum, default_value_t = ShadingChoice::Geometric)]
    shading: ShadingChoice,

    /// Exposure in stops, added to the default; for .png
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::stops,
        allow_hyphen_values = true)]
    pub exposure: f32,

    /// Put the meshes on a plane that shows their shadows
    #[arg(long)]
    ground: bool,

    /// Make the background transparent (in .exr it always is)
    #[arg(long)]
    transparent: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShadingChoice {
    /// The geometry's own: each flat triangle is a facet
    Geometric,
    /// The vertex normals, interpolated: outlines and shadows stay those of the geometry
    Interpolated,
}

impl LightArgs {
    /// The lights of a scene whose files have these.
    pub fn lighting(&self, up: UpAxis, scene: &Scene, scenery: &Scenery) -> Lighting {
        let mut lighting = Lighting::daylight(up);
        let towards_sun = self.sun_direction.or(scenery.suns.first().copied());
        if let Some(direction) = towards_sun {
            lighting.towards_sun = direction.as_vec3().normalize();
        }
        if self.file_lights > 0.0 {
            let brightness = self.file_lights * lighting.sun.element_sum() / 3.0;
            lighting.points = points(&scenery.lamps, scene.bounds(), brightness.into());
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
        let lit = !lighting.points.is_empty() && towards_sun.is_none();
        lighting.sun *= self.sun.unwrap_or(if lit { 0.0 } else { 1.0 });
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

    /// What surfaces are lit by.
    pub fn shading(&self) -> Shading {
        match self.shading {
            ShadingChoice::Geometric => Shading::Geometric,
            ShadingChoice::Interpolated => Shading::Interpolated,
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

/// Lights nearer to the meshes' middle than this share of their bounds' diagonal count as if they were
/// there: they are among the meshes, and none lies in their middle.
const NEAR: f64 = 0.25;

/// The lights of files. Their intensities keep their relation to each other; all together they light
/// the middle of the bounds, each as if it faced it and nothing was between, by `brightness`: a white
/// surface's radiance.
fn points(lamps: &[FileLamp], bounds: &Bounds, brightness: f64) -> Vec<PointLight> {
    let light = |lamp: &FileLamp| {
        let distance = lamp.position.distance(bounds.centre());
        let distance = distance.max(NEAR * bounds.diagonal());
        lamp.intensity.element_sum() / 3.0 / (distance * distance)
    };
    let gain = brightness / lamps.iter().map(light).sum::<f64>();
    let cone = |cone: FileCone| Cone {
        axis: cone.axis.as_vec3(),
        cosines: cone.angles.map(|angle| angle.cos() as f32),
    };
    let point = |lamp: &FileLamp| PointLight {
        position: lamp.position,
        intensity: (gain * lamp.intensity).as_vec3(),
        range: lamp.range.unwrap_or(f64::INFINITY),
        cone: lamp.cone.map(cone),
    };
    lamps.iter().map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_of_files_keep_their_relations_and_light_the_middle_together() {
        let lamp = |x: f64, candela: f64| FileLamp {
            position: DVec3::new(x, 0.0, 0.0),
            intensity: DVec3::splat(candela),
            range: None,
            cone: None,
        };
        let bounds = Bounds {
            min: DVec3::NEG_ONE,
            max: DVec3::ONE,
        };
        let at = |lights: &[PointLight], n: usize, distance: f32| {
            lights[n].intensity.x / (distance * distance)
        };
        let lights = points(&[lamp(10.0, 3e5), lamp(-5.0, 1e5)], &bounds, 0.9);
        assert!((lights[0].intensity.x / lights[1].intensity.x - 3.0).abs() < 1e-5);
        assert!((at(&lights, 0, 10.0) + at(&lights, 1, 5.0) - 0.9).abs() < 1e-5);
        // One in the middle itself does not blind.
        let lights = points(&[lamp(0.0, 7.0)], &bounds, 0.9);
        assert!((at(&lights, 0, 12_f32.sqrt() / 4.0) - 0.9).abs() < 1e-5);
    }
}
