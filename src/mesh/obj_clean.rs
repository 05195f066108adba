//! Feeds tobj the lines of an OBJ file that make its surface, checked.

use std::fmt::Write;
use std::io::{BufRead, Read};

use super::MeshError;
use super::error::{Fault, MAX_INDICES};
use super::obj_text::{Line, Lines};
use super::text::is_written_nan;

/// The normal of corners that have none: it stands behind the file's own normals, none of which
/// reaches tobj as NaN.
const NO_NORMAL_LINE: &str = "vn NaN NaN NaN\n";

/// How many material libraries are looked for: so many are only named in files made to be slow.
const MAX_LIBRARIES: usize = 64;

/// How many vertices or normals there are.
#[derive(Clone, Copy, Default)]
struct Count {
    vertices: u64,
    normals: u64,
}

/// A reader that hands out one clean line after the other.
pub(super) struct Cleaner<'a> {
    lines: Lines<'a>,
    /// Of the whole file.
    total: Count,
    /// Up to the present line.
    so_far: Count,
    /// The present line for tobj, and how much of it tobj has taken.
    clean: String,
    taken: usize,
    ended: bool,
    indices: u64,
    /// The number of the present line in the file, from 1.
    pub(super) line_number: usize,
    /// Why the last read failed.
    pub(super) fault: Option<Fault>,
    /// Faces of three corners or more.
    pub(super) polygons: u64,
    /// Elements that are no surface.
    pub(super) skipped: u64,
    /// The material libraries named, the first of them.
    pub(super) libraries: Vec<String>,
    /// Lines with others.
    pub(super) more_libraries: u64,
}

