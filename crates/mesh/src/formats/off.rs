//! Reads OFF files (text): a small reader of our own, as there is no well-kept crate.
//!
//! What a vertex has besides its position the keyword says: `ST` texture coordinates and `C` colours,
//! which are left out, `N` a normal, `4` a fourth coordinate that divides the others. Programs
//! disagree on which of colour and normal comes first, whatever the order of the letters; so the
//! numbers decide. Colours of faces are left out.
//!
//! All programs write one line a vertex and a face, and colours of faces end with the line. Where a
//! file cannot be read so, any white space is taken to separate its numbers.

use glam::DVec3;

use super::Parsed;
use super::text::{Lines, Words, number};
use crate::error::Fault;
use crate::polygons::Faces;
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use crate::skipped::Skipped;

/// How far from 1 the square of a normal's length may be.
const UNIT_TOLERANCE: f64 = 0.02;

/// The greatest number of a colour.
const MAX_COLOUR: f64 = 255.0;

/// What vertices have, by the keyword.
#[derive(Clone, Copy, Default)]
struct Attributes {
    texture: bool,
    colours: bool,
    normals: bool,
    homogeneous: bool,
    /// Positions have any number of coordinates.
    any_dimension: bool,
    /// Whether `N` stands before `C`.
    normals_named_first: bool,
}

impl Attributes {
    /// What a keyword says, and what is glued to it; `None` for another word. Letters come in any
    /// order, in upper or lower case.
    fn of(word: &str) -> Option<(Attributes, &str)> {
        let at = word.to_ascii_uppercase().find("OFF")?;
        let (letters, off) = word.split_at(at);
        let (off, glued) = off.split_at(3);
        if !glued.is_empty() && !glued.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        // In a keyword of small letters, n is N.
        let letters = if off == "off" {
            letters.to_ascii_uppercase()
        } else {
            letters.to_owned()
        };
        let mut has = Attributes::default();
        let mut left = letters.as_str();
        while let Some(letter) = left.chars().next() {
            let is_st = left
                .get(..2)
                .is_some_and(|st| st.eq_ignore_ascii_case("st"));
            let (flag, length) = match letter {
                _ if is_st => (&mut has.texture, 2),
                'C' | 'c' => (&mut has.colours, 1),
                'N' => {
                    has.normals_named_first = !has.colours;
                    (&mut has.normals, 1)
                }
                '4' => (&mut has.homogeneous, 1),
                'n' => (&mut has.any_dimension, 1),
                _ => return None,
            };
            if std::mem::replace(flag, true) {
                return None;
            }
            left = &left[length..];
        }
        Some((has, glued))
    }

    /// Coordinates of a position.
    fn coordinates(self) -> usize {
        3 + usize::from(self.homogeneous)
    }

    /// Numbers of a vertex, with so many for its colour.
    fn numbers(self, colour: usize) -> usize {
        self.coordinates()
            + 3 * usize::from(self.normals)
            + colour * usize::from(self.colours)
            + 2 * usize::from(self.texture)
    }
}

/// Whether a word is the keyword of an OFF file.
pub(super) fn is_keyword(word: &[u8]) -> bool {
    // A keyword is short, and the number behind it as well.
    let word = word.get(..word.len().min(32)).unwrap_or_default();
    std::str::from_utf8(word).is_ok_and(|word| Attributes::of(word).is_some())
}

/// How the numbers of vertices and faces are separated.
#[derive(Clone, Copy, PartialEq)]
enum Layout {
    /// One line each.
    Lines,
    /// Any white space; what follows a face in its line is its colour.
    WordsAndFaceColours,
    /// Any white space, and faces have no colours.
    Words,
}

/// The header, and the words behind it.
#[derive(Clone)]
struct Reader<'a> {
    words: Words<'a>,
    has: Attributes,
    vertices: usize,
    faces: usize,
    /// How many numbers a colour has.
    colour: usize,
}

