//! What `curvetri bench` prints, for people and for programs.

use std::fmt::Write;

use curvetri_bench::{
    BASELINE, Clock, FormReport, Goal, MedianRange, MeshReport, Outcome, RayKind, RayRow,
};
use serde_json::{Value, json};

use super::bench::BenchReport;

/// One JSON object. Times are in seconds, memory in bytes.
pub fn json(report: &BenchReport) -> String {
    let machine = &report.machine;
    let meshes: Vec<Value> = report.meshes.iter().map(mesh_json).collect();
    let goals: Vec<Value> = report.goals.iter().map(goal_json).collect();
    let torus = &report.torus;
    let value = json!({
        "machine": {
            "processor": machine.processor,
            "threads": machine.threads,
            "memory": machine.memory,
            "system": machine.system,
            "embree": machine.embree,
            "isa": machine.isa,
            "curvetri": machine.version,
        },
        "rays": report.options.rays,
        "rounds": report.options.rounds,
        "clock": clock(report),
        "meshes": meshes,
        "torus": {
            "parts": torus.parts,
            "greatest_error": { "flat": torus.errors.greatest[0], "curved": torus.errors.greatest[1] },
            "mean_error": { "flat": torus.errors.mean[0], "curved": torus.errors.mean[1] },
            "bytes": {
                "curved": torus.curved,
                "tessellated": torus.tessellated,
                "grids": torus.grids,
            },
        },
        "goals": goals,
    });
    format!("{value:#}\n")
}

fn mesh_json(mesh: &MeshReport) -> Value {
    let mut value = json!({
        "name": mesh.name,
        "triangles": mesh.triangles,
        "flat": mesh.kinds.flat(),
        "forms": mesh.forms.iter().map(form_json).collect::<Vec<_>>(),
    });
    if let Some(errors) = &mesh.errors {
        value["greatest_error"] =
            json!({ "flat": errors.greatest[0], "curved": errors.greatest[1] });
    }
    value
}

fn form_json(form: &FormReport) -> Value {
    if let Outcome::Skipped(reason) = &form.outcome {
        return json!({ "name": form.name, "skipped": reason });
    }
    let (times, bytes) = (form.times, form.bytes);
    let mut value = json!({
        "name": form.name,
        "parts": form.parts,
        "primitives": form.primitives,
        "pieces": form.pieces,
        "seconds": { "prepare": times.prepare, "build": times.build },
        "build_over_flat": times.over_flat,
        "bytes": {
            "mesh": bytes.mesh,
            "records": bytes.records,
            "buffers": bytes.buffers,
            "tree": bytes.tree,
            "total": bytes.total(),
        },
        "rows": form.rows.iter().map(row_json).collect::<Vec<_>>(),
    });
    if let Some(misses) = form.misses {
        value["misses"] = json!({
            "rays": misses.rays,
            "lost": misses.lost,
            "gained": misses.gained,
        });
    }
    value
}

fn row_json(row: &RayRow) -> Value {
    json!({
        "kind": row.kind.name(),
        "width": row.way.width,
        "coherent": row.way.coherent,
        "threads": row.threads,
        "mray_per_second": median_range_json(&row.mray_per_second),
        "ratio_to_flat": median_range_json(&row.ratio),
        "rays": row.rays,
        "hit_share": row.hit_share(),
        "callbacks_per_ray": row.callbacks_per_ray(),
        "calls_per_ray": row.calls_per_ray(),
        "evaluations_per_ray": row.evaluations_per_ray(),
        "lanes_used": row.lanes_used(),
    })
}

fn median_range_json(spread: &MedianRange) -> Value {
    json!({ "median": spread.median, "min": spread.least, "max": spread.greatest })
}

fn goal_json(goal: &Goal) -> Value {
    let by_mesh: Vec<Value> = goal
        .by_mesh
        .iter()
        .map(|(mesh, figure)| json!({ "mesh": mesh, "figure": figure }))
        .collect();
    json!({
        "goal": goal.what,
        "reached": goal.reached,
        "least": goal.least,
        "aim": goal.aim,
        "less_is_better": goal.less_is_better,
        "met": goal.is_met(),
        "by_mesh": by_mesh,
    })
}

/// Tables for people.
pub fn text(report: &BenchReport) -> String {
    tables(report).iter().map(TextTable::text).collect()
}

/// The same as a page of documentation.
pub fn markdown(report: &BenchReport) -> String {
    let intro = "# Measured speed and memory\n\nWritten by `curvetri bench --markdown`. A ratio compares \
                 a form with Embree's flat triangles on the same rays. The two take turns, and the ratio \
                 is the median over the rounds. Flat triangles use the packet width and the flag that are \
                 best for them.\n";
    let tables = tables(report);
    std::iter::once(intro.to_owned())
        .chain(tables.iter().map(TextTable::markdown))
        .collect()
}

