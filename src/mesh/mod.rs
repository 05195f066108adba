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

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(bytes: &[u8]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        std::fs::write(&path, bytes).unwrap();
        let error = load(&path, &LoadOptions::default())
            .unwrap_err()
            .to_string();
        let named = error.strip_prefix(&path.display().to_string());
        named.expect("the file is named first").to_owned()
    }

    #[test]
    fn a_missing_file_and_a_folder_are_refused_by_name() {
        let error = load("no/such.obj", &LoadOptions::default()).unwrap_err();
        let message = error.to_string();
        assert!(
            message.starts_with("cannot read no/such.obj: No such file"),
            "{message}"
        );
        let error = load(".", &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.starts_with("cannot read .: "), "{error}");
    }

    #[test]
    fn other_formats_are_refused_by_content_whatever_the_name() {
        let not_read =
            |what: &str| format!(": this is {what}, which is not read yet; OBJ files are read");
        assert_eq!(error_of(b"ply\nformat ascii 1.0\n"), not_read("a PLY file"));
        assert_eq!(error_of(b"solid x\nendsolid x\n"), not_read("an STL file"));
        assert_eq!(error_of(b"OFF\n0 0 0\n"), not_read("an OFF file"));
        assert_eq!(error_of(b"glTF\x02\0\0\0"), not_read("a GLB file"));
        assert_eq!(error_of(b"\x1f\x8b\x08"), not_read("a gzip file"));
        assert_eq!(
            error_of(b" {\"asset\": 1}"),
            ": this looks like a glTF file, which is not read yet; OBJ files are read"
        );
        assert_eq!(
            error_of(b"v 0 0 0\0"),
            ": this is a binary file of an unknown format; OBJ files are read"
        );
    }

    #[test]
    fn the_crease_angle_decides_hard_edges() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("roof.obj");
        std::fs::write(
            &path,
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 -1\nf 1 2 3\nf 2 1 4\n",
        )
        .unwrap();
        let hard = |crease_angle_degrees| {
            let options = LoadOptions {
                crease_angle_degrees,
            };
            Topology::new(&load(&path, &options).unwrap().mesh)
                .counts()
                .hard
        };
        assert_eq!(
            [hard(30.0), hard(44.9), hard(45.1), hard(180.0)],
            [1, 1, 0, 0]
        );
    }
}
