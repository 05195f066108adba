//! Triangle meshes: reading files, vertex normals, which triangles share a side.
//!
//! [`load`] reads a file (OBJ, PLY, STL, OFF, glTF) into a [`Loaded`]: a [`Mesh`] and what was met
//! on the way; [`load_parts`] keeps meshes that a glTF file uses several times apart. Every reader makes a [`RawMesh`] of what its file says; [`RawMesh::into_mesh`] checks it, makes missing
//! normals and merges corners into vertices. [`Topology`] then tells which triangles share a side
//! and how.

mod crossing;
mod error;
mod faces;
mod facets;
mod fan;
mod format;
mod gltf;
mod gltf_buffers;
mod gltf_scenery;
mod input;
mod junctions;
#[cfg(test)]
mod mangle;
mod model;
mod normals;
mod obj;
mod obj_chunk;
mod obj_text;
mod obj_write;
mod off;
mod order;
mod parts;
mod ply;
mod ply_body;
mod polygon;
mod raw;
mod scenery;
mod side_uses;
mod snap;
mod stl;
mod text;
mod topology;
mod triangle_mesh;
mod weld;

use std::path::Path;

use error::Fault;
use format::Format;
use model::Model;

pub use error::{LoadError, MAX_COORDINATE, MAX_INDICES, MeshError};
pub use junctions::t_junctions;
pub use normals::{NormalsPolicy, NormalsReport};
pub use obj_write::{obj_text, write_obj};
pub use parts::{Parts, Placement};
pub use raw::{NO_NORMAL, RawMesh};
pub use scenery::{FileCamera, FileCone, FileLamp, Scenery};
pub use topology::{NO_TRIANGLE, SideKind, Topology, TopologyCounts};
pub use triangle_mesh::{Bounds, Mesh};
pub use weld::weld;

/// How a mesh is made of what a file says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadOptions {
    /// Where normals are missing, faces whose dihedral angle (degrees, 0 where they lie in one
    /// plane) is at most this are smoothed into each other; a greater one makes a hard edge.
    pub crease_angle_degrees: f32,
    /// Which of the stored normals are used.
    pub normals: NormalsPolicy,
}

impl Default for LoadOptions {
    fn default() -> LoadOptions {
        LoadOptions {
            crease_angle_degrees: 30.0,
            normals: NormalsPolicy::default(),
        }
    }
}

/// A mesh and what was met while reading it.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// Cameras and lights beside it.
    pub scenery: Scenery,
    /// What was met.
    pub report: LoadReport,
}

/// Meshes apart from where they are used, and what was met while reading them.
#[derive(Debug, Clone)]
pub struct LoadedParts {
    /// The meshes and their uses.
    pub parts: Parts,
    /// Cameras and lights beside them.
    pub scenery: Scenery,
    /// What was met; a mesh counts once, however often it is used.
    pub report: LoadReport,
}

/// What was met in a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// Polygons of three corners or more.
    pub polygons: u64,
    /// Lines, points and faces of fewer than three corners, none of which is a surface: skipped.
    pub skipped_elements: u64,
    /// Places of vertices that were so near to another that they were put there.
    pub snapped: u64,
    /// Where the normals come from.
    pub normals: NormalsReport,
    /// Sentences for the user on what was skipped or mended.
    pub warnings: Vec<String>,
}

/// Told now and then, from any thread, what share of the work is done, 0 to 1.
pub type Progress<'a> = &'a (dyn Fn(f32) + Sync);

/// The share of the work that reading a file's text or numbers is; the rest makes a mesh of them.
const READING: f32 = 0.6;

/// What a reader makes of a file.
#[derive(Debug)]
struct Parsed {
    model: Model,
    scenery: Scenery,
    report: LoadReport,
}

impl Parsed {
    /// Nothing but a mesh.
    fn new(raw: RawMesh, report: LoadReport) -> Parsed {
        Parsed {
            model: raw.into(),
            scenery: Scenery::default(),
            report,
        }
    }
}

/// Reads a mesh file, or standard input where the path is `-`.
///
/// OBJ, PLY, STL, OFF, glTF and GLB files are read, each also as `.gz`; the content tells which it
/// is, not the name. All their parts become one mesh. Of a glTF file the default scene is read.
///
/// # Errors
///
/// [`LoadError`], whose message names the file, the line or element, and what is wrong.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, LoadError> {
    load_watched(path, options, &|_| {})
}

/// The same as [`load`], telling how far it is.
///
/// # Errors
///
/// As [`load`].
pub fn load_watched(
    path: impl AsRef<Path>,
    options: &LoadOptions,
    progress: Progress<'_>,
) -> Result<Loaded, LoadError> {
    let (bytes, path) = input(path.as_ref())?;
    load_bytes_watched(bytes, path, options, progress)
}

/// The same as [`load`], from the bytes of a file. The path is for messages, and for files that the
/// mesh names, which are looked for beside it.
///
/// # Errors
///
/// As [`load`].
pub fn load_bytes(
    bytes: Vec<u8>,
    path: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    load_bytes_watched(bytes, path.as_ref(), options, &|_| {})
}

/// The same as [`load_watched`], but a mesh that a glTF file uses several times stays one part with
/// as many placements. All others are one part, the first, in the user's space; so are uses whose
/// transform is too extreme for an instance (flat, or of very different scales).
///
/// # Errors
///
/// As [`load`].
pub fn load_parts(
    path: impl AsRef<Path>,
    options: &LoadOptions,
    progress: Progress<'_>,
) -> Result<LoadedParts, LoadError> {
    let (bytes, path) = input(path.as_ref())?;
    load_parts_bytes(bytes, path, options, progress)
}

