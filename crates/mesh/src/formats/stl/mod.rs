//! Reads STL files, text and binary.
//!
//! Our own reader, because the crate for it reads text in single precision, without line numbers,
//! up to the first `endsolid` only, and takes binary files that start with "solid" for text.
//!
//! A facet's normal says nothing that its corners do not say, except where both disagree: then the
//! winding counts, and the facets are counted for a warning. Vertex normals are made from the
//! facets, which share their corners by exact position.

mod binary;
mod text;

use glam::DVec3;

use super::Parsed;
use crate::error::{Fault, MAX_INDICES, MeshError, check_position};
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::skipped::Skipped;

pub(super) use binary::{is_empty_binary, is_whole_binary, read_binary};
pub(super) use text::{has_text_keywords, read_text, starts_as_text};

/// Facets on their way to a mesh.
struct Facets {
    positions: Vec<DVec3>,
    /// The number of the present facet, from 1.
    number: usize,
    /// Facets whose normal points to the side from which they wind clockwise.
    against: u64,
    skipped: Skipped,
    warnings: Vec<String>,
}

impl Facets {
    fn new(skipped: Skipped) -> Facets {
        Facets {
            positions: Vec::new(),
            number: 0,
            against: 0,
            skipped,
            warnings: Vec::new(),
        }
    }

    /// Adds the present facet, if its corners may be those of a mesh.
    fn push(&mut self, normal: DVec3, corners: [DVec3; 3]) -> Result<(), Fault> {
        for (corner, &position) in (1..).zip(&corners) {
            let what = |wrong| Fault::Content(format!("facet {}: {wrong}", self.number));
            check_position(corner, position).map_err(what)?;
        }
        let [a, b, c] = corners;
        if (b - a).cross(c - a).dot(normal) < 0.0 {
            self.against += 1;
        }
        self.positions.extend(corners);
        Ok(())
    }

    fn into_parsed(mut self) -> Result<Parsed, Fault> {
        let indices = self.positions.len() as u64;
        if indices > MAX_INDICES {
            return Err(MeshError::TooManyIndices { indices }.into());
        }
        if self.against > 0 {
            self.warnings.push(format!(
                "{} facets have a normal that points against their winding; the winding counts",
                self.against
            ));
        }
        let corners = (0..indices as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        let raw = RawMesh {
            corners: corners.collect(),
            positions: self.positions,
            ..RawMesh::default()
        };
        let report = LoadReport {
            polygons: indices / 3,
            warnings: self.warnings,
            ..LoadReport::default()
        };
        Parsed::new(raw, report, self.skipped)
    }
}

#[cfg(test)]
mod tests;
