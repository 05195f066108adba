//! `curvetri inspect`: what is in a mesh and what the method does with it.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use curvetri::curved::Inspection;
use curvetri::mesh::Loaded;
use curvetri::render::{Form, Scene, Shape};
use glam::DVec3;
use serde_json::{Value, json};

use super::advice::sentence;
use super::console::{self, Console};
use super::surface::SurfaceArgs;
use super::values::UpChoice;
use super::{device, paint, usage, values};

/// Show what is in a mesh, what becomes of its triangles, and what to do about its problems
#[derive(Args)]
pub struct InspectArgs {
    /// The mesh file, or - for standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    /// Print the figures as JSON
    #[arg(long)]
    json: bool,

    /// Write a picture of the mesh with each kind of triangle in its own colour, and print what the
    /// colours mean
    #[arg(long, value_name = "FILE.png", value_parser = values::png)]
    image: Option<PathBuf>,

    /// Which axis of the mesh points up in the picture
    #[arg(long, value_enum, default_value_t = UpChoice::Y, requires = "image")]
    up_axis: UpChoice,

    #[command(flatten)]
    surface: SurfaceArgs,
}

/// Runs the command.
pub fn run(args: &InspectArgs, console: &Console) -> Result<()> {
    let Form::Curved(options) = args.surface.form()? else {
        return usage("--surface flat curves nothing; leave it out to inspect what is curved");
    };
    let loaded = args.surface.read(&args.mesh, console)?;
    let bar = console.spinner("curving");
    let inspection = match &args.image {
        None => Inspection::new(loaded, &options),
        Some(image) => {
            let Loaded { mesh, report, .. } = loaded;
            let device = device(None)?;
            let scene = Scene::new(&device, vec![mesh], args.surface.form()?)
                .context("cannot build the scene")?;
            bar.finish_and_clear();
            paint::paint(&scene, image, args.up_axis.axis(), console)?;
            let Shape::Curved(curved) = &scene.shapes()[0] else {
                unreachable!("the form is a curved one");
            };
            Inspection::of(report, curved)
        }
    };
    bar.finish_and_clear();
    let legend = args.image.is_some();
    console::print(&if args.json {
        as_json(&inspection, legend)
    } else {
        as_text(&inspection, legend)
    })
}

/// A name and a value a line.
#[derive(Default)]
struct TextLines(String);

impl TextLines {
    fn add(&mut self, name: &str, value: impl AsRef<str>) {
        let _ = writeln!(self.0, "{name:10} {}", value.as_ref());
    }
}

fn as_text(inspection: &Inspection, legend: bool) -> String {
    let mut lines = TextLines::default();
    add_mesh(&mut lines, inspection);
    add_method(&mut lines, inspection, legend);
    let advice = inspection.advice();
    if advice.is_empty() {
        lines.add("advice", "nothing to mend");
    }
    for advice in &advice {
        lines.add("advice", sentence(advice));
    }
    lines.0
}

/// What is in the mesh.
fn add_mesh(lines: &mut TextLines, inspection: &Inspection) {
    let Inspection {
        report,
        topology,
        bounds,
        edges,
        ..
    } = inspection;
    lines.add(
        "triangles",
        format!("{} of {} polygons", inspection.triangles, report.polygons),
    );
    lines.add(
        "vertices",
        format!("{} in {} places", inspection.vertices, topology.places),
    );
    lines.add(
        "bounds",
        format!("{} to {}", vector(bounds.min), vector(bounds.max)),
    );
    if inspection.origin != DVec3::ZERO {
        lines.add(
            "origin",
            format!("{}, near the mesh", vector(inspection.origin)),
        );
    }
    lines.add(
        "lengths",
        format!(
            "edges from {:.3e}, mean {:.3e}, to {:.3e}",
            edges.least, edges.mean, edges.greatest
        ),
    );
    lines.add("normals", counts(&normals(inspection)));
    lines.add("edges", counts(&edge_kinds(inspection)));
    lines.add("closed", if topology.is_closed() { "yes" } else { "no" });
    lines.add("problems", counts(&problems(inspection)));
}

/// What the method does with it.
fn add_method(lines: &mut TextLines, inspection: &Inspection, legend: bool) {
    lines.add("kinds", counts(&kinds(inspection)));
    if legend {
        let colours = paint::legend().map(|(kind, colour)| format!("{colour}: {kind}"));
        let colours: Vec<String> = colours.collect();
        lines.add("colours", colours.join(", ").replace('_', " "));
    }
    if inspection.spheres.total() > 0 {
        lines.add("spheres", counts(&spheres(inspection)));
    }
    let heights = inspection.heights;
    lines.add(
        "heights",
        format!(
            "up to {:.3e} (triangle {}), and {:.1} % of the triangle's longest edge (triangle {})",
            heights.greatest,
            heights.greatest_at,
            100.0 * heights.steepest,
            heights.steepest_at
        ),
    );
    let megabytes = |bytes: u64| format!("{:.2} MB", bytes as f64 * 1e-6);
    let memory = inspection.memory;
    lines.add(
        "memory",
        format!(
            "{}: {} mesh, {} records, {} Embree's tree at most",
            megabytes(memory.total()),
            megabytes(memory.mesh),
            megabytes(memory.records),
            megabytes(memory.tree)
        ),
    );
}

