//! Writes the corpus the fuzzers start from: `cargo run -p curvetri-fuzz-seeds FOLDER` makes a folder in
//! it for each target of `fuzz/`.

mod rays;

use std::path::Path;

use curvetri_fuzz_seeds as seeds;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os().nth(1);
    let folder = folder.ok_or("usage: fuzz_seeds FOLDER")?;
    let write = |target: &str, name: &str, bytes: &[u8]| {
        let folder = Path::new(&folder).join(target);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(name), bytes)
    };
    for seed in seeds::all() {
        let (target, name) = (seed.format, &*seed.name);
        write(target, name, &seed.bytes)?;
        // The target for packed files packs what starts with 0, and takes what starts with 1.
        let packed = [&[1], &*seeds::packed(&seed.bytes)].concat();
        write("gz", &format!("{target} {name}, packed"), &packed)?;
        let plain = [&[0], &*seed.bytes].concat();
        write("gz", &format!("{target} {name}"), &plain)?;
    }
    for (name, bytes) in rays::all() {
        write("rays", &name, &bytes)?;
    }
    Ok(())
}
