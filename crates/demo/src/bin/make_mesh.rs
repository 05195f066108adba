//! Writes a closed bumpy torus of about as many triangles as wanted as an OBJ file:
//! `cargo run --release --bin make_mesh -- TRIANGLES FILE`.

use std::process::ExitCode;

use curvetri::mesh::write_obj;
use curvetri_bodies::bumpy_torus;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (Some(Ok(triangles)), Some(file)) = (args.first().map(|n| n.parse()), args.get(1)) else {
        eprintln!("usage: make_mesh TRIANGLES FILE.obj");
        return ExitCode::from(2);
    };
    let mesh = bumpy_torus(triangles);
    if let Err(error) = write_obj(&mesh, file) {
        eprintln!("{error}");
        return ExitCode::FAILURE;
    }
    println!("{file}: {} triangles", mesh.triangles().len());
    ExitCode::SUCCESS
}
