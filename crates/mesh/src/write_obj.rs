//! Writes OBJ files.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use crate::mesh::Mesh;
use crate::topology::weld;

/// A mesh as the text of an OBJ file, with normals. Numbers have as many digits as reading them
/// back bit for bit takes (around a local origin, as many as double precision takes). Positions
/// that vertices share are written once.
#[must_use]
pub fn obj_text(mesh: &Mesh) -> String {
    let (place_of, places) = weld(mesh.positions());
    let mut text = String::new();
    let mut written = 0;
    for (vertex, &place) in place_of.iter().enumerate() {
        if place as usize == written {
            written += 1;
            line(&mut text, "v", position_words(mesh, vertex));
        }
    }
    debug_assert_eq!(written, places);
    for n in mesh.normals() {
        line(&mut text, "vn", n.to_array().map(|x| x.to_string()));
    }
    for t in mesh.triangles() {
        let corners = t.map(|v| format!("{}//{}", place_of[v as usize] + 1, v + 1));
        line(&mut text, "f", corners);
    }
    text
}

fn position_words(mesh: &Mesh, vertex: usize) -> [String; 3] {
    if mesh.origin() == glam::DVec3::ZERO {
        mesh.positions()[vertex].to_array().map(|x| x.to_string())
    } else {
        mesh.world_position(vertex)
            .to_array()
            .map(|x| x.to_string())
    }
}

fn line(text: &mut String, keyword: &str, words: [String; 3]) {
    writeln!(text, "{keyword} {}", words.join(" ")).expect("writing to a string does not fail");
}

/// Writes a mesh as an OBJ file, beside its place first and then renamed, so that there is never
/// half a file.
///
/// # Errors
///
/// What the operating system says, with the path.
pub fn write_obj(mesh: &Mesh, path: impl AsRef<Path>) -> std::io::Result<()> {
    let path = path.as_ref();
    let write = || {
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        // Readable as any new file, and not by its owner only.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(folder)?;
        file.write_all(obj_text(mesh).as_bytes())?;
        file.persist(path)?;
        std::io::Result::Ok(())
    };
    write().map_err(|error| {
        let what = format!("cannot write {}: {error}", path.display());
        std::io::Error::new(error.kind(), what)
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::Loader;

    fn roof(offset: f64) -> Mesh {
        let positions = [[0., 0., 0.], [1., 0., 0.], [0., 0.7, 0.1], [0., -0.3, -1.3]];
        let positions = positions.map(|p| DVec3::from(p) + offset).to_vec();
        Mesh::new(positions, None, vec![[0, 1, 2], [1, 0, 3]]).unwrap()
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("roof.obj");
        for mesh in [roof(0.0), roof(1e7)] {
            assert_eq!(
                mesh.positions().len(),
                6,
                "the hard edge splits two vertices"
            );
            write_obj(&mesh, &path).unwrap();
            let read = Loader::new().load(&path).unwrap().mesh;
            assert_eq!(read.positions().len(), mesh.positions().len());
            assert_eq!(read.triangles().len(), mesh.triangles().len());
            for triangle in 0..mesh.triangles().len() {
                let positions = |mesh: &Mesh| mesh.triangle_positions(triangle);
                assert_eq!(positions(&read), positions(&mesh));
                let normals = |mesh: &Mesh| mesh.triangle_normals(triangle);
                for (a, b) in normals(&read).into_iter().zip(normals(&mesh)) {
                    assert!(a.distance(b) < 1e-7);
                }
            }
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_unwritable_place_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing/roof.obj");
        let error = write_obj(&roof(0.0), &path).unwrap_err().to_string();
        let expected = format!("cannot write {}: ", path.display());
        assert!(error.starts_with(&expected), "{error}");
    }
}
