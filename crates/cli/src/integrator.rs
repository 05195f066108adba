//! The options that say how a picture's light is found, and what the meshes are made of.

use anyhow::Result;
use clap::{Args, ValueEnum};
use curvetri::render::{Integrator, Material};

use super::{usage, values};

/// Surfaces that light meets on its way if no option says otherwise: in and out of two bodies of
/// glass, and some more.
const DEFAULT_DEPTH: u32 = 8;
/// Of common glass.
const DEFAULT_INDEX: f32 = 1.5;

#[derive(Args)]
#[command(next_help_heading = "Integrator and material")]
pub struct IntegratorArgs {
    /// How light is found
    #[arg(long, value_enum, default_value_t = IntegratorChoice::Direct)]
    integrator: IntegratorChoice,

    /// With path: how many surfaces light may meet on its way [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    depth: Option<u32>,

    /// With ao: count only what is this close or closer, in the units of the meshes [default: any
    /// distance]
    #[arg(long, value_name = "DISTANCE", value_parser = values::length)]
    ao_distance: Option<f32>,

    /// With direct: let surfaces hide the sky from each other, which adds noise (with path they always
    /// do)
    #[arg(long)]
    sky_shadows: bool,

    /// What the meshes are made of; glass needs path
    #[arg(long, value_enum, default_value_t = MaterialChoice::Lambert)]
    material: MaterialChoice,

    /// The refractive index of the glass [default: 1.5]
    #[arg(long, value_name = "INDEX", value_parser = values::index)]
    ior: Option<f32>,

    /// Seed of the noise. The same seed gives the same picture on any number of threads
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum IntegratorChoice {
    /// Light straight from the sun, the area light, point lights and the sky
    Direct,
    /// Ambient occlusion: how open the surroundings are, without lights
    Ao,
    /// Path tracing: also light from other surfaces and through glass
    Path,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MaterialChoice {
    /// Diffuse
    Lambert,
    /// Clear glass
    Glass,
}

impl IntegratorArgs {
    /// How light is found.
    pub fn integrator(&self) -> Result<Integrator> {
        use IntegratorChoice::{Ao, Direct, Path};
        let only = [
            ("--depth", self.depth.is_some(), Path, "path"),
            ("--ao-distance", self.ao_distance.is_some(), Ao, "ao"),
            ("--sky-shadows", self.sky_shadows, Direct, "direct"),
        ];
        for (option, given, choice, name) in only {
            if given && self.integrator != choice {
                return usage(format!("{option} is for --integrator {name}"));
            }
        }
        Ok(match self.integrator {
            Direct => Integrator::Direct {
                sky_shadows: self.sky_shadows,
            },
            Ao => Integrator::AmbientOcclusion {
                distance: self.ao_distance.unwrap_or(f32::INFINITY),
            },
            Path => Integrator::Path {
                depth: self.depth.unwrap_or(DEFAULT_DEPTH),
            },
        })
    }

    /// What the meshes are made of.
    pub fn material(&self) -> Result<Material> {
        match self.material {
            MaterialChoice::Lambert if self.ior.is_some() => usage("--ior is for --material glass"),
            MaterialChoice::Lambert => Ok(Material::Lambert),
            MaterialChoice::Glass if self.integrator != IntegratorChoice::Path => {
                usage("--material glass needs --integrator path")
            }
            MaterialChoice::Glass => Ok(Material::Glass {
                index: self.ior.unwrap_or(DEFAULT_INDEX),
            }),
        }
    }
}
