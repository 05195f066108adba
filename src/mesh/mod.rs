//! Triangle meshes: reading files, vertex normals, which triangles share a side.
//!
//! [`load`] reads a file into a [`Loaded`]: a [`Mesh`] and what was met on the way. Every reader
//! makes a [`RawMesh`] of what its file says; [`RawMesh::into_mesh`] checks it, makes missing
//! normals and merges corners into vertices. [`Topology`] then tells which triangles share a side
//! and how.

mod error;
mod fan;
mod normals;
mod obj;
mod obj_clean;
mod obj_text;
mod obj_write;
mod polygon;
mod raw;
mod topology;
mod triangle_mesh;
mod weld;

use std::path::Path;

pub use error::{LoadError, MAX_COORDINATE, MAX_INDICES, MeshError};
pub use normals::NormalsReport;
pub use obj_write::{obj_text, write_obj};
pub use raw::{NO_NORMAL, RawMesh};
pub use topology::{NO_TRIANGLE, SideKind, Topology, TopologyCounts};
pub use triangle_mesh::{Bounds, Mesh};

/// How a mesh is made of what a file says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadOptions {
    /// Where normals are missing, faces whose dihedral angle (degrees, 0 where they lie in one
    /// plane) is at most this are smoothed into each other; a greater one makes a hard edge.
    pub crease_angle_degrees: f32,
}

impl Default for LoadOptions {
    fn default() -> LoadOptions {
        LoadOptions {
            crease_angle_degrees: 30.0,
        }
    }
}

/// A mesh and what was met while reading it.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// What was met.
    pub report: LoadReport,
}

/// What was met in a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// Polygons of three corners or more.
    pub polygons: u64,
    /// Lines, points and faces of fewer than three corners, none of which is a surface: skipped.
    pub skipped_elements: u64,
    /// Where the normals come from.
    pub normals: NormalsReport,
    /// Sentences for the user on what was skipped or mended.
    pub warnings: Vec<String>,
}

/// Reads a mesh file.
///
/// OBJ is read (see the user's manual for its fine print); the format is told by the content.
///
/// # Errors
///
/// [`LoadError`], whose message names the file, the line or element, and what is wrong.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| LoadError::Read {
        path: path.into(),
        source,
    })?;
    if let Some(what) = other_format(&bytes) {
        return Err(LoadError::Format {
            path: path.into(),
            what: what.into(),
        });
    }
    obj::read(bytes, path, options)
}

/// What a file is if it cannot be an OBJ. Further formats find their readers here.
fn other_format(bytes: &[u8]) -> Option<&'static str> {
    let first_word = bytes
        .split(u8::is_ascii_whitespace)
        .find(|word| !word.is_empty())
        .unwrap_or_default();
    match first_word {
        b"ply" => Some("this is a PLY file, which is not read yet"),
        b"solid" => Some("this is an STL file, which is not read yet"),
        b"OFF" | b"COFF" | b"NOFF" | b"CNOFF" => Some("this is an OFF file, which is not read yet"),
        _ if bytes.starts_with(b"glTF") => Some("this is a GLB file, which is not read yet"),
        _ if bytes.starts_with(b"\x1f\x8b") => Some("this is a gzip file, which is not read yet"),
        _ if first_word.starts_with(b"{") => {
            Some("this looks like a glTF file, which is not read yet")
        }
        _ if bytes.contains(&0) && !obj_text::is_utf16(bytes) => {
            Some("this is a binary file of an unknown format")
        }
        _ => None,
    }
}