/// A heading, a remark and rows, of which the first are the columns' names.
struct TextTable {
    heading: String,
    remark: String,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    fn new(heading: impl Into<String>, columns: &[&str]) -> Self {
        Self {
            heading: heading.into(),
            remark: String::new(),
            rows: vec![columns.iter().map(|&name| name.to_owned()).collect()],
        }
    }

    fn text(&self) -> String {
        let mut widths = vec![0; self.rows[0].len()];
        for row in &self.rows {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = cell.chars().count().max(*width);
            }
        }
        let mut text = format!("{}\n", self.heading);
        if self.rows.len() > 1 {
            for row in &self.rows {
                let mut line = String::new();
                for (n, (cell, width)) in row.iter().zip(&widths).enumerate() {
                    let _ = match n {
                        0 => write!(line, "  {cell:width$}"),
                        _ => write!(line, "  {cell:>width$}"),
                    };
                }
                text += line.trim_end();
                text.push('\n');
            }
        }
        for line in self.remark.lines() {
            let _ = writeln!(text, "  {line}");
        }
        text + "\n"
    }

    fn markdown(&self) -> String {
        let mut text = format!("\n## {}\n\n", self.heading);
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        if self.rows.len() > 1 {
            text += &line(&self.rows[0]);
            let rules: Vec<String> = (0..self.rows[0].len())
                .map(|n| if n == 0 { "---" } else { "---:" }.to_owned())
                .collect();
            text += &line(&rules);
            self.rows[1..].iter().for_each(|row| text += &line(row));
        }
        if !self.remark.is_empty() {
            let _ = write!(text, "\n{}\n", self.remark.trim_end().replace('\n', "  \n"));
        }
        text
    }
}

fn tables(report: &BenchReport) -> Vec<TextTable> {
    let mut tables = vec![machine_table(report)];
    for mesh in &report.meshes {
        tables.push(sizes_table(mesh));
        for threads in thread_counts(mesh) {
            tables.push(speeds_table(mesh, threads));
        }
        tables.push(ways_table(mesh));
        tables.push(kernel_table(mesh));
    }
    tables.push(goals_table(report));
    tables
}

fn machine_table(report: &BenchReport) -> TextTable {
    let machine = &report.machine;
    let mut table = TextTable::new("Machine", &["", ""]);
    table.remark = format!(
        "{}, {} threads, {:.0} GB, {}\nEmbree {} ({}), curvetri {}\nabout {} rays of each kind, {} rounds, {}\n",
        machine.processor,
        machine.threads,
        machine.memory as f64 * 1e-9,
        machine.system,
        machine.embree,
        machine.isa,
        machine.version,
        report.options.rays,
        report.options.rounds,
        clock(report),
    );
    table
}

fn clock(report: &BenchReport) -> &'static str {
    match report.options.clock {
        Clock::Wall => "wall-clock time",
        Clock::Processor => "processor time",
    }
}

fn thread_counts(mesh: &MeshReport) -> Vec<usize> {
    let mut counts: Vec<usize> = mesh.forms[0].rows.iter().map(|row| row.threads).collect();
    counts.sort_unstable();
    counts.dedup();
    counts
}

fn measured(mesh: &MeshReport) -> impl Iterator<Item = &FormReport> {
    mesh.forms
        .iter()
        .filter(|form| form.outcome == Outcome::Measured)
}

fn sizes_table(mesh: &MeshReport) -> TextTable {
    let columns = [
        "form",
        "primitives",
        "mesh",
        "patches",
        "buffers",
        "tree",
        "B/triangle",
        "over flat",
        "prepare s",
        "build s",
        "Mtri/s",
        "over flat",
    ];
    let heading = format!(
        "{}: {} triangles ({} stay flat), bytes for each triangle, and time to build",
        mesh.name,
        mesh.triangles,
        mesh.kinds.flat()
    );
    let mut table = TextTable::new(heading, &columns);
    let flat = &mesh.forms[0];
    for form in measured(mesh) {
        let each = |bytes: u64| format!("{:.1}", bytes as f64 / mesh.triangles as f64);
        let (bytes, times) = (form.bytes, form.times);
        table.rows.push(vec![
            form.name.clone(),
            form.primitives.to_string(),
            each(bytes.mesh),
            each(bytes.records),
            each(bytes.buffers),
            each(bytes.tree),
            each(bytes.total()),
            format!("{:.2}", bytes.total() as f64 / flat.bytes.total() as f64),
            format!("{:.3}", times.prepare),
            format!("{:.3}", times.build),
            format!("{:.2}", mesh.triangles as f64 * 1e-6 / times.total()),
            format!("{:.2}", times.over_flat),
        ]);
    }
    for form in &mesh.forms {
        if let Outcome::Skipped(reason) = &form.outcome {
            let _ = writeln!(table.remark, "{}: left out: {reason}", form.name);
        }
    }
    table
}

/// The kinds of rays that were measured.
fn kinds(mesh: &MeshReport) -> Vec<RayKind> {
    let rows = &mesh.forms[0].rows;
    let kinds = RayKind::ALL.into_iter();
    kinds
        .filter(|kind| rows.iter().any(|row| row.kind == *kind))
        .collect()
}

