//! Reads OBJ files through tobj.
//!
//! tobj is fed only what a surface needs, one line at a time: vertices, normals and faces, with
//! continuations joined, comments and colours cut off and each number checked. So an error has its
//! line, and lines that tobj would stumble over (materials, texture coordinates) or take for
//! surfaces (polylines) never reach it. All groups, objects and materials are one mesh in file
//! order.

use std::path::Path;

use glam::DVec3;

use super::error::Fault;
use super::faces::cut;
use super::obj_clean::Cleaner;
use super::{LoadReport, NO_NORMAL, Parsed, RawMesh};

/// Reads the text of an OBJ file; `path` is for material libraries beside it.
pub(super) fn read(text: &str, path: &Path) -> Result<Parsed, Fault> {
    let mut cleaner = Cleaner::new(text);
    let loaded = tobj::load_obj_buf(&mut cleaner, &tobj::LoadOptions::default(), |_| {
        unreachable!("no material library reaches tobj")
    });
    let (models, _) = loaded.map_err(|error| {
        let fault = cleaner.fault.take();
        // What tobj finds wrong has been let through by mistake, but it still has its line.
        fault.unwrap_or_else(|| Fault::Line(cleaner.line_number, error.to_string()))
    })?;
    let mut report = LoadReport {
        polygons: cleaner.polygons,
        skipped_elements: cleaner.skipped,
        ..LoadReport::default()
    };
    warn(&mut report, &cleaner.libraries, path);
    if cleaner.more_libraries > 0 {
        report.warnings.push(format!(
            "{} lines name further material libraries, which were not looked for",
            cleaner.more_libraries
        ));
    }
    let mesh = models.into_iter().next().map(|m| m.mesh);
    let raw = into_raw(mesh.unwrap_or_default());
    Ok(Parsed { raw, report })
}

fn warn(report: &mut LoadReport, libraries: &[String], path: &Path) {
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

#[cfg(test)]
#[path = "obj_tests.rs"]
mod tests;
