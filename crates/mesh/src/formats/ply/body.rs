//! The numbers after the header of a PLY file.

use ply_rs_bw::ply::ScalarType;

use crate::error::Fault;
use crate::formats::text::{Lines, Words, number};

/// Hands out the numbers of one element after the other.
pub(super) trait Body {
    /// Starts an element.
    fn begin(&mut self) -> Result<(), String>;

    /// The next number of the element. Single precision and whole numbers of up to 32 bits fit into
    /// it exactly.
    fn number(&mut self, scalar: &ScalarType) -> Result<f64, String>;

    /// Ends an element.
    fn end(&mut self) -> Result<(), String>;

    /// Ends the body. Returns a sentence on what follows it, if anything does.
    ///
    /// # Errors
    ///
    /// If what follows shows that the elements have not been read as they are meant.
    fn finish(&mut self) -> Result<Option<String>, Fault>;

    /// The fault for what is wrong with an element.
    fn fault(&self, element: &str, number: usize, what: String) -> Fault;
}

/// The body of a text file. Where it has as many lines as elements, each line is one, and blank
/// lines are left out. Otherwise any white space separates numbers.
pub(super) struct Text<'a> {
    words: Words<'a>,
    by_line: bool,
    /// The number of the last element's line and of the first element's that does not end where its
    /// line does.
    line: usize,
    first_within_line: Option<usize>,
}

impl<'a> Text<'a> {
    /// The text of so many elements after a header of so many lines.
    pub(super) fn new(text: &'a str, before: usize, elements: usize) -> Text<'a> {
        let words = Words::new(Lines::new(text, before), None);
        let mut lines = words.clone();
        let count = std::iter::from_fn(|| lines.next_line_with_words().then_some(())).count();
        Text {
            words,
            by_line: count == elements,
            line: before,
            first_within_line: None,
        }
    }
}

impl Body for Text<'_> {
    fn begin(&mut self) -> Result<(), String> {
        let is_there = if self.words.rest_of_line().next().is_some() {
            // Where each line is one, the last has been read whole.
            self.first_within_line.get_or_insert(self.line);
            true
        } else {
            self.words.next_line_with_words()
        };
        self.line = self.words.line_number();
        if !is_there {
            return Err("the file ends before it".into());
        }
        Ok(())
    }

    fn number(&mut self, _: &ScalarType) -> Result<f64, String> {
        let word = if self.by_line {
            let word = self.words.next_in_line();
            word.ok_or("its line has fewer values than the header declares")?
        } else {
            self.words.next().ok_or("the file ends in it")?
        };
        self.line = self.words.line_number();
        number(word).ok_or_else(|| format!("{word:?} is not a number"))
    }

    fn end(&mut self) -> Result<(), String> {
        if self.by_line && self.words.next_in_line().is_some() {
            return Err(MORE.into());
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Option<String>, Fault> {
        let is_within_line = self.words.rest_of_line().next().is_some();
        if !is_within_line && !self.words.next_line_with_words() {
            return Ok(None);
        }
        if let Some(line) = self.first_within_line {
            return Err(Fault::Line(
                line,
                format!("an element ends here, but {MORE}"),
            ));
        }
        if is_within_line {
            return Err(Fault::Line(
                self.line,
                format!("the last element ends here, but {MORE}"),
            ));
        }
        Ok(Some(format!(
            "the file goes on behind its last element, in line {}; that was not read",
            self.words.line_number()
        )))
    }

    fn fault(&self, element: &str, number: usize, what: String) -> Fault {
        let mut what = format!("{element} {number}: {what}");
        if let Some(line) = self.first_within_line {
            what += &format!("; or in line {line} {MORE}");
        }
        Fault::Line(self.line, what)
    }
}

/// What is wrong with a line.
const MORE: &str = "its line has more values than the header declares";

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

    fn finish(&mut self) -> Result<Option<String>, Fault> {
        Ok(None)
    }

    fn fault(&self, element: &str, number: usize, what: String) -> Fault {
        Fault::Content(format!("{element} {number}: {what}"))
    }
}
