//! Reads OFF files (text): a small reader of our own, as there is no well-kept crate.
//!
//! One line a vertex and a face, as all programs write them. What a vertex has besides its position
//! the keyword says: `ST` texture coordinates and `C` colours, which are left out, `N` a normal,
//! `4` a fourth coordinate that divides the others. Colours of faces are left out.

use glam::DVec3;

use super::Parsed;
use super::text::{lines, number};
use crate::error::Fault;
use crate::polygons::Faces;
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;

/// What vertices have, by the keyword.
#[derive(Clone, Copy)]
struct Vertices {
    homogeneous: bool,
    normals: bool,
}

/// The lines that say something, without comments.
struct Lines<'a, I: Iterator<Item = (usize, &'a str)>> {
    inner: I,
    last: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> Lines<'a, I> {
    fn next(&mut self, wanted: &str) -> Result<(usize, &'a str), Fault> {
        for (number, line) in self.inner.by_ref() {
            let line = line.split('#').next().unwrap_or_default().trim_ascii();
            if !line.is_empty() {
                self.last = number;
                return Ok((number, line));
            }
        }
        let what = format!("the file ends before {wanted}");
        Err(Fault::Line(self.last, what))
    }
}

/// Reads the text of an OFF file.
pub(super) fn read(text: &str) -> Result<Parsed, Fault> {
    let mut lines = Lines {
        inner: lines(text),
        last: 1,
    };
    let (vertices, [vertex_count, face_count]) = header(&mut lines, text.len())?;
    let mut raw = RawMesh::default();
    for vertex in 0..vertex_count {
        let (line, words) = lines.next(&format!("vertex {vertex} of {vertex_count}"))?;
        let fault = |what| Fault::Line(line, format!("vertex {vertex}: {what}"));
        let (position, normal) = vertices.read(words).map_err(fault)?;
        raw.positions.push(position);
        raw.normals.extend(normal);
    }
    let mut faces = Faces::default();
    let mut polygon = Vec::new();
    for face in 0..face_count {
        let (line, words) = lines.next(&format!("face {face} of {face_count}"))?;
        let fault = |what| Fault::Line(line, format!("face {face}: {what}"));
        read_face(words, vertex_count, &mut polygon).map_err(fault)?;
        faces.push(&polygon)?;
    }
    let report = LoadReport {
        polygons: faces.polygons,
        skipped_elements: faces.skipped,
        ..LoadReport::default()
    };
    raw.corners = faces.into_triangles(&raw.positions);
    raw.normal_corners = vertices.normals.then(|| raw.corners.clone());
    Ok(Parsed::new(raw, report))
}

/// The keyword and the numbers of vertices and faces, which the keyword's line may hold as well.
fn header<'a>(
    lines: &mut Lines<'a, impl Iterator<Item = (usize, &'a str)>>,
    length: usize,
) -> Result<(Vertices, [usize; 2]), Fault> {
    let (mut line, first) = lines.next("its keyword")?;
    let mut words = first.split_ascii_whitespace();
    let keyword = words.next().unwrap_or_default();
    let prefix = keyword.strip_suffix("OFF").unwrap_or(keyword);
    let vertices = Vertices {
        homogeneous: prefix.contains('4'),
        normals: prefix.contains('N'),
    };
    if prefix.contains('n') {
        let what = "the keyword promises vertices of any dimension; only three are read";
        return Err(Fault::Line(line, what.into()));
    }
    // Only two count, and a line may have many.
    let mut counts: Vec<&str> = words.take(2).collect();
    if counts
        .first()
        .is_some_and(|w| w.eq_ignore_ascii_case("binary"))
    {
        let what = "binary OFF files are not read; save it as text";
        return Err(Fault::Line(line, what.into()));
    }
    if counts.is_empty() {
        let (next, text) = lines.next("the numbers of vertices and faces")?;
        line = next;
        counts = text.split_ascii_whitespace().take(2).collect();
    }
    let count = |k: usize, what: &str, least: usize| {
        let word = counts.get(k).copied().unwrap_or_default();
        let count: usize = word
            .parse()
            .map_err(|_| Fault::Line(line, format!("{word:?} is no number of {what}")))?;
        // Each takes a line of at least so many bytes.
        if count > length / least {
            return Err(Fault::Line(
                line,
                format!("{count} {what} are promised, but the file has only {length} bytes"),
            ));
        }
        Ok(count)
    };
    Ok((vertices, [count(0, "vertices", 6)?, count(1, "faces", 2)?]))
}

impl Vertices {
    /// The position and perhaps the normal that a line has; what follows is left out.
    fn read(self, line: &str) -> Result<(DVec3, Option<DVec3>), String> {
        let wanted = 3 + usize::from(self.homogeneous) + 3 * usize::from(self.normals);
        let mut words = line.split_ascii_whitespace();
        let mut numbers = [0.0; 7];
        for (k, value) in numbers[..wanted].iter_mut().enumerate() {
            let word = words
                .next()
                .ok_or_else(|| format!("there are {k} numbers instead of {wanted}"))?;
            *value = number(word).ok_or_else(|| format!("{word:?} is not a number"))?;
        }
        let position = DVec3::from_slice(&numbers);
        if !self.homogeneous {
            return Ok((
                position,
                self.normals.then(|| DVec3::from_slice(&numbers[3..])),
            ));
        }
        let normal = self.normals.then(|| DVec3::from_slice(&numbers[4..]));
        Ok((position / numbers[3], normal))
    }
}

