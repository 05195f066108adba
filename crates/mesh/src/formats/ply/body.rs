//! The numbers after the header of a PLY file.

use ply_rs_bw::ply::ScalarType;

use crate::error::Fault;
use crate::formats::text::{lines, number};

/// Hands out the numbers of one element after the other.
pub(super) trait Body {
    /// Starts an element.
    fn begin(&mut self) -> Result<(), String>;

    /// The next number of the element. Single precision and whole numbers of up to 32 bits fit into
    /// it exactly.
    fn number(&mut self, scalar: &ScalarType) -> Result<f64, String>;

    /// Ends an element.
    fn end(&mut self) -> Result<(), String>;

    /// The fault for what is wrong with an element.
    fn fault(&self, element: &str, number: usize, what: String) -> Fault;
}

/// The body of a text file: one line an element, blank lines left out.
pub(super) struct Text<'a> {
    lines: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    words: std::str::SplitAsciiWhitespace<'a>,
    /// Lines of the header.
    before: usize,
    /// The present line, from 1.
    line: usize,
}

impl<'a> Text<'a> {
    /// The text after a header of so many lines.
    pub(super) fn new(text: &'a str, before: usize) -> Text<'a> {
        Text {
            lines: Box::new(lines(text)),
            words: "".split_ascii_whitespace(),
            before,
            line: before,
        }
    }
}

impl Body for Text<'_> {
    fn begin(&mut self) -> Result<(), String> {
        for (number, line) in self.lines.by_ref() {
            self.line = self.before + number;
            if !line.trim_ascii().is_empty() {
                self.words = line.split_ascii_whitespace();
                return Ok(());
            }
        }
        Err("the file ends before it".into())
    }

    fn number(&mut self, _: &ScalarType) -> Result<f64, String> {
        let word = self.words.next();
        let word = word.ok_or("its line has fewer values than the header declares")?;
        number(word).ok_or_else(|| format!("{word:?} is not a number"))
    }

    fn end(&mut self) -> Result<(), String> {
        match self.words.next() {
            None => Ok(()),
            Some(_) => Err("its line has more values than the header declares".into()),
        }
    }

    fn fault(&self, element: &str, number: usize, what: String) -> Fault {
        Fault::Line(self.line, format!("{element} {number}: {what}"))
    }
}

/// The body of a binary file.
pub(super) struct Binary<'a> {
    left: &'a [u8],
    big_endian: bool,
}

impl<'a> Binary<'a> {
    pub(super) fn little_endian(left: &'a [u8]) -> Binary<'a> {
        let big_endian = false;
        Binary { left, big_endian }
    }

    pub(super) fn big_endian(left: &'a [u8]) -> Binary<'a> {
        let big_endian = true;
        Binary { left, big_endian }
    }

    /// The next bytes, the least significant first.
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, left) = self.left.split_first_chunk()?;
        self.left = left;
        let mut bytes = *bytes;
        if self.big_endian {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn read(&mut self, scalar: &ScalarType) -> Option<f64> {
        Some(match scalar {
            ScalarType::Char => i8::from_le_bytes(self.take()?).into(),
            ScalarType::UChar => u8::from_le_bytes(self.take()?).into(),
            ScalarType::Short => i16::from_le_bytes(self.take()?).into(),
            ScalarType::UShort => u16::from_le_bytes(self.take()?).into(),
            ScalarType::Int => i32::from_le_bytes(self.take()?).into(),
            ScalarType::UInt => u32::from_le_bytes(self.take()?).into(),
            ScalarType::Float => f32::from_le_bytes(self.take()?).into(),
            ScalarType::Double => f64::from_le_bytes(self.take()?),
        })
    }
}

impl Body for Binary<'_> {
    fn begin(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn number(&mut self, scalar: &ScalarType) -> Result<f64, String> {
        self.read(scalar)
            .ok_or_else(|| "the file ends in it".into())
    }

    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn fault(&self, element: &str, number: usize, what: String) -> Fault {
        Fault::Content(format!("{element} {number}: {what}"))
    }
}
