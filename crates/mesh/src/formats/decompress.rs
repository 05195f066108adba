//! Files that are compressed by gzip.

use std::io::Read;

use flate2::read::MultiGzDecoder;

use crate::error::Fault;

/// How many times longer than packed a file may get, so that a small file cannot fill the memory.
/// Meshes shrink to a third or a tenth.
const MAX_EXPANSION: u64 = 100;

/// What any file may unpack to.
const MIN_LIMIT: u64 = 1 << 24;

/// Unpacks gzip files; others stay as they are.
pub(super) fn gunzip(bytes: Vec<u8>) -> Result<Vec<u8>, Fault> {
    if !bytes.starts_with(b"\x1f\x8b") {
        return Ok(bytes);
    }
    let limit = (MAX_EXPANSION * bytes.len() as u64).max(MIN_LIMIT);
    let mut unpacked = Vec::new();
    let read = MultiGzDecoder::new(&*bytes)
        .take(limit + 1)
        .read_to_end(&mut unpacked);
    match read {
        Err(error) => Err(Fault::Caused {
            line: None,
            what: "the gzip file does not unpack".into(),
            source: error.into(),
        }),
        Ok(length) if length as u64 > limit => Err(Fault::Content(format!(
            "the gzip file unpacks to more than {MAX_EXPANSION} times its size; unpack it first"
        ))),
        Ok(_) => Ok(unpacked),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;
    use crate::error::chain;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn unpacked(bytes: Vec<u8>) -> Result<Vec<u8>, String> {
        gunzip(bytes).map_err(|fault| chain(&fault.of("x.gz".as_ref())))
    }

    #[test]
    fn gzip_is_unpacked_and_all_else_stays() {
        assert_eq!(unpacked(packed(b"v 0 0 0")), Ok(b"v 0 0 0".to_vec()));
        let two = [packed(b"v 0"), packed(b" 0 0")].concat();
        assert_eq!(unpacked(two), Ok(b"v 0 0 0".to_vec()));
        assert_eq!(unpacked(b"v 0 0 0".to_vec()), Ok(b"v 0 0 0".to_vec()));
    }

    #[test]
    fn broken_gzip_is_refused() {
        let mut cut = packed(b"v 0 0 0");
        cut.truncate(15);
        let error = unpacked(cut).unwrap_err();
        assert!(
            error.starts_with("x.gz: the gzip file does not unpack: "),
            "{error}"
        );
    }

    #[test]
    fn what_unpacks_to_far_too_much_is_refused() {
        let error = unpacked(packed(&vec![0; 1 << 25])).unwrap_err();
        assert_eq!(
            error,
            "x.gz: the gzip file unpacks to more than 100 times its size; unpack it first"
        );
    }
}
