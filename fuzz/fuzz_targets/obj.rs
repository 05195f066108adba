#![no_main]

use libfuzzer_sys::fuzz_target;

/// Starts of other formats.
const OTHERS: [&[u8]; 6] = [b"glTF", b"\x1f\x8b", b"ply", b"solid", b"OFF", b"{"];

fuzz_target!(|file: &[u8]| {
    let is_other = |file: &[u8]| OTHERS.iter().any(|start| file.starts_with(start));
    curvetri_fuzz::load(file, |file| !is_other(file));
});
