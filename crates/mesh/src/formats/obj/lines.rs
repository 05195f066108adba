//! The logical lines of an OBJ file.

use crate::formats::text;

/// A line of the file, with the lines it continues on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line<'a> {
    /// The number of its first line in the file, from 1.
    pub(super) number: usize,
    /// The first word.
    pub(super) keyword: &'a str,
    /// What follows, up to a comment; with the backslashes and line ends of continuations.
    pub(super) rest: &'a str,
}

impl<'a> Line<'a> {
    /// The words after the keyword, continuations joined.
    pub(super) fn words(&self) -> impl Iterator<Item = &'a str> + Clone + use<'a> {
        self.rest
            .split(|c: char| c.is_ascii_whitespace() || c == '\\')
            .filter(|word| !word.is_empty())
    }
}

/// The logical lines of a text, without blank ones and comments.
pub(super) struct Lines<'a> {
    physical: text::Lines<'a>,
}

/// Cuts a text into chunks of at least so many bytes (the last may be shorter), after lines that no
/// other continues.
pub(super) fn chunks(text: &str, size: usize) -> Vec<&str> {
    let mut chunks = Vec::new();
    let mut left = text;
    while left.len() > size {
        let chunk = chunk_length(left.as_bytes(), size);
        // Line ends are characters of one byte.
        let (chunk, rest) = left.split_at(chunk);
        chunks.push(chunk);
        left = rest;
    }
    if !left.is_empty() {
        chunks.push(left);
    }
    chunks
}

/// The length up to the first line end at or behind `size` whose line no other continues.
fn chunk_length(bytes: &[u8], size: usize) -> usize {
    // Both bytes of a line end stay in one chunk.
    let mut start = size - usize::from(size > 0 && bytes[size - 1..].starts_with(b"\r\n"));
    while start < bytes.len() {
        let (length, end) = text::first_line(&bytes[start..]);
        let line = trim_blanks(&bytes[..start + length]);
        start += length + end;
        if !line.ends_with(b"\\") {
            return start;
        }
    }
    bytes.len()
}

/// Without blanks at the end, but no further than to the end of the line before.
fn trim_blanks(mut line: &[u8]) -> &[u8] {
    while let Some((last, rest)) = line.split_last()
        && last.is_ascii_whitespace()
        && !b"\n\r".contains(last)
    {
        line = rest;
    }
    line
}

impl<'a> Lines<'a> {
    /// The lines of a text or a chunk of it, before which there are so many.
    pub(super) fn new(text: &'a str, before: usize) -> Lines<'a> {
        Lines {
            physical: text::Lines::new(text, before),
        }
    }

    /// The number of the last physical line there has been.
    pub(super) fn number(&self) -> usize {
        self.physical.number()
    }
}

/// Keywords whose lines go on where they end in a backslash. Others do not: names may be paths that
/// end in one.
fn may_continue(keyword: &str) -> bool {
    matches!(
        keyword,
        "v" | "vn"
            | "vt"
            | "vp"
            | "f"
            | "fo"
            | "l"
            | "p"
            | "curv"
            | "curv2"
            | "surf"
            | "parm"
            | "trim"
            | "hole"
            | "scrv"
            | "sp"
            | "con"
            | "bmat"
            | "deg"
            | "step"
    )
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let text = self.physical.left();
            let first = self.physical.next()?;
            let number = self.number();
            let trimmed = first.trim_start();
            let length = trimmed
                .find(|c: char| c.is_ascii_whitespace())
                .unwrap_or(trimmed.len());
            let keyword = &trimmed[..length];
            if keyword.is_empty() || keyword.starts_with('#') {
                continue;
            }
            let mut end = first.len();
            let mut last = first;
            if may_continue(keyword) {
                while is_continued(last) {
                    let Some(more) = self.physical.next() else {
                        break;
                    };
                    end = text.len() - self.physical.left().len();
                    last = more;
                }
            }
            let start = first.len() - trimmed.len() + length;
            let rest = &text[start..end];
            let rest = comment_start(rest).map_or(rest, |at| &rest[..at]);
            return Some(Line {
                number,
                keyword,
                rest,
            });
        }
    }
}

/// Whether a line ends in a backslash that no comment swallows.
fn is_continued(line: &str) -> bool {
    trim_blanks(line.as_bytes()).ends_with(b"\\") && comment_start(line).is_none()
}

/// Where a word starts with `#`. Within words it is none: `1.#QNAN` is what some programs write.
fn comment_start(line: &str) -> Option<usize> {
    line.match_indices('#')
        .map(|(at, _)| at)
        .find(|&at| line[..at].ends_with(|c: char| c.is_ascii_whitespace()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(usize, &str, Vec<&str>)> {
        Lines::new(text, 0)
            .map(|l| (l.number, l.keyword, l.words().collect()))
            .collect()
    }

    #[test]
    fn continuations_join_and_comments_go() {
        let text = "# head \\\nv 1 2 \\\r\n 3 # not 4\n\n  f\t1 2\\\n3 \\\r4\r\n#f 1\nv 7";
        assert_eq!(
            lines(text),
            [
                (2, "v", vec!["1", "2", "3"]),
                (5, "f", vec!["1", "2", "3", "4"]),
                (9, "v", vec!["7"]),
            ]
        );
    }

    #[test]
    fn chunks_are_whole_lines_with_what_continues_them() {
        let text = "v 1 2 \\\n3\rv 4\n\r\nf 1 \\ \r\n2\n\\\n\nend";
        for size in 0..text.len() + 2 {
            let parts = chunks(text, size);
            assert_eq!(parts.concat(), text);
            let mut before = 0;
            let mut all = Vec::new();
            for part in &parts {
                let mut of_part = Lines::new(part, before);
                all.extend(
                    of_part
                        .by_ref()
                        .map(|l| (l.number, l.keyword, l.words().collect())),
                );
                before = of_part.number();
            }
            assert_eq!(all, lines(text), "{size}");
        }
        assert_eq!(chunks(text, 0).len(), 6);
        assert_eq!(chunks("", 0), [] as [&str; 0]);
    }

    #[test]
    fn names_that_end_in_a_backslash_do_not_swallow_the_next_line() {
        let text = "mtllib C:\\models\\\nv 1 2 3\n";
        assert_eq!(lines(text)[1], (2, "v", vec!["1", "2", "3"]));
    }

    #[test]
    fn a_backslash_at_the_end_of_the_text_is_nothing() {
        assert_eq!(lines("f 1 2 3 \\"), [(1, "f", vec!["1", "2", "3"])]);
    }

    #[test]
    fn any_line_end_ends_a_line() {
        assert_eq!(
            lines("# head\rv 1\nv 2\r\nv 3\r\rv 4"),
            [
                (2, "v", vec!["1"]),
                (3, "v", vec!["2"]),
                (4, "v", vec!["3"]),
                (6, "v", vec!["4"])
            ]
        );
    }
}
