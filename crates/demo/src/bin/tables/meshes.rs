//! What becomes of each mesh of a folder.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{Result, curvetri, machine, number};

const HEAD: &str = "# Real meshes

What becomes of 49 meshes that people use. Each is rendered at 400 x 300 pixels with 4 rays per pixel, in a
process of its own, or it is refused with a message. This command writes the table:

```sh
cargo run --release --bin tables -- meshes FOLDER
```

- *curved*: triangles with the default surface; *fall-back*: with the angular rule instead
- *plane*: flat because their surface lies in their plane; *flat*: flat because the method cannot take them
- *degenerate*: without area, so that no ray hits them
- *load*, *build*, *render*: seconds
- *memory*: the mesh, its packed patches and Embree's tree, in MB; *peak*: the most that the process ever had

";

/// The files' table.
pub fn table(folder: &Path) -> Result<String> {
    let files = files(folder)?;
    let picture = tempfile::Builder::new().suffix(".png").tempfile()?;
    let picture = picture.path().to_string_lossy();
    let (mut rows, mut refused) = (String::new(), String::new());
    let mut made_on = String::new();
    for path in &files {
        let name = path.strip_prefix(folder)?.display().to_string();
        let file = path.to_string_lossy();
        let render = ["render", "--quiet", "--json", "--size", "400x300"];
        let render = [&render[..], &["--samples", "4", "-o", &picture, &file]].concat();
        match curvetri(&render)? {
            Ok(stats) => {
                let inspected = curvetri(&["inspect", "--quiet", "--json", &file])??;
                rows += &row(&name, &stats, &inspected);
                made_on = machine(&stats);
            }
            Err(sentence) => {
                let sentence = sentence.replace(&*file, &name);
                refused += &format!("| {name} | {} |\n", sentence.replace('|', "\\|"));
            }
        }
    }
    let head = HEAD.replace("49 real", &format!("{} real", files.len()));
    Ok(format!(
        "{head}{made_on}\n\n\
         | file | triangles | closed | curved | fall-back | plane | flat | degenerate | load | \
         build | render | memory | peak |\n|---|--:|:-:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n{rows}\n\
         ## Refused\n\n| file | sentence |\n|---|---|\n{refused}"
    ))
}

fn row(name: &str, stats: &Value, inspected: &Value) -> String {
    let kinds = &stats["triangles"];
    let kind = |name: &str| number(&kinds[name]);
    let flat: f64 = ["sliver", "back_normal", "bend", "fold"]
        .map(|reason| kind(&format!("flat_{reason}")))
        .iter()
        .sum();
    let seconds = |name: &str| number(&stats["seconds"][name]);
    let bytes = |name: &str| number(&stats["bytes"][name]);
    let closed = inspected["closed"].as_bool() == Some(true);
    format!(
        "| {name} | {} | {} | {} | {} | {} | {flat} | {} | {:.3} | {:.3} | {:.2} | {:.1} | {:.0} |\n",
        kind("total"),
        if closed { "yes" } else { "no" },
        kind("curved"),
        kind("fallback"),
        kind("flat_plane"),
        kind("degenerate"),
        seconds("load"),
        seconds("curve") + seconds("build"),
        seconds("render"),
        1e-6 * (bytes("mesh") + bytes("records") + bytes("embree")),
        1e-6 * bytes("peak"),
    )
}

/// All mesh files in a folder and those in it.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if path.is_dir() {
            found.extend(files(&path)?);
        } else if ["obj", "ply", "stl", "off", "gltf", "glb", "gz"].contains(&ending) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
