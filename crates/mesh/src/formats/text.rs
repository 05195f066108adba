//! Text files: decoded, cut into lines and numbers.

use memchr::memchr2;

/// How a file's bytes are encoded, by the byte order mark that it starts with.
#[derive(Clone, Copy)]
enum Encoding {
    Utf8,
    Utf16(fn([u8; 2]) -> u16),
    Utf32(fn([u8; 4]) -> u32),
}

/// Byte order marks. That of UTF-32 starts with that of UTF-16.
const MARKS: [(&[u8], Encoding); 5] = [
    (b"\xef\xbb\xbf", Encoding::Utf8),
    (b"\xff\xfe\0\0", Encoding::Utf32(u32::from_le_bytes)),
    (b"\0\0\xfe\xff", Encoding::Utf32(u32::from_be_bytes)),
    (b"\xff\xfe", Encoding::Utf16(u16::from_le_bytes)),
    (b"\xfe\xff", Encoding::Utf16(u16::from_be_bytes)),
];

/// Takes a byte order mark off the start of the bytes; whether there was one. UTF-16 and UTF-32
/// become UTF-8.
pub(super) fn take_mark(bytes: &mut Vec<u8>) -> bool {
    let Some((mark, encoding)) = MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)) else {
        return false;
    };
    let rest = &bytes[mark.len()..];
    let text: String = match encoding {
        Encoding::Utf8 => {
            bytes.drain(..mark.len());
            return true;
        }
        Encoding::Utf16(unit) => {
            let units = rest.as_chunks().0.iter().map(|&bytes| unit(bytes));
            let characters = char::decode_utf16(units);
            let known = characters.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
            known.collect()
        }
        Encoding::Utf32(unit) => {
            let units = rest.as_chunks().0.iter().map(|&bytes| unit(bytes));
            let known = |unit| char::from_u32(unit).unwrap_or(char::REPLACEMENT_CHARACTER);
            units.map(known).collect()
        }
    };
    *bytes = text.into_bytes();
    true
}

/// How many of the bytes are text before what only fills up the end: zeros, and the Ctrl-Z that ends
/// files of DOS, with white space between and behind them.
pub(super) fn length_without_padding(bytes: &[u8]) -> usize {
    let fills = |byte: &u8| b"\0\x1a".contains(byte);
    let is_text = |byte: &u8| !fills(byte) && !byte.is_ascii_whitespace();
    let text = bytes.iter().rposition(is_text).map_or(0, |last| last + 1);
    let padding = bytes[text..].iter().position(fills);
    padding.map_or(bytes.len(), |padding| text + padding)
}

/// The bytes of a text: UTF-8, and where that fails Latin-1, which always succeeds. Zeros at the end
/// are left out.
pub(super) fn decode(mut bytes: Vec<u8>) -> String {
    bytes.truncate(length_without_padding(&bytes));
    String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().iter().map(|&b| char::from(b)).collect())
}

/// The lines of a text, without their ends: line feeds, carriage returns, or both in this order.
#[derive(Clone)]
pub(super) struct Lines<'a> {
    left: &'a str,
    number: usize,
}

impl<'a> Lines<'a> {
    /// The lines of a text before which there are so many.
    pub(super) fn new(text: &'a str, before: usize) -> Lines<'a> {
        Lines {
            left: text,
            number: before,
        }
    }

    /// What is left of the text.
    pub(super) fn left(&self) -> &'a str {
        self.left
    }

    /// The number of the last line there has been, from 1.
    pub(super) fn number(&self) -> usize {
        self.number
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        if self.left.is_empty() {
            return None;
        }
        self.number += 1;
        let (length, end) = first_line(self.left.as_bytes());
        let line = &self.left[..length];
        self.left = &self.left[length + end..];
        Some(line)
    }
}

/// The length of the first line and that of its end, which is 0 where the bytes end in the line.
pub(super) fn first_line(bytes: &[u8]) -> (usize, usize) {
    match memchr2(b'\n', b'\r', bytes) {
        None => (bytes.len(), 0),
        Some(length) if bytes[length..].starts_with(b"\r\n") => (length, 2),
        Some(length) => (length, 1),
    }
}

/// The words of a text, whatever white space is between them, with the numbers of their lines.
#[derive(Clone)]
pub(super) struct Words<'a> {
    lines: Lines<'a>,
    line: std::str::SplitAsciiWhitespace<'a>,
    /// What starts a comment that goes on to the end of the line.
    comment: Option<char>,
}

