//! `curvetri bench`: curved triangles against flat ones.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use curvetri::mesh::Loader;
use curvetri::output::OutputFile;
use curvetri_bench::{
    BenchOptions, Clock, Goal, Machine, MeshReport, NamedForm, RayKind, Subject, TorusBytes, Way,
};
use curvetri_bodies::{bumpy_torus, bumpy_torus_distance};

use super::bench_report::{json, markdown, text};
use super::console::{self, Console};
use super::{usage, values};

/// Sizes of the torus if neither meshes nor sizes are given.
const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];

/// Measure the speed and memory of curved triangles against flat ones
///
/// Traces each mesh in many forms, in one run and with the same rays: Embree's flat triangles, which
/// are the baseline; curved triangles with each surface and root finder; the curved surface cut into
/// flat triangles and into Embree's grids; and Embree's subdivision surface. Each form takes turns with
/// the baseline, and ratios are medians over the rounds. The baseline uses the packet width and the
/// flag that are best for it. Vertices and triangles are put into random order first.
///
/// Without files and sizes the meshes are bumpy tori of 10 thousand, 100 thousand and 1 million
/// triangles.
#[derive(Args)]
pub struct BenchArgs {
    /// Mesh files (OBJ, PLY, STL, OFF, glTF, GLB, also as .gz)
    #[arg(value_name = "MESH")]
    meshes: Vec<PathBuf>,

    /// Measure bumpy tori of about these numbers of triangles, in addition to the files
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = values::triangles)]
    triangles: Vec<usize>,

    /// Print all results as JSON
    #[arg(long)]
    json: bool,

    /// Write the tables as Markdown, with a description of the machine
    #[arg(long, value_name = "FILE.md")]
    markdown: Option<PathBuf>,

    /// Take about a minute: a torus of 10 thousand triangles, fewer forms, rays and rounds
    #[arg(long)]
    quick: bool,

    /// Forms to measure in addition to flat [default: all]
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    forms: Vec<String>,

    /// Kinds of rays [default: all]
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    kinds: Vec<String>,

    /// Packet widths: 1, 4, 8 or 16 rays, with a c after it for Embree's coherent flag. They apply to
    /// the baseline as well [default: all]
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    ways: Vec<String>,

    /// About how many rays of each kind [default: 262144]
    #[arg(long, value_name = "N", value_parser = values::samples)]
    rays: Option<usize>,

    /// How many rounds [default: 5]
    #[arg(long, value_name = "N", value_parser = values::rounds)]
    rounds: Option<usize>,

    /// Numbers of threads to trace on [default: 1 and all]
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = values::threads)]
    threads: Vec<usize>,

    /// Count processor time, not wall-clock time: for machines that are busy with other work
    #[arg(long)]
    cpu_time: bool,

    /// Leave out forms that need more memory than this many gigabytes [default: two thirds of what is
    /// free]
    #[arg(long, value_name = "GB", value_parser = values::number)]
    memory: Option<f64>,
}

/// What was measured.
pub struct BenchReport {
    pub machine: Machine,
    pub options: BenchOptions,
    pub meshes: Vec<MeshReport>,
    pub torus: TorusBytes,
    pub goals: Vec<Goal>,
}

/// Runs the command.
pub fn run(args: &BenchArgs, console: &Console) -> Result<()> {
    let options = args.options()?;
    let machine = Machine::new()?;
    let file = args.markdown.as_deref().map(OutputFile::create);
    let file = file.transpose()?;
    // before the long work: a file may be missing
    let files = args.meshes.iter().map(|path| read(path));
    let files = files.collect::<Result<Vec<Subject>>>()?;
    let bar = console.spinner("measuring");
    let say = |what: &str| {
        console.note(what);
        bar.set_message(what.to_owned());
    };
    let mut meshes = Vec::new();
    for size in args.sizes() {
        let subject = Subject {
            name: format!("bumpy-torus-{size}"),
            mesh: bumpy_torus(size),
            truth: Some(bumpy_torus_distance),
        };
        meshes.push(measure(&subject, &options, &say)?);
    }
    for subject in &files {
        meshes.push(measure(subject, &options, &say)?);
    }
    say("torus-48x64: bytes at equal error");
    let torus = curvetri_bench::torus_bytes().context("cannot measure the torus")?;
    bar.finish_and_clear();
    let goals = curvetri_bench::goals(&meshes, Some(&torus));
    let report = BenchReport {
        machine,
        options,
        meshes,
        torus,
        goals,
    };
    if let Some(file) = file {
        let page = markdown(&report);
        file.finish(|out| out.write_all(page.as_bytes()))?;
    }
    console::print(&if args.json {
        json(&report)
    } else {
        text(&report)
    })
}

fn measure(subject: &Subject, options: &BenchOptions, say: &dyn Fn(&str)) -> Result<MeshReport> {
    curvetri_bench::measure(subject, options, say)
        .with_context(|| format!("cannot measure {}", subject.name))
}

fn read(path: &Path) -> Result<Subject> {
    let name = path.file_stem().unwrap_or(path.as_os_str());
    Ok(Subject {
        name: name.to_string_lossy().into_owned(),
        mesh: Loader::new().load(path)?.mesh,
        truth: None,
    })
}

impl BenchArgs {
    fn sizes(&self) -> Vec<usize> {
        match (&*self.triangles, &*self.meshes) {
            ([], []) if self.quick => SIZES[..1].to_vec(),
            ([], []) => SIZES.to_vec(),
            (sizes, _) => sizes.to_vec(),
        }
    }

    fn options(&self) -> Result<BenchOptions> {
        let mut options = if self.quick {
            BenchOptions::quick()
        } else {
            BenchOptions::default()
        };
        if !self.forms.is_empty() {
            options.forms = named(
                &self.forms,
                curvetri_bench::forms(),
                "form",
                |form: &NamedForm| form.name.clone(),
            )?;
        }
        if !self.kinds.is_empty() {
            let all = RayKind::ALL.to_vec();
            options.kinds = named(&self.kinds, all, "kind of rays", |kind| {
                kind.name().to_owned()
            })?;
        }
        if !self.ways.is_empty() {
            options.ways = named(&self.ways, Way::ALL.to_vec(), "way", Way::name)?;
        }
        if !self.threads.is_empty() {
            options.threads.clone_from(&self.threads);
        }
        if self.cpu_time {
            options.clock = Clock::Processor;
        }
        options.rays = self.rays.unwrap_or(options.rays);
        options.rounds = self.rounds.unwrap_or(options.rounds);
        if let Some(gigabytes) = self.memory {
            options.memory = (gigabytes * 1e9) as u64;
        }
        Ok(options)
    }
}

/// Those of all that have one of the wanted names.
fn named<T: Clone>(
    wanted: &[String],
    all: Vec<T>,
    what: &str,
    name: impl Fn(&T) -> String,
) -> Result<Vec<T>> {
    for wanted_name in wanted {
        if !all.iter().any(|one| name(one) == *wanted_name) {
            let names: Vec<String> = all.iter().map(&name).collect();
            return usage(format!(
                "there is no {what} named {wanted_name}; there are {}",
                names.join(", ")
            ));
        }
    }
    Ok(all
        .into_iter()
        .filter(|one| wanted.contains(&name(one)))
        .collect())
}
