//! The project's goals for speed and memory, and what was reached of them.

use super::forms::{BASELINE, DEFAULT};
use super::rays::RayKind;
use super::report::{FormReport, MeshReport};
use super::{TorusBytes, median};

/// A goal and what was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// What it is about.
    pub what: String,
    /// What has to be reached.
    pub least: f64,
    /// What is hoped for.
    pub aim: f64,
    /// Whether less is better.
    pub less_is_better: bool,
    /// The figure of each mesh it could be taken of.
    pub by_mesh: Vec<(String, f64)>,
    /// Their median; `None` if it was not measured.
    pub reached: Option<f64>,
}

impl Goal {
    /// Whether what has to be reached is reached.
    #[must_use]
    pub fn is_met(&self) -> Option<bool> {
        let met = |reached| {
            if self.less_is_better {
                reached <= self.least
            } else {
                reached >= self.least
            }
        };
        self.reached.map(met)
    }

    fn new(what: &str, [least, aim]: [f64; 2], by_mesh: Vec<(String, f64)>) -> Self {
        let reached = median(by_mesh.iter().map(|(_, figure)| *figure));
        Self {
            what: what.to_owned(),
            least,
            aim,
            less_is_better: aim < least,
            reached: (!by_mesh.is_empty()).then_some(reached),
            by_mesh,
        }
    }
}

/// A figure of one mesh; `None` where it was not measured.
type Figure<'a> = dyn Fn(&MeshReport) -> Option<f64> + 'a;

/// All goals, as far as they were measured.
#[must_use]
pub fn goals(reports: &[MeshReport], torus: Option<&TorusBytes>) -> Vec<Goal> {
    let goal = |what: &str, limits: [f64; 2], figure: &Figure<'_>| {
        let figures = reports.iter();
        let figures = figures.filter_map(|mesh| Some((mesh.name.clone(), figure(mesh)?)));
        Goal::new(what, limits, figures.collect())
    };
    let over = |other: &'static str, kind: RayKind| {
        move |mesh: &MeshReport| Some(speed(mesh, DEFAULT, kind)? / speed(mesh, other, kind)?)
    };
    let speeds = [
        (RayKind::Primary, BASELINE, [0.35, 0.6]),
        (RayKind::Primary, "tessellated-x16", [0.8, 1.5]),
        (RayKind::Bounce, BASELINE, [0.3, 0.7]),
        (RayKind::Diffuse, BASELINE, [0.25, 0.7]),
        (RayKind::Diffuse, "tessellated-x64", [0.4, 1.0]),
        (RayKind::Shadow, BASELINE, [0.3, 0.6]),
        (RayKind::AmbientOcclusion, BASELINE, [0.3, 0.6]),
        (RayKind::Primary, "subdivision-4", [1.0, 1.6]),
        (RayKind::Diffuse, "subdivision-4", [0.7, 1.7]),
    ];
    let mut goals: Vec<Goal> = speeds
        .into_iter()
        .map(|(kind, other, limits)| {
            let what = format!("{} rays: {DEFAULT} over {other}", kind.name());
            goal(&what, limits, &over(other, kind))
        })
        .collect();
    goals.extend([
        goal("all rays: default over paper", [3.0, 6.0], &gain_over_paper),
        goal(
            "bytes a triangle, leaves of 4: smooth over flat",
            [1.0, 0.8],
            &|mesh| bytes_over_flat(mesh, "smooth-leaf4"),
        ),
        goal(
            "bytes a triangle, any device: smooth over flat",
            [1.6, 1.2],
            &|mesh| bytes_over_flat(mesh, DEFAULT),
        ),
    ]);
    let at_torus = |bytes: fn(&TorusBytes) -> u64| {
        let figure = |t: &TorusBytes| bytes(t) as f64 / t.curved as f64;
        let name = "torus-48x64".to_owned();
        torus.map(|t| (name, figure(t))).into_iter().collect()
    };
    goals.extend([
        Goal::new(
            "bytes at equal error: tessellated over smooth",
            [16.0, 40.0],
            at_torus(|t| t.tessellated),
        ),
        Goal::new(
            "bytes at equal error: grids over smooth",
            [4.0, 10.0],
            at_torus(|t| t.grids),
        ),
        goal("build time: smooth over flat", [2.0, 1.3], &|mesh| {
            Some(mesh.form(DEFAULT)?.times.over_flat)
        }),
        goal(
            "evaluations a call: finish over the best ITA at equal misses",
            [0.5, 0.25],
            &evaluations_over_ita,
        ),
    ]);
    for kind in [RayKind::Primary, RayKind::Diffuse] {
        let what = format!(
            "{} rays, 10 million triangles against 100 thousand: growth of cost over flat's",
            kind.name()
        );
        goals.push(Goal::new(&what, [1.3, 1.0], growth(reports, kind)));
    }
    goals
}

/// A form's speed over the baseline's for rays of a kind, at its best way on all threads.
fn speed(mesh: &MeshReport, form: &str, kind: RayKind) -> Option<f64> {
    if form == BASELINE {
        return Some(1.0);
    }
    let form = mesh.form(form)?;
    Some(form.best(kind, form.most_threads())?.ratio.median)
}

/// Time for as many rays of each kind by the paper's method over that by the default.
fn gain_over_paper(mesh: &MeshReport) -> Option<f64> {
    let time = |form: &FormReport| {
        let kinds = RayKind::ALL.iter();
        let best = kinds.filter_map(|kind| form.best(*kind, form.most_threads()));
        best.map(|row| 1.0 / row.mray_per_second.median)
            .sum::<f64>()
    };
    Some(time(mesh.form("paper")?) / time(mesh.form(DEFAULT)?))
}

fn bytes_over_flat(mesh: &MeshReport, form: &str) -> Option<f64> {
    let bytes = |form| Some(mesh.form(form)?.bytes.total() as f64);
    Some(bytes(form)? / bytes(BASELINE)?)
}

/// Share of rays by which an ITA may lose more than it gains, and still misses no more.
const EQUAL_MISSES: f64 = 1e-5;

fn evaluations_over_ita(mesh: &MeshReport) -> Option<f64> {
    let itas = (1..=4).filter_map(|step| mesh.form(&format!("smooth-ita{step}")));
    let with_misses = itas.filter_map(|form| Some((form, form.misses?)));
    let worse = |misses: &super::Misses| {
        (misses.lost as f64 - misses.gained as f64) / misses.rays.max(1) as f64
    };
    let good = with_misses.filter(|(_, misses)| worse(misses) <= EQUAL_MISSES);
    let best = good.map(|(form, _)| form.evaluations_per_call());
    let best = best.min_by(f64::total_cmp)?;
    Some(mesh.form(DEFAULT)?.evaluations_per_call() / best)
}

/// How much more a ray costs on a mesh of ten million triangles than on one of a hundred thousand, over
/// the baseline's own growth.
fn growth(reports: &[MeshReport], kind: RayKind) -> Vec<(String, f64)> {
    let of_size = |size: usize| {
        let near = size - size / 10..size + size / 10;
        let found = reports.iter().find(|mesh| near.contains(&mesh.triangles));
        found.and_then(|mesh| Some((mesh, speed(mesh, DEFAULT, kind)?)))
    };
    match (of_size(100_000), of_size(10_000_000)) {
        (Some((_, small)), Some((mesh, large))) => vec![(mesh.name.clone(), small / large)],
        _ => Vec::new(),
    }
}
