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

use std::path::{Path, PathBuf};

use crate::error::{Fault, LoadError};
use crate::model::Model;
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::scenery::Scenery;
use crate::skipped::Skipped;
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
    fn new(raw: RawMesh, report: LoadReport, skipped: Skipped) -> Result<Parsed, Fault> {
        Parsed {
            model: raw.into(),
            scenery: Scenery::default(),
            report,
        }
        .with_skipped(skipped)
    }

    /// Reports what was skipped. A file of which nothing is left is refused.
    fn with_skipped(mut self, skipped: Skipped) -> Result<Parsed, Fault> {
        let is_empty = self.model.parts.iter().all(|part| part.corners.is_empty());
        match skipped.warning() {
            Some(warning) if is_empty => Err(Fault::Content(format!("{warning}; nothing is left"))),
            warning => {
                self.report.skipped_faults = skipped.count();
                self.report.warnings.extend(warning);
                Ok(self)
            }
        }
    }
}

/// The file that the file at `path` names, beside it. Programs on Windows write `\` between folders;
/// here that may be part of a name, so what is there comes first.
fn beside(path: &Path, name: &str) -> PathBuf {
    let folder = path.with_file_name("");
    let as_written = folder.join(name);
    if as_written.exists() {
        return as_written;
    }
    folder.join(name.replace('\\', "/"))
}

/// Reads the bytes of a file. Its content decides the format; the path is for messages, and for
/// files that it names. A lenient reader skips faces that are wrong.
pub(crate) fn read(
    bytes: Vec<u8>,
    path: &Path,
    lenient: bool,
    progress: Progress<'_>,
) -> Result<Parsed, LoadError> {
    let mut bytes = decompress::gunzip(bytes).map_err(|fault| fault.of(path))?;
    // Some programs write one more mark at each step, or where they join files. What looks like one
    // may be the first of a binary STL's 80 bytes of anything.
    while !stl::is_whole_binary(&bytes) && text::take_mark(&mut bytes) {}
    let name = path.to_string_lossy().to_ascii_lowercase();
    let named_stl = name.ends_with(".stl") || name.ends_with(".stl.gz");
    let format = detect::detect(&bytes, named_stl).map_err(|what| LoadError::Format {
        path: path.into(),
        what,
    })?;
    let skipped = Skipped::new(lenient);
    let parsed: Result<Parsed, Fault> = match format {
        Format::Obj => obj::read(&text::decode(bytes), path, skipped, progress),
        Format::Ply => ply::read(bytes, skipped),
        Format::StlText => stl::read_text(&text::decode(bytes), skipped),
        Format::StlBinary => stl::read_binary(&bytes, skipped),
        Format::Off => off::read(&text::decode(bytes), skipped),
        Format::Gltf | Format::Glb => gltf::read(&bytes, path, skipped),
    };
    parsed.map_err(|fault| fault.of(path))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::{LoadError, Loader};

    #[test]
    fn what_is_no_mesh_is_refused_by_content_whatever_the_name() {
        let error = Loader::new().load_bytes(b"v 0 0 0\0\x01".to_vec(), "mesh.obj");
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
    fn a_byte_order_mark_is_skipped_for_every_format() {
        let stl = "solid part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                   vertex 0 1 0\nendloop\nendfacet\nendsolid part\n";
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                   property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let gltf = "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"meshes\":[{\
                    \"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\
                    \"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\
                    \"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\
                    \"byteLength\":36,\"uri\":\"data:;base64,\
                    AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";
        let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        for text in [stl, ply, gltf, off, obj] {
            let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            let marked = [
                [b"\xef\xbb\xbf", text.as_bytes()].concat(),
                [b"\xff\xfe".to_vec(), utf16].concat(),
            ];
            for bytes in marked {
                let loaded = Loader::new().load_bytes(bytes, "x");
                let mesh = loaded
                    .unwrap_or_else(|error| panic!("{text}: {error}"))
                    .mesh;
                assert_eq!(mesh.triangle_positions(0), [Vec3::ZERO, Vec3::X, Vec3::Y]);
            }
        }
        // In a binary STL the same bytes are the first of its header.
        let mut stl = vec![0; 84];
        stl[..3].copy_from_slice(b"\xef\xbb\xbf");
        stl[80] = 1;
        let numbers = [0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.];
        stl.extend(numbers.iter().flat_map(|x: &f32| x.to_le_bytes()));
        stl.extend([0, 0]);
        let marked = [b"\xef\xbb\xbf", &stl[..]].concat();
        for bytes in [stl, marked] {
            assert_eq!(
                Loader::new()
                    .load_bytes(bytes, "x")
                    .unwrap()
                    .mesh
                    .triangles()
                    .len(),
                1
            );
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
