#![no_main]

use libfuzzer_sys::fuzz_target;

/// Bytes before the facets, and of each.
const HEAD: usize = 84;
const FACET: usize = 50;

// Binary files of whole facets get a header that promises as many, which the fuzzer would hardly
// ever find; all others are taken as they are.
fuzz_target!(|file: &[u8]| {
    let mut file = file.to_vec();
    if !file.starts_with(b"solid")
        && file.len() >= HEAD
        && (file.len() - HEAD).is_multiple_of(FACET)
    {
        let facets = (file.len() - HEAD) / FACET;
        file[HEAD - 4..HEAD].copy_from_slice(&(facets as u32).to_le_bytes());
    }
    curvetri_fuzz::load_within(&file, file.len());
});
