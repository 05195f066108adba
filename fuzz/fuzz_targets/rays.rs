#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| curvetri_fuzz::cast_rays(data));
