//! Time and memory by the number of triangles.

use curvetri::mesh::write_obj;
use curvetri_bodies::bumpy_torus;
use serde_json::Value;

use super::{Result, curvetri, machine, number};

const HEAD: &str = "# Time and memory by size

A bumpy torus, stored as an OBJ file with normals, is read, curved, built and rendered (800 x 600 pixels, 4
rays per pixel). *Peak* is the most memory that the process ever had, with the text of the file. This
command writes the tables:

```sh
cargo run --release --bin tables -- sizes
```

";

/// The tables, for 0.1, 1 and 10 million triangles where none are named.
pub fn table(sizes: &[&str]) -> Result<String> {
    let sizes: Vec<usize> = match sizes {
        [] => vec![100_000, 1_000_000, 10_000_000],
        _ => sizes
            .iter()
            .map(|n| n.parse())
            .collect::<std::result::Result<_, _>>()?,
    };
    let folder = tempfile::tempdir()?;
    let mut runs = Vec::new();
    for size in sizes {
        let file = folder.path().join("torus.obj");
        write_obj(&bumpy_torus(size), &file)?;
        let length = std::fs::metadata(&file)?.len();
        let (file, picture) = (file.to_string_lossy(), folder.path().join("torus.png"));
        let picture = picture.to_string_lossy();
        let args = ["render", "--quiet", "--json", "--samples", "4", "-o"];
        let stats = curvetri(&[&args[..], &[&picture, &file]].concat())??;
        runs.push((length, stats));
    }
    let machine = runs.last().map(|(_, stats)| machine(stats));
    Ok(format!(
        "{HEAD}{}\n\n## Time\n\n{}\n## Memory\n\n{}",
        machine.unwrap_or_default(),
        times(&runs),
        memory(&runs)
    ))
}

fn triangles(stats: &Value) -> f64 {
    number(&stats["triangles"]["total"])
}

fn times(runs: &[(u64, Value)]) -> String {
    let mut text =
        "| triangles | load | curve | build | render | load, curve and build, per triangle | \
                    render |\n|--:|--:|--:|--:|--:|--:|--:|\n"
            .to_owned();
    for (_, stats) in runs {
        let [load, curve, build, render] =
            ["load", "curve", "build", "render"].map(|name| number(&stats["seconds"][name]));
        text += &format!(
            "| {} | {load:.2} s | {curve:.2} s | {build:.2} s | {render:.2} s | {:.0} ns | {:.2} Mray/s |\n",
            triangles(stats),
            1e9 * (load + curve + build) / triangles(stats),
            number(&stats["mray_per_second"]),
        );
    }
    text
}

fn memory(runs: &[(u64, Value)]) -> String {
    let mut text =
        "| triangles | file | mesh | packed patches | Embree's tree | all three | peak |\n\
                    |--:|--:|--:|--:|--:|--:|--:|\n"
            .to_owned();
    for (length, stats) in runs {
        let bytes = |name: &str| number(&stats["bytes"][name]);
        let count = triangles(stats);
        let cell = |bytes: f64| format!("{:.1} MB ({:.0} B each)", 1e-6 * bytes, bytes / count);
        let [mesh, records, tree] = ["mesh", "records", "embree"].map(bytes);
        let cells = [
            *length as f64,
            mesh,
            records,
            tree,
            mesh + records + tree,
            bytes("peak"),
        ];
        text += &format!("| {count} | {} |\n", cells.map(cell).join(" | "));
    }
    text
}
