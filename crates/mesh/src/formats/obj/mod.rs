//! Reads OBJ files, in parallel.
//!
//! The text is cut at ends of lines into chunks. First the vertices and normals of each are
//! counted, because indices may count back from where they stand; then each is read on its own,
//! right into its share of the arrays. Only what makes a surface is read: vertices, normals and
//! faces. All groups, objects and materials are one mesh in file order.

mod chunk;
mod lines;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::{Parsed, Progress, beside};
use crate::error::{Fault, MeshError, check_sizes};
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::skipped::Skipped;
use chunk::{Chunk, Count, Libraries, Part};
use lines::{Lines, chunks};

/// How long a chunk is, in bytes: short enough that what is half done takes little memory.
const CHUNK: usize = 1 << 22;

/// Reads the text of an OBJ file; `path` is for material libraries beside it.
pub(super) fn read(
    text: &str,
    path: &Path,
    skipped: Skipped,
    progress: Progress<'_>,
) -> Result<Parsed, Fault> {
    read_by(text, path, skipped, progress, CHUNK)
}

fn read_by(
    text: &str,
    path: &Path,
    skipped: Skipped,
    progress: Progress<'_>,
    size: usize,
) -> Result<Parsed, Fault> {
    let texts = chunks(text, size);
    let counts: Vec<Count> = texts.par_iter().map(|text| Count::of(text)).collect();
    let total = counts.iter().copied().fold(Count::default(), Count::plus);
    check_sizes(0, total.vertices.max(total.normals))?;
    let mut raw = RawMesh {
        positions: vec![DVec3::ZERO; total.vertices as usize],
        normals: vec![DVec3::ZERO; total.normals as usize],
        ..RawMesh::default()
    };
    let (mut positions, mut normals) = (&mut raw.positions[..], &mut raw.normals[..]);
    let mut so_far = Count::default();
    let mut jobs = Vec::with_capacity(texts.len());
    for (text, count) in texts.iter().zip(counts) {
        let own_positions = split_off(&mut positions, count.vertices);
        let own_normals = split_off(&mut normals, count.normals);
        jobs.push(Chunk {
            lines: Lines::new(text, so_far.lines),
            so_far,
            total,
            skipped: skipped.fresh(),
            positions: own_positions,
            normals: own_normals,
        });
        so_far = so_far.plus(count);
    }
    let (done, whole) = (AtomicUsize::new(0), text.len() as f32);
    let parts: Vec<Result<Part, Fault>> = jobs
        .into_par_iter()
        .zip(&texts)
        .map(|(job, text)| {
            let part = job.read();
            let done = done.fetch_add(text.len(), Ordering::Relaxed) + text.len();
            progress(done as f32 / whole);
            part
        })
        .collect();
    // The first fault in the file's order.
    let parts: Vec<Part> = parts.into_iter().collect::<Result<_, _>>()?;
    let (mut parsed, libraries) = join(raw, parts, text, skipped)?;
    warn(&mut parsed.report, &libraries, path);
    Ok(parsed)
}

fn split_off<'a>(rest: &mut &'a mut [DVec3], count: u64) -> &'a mut [DVec3] {
    let (own, left) = std::mem::take(rest).split_at_mut(count as usize);
    *rest = left;
    own
}

/// Cuts polygons and puts the parts' triangles behind each other.
fn join(
    mut raw: RawMesh,
    parts: Vec<Part>,
    text: &str,
    mut skipped: Skipped,
) -> Result<(Parsed, Libraries), Fault> {
    let mut report = LoadReport::default();
    let mut libraries = Libraries::default();
    let indices = parts.iter().map(|part| part.faces.indices()).sum();
    check_sizes(indices, 0)?;
    raw.corners.reserve_exact(indices as usize / 3);
    let mut normal_corners = Vec::new();
    let mut groups = Vec::new();
    for part in parts {
        libraries.append(&part.libraries);
        skipped.append(part.skipped);
        let fault = |vertex, error| vertex_fault(text, vertex, error);
        let faces = part
            .faces
            .check_positions(&raw.positions, &mut skipped, fault)?;
        report.polygons += faces.polygons;
        report.skipped_elements += faces.too_small + part.no_surface;
        let triangles = faces.into_triangles(&raw.positions);
        raw.corners.extend(triangles.corners);
        normal_corners.extend(triangles.others);
        groups.extend(triangles.groups);
    }
    raw.normal_corners = (!raw.normals.is_empty()).then_some(normal_corners);
    raw.smoothing_groups = (!groups.is_empty()).then_some(groups);
    Ok((Parsed::new(raw, report, skipped)?, libraries))
}

/// What is wrong with the position of a vertex, which is counted from 0, with its line.
fn vertex_fault(text: &str, vertex: u32, error: MeshError) -> Fault {
    let mut lines = Lines::new(text, 0).filter(|line| line.keyword == "v");
    let Some(line) = lines.nth(vertex as usize) else {
        return error.into();
    };
    let number = vertex + 1;
    let words: Vec<&str> = line.words().collect();
    let divisor = words.get(3).filter(|_| words.len() == 4);
    let what = match error {
        MeshError::NotFinite { .. } if divisor.is_some_and(|w| w.parse() == Ok(0.0)) => {
            format!("vertex {number}: its fourth coordinate, which divides, is zero")
        }
        MeshError::NotFinite { .. } => {
            format!("vertex {number} is not finite: {}", words.join(" "))
        }
        error => {
            let MeshError::TooFar { x, y, z, .. } = error else {
                return error.into();
            };
            let vertex = number as usize;
            MeshError::TooFar { vertex, x, y, z }.to_string()
        }
    };
    Fault::Line(line.number, what)
}

fn warn(report: &mut LoadReport, libraries: &Libraries, path: &Path) {
    for library in &libraries.names {
        if !beside(path, library).is_file() {
            report.warnings.push(format!(
                "the material library {library} was not found; the mesh is read without it"
            ));
        }
    }
    if libraries.more > 0 {
        report.warnings.push(format!(
            "{} lines name further material libraries, which were not looked for",
            libraries.more
        ));
    }
}

#[cfg(test)]
mod tests;