/// Reads the text of an OFF file.
pub(super) fn read(text: &str, skipped: Skipped) -> Result<Parsed, Fault> {
    let reader = Reader::header(text)?;
    let fault = match reader.clone().body(Layout::Lines, skipped.fresh()) {
        Err(fault) => fault,
        parsed => return parsed,
    };
    // With a line for each, a wrong one is just that.
    if reader.lines_left() == reader.vertices + reader.faces {
        return Err(fault);
    }
    let layouts = [Layout::WordsAndFaceColours, Layout::Words];
    let with_colours = |colour| layouts.map(|layout| (layout, colour));
    // The second only matters where there are colours.
    let others = [4, 3].into_iter().take(1 + usize::from(reader.has.colours));
    let read = |(layout, colour)| {
        let reader = Reader {
            colour,
            ..reader.clone()
        };
        reader.body(layout, skipped.fresh()).ok()
    };
    others.flat_map(with_colours).find_map(read).ok_or(fault)
}

impl<'a> Reader<'a> {
    /// Reads the keyword and the numbers of vertices and faces.
    fn header(text: &'a str) -> Result<Reader<'a>, Fault> {
        let mut words = Words::new(Lines::new(text, 0), Some('#'));
        let keyword = words.next().unwrap_or_default();
        let (has, glued) = Attributes::of(keyword).unwrap_or_default();
        let line = words.line_number();
        if has.any_dimension {
            let what = "the keyword promises vertices of any dimension; only three are read";
            return Err(Fault::Line(line, what.into()));
        }
        let next = words.rest_of_line().next().unwrap_or_default();
        if next.eq_ignore_ascii_case("binary") {
            let what = "binary OFF files are not read; save it as text";
            return Err(Fault::Line(line, what.into()));
        }
        let glued = (!glued.is_empty()).then_some(glued);
        let mut count = |glued: Option<&'a str>, what: &str, least: usize| {
            let word = glued.or_else(|| words.next());
            let line = words.line_number();
            let Some(word) = word else {
                let what = "the file ends before the numbers of vertices and faces";
                return Err(Fault::Line(line, what.into()));
            };
            let count: usize = word
                .parse()
                .map_err(|_| Fault::Line(line, format!("{word:?} is no number of {what}")))?;
            // Each takes at least so many bytes.
            if count > text.len() / least {
                let length = text.len();
                let what =
                    format!("{count} {what} are promised, but the file has only {length} bytes");
                return Err(Fault::Line(line, what));
            }
            Ok(count)
        };
        let vertices = count(glued, "vertices", 6)?;
        let faces = count(None, "faces", 2)?;
        // The number of edges, which means nothing and may be missing.
        if words.next_in_line().is_none() {
            let mut next_line = words.clone();
            if next_line.next().is_some() && next_line.next_in_line().is_none() {
                words = next_line;
            }
        }
        // The first vertex's line shows how many numbers a colour has.
        let mut first = words.clone();
        let numbers = match first.next_line_with_words() {
            true => first.rest_of_line().count(),
            false => 0,
        };
        let colour = numbers.checked_sub(has.numbers(0));
        Ok(Reader {
            words,
            has,
            vertices,
            faces,
            colour: colour.filter(|n| (1..=4).contains(n)).unwrap_or(4),
        })
    }

    /// How many lines with words follow the header's.
    fn lines_left(&self) -> usize {
        let mut words = self.words.clone();
        std::iter::from_fn(|| words.next_line_with_words().then_some(())).count()
    }

    fn body(mut self, layout: Layout, mut skipped: Skipped) -> Result<Parsed, Fault> {
        let mut raw = self.read_vertices(layout)?;
        let mut faces = Faces::default();
        let mut polygon = Vec::new();
        for face in 0..self.faces {
            if layout == Layout::Lines && !self.words.next_line_with_words() {
                return Err(self.ends_before("face", face, self.faces));
            }
            let wrong = self.read_face(layout, face, &mut polygon)?;
            match wrong {
                Some(fault) => skipped.skip("the face", fault)?,
                None => faces.push(&polygon)?,
            }
            if layout == Layout::WordsAndFaceColours {
                while self.words.next_in_line().is_some() {}
            }
        }
        if layout != Layout::Lines && self.words.next().is_some() {
            let what = "the file goes on after the last face".into();
            return Err(Fault::Line(self.words.line_number(), what));
        }
        let mut warnings = Vec::new();
        if layout == Layout::Lines && self.words.next_line_with_words() {
            warnings.push(format!(
                "the file goes on behind its last face, in line {}; that was not read",
                self.words.line_number()
            ));
        }
        let fault = |_, error| Fault::Mesh(error);
        let faces = faces.check_positions(&raw.positions, &mut skipped, fault)?;
        let report = LoadReport {
            polygons: faces.polygons,
            skipped_elements: faces.too_small,
            warnings,
            ..LoadReport::default()
        };
        raw.corners = faces.into_triangles(&raw.positions).corners;
        raw.normal_corners = self.has.normals.then(|| raw.corners.clone());
        Parsed::new(raw, report, skipped)
    }

