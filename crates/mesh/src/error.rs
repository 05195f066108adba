//! What can be wrong with a mesh or its file, each with a sentence that names the place.

use std::path::{Path, PathBuf};

use glam::DVec3;
use thiserror::Error;

/// The largest coordinate a mesh may have: single precision's squares overflow a little beyond it,
/// and Embree takes larger bounds for invalid.
pub const MAX_COORDINATE: f64 = 1e18;

/// The most index values (three a triangle) a mesh may have.
pub const MAX_INDICES: u64 = 1 << 31;

/// Why arrays of numbers are no mesh. Vertices, normals and faces are numbered from 0, as in the
/// arrays.
///
/// ```
/// use curvetri_mesh::{Mesh, MeshError};
///
/// let error = Mesh::new(vec![], None, vec![]).unwrap_err();
/// assert_eq!(error, MeshError::Empty);
/// ```
#[derive(Debug, Error, Clone, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// There are neither triangles nor points.
    #[error("the mesh is empty: it has no triangles")]
    Empty,
    /// There are points, but no triangles.
    #[error(
        "the mesh has {points} point{}, no faces; only faces are a surface: make some of the points \
         first, with a program for point clouds",
        if *points == 1 { "" } else { "s" }
    )]
    NoFaces {
        /// How many vertices there are.
        points: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite: {x} {y} {z}")]
    NotFinite {
        /// The vertex.
        vertex: usize,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
        /// Its third coordinate.
        z: f64,
    },
    /// A coordinate is beyond [`MAX_COORDINATE`].
    #[error(
        "vertex {vertex} lies too far out ({x} {y} {z}): coordinates may go up to {MAX_COORDINATE:e}; \
         scale the mesh down"
    )]
    TooFar {
        /// The vertex.
        vertex: usize,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
        /// Its third coordinate.
        z: f64,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index}, but there are only {vertices} (0 is the first)")]
    VertexOutOfRange {
        /// The face.
        face: usize,
        /// What it names.
        index: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A face names a normal that does not exist.
    #[error("face {face} names normal {index}, but there are only {normals} (0 is the first)")]
    NormalOutOfRange {
        /// The face.
        face: usize,
        /// What it names.
        index: u32,
        /// How many there are.
        normals: usize,
    },
    /// The normals do not match the vertices or faces one to one.
    #[error("{normals} normals do not match {expected}")]
    NormalCount {
        /// How many normals or triples of normal indices there are.
        normals: usize,
        /// What there should be as many of.
        expected: String,
    },
    /// The smoothing groups do not match the triangles one to one.
    #[error("{groups} smoothing groups do not match {triangles} triangles")]
    GroupCount {
        /// How many groups there are.
        groups: usize,
        /// How many triangles there are.
        triangles: usize,
    },
    /// More than [`MAX_INDICES`] vertices.
    #[error(
        "{vertices} vertices are more than the {MAX_INDICES} (2^31) a mesh may have; split the mesh"
    )]
    TooManyVertices {
        /// How many there are.
        vertices: u64,
    },
    /// More than [`MAX_INDICES`] index values.
    #[error(
        "{indices} index values are more than the {MAX_INDICES} (2^31) a mesh may have; split the mesh"
    )]
    TooManyIndices {
        /// How many there are.
        indices: u64,
    },
}

/// Refuses a vertex whose position no mesh may have.
pub(crate) fn check_position(vertex: usize, position: DVec3) -> Result<(), MeshError> {
    let DVec3 { x, y, z } = position;
    if !position.is_finite() {
        return Err(MeshError::NotFinite { vertex, x, y, z });
    }
    if position.abs().max_element() > MAX_COORDINATE {
        return Err(MeshError::TooFar { vertex, x, y, z });
    }
    Ok(())
}

/// Refuses more index values or vertices than a mesh may have.
pub(crate) fn check_sizes(indices: u64, vertices: u64) -> Result<(), MeshError> {
    if indices > MAX_INDICES {
        return Err(MeshError::TooManyIndices { indices });
    }
    if vertices > MAX_INDICES {
        return Err(MeshError::TooManyVertices { vertices });
    }
    Ok(())
}

