//! The figures of a comparison: what `--json` prints, and what the table and the report say.

use std::collections::BTreeMap;

use curvetri::compare::{Difference, darkened};
use curvetri::render::Times;
use serde::Serialize;

use super::args::CompareArgs;
use super::findings::{self, Finding};
use super::measure::Measured;
use super::pictures::Pictures;
use super::{Measurements, names};

/// All figures. Times are in seconds, memory in bytes, lengths in pixels, angles in degrees.
#[derive(Serialize)]
pub struct Figures {
    pub meshes: Vec<String>,
    pub reference: Vec<String>,
    pub picture: PictureFigures,
    pub embree: EmbreeFigures,
    /// The form whose shadows are taken for the true ones.
    pub shadows_against: &'static str,
    /// The form that the others are set against.
    pub errors_against: &'static str,
    /// Flat first, then curved; the reference last.
    pub forms: Vec<FormFigures>,
    /// What they say, in words: first in one sentence, then one by one.
    pub summary: String,
    pub findings: Vec<Finding>,
}

#[derive(Serialize)]
pub struct PictureFigures {
    pub width: usize,
    pub height: usize,
    pub samples: u32,
    pub runs: u32,
}

#[derive(Serialize)]
pub struct EmbreeFigures {
    pub version: String,
    pub isa: String,
}

/// The figures of one form.
#[derive(Serialize)]
pub struct FormFigures {
    pub name: String,
    pub title: String,
    /// By kind, and their total.
    pub triangles: BTreeMap<&'static str, usize>,
    pub vertices: usize,
    pub seconds: TimeFigures,
    pub bytes: MemoryFigures,
    pub rays: u64,
    pub mray_per_second: f64,
    pub calls_per_ray: f64,
    pub evaluations_per_call: f64,
    /// What it costs for each one of flat triangles.
    pub over_flat: OverFlat,
    /// How far it is from the reference or, without one, from flat triangles.
    #[serde(rename = "apart")]
    pub difference: Option<Difference>,
    /// Lit pixels that it darkens.
    pub darkened: DarkenedFigures,
}

#[derive(Clone, Copy, Serialize)]
pub struct DarkenedFigures {
    pub lit: usize,
    pub darkened: usize,
    /// 0 to 1.
    pub share: f64,
}

/// Medians over the runs.
#[derive(Serialize)]
pub struct TimeFigures {
    pub load: f64,
    pub curve: f64,
    pub build: f64,
    pub render: f64,
    pub render_least: f64,
    pub render_most: f64,
}

#[derive(Serialize)]
pub struct MemoryFigures {
    pub mesh: u64,
    pub records: u64,
    pub embree: u64,
    pub total: u64,
}

/// Ratios to flat triangles: medians over the runs, and the least and the greatest.
#[derive(Serialize)]
pub struct OverFlat {
    /// To curve and to build.
    pub build: f64,
    pub render: f64,
    pub render_least: f64,
    pub render_most: f64,
    pub bytes: f64,
}

impl Figures {
    pub fn of(
        args: &CompareArgs,
        all: &Measurements,
        pictures: &Pictures,
        [version, isa]: &[String; 2],
    ) -> Self {
        let forms = all.all().zip(&pictures.difference);
        let against = |there: bool| if there { "reference" } else { "" };
        let [shadows_against, errors_against] = match all.reference {
            Some(_) => [against(true); 2],
            None => ["curved", "flat"],
        };
        let mut figures = Self {
            meshes: names(&args.meshes),
            reference: names(&args.reference),
            picture: PictureFigures {
                width: args.size[0],
                height: args.size[1],
                samples: args.samples,
                runs: args.repeat,
            },
            embree: EmbreeFigures {
                version: version.clone(),
                isa: isa.clone(),
            },
            shadows_against,
            errors_against,
            forms: forms
                .map(|(form, difference)| FormFigures::of(form, all, difference.clone()))
                .collect(),
            summary: String::new(),
            findings: Vec::new(),
        };
        figures.summary = findings::summary(&figures);
        figures.findings = findings::of(&figures);
        figures
    }

    pub fn flat(&self) -> &FormFigures {
        &self.forms[0]
    }

    pub fn curved(&self) -> &FormFigures {
        &self.forms[1]
    }

    pub fn reference(&self) -> Option<&FormFigures> {
        self.forms.last().filter(|_| !self.reference.is_empty())
    }
}

impl FormFigures {
    fn of(form: &Measured, all: &Measurements, difference: Option<Difference>) -> Self {
        let stats = &form.stats;
        let triangles = stats.triangles.named().into_iter();
        let triangles = triangles.chain([("total", stats.triangles.total())]);
        Self {
            name: form.contestant.name.clone(),
            title: form.contestant.title.clone(),
            triangles: triangles.collect(),
            vertices: form.vertices,
            seconds: TimeFigures::of(form),
            bytes: MemoryFigures::of(form),
            rays: stats.rays.total(),
            mray_per_second: stats.mray_per_second(),
            calls_per_ray: stats.calls_per_ray(),
            evaluations_per_call: stats.evaluations_per_call(),
            over_flat: OverFlat::of(form, all.flat()),
            difference,
            darkened: DarkenedFigures::of(form, all.truth()),
        }
    }

    /// Triangles of this kind.
    pub fn count(&self, kind: &str) -> usize {
        self.triangles.get(kind).copied().unwrap_or_default()
    }
}

impl DarkenedFigures {
    fn of(form: &Measured, truth: &Measured) -> Self {
        let count = darkened(&form.view.probe, &truth.view.probe);
        Self {
            lit: count.lit,
            darkened: count.darkened,
            share: count.share(),
        }
    }
}

impl TimeFigures {
    fn of(form: &Measured) -> Self {
        let times = form.stats.times;
        let [render_least, _, render_most] = spread(form.times.iter().map(render));
        Self {
            load: times.load.as_secs_f64(),
            curve: times.curve.as_secs_f64(),
            build: times.build.as_secs_f64(),
            render: times.render.as_secs_f64(),
            render_least,
            render_most,
        }
    }
}

impl MemoryFigures {
    fn of(form: &Measured) -> Self {
        let memory = form.stats.memory;
        Self {
            mesh: memory.mesh,
            records: memory.records,
            embree: memory.embree,
            total: memory.mesh + memory.records + memory.embree,
        }
    }
}

impl OverFlat {
    fn of(form: &Measured, flat: &Measured) -> Self {
        let ratios = |part: fn(&Times) -> f64| {
            let pairs = form.times.iter().zip(&flat.times);
            spread(pairs.map(move |(form, flat)| part(form) / part(flat)))
        };
        let [_, build, _] = ratios(|times| (times.curve + times.build).as_secs_f64());
        let [render_least, render, render_most] = ratios(render);
        let total = |form: &Measured| MemoryFigures::of(form).total as f64;
        Self {
            build,
            render,
            render_least,
            render_most,
            bytes: total(form) / total(flat),
        }
    }
}

fn render(times: &Times) -> f64 {
    times.render.as_secs_f64()
}

/// The least, the median and the greatest.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    let n = values.len();
    [
        values[0],
        0.5 * (values[(n - 1) / 2] + values[n / 2]),
        values[n - 1],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_of_an_even_number_is_between_the_middle_two() {
        assert_eq!(spread([4.0, 1.0, 2.0, 9.0].into_iter()), [1.0, 3.0, 9.0]);
        assert_eq!(spread([5.0].into_iter()), [5.0; 3]);
    }
}
