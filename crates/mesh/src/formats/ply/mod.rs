//! Reads PLY files: text and binary of either byte order.
//!
//! The header is parsed by `ply-rs-bw`; the numbers after it are read here, because each property's
//! part is then found once an element kind and not by name for every number, and because text is
//! taken as programs write it (`1.`, `nan`), with the line named where it is wrong.

mod body;

use std::io::Cursor;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, Header, PropertyType, ScalarType};

use glam::DVec3;

use super::Parsed;
use super::text::{self, decode, first_line};
use crate::error::{Fault, MeshError};
use crate::polygons::Faces;
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::skipped::Skipped;
use body::{Binary, Body, Text};

/// Reads a PLY file. Vertices, normals, faces and triangle strips are taken; colours, texture
/// coordinates and everything else is left out.
pub(super) fn read(bytes: Vec<u8>, skipped: Skipped) -> Result<Parsed, Fault> {
    let (header, body, lines) = split(&bytes)?;
    let header = parse_header(header)?;
    check_counts(&header, body.len())?;
    match header.encoding {
        Encoding::Ascii => {
            let text = decode(body.to_vec());
            drop(bytes);
            let elements = header.elements.values();
            let elements = elements.filter(|element| !element.properties.is_empty());
            let count = elements.map(|element| element.count).sum();
            read_body(&header, &mut Text::new(&text, lines, count), skipped)
        }
        Encoding::BinaryLittleEndian => {
            read_body(&header, &mut Binary::little_endian(body), skipped)
        }
        Encoding::BinaryBigEndian => read_body(&header, &mut Binary::big_endian(body), skipped),
    }
}

/// The header's bytes, the bytes after it, and how many lines it has. Line feeds, carriage returns
/// or both end a line.
fn split(bytes: &[u8]) -> Result<(&[u8], &[u8], usize), Fault> {
    let mut from = 0;
    let mut has_line_feeds = false;
    for number in 1.. {
        let (length, end) = first_line(&bytes[from..]);
        if length + end == 0 {
            break;
        }
        let line = &bytes[from..from + length];
        let line_end = &bytes[from + length..from + length + end];
        from += length + end;
        if line.trim_ascii().eq_ignore_ascii_case(b"end_header") {
            // In a file whose lines end in carriage returns a line feed is the body's first byte.
            if line_end == b"\r\n" && number > 1 && !has_line_feeds {
                from -= 1;
            }
            return Ok((&bytes[..from], &bytes[from..], number));
        }
        has_line_feeds |= line_end.contains(&b'\n');
    }
    Err(Fault::Content(
        "the header of the PLY file has no \"end_header\"".into(),
    ))
}

fn parse_header(bytes: &[u8]) -> Result<Header, Fault> {
    let mut text = decode(bytes.to_vec());
    // What is written in capitals as a whole means the same.
    if !text.contains("end_header") {
        text.make_ascii_lowercase();
    }
    // The parser knows neither blank lines, nor spaces around them, nor "PLY". It gets a line for each
    // line, so that numbers stay: what stands before the first word follows it as comments.
    let mut clean = String::with_capacity(text.len());
    clean.push_str("ply\n");
    let mut declared = 0;
    let mut is_behind_magic = false;
    for line in text::Lines::new(&text, 0) {
        let line = line.trim();
        let word = line.split_ascii_whitespace().next();
        declared += usize::from(matches!(word, Some("element" | "property")));
        match word {
            Some(_) if !std::mem::replace(&mut is_behind_magic, true) => continue,
            Some(_) => clean.push_str(line),
            None => clean.push_str("comment"),
        }
        clean.push('\n');
    }
    let mut reader = Reader::new(Cursor::new(&clean));
    let header = Parser::<DefaultElement>::new().read_header(&mut reader);
    let header = header.map_err(|error| match error.line() {
        Some(number) => {
            let line = clean.lines().nth(number - 1).unwrap_or_default();
            let what = format!("{line:?} does not belong into the header of a PLY file");
            Fault::Line(number, what)
        }
        None => {
            let all = error.to_string();
            let what = all.lines().next().unwrap_or_default();
            Fault::Content(format!("the header of the PLY file is wrong: {what}"))
        }
    })?;
    let elements = header.elements.values();
    let distinct: usize = elements.map(|e| 1 + e.properties.len()).sum();
    if distinct < declared {
        let what = "the header of the PLY file declares an element or property twice";
        return Err(Fault::Content(what.into()));
    }
    Ok(header)
}

