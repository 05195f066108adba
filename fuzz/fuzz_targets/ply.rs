#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|file: &[u8]| curvetri_fuzz::load(file, |file| file.starts_with(b"ply")));
