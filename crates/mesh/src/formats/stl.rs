//! Reads STL files, text and binary.
//!
//! Our own reader, because the crate for it reads text in single precision, without line numbers,
//! up to the first `endsolid` only, and takes binary files that start with "solid" for text.
//!
//! A facet's normal says nothing that its corners do not say, except where both disagree: then the
//! winding counts, and the facets are counted for a warning. Vertex normals are made from the
//! facets, which share their corners by exact position.

use glam::DVec3;

use super::Parsed;
use super::text::{lines, number};
use crate::error::{Fault, MAX_INDICES, MeshError};
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;

/// Bytes of a binary STL before its facets, and of each facet.
const STL_HEAD: usize = 84;
const STL_FACET: usize = 50;

/// Facets on their way to a mesh.
#[derive(Default)]
struct Facets {
    positions: Vec<DVec3>,
    /// Facets whose normal points to the side from which they wind clockwise.
    against: u64,
    warnings: Vec<String>,
}

impl Facets {
    fn push(&mut self, normal: DVec3, corners: [DVec3; 3]) {
        let [a, b, c] = corners;
        if (b - a).cross(c - a).dot(normal) < 0.0 {
            self.against += 1;
        }
        self.positions.extend(corners);
    }

    fn check(&self, facet: usize) -> Result<(), Fault> {
        let corners = &self.positions[3 * facet..];
        match corners.iter().find(|p| !p.is_finite()) {
            Some(DVec3 { x, y, z }) => Err(Fault::Content(format!(
                "facet {} has a corner that is not finite: {x} {y} {z}",
                facet + 1
            ))),
            None => Ok(()),
        }
    }

