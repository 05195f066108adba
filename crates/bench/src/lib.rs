//! How fast the curved form of a mesh is against the flat one, in one run on the same rays.
//!
//! [`measure`] traces a mesh in many [forms](TracedForm): Embree's own flat triangles, the baseline; curved
//! triangles in all their ways; and the curved surface cut into flat ones. Each form is built in turn
//! and traced in rounds with the baseline in between, so that what else the machine does falls on
//! both; ratios are medians over the rounds. [`goals`] draws the project's goals from the reports.
//!
//! Vertices and triangles are shuffled first, as if the file had them so: locality is to be earned, not
//! inherited.

mod clock;
mod equal;
mod forms;
mod goals;
mod grids;
mod machine;
mod measure;
mod rays;
mod report;
mod shuffle;
mod torus;

use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuilder};
use thiserror::Error;

use curvetri::curved::{CurvedMesh, CurvedOptions};
use curvetri::embree::{self, Geometry, Scene, SceneBuilder};
use curvetri::mesh::{Mesh, MeshError};
use measure::PackedRays;
use rays::RayMaker;

pub use clock::Clock;
pub use equal::{SurfaceErrors, Truth};
pub use forms::{BASELINE, BuildTimes, Bytes, Cut, DEFAULT, NamedForm, TracedForm, forms};
pub use goals::{Goal, goals};
pub use machine::{Machine, spare_memory};
pub use measure::Way;
pub use rays::RayKind;
pub use report::{FormReport, MedianRange, MeshReport, Misses, Outcome, RayRow};
pub use torus::{TorusBytes, torus_bytes};

/// Why nothing was measured.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BenchError {
    /// Embree's own reason.
    #[error(transparent)]
    Embree(#[from] embree::Error),
    /// A mesh cannot be cut that finely.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Threads cannot be started.
    #[error("cannot start the threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// A mesh to be measured.
pub struct Subject {
    /// As it appears in reports.
    pub name: String,
    /// The mesh.
    pub mesh: Mesh,
    /// Its true surface, where that is known.
    pub truth: Option<Truth>,
}

/// What is measured, and how thoroughly.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// The forms, of which the baseline is measured always.
    pub forms: Vec<NamedForm>,
    /// The kinds of rays.
    pub kinds: Vec<RayKind>,
    /// About how many rays of a kind.
    pub rays: usize,
    /// How often each time is taken.
    pub rounds: usize,
    /// What time is taken. Of building it is that of all threads together.
    pub clock: Clock,
    /// Numbers of threads to trace on.
    pub threads: Vec<usize>,
    /// The ways in which the baseline and the default are traced. Other forms are traced in those of them that
    /// may be [best](Way::FEW), or in all where none of these is there.
    pub ways: Vec<Way>,
    /// Bytes that a form may need; larger ones are left out.
    pub memory: u64,
}

impl Default for BenchOptions {
    fn default() -> Self {
        let mut threads = vec![1, machine::all_threads()];
        threads.dedup();
        Self {
            forms: forms(),
            kinds: RayKind::ALL.to_vec(),
            rays: 1 << 18,
            rounds: 5,
            clock: Clock::Wall,
            threads,
            ways: Way::ALL.to_vec(),
            memory: spare_memory(),
        }
    }
}

impl BenchOptions {
    /// What is over within a minute, for a mesh of ten thousand triangles: fewer forms, rays and rounds.
    #[must_use]
    pub fn quick() -> Self {
        let left_out = [
            "robust", "compact", "low", "high", "apart", "tensor", "angular", "sphere", "ita1",
            "ita2", "ita4", "x4", "equal",
        ];
        let mut quick = Self::default();
        quick
            .forms
            .retain(|form| !left_out.iter().any(|end| form.name.ends_with(end)));
        quick.threads = quick.threads.split_off(quick.threads.len() - 1);
        Self {
            rays: 1 << 15,
            rounds: 3,
            ways: Way::FEW.to_vec(),
            ..quick
        }
    }
}

/// Measures a mesh; `progress` gets a few words on what is being done.
///
/// # Errors
/// If Embree, the threads or a cut fail.
pub fn measure(
    subject: &Subject,
    options: &BenchOptions,
    progress: &dyn Fn(&str),
) -> Result<MeshReport, BenchError> {
    progress(&format!("{}: making rays", subject.name));
    let bench = BenchRun::new(subject, options)?;
    progress(&format!("{}: {BASELINE}", subject.name));
    let (flat, baseline) = bench.baseline()?;
    let mut forms = vec![baseline];
    for form in &options.forms {
        if form.name != BASELINE {
            progress(&format!("{}: {}", subject.name, form.name));
            let report = bench.form(form, &flat, &forms[0])?;
            forms.push(report);
        }
    }
    Ok(MeshReport {
        name: subject.name.clone(),
        triangles: bench.mesh.triangles().len(),
        kinds: *bench.curved.kinds(),
        errors: bench.errors,
        forms,
    })
}