    fn ends_before(&self, what: &str, number: usize, count: usize) -> Fault {
        let what = format!("the file ends before {what} {number} of {count}");
        Fault::Line(self.words.line_number(), what)
    }

    /// The positions and normals.
    fn read_vertices(&mut self, layout: Layout) -> Result<RawMesh, Fault> {
        let has = self.has;
        let mut raw = RawMesh::default();
        let mut normals = NormalColumns::new(has);
        let mut numbers = Vec::new();
        let count = has.numbers(self.colour);
        for vertex in 0..self.vertices {
            numbers.clear();
            if layout == Layout::Lines {
                if !self.words.next_line_with_words() {
                    return Err(self.ends_before("vertex", vertex, self.vertices));
                }
                while let Some(word) = self.words.next_in_line() {
                    numbers.push(self.vertex_number(vertex, word)?);
                }
            } else {
                while numbers.len() < count {
                    let word = self.words.next();
                    let word =
                        word.ok_or_else(|| self.ends_before("vertex", vertex, self.vertices))?;
                    numbers.push(self.vertex_number(vertex, word)?);
                }
            }
            let wanted = has.coordinates() + 3 * usize::from(has.normals);
            if numbers.len() < wanted {
                let what = format!(
                    "vertex {vertex}: there are {} numbers instead of {wanted}",
                    numbers.len()
                );
                return Err(Fault::Line(self.words.line_number(), what));
            }
            let position = DVec3::from_slice(&numbers);
            raw.positions.push(match has.homogeneous {
                true => position / numbers[3],
                false => position,
            });
            if has.normals {
                normals.push(&numbers[has.coordinates()..], self.colour);
            }
        }
        raw.normals = normals.chosen();
        Ok(raw)
    }

    fn vertex_number(&self, vertex: usize, word: &str) -> Result<f64, Fault> {
        number(word).ok_or_else(|| {
            let what = format!("vertex {vertex}: {word:?} is not a number");
            Fault::Line(self.words.line_number(), what)
        })
    }

    /// Reads the corners of a face, after their number. Returns what is wrong with one of them, if
    /// that does not keep the rest from being read.
    fn read_face(
        &mut self,
        layout: Layout,
        face: usize,
        polygon: &mut Vec<u32>,
    ) -> Result<Option<Fault>, Fault> {
        let mut next = || match layout {
            Layout::Lines => self.words.next_in_line(),
            _ => self.words.next(),
        };
        let first = next();
        let corners: Result<usize, _> = first.unwrap_or_default().parse();
        let mut wrong: Option<String> = None;
        let mut found = 0;
        polygon.clear();
        if let Ok(corners) = corners {
            while found < corners
                && let Some(word) = next()
            {
                found += 1;
                match word.parse::<u32>() {
                    Ok(index) if (index as usize) < self.vertices => polygon.push(index),
                    Ok(index) => {
                        let count = self.vertices;
                        wrong.get_or_insert_with(|| {
                            format!(
                                "it names vertex {index}, but there are only {count} (0 is the first)"
                            )
                        });
                    }
                    Err(_) => {
                        wrong.get_or_insert_with(|| format!("{word:?} is no vertex"));
                    }
                }
            }
        }
        let fault = |what| Fault::Line(self.words.line_number(), format!("face {face}: {what}"));
        match (first, corners) {
            (None, _) => Err(self.ends_before("face", face, self.faces)),
            (Some(first), Err(_)) => Err(fault(format!("{first:?} is no number of corners"))),
            (_, Ok(corners)) if found < corners => Err(fault(format!(
                "there are {found} corners instead of {corners}"
            ))),
            _ => Ok(wrong.map(fault)),
        }
    }
}

/// The normals of vertices, for both places where they may be.
struct NormalColumns {
    has_colours: bool,
    first_if_equal: bool,
    /// Before and behind the colours.
    normals: [Vec<DVec3>; 2],
    /// How many vertices have a unit normal and a colour there.
    plausible: [usize; 2],
}

impl NormalColumns {
    fn new(has: Attributes) -> NormalColumns {
        NormalColumns {
            has_colours: has.colours,
            first_if_equal: !has.normals_named_first,
            normals: Default::default(),
            plausible: [0; 2],
        }
    }

