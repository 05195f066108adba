//! A part of an OBJ file's text, read on its own.

use std::borrow::Cow;

use glam::DVec3;

use super::lines::{Line, Lines};
use crate::error::Fault;
use crate::formats::text::is_written_nan;
use crate::normals::NO_NORMAL;
use crate::polygons::Faces;

/// How many of what a text has.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Count {
    pub(super) vertices: u64,
    pub(super) normals: u64,
    /// Physical lines.
    pub(super) lines: usize,
}

/// What the faces of a part name, and what else is in it. Indices are those of the whole file.
#[derive(Default)]
pub(super) struct Part {
    pub(super) faces: Faces,
    /// The normals of the faces' corners; empty if the file has none at all.
    pub(super) normal_corners: Vec<u32>,
    /// Lines, points and curves.
    pub(super) skipped: u64,
    pub(super) libraries: Libraries,
}

/// How many material libraries are looked for: more are only named in files made to be slow.
const MAX_LIBRARIES: usize = 64;

/// The material libraries named.
#[derive(Default)]
pub(super) struct Libraries {
    /// The first of them.
    pub(super) names: Vec<String>,
    /// Lines that name others.
    pub(super) more: u64,
}

impl Libraries {
    fn add(&mut self, name: &str) {
        if name.is_empty() || self.names.iter().any(|known| known == name) {
            return;
        }
        if self.names.len() < MAX_LIBRARIES {
            self.names.push(name.to_owned());
        } else {
            self.more += 1;
        }
    }

    /// Adds those of a later part.
    pub(super) fn append(&mut self, other: &Libraries) {
        other.names.iter().for_each(|name| self.add(name));
        self.more += other.more;
    }
}

impl Count {
    /// What there is in a part of a text, whose lines end in this byte.
    pub(super) fn of(text: &str, line_end: u8) -> Count {
        let mut count = Count::default();
        let mut lines = Lines::new(text, line_end, 0);
        for line in &mut lines {
            match line.keyword {
                "v" => count.vertices += 1,
                "vn" => count.normals += 1,
                _ => {}
            }
        }
        count.lines = lines.number();
        count
    }

    /// The sum.
    pub(super) fn plus(self, other: Count) -> Count {
        Count {
            vertices: self.vertices + other.vertices,
            normals: self.normals + other.normals,
            lines: self.lines + other.lines,
        }
    }
}

/// A part of a file while it is read.
pub(super) struct Chunk<'a> {
    /// Its lines, numbered as in the file.
    pub(super) lines: Lines<'a>,
    /// Up to the present line.
    pub(super) so_far: Count,
    /// Of the whole file.
    pub(super) total: Count,
    /// Where its vertices and normals go.
    pub(super) positions: &'a mut [DVec3],
    pub(super) normals: &'a mut [DVec3],
}

