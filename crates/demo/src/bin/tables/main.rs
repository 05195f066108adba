//! Makes the tables in `docs` by running `curvetri` on many meshes:
//!
//! - `cargo run --release --bin tables -- meshes FOLDER` writes `docs/meshes.md`, what becomes
//!   of each mesh file in a folder and those in it;
//! - `cargo run --release --bin tables -- sizes [TRIANGLES...]` writes `docs/size.md`, time and
//!   memory by the number of triangles.
//!
//! `cargo build --release` has to be run before.

mod meshes;
mod sizes;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use serde_json::Value;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let made = match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["meshes", folder] => meshes::table(Path::new(folder)).map(|t| ("docs/meshes.md", t)),
        ["sizes", ref sizes @ ..] => sizes::table(sizes).map(|t| ("docs/size.md", t)),
        _ => Err("usage: tables meshes FOLDER | tables sizes [TRIANGLES...]".into()),
    };
    let written = made.and_then(|(file, table)| Ok(std::fs::write(file, table)?));
    if let Err(error) = written {
        eprintln!("tables: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What a run of `curvetri` printed as JSON, or the sentence it refused with.
fn curvetri(args: &[&str]) -> Result<std::result::Result<Value, String>> {
    let output = Command::new(program()?).args(args).output()?;
    if output.status.success() {
        return Ok(Ok(serde_json::from_slice(&output.stdout)?));
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let sentence = said.lines().next().unwrap_or_default();
    match sentence.strip_prefix("curvetri: error: ") {
        Some(sentence) if output.status.code() == Some(1) => Ok(Err(sentence.to_owned())),
        _ => Err(format!("curvetri {args:?}: {}: {said}", output.status).into()),
    }
}

/// The program beside the examples.
fn program() -> Result<PathBuf> {
    let own = std::env::current_exe()?;
    let folder = own.parent().and_then(Path::parent);
    let program = folder.map(|folder| folder.join("curvetri"));
    let program = program.filter(|program| program.exists());
    Ok(program.ok_or("build curvetri first: cargo build --release")?)
}

/// Where and with which Embree the figures were made.
fn machine(stats: &Value) -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let embree = &stats["embree"];
    let word = |name: &str| embree[name].as_str().unwrap_or("?").to_owned();
    format!(
        "On {cores} cores, Embree {} ({}).",
        word("version"),
        word("isa")
    )
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}
