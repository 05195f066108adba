//! The seeds of the fuzzers, whole and damaged, through the loaders: no panic, errors that name the
//! file, sound meshes. `fuzz/` looks much further.

use curvetri_bodies::SplitMix;
use curvetri_fuzz_seeds::{self as seeds, Seed};
use curvetri_mesh::{LoadError, Loaded, Loader};

/// How many bytes are changed at once, and how often in each file.
const FLIPS: [usize; 3] = [1, 3, 20];
const TIMES: usize = 100;
/// At how many lengths each file is cut off.
const CUTS: usize = 100;

fn load(bytes: Vec<u8>, format: &str) -> Result<Loaded, LoadError> {
    Loader::new().load_bytes(bytes, format!("seed.{format}"))
}

/// Loads a file in whatever state; whether it could be read.
fn check(bytes: Vec<u8>, format: &str) -> bool {
    match load(bytes, format) {
        Ok(Loaded { mesh, .. }) => {
            assert!(!mesh.triangles().is_empty());
            assert!(mesh.positions().iter().all(|p| p.is_finite()));
            assert!(mesh.normals().iter().all(|n| n.is_normalized()));
            assert_eq!(mesh.positions().len(), mesh.normals().len());
            let mut indices = mesh.triangles().as_flattened().iter();
            assert!(indices.all(|&i| (i as usize) < mesh.positions().len()));
            true
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with(&format!("seed.{format}:")), "{message}");
            false
        }
    }
}

/// Each file as it is and packed.
fn files() -> impl Iterator<Item = Seed> {
    seeds::all().into_iter().flat_map(|seed| {
        let packed = Seed {
            name: format!("{}, packed", seed.name),
            bytes: seeds::packed(&seed.bytes),
            ..seed
        };
        [seed, packed]
    })
}

#[test]
fn whole_seeds_are_read() {
    for Seed {
        format,
        name,
        bytes,
    } in files()
    {
        if let Err(error) = load(bytes, format) {
            panic!("{name}: {error}");
        }
    }
}

#[test]
fn seeds_cut_off_are_read_or_refused() {
    let (mut read, mut refused) = (0, 0);
    for Seed { format, bytes, .. } in files() {
        let step = bytes.len().div_ceil(CUTS);
        for length in (0..bytes.len()).step_by(step) {
            match check(bytes[..length].to_vec(), format) {
                true => read += 1,
                false => refused += 1,
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 100 && refused > 1000, "{read} {refused}");
}

#[test]
fn seeds_with_wrong_bytes_are_read_or_refused() {
    let mut random = SplitMix::new(17);
    let (mut read, mut refused) = (0, 0);
    for Seed { format, bytes, .. } in files() {
        for flips in FLIPS {
            for _ in 0..TIMES {
                let mut wrong = bytes.clone();
                for _ in 0..flips {
                    let at = random.below(wrong.len());
                    // Numbers stay numbers half of the time, and so get further.
                    wrong[at] = match wrong[at] {
                        b'0'..=b'9' if random.below(2) == 0 => b'0' + random.below(10) as u8,
                        _ => random.below(256) as u8,
                    };
                }
                match check(wrong, format) {
                    true => read += 1,
                    false => refused += 1,
                }
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 1000 && refused > 1000, "{read} {refused}");
}
