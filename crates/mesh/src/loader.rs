//! The way in: reads files into meshes.

use std::io::Read;
use std::path::Path;

use crate::error::{Fault, LoadError};
use crate::formats::{self, Parsed, Progress};
use crate::instances::Parts;
use crate::mesh::Mesh;
use crate::normals::{NormalOptions, NormalsPolicy};
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::scenery::Scenery;

/// The share of the work that reading a file's text or numbers is. The rest makes a mesh of them.
const READING: f32 = 0.6;

/// A mesh, and what was found while it was read.
///
/// ```
/// use curvetri_mesh::{Loaded, Loader};
///
/// let off = "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// let Loaded { mesh, scenery, report } = Loader::new().load_bytes(off.into(), "a.off")?;
/// assert_eq!(mesh.triangles().len(), 1);
/// assert!(scenery.cameras.is_empty());
/// assert_eq!(report.normals.made, 3);
/// # Ok::<(), curvetri_mesh::LoadError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The mesh, in the user's space.
    pub mesh: Mesh,
    /// Cameras and lights of the file.
    pub scenery: Scenery,
    /// What was found.
    pub report: LoadReport,
}

/// Meshes and their instances, and what was found while they were read.
///
/// ```no_run
/// use curvetri_mesh::{LoadedParts, Loader};
///
/// let LoadedParts { parts, .. } = Loader::new().load_parts("forest.glb")?;
/// println!("{} meshes at {} places", parts.meshes.len(), parts.placements.len());
/// # Ok::<(), curvetri_mesh::LoadError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LoadedParts {
    /// The meshes and where they are placed.
    pub parts: Parts,
    /// Cameras and lights of the file.
    pub scenery: Scenery,
    /// What was found. A mesh counts once, however often it is placed.
    pub report: LoadReport,
}

/// Reads mesh files: OBJ, PLY, STL, OFF, glTF and GLB, each also compressed by gzip.
///
/// A file's content decides its format, not its name. The path `-` stands for standard input.
///
/// ```no_run
/// use curvetri_mesh::{Loader, NormalsPolicy};
///
/// let loader = Loader::new()
///     .normals(NormalsPolicy::Stored)
///     .crease_angle_degrees(40.0)
///     .progress(&|share| eprintln!("{:.0} %", 100.0 * share));
/// let mesh = loader.load("part.stl")?.mesh;
/// # Ok::<(), curvetri_mesh::LoadError>(())
/// ```
///
/// # Errors
///
/// All methods that read return a [`LoadError`]. Its message names the file, the line or element,
/// and what is wrong.
#[derive(Clone, Copy, Default)]
#[must_use]
pub struct Loader<'a> {
    normals: NormalOptions,
    lenient: bool,
    progress: Option<Progress<'a>>,
}

impl<'a> Loader<'a> {
    /// A loader with default options: see [`NormalOptions`].
    pub fn new() -> Loader<'a> {
        Loader::default()
    }

    /// Chooses which of the stored normals are used.
    pub fn normals(mut self, policy: NormalsPolicy) -> Loader<'a> {
        self.normals.policy = policy;
        self
    }

    /// Sets the greatest dihedral angle, in degrees, across which made normals are smooth: see
    /// [`NormalOptions::crease_angle_degrees`].
    pub fn crease_angle_degrees(mut self, degrees: f32) -> Loader<'a> {
        self.normals.crease_angle_degrees = Some(degrees);
        self
    }

    /// Skips faces, corners' normals, facets and primitives that are wrong, counts them in
    /// [`LoadReport::skipped_faults`] and warns of them. Without, the first of them is an error.
    pub fn lenient(mut self, lenient: bool) -> Loader<'a> {
        self.lenient = lenient;
        self
    }

    /// Has `progress` called now and then, from any thread, with the share of the work that is done,
    /// from 0 to 1.
    pub fn progress(mut self, progress: &'a (dyn Fn(f32) + Sync)) -> Loader<'a> {
        self.progress = Some(progress);
        self
    }

    /// Reads a file, or standard input where the path is `-`. All its parts become one mesh. Of a
    /// glTF file the default scene is read.
    ///
    /// # Errors
    ///
    /// [`LoadError`] if the file cannot be read or is no mesh.
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Loaded, LoadError> {
        let (bytes, name) = read_input(path.as_ref())?;
        self.load_bytes(bytes, name)
    }

    /// Reads the bytes of a file. The path is for messages, and for files that the mesh names, which
    /// are looked for beside it.
    ///
    /// # Errors
    ///
    /// [`LoadError`] if the bytes are no mesh, or a file that they name cannot be read.
    pub fn load_bytes(&self, bytes: Vec<u8>, path: impl AsRef<Path>) -> Result<Loaded, LoadError> {
        let path = path.as_ref();
        let Parsed {
            model,
            scenery,
            mut report,
        } = self.parse(bytes, path)?;
        let mesh = (model.flatten())
            .and_then(|raw| self.make(raw, &mut report))
            .map_err(|fault| fault.of(path))?;
        self.report_progress(1.0);
        report.warn();
        Ok(Loaded {
            mesh,
            scenery,
            report,
        })
    }

    /// Reads a file as [`load`](Loader::load) does, but a mesh that a glTF file places several times
    /// stays one part with as many placements. All others are one part, the first, in the user's
    /// space; so are placements whose transform is too extreme for an instance (flat, or of very
    /// different scales).
    ///
    /// # Errors
    ///
    /// [`LoadError`] if the file cannot be read or is no mesh.
    pub fn load_parts(&self, path: impl AsRef<Path>) -> Result<LoadedParts, LoadError> {
        let (bytes, name) = read_input(path.as_ref())?;
        self.load_parts_bytes(bytes, name)
    }

    /// The same from the bytes of a file.
    pub(crate) fn load_parts_bytes(
        &self,
        bytes: Vec<u8>,
        path: &Path,
    ) -> Result<LoadedParts, LoadError> {
        let Parsed {
            model,
            scenery,
            mut report,
        } = self.parse(bytes, path)?;
        let model = model.split().map_err(|fault| fault.of(path))?;
        let meshes: Result<_, Fault> = (model.parts.into_iter())
            .map(|raw| self.make(raw, &mut report))
            .collect();
        let parts = Parts {
            meshes: meshes.map_err(|fault| fault.of(path))?,
            placements: model.placements,
        };
        self.report_progress(1.0);
        report.warn();
        Ok(LoadedParts {
            parts,
            scenery,
            report,
        })
    }

    fn parse(&self, bytes: Vec<u8>, path: &Path) -> Result<Parsed, LoadError> {
        let parsed = formats::read(bytes, path, self.lenient, &|share| {
            self.report_progress(READING * share);
        })?;
        self.report_progress(READING);
        Ok(parsed)
    }

    /// Makes a mesh, and adds what that found to the report.
    fn make(&self, raw: RawMesh, report: &mut LoadReport) -> Result<Mesh, Fault> {
        let (mesh, of_mesh) = raw.into_mesh(&self.normals)?;
        report.add(&of_mesh);
        Ok(mesh.ordered())
    }

    fn report_progress(&self, share: f32) {
        if let Some(progress) = self.progress {
            progress(share);
        }
    }
}

