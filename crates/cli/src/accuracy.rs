//! `curvetri accuracy`: the paper's Table 1 again.

use anyhow::{Context, Result};
use clap::Args;
use curvetri::embree::Device;
use curvetri_accuracy::{AccuracyOptions, BodyRow, Needed, SurfaceModel};
use curvetri_bodies::Body;

use super::accuracy_report::{json, text};
use super::console::{self, Console};
use super::{device, on_threads, values};

/// The errors for which --peers counts triangles.
const GOALS: [f64; 2] = [1e-3, 1e-4];

/// Measure the surfaces on bodies whose true surface is known
///
/// Repeats the paper's Table 1. For each body it gives the greatest and the mean distance from the
/// surface to the true one, along the guide, as a share of the body's largest diameter; the mean angle
/// between the geometric normal and the true one; and the mean jump of the normal across edges. All
/// triangles are curved, also those that are too coarse for other commands to curve. The table counts
/// these.
#[derive(Args)]
pub struct AccuracyArgs {
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,

    /// Measure with rays through Embree, in single precision, instead of with the formulas in double
    /// precision
    #[arg(long, conflicts_with = "peers")]
    traced: bool,

    /// Measure PN triangles, Phong tessellation and Nagata patches as well. Show how fast each gets
    /// better on finer tori, and how many triangles it needs for an error of 1e-3 and of 1e-4
    #[arg(long)]
    peers: bool,

    /// Points on each body; each triangle gets at least 8
    #[arg(long, value_name = "N", default_value_t = AccuracyOptions::default().samples,
          value_parser = values::samples)]
    samples: usize,

    /// Seed of the positions of the points
    #[arg(long, value_name = "N", default_value_t = AccuracyOptions::default().seed)]
    seed: u64,

    /// Threads to use [default: all]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<usize>,
}

/// What was measured.
pub struct AccuracyReport {
    pub rows: Vec<BodyRow>,
    /// Only with --peers.
    pub peers: Option<Convergence>,
}

/// How the models get better on finer tori.
pub struct Convergence {
    pub orders: Vec<Orders>,
    pub needed: Vec<Needed>,
}

/// A model's observed orders of convergence from one torus to the next finer one.
pub struct Orders {
    pub model: SurfaceModel,
    pub from: String,
    pub to: String,
    pub max: f64,
    pub mean: f64,
    pub normal: f64,
}

/// Runs the command.
pub fn run(args: &AccuracyArgs, console: &Console) -> Result<()> {
    let device = args.traced.then(|| device(args.threads)).transpose()?;
    let report = on_threads(args.threads, || measure(args, device.as_ref(), console))?;
    let printed = if args.json {
        json(&report)
    } else {
        text(&report)
    };
    console::print(&printed)
}

fn measure(
    args: &AccuracyArgs,
    device: Option<&Device>,
    console: &Console,
) -> Result<AccuracyReport> {
    let options = AccuracyOptions {
        samples: args.samples,
        seed: args.seed,
    };
    let mut models = SurfaceModel::OURS.to_vec();
    if args.peers {
        models.extend(SurfaceModel::PEERS);
    }
    let bodies = curvetri_accuracy::bodies();
    let bar = console.progress("measuring", ((bodies.len() + 1) * models.len()) as u64);
    let mut rows = Vec::new();
    for body in &bodies {
        for &model in &models {
            rows.push(row(body, model, &options, device)?);
            bar.inc(1);
        }
    }
    let peers = args.peers.then(|| Convergence {
        orders: orders(&rows),
        needed: (models.iter())
            .inspect(|_| bar.inc(1))
            .flat_map(|&model| curvetri_accuracy::triangles_needed(model, &GOALS, args.seed))
            .collect(),
    });
    bar.finish_and_clear();
    Ok(AccuracyReport { rows, peers })
}

fn row(
    body: &Body,
    model: SurfaceModel,
    options: &AccuracyOptions,
    device: Option<&Device>,
) -> Result<BodyRow> {
    match device {
        None => Ok(curvetri_accuracy::measure(body, model, options)),
        Some(device) => curvetri_accuracy::measure_traced(device, body, model, options)
            .with_context(|| format!("cannot trace the {}", body.name())),
    }
}

/// Compares each torus with the one before it, by model.
fn orders(rows: &[BodyRow]) -> Vec<Orders> {
    let mut orders = Vec::new();
    for (n, coarse) in rows.iter().enumerate() {
        // The next row of the model, and a torus of four times the triangles.
        let finer = rows[n + 1..].iter().find(|row| row.model == coarse.model);
        let Some(fine) = finer.filter(|row| is_torus(coarse) && is_torus(row)) else {
            continue;
        };
        orders.push(Orders {
            model: coarse.model,
            from: coarse.body.clone(),
            to: fine.body.clone(),
            max: curvetri_accuracy::order(coarse.max, fine.max),
            mean: curvetri_accuracy::order(coarse.mean, fine.mean),
            normal: curvetri_accuracy::order(coarse.normal_deg, fine.normal_deg),
        });
    }
    orders
}

fn is_torus(row: &BodyRow) -> bool {
    row.body.starts_with("torus")
}