/// A mesh with its rays.
struct BenchRun<'a> {
    options: &'a BenchOptions,
    mesh: Arc<Mesh>,
    curved: Arc<CurvedMesh>,
    errors: Option<SurfaceErrors>,
    rays: Vec<PackedRays>,
    /// How far the rays of each kind go on the default surface; empty for kinds that are not looked at.
    distances: Vec<Vec<f32>>,
    one: ThreadPool,
    pools: Vec<ThreadPool>,
}

impl<'a> BenchRun<'a> {
    fn new(subject: &Subject, options: &'a BenchOptions) -> Result<Self, BenchError> {
        let mesh = Arc::new(shuffle::shuffled(&subject.mesh).ordered());
        let curved = Arc::new(CurvedMesh::new(mesh.clone(), &CurvedOptions::default()));
        let scene = curved_scene(&curved)?;
        let all = RayMaker::new(&scene, &curved, options.rays).make();
        let wanted = |kind: &RayKind| options.kinds.contains(kind);
        let rays: Vec<PackedRays> = RayKind::ALL
            .iter()
            .zip(&all)
            .filter(|(kind, rays)| wanted(kind) && !rays.is_empty())
            .map(|(kind, rays)| PackedRays::new(*kind, rays))
            .collect();
        let looked_at = |rays: &PackedRays| match rays.kind {
            RayKind::Primary | RayKind::Diffuse => rays.distances(&scene),
            _ => Vec::new(),
        };
        let pool = |&threads: &usize| ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(Self {
            options,
            errors: subject.truth.map(|truth| SurfaceErrors::of(&curved, truth)),
            distances: rays.iter().map(looked_at).collect(),
            rays,
            mesh,
            curved,
            one: pool(&1)?,
            pools: options.threads.iter().map(pool).collect::<Result<_, _>>()?,
        })
    }

    /// Builds and measures the form that the others are compared with.
    fn baseline(&self) -> Result<(Scene, FormReport), BenchError> {
        let built = TracedForm::BASELINE.build(&self.mesh, 1, self.options.clock)?;
        let mut report = FormReport::new(BASELINE, &built);
        for rays in &self.rays {
            for pool in &self.pools {
                let ways = self.ways(BASELINE, rays.kind);
                let mut times = vec![Vec::new(); ways.len()];
                for _ in 0..self.options.rounds {
                    for (way, times) in ways.iter().zip(&mut times) {
                        times.push(rays.time(&built.scene, *way, pool, self.options.clock));
                    }
                }
                let best = times.iter().map(|times| median(times.iter().copied()));
                let best = best.fold(f64::INFINITY, f64::min);
                for (way, times) in ways.iter().zip(times) {
                    let ratios = times.iter().map(|time| best / time).collect();
                    let row = self.row(&built.scene, rays, *way, pool, times, ratios);
                    report.rows.push(row);
                }
            }
        }
        Ok((built.scene, report))
    }

    /// Builds and measures a form, in turns with the baseline.
    fn form(
        &self,
        named: &NamedForm,
        flat: &Scene,
        baseline: &FormReport,
    ) -> Result<FormReport, BenchError> {
        let parts = match self.parts(named) {
            Ok(parts) => parts,
            Err(reason) => return Ok(FormReport::skipped(&named.name, reason)),
        };
        let built = match named.form.build(&self.mesh, parts, self.options.clock) {
            Err(BenchError::Mesh(error)) => {
                return Ok(FormReport::skipped(&named.name, error.to_string()));
            }
            built => built?,
        };
        let mut report = FormReport::new(&named.name, &built);
        report.parts = parts;
        for rays in &self.rays {
            for pool in &self.pools {
                let threads = pool.current_num_threads();
                let flat_way = baseline
                    .best(rays.kind, threads)
                    .expect("the baseline has all kinds")
                    .way;
                let flat = (flat, flat_way);
                report
                    .rows
                    .extend(self.in_turns(&named.name, &built.scene, flat, rays, pool));
            }
        }
        if is_other_solver(&named.form) {
            report.misses = Some(self.misses(&built.scene));
        }
        Ok(report)
    }

