//! The file formats: which one a file has, and one reader for each.

#[cfg(test)]
mod damaged;
mod decompress;
mod detect;
mod gltf;
mod obj;
mod off;
mod ply;
mod stl;
mod text;

use std::path::Path;

use crate::error::{Fault, LoadError};
use crate::model::Model;
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::scenery::Scenery;
use detect::Format;

#[cfg(test)]
pub(crate) use damaged::{check, damaged};

/// Called now and then, from any thread, with the share of the work that is done, 0 to 1.
pub(crate) type Progress<'a> = &'a (dyn Fn(f32) + Sync);

/// What a reader makes of a file.
#[derive(Debug)]
pub(crate) struct Parsed {
    pub(crate) model: Model,
    pub(crate) scenery: Scenery,
    pub(crate) report: LoadReport,
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

/// Reads the bytes of a file. Its content decides the format; the path is for messages, and for
/// files that it names.
pub(crate) fn read(
    bytes: Vec<u8>,
    path: &Path,
    progress: Progress<'_>,
) -> Result<Parsed, LoadError> {
    let mut bytes = decompress::gunzip(bytes).map_err(|fault| fault.of(path))?;
    if text::is_utf16(&bytes) {
        bytes = text::decode(bytes).into_bytes();
    }
    let name = path.to_string_lossy().to_ascii_lowercase();
    let named_stl = name.ends_with(".stl") || name.ends_with(".stl.gz");
    let format = detect::detect(&bytes, named_stl).map_err(|what| LoadError::Format {
        path: path.into(),
        what: what.into(),
    })?;
    let parsed: Result<Parsed, Fault> = match format {
        Format::Obj => obj::read(&text::decode(bytes), path, progress),
        Format::Ply => ply::read(bytes),
        Format::StlText => stl::read_text(&text::decode(bytes)),
        Format::StlBinary => stl::read_binary(&bytes),
        Format::Off => off::read(&text::decode(bytes)),
        Format::Gltf | Format::Glb => gltf::read(&bytes, path),
    };
    parsed.map_err(|fault| fault.of(path))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::{LoadError, Loader};

    #[test]
    fn what_is_no_mesh_is_refused_by_content_whatever_the_name() {
        let error = Loader::new().load_bytes(b"v 0 0 0\0".to_vec(), "mesh.obj");
        assert_eq!(
            error.unwrap_err().to_string(),
            "mesh.obj: this is a binary file of an unknown format; OBJ, PLY, STL, OFF, glTF and \
             GLB files are read"
        );
    }

    #[test]
    fn every_format_is_read_by_content_plain_and_compressed() {
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
            let mut encoder = flate2::read::GzEncoder::new(&*file, flate2::Compression::fast());
            let mut gz = Vec::new();
            std::io::Read::read_to_end(&mut encoder, &mut gz).unwrap();
            for bytes in [&file, &gz] {
                let loaded = Loader::new().load_bytes(bytes.clone(), "mesh.obj");
                let mesh = loaded.unwrap().mesh;
                assert_eq!(mesh.triangle_positions(0), [Vec3::ZERO, Vec3::X, Vec3::Y]);
                assert_eq!(mesh.triangles().len(), 1);
            }
        }
    }

    #[test]
    fn a_broken_gzip_file_is_refused_by_name_with_its_cause() {
        let error = Loader::new().load_bytes(b"\x1f\x8b\x08".to_vec(), "x.obj.gz");
        let error: LoadError = error.unwrap_err();
        assert_eq!(error.to_string(), "x.obj.gz: the gzip file does not unpack");
        assert!(std::error::Error::source(&error).is_some());
    }
}
