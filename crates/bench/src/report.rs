//! What was measured.

use super::forms::{BuildTimes, Built, Bytes};
use super::measure::Way;
use super::rays::RayKind;
use super::{SurfaceErrors, median};
use curvetri::curved::{Counters, Kinds};

/// What was measured of a mesh.
#[derive(Clone, Debug)]
pub struct MeshReport {
    /// Its name.
    pub name: String,
    /// Its triangles.
    pub triangles: usize,
    /// What the default surface made of them.
    pub kinds: Kinds,
    /// How far they are off the true surface, where that is known.
    pub errors: Option<SurfaceErrors>,
    /// The forms, the baseline first.
    pub forms: Vec<FormReport>,
}

impl MeshReport {
    /// A form that was measured.
    #[must_use]
    pub fn form(&self, name: &str) -> Option<&FormReport> {
        let found = self.forms.iter().find(|form| form.name == name);
        found.filter(|form| matches!(form.outcome, Outcome::Measured))
    }
}

/// Whether a form was measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It was.
    Measured,
    /// It was not, for this reason.
    Skipped(String),
}

/// What was measured of a form.
#[derive(Clone, Debug)]
pub struct FormReport {
    /// Its name.
    pub name: String,
    /// Whether it was measured; if not the rest is empty.
    pub outcome: Outcome,
    /// Into how many parts each edge was cut; 1 for what is not cut.
    pub parts: u32,
    /// Primitives of Embree's: triangles, grids, faces.
    pub primitives: u64,
    /// Flat triangles that they stand for, where the form is cut.
    pub pieces: u64,
    /// Memory.
    pub bytes: Bytes,
    /// Time to make it.
    pub times: BuildTimes,
    /// Its rays.
    pub rows: Vec<RayRow>,
    /// How its hits differ from the default surface's, where only the root finder is another.
    pub misses: Option<Misses>,
}

/// Rays whose hits differ from the default surface's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Misses {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit later or not at all.
    pub lost: u64,
    /// Rays that hit sooner: the default missed there.
    pub gained: u64,
}

/// How fast rays of a kind are in one form when traced in one way.
#[derive(Clone, Debug)]
pub struct RayRow {
    /// The kind.
    pub kind: RayKind,
    /// The way.
    pub way: Way,
    /// Threads.
    pub threads: usize,
    /// Millions of rays a second, all threads together.
    pub mray_per_second: MedianRange,
    /// Speed over the baseline's at its best of widths and flags.
    pub ratio: MedianRange,
    /// Rays.
    pub rays: u64,
    /// Rays that hit.
    pub hits: u64,
    /// What the curved kernel did, all zero for other forms.
    pub kernel: Counters,
}

impl RayRow {
    /// Embree's calls a ray.
    #[must_use]
    pub fn callbacks_per_ray(&self) -> f64 {
        share(self.kernel.callbacks, self.rays)
    }

    /// Ray-triangle tests of the curved kernel a ray.
    #[must_use]
    pub fn calls_per_ray(&self) -> f64 {
        share(self.kernel.calls, self.rays)
    }

    /// Evaluations of the surface a ray.
    #[must_use]
    pub fn evaluations_per_ray(&self) -> f64 {
        share(self.kernel.evaluations, self.rays)
    }

    /// Lanes that a test of a triangle has to work on, over the packet's width.
    #[must_use]
    pub fn lanes_used(&self) -> f64 {
        share(self.kernel.calls, self.kernel.tests) / self.way.width as f64
    }

    /// Share of the rays that hit.
    #[must_use]
    pub fn hit_share(&self) -> f64 {
        share(self.hits, self.rays)
    }
}

fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// A figure that was taken several times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MedianRange {
    /// The middle value.
    pub median: f64,
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

impl MedianRange {
    pub(super) fn of(values: Vec<f64>) -> Self {
        Self {
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            greatest: values.iter().copied().fold(0.0, f64::max),
            median: median(values.into_iter()),
        }
    }

    /// From the least to the greatest, over the median.
    #[must_use]
    pub fn width(&self) -> f64 {
        (self.greatest - self.least) / self.median
    }
}

impl FormReport {
    pub(super) fn new(name: &str, built: &Built) -> Self {
        Self {
            name: name.to_owned(),
            outcome: Outcome::Measured,
            parts: 1,
            primitives: built.primitives,
            pieces: built.pieces,
            bytes: built.bytes,
            times: built.times,
            rows: Vec::new(),
            misses: None,
        }
    }

    pub(super) fn skipped(name: &str, reason: String) -> Self {
        Self {
            name: name.to_owned(),
            outcome: Outcome::Skipped(reason),
            parts: 0,
            primitives: 0,
            pieces: 0,
            bytes: Bytes::default(),
            times: BuildTimes::default(),
            rows: Vec::new(),
            misses: None,
        }
    }

    /// The fastest way for rays of a kind on so many threads.
    #[must_use]
    pub fn best(&self, kind: RayKind, threads: usize) -> Option<&RayRow> {
        let rows = self.rows.iter();
        rows.filter(|row| row.kind == kind && row.threads == threads)
            .max_by(|a, b| a.ratio.median.total_cmp(&b.ratio.median))
    }

    /// The most threads it was traced on.
    #[must_use]
    pub fn most_threads(&self) -> usize {
        self.rows.iter().map(|row| row.threads).max().unwrap_or(0)
    }

    /// Evaluations of the surface a ray-triangle test, over all packets of sixteen.
    #[must_use]
    pub fn evaluations_per_call(&self) -> f64 {
        let packets = self.rows.iter().filter(|row| row.way.width == 16);
        let sums = packets.fold([0, 0], |[evaluations, calls], row| {
            [
                evaluations + row.kernel.evaluations,
                calls + row.kernel.calls,
            ]
        });
        share(sums[0], sums[1])
    }
}
