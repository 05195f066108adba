//! The options that say what a mesh's triangles stand for, the same for all commands.

use std::path::Path;

use anyhow::Result;
use clap::{Args, ValueEnum};
use curvetri::curved::CurvedOptions;
use curvetri::mesh::{self, LoadOptions, Loaded, Mesh, NormalsPolicy};
use curvetri::render::Form;
use curvetri::surface::{Solver, Surface};

use super::console::Console;
use super::{usage, values};

/// Digits of a root if only their number a step is given: all that single precision has.
const DEFAULT_BITS: u32 = 24;
/// Digits a step if only the number of digits is given: the least that misses no root in practice.
const DEFAULT_STEP: u32 = 3;

#[derive(Args)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceArgs {
    /// What the triangles stand for
    #[arg(long, value_enum, default_value_t = SurfaceChoice::Smooth)]
    surface: SurfaceChoice,

    /// Find roots by the paper's iterative algorithm, to this many binary digits (n) [default with
    /// --ita-step: 24]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=30))]
    ita_bits: Option<u32>,

    /// Find roots by the paper's iterative algorithm, this many binary digits a step (n1) [default
    /// with --ita-bits: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8))]
    ita_step: Option<u32>,

    /// Where normals are missing, faces that meet at a greater angle than this make a hard edge
    #[arg(long, value_name = "DEGREES", default_value = "30", value_parser = values::crease)]
    crease_angle: f32,

    /// Which of the normals that a file has are used
    #[arg(long, value_enum, default_value_t = NormalsChoice::Auto)]
    normals: NormalsChoice,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NormalsChoice {
    /// All
    Stored,
    /// None: all are made from the triangles
    Smooth,
    /// All but flat ones on what looks like a curved wall
    Auto,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SurfaceChoice {
    /// Themselves
    Flat,
    /// The paper's curved triangles
    Angular,
    /// Curved by a quadratic form; better on fine meshes
    Tensor,
    /// As tensor, with tangent planes that agree across sides
    Smooth,
}

impl SurfaceArgs {
    /// What the triangles stand for.
    pub fn form(&self) -> Result<Form> {
        let ita = self.ita_bits.is_some() || self.ita_step.is_some();
        let surface = match self.surface {
            SurfaceChoice::Flat if ita => {
                return usage(
                    "--ita-bits and --ita-step are for curved surfaces, not for flat ones",
                );
            }
            SurfaceChoice::Flat => return Ok(Form::Flat),
            SurfaceChoice::Angular => Surface::Angular,
            SurfaceChoice::Tensor => Surface::Tensor,
            SurfaceChoice::Smooth => Surface::Smooth,
        };
        let solver = if ita {
            Solver::Ita {
                bits: self.ita_bits.unwrap_or(DEFAULT_BITS),
                step: self.ita_step.unwrap_or(DEFAULT_STEP),
            }
        } else {
            Solver::default()
        };
        Ok(Form::Curved(CurvedOptions {
            surface,
            solver,
            ..CurvedOptions::default()
        }))
    }

    /// Reads a mesh and tells what was odd about it.
    pub fn load(&self, path: &Path, console: &Console) -> Result<Mesh> {
        let loaded = self.read(path, console)?;
        for warning in &loaded.report.warnings {
            console.warn(&format!("{}: {warning}", path.display()));
        }
        Ok(loaded.mesh)
    }

    /// Reads a mesh, with what was odd about it.
    pub fn read(&self, path: &Path, console: &Console) -> Result<Loaded> {
        let options = LoadOptions {
            crease_angle_degrees: self.crease_angle,
            normals: match self.normals {
                NormalsChoice::Stored => NormalsPolicy::Stored,
                NormalsChoice::Smooth => NormalsPolicy::Smooth,
                NormalsChoice::Auto => NormalsPolicy::Auto,
            },
        };
        let bar = console.spinner("reading");
        let loaded = mesh::load(path, &options)?;
        bar.finish_and_clear();
        console.note(&format!(
            "{}: {} triangles, {} vertices",
            path.display(),
            loaded.mesh.triangles().len(),
            loaded.mesh.positions().len()
        ));
        Ok(loaded)
    }
}