impl<'a> Words<'a> {
    pub(super) fn new(lines: Lines<'a>, comment: Option<char>) -> Words<'a> {
        Words {
            lines,
            line: "".split_ascii_whitespace(),
            comment,
        }
    }

    /// The next word, of this line or one of the next.
    pub(super) fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.line.next() {
                return Some(word);
            }
            if !self.next_line() {
                return None;
            }
        }
    }

    /// The next word of this line.
    pub(super) fn next_in_line(&mut self) -> Option<&'a str> {
        self.line.next()
    }

    /// The words that are left of this line.
    pub(super) fn rest_of_line(&self) -> std::str::SplitAsciiWhitespace<'a> {
        self.line.clone()
    }

    /// Leaves out the rest of this line and goes to the next that has a word, if there is one.
    pub(super) fn next_line_with_words(&mut self) -> bool {
        while self.next_line() {
            if self.line.clone().next().is_some() {
                return true;
            }
        }
        false
    }

    fn next_line(&mut self) -> bool {
        let Some(line) = self.lines.next() else {
            self.line = "".split_ascii_whitespace();
            return false;
        };
        let comment = self.comment.and_then(|start| line.find(start));
        self.line = line[..comment.unwrap_or(line.len())].split_ascii_whitespace();
        true
    }

    /// The number of the present line, from 1.
    pub(super) fn line_number(&self) -> usize {
        self.lines.number()
    }
}

/// Whether some bytes contain a word, in upper or lower case.
pub(super) fn contains_ignoring_case(bytes: &[u8], word: &str) -> bool {
    let mut windows = bytes.windows(word.len());
    windows.any(|window| window.eq_ignore_ascii_case(word.as_bytes()))
}

/// A number as programs write it; NaN for all they write in place of one.
pub(super) fn number(word: &str) -> Option<f64> {
    match word.parse() {
        Ok(value) => Some(value),
        Err(_) => is_written_nan(word).then_some(f64::NAN),
    }
}

/// Not-a-number and infinity as C libraries write them.
fn is_written_nan(word: &str) -> bool {
    let word = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    word.starts_with("nan") || word.starts_with("inf") || word.starts_with("1.#")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(mut bytes: Vec<u8>) -> String {
        while take_mark(&mut bytes) {}
        decode(bytes)
    }

    #[test]
    fn marked_texts_and_latin1_decode() {
        let text = "v 1 # ü";
        let utf16 = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect();
        let utf32 = |unit: fn(u32) -> [u8; 4]| text.chars().map(u32::from).flat_map(unit).collect();
        let marked = |mark: &[u8], bytes: Vec<u8>| decoded([mark.to_vec(), bytes].concat());
        assert_eq!(marked(b"\xff\xfe", utf16(u16::to_le_bytes)), text);
        assert_eq!(marked(b"\xfe\xff", utf16(u16::to_be_bytes)), text);
        assert_eq!(marked(b"\xff\xfe\0\0", utf32(u32::to_le_bytes)), text);
        assert_eq!(marked(b"\0\0\xfe\xff", utf32(u32::to_be_bytes)), text);
        assert_eq!(marked(b"\xef\xbb\xbf", text.into()), text);
        assert_eq!(marked(b"\xef\xbb\xbf\xef\xbb\xbf", text.into()), text);
        assert_eq!(decoded(b"v 1 # \xfc".to_vec()), text);
        assert_eq!(decoded(b"v 1\x1a\0\0".to_vec()), "v 1");
        assert_eq!(decoded(b"v 1\n\x1a\r\n".to_vec()), "v 1\n");
        assert_eq!(decoded(b"v 1\n \n".to_vec()), "v 1\n \n");
        assert_eq!(decoded(b"\0\x1a".to_vec()), "");
    }

    #[test]
    fn any_line_end_ends_a_line_and_both_together_are_one() {
        let of = |text| {
            let mut lines = Lines::new(text, 3);
            let all: Vec<&str> = lines.by_ref().collect();
            (all, lines.number())
        };
        assert_eq!(of("a\r\n\nb\n"), (vec!["a", "", "b"], 6));
        assert_eq!(of("a\rb\nc"), (vec!["a", "b", "c"], 6));
        assert_eq!(of("\n\r\n\r"), (vec!["", "", ""], 6));
        assert_eq!(of(""), (vec![], 3));
    }

    #[test]
    fn words_know_their_lines() {
        let mut words = Words::new(Lines::new("a b # c\r\n\n# d\re\tf", 0), Some('#'));
        assert_eq!(words.next(), Some("a"));
        assert_eq!(words.rest_of_line().count(), 1);
        assert_eq!((words.next(), words.line_number()), (Some("b"), 1));
        assert_eq!(words.next_in_line(), None);
        assert!(words.next_line_with_words());
        assert_eq!((words.next(), words.line_number()), (Some("e"), 4));
        assert_eq!((words.next(), words.next()), (Some("f"), None));
        assert!(!words.next_line_with_words());
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
