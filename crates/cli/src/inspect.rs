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

fn as_text(inspection: &Inspection, legend: bool) -> String {
    let Inspection {
        report, topology, ..
    } = inspection;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:10} {value}");
    };
    line(
        "triangles",
        format!("{} of {} polygons", inspection.triangles, report.polygons),
    );
    line(
        "vertices",
        format!("{} in {} places", inspection.vertices, topology.places),
    );
    let bounds = inspection.bounds;
    line(
        "bounds",
        format!("{} to {}", vector(bounds.min), vector(bounds.max)),
    );
    if inspection.origin != DVec3::ZERO {
        line(
            "origin",
            format!("{}, near the mesh", vector(inspection.origin)),
        );
    }
    let sides = inspection.sides;
    line(
        "lengths",
        format!(
            "sides from {:.3e}, mean {:.3e}, to {:.3e}",
            sides.least, sides.mean, sides.greatest
        ),
    );
    line("normals", counts(&normals(inspection)));
    line("sides", counts(&side_kinds(inspection)));
    line(
        "closed",
        (if topology.is_closed() { "yes" } else { "no" }).into(),
    );
    line("problems", counts(&problems(inspection)));
    line("kinds", counts(&kinds(inspection)));
    if legend {
        let colours = paint::legend().map(|(kind, colour)| format!("{colour}: {kind}"));
        let colours: Vec<String> = colours.collect();
        line("colours", colours.join(", ").replace('_', " "));
    }
    if inspection.spheres.total() > 0 {
        line("spheres", counts(&spheres(inspection)));
    }
    let heights = inspection.heights;
    line(
        "heights",
        format!(
            "up to {:.3e} (triangle {}), and {:.1} % of the triangle's longest side (triangle {})",
            heights.greatest,
            heights.greatest_at,
            100.0 * heights.steepest,
            heights.steepest_at
        ),
    );
    let megabytes = |bytes: u64| format!("{:.2} MB", bytes as f64 * 1e-6);
    let memory = inspection.memory;
    line(
        "memory",
        format!(
            "{}: {} mesh, {} records, {} Embree's tree at most",
            megabytes(memory.total()),
            megabytes(memory.mesh),
            megabytes(memory.records),
            megabytes(memory.tree)
        ),
    );
    let advice = inspection.advice();
    if advice.is_empty() {
        line("advice", "nothing to mend".into());
    }
    for sentence in advice {
        line("advice", sentence);
    }
    text
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
        ("faceted", normals.faceted),
        ("unusable", normals.unusable),
        ("renormalised", normals.renormalised),
        ("against_face", normals.against_face),
    ]
}

fn side_kinds(inspection: &Inspection) -> Vec<(&'static str, u64)> {
    let sides = &inspection.topology;
    vec![
        ("smooth", sides.smooth),
        ("hard", sides.hard),
        ("boundary", sides.boundary),
        ("non_manifold", sides.non_manifold),
        ("doubled", sides.doubled),
        ("flipped", sides.flipped),
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
    let (sides, heights) = (inspection.sides, inspection.heights);
    let mut value = json!({
        "triangles": inspection.triangles,
        "polygons": inspection.report.polygons,
        "vertices": inspection.vertices,
        "places": inspection.topology.places,
        "bounds": { "min": bounds.min.to_array(), "max": bounds.max.to_array() },
        "origin": inspection.origin.to_array(),
        "side_lengths": { "least": sides.least, "mean": sides.mean, "greatest": sides.greatest },
        "normals": object(normals(inspection)),
        "sides": object(side_kinds(inspection)),
        "closed": inspection.topology.is_closed(),
        "problems": object(problems(inspection)),
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
        "advice": inspection.advice(),
    });
    if legend {
        let colours = paint::legend().map(|(kind, colour)| (kind.to_owned(), colour.into()));
        value["colours"] = Value::Object(colours.collect());
    }
    format!("{value:#}\n")
}
