//! `curvetri compare`: a curved surface beside flat triangles, what it gains and what it costs.

mod args;
mod figures;
mod findings;
mod measure;
mod pictures;
mod report;
mod sheet;
mod table;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Result;
use curvetri::mesh::{Parts, Scenery};
use curvetri::output::OutputFile;
use curvetri::render::Form;

pub use args::CompareArgs;

use self::figures::Figures;
use self::measure::{Comparison, Measured};
use self::pictures::Pictures;
use super::console::{self, Console};
use super::on_threads;

/// Meshes that were read, and how long that took.
struct LoadedMeshes {
    parts: Parts,
    scenery: Scenery,
    time: Duration,
}

/// What was measured of everything that is compared. The first form is the flat one, the second the
/// one it is compared with.
struct Measurements {
    forms: Vec<Measured>,
    reference: Option<Measured>,
}

impl Measurements {
    fn flat(&self) -> &Measured {
        &self.forms[0]
    }

    fn curved(&self) -> &Measured {
        &self.forms[1]
    }

    /// What stands for the true surface when shadows are judged.
    fn truth(&self) -> &Measured {
        self.reference.as_ref().unwrap_or(self.curved())
    }

    fn all(&self) -> impl Iterator<Item = &Measured> {
        self.forms.iter().chain(&self.reference)
    }
}

/// Runs the command.
pub fn run(args: &CompareArgs, console: &Console) -> Result<()> {
    let forms = args.forms()?;
    args.check()?;
    let figures = on_threads(args.threads, || {
        let loaded = args.load(&args.meshes, console)?;
        let reference = args.load_reference(&loaded, console)?;
        let sheet = OutputFile::create(&args.output)?;
        let report = args.report.as_ref().map(OutputFile::create).transpose()?;
        let lowest = match &reference {
            Some(fine) => (fine, Form::Flat),
            None => (&loaded, forms[1].form),
        };
        let comparison = Comparison::new(args, &loaded, lowest)?;
        let (forms, reference) = comparison.measure(forms, &loaded, reference.as_ref(), console)?;
        let measurements = Measurements { forms, reference };
        if measurements.all().all(|form| form.view.is_empty()) {
            console.warn("the camera sees nothing of the meshes: all pictures are the same");
        }
        let bar = console.spinner("comparing");
        let pictures = Pictures::of(&measurements);
        let figures = Figures::of(args, &measurements, &pictures, comparison.embree());
        sheet.finish(|out| sheet::write(&pictures, out))?;
        if let Some(report) = report {
            let html = report::html(&figures, &pictures)?;
            report.finish(|out| out.write_all(html.as_bytes()))?;
        }
        bar.finish_and_clear();
        Ok(figures)
    })?;
    if args.json {
        console::print(&format!("{}\n", serde_json::to_string_pretty(&figures)?))
    } else {
        console::print(&table::text(&figures))
    }
}

impl CompareArgs {
    fn load(&self, paths: &[PathBuf], console: &Console) -> Result<LoadedMeshes> {
        let start = Instant::now();
        let (parts, scenery) = self.surface.load_all(paths, console)?;
        Ok(LoadedMeshes {
            parts,
            scenery,
            time: start.elapsed(),
        })
    }

    /// The reference, if there is one; warns if it can hardly be the truth.
    fn load_reference(
        &self,
        coarse: &LoadedMeshes,
        console: &Console,
    ) -> Result<Option<LoadedMeshes>> {
        if self.reference.is_empty() {
            return Ok(None);
        }
        let fine = self.load(&self.reference, console)?;
        let triangles = |loaded: &LoadedMeshes| loaded.parts.triangles();
        let names = names(&self.reference).join(", ");
        if triangles(&fine) <= triangles(coarse) {
            console.warn(&format!(
                "{names}: as a reference it should have more triangles than the {} of the meshes, \
                 not {}",
                triangles(coarse),
                triangles(&fine)
            ));
        }
        if let (Some(a), Some(b)) = (coarse.parts.bounds(), fine.parts.bounds()) {
            let off = (a.min - b.min).abs().max((a.max - b.max).abs());
            let share = off.max_element() / a.diagonal();
            if share > 0.1 {
                console.warn(&format!(
                    "{names}: its bounds are off the meshes' by {:.0} % of their size; is it the \
                     same body in the same place?",
                    100.0 * share
                ));
            }
        }
        Ok(Some(fine))
    }
}

/// The files' names without their directories.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_owned();
    paths
        .iter()
        .map(|path| Path::new(&name(path)).display().to_string())
        .collect()
}