    /// Into how many parts a form's edges are cut, or why it is not measured.
    fn parts(&self, named: &NamedForm) -> Result<u32, String> {
        let parts = named.form.parts();
        let parts = parts.or(self.errors.map(|errors| errors.parts()));
        let parts = parts.ok_or("the true surface is not known")?;
        let need = named.form.need(&self.mesh, parts);
        if need > self.options.memory {
            let gigabytes = |bytes: u64| bytes as f64 * 1e-9;
            return Err(format!(
                "cut into {parts} parts an edge it needs about {:.1} GB, more than {:.1} GB",
                gigabytes(need),
                gigabytes(self.options.memory)
            ));
        }
        Ok(parts)
    }

    /// Traces rays in all ways of a form, in turns with the baseline in its best way.
    fn in_turns(
        &self,
        form: &str,
        scene: &Scene,
        (flat, flat_way): (&Scene, Way),
        rays: &PackedRays,
        pool: &ThreadPool,
    ) -> Vec<RayRow> {
        let ways = self.ways(form, rays.kind);
        let mut times = vec![Vec::new(); ways.len()];
        let mut flat_times = Vec::new();
        for _ in 0..self.options.rounds {
            flat_times.push(rays.time(flat, flat_way, pool, self.options.clock));
            for (way, times) in ways.iter().zip(&mut times) {
                times.push(rays.time(scene, *way, pool, self.options.clock));
            }
        }
        let rows = ways.iter().zip(times).map(|(way, times)| {
            let ratios = flat_times.iter().zip(&times);
            let ratios = ratios.map(|(flat, time)| flat / time).collect();
            self.row(scene, rays, *way, pool, times, ratios)
        });
        rows.collect()
    }

    fn row(
        &self,
        scene: &Scene,
        rays: &PackedRays,
        way: Way,
        pool: &ThreadPool,
        times: Vec<f64>,
        ratios: Vec<f64>,
    ) -> RayRow {
        let (hits, kernel) = rays.count(scene, way, &self.one);
        let speed = |time: &f64| rays.count as f64 * 1e-6 / time;
        RayRow {
            kind: rays.kind,
            way,
            threads: pool.current_num_threads(),
            mray_per_second: MedianRange::of(times.iter().map(speed).collect()),
            ratio: MedianRange::of(ratios),
            rays: rays.count as u64,
            hits,
            kernel,
        }
    }

    /// The ways in which a form is traced: the main forms in all that are wanted, others in those that may be best.
    fn ways(&self, form: &str, kind: RayKind) -> Vec<Way> {
        let wanted = &self.options.ways;
        let [single, packets] = Way::FEW;
        let few = match kind {
            RayKind::Diffuse | RayKind::Random => vec![single],
            _ => vec![single, packets],
        };
        let few: Vec<Way> = few.into_iter().filter(|way| wanted.contains(way)).collect();
        let main = form == DEFAULT || form.starts_with(BASELINE);
        if main || few.is_empty() {
            return wanted.clone();
        }
        few
    }

    /// Compares with the default surface's own hits.
    fn misses(&self, scene: &Scene) -> Misses {
        let mut misses = Misses::default();
        for (rays, distances) in self.rays.iter().zip(&self.distances) {
            if distances.is_empty() {
                continue;
            }
            let tolerance = |t: f32| 1e-4 * t.min(f32::MAX);
            for (&other, &default) in rays.distances(scene).iter().zip(distances) {
                misses.rays += 1;
                misses.lost += u64::from(other > default + tolerance(default));
                misses.gained += u64::from(default > other + tolerance(other));
            }
        }
        misses
    }
}

/// Whether a form is the default surface with other roots.
fn is_other_solver(form: &TracedForm) -> bool {
    let plain = CurvedOptions::default();
    match form {
        TracedForm::Curved { options, .. } => {
            options.solver != plain.solver
                && *options
                    == CurvedOptions {
                        solver: options.solver,
                        ..plain
                    }
        }
        _ => false,
    }
}

fn curved_scene(curved: &Arc<CurvedMesh>) -> Result<Scene, BenchError> {
    let device = curvetri::linked::device()?;
    let mut builder = SceneBuilder::new(&device)?;
    builder.attach(&Geometry::user(&device, curved.clone())?.commit()?);
    Ok(builder.commit()?)
}

/// The middle value, 0 of none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n => 0.5 * (values[(n - 1) / 2] + values[n / 2]),
    }
}

#[cfg(test)]
mod tests;