/// Speeds at the best packet width, with the ratio to the baseline.
fn speeds_table(mesh: &MeshReport, threads: usize) -> TextTable {
    let kinds = kinds(mesh);
    let mut columns = vec!["form"];
    columns.extend(kinds.iter().map(|kind| kind.name()));
    let heading = format!(
        "{}: Mray/s on {threads} thread{}, each at its best packet width (ratio to flat)",
        mesh.name,
        if threads == 1 { "" } else { "s" }
    );
    let mut table = TextTable::new(heading, &columns);
    for form in measured(mesh) {
        let mut cells = vec![form.name.clone()];
        cells.extend(kinds.iter().map(|&kind| {
            form.best(kind, threads).map_or_else(String::new, |row| {
                let (speed, ratio) = (row.mray_per_second.median, row.ratio.median);
                format!("{speed:.2} ({ratio:.2})")
            })
        }));
        table.rows.push(cells);
    }
    let mut shares = vec!["share of hits, flat".to_owned()];
    shares.extend(kinds.iter().map(|&kind| {
        let row = mesh.forms[0].best(kind, threads);
        row.map_or_else(String::new, |row| format!("{:.2}", row.hit_share()))
    }));
    table.rows.push(shares);
    table
}

/// Every packet width that the main forms were traced with.
fn ways_table(mesh: &MeshReport) -> TextTable {
    let columns = [
        "form", "rays", "packet", "threads", "Mray/s", "spread", "ratio", "spread", "hits",
    ];
    let heading = format!(
        "{}: every packet width (c: with the coherent flag)",
        mesh.name
    );
    let mut table = TextTable::new(heading, &columns);
    for form in measured(mesh).filter(|form| [BASELINE, "smooth"].contains(&&*form.name)) {
        for row in &form.rows {
            table.rows.push(vec![
                form.name.clone(),
                row.kind.name().to_owned(),
                row.way.name(),
                row.threads.to_string(),
                format!("{:.2}", row.mray_per_second.median),
                format!("{:.0} %", 100.0 * row.mray_per_second.width()),
                format!("{:.3}", row.ratio.median),
                format!("{:.0} %", 100.0 * row.ratio.width()),
                format!("{:.3}", row.hit_share()),
            ]);
        }
    }
    table
}

/// What the curved kernel did.
fn kernel_table(mesh: &MeshReport) -> TextTable {
    let columns = [
        "form",
        "rays",
        "packet",
        "callbacks/ray",
        "calls/ray",
        "evaluations/ray",
        "evaluations/call",
        "lanes used",
    ];
    let mut table = TextTable::new(format!("{}: the curved kernel", mesh.name), &columns);
    for form in measured(mesh) {
        let most = form.most_threads();
        let curved = form.rows.iter().filter(|row| row.kernel.calls > 0);
        for row in curved.filter(|row| row.threads == most) {
            table.rows.push(vec![
                form.name.clone(),
                row.kind.name().to_owned(),
                row.way.name(),
                format!("{:.2}", row.callbacks_per_ray()),
                format!("{:.2}", row.calls_per_ray()),
                format!("{:.2}", row.evaluations_per_ray()),
                format!("{:.2}", row.evaluations_per_ray() / row.calls_per_ray()),
                format!("{:.2}", row.lanes_used()),
            ]);
        }
        if let Some(misses) = form.misses {
            let _ = writeln!(
                table.remark,
                "{}: of {} rays {} hit later than smooth or not at all, {} sooner",
                form.name, misses.rays, misses.lost, misses.gained
            );
        }
    }
    table
}

fn goals_table(report: &BenchReport) -> TextTable {
    let mut columns = vec!["goal", "least", "aim", "reached", "met"];
    columns.extend(report.meshes.iter().map(|mesh| mesh.name.as_str()));
    let mut table = TextTable::new("Goals (medians over the meshes, all threads)", &columns);
    for goal in &report.goals {
        let figure = |figure: f64| format!("{figure:.2}");
        let met = match goal.is_met() {
            Some(true) => "yes",
            Some(false) => "no",
            None => "",
        };
        let reached = goal
            .reached
            .map_or_else(|| "not measured".to_owned(), figure);
        let mut cells = vec![
            goal.what.clone(),
            goal.least.to_string(),
            goal.aim.to_string(),
            reached,
            met.to_owned(),
        ];
        cells.extend(report.meshes.iter().map(|mesh| {
            let found = goal.by_mesh.iter().find(|(name, _)| *name == mesh.name);
            found.map_or_else(String::new, |(_, value)| figure(*value))
        }));
        table.rows.push(cells);
    }
    let torus = &report.torus;
    let _ = writeln!(
        table.remark,
        "Equal error: on the torus of 48 by 64 pieces the greatest error is {:.1e} curved and {:.1e} flat. \
         With {} parts per edge flat triangles reach the curved error.",
        torus.errors.greatest[1], torus.errors.greatest[0], torus.parts
    );
    table
}
