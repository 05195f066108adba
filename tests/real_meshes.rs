//! Real meshes, where `CURVETRI_MESHES` points to a folder of them: each loads or is refused with a
//! sentence.

use std::path::{Path, PathBuf};

use curvetri::mesh::{LoadOptions, Topology, load};

/// All files of these formats in a folder and those in it.
fn files(folder: &Path) -> Vec<PathBuf> {
    let endings = ["obj", "ply", "stl", "off", "gltf", "glb", "gz"];
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_mesh = path
            .extension()
            .and_then(|e| e.to_str())
            .is_some_and(|e| endings.contains(&e));
        if path.is_dir() {
            found.extend(files(&path));
        } else if is_mesh {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn every_mesh_loads_or_is_refused_by_name() {
    let Some(folder) = std::env::var_os("CURVETRI_MESHES").map(PathBuf::from) else {
        println!("skipped, because CURVETRI_MESHES is not set");
        return;
    };
    let files = files(&folder);
    assert!(
        !files.is_empty(),
        "there are no meshes in {}",
        folder.display()
    );
    for path in files {
        match load(&path, &LoadOptions::default()) {
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
