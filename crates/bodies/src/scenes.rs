//! The meshes kept as files in the repository's `scenes`.

use super::{Body, capped_cone, capped_cylinder, teapot, terminator};
use curvetri_mesh::Mesh;

/// The names of the scene files and the meshes they hold.
#[must_use]
pub fn scenes() -> Vec<(&'static str, Mesh)> {
    vec![
        ("sphere4.obj", Body::sphere_tetrahedron().mesh()),
        ("sphere12.obj", Body::sphere_cube().mesh()),
        ("cylinder.obj", Body::cylinder().mesh()),
        ("cone.obj", Body::cone().mesh()),
        ("torus.obj", Body::torus(6, 8).mesh()),
        ("torus_fine.obj", Body::torus(12, 16).mesh()),
        ("capped_cylinder.obj", capped_cylinder(16, 1.5)),
        ("capped_cone.obj", capped_cone(16, 1.25)),
        ("teapot.obj", teapot(6)),
        ("terminator.obj", terminator()),
    ]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use curvetri_mesh::{Loader, obj_text};

    #[test]
    fn the_committed_files_are_what_the_program_writes() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        for (name, mesh) in scenes() {
            let committed = std::fs::read_to_string(folder.join(name)).unwrap();
            assert!(
                committed == obj_text(&mesh),
                "{name} is old: run `cargo run --bin make_scenes`"
            );
            let read = Loader::new().load(folder.join(name)).unwrap();
            assert_eq!(read.mesh.triangles().len(), mesh.triangles().len());
            assert_eq!(read.report.normals.made, 0);
        }
    }
}
