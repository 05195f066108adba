//! Reads OBJ files through tobj.
//!
//! tobj is fed only what a surface needs, one line at a time: vertices, normals and faces, with
//! continuations joined, comments and colours cut off and each number checked. So an error has its
//! line, and lines that tobj would stumble over (materials, texture coordinates) or take for
//! surfaces (polylines) never reach it. All groups, objects and materials are one mesh in file
//! order.

use std::path::Path;

use glam::DVec3;

use super::obj_clean::{Cleaner, Fault};
use super::obj_text::decode;
use super::polygon::PolygonCutter;
use super::{LoadError, LoadOptions, LoadReport, Loaded, NO_NORMAL, RawMesh};

/// Reads an OBJ file's bytes; `path` is for messages and for material libraries beside it.
pub(super) fn read(
    bytes: Vec<u8>,
    path: &Path,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let (raw, mut report) = parse(bytes, path)?;
    let (mesh, normals) = raw.into_mesh(options).map_err(|source| LoadError::Mesh {
        path: path.into(),
        source,
    })?;
    report.normals = normals;
    if normals.unusable > 0 {
        report.warnings.push(format!(
            "{} triangle corners have a normal that is zero or not finite; theirs were made",
            normals.unusable
        ));
    }
    Ok(Loaded { mesh, report })
}

fn parse(bytes: Vec<u8>, path: &Path) -> Result<(RawMesh, LoadReport), LoadError> {
    let text = decode(bytes);
    let mut cleaner = Cleaner::new(&text);
    let loaded = tobj::load_obj_buf(&mut cleaner, &tobj::LoadOptions::default(), |_| {
        unreachable!("no material library reaches tobj")
    });
    let (models, _) = loaded.map_err(|error| match cleaner.fault.take() {
        Some(Fault::Mesh(source)) => LoadError::Mesh {
            path: path.into(),
            source,
        },
        fault => LoadError::Line {
            path: path.into(),
            line: cleaner.line_number,
            // What tobj finds wrong has been let through by mistake, but it still has its line.
            what: match fault {
                Some(Fault::Line(what)) => what,
                _ => error.to_string(),
            },
        },
    })?;
    let mut report = LoadReport {
        polygons: cleaner.polygons,
        skipped_elements: cleaner.skipped,
        ..LoadReport::default()
    };
    warn(&mut report, &cleaner.libraries, path);
    let mesh = models.into_iter().next().map(|m| m.mesh);
    Ok((into_raw(mesh.unwrap_or_default()), report))
}

fn warn(report: &mut LoadReport, libraries: &[String], path: &Path) {
    if report.skipped_elements > 0 {
        report.warnings.push(format!(
            "{} lines, points, curves or faces of fewer than three corners are no surface and were \
             skipped",
            report.skipped_elements
        ));
    }
    for library in libraries {
        let beside = path.with_file_name("").join(library.replace('\\', "/"));
        if !beside.is_file() {
            report.warnings.push(format!(
                "the material library {library} was not found; the mesh is read without it"
            ));
        }
    }
}

/// Sorts tobj's arrays and cuts polygons.
fn into_raw(mesh: tobj::Mesh) -> RawMesh {
    let positions = as_vectors(&mesh.positions);
    let normals = as_vectors(&mesh.normals);
    let cut = cut(&mesh.face_arities, &mesh.indices, &positions);
    let triangles = |indices: Vec<u32>| match &cut {
        Some(cut) => cut.iter().map(|t| t.map(|c| indices[c as usize])).collect(),
        None => indices.as_chunks::<3>().0.to_vec(),
    };
    let corners = triangles(mesh.indices);
    let normal_corners = (!normals.is_empty()).then(|| {
        let mut corners = triangles(mesh.normal_indices);
        for index in corners.as_flattened_mut() {
            if normals[*index as usize].is_nan() {
                *index = NO_NORMAL;
            }
        }
        corners
    });
    RawMesh {
        positions,
        corners,
        normals,
        normal_corners,
    }
}

fn as_vectors(flat: &[f64]) -> Vec<DVec3> {
    flat.as_chunks::<3>().0.iter().map(|&p| p.into()).collect()
}

/// The triangles of faces of the given numbers of corners, as numbers into the corners of all
/// faces; `None` where all faces are triangles.
fn cut(arities: &[u32], corners: &[u32], positions: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    if arities.is_empty() {
        return None;
    }
    let mut cutter = PolygonCutter::new();
    let mut outline = Vec::new();
    let mut triangles = Vec::new();
    let mut first = 0;
    for &arity in arities {
        let face = &corners[first as usize..(first + arity) as usize];
        outline.clear();
        outline.extend(face.iter().map(|&v| positions[v as usize]));
        triangles.extend(cutter.cut(&outline).iter().map(|t| t.map(|k| first + k)));
        first += arity;
    }
    Some(triangles)
}

#[cfg(test)]
#[path = "obj_tests.rs"]
mod tests;