/// Refuses headers that promise more than the file can hold, before memory is reserved for it.
fn check_counts(header: &Header, length: usize) -> Result<(), Fault> {
    let mut needed: usize = 0;
    for element in header.elements.values() {
        let least: usize = element
            .properties
            .values()
            .map(|p| match (&header.encoding, &p.data_type) {
                // A digit and what parts it from the next.
                (Encoding::Ascii, _) => 2,
                (_, PropertyType::Scalar(t) | PropertyType::List(t, _)) => size(t),
            })
            .sum();
        needed = needed.saturating_add(element.count.saturating_mul(least));
        // The last line may lack its end.
        if needed > length + 1 {
            return Err(Fault::Content(format!(
                "the header promises {} elements \"{}\", but only {length} bytes follow it",
                element.count, element.name
            )));
        }
    }
    Ok(())
}

/// The bytes a number takes.
fn size(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// What a property is to us.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// A coordinate of the position (0 to 2) or the normal (3 to 5).
    Coordinate(usize),
    /// The corners of a face.
    Corners,
    /// The corners of strips of triangles.
    Strips,
    Other,
}

fn parts(element: &ElementDef) -> Vec<Part> {
    let part = |name: &str, data_type: &PropertyType| {
        let is_indices = matches!(name, "vertex_indices" | "vertex_index");
        match (data_type, &*element.name) {
            (PropertyType::Scalar(_), "vertex") => ["x", "y", "z", "nx", "ny", "nz"]
                .iter()
                .position(|n| *n == name)
                .map_or(Part::Other, Part::Coordinate),
            (PropertyType::List(..), "face") if is_indices => Part::Corners,
            (PropertyType::List(..), "tristrips") if is_indices => Part::Strips,
            _ => Part::Other,
        }
    };
    let properties = element.properties.values();
    properties.map(|p| part(&p.name, &p.data_type)).collect()
}

/// What has been read, and what is being read.
struct Build {
    raw: RawMesh,
    faces: Faces,
    vertices: usize,
    /// Numbers of the present list.
    indices: Vec<u32>,
    /// What is wrong with one of them.
    wrong_index: Option<String>,
    skipped: Skipped,
}

fn read_body(header: &Header, body: &mut impl Body, skipped: Skipped) -> Result<Parsed, Fault> {
    let vertex = header.elements.get("vertex");
    let vertex = vertex.ok_or_else(|| Fault::Content("the PLY file has no vertices".into()))?;
    let has = |k: usize| parts(vertex).contains(&Part::Coordinate(k));
    if let Some(k) = (0..3).find(|&k| !has(k)) {
        let what = format!("the PLY file's vertices have no {}", ["x", "y", "z"][k]);
        return Err(Fault::Content(what));
    }
    let has_normals = (3..6).all(has);
    if let Some(face) = header.elements.get("face")
        && face.count > 0
        && !parts(face).contains(&Part::Corners)
    {
        let what = "the PLY file's faces have no list \"vertex_indices\"";
        return Err(Fault::Content(what.into()));
    }
    let mut build = Build {
        raw: RawMesh::default(),
        faces: Faces::default(),
        vertices: vertex.count,
        indices: Vec::new(),
        wrong_index: None,
        skipped,
    };
    for element in header.elements.values() {
        build.read_elements(element, has_normals, body)?;
    }
    let warning = body.finish()?;
    let Build {
        mut raw,
        faces,
        mut skipped,
        ..
    } = build;
    let fault = |_, error| Fault::Mesh(error);
    let faces = faces.check_positions(&raw.positions, &mut skipped, fault)?;
    let report = LoadReport {
        polygons: faces.polygons,
        skipped_elements: faces.too_small,
        warnings: warning.into_iter().collect(),
        ..LoadReport::default()
    };
    raw.corners = faces.into_triangles(&raw.positions).corners;
    raw.normal_corners = has_normals.then(|| raw.corners.clone());
    Parsed::new(raw, report, skipped)
}

