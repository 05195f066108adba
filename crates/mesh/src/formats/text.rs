//! Text files: decoded, cut into lines and numbers.

/// Whether the bytes start with UTF-16's byte order mark.
pub(super) fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff")
}

/// The file's text: UTF-16 where it starts with its byte order mark, else UTF-8, and where that
/// fails Latin-1, which always succeeds.
pub(super) fn decode(mut bytes: Vec<u8>) -> String {
    if is_utf16(&bytes) {
        let unit = match bytes[0] {
            0xff => u16::from_le_bytes,
            _ => u16::from_be_bytes,
        };
        let (pairs, _) = bytes[2..].as_chunks::<2>();
        let units = pairs.iter().map(|&pair| unit(pair));
        return char::decode_utf16(units)
            .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect();
    }
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().iter().map(|&b| char::from(b)).collect())
}

/// The lines of a text with their numbers from 1, without their ends. Line feeds end lines, or
/// carriage returns where there is no line feed at all.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let end = if text.as_bytes().contains(&b'\n') {
        '\n'
    } else {
        '\r'
    };
    (1..).zip(text.split_terminator(end).map(str::trim_end))
}

/// A number as programs write it; NaN for all they write in place of one.
pub(super) fn number(word: &str) -> Option<f64> {
    match word.parse() {
        Ok(value) => Some(value),
        Err(_) => is_written_nan(word).then_some(f64::NAN),
    }
}

/// Not-a-number and infinity as C libraries write them.
pub(super) fn is_written_nan(word: &str) -> bool {
    let word = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    word.starts_with("nan") || word.starts_with("inf") || word.starts_with("1.#")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf16_latin1_and_marked_utf8_decode() {
        let text = "v 1 # ü";
        let le: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let be: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        assert_eq!(decode([b"\xff\xfe".to_vec(), le].concat()), text);
        assert_eq!(decode([b"\xfe\xff".to_vec(), be].concat()), text);
        assert_eq!(
            decode([b"\xef\xbb\xbf".to_vec(), text.into()].concat()),
            text
        );
        assert_eq!(decode(b"v 1 # \xfc".to_vec()), text);
    }

    #[test]
    fn lines_are_numbered_whatever_ends_them() {
        let of = |text| lines(text).collect::<Vec<_>>();
        assert_eq!(of("a\r\n\nb\n"), [(1, "a"), (2, ""), (3, "b")]);
        assert_eq!(of("a\rb"), [(1, "a"), (2, "b")]);
        assert_eq!(of(""), []);
    }

    #[test]
    fn numbers_are_read_as_programs_write_them() {
        assert_eq!(number("1."), Some(1.0));
        assert_eq!(number("-.5e-3"), Some(-0.5e-3));
        assert!(number("-1.#IND").unwrap().is_nan());
        assert!(number("-nan(ind)").unwrap().is_nan());
        assert_eq!(number("1,5"), None);
        assert_eq!(number("x"), None);
    }
}