fn vector(v: DVec3) -> String {
    // What single precision holds exactly needs no more digits than it has.
    let number = |x: f64| match x as f32 {
        single if f64::from(single) == x => format!("{single:?}"),
        _ => format!("{x:?}"),
    };
    let [x, y, z] = v.to_array().map(number);
    format!("({x}, {y}, {z})")
}

/// The counts that are not zero.
fn counts(named: &[(&str, u64)]) -> String {
    let some = named.iter().filter(|(_, count)| *count > 0);
    let words: Vec<String> = some
        .map(|(name, count)| format!("{count} {}", name.replace('_', " ")))
        .collect();
    if words.is_empty() {
        return "none".into();
    }
    words.join(", ")
}

fn normals(inspection: &Inspection) -> Vec<(&'static str, u64)> {
    let normals = &inspection.report.normals;
    vec![
        ("stored", normals.stored),
        ("made", normals.made),
        ("by_group", normals.by_group),
        ("faceted", normals.faceted),
        ("averaged", normals.averaged),
        ("unusable", normals.unusable),
        ("renormalised", normals.renormalised),
        ("against_face", normals.against_face),
    ]
}

fn edge_kinds(inspection: &Inspection) -> Vec<(&'static str, u64)> {
    let edges = &inspection.topology;
    vec![
        ("smooth", edges.smooth),
        ("hard", edges.hard),
        ("boundary", edges.boundary),
        ("non_manifold", edges.non_manifold),
        ("doubled", edges.doubled),
        ("flipped", edges.flipped),
    ]
}

fn problems(inspection: &Inspection) -> Vec<(&'static str, u64)> {
    vec![
        (
            "degenerate_triangles",
            inspection.topology.degenerate_triangles,
        ),
        (
            "duplicate_triangles",
            inspection.topology.duplicate_triangles,
        ),
        ("t_junctions", inspection.t_junctions),
        ("snapped_vertices", inspection.report.snapped),
        ("skipped_elements", inspection.report.skipped_elements),
        ("unused_vertices", inspection.report.unused_vertices),
        ("imprecise_triangles", inspection.report.imprecise_triangles),
        ("skipped_faults", inspection.report.skipped_faults),
    ]
}

fn kinds(inspection: &Inspection) -> Vec<(&'static str, u64)> {
    let named = inspection.kinds.named().into_iter();
    named.map(|(name, count)| (name, count as u64)).collect()
}

fn spheres(inspection: &Inspection) -> Vec<(&'static str, u64)> {
    let named = inspection.spheres.named().into_iter();
    named.map(|(name, count)| (name, count as u64)).collect()
}

/// One JSON object. Lengths are in the mesh's units, memory in bytes; normals are counted by
/// triangle corners.
fn as_json(inspection: &Inspection, legend: bool) -> String {
    let object = |named: Vec<(&str, u64)>| {
        let entries = named
            .into_iter()
            .map(|(name, count)| (name.to_owned(), count.into()));
        Value::Object(entries.collect())
    };
    let (bounds, memory) = (inspection.bounds, inspection.memory);
    let (edges, heights) = (inspection.edges, inspection.heights);
    let mut value = json!({
        "triangles": inspection.triangles,
        "polygons": inspection.report.polygons,
        "vertices": inspection.vertices,
        "places": inspection.topology.places,
        "bounds": { "min": bounds.min.to_array(), "max": bounds.max.to_array() },
        "origin": inspection.origin.to_array(),
        "edge_lengths": { "least": edges.least, "mean": edges.mean, "greatest": edges.greatest },
        "normals": object(normals(inspection)),
        "edges": object(edge_kinds(inspection)),
        "closed": inspection.topology.is_closed(),
        "problems": object(problems(inspection)),
        "warnings": inspection.report.warnings,
        "kinds": object(kinds(inspection)),
        "spheres": object(spheres(inspection)),
        "heights": {
            "greatest": heights.greatest,
            "greatest_at": heights.greatest_at,
            "steepest": heights.steepest,
            "steepest_at": heights.steepest_at,
        },
        "bytes": {
            "mesh": memory.mesh,
            "records": memory.records,
            "tree": memory.tree,
            "total": memory.total(),
        },
        "warnings": inspection.report.warnings,
        "advice": inspection.advice().iter().map(sentence).collect::<Vec<_>>(),
    });
    if legend {
        let colours = paint::legend().map(|(kind, colour)| (kind.to_owned(), colour.into()));
        value["colours"] = Value::Object(colours.collect());
    }
    format!("{value:#}\n")
}
