#![no_main]

use std::io::{BufReader, Read};

use flate2::Compression;
use flate2::read::{GzEncoder, MultiGzDecoder};
use libfuzzer_sys::fuzz_target;

/// Above what the loader unpacks of a file as small as these.
const MOST: u64 = 1 << 25;

// The first byte says whether the rest is a packed file, or is to be packed: a damaged one hardly
// ever unpacks.
fuzz_target!(|data: &[u8]| {
    let Some((&how, rest)) = data.split_first() else {
        return;
    };
    if how % 2 == 0 {
        let mut packed = Vec::new();
        let mut encoder = GzEncoder::new(rest, Compression::fast());
        encoder
            .read_to_end(&mut packed)
            .expect("memory has no faults");
        curvetri_fuzz::load_within(&packed, rest.len());
    } else if rest.starts_with(b"\x1f\x8b") {
        let decoder = BufReader::new(MultiGzDecoder::new(rest).take(MOST));
        // What stands before a fault is unpacked as well.
        let length = decoder.bytes().take_while(Result::is_ok).count();
        curvetri_fuzz::load_within(rest, length.max(rest.len()));
    }
});
