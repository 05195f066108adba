//! Real meshes, where `CURVETRI_MESHES` points to a folder of them: each loads or is refused with a
//! sentence.

use std::path::PathBuf;

use curvetri::mesh::{Loader, Topology};

#[test]
fn every_mesh_loads_or_is_refused_by_name() {
    let Some(folder) = std::env::var_os("CURVETRI_MESHES").map(PathBuf::from) else {
        println!("skipped, because CURVETRI_MESHES is not set");
        return;
    };
    let files = curvetri_test_support::mesh_files(&folder);
    assert!(
        !files.is_empty(),
        "there are no meshes in {}",
        folder.display()
    );
    for path in files {
        match Loader::new().load(&path) {
            Ok(loaded) => {
                let counts = *Topology::new(&loaded.mesh).counts();
                println!(
                    "{}: {} triangles\n    {:?}\n    {counts:?}\n    {:?}",
                    path.display(),
                    loaded.mesh.triangles().len(),
                    loaded.report.normals,
                    loaded.report.warnings
                );
            }
            Err(error) => {
                println!("{error}");
                assert!(error.to_string().contains(&path.display().to_string()));
            }
        }
    }
}