/// A file's bytes, and its name.
fn input(path: &Path) -> Result<(Vec<u8>, &Path), LoadError> {
    let bytes = input::read(path).map_err(|source| LoadError::Read {
        path: path.into(),
        source,
    })?;
    let name = if input::is_standard_input(path) {
        "standard input".as_ref()
    } else {
        path
    };
    Ok((bytes, name))
}

fn load_bytes_watched(
    bytes: Vec<u8>,
    path: &Path,
    options: &LoadOptions,
    progress: Progress<'_>,
) -> Result<Loaded, LoadError> {
    let Parsed {
        model,
        scenery,
        mut report,
    } = parse(bytes, path, &|share| progress(READING * share))?;
    progress(READING);
    let mesh = (model.flatten())
        .and_then(|raw| report.made(raw, options))
        .map_err(|fault| fault.of(path))?;
    progress(1.0);
    report.warn();
    Ok(Loaded {
        mesh,
        scenery,
        report,
    })
}

fn load_parts_bytes(
    bytes: Vec<u8>,
    path: &Path,
    options: &LoadOptions,
    progress: Progress<'_>,
) -> Result<LoadedParts, LoadError> {
    let Parsed {
        model,
        scenery,
        mut report,
    } = parse(bytes, path, &|share| progress(READING * share))?;
    progress(READING);
    let model = model.split().map_err(|fault| fault.of(path))?;
    let meshes: Result<_, Fault> = (model.parts.into_iter())
        .map(|raw| report.made(raw, options))
        .collect();
    let parts = Parts {
        meshes: meshes.map_err(|fault| fault.of(path))?,
        placements: model.uses,
    };
    progress(1.0);
    report.warn();
    Ok(LoadedParts {
        parts,
        scenery,
        report,
    })
}

fn parse(bytes: Vec<u8>, path: &Path, progress: Progress<'_>) -> Result<Parsed, LoadError> {
    let mut bytes = input::unpack(bytes, path)?;
    if text::is_utf16(&bytes) {
        bytes = text::decode(bytes).into_bytes();
    }
    let name = path.to_string_lossy().to_ascii_lowercase();
    let named_stl = name.ends_with(".stl") || name.ends_with(".stl.gz");
    let format = format::detect(&bytes, named_stl).map_err(|what| LoadError::Format {
        path: path.into(),
        what: what.into(),
    })?;
    let parsed = match format {
        Format::Obj => obj::read(&text::decode(bytes), path, progress),
        Format::Ply => ply::read(bytes),
        Format::StlText => stl::read_text(&text::decode(bytes)),
        Format::StlBinary => stl::read_binary(&bytes),
        Format::Off => off::read(&text::decode(bytes)),
        Format::Gltf | Format::Glb => gltf::read(&bytes, path),
    };
    parsed.map_err(|fault| fault.of(path))
}

impl LoadReport {
    /// Makes a mesh, and counts what it took.
    fn made(&mut self, raw: RawMesh, options: &LoadOptions) -> Result<Mesh, Fault> {
        let (mesh, made) = raw.into_mesh(options)?;
        self.normals = self.normals.add(made.normals);
        self.snapped += made.snapped;
        Ok(mesh.ordered())
    }

    /// Puts sentences for what has been counted before those of the reader.
    fn warn(&mut self) {
        let mut sentences = Vec::new();
        if self.skipped_elements > 0 {
            sentences.push(format!(
                "{} lines, points, curves or faces of fewer than three corners are no surface and \
                 were skipped",
                self.skipped_elements
            ));
        }
        if self.snapped > 0 {
            sentences.push(format!(
                "{} vertices lay less than a millionth of a side, or rounding, beside another and were \
                 put there",
                self.snapped
            ));
        }
        if self.normals.unusable > 0 {
            sentences.push(format!(
                "{} triangle corners have a normal that is zero or not finite; theirs were made",
                self.normals.unusable
            ));
        }
        if self.normals.faceted > 0 {
            sentences.push(format!(
                "{} triangle corners have flat normals on what looks like a curved wall; theirs were \
                 made smooth",
                self.normals.faceted
            ));
        }
        self.warnings.splice(0..0, sentences);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

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
    fn what_is_no_mesh_is_refused_by_content_whatever_the_name() {
        assert_eq!(
            error_of(b"v 0 0 0\0"),
            ": this is a binary file of an unknown format; OBJ, PLY, STL, OFF, glTF and GLB files \
             are read"
        );
    }

    #[test]
    fn every_format_is_read_by_content_plain_and_packed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        let corners = "0 0 0\n1 0 0\n0 1 0\n";
        let mut stl = vec![0; 84];
        stl[80] = 1;
        let numbers = [0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.];
        stl.extend(numbers.iter().flat_map(|x: &f32| x.to_le_bytes()));
        stl.extend([0, 0]);
        let ply_head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                        property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                        end_header\n";
        let files: [Vec<u8>; 5] = [
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into(),
            format!("{ply_head}{corners}3 0 1 2\n").into(),
            format!("OFF 3 1 0\n{corners}3 0 1 2\n").into(),
            stl,
            "solid x\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\nendsolid\n".into(),
        ];
        for file in files {
            let mut packed = flate2::read::GzEncoder::new(&*file, flate2::Compression::fast());
            let mut gz = Vec::new();
            std::io::Read::read_to_end(&mut packed, &mut gz).unwrap();
            for bytes in [&file, &gz] {
                std::fs::write(&path, bytes).unwrap();
                let mesh = load(&path, &LoadOptions::default()).unwrap().mesh;
                assert_eq!(mesh.triangle_positions(0), [Vec3::ZERO, Vec3::X, Vec3::Y]);
                assert_eq!(mesh.triangles().len(), 1);
            }
        }
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
                ..LoadOptions::default()
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