impl Chunk<'_> {
    /// Reads all its lines, up to the first that is wrong.
    pub(super) fn read(mut self) -> Result<Part, Fault> {
        let mut part = Part::default();
        let (mut positions, mut normals) = (0, 0);
        let mut corners = [Vec::new(), Vec::new()];
        while let Some(line) = self.lines.next() {
            match line.keyword {
                "v" => {
                    self.so_far.vertices += 1;
                    self.positions[positions] = self.vertex(&line)?;
                    positions += 1;
                }
                "vn" => {
                    self.so_far.normals += 1;
                    self.normals[normals] = self.normal(&line)?;
                    normals += 1;
                }
                "f" | "fo" => self.face(&line, &mut corners, &mut part)?,
                "l" | "p" | "curv" | "curv2" | "surf" => part.skipped += 1,
                "mtllib" => part.libraries.add(line.rest.trim()),
                _ => {}
            }
        }
        Ok(part)
    }

    /// Three coordinates; a fourth number divides them, and more are a colour.
    fn vertex(&self, line: &Line<'_>) -> Result<DVec3, Fault> {
        let number = self.so_far.vertices;
        let mut words = line.words();
        let mut position = [0.0; 3];
        for (k, value) in position.iter_mut().enumerate() {
            let Some(word) = words.next() else {
                let what = format!("vertex {number} has {k} coordinates instead of 3");
                return Err(fault(line, what));
            };
            *value = coordinate(line, number, word)?;
        }
        match (words.next(), words.next()) {
            (Some(word), None) => match coordinate(line, number, word)? {
                0.0 => Err(fault(
                    line,
                    format!("vertex {number}: its fourth coordinate, which divides, is zero"),
                )),
                divisor => Ok(DVec3::from(position) / divisor),
            },
            _ => Ok(position.into()),
        }
    }

    /// Three coordinates; what is not finite becomes zero, which is made anew later.
    fn normal(&self, line: &Line<'_>) -> Result<DVec3, Fault> {
        let number = self.so_far.normals;
        let mut words = line.words();
        let mut normal = [0.0; 3];
        for (k, value) in normal.iter_mut().enumerate() {
            let Some(word) = words.next() else {
                let what = format!("normal {number} has {k} coordinates instead of 3");
                return Err(fault(line, what));
            };
            *value = match word.parse::<f64>() {
                Ok(value) => value,
                Err(_) if is_written_nan(word) => f64::NAN,
                Err(_) => {
                    let what = format!("normal {number}: {word:?} is not a number");
                    return Err(fault(line, what));
                }
            };
        }
        let normal = DVec3::from(normal);
        Ok(if normal.is_finite() {
            normal
        } else {
            DVec3::ZERO
        })
    }

    /// Corners of a vertex and perhaps a normal; texture coordinates are left out.
    fn face(
        &self,
        line: &Line<'_>,
        [vertices, normals]: &mut [Vec<u32>; 2],
        part: &mut Part,
    ) -> Result<(), Fault> {
        vertices.clear();
        normals.clear();
        for word in line.words() {
            let mut parts = word.split('/');
            let vertex = parts.next().unwrap_or_default();
            let normal = parts.nth(1).unwrap_or_default();
            if parts.next().is_some() {
                return Err(corner_fault(line, word, "has more than three parts"));
            }
            let (so_far, total) = (self.so_far, self.total);
            let counts = [so_far.vertices, total.vertices];
            vertices.push(index(line, vertex, word, "vertex", counts)?);
            normals.push(match normal {
                "" => NO_NORMAL,
                normal => {
                    let counts = [so_far.normals, total.normals];
                    index(line, normal, word, "normal", counts)?
                }
            });
        }
        part.faces.push(vertices)?;
        if self.total.normals > 0 && vertices.len() >= 3 {
            part.normal_corners.extend_from_slice(normals);
        }
        Ok(())
    }
}

/// One of a vertex's numbers.
fn coordinate(line: &Line<'_>, vertex: u64, word: &str) -> Result<f64, Fault> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => {
            let rest = line.rest.trim();
            Err(fault(
                line,
                format!("vertex {vertex} is not finite: {rest}"),
            ))
        }
        Err(_) => Err(fault(
            line,
            format!("vertex {vertex}: {word:?} is not a number"),
        )),
    }
}

/// An index into vertices or normals as a corner has it, counted from 0. Negative ones count back
/// from the last one read, which is -1.
fn index(
    line: &Line<'_>,
    text: &str,
    word: &str,
    what: &str,
    [so_far, total]: [u64; 2],
) -> Result<u32, Fault> {
    let index: i64 = text
        .parse()
        .map_err(|_| corner_fault(line, word, "is not made of whole numbers"))?;
    let absolute = if index < 0 {
        (so_far + 1).checked_sub(index.unsigned_abs())
    } else {
        Some(index.unsigned_abs())
    };
    match absolute {
        // A file has fewer than 2^31 vertices or normals: that has been checked.
        Some(absolute) if (1..=total).contains(&absolute) => Ok((absolute - 1) as u32),
        _ => Err(corner_fault(
            line,
            word,
            format!("names {what} {index}, but the file has {total} (1 is the first)"),
        )),
    }
}

/// The line is wrong.
fn fault(line: &Line<'_>, what: String) -> Fault {
    Fault::Line(line.number, what)
}

fn corner_fault<'a>(line: &Line<'_>, word: &str, what: impl Into<Cow<'a, str>>) -> Fault {
    fault(line, format!("corner {word:?} {}", what.into()))
}
