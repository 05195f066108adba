#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|file: &[u8]| {
    curvetri_fuzz::load(file, |file| {
        let word = file.split(u8::is_ascii_whitespace).next();
        word.is_some_and(|word| word.ends_with(b"OFF"))
    });
});
