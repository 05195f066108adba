//! `curvetri accuracy`: the paper's Table 1 again.

use std::fmt::Write;

use anyhow::{Context, Result};
use clap::Args;
use curvetri::accuracy::{self, Model, Options, Row};
use curvetri::embree::Device;
use serde_json::{Value, json};

use super::console::{self, Console};
use super::{device, on_threads, values};

/// Measure the surfaces on bodies whose true surface is known
///
/// The paper's Table 1 again: the greatest and the mean distance along the guide from the surface to
/// the true one, over the body's largest diameter; the mean angle of the geometric normal to the true
/// one; and its mean jump across sides. All triangles are curved, also those that are too coarse for
/// other commands to curve; the table counts them.
#[derive(Args)]
pub struct AccuracyArgs {
    /// Print JSON
    #[arg(long)]
    json: bool,

    /// Measure by rays through Embree, in single precision, instead of by the formulas in double
    /// precision
    #[arg(long)]
    traced: bool,

    /// Points a body; each triangle gets 8 at the least
    #[arg(long, value_name = "N", default_value_t = Options::default().samples,
          value_parser = values::samples)]
    samples: usize,

    /// Where the points lie
    #[arg(long, value_name = "N", default_value_t = Options::default().seed)]
    seed: u64,

    /// Threads to use [default: all]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<usize>,
}

/// Runs the command.
pub fn run(args: &AccuracyArgs, console: &Console) -> Result<()> {
    let options = Options {
        samples: args.samples,
        seed: args.seed,
    };
    let device = args.traced.then(|| device(args.threads)).transpose()?;
    let rows = on_threads(args.threads, || rows(&options, device.as_ref(), console))?;
    console::print(&if args.json { json(&rows) } else { text(&rows) })
}

fn rows(options: &Options, device: Option<&Device>, console: &Console) -> Result<Vec<Row>> {
    let bodies = accuracy::bodies();
    let bar = console.progress("measuring", (bodies.len() * Model::OURS.len()) as u64);
    let mut rows = Vec::new();
    for body in &bodies {
        for model in Model::OURS {
            rows.push(match device {
                None => accuracy::measure(body, model, options),
                Some(device) => accuracy::measure_traced(device, body, model, options)
                    .with_context(|| format!("cannot trace the {}", body.name()))?,
            });
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(rows)
}

fn json(rows: &[Row]) -> String {
    let rows: Vec<Value> = rows.iter().map(row_json).collect();
    format!("{:#}\n", json!({ "rows": rows }))
}

fn row_json(row: &Row) -> Value {
    json!({
        "body": row.body,
        "triangles": row.triangles,
        "surface": row.model.name(),
        "max": row.max,
        "mean": row.mean,
        "normal_deg": row.normal_deg,
        "jump_deg": row.jump_deg,
        "flat_by_default": row.flat_by_default,
        "points": row.points,
        "missed": row.missed,
    })
}

fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "{:18} {:>9}  {:8} {:>8} {:>8} {:>8} {:>8}\n",
        "body", "triangles", "surface", "max", "mean", "normal", "jump"
    );
    for (n, row) in rows.iter().enumerate() {
        let first = n == 0 || rows[n - 1].body != row.body;
        let (body, triangles) = if first {
            (row.body.as_str(), row.triangles.to_string())
        } else {
            ("", String::new())
        };
        let jump = row
            .jump_deg
            .map_or_else(|| "-".to_owned(), |jump| format!("{jump:.2e}"));
        let _ = writeln!(
            text,
            "{body:18} {triangles:>9}  {:8} {:8.2e} {:8.2e} {:8.2e} {jump:>8}{}",
            row.model.name(),
            row.max,
            row.mean,
            row.normal_deg,
            remarks(row)
        );
    }
    text + "\nmax, mean: distance to the true surface over the body's diameter\n\
            normal, jump: degrees, mean\n"
}

/// What has to be known to read a row right.
fn remarks(row: &Row) -> String {
    let mut remarks = String::new();
    if row.flat_by_default > 0 {
        let _ = write!(remarks, "  {} flat by default", row.flat_by_default);
    }
    if row.missed > 0 {
        let points = row.points + row.missed;
        let _ = write!(remarks, "  {} of {points} points missed", row.missed);
    }
    remarks
}
