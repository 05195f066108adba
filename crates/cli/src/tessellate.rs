//! `curvetri tessellate`: the curved surface as flat triangles.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use curvetri::curved::{CurvedMesh, CurvedOptions};
use curvetri::mesh::obj_text;
use curvetri::output::OutputFile;
use curvetri::render::Form;

use super::console::Console;
use super::surface::SurfaceArgs;
use super::{on_threads, usage, values};

/// Cut the curved surface into flat triangles, for programs that know only those
///
/// Each triangle becomes LEVEL times LEVEL triangles. Their vertices lie on the curved surface and
/// have its normals. Triangle i of the mesh becomes the triangles from number i * LEVEL * LEVEL on.
/// A closed mesh stays closed.
#[derive(Args)]
pub struct TessellateArgs {
    /// Mesh file (OBJ, PLY, STL, OFF, glTF, GLB, also as .gz), or - for standard input
    mesh: PathBuf,

    /// How many parts each edge is cut into
    #[arg(long, value_name = "LEVEL", default_value_t = 4,
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    level: u32,

    /// The file to write
    #[arg(short, long, value_name = "FILE.obj")]
    output: PathBuf,

    /// Threads to use [default: all]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<usize>,

    #[command(flatten)]
    surface: SurfaceArgs,
}

/// Runs the command.
pub fn run(args: &TessellateArgs, console: &Console) -> Result<()> {
    let options: CurvedOptions = match args.surface.form()? {
        Form::Curved(options) => options,
        Form::Flat => return usage("--surface flat is not curved: there is nothing to cut"),
    };
    on_threads(args.threads, || {
        let mesh = Arc::new(args.surface.load(&args.mesh, console)?.mesh);
        let output = OutputFile::create(&args.output)?;
        let curved = CurvedMesh::new(mesh, &options);
        let fine = curved
            .tessellate(args.level)
            .with_context(|| format!("cannot cut {} that finely", args.mesh.display()))?;
        let text = obj_text(fine.mesh());
        output.finish(|out| out.write_all(text.as_bytes()))?;
        console.note(&format!(
            "{}: {} triangles",
            args.output.display(),
            fine.mesh().triangles().len()
        ));
        Ok(())
    })
}