    /// Adds the numbers of a vertex behind its position, where colours have so many.
    fn push(&mut self, numbers: &[f64], colour: usize) {
        let before = DVec3::from_slice(numbers);
        // A vertex may lack its colour.
        let behind = numbers.get(colour..colour + 3);
        let behind = behind.filter(|_| self.has_colours).map(DVec3::from_slice);
        let is_unit = |n: DVec3| (n.length_squared() - 1.0).abs() < UNIT_TOLERANCE;
        let is_colour = |numbers: &[f64]| {
            let mut numbers = numbers.iter();
            numbers.all(|x| (0.0..=MAX_COLOUR).contains(x))
        };
        if let Some(behind) = behind {
            let colours = [&numbers[3..3 + colour], &numbers[..colour]];
            for (place, normal) in [before, behind].into_iter().enumerate() {
                let fits = is_unit(normal) && is_colour(colours[place]);
                self.plausible[place] += usize::from(fits);
            }
        }
        self.normals[0].push(before);
        if self.has_colours {
            self.normals[1].push(behind.unwrap_or(before));
        }
    }

    /// Those at the place where more of them are plausible. Where that does not decide, MeshLab's
    /// NC has the colour first, and Geomview's CN the normal.
    fn chosen(self) -> Vec<DVec3> {
        let [before, behind] = self.plausible;
        let is_first =
            !self.has_colours || before > behind || before == behind && self.first_if_equal;
        let [first, second] = self.normals;
        if is_first { first } else { second }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::formats::{check, damaged};

    const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

    fn fault(text: &str) -> (usize, String) {
        match read(text, Skipped::new(false)) {
            Err(Fault::Line(line, what)) => (line, what),
            other => panic!("{:?}", other.map(|p| p.model)),
        }
    }

    #[test]
    fn polygons_comments_and_colours_are_read() {
        let text =
            format!("OFF # by hand\n\n4 3 0\n{SQUARE}4 0 1 2 3 255 0 0\n# x\n3 0 1 2\n2 0 1\n");
        let parsed = read(&text, Skipped::new(false)).unwrap();
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
        let raw = flat(text);
        assert_eq!(raw.normals, [DVec3::Z, DVec3::Z, DVec3::Y]);
        assert_eq!(raw.normal_corners, Some(vec![[0, 1, 2]]));
        let text = "N4OFF 3 1 0\n0 0 0 1 0 0 1\n2 0 0 2 0 0 1\n0 1 0 1 0 1 0\n3 0 1 2\n";
        // Geomview writes the keyword as 4NOFF or N4OFF; both say the same.
        let raw = flat(text);
        assert_eq!((raw.positions[1], raw.normals[2]), (DVec3::X, DVec3::Y));
    }

    fn flat(text: &str) -> RawMesh {
        let parsed = read(text, Skipped::new(false));
        let parsed = parsed.unwrap_or_else(|fault| panic!("{text}: {}", fault.text()));
        parsed.model.flatten().unwrap()
    }

    #[test]
    fn colours_may_come_before_normals_or_after_them() {
        let unit = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        let n = ["1 0 0", "0 1 0", "0 0 -1"];
        // Colours of 0 to 255 and of 0 to 1, three numbers or four; pure red is as long as a normal.
        let colours = ["200 30 30 255", "0.5 0.25 1 1", "1 0 0 1", "12 0 0", "7"];
        for keyword in ["NCOFF", "CNOFF", "ncoff", "CNSTOFF", "STNCOFF", "NcOFF"] {
            let texture = if keyword.contains("ST") {
                " 0.5 0.25"
            } else {
                ""
            };
            for colour in colours {
                let with = |vertex: &dyn Fn(&str) -> String| {
                    let vertices = n.map(|n| format!("0 0 0 {}{texture}\n", vertex(n)));
                    format!("{keyword}\n3 1 0\n{}3 0 1 2\n", vertices.concat())
                };
                let texts = [
                    with(&|n| format!("{colour} {n}")),
                    with(&|n| format!("{n} {colour}")),
                ];
                for text in texts {
                    assert_eq!(flat(&text).normals, unit, "{text}");
                }
            }
        }
        // Nothing but the letters tells: MeshLab's NC has the colour first.
        let text = |keyword: &str| {
            let vertex = "0 0 0 0 0 1 0 0 1\n";
            format!(
                "{keyword}\n3 1 0\n{}3 0 1 2\n",
                vertex.repeat(3).replace("0 0 1 0 0 1", "1 0 0 0 1 0")
            )
        };
        assert_eq!(flat(&text("NCOFF")).normals[0], DVec3::Y);
        assert_eq!(flat(&text("CNOFF")).normals[0], DVec3::X);
        assert_eq!(
            flat("COFF 3 1 0\n0 0 0 1 0 0 1\n1 0 0 9 9 9\n0 1 0\n3 0 1 2\n").normals,
            []
        );
    }

    #[test]
    fn any_white_space_separates_numbers() {
        let expected = flat(&format!("OFF\n4 2 0\n{SQUARE}4 0 1 2 3\n3 0 1 2\n"));
        let words = "4 2 0 0 0 0 1 0 0 1 1 0 0 1 0 4 0 1 2 3 3 0 1 2";
        let texts = [
            format!("OFF{words}"),
            format!("OFF {words}\n"),
            format!("off\n# one a line\n{}", words.replace(' ', "\n")),
            format!("OFF\n4 2\n{SQUARE}4 0 1 2 3\n3 0 1 2\n"),
            format!(
                "OFF\r4\r2\r0\r{}4 0 1 2 3 255 0 0\r3 0 1\t2\r",
                SQUARE.replace('\n', "\r")
            ),
            "Off 4 2 0\n0 0 0 1\n0 0 1 1 0\n0 1 0\n4 0 1 2 3 1 0 0\n3 0 1 2 0.5\n".into(),
        ];
        for text in texts {
            let raw = flat(&text);
            assert_eq!(raw.positions, expected.positions, "{text}");
            assert_eq!(raw.corners, expected.corners, "{text}");
        }
        for colour in ["9 0 0", "9 0 0 255"] {
            let vertices = SQUARE.replace('\n', &format!(" {colour} 0 0 1\n"));
            let text = format!("NCOFF 4 2 0 {vertices} 4 0 1 2 3 3 0 1 2").replace('\n', " ");
            let raw = flat(&text);
            assert_eq!(raw.positions, expected.positions, "{text}");
            assert_eq!(raw.normals, [DVec3::Z; 4], "{text}");
        }
    }

    #[test]
    fn what_is_behind_the_last_face_is_told() {
        let text = format!("OFF\n4 1 0\n{SQUARE}4 0 1 2 3\n\n3 0 1 2\n");
        assert_eq!(
            read(&text, Skipped::new(false)).unwrap().report.warnings,
            ["the file goes on behind its last face, in line 9; that was not read"]
        );
    }

    #[test]
    fn keywords_have_their_letters_in_any_order_and_case() {
        for keyword in [
            "OFF", "NOFF", "noff", "CSTOFF", "STCOFF", "4off", "C4NSTOFF", "nOFF", "Coff",
        ] {
            assert!(is_keyword(keyword.as_bytes()), "{keyword}");
        }
        for other in ["OFFICE", "XOFF", "NNOFF", "COFFEE", "OF", "", "SOFF"] {
            assert!(!is_keyword(other.as_bytes()), "{other}");
        }
        assert_eq!(fault("nOFF\n5\n").0, 1);
        assert!(fault("noff\n1\n").1.contains("ends before"));
    }

    #[test]
    fn wrong_faces_are_skipped_where_that_is_asked_for() {
        let text = format!("OFF\n4 4 0\n{SQUARE}4 0 1 2 3\n3 0 1 9\n3 0 1 x\n3 0 1 2\n");
        let parsed = read(&text, Skipped::new(true)).unwrap();
        assert_eq!(
            (parsed.report.polygons, parsed.report.skipped_faults),
            (2, 2)
        );
        let nan = text.replace("0 1 0\n", "0 nan 0\n");
        let parsed = read(&nan, Skipped::new(true)).unwrap();
        assert_eq!(
            (parsed.report.polygons, parsed.report.skipped_faults),
            (1, 3)
        );
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
                "face 0: it names vertex 4, but there are only 4 (0 is the first); --lenient skips \
                 the face"
                    .into()
            )
        );
        assert_eq!(
            with("3 0 1 -1\n"),
            (
                7,
                "face 0: \"-1\" is no vertex; --lenient skips the face".into()
            )
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
