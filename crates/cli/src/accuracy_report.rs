//! What `curvetri accuracy` prints, for people and for programs.

use std::fmt::Write;

use curvetri_accuracy::{BodyRow, Needed};
use serde_json::{Value, json};

use super::accuracy::{AccuracyReport, Convergence, Orders};

/// One JSON object.
pub fn json(report: &AccuracyReport) -> String {
    let rows: Vec<Value> = report.rows.iter().map(row_json).collect();
    let mut value = json!({ "rows": rows });
    if let Some(peers) = &report.peers {
        value["convergence"] = peers.orders.iter().map(orders_json).collect();
        value["needed"] = peers.needed.iter().map(needed_json).collect();
    }
    format!("{value:#}\n")
}

fn row_json(row: &BodyRow) -> Value {
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

fn orders_json(orders: &Orders) -> Value {
    json!({
        "surface": orders.model.name(),
        "from": orders.from,
        "to": orders.to,
        "max": orders.max,
        "mean": orders.mean,
        "normal_deg": orders.normal,
    })
}

fn needed_json(needed: &Needed) -> Value {
    json!({
        "surface": needed.model.name(),
        "measure": needed.measure.name(),
        "error": needed.error,
        "triangles": needed.triangles(),
        "pieces": needed.pieces,
    })
}

/// Tables.
pub fn text(report: &AccuracyReport) -> String {
    let mut text = rows_text(&report.rows);
    if let Some(peers) = &report.peers {
        text += &orders_text(peers);
        text += &needed_text(&peers.needed);
    }
    text
}

fn rows_text(rows: &[BodyRow]) -> String {
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
        let _ = writeln!(
            text,
            "{body:18} {triangles:>9}  {:8} {:8.1e} {:8.1e} {:>8} {:>8}{}",
            row.model.name(),
            row.max,
            row.mean,
            degrees(row.normal_deg),
            row.jump_deg.map_or_else(|| "-".into(), degrees),
            remarks(row)
        );
    }
    text + "\nmax, mean      distance to the true surface over the body's largest diameter\n\
            normal, jump   mean angle to the true normal, mean jump across edges, degrees\n\
            paper          the angular surface as the paper's own algorithm finds it\n"
}

/// Two digits at the least, without an exponent where that is readable.
fn degrees(degrees: f64) -> String {
    match degrees {
        1.0.. => format!("{degrees:.1}"),
        0.01.. => format!("{degrees:.3}"),
        _ => format!("{degrees:.1e}"),
    }
}

/// What has to be known to read a row right.
fn remarks(row: &BodyRow) -> String {
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

fn orders_text(peers: &Convergence) -> String {
    let mut text = format!(
        "\nObserved order of convergence\n{:8} {:12} {:12} {:>6} {:>6} {:>6}\n",
        "surface", "from", "to", "max", "mean", "normal"
    );
    let mut orders: Vec<&Orders> = peers.orders.iter().collect();
    // By surface; within one the tori stay in their order.
    orders.sort_by_key(|orders| {
        let first = peers.orders.iter().position(|o| o.model == orders.model);
        first.expect("it is one of them")
    });
    for (n, row) in orders.iter().enumerate() {
        let first = n == 0 || orders[n - 1].model != row.model;
        let name = if first { row.model.name() } else { "" };
        let _ = writeln!(
            text,
            "{name:8} {:12} {:12} {:6.2} {:6.2} {:6.2}",
            row.from, row.to, row.max, row.mean, row.normal
        );
    }
    text
}

fn needed_text(needed: &[Needed]) -> String {
    let mut text = String::from("\nTriangles needed on the torus, cut into 3k by 4k pieces\n");
    let Some(model) = needed.first().map(|needed| needed.model) else {
        return text;
    };
    let _ = write!(text, "{:8}", "surface");
    for goal in needed.iter().filter(|goal| goal.model == model) {
        let _ = write!(
            text,
            " {:>11}",
            format!("{} {:.0e}", goal.measure.name(), goal.error)
        );
    }
    for row in needed.chunk_by(|a, b| a.model == b.model) {
        let _ = write!(text, "\n{:8}", row[0].model.name());
        for goal in row {
            let count = goal
                .triangles()
                .map_or_else(|| "-".into(), |n| n.to_string());
            let _ = write!(text, " {count:>11}");
        }
    }
    text + "\n"
}
