//! Writes the meshes of `scenes`: `cargo run --bin make_scenes [FOLDER]`.

use std::path::PathBuf;

use curvetri::mesh::write_obj;
use curvetri_bodies::scenes;

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("scenes"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    for (name, mesh) in scenes() {
        write_obj(&mesh, folder.join(name))?;
        println!("{name}: {} triangles", mesh.triangles().len());
    }
    Ok(())
}
