//! The logical lines of an OBJ file.

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
    left: &'a str,
    number: usize,
    line_end: u8,
}

/// What ends a text's lines: line feeds, or carriage returns where there is no line feed at all.
pub(super) fn line_end(text: &str) -> u8 {
    if text.as_bytes().contains(&b'\n') {
        b'\n'
    } else {
        b'\r'
    }
}

/// Cuts a text into chunks of at least so many bytes (the last may be shorter), after lines that no
/// other continues.
pub(super) fn chunks(text: &str, line_end: u8, size: usize) -> Vec<&str> {
    let mut chunks = Vec::new();
    let mut left = text;
    while left.len() > size {
        let bytes = left.as_bytes();
        let mut ends = (size..bytes.len()).filter(|&at| bytes[at] == line_end);
        let Some(end) = ends.find(|&at| !bytes[..at].trim_ascii_end().ends_with(b"\\")) else {
            break;
        };
        // Line ends are characters of one byte.
        let (chunk, rest) = left.split_at(end + 1);
        chunks.push(chunk);
        left = rest;
    }
    if !left.is_empty() {
        chunks.push(left);
    }
    chunks
}

impl<'a> Lines<'a> {
    /// The lines of a text or a chunk of it, before which there are so many.
    pub(super) fn new(text: &'a str, line_end: u8, before: usize) -> Lines<'a> {
        Lines {
            left: text,
            number: before,
            line_end,
        }
    }

    /// The number of the last physical line there has been.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// The next physical line, without its end.
    fn physical(&mut self) -> Option<&'a str> {
        if self.left.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.left.find(char::from(self.line_end));
        let (line, left) = match end {
            Some(end) => (&self.left[..end], &self.left[end + 1..]),
            None => (self.left, ""),
        };
        self.left = left;
        Some(line)
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
            let from = self.left;
            let first = self.physical()?;
            let number = self.number;
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
                    let Some(more) = self.physical() else { break };
                    end += 1 + more.len();
                    last = more;
                }
            }
            let start = first.len() - trimmed.len() + length;
            let rest = &from[start..end];
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
    line.trim_end().ends_with('\\') && comment_start(line).is_none()
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
        Lines::new(text, line_end(text), 0)
            .map(|l| (l.number, l.keyword, l.words().collect()))
            .collect()
    }

    #[test]
    fn continuations_join_and_comments_go() {
        let text = "# head \\\nv 1 2 \\\r\n 3 # not 4\n\n  f\t1 2\\\n3 \\\n4\r\n#f 1\nv 7";
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
        let text = "v 1 2 \\\n3\nv 4\n\nf 1 \\ \r\n2\nend";
        for size in 0..text.len() + 2 {
            let parts = chunks(text, b'\n', size);
            assert_eq!(parts.concat(), text);
            let mut before = 0;
            let mut all = Vec::new();
            for part in &parts {
                let mut of_part = Lines::new(part, b'\n', before);
                all.extend(
                    of_part
                        .by_ref()
                        .map(|l| (l.number, l.keyword, l.words().collect())),
                );
                before = of_part.number();
            }
            assert_eq!(all, lines(text), "{size}");
        }
        assert_eq!(chunks(text, b'\n', 0).len(), 5);
        assert_eq!(chunks("", b'\n', 0), [] as [&str; 0]);
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
    fn carriage_returns_alone_end_lines() {
        assert_eq!(
            lines("v 1\rv 2"),
            [(1, "v", vec!["1"]), (2, "v", vec!["2"])]
        );
    }
}