    fn into_parsed(mut self) -> Result<Parsed, Fault> {
        let indices = self.positions.len() as u64;
        if indices > MAX_INDICES {
            return Err(MeshError::TooManyIndices { indices }.into());
        }
        if self.against > 0 {
            self.warnings.push(format!(
                "{} facets have a normal that points against their winding; the winding counts",
                self.against
            ));
        }
        let corners = (0..indices as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        let raw = RawMesh {
            corners: corners.collect(),
            positions: self.positions,
            ..RawMesh::default()
        };
        let report = LoadReport {
            polygons: indices / 3,
            warnings: self.warnings,
            ..LoadReport::default()
        };
        Ok(Parsed::new(raw, report))
    }
}

/// Reads a binary STL.
pub(super) fn read_binary(bytes: &[u8]) -> Result<Parsed, Fault> {
    let Some(count) = stl_facets(bytes) else {
        return Err(Fault::Content(
            "the file is too short for a binary STL".into(),
        ));
    };
    let (records, _) = bytes[STL_HEAD..].as_chunks::<STL_FACET>();
    if records.len() < count {
        return Err(Fault::Content(format!(
            "the file ends in facet {}, but its header promises {count} facets",
            records.len() + 1
        )));
    }
    let mut facets = Facets {
        positions: Vec::with_capacity(3 * count),
        ..Facets::default()
    };
    for (facet, record) in records[..count].iter().enumerate() {
        let (numbers, _) = record.as_chunks::<4>();
        let vector = |k: usize| {
            let part = |i: usize| f64::from(f32::from_le_bytes(numbers[3 * k + i]));
            DVec3::new(part(0), part(1), part(2))
        };
        facets.push(vector(0), [vector(1), vector(2), vector(3)]);
        facets.check(facet)?;
    }
    let behind = bytes.len() - stl_length(count).unwrap_or(bytes.len());
    if behind > 0 {
        facets
            .warnings
            .push(format!("{behind} bytes after the last facet were not read"));
    }
    facets.into_parsed()
}

/// The number of facets that a binary STL promises.
pub(super) fn stl_facets(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..STL_HEAD)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

/// The length of a binary STL of so many facets.
pub(super) fn stl_length(facets: usize) -> Option<usize> {
    facets.checked_mul(STL_FACET)?.checked_add(STL_HEAD)
}

/// What stands where in a text STL.
enum Place {
    /// Between facets.
    Outside,
    /// In a facet with this normal, with the corners so far.
    Facet(DVec3, Vec<DVec3>),
}

/// Reads a text STL. Any number of solids makes one mesh.
pub(super) fn read_text(text: &str) -> Result<Parsed, Fault> {
    let mut facets = Facets::default();
    let mut place = Place::Outside;
    let mut ended = false;
    let mut last = 0;
    for (number, line) in lines(text) {
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        last = number;
        ended = false;
        let fault = |what: &str| Err(Fault::Line(number, what.into()));
        match (keyword.to_ascii_lowercase().as_str(), &mut place) {
            ("solid", Place::Outside) => {}
            ("endsolid", Place::Outside) => ended = true,
            ("facet", Place::Outside) => {
                let normal = facet_normal(words).map_err(|what| Fault::Line(number, what))?;
                place = Place::Facet(normal, Vec::with_capacity(3));
            }
            ("outer" | "endloop", Place::Facet(..)) => {}
            ("vertex", Place::Facet(_, corners)) if corners.len() == 3 => {
                return fault("a facet has more than three corners; STL facets are triangles");
            }
            ("vertex", Place::Facet(_, corners)) => {
                corners.push(vector(words).map_err(|what| Fault::Line(number, what))?);
            }
            ("endfacet", Place::Facet(normal, corners)) => {
                let Ok(corners) = <[DVec3; 3]>::try_from(corners.as_slice()) else {
                    return fault("a facet has fewer than three corners");
                };
                facets.push(*normal, corners);
                facets.check(facets.positions.len() / 3 - 1)?;
                place = Place::Outside;
            }
            _ => return Err(Fault::Line(number, misplaced(keyword))),
        }
    }
    if let Place::Facet(..) = place {
        return Err(Fault::Line(last, "the file ends in a facet".into()));
    }
    if !ended {
        facets
            .warnings
            .push("the file ends without \"endsolid\"; it may be cut off".into());
    }
    facets.into_parsed()
}

fn misplaced(keyword: &str) -> String {
    let known = [
        "solid", "facet", "outer", "vertex", "endloop", "endfacet", "endsolid",
    ];
    if known.contains(&keyword.to_ascii_lowercase().as_str()) {
        format!("{keyword:?} does not belong here")
    } else {
        format!("{keyword:?} is no keyword of an STL file")
    }
}

/// The normal after "facet normal"; zero where it is not there.
fn facet_normal<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    match words.next() {
        None => Ok(DVec3::ZERO),
        Some(word) if word.eq_ignore_ascii_case("normal") => vector(words),
        Some(word) => Err(format!("{word:?} stands where \"normal\" should")),
    }
}