/// The bytes of a file or of standard input, and the name for messages.
fn read_input(path: &Path) -> Result<(Vec<u8>, &Path), LoadError> {
    let is_standard_input = path.as_os_str() == "-";
    let bytes = if is_standard_input {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().read_to_end(&mut bytes);
        read.map(|_| bytes)
    } else {
        std::fs::read(path)
    };
    let bytes = bytes.map_err(|source| LoadError::Read {
        path: path.into(),
        source,
    })?;
    let name = if is_standard_input {
        "standard input".as_ref()
    } else {
        path
    };
    Ok((bytes, name))
}

#[cfg(test)]
mod tests {
    use std::error::Error;

    use super::*;
    use crate::Topology;

    #[test]
    fn a_missing_file_and_a_folder_are_refused_by_name_with_their_cause() {
        let error = Loader::new().load("no/such.obj").unwrap_err();
        assert_eq!(error.to_string(), "cannot read no/such.obj");
        let cause = error.source().unwrap().to_string();
        assert!(cause.starts_with("No such file"), "{cause}");
        let error = Loader::new().load(".").unwrap_err().to_string();
        assert_eq!(error, "cannot read .");
    }

    #[test]
    fn the_crease_angle_decides_hard_edges() {
        let roof = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 -1\nf 1 2 3\nf 2 1 4\n";
        let hard = |degrees| {
            let loader = Loader::new().crease_angle_degrees(degrees);
            let mesh = loader.load_bytes(roof.into(), "roof.obj").unwrap().mesh;
            Topology::new(&mesh).counts().hard
        };
        assert_eq!(
            [hard(30.0), hard(44.9), hard(45.1), hard(180.0)],
            [1, 1, 0, 0]
        );
    }

    #[test]
    fn a_mesh_without_any_area_is_told() {
        let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n";
        let warnings = |text: &str| {
            let whole = Loader::new().load_bytes(text.into(), "x.obj").unwrap();
            let parts = Loader::new().load_parts_bytes(text.into(), "x.obj".as_ref());
            assert_eq!(parts.unwrap().report, whole.report);
            whole.report.warnings
        };
        let expected = "none of the 2 triangles has an area: there is nothing to see";
        assert_eq!(warnings(text), [expected]);
        let one = text.replace("v 2 0 0", "v 2 1 0");
        assert_eq!(warnings(&one), [] as [String; 0]);
    }

    #[test]
    fn parts_too_far_apart_are_told() {
        let far = "v 456789.25 5123456.5 314.25\nv 456789.35 5123456.5 314.25\n\
                   v 456789.25 5123456.6 314.25\nf 4 5 6\n";
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n{far}");
        let report = Loader::new()
            .load_bytes(text.into(), "x.obj")
            .unwrap()
            .report;
        assert_eq!(report.imprecise_triangles, 1);
        assert!(
            report.warnings[0].starts_with("1 triangle lies so far"),
            "{:?}",
            report.warnings
        );
    }
}
