//! The figures as tables: for a terminal, and for the report.

use std::fmt::Write;

use curvetri::compare::{Difference, Summary};
use serde::Serialize;

use super::figures::{Figures, FormFigures, TimeFigures};

/// Rows under a title, with a column a form.
#[derive(Serialize)]
pub struct ComparisonTable {
    pub title: String,
    /// What its figures mean.
    pub note: String,
    pub rows: Vec<Row>,
}

#[derive(Serialize)]
pub struct Row {
    pub name: &'static str,
    /// What it is measured in; may be empty.
    pub unit: &'static str,
    pub cells: Vec<String>,
}

/// Stands where there is nothing to tell.
const NOTHING: &str = "–";

/// For people at a terminal.
pub fn text(figures: &Figures) -> String {
    let mut text = String::new();
    let name = |row: &Row| match row.unit {
        "" => row.name.to_owned(),
        unit => format!("{}, {unit}", row.name),
    };
    let tables = tables(figures);
    let rows = || tables.iter().flat_map(|table| &table.rows);
    let heads: Vec<&str> = figures
        .forms
        .iter()
        .map(|form| form.name.as_str())
        .collect();
    let width = |text: &str| text.chars().count();
    let first = rows().map(|row| width(&name(row))).max().unwrap_or(0);
    let wide = |column: usize| {
        rows()
            .map(|row| width(&row.cells[column]))
            .max()
            .unwrap_or(0)
    };
    let wide: Vec<usize> = (0..heads.len())
        .map(|n| wide(n).max(width(heads[n])))
        .collect();
    let mut line = |head: &str, cells: &[&str]| {
        let _ = write!(text, "{head:first$}");
        for (cell, wide) in cells.iter().zip(&wide) {
            let _ = write!(text, "  {cell:>wide$}");
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    };
    for table in &tables {
        line(&table.title.to_uppercase(), &heads);
        for row in &table.rows {
            let cells: Vec<&str> = row.cells.iter().map(String::as_str).collect();
            line(&name(row), &cells);
        }
        line("", &[]);
    }
    let _ = writeln!(text, "{}\n", figures.summary);
    for finding in &figures.findings {
        let _ = writeln!(text, "- {}", finding.text);
    }
    text
}

/// All tables.
pub fn tables(figures: &Figures) -> Vec<ComparisonTable> {
    vec![cost(figures), errors(figures), shadows(figures)]
}

fn cost(figures: &Figures) -> ComparisonTable {
    let rows = Rows(figures);
    let mut all = vec![
        rows.row("triangles", "", |form| form.count("total").to_string()),
        rows.row("of them curved", "", |form| {
            (form.count("curved") + form.count("fallback")).to_string()
        }),
        rows.row("load", "s", |form| number(form.seconds.load)),
        rows.row("prepare patches", "s", |form| number(form.seconds.curve)),
        rows.row("build the tree", "s", |form| number(form.seconds.build)),
        rows.row("render", "s", |form| number(form.seconds.render)),
    ];
    if figures.picture.runs > 1 {
        all.push(rows.row("render, least to most", "s", |form| {
            let TimeFigures {
                render_least,
                render_most,
                ..
            } = &form.seconds;
            format!("{} to {}", number(*render_least), number(*render_most))
        }));
    }
    all.extend([
        rows.row("speed", "Mray/s", |form| number(form.mray_per_second)),
        rows.row("memory: mesh", "MB", |form| megabytes(form.bytes.mesh)),
        rows.row("memory: patches", "MB", |form| {
            megabytes(form.bytes.records)
        }),
        rows.row("memory: Embree", "MB", |form| megabytes(form.bytes.embree)),
        rows.row("memory: all", "MB", |form| megabytes(form.bytes.total)),
        rows.row("set-up over flat", "times", |form| {
            number(form.over_flat.build)
        }),
        rows.row("render over flat", "times", |form| {
            number(form.over_flat.render)
        }),
        rows.row("memory over flat", "times", |form| {
            number(form.over_flat.bytes)
        }),
    ]);
    ComparisonTable {
        title: "Cost".into(),
        note: match figures.picture.runs {
            1 => "One run; times vary with what else the machine does (--repeat).".into(),
            runs => format!("Medians of {runs} runs that took turns."),
        },
        rows: all,
    }
}

fn errors(figures: &Figures) -> ComparisonTable {
    let rows = Rows(figures);
    let mean = |spread: Option<Summary>| spread.map(|s| s.mean);
    let p95 = |spread: Option<Summary>| spread.map(|s| s.p95);
    let difference = |name, unit, value: &dyn Fn(&Difference) -> Option<f64>| {
        rows.row(name, unit, |form| {
            let value = form.difference.as_ref().and_then(value);
            value.map_or(NOTHING.to_owned(), number)
        })
    };
    let (title, note) = match figures.reference() {
        Some(_) => (
            "Error",
            "How far each is from the reference. What is smaller than its facets it cannot tell.",
        ),
        None => (
            "Difference",
            "How far each is from flat triangles; which is right, a reference tells.",
        ),
    };
    ComparisonTable {
        title: title.into(),
        note: note.into(),
        rows: vec![
            difference("picture, RMSE", "%", &|a| Some(100.0 * a.rmse)),
            difference("picture, FLIP", "", &|a| Some(a.flip)),
            difference("outline, mean", "px", &|a| mean(a.outline)),
            difference("outline, 95 %", "px", &|a| p95(a.outline)),
            difference("outline, most", "px", &|a| a.outline.map(|s| s.max)),
            difference("shading normal, mean", "deg", &|a| mean(a.shading_normal)),
            difference("shading normal, 95 %", "deg", &|a| p95(a.shading_normal)),
            difference("geometric normal, mean", "deg", &|a| {
                mean(a.geometric_normal)
            }),
            difference(
                "geometric normal, 95 %",
                "deg",
                &|a| p95(a.geometric_normal),
            ),
        ],
    }
}

fn shadows(figures: &Figures) -> ComparisonTable {
    let rows = Rows(figures);
    let truth = figures.shadows_against;
    let cell = |form: &FormFigures, text: String| {
        if form.name == truth {
            NOTHING.to_owned()
        } else {
            text
        }
    };
    ComparisonTable {
        title: "Shadow terminator".into(),
        note: format!("Pixels that are dark although the sun shines there on the {truth} surface."),
        rows: vec![
            rows.row("lit pixels", "", |form| form.darkened.lit.to_string()),
            rows.row("darkened", "", |form| {
                cell(form, form.darkened.darkened.to_string())
            }),
            rows.row("darkened", "%", |form| {
                cell(form, number(100.0 * form.darkened.share))
            }),
        ],
    }
}

/// Makes rows with a cell for each form.
struct Rows<'a>(&'a Figures);

impl Rows<'_> {
    fn row(
        &self,
        name: &'static str,
        unit: &'static str,
        cell: impl Fn(&FormFigures) -> String,
    ) -> Row {
        Row {
            name,
            unit,
            cells: self.0.forms.iter().map(cell).collect(),
        }
    }
}

fn megabytes(bytes: u64) -> String {
    number(bytes as f64 * 1e-6)
}

/// Three digits, as far as there are not more than six behind the point; without an exponent.
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if value.abs() < 0.000_001 {
        return "<0.000001".into();
    }
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (1234.5, "1234"),
            (12.345, "12.3"),
            (3.0, "3"),
            (0.999_9, "1"),
            (0.001_234_5, "0.00123"),
            (100.0, "100"),
            (0.000_012_34, "0.000012"),
            (8e-7, "<0.000001"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }
}
