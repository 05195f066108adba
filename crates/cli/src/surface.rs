//! The options that say what a mesh's triangles stand for, the same for all commands.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use curvetri::curved::{CurvedOptions, FlatTriangles, Primitives};
use curvetri::mesh::{LoadReport, Loaded, Loader, Mesh, NormalsPolicy, Parts, Scenery};
use curvetri::method::{BoundsKind, Solver, Surface};
use curvetri::render::Form;

use super::console::Console;
use super::usage;
use super::values::{self, Tolerance};

/// What is said of meshes that no ray hits.
const NOTHING_TO_SEE: &str = "no triangle has an area: there is nothing to see";

#[derive(Args)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceArgs {
    /// The form of the method. --surface, --bounds, --primitives and --solver override its parts
    #[arg(long, value_enum, default_value_t = MethodChoice::Default)]
    method: MethodChoice,

    /// The surface that the triangles stand for [default: smooth, or angular with --method paper]
    #[arg(long, value_enum)]
    surface: Option<SurfaceChoice>,

    /// What bounds a curved triangle [default: tight, or sphere with --method paper]
    #[arg(long, value_enum)]
    bounds: Option<BoundsChoice>,

    /// What is one primitive for Embree [default: clusters, or triangles with --method paper]
    #[arg(long, value_enum)]
    primitives: Option<PrimitivesChoice>,

    /// How roots are found [default: finish, or ita with --method paper, --ita-bits or --ita-step]
    #[arg(long, value_enum)]
    solver: Option<SolverChoice>,

    /// Binary digits of a root (the paper's n); implies --solver ita [default: 24]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=30))]
    ita_bits: Option<u32>,

    /// Binary digits that each step adds (the paper's n1); implies --solver ita [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8))]
    ita_step: Option<u32>,

    /// Keep triangles flat whose surface is this close to their plane: a length in the units of the
    /// mesh, or, for `render`, in pixels as in 0.05px. If a third of a mesh is flat, Embree traces
    /// those triangles itself [default: 0]
    #[arg(long, value_name = "LENGTH", value_parser = values::tolerance)]
    tolerance: Option<Tolerance>,

    /// Where normals are missing, faces that meet at a greater angle than this form a hard edge
    /// [default: 30, or as the smoothing groups of an OBJ file say]
    #[arg(long, value_name = "DEGREES", value_parser = values::crease)]
    crease_angle: Option<f32>,

    /// Which of the normals in a file are used
    #[arg(long, value_enum, default_value_t = NormalsChoice::Auto)]
    normals: NormalsChoice,

    /// Skip faces and corners that are wrong, and count them, instead of refusing the file
    #[arg(long)]
    lenient: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodChoice {
    /// The smooth surface, tight bounds, a fast root finder
    Default,
    /// The paper's: the angular surface, spheres of greatest curvature, the iterative algorithm (ITA)
    Paper,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BoundsChoice {
    /// The paper's sphere of greatest curvature, the one on the circumscribed circle
    Sphere,
    /// The least and the greatest height that the surface may have
    Tight,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PrimitivesChoice {
    /// One triangle
    Triangles,
    /// Up to eight neighbouring triangles
    Clusters,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SolverChoice {
    /// The paper's iterative algorithm (ITA)
    Ita,
    /// Samples, then a superlinear bracketing method
    Finish,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NormalsChoice {
    /// All
    Stored,
    /// None: all normals are made from the triangles
    Smooth,
    /// All except those of flat facets on what looks like a curved body, and plain averages of large and small
    /// faces where all normals are such averages
    Auto,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SurfaceChoice {
    /// The flat triangles themselves
    Flat,
    /// The paper's surface
    Angular,
    /// Curvature as a quadratic form: better on fine meshes
    Tensor,
    /// As tensor, with tangent planes that agree across edges
    Smooth,
}

/// The default form of our own scenes, which may have two geometries a mesh.
pub fn plain() -> CurvedOptions {
    CurvedOptions {
        flat: FlatTriangles::Separate,
        ..CurvedOptions::default()
    }
}

impl SurfaceArgs {
    /// What the triangles stand for, where there is no camera.
    pub fn form(&self) -> Result<Form> {
        match self.tolerance {
            Some(Tolerance::Pixels(_)) => {
                usage("--tolerance in pixels is for `curvetri render`, which has a camera")
            }
            Some(Tolerance::Length(length)) => self.form_within(length),
            None => self.form_within(0.0),
        }
    }

    /// The tolerance, where it is in pixels.
    pub fn tolerated_pixels(&self) -> Option<f32> {
        match self.tolerance {
            Some(Tolerance::Pixels(pixels)) => Some(pixels),
            _ => None,
        }
    }

    /// The same with this length as the tolerance.
    pub fn form_within(&self, tolerance: f32) -> Result<Form> {
        let preset = match self.method {
            MethodChoice::Default => plain(),
            MethodChoice::Paper => CurvedOptions::paper(),
        };
        let surface = match self.surface {
            None => preset.surface,
            Some(SurfaceChoice::Flat) => return self.flat(),
            Some(SurfaceChoice::Angular) => Surface::Angular,
            Some(SurfaceChoice::Tensor) => Surface::Tensor,
            Some(SurfaceChoice::Smooth) => Surface::Smooth,
        };
        let bounds = match self.bounds {
            None => preset.bounds,
            Some(BoundsChoice::Sphere) => BoundsKind::Sphere,
            Some(BoundsChoice::Tight) => BoundsKind::Tight,
        };
        let primitives = match self.primitives {
            None => preset.primitives,
            Some(PrimitivesChoice::Triangles) => Primitives::Triangles,
            Some(PrimitivesChoice::Clusters) => Primitives::Clusters,
        };
        Ok(Form::Curved(CurvedOptions {
            surface,
            bounds,
            primitives,
            solver: self.solver(preset.solver)?,
            tolerance,
            ..preset
        }))
    }

    fn flat(&self) -> Result<Form> {
        let given = [
            ("--method paper", self.method == MethodChoice::Paper),
            ("--bounds", self.bounds.is_some()),
            ("--primitives", self.primitives.is_some()),
            ("--solver", self.solver.is_some()),
            ("--ita-bits", self.ita_bits.is_some()),
            ("--ita-step", self.ita_step.is_some()),
            ("--tolerance", self.tolerance.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            None => Ok(Form::Flat),
            Some((name, _)) => usage(format!(
                "{name} is for curved surfaces, not for flat ones; leave it out, or --surface flat"
            )),
        }
    }

    fn solver(&self, preset: Solver) -> Result<Solver> {
        let digits = self.ita_bits.is_some() || self.ita_step.is_some();
        let chosen = match self.solver {
            Some(SolverChoice::Finish) if digits => {
                return usage(
                    "--ita-bits and --ita-step are for --solver ita; leave them out, or choose that",
                );
            }
            Some(SolverChoice::Finish) => Solver::default(),
            Some(SolverChoice::Ita) => Solver::ITA,
            None if digits => Solver::ITA,
            None => preset,
        };
        Ok(match chosen {
            Solver::Ita { bits, step } => Solver::Ita {
                bits: self.ita_bits.unwrap_or(bits),
                step: self.ita_step.unwrap_or(step),
            },
            finish @ Solver::Bracketing { .. } => finish,
        })
    }

    /// Reads a mesh and tells what was odd about it.
    pub fn load(&self, path: &Path, console: &Console) -> Result<Loaded> {
        let loaded = self.read(path, console)?;
        if loaded.report.is_without_area() {
            bail!(NOTHING_TO_SEE);
        }
        Ok(loaded)
    }

    /// Reads meshes, and what else their files have; tells what was odd. What a file uses several
    /// times stays separate.
    pub fn load_all(&self, paths: &[PathBuf], console: &Console) -> Result<(Parts, Scenery)> {
        let (mut parts, mut scenery) = (Parts::default(), Scenery::default());
        let mut is_without_area = true;
        for path in paths {
            let bar = console.progress("reading", 1000);
            let report = |share| bar.set_position((1000.0 * share) as u64);
            let loaded = self.loader().progress(&report).load_parts(path)?;
            bar.finish_and_clear();
            for mesh in &loaded.parts.meshes {
                Self::note(path, mesh, console);
            }
            Self::warn(path, &loaded.report, console);
            is_without_area &= loaded.report.is_without_area();
            parts.append(loaded.parts);
            scenery.append(loaded.scenery);
        }
        if is_without_area {
            bail!(NOTHING_TO_SEE);
        }
        let imprecise = parts.imprecise_triangles();
        if imprecise > 0 {
            let triangles = if imprecise == 1 {
                "triangle"
            } else {
                "triangles"
            };
            console.warn(&format!(
                "the meshes lie so far apart that single precision does not hold the shape of \
                 {imprecise} {triangles}; move them nearer to each other, or render them one by one"
            ));
        }
        Ok((parts, scenery))
    }

    /// Reads a mesh, even one that no ray hits, and tells what was odd about it.
    pub fn read(&self, path: &Path, console: &Console) -> Result<Loaded> {
        let bar = console.progress("reading", 1000);
        let report = |share| bar.set_position((1000.0 * share) as u64);
        let loaded = self.loader().progress(&report).load(path)?;
        bar.finish_and_clear();
        Self::note(path, &loaded.mesh, console);
        Self::warn(path, &loaded.report, console);
        Ok(loaded)
    }

    fn warn(path: &Path, report: &LoadReport, console: &Console) {
        for warning in &report.warnings {
            console.warn(&format!("{}: {warning}", path.display()));
        }
    }

    fn loader(&self) -> Loader<'_> {
        let policy = match self.normals {
            NormalsChoice::Stored => NormalsPolicy::Stored,
            NormalsChoice::Smooth => NormalsPolicy::Smooth,
            NormalsChoice::Auto => NormalsPolicy::Auto,
        };
        let loader = Loader::new().normals(policy).lenient(self.lenient);
        match self.crease_angle {
            Some(degrees) => loader.crease_angle_degrees(degrees),
            None => loader,
        }
    }

    fn note(path: &Path, mesh: &Mesh, console: &Console) {
        console.note(&format!(
            "{}: {} triangles, {} vertices",
            path.display(),
            mesh.triangles().len(),
            mesh.positions().len()
        ));
    }
}
