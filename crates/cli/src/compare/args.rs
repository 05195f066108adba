//! The options of `curvetri compare`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{Args, ValueEnum};
use curvetri::curved::CurvedOptions;
use curvetri::method::Surface;
use curvetri::render::{Background, Form, Shading};

use super::super::integrator::IntegratorArgs;
use super::super::light::LightArgs;
use super::super::surface::{SurfaceArgs, plain};
use super::super::view::ViewArgs;
use super::super::{usage, values};
use super::measure::{Contestant, INTERPOLATED};

/// Compare flat triangles with the curved surface: pictures, errors, time and memory
#[derive(Args)]
pub struct CompareArgs {
    /// Mesh files (OBJ, PLY, STL, OFF, glTF, GLB, also as .gz), or - for standard input
    #[arg(required = true, value_name = "MESH")]
    pub meshes: Vec<PathBuf>,

    /// The picture to write, a PNG file: flat, curved, their difference and the reference, side by side
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,

    /// A finer mesh of the same body, which stands for the truth. It is shown as flat triangles with
    /// interpolated normals. May be given several times
    #[arg(long, value_name = "FINE")]
    pub reference: Vec<PathBuf>,

    /// Further forms to compare, separated by commas
    #[arg(
        long,
        value_name = "FORM,...",
        value_enum,
        value_delimiter = ',',
        default_values = ["paper", "interpolated"]
    )]
    pub also: Vec<AlsoChoice>,

    /// Write a report in one file: all figures, and pictures with a slider between any two
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,

    /// Print the figures as JSON
    #[arg(long)]
    pub json: bool,

    /// Build and render this many times, and give medians and spreads of the times
    #[arg(long, value_name = "N", default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeat: u32,

    /// Width and height of each picture in pixels
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = values::size)]
    pub size: [usize; 2],

    /// Rays for each pixel
    #[arg(long, visible_alias = "spp", value_name = "N", default_value_t = 16,
        value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub samples: u32,

    /// Threads to use [default: all]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    pub threads: Option<usize>,

    #[command(flatten)]
    pub view: ViewArgs,

    #[command(flatten)]
    pub integrator: IntegratorArgs,

    #[command(flatten)]
    pub light: LightArgs,

    #[command(flatten)]
    pub surface: SurfaceArgs,
}

/// Further forms to compare. Those that name a surface have it without any other options.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AlsoChoice {
    /// Flat triangles, lit by their own normals
    Facets,
    /// The curved surface, lit by interpolated vertex normals
    Interpolated,
    /// The paper's surface, with the default bounds and root finder
    Angular,
    /// Curvature as a quadratic form
    Tensor,
    /// As tensor, with tangent planes that agree across edges
    Smooth,
    /// The paper's surface, bounds and root finder
    Paper,
    /// No further form
    None,
}

/// The most pixels of a picture: several pictures stay in memory, with some hundred bytes a pixel.
const MOST_PIXELS: usize = 1 << 26;

impl CompareArgs {
    /// What is compared, flat triangles first.
    pub fn forms(&self) -> Result<Vec<Contestant>> {
        let curved = self.surface.form()?;
        if curved == Form::Flat {
            return usage(
                "compare sets a curved surface beside flat triangles: not --surface flat",
            );
        }
        let mut forms = vec![
            Contestant::flat("flat"),
            Contestant::curved("curved", curved).lit_by(self.light.shading()),
        ];
        for choice in &self.also {
            let Some(also) = choice.contestant(curved) else {
                continue;
            };
            let same = |old: &Contestant| old.form == also.form && old.shading == also.shading;
            if !forms.iter().any(same) {
                forms.push(also);
            }
        }
        Ok(forms)
    }

    /// Looks for mistakes that show in the arguments alone.
    pub fn check(&self) -> Result<()> {
        ends_in(&self.output, &["png"])?;
        if let Some(report) = &self.report {
            ends_in(report, &["html", "htm"])?;
        }
        if self.size[0] * self.size[1] > MOST_PIXELS {
            return usage(format!("a picture has at most {MOST_PIXELS} pixels"));
        }
        if self.light.background() == Background::Transparent {
            return usage("--transparent is for render: compared pictures have a background");
        }
        self.integrator.integrator()?;
        self.integrator.material()?;
        self.view.check()
    }
}

impl AlsoChoice {
    /// `compared` is the form that is set beside flat triangles.
    fn contestant(self, compared: Form) -> Option<Contestant> {
        let curved = |name, surface| {
            let options = CurvedOptions { surface, ..plain() };
            Contestant::curved(name, Form::Curved(options))
        };
        Some(match self {
            Self::None => return None,
            Self::Paper => Contestant::curved("paper", Form::Curved(CurvedOptions::paper())),
            Self::Facets => Contestant::facets(),
            Self::Interpolated => {
                Contestant::curved(INTERPOLATED, compared).lit_by(Shading::Interpolated)
            }
            Self::Angular => curved("angular", Surface::Angular),
            Self::Tensor => curved("tensor", Surface::Tensor),
            Self::Smooth => curved("smooth", Surface::Smooth),
        })
    }
}

fn ends_in(path: &Path, endings: &[&str]) -> Result<()> {
    let ending = path.extension().map(|e| e.to_ascii_lowercase());
    if endings
        .iter()
        .any(|known| ending.as_deref() == Some(known.as_ref()))
    {
        return Ok(());
    }
    usage(format!(
        "{} does not end in .{}",
        path.display(),
        endings[0]
    ))
}
