//! A part of an OBJ file's text, read on its own.

use glam::DVec3;

use super::lines::{Line, Lines};
use crate::error::Fault;
use crate::formats::text::number;
use crate::normals::NO_NORMAL;
use crate::polygons::{Attributes, Faces};
use crate::skipped::Skipped;

/// How many of what a text has.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Count {
    pub(super) vertices: u64,
    pub(super) normals: u64,
    /// Physical lines.
    pub(super) lines: usize,
    /// The smoothing group that holds at its end, if it names one.
    pub(super) group: Option<u32>,
}

/// What the faces of a part name, and what else is in it. Indices are those of the whole file.
pub(super) struct Part {
    /// With the normals of their corners if the file has any, and their smoothing groups if it names
    /// any.
    pub(super) faces: Faces,
    /// Lines, points and curves.
    pub(super) no_surface: u64,
    pub(super) libraries: Libraries,
    /// Corners and faces that are wrong.
    pub(super) skipped: Skipped,
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
    /// What there is in a part of a text.
    pub(super) fn of(text: &str) -> Count {
        let mut count = Count::default();
        let mut lines = Lines::new(text, 0);
        for line in &mut lines {
            match line.keyword {
                "v" => count.vertices += 1,
                "vn" => count.normals += 1,
                // What is wrong is told when it is read, or skipped.
                "s" => count.group = smoothing_group(&line).ok().or(count.group),
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
            group: other.group.or(self.group),
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
    /// What is done with corners that are wrong.
    pub(super) skipped: Skipped,
    /// Where its vertices and normals go.
    pub(super) positions: &'a mut [DVec3],
    pub(super) normals: &'a mut [DVec3],
}

impl Chunk<'_> {
    /// Reads all its lines, up to the first that is wrong.
    pub(super) fn read(mut self) -> Result<Part, Fault> {
        let mut part = Part {
            faces: Faces::default(),
            no_surface: 0,
            libraries: Libraries::default(),
            skipped: self.skipped.fresh(),
        };
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
                "s" => match smoothing_group(&line) {
                    Ok(group) => self.so_far.group = Some(group),
                    Err(fault) => part.skipped.skip("the line", fault)?,
                },
                "l" | "p" | "curv" | "curv2" | "surf" => part.no_surface += 1,
                "mtllib" => part.libraries.add(line.rest.trim()),
                _ => {}
            }
        }
        Ok(part)
    }

    /// Three coordinates; a fourth number divides them, and more are a colour. They need not be
    /// finite, which only matters where a face names the vertex.
    fn vertex(&self, line: &Line<'_>) -> Result<DVec3, Fault> {
        let what = || format!("vertex {}", self.so_far.vertices);
        let (position, mut more) = vector(line, &what)?;
        Ok(match (more.next(), more.next()) {
            (Some(divisor), None) => position / number(divisor).unwrap_or(1.0),
            _ => position,
        })
    }

    /// Three coordinates; what is not finite becomes zero, which is made anew later.
    fn normal(&self, line: &Line<'_>) -> Result<DVec3, Fault> {
        let what = || format!("normal {}", self.so_far.normals);
        let (normal, _) = vector(line, &what)?;
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
            let fault = |what: String| Fault::Line(line.number, format!("corner {word:?} {what}"));
            if parts.next().is_some() {
                let what = "has more than three parts".into();
                return part.skipped.skip("the face", fault(what));
            }
            match self.index(vertex, "vertex") {
                Ok(vertex) => vertices.push(vertex),
                Err(what) => return part.skipped.skip("the face", fault(what)),
            }
            normals.push(match normal {
                "" => NO_NORMAL,
                normal => match self.index(normal, "normal") {
                    Ok(normal) => normal,
                    Err(what) => {
                        part.skipped.skip("the corner's normal", fault(what))?;
                        NO_NORMAL
                    }
                },
            });
        }
        let attributes = Attributes {
            others: (self.total.normals > 0).then_some(normals),
            // Before the first that is named, smoothing is off.
            group: self.total.group.map(|_| self.so_far.group.unwrap_or(0)),
        };
        Ok(part.faces.push_with(vertices, attributes)?)
    }

    /// An index into vertices or normals as a corner has it, counted from 0. Negative ones count
    /// back from the last one read, which is -1.
    fn index(&self, text: &str, what: &str) -> Result<u32, String> {
        let [so_far, total] = [self.so_far, self.total].map(|count| match what {
            "vertex" => count.vertices,
            _ => count.normals,
        });
        let index: i64 = (text.parse()).map_err(|_| "is not made of whole numbers".to_owned())?;
        let absolute = if index < 0 {
            (so_far + 1).checked_sub(index.unsigned_abs())
        } else {
            Some(index.unsigned_abs())
        };
        match absolute {
            // A file has fewer than 2^31 vertices or normals: that has been checked.
            Some(absolute) if (1..=total).contains(&absolute) => Ok((absolute - 1) as u32),
            _ => Err(format!(
                "names {what} {index}, but the file has {total} (1 is the first)"
            )),
        }
    }
}

/// Three coordinates, and the words behind them, which are numbers as well.
fn vector<'a>(
    line: &Line<'a>,
    what: &dyn Fn() -> String,
) -> Result<(DVec3, impl Iterator<Item = &'a str> + use<'a>), Fault> {
    let fault = |problem: String| Fault::Line(line.number, format!("{}{problem}", what()));
    let is_no_number = |word: &str| fault(format!(": {word:?} is not a number"));
    let mut words = line.words();
    let mut vector = DVec3::ZERO;
    for k in 0..3 {
        let word = words.next();
        let word = word.ok_or_else(|| fault(format!(" has {k} coordinates instead of 3")))?;
        vector[k] = number(word).ok_or_else(|| is_no_number(word))?;
    }
    match words.clone().find(|word| number(word).is_none()) {
        Some(word) => Err(is_no_number(word)),
        None => Ok((vector, words)),
    }
}

/// The group that a line names; 0 is none.
fn smoothing_group(line: &Line<'_>) -> Result<u32, Fault> {
    match line.words().next() {
        None | Some("off" | "Off" | "OFF") => Ok(0),
        Some("on" | "On" | "ON") => Ok(1),
        Some(word) => word.parse().map_err(|_| {
            let what = format!("{word:?} is no smoothing group: that is a number or off");
            Fault::Line(line.number, what)
        }),
    }
}