impl Build {
    fn read_elements(
        &mut self,
        element: &ElementDef,
        has_normals: bool,
        body: &mut impl Body,
    ) -> Result<(), Fault> {
        let parts = parts(element);
        let types: Vec<&PropertyType> = element.properties.values().map(|p| &p.data_type).collect();
        if types.is_empty() {
            return Ok(());
        }
        if element.name == "vertex" {
            // The header has been checked against the file's length.
            self.raw.positions.reserve_exact(element.count);
        }
        for number in 0..element.count {
            let coordinates = self
                .read_element(&types, &parts, body)
                .map_err(|what| body.fault(&element.name, number, what))?;
            if let Some(what) = self.wrong_index.take() {
                let fault = body.fault(&element.name, number, what);
                self.skipped.skip(&format!("the {}", element.name), fault)?;
                continue;
            }
            match &*element.name {
                "vertex" => {
                    self.raw.positions.push(DVec3::from_slice(&coordinates));
                    if has_normals {
                        self.raw.normals.push(DVec3::from_slice(&coordinates[3..]));
                    }
                }
                "face" => self.faces.push(&self.indices)?,
                "tristrips" => self.push_strips()?,
                _ => {}
            }
        }
        Ok(())
    }

    /// Reads one element: its coordinates, and its corners into `indices`.
    fn read_element(
        &mut self,
        types: &[&PropertyType],
        parts: &[Part],
        body: &mut impl Body,
    ) -> Result<[f64; 6], String> {
        let mut coordinates = [0.0; 6];
        self.indices.clear();
        body.begin()?;
        for (data_type, part) in types.iter().zip(parts) {
            match data_type {
                PropertyType::Scalar(scalar) => {
                    let value = body.number(scalar)?;
                    if let Part::Coordinate(k) = part {
                        coordinates[*k] = value;
                    }
                }
                PropertyType::List(length, scalar) => {
                    let length = body.number(length)?;
                    if !(length >= 0.0 && length.fract() == 0.0) {
                        return Err(format!("{length} is no length of a list"));
                    }
                    for _ in 0..length as u64 {
                        let value = body.number(scalar)?;
                        match part {
                            Part::Strips if value == -1.0 => self.indices.push(STRIP_END),
                            Part::Corners | Part::Strips => self.push_index(value),
                            _ => {}
                        }
                    }
                }
            }
        }
        body.end()?;
        Ok(coordinates)
    }

    fn push_index(&mut self, value: f64) {
        if value >= 0.0 && value.fract() == 0.0 && value < self.vertices as f64 {
            self.indices.push(value as u32);
            return;
        }
        let vertices = self.vertices;
        self.wrong_index.get_or_insert_with(|| {
            format!("it names vertex {value}, but there are only {vertices} (0 is the first)")
        });
    }

    /// Cuts strips of triangles, every other one of which winds the other way.
    fn push_strips(&mut self) -> Result<(), MeshError> {
        for strip in self.indices.split(|&i| i == STRIP_END) {
            for (k, window) in strip.windows(3).enumerate() {
                let [a, b, c] = [window[0], window[1], window[2]];
                let triangle = if k % 2 == 0 { [a, b, c] } else { [b, a, c] };
                // Two equal corners only turn the strip.
                if a != b && b != c && c != a {
                    self.faces.push(&triangle)?;
                }
            }
        }
        Ok(())
    }
}

/// Stands between strips of triangles, where files have -1.
const STRIP_END: u32 = u32::MAX;

#[cfg(test)]
mod tests;
