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

use super::{Parsed, Progress};
use crate::error::{Fault, check_sizes};
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use chunk::{Chunk, Count, Libraries, Part};
use lines::{Lines, chunks, line_end};

/// How long a chunk is, in bytes: short enough that what is half done takes little memory.
const CHUNK: usize = 1 << 22;

/// Reads the text of an OBJ file; `path` is for material libraries beside it.
pub(super) fn read(text: &str, path: &Path, progress: Progress<'_>) -> Result<Parsed, Fault> {
    read_by(text, path, progress, CHUNK)
}

fn read_by(text: &str, path: &Path, progress: Progress<'_>, size: usize) -> Result<Parsed, Fault> {
    let end = line_end(text);
    let texts = chunks(text, end, size);
    let counts: Vec<Count> = texts.par_iter().map(|text| Count::of(text, end)).collect();
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
            lines: Lines::new(text, end, so_far.lines),
            so_far,
            total,
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
    join(raw, parts, path)
}

fn split_off<'a>(rest: &mut &'a mut [DVec3], count: u64) -> &'a mut [DVec3] {
    let (own, left) = std::mem::take(rest).split_at_mut(count as usize);
    *rest = left;
    own
}

/// Cuts polygons and puts the parts' triangles behind each other.
fn join(mut raw: RawMesh, parts: Vec<Part>, path: &Path) -> Result<Parsed, Fault> {
    let mut report = LoadReport::default();
    let mut libraries = Libraries::default();
    let mut indices = 0;
    for part in &parts {
        report.polygons += part.faces.polygons;
        report.skipped_elements += part.faces.skipped + part.skipped;
        indices += part.faces.indices();
        libraries.append(&part.libraries);
    }
    check_sizes(indices, 0)?;
    warn(&mut report, &libraries, path);
    let has_normals = !raw.normals.is_empty();
    raw.corners.reserve_exact(indices as usize / 3);
    let mut normal_corners = Vec::new();
    if has_normals {
        normal_corners.reserve_exact(indices as usize / 3);
    }
    for part in parts {
        let triangles = part
            .faces
            .into_triangles_with(part.normal_corners, &raw.positions);
        raw.corners.extend(triangles.0);
        normal_corners.extend(triangles.1);
    }
    raw.normal_corners = has_normals.then_some(normal_corners);
    Ok(Parsed::new(raw, report))
}

fn warn(report: &mut LoadReport, libraries: &Libraries, path: &Path) {
    for library in &libraries.names {
        let beside = path.with_file_name("").join(library.replace('\\', "/"));
        if !beside.is_file() {
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