impl<'a> Cleaner<'a> {
    pub(super) fn new(text: &'a str) -> Cleaner<'a> {
        let mut total = Count::default();
        for line in Lines::new(text) {
            match line.keyword {
                "v" => total.vertices += 1,
                "vn" => total.normals += 1,
                _ => {}
            }
        }
        Cleaner {
            lines: Lines::new(text),
            total,
            so_far: Count::default(),
            clean: String::new(),
            taken: 0,
            ended: false,
            indices: 0,
            line_number: 0,
            fault: None,
            polygons: 0,
            skipped: 0,
            libraries: Vec::new(),
            more_libraries: 0,
        }
    }

    /// Puts the next clean line up; an empty one at the end.
    fn advance(&mut self) -> Result<(), Fault> {
        self.clean.clear();
        self.taken = 0;
        while self.clean.is_empty() && !self.ended {
            let Some(line) = self.lines.next() else {
                self.ended = true;
                if self.total.normals > 0 {
                    self.clean.push_str(NO_NORMAL_LINE);
                }
                break;
            };
            self.line_number = line.number;
            self.take_up(&line)?;
        }
        Ok(())
    }

    fn take_up(&mut self, line: &Line<'_>) -> Result<(), Fault> {
        match line.keyword {
            "v" => self.vertex(line),
            "vn" => self.normal(line),
            "f" | "fo" => self.face(line),
            "l" | "p" | "curv" | "curv2" | "surf" => {
                self.skipped += 1;
                Ok(())
            }
            "mtllib" => {
                self.library(line.rest.trim());
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn library(&mut self, name: &str) {
        if name.is_empty() || self.libraries.iter().any(|known| known == name) {
            return;
        }
        if self.libraries.len() < MAX_LIBRARIES {
            self.libraries.push(name.to_owned());
        } else {
            self.more_libraries += 1;
        }
    }

    /// Three coordinates; a fourth number divides them, and more are a colour.
    fn vertex(&mut self, line: &Line<'_>) -> Result<(), Fault> {
        let number = self.so_far.vertices + 1;
        self.so_far.vertices += 1;
        let count = line.words().count();
        if count < 3 {
            return Err(self.wrong(format!(
                "vertex {number} has {count} coordinates instead of 3"
            )));
        }
        self.clean.push('v');
        for word in line.words().take(if count == 4 { 4 } else { 3 }) {
            let value: f64 = word
                .parse()
                .map_err(|_| self.wrong(format!("vertex {number}: {word:?} is not a number")))?;
            if !value.is_finite() {
                return Err(self.wrong(format!(
                    "vertex {number} is not finite: {}",
                    line.rest.trim()
                )));
            }
            self.clean.push(' ');
            self.clean.push_str(word);
        }
        self.clean.push('\n');
        Ok(())
    }

    /// Three coordinates; what is not finite becomes zero, which is made anew later.
    fn normal(&mut self, line: &Line<'_>) -> Result<(), Fault> {
        let number = self.so_far.normals + 1;
        self.so_far.normals += 1;
        let count = line.words().count();
        if count < 3 {
            return Err(self.wrong(format!(
                "normal {number} has {count} coordinates instead of 3"
            )));
        }
        let mut usable = true;
        for word in line.words().take(3) {
            match word.parse::<f64>() {
                Ok(value) => usable &= value.is_finite(),
                Err(_) if is_written_nan(word) => usable = false,
                Err(_) => {
                    let what = format!("normal {number}: {word:?} is not a number");
                    return Err(self.wrong(what));
                }
            }
        }
        self.clean.push_str("vn");
        for word in line.words().take(3) {
            self.clean.push(' ');
            self.clean.push_str(if usable { word } else { "0" });
        }
        self.clean.push('\n');
        Ok(())
    }

    /// Corners of a vertex and perhaps a normal; texture coordinates are left out.
    fn face(&mut self, line: &Line<'_>) -> Result<(), Fault> {
        let corners = line.words().count();
        if corners < 3 {
            self.skipped += 1;
            return Ok(());
        }
        self.polygons += 1;
        self.indices += 3 * (corners as u64 - 2);
        if self.indices > MAX_INDICES {
            let indices = self.indices;
            return Err(Fault::Mesh(MeshError::TooManyIndices { indices }));
        }
        self.clean.push('f');
        for word in line.words() {
            let mut parts = word.split('/');
            let vertex = parts.next().unwrap_or_default();
            let normal = parts.nth(1).unwrap_or_default();
            if parts.next().is_some() {
                return Err(self.face_fault(word, "has more than three parts"));
            }
            let vertex = self.index(vertex, word, "vertex")?;
            let normal = match normal {
                "" => self.total.normals + 1,
                normal => self.index(normal, word, "normal")?,
            };
            let written = if self.total.normals > 0 {
                write!(self.clean, " {vertex}//{normal}")
            } else {
                write!(self.clean, " {vertex}")
            };
            written.expect("writing to a string does not fail");
        }
        self.clean.push('\n');
        Ok(())
    }

    /// An index into vertices or normals, checked and counted from 1.
    fn index(&self, text: &str, word: &str, what: &str) -> Result<u64, Fault> {
        let (so_far, total) = match what {
            "vertex" => (self.so_far.vertices, self.total.vertices),
            _ => (self.so_far.normals, self.total.normals),
        };
        let index: i64 = text
            .parse()
            .map_err(|_| self.face_fault(word, "is not made of whole numbers"))?;
        let absolute = if index < 0 {
            // Counted back from the last one read, which is -1.
            (so_far + 1).checked_sub(index.unsigned_abs())
        } else {
            Some(index.unsigned_abs())
        };
        match absolute {
            Some(absolute) if (1..=total).contains(&absolute) => Ok(absolute),
            _ => Err(self.face_fault(
                word,
                &format!("names {what} {index}, but the file has {total} (1 is the first)"),
            )),
        }
    }

    /// The present line is wrong.
    fn wrong(&self, what: String) -> Fault {
        Fault::Line(self.line_number, what)
    }

    fn face_fault(&self, word: &str, what: &str) -> Fault {
        self.wrong(format!("face {}: corner {word:?} {what}", self.polygons))
    }
}

impl BufRead for Cleaner<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.taken == self.clean.len()
            && let Err(fault) = self.advance()
        {
            self.fault = Some(fault);
            return Err(std::io::ErrorKind::InvalidData.into());
        }
        Ok(&self.clean.as_bytes()[self.taken..])
    }

    fn consume(&mut self, amount: usize) {
        self.taken += amount;
    }
}

impl Read for Cleaner<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}