/// Why a mesh file could not be loaded.
///
/// A message does not contain that of its [source](std::error::Error::source): print both.
///
/// ```
/// use curvetri_mesh::{LoadError, Loader};
///
/// let error = Loader::new().load_bytes("v 0 0 zero\n".into(), "a.obj").unwrap_err();
/// assert_eq!(error.to_string(), "a.obj:1: vertex 1: \"zero\" is not a number");
/// assert!(matches!(error, LoadError::Line { line: 1, .. }));
/// ```
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file is of a format that is not read.
    #[error("{}: {what}; OBJ, PLY, STL, OFF, glTF and GLB files are read", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What the file seems to be.
        what: String,
    },
    /// A line of the file is wrong.
    #[error("{}:{line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
        /// The error behind it, if there is one.
        source: Option<Cause>,
    },
    /// Something in a file without lines is wrong, or the file as a whole.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The element and what is wrong with it.
        what: String,
        /// The error behind it, if there is one.
        source: Option<Cause>,
    },
    /// What the file says is no mesh.
    #[error("{}: no mesh can be made of it", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: MeshError,
    },
}

/// An error of a library that a reader uses.
pub(crate) type Cause = Box<dyn std::error::Error + Send + Sync>;

/// What a reader finds wrong, not yet with the file's name.
#[derive(Debug)]
pub(crate) enum Fault {
    /// A line, counted from 1.
    Line(usize, String),
    /// An element, or the whole.
    Content(String),
    /// A line, or the whole, with the error that caused it.
    Caused {
        line: Option<usize>,
        what: String,
        source: Cause,
    },
    /// What the file says is no mesh.
    Mesh(MeshError),
}

impl Fault {
    /// The same with more text behind it.
    pub(crate) fn with(self, more: &str) -> Fault {
        match self {
            Fault::Line(line, what) => Fault::Line(line, what + more),
            Fault::Content(what) => Fault::Content(what + more),
            Fault::Caused { line, what, source } => {
                let what = format!("{what}: {source}{more}");
                match line {
                    Some(line) => Fault::Line(line, what),
                    None => Fault::Content(what),
                }
            }
            Fault::Mesh(error) => Fault::Content(format!("{error}{more}")),
        }
    }

    /// The place and what is wrong there, without the file.
    pub(crate) fn text(&self) -> String {
        match self {
            Fault::Line(line, what) => format!("line {line}: {what}"),
            Fault::Content(what) => what.clone(),
            Fault::Caused { what, source, .. } => format!("{what}: {source}"),
            Fault::Mesh(error) => error.to_string(),
        }
    }

    /// The error for the file of this name.
    pub(crate) fn of(self, path: &Path) -> LoadError {
        let path = path.into();
        match self {
            Fault::Line(line, what) => LoadError::line(path, line, what, None),
            Fault::Content(what) => LoadError::content(path, what, None),
            Fault::Caused { line, what, source } => match line {
                Some(line) => LoadError::line(path, line, what, Some(source)),
                None => LoadError::content(path, what, Some(source)),
            },
            Fault::Mesh(source) => LoadError::Mesh { path, source },
        }
    }
}

impl LoadError {
    fn line(path: PathBuf, line: usize, what: String, source: Option<Cause>) -> LoadError {
        LoadError::Line {
            path,
            line,
            what,
            source,
        }
    }

    fn content(path: PathBuf, what: String, source: Option<Cause>) -> LoadError {
        LoadError::Content { path, what, source }
    }
}

/// The texts of an error and its causes, as the command line prints them.
#[cfg(test)]
pub(crate) fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    text
}

impl From<MeshError> for Fault {
    fn from(error: MeshError) -> Fault {
        Fault::Mesh(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_two_to_the_31_are_refused_by_their_number() {
        let most = 1 << 31;
        assert_eq!(check_sizes(most, most), Ok(()));
        let said = |indices, vertices| check_sizes(indices, vertices).unwrap_err().to_string();
        assert_eq!(
            said(most + 1, 0),
            "2147483649 index values are more than the 2147483648 (2^31) a mesh may have; split \
             the mesh"
        );
        assert_eq!(
            said(0, 3 << 30),
            "3221225472 vertices are more than the 2147483648 (2^31) a mesh may have; split the mesh"
        );
    }
}