/// The corners a face's line names, after their number; colours follow.
fn read_face(line: &str, vertices: usize, polygon: &mut Vec<u32>) -> Result<(), String> {
    let mut words = line.split_ascii_whitespace();
    let first = words.next().unwrap_or_default();
    let corners: usize = first
        .parse()
        .map_err(|_| format!("{first:?} is no number of corners"))?;
    polygon.clear();
    for k in 0..corners {
        let word = words
            .next()
            .ok_or_else(|| format!("there are {k} corners instead of {corners}"))?;
        let index: u32 = word.parse().map_err(|_| format!("{word:?} is no vertex"))?;
        if index as usize >= vertices {
            return Err(format!(
                "it names vertex {index}, but there are only {vertices} (0 is the first)"
            ));
        }
        polygon.push(index);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::formats::{check, damaged};

    const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

    fn fault(text: &str) -> (usize, String) {
        match read(text) {
            Err(Fault::Line(line, what)) => (line, what),
            other => panic!("{:?}", other.map(|p| p.model)),
        }
    }

    #[test]
    fn polygons_comments_and_colours_are_read() {
        let text =
            format!("OFF # by hand\n\n4 3 0\n{SQUARE}4 0 1 2 3 255 0 0\n# x\n3 0 1 2\n2 0 1\n");
        let parsed = read(&text).unwrap();
        assert_eq!(
            parsed.model.parts[0].corners,
            [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
        );
        assert_eq!(
            (parsed.report.polygons, parsed.report.skipped_elements),
            (2, 1)
        );
        assert_eq!(parsed.model.parts[0].normal_corners, None);
    }

    #[test]
    fn the_keyword_says_what_vertices_have() {
        let text = "CNOFF 3 1 0\n0 0 0 0 0 1 .1 .2 .3 1\n1 0 0 0 0 1\n0 1 0 0 1 0\n3 0 1 2\n";
        let raw = read(text).unwrap().model.flatten().unwrap();
        assert_eq!(raw.normals, [DVec3::Z, DVec3::Z, DVec3::Y]);
        assert_eq!(raw.normal_corners, Some(vec![[0, 1, 2]]));
        let text = "N4OFF 3 1 0\n0 0 0 1 0 0 1\n2 0 0 2 0 0 1\n0 1 0 1 0 1 0\n3 0 1 2\n";
        // Geomview writes the keyword as 4NOFF or N4OFF; both say the same.
        let raw = read(text).unwrap().model.flatten().unwrap();
        assert_eq!((raw.positions[1], raw.normals[2]), (DVec3::X, DVec3::Y));
    }

    #[test]
    fn headers_that_lie_are_refused_before_anything_is_kept() {
        assert_eq!(
            fault("OFF\n353535235358 6 0\n0 0 0\n"),
            (
                2,
                "353535235358 vertices are promised, but the file has only 27 bytes".into()
            )
        );
        assert_eq!(
            fault("OFF 1 -1 0\n"),
            (1, "\"-1\" is no number of faces".into())
        );
        assert_eq!(fault("OFF BINARY\n").0, 1);
        assert_eq!(fault("nOFF\n5\n").0, 1);
        assert_eq!(
            fault("OFF\n"),
            (
                1,
                "the file ends before the numbers of vertices and faces".into()
            )
        );
    }

    #[test]
    fn errors_name_line_and_element() {
        let with = |faces: &str| fault(&format!("OFF\n4 2 0\n{SQUARE}{faces}"));
        assert_eq!(
            with("3 0 1 2\n"),
            (7, "the file ends before face 1 of 2".into())
        );
        assert_eq!(
            with("3 0 1 4\n"),
            (
                7,
                "face 0: it names vertex 4, but there are only 4 (0 is the first)".into()
            )
        );
        assert_eq!(
            with("3 0 1 -1\n"),
            (7, "face 0: \"-1\" is no vertex".into())
        );
        assert_eq!(
            with("4 0 1 2\n"),
            (7, "face 0: there are 3 corners instead of 4".into())
        );
        assert_eq!(
            fault("OFF\n2 0 0\n0 0 0\n0 0\n"),
            (4, "vertex 1: there are 2 numbers instead of 3".into())
        );
    }

    proptest! {
        #[test]
        fn damaged_files_are_refused_or_read(
            file in damaged(vec![
                format!("OFF\n4 2 0\n{SQUARE}4 0 1 2 3\n3 2 1 0\n").into(),
                b"N4OFF 3 1 0\n0 0 0 1 0 0 1\n2 0 0 2 0 0 1\n0 1 0 1 0 1 0\n3 0 1 2\n".into(),
            ]),
        ) {
            check(file)?;
        }
    }
}