fn vector<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut vector = DVec3::ZERO;
    for k in 0..3 {
        let word = words
            .next()
            .ok_or_else(|| format!("there are {k} coordinates instead of 3"))?;
        vector[k] = number(word).ok_or_else(|| format!("{word:?} is not a number"))?;
    }
    Ok(vector)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::formats::{check, damaged};

    const FACET: &str = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  \
                         vertex 0 1.0000000001 0\n endloop\nendfacet\n";

    fn record(normal: [f32; 3], corners: [[f32; 3]; 3]) -> Vec<u8> {
        let numbers = [&normal[..], corners.as_flattened()].concat();
        let mut bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend([7, 7]);
        bytes
    }

    fn binary(promised: u32, records: &[Vec<u8>]) -> Vec<u8> {
        let head = [&[b'x'; 80][..], &promised.to_le_bytes()].concat();
        [head, records.concat()].concat()
    }

    const CORNERS: [[f32; 3]; 3] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];

    fn line_fault(text: &str) -> (usize, String) {
        match read_text(text) {
            Err(Fault::Line(line, what)) => (line, what),
            other => panic!("{:?}", other.map(|p| p.model)),
        }
    }

    #[test]
    fn text_keeps_all_digits_and_all_solids() {
        let text = format!(
            "solid a b\n{FACET}endsolid a b\nSOLID\n{}ENDSOLID\n",
            FACET.to_uppercase()
        );
        let parsed = read_text(&text).unwrap();
        assert_eq!(parsed.model.parts[0].corners, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(parsed.model.parts[0].positions[5].y, 1.0000000001);
        assert_eq!(parsed.report.warnings, [] as [String; 0]);
    }

    #[test]
    fn text_that_ends_early_is_refused_or_warned_of() {
        let warned = read_text(&format!("solid\n{FACET}")).unwrap();
        assert_eq!(
            warned.report.warnings,
            ["the file ends without \"endsolid\"; it may be cut off"]
        );
        let cut = &FACET[..FACET.len() - 9];
        assert_eq!(
            line_fault(&format!("solid\n{cut}")),
            (7, "the file ends in a facet".into())
        );
    }

    #[test]
    fn text_errors_name_their_line() {
        let with =
            |from: &str, to: &str| line_fault(&format!("solid\n{}", FACET.replacen(from, to, 1)));
        assert_eq!(
            with("vertex 1 0 0", "vertex 1 0"),
            (5, "there are 2 coordinates instead of 3".into())
        );
        assert_eq!(with("1 0 0", "1 O 0"), (5, "\"O\" is not a number".into()));
        assert_eq!(with("vertex 1 0 0\n", "\n").0, 8);
        assert_eq!(with(" endloop", " vertex 1 2 3").0, 7);
        assert_eq!(
            with("endfacet", "facet"),
            (8, "\"facet\" does not belong here".into())
        );
        assert_eq!(with("normal", "ordinary").0, 2);
        assert_eq!(
            with("facet", "f"),
            (2, "\"f\" is no keyword of an STL file".into())
        );
    }

    #[test]
    fn binary_facets_become_triangles_and_normals_against_the_winding_are_told() {
        let records = [[0., 0., 1.], [0., 0., 0.], [0., 0., -1.], [f32::NAN; 3]];
        let records = records.map(|n| record(n, CORNERS));
        let parsed = read_binary(&binary(4, &records)).unwrap();
        assert_eq!(parsed.model.parts[0].corners.len(), 4);
        assert_eq!(parsed.model.parts[0].positions[11], DVec3::Y);
        assert_eq!(
            parsed.report.warnings,
            ["1 facets have a normal that points against their winding; the winding counts"]
        );
    }

    #[test]
    fn a_binary_file_that_is_cut_off_or_not_finite_is_refused_by_facet() {
        let what = |bytes: &[u8]| match read_binary(bytes) {
            Err(Fault::Content(what)) => what,
            other => panic!("{:?}", other.map(|p| p.model)),
        };
        let one = record([0.; 3], CORNERS);
        assert_eq!(
            what(&binary(u32::MAX, std::slice::from_ref(&one))),
            "the file ends in facet 2, but its header promises 4294967295 facets"
        );
        assert_eq!(what(&[0; 83]), "the file is too short for a binary STL");
        let mut infinite = CORNERS;
        infinite[1][2] = f32::INFINITY;
        assert_eq!(
            what(&binary(2, &[one, record([0.; 3], infinite)])),
            "facet 2 has a corner that is not finite: 1 0 inf"
        );
    }

    #[test]
    fn bytes_behind_the_last_facet_are_told() {
        let bytes = binary(1, &[record([0.; 3], CORNERS), vec![0; 9]]);
        assert_eq!(
            read_binary(&bytes).unwrap().report.warnings,
            ["9 bytes after the last facet were not read"]
        );
    }

    proptest! {
        #[test]
        fn damaged_files_are_refused_or_read(
            file in damaged(vec![
                format!("solid a\n{FACET}{FACET}endsolid\n").into(),
                binary(3, &vec![record([0., 0., 1.], CORNERS); 3]),
            ]),
        ) {
            check(file)?;
        }
    }
}
