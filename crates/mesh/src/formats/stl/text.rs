//! Text STL: keywords and numbers, with any white space between them.

use glam::DVec3;

use super::Facets;
use crate::error::Fault;
use crate::formats::Parsed;
use crate::formats::text::{Lines, Words, contains_ignoring_case, number};
use crate::skipped::Skipped;

/// How much of a file is searched for the keywords of its first facet.
const SEARCHED: usize = 4096;

/// What stands where in a text STL.
enum Place {
    /// Between facets.
    Outside,
    /// In a facet with this normal, with the corners so far.
    Facet(DVec3, Vec<DVec3>),
}

/// Whether the first word of a file is that of a text STL. A name may stand right behind "solid".
pub(in crate::formats) fn starts_as_text(word: &[u8]) -> bool {
    let start = word.get(..5);
    // Without the first line it is cut off at the start.
    start.is_some_and(|start| start.eq_ignore_ascii_case(b"solid"))
        || word.eq_ignore_ascii_case(b"facet")
}

/// Whether a file has the keywords of a text STL, so that zeros in it are no sign of a binary one.
pub(in crate::formats) fn has_text_keywords(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(SEARCHED)];
    let has = |word| contains_ignoring_case(head, word);
    has("facet") && has("vertex") || has("endsolid")
}

/// Reads a text STL. Any number of solids makes one mesh.
pub(in crate::formats) fn read_text(text: &str, skipped: Skipped) -> Result<Parsed, Fault> {
    let mut reader = Reader {
        words: Words::new(Lines::new(text, 0), None),
        facets: Facets::new(skipped),
        place: Place::Outside,
        ended: false,
    };
    // Zeros may pad names, and Ctrl-Z stands where DOS files were joined.
    let clean;
    if text.contains(['\0', '\x1a']) {
        clean = text.replace(['\0', '\x1a'], " ");
        reader.words = Words::new(Lines::new(&clean, 0), None);
        return reader.read();
    }
    reader.read()
}

struct Reader<'a> {
    words: Words<'a>,
    facets: Facets,
    place: Place,
    /// Whether the last keyword ended a solid.
    ended: bool,
}

impl Reader<'_> {
    fn read(mut self) -> Result<Parsed, Fault> {
        let mut last = 0;
        while let Some(word) = self.words.next() {
            last = self.words.line_number();
            if let Err(fault) = self.keyword(word) {
                self.facets.skipped.skip("the facet", fault)?;
                if let Place::Facet(..) = self.place {
                    self.leave_facet();
                }
            }
        }
        if let Place::Facet(..) = self.place {
            let fault = Fault::Line(last, "the file ends in a facet".into());
            self.facets.skipped.skip("the facet", fault)?;
        }
        if !self.ended {
            let warning = "the file ends without \"endsolid\"; it may be cut off";
            self.facets.warnings.push(warning.into());
        }
        self.facets.into_parsed()
    }

    /// Reads what belongs to a keyword.
    fn keyword(&mut self, word: &str) -> Result<(), Fault> {
        self.ended = false;
        let keyword = self.whole_keyword(word);
        let line = self.words.line_number();
        let fault = |what: &str| Err(Fault::Line(line, what.into()));
        match (&*keyword, &mut self.place) {
            ("solid", Place::Outside) => self.skip_name(&["facet"]),
            ("endsolid", Place::Outside) => {
                self.skip_name(&["solid", "facet"]);
                self.ended = true;
            }
            ("facet", Place::Outside) => {
                self.facets.number += 1;
                self.place = Place::Facet(DVec3::ZERO, Vec::with_capacity(3));
                let given = self.facet_normal()?;
                if let Place::Facet(normal, _) = &mut self.place {
                    *normal = given;
                }
            }
            ("outer" | "loop" | "endloop", Place::Facet(..)) => {}
            ("color" | "colour", _) => self.skip_numbers(),
            ("vertex", Place::Facet(_, corners)) if corners.len() == 3 => {
                return fault("a facet has more than three corners; STL facets are triangles");
            }
            ("vertex", Place::Facet(..)) => {
                let corner = self.vector()?;
                if let Place::Facet(_, corners) = &mut self.place {
                    corners.push(corner);
                }
            }
            ("endfacet", Place::Facet(normal, corners)) => {
                let (normal, corners) = (*normal, <[DVec3; 3]>::try_from(corners.as_slice()));
                self.place = Place::Outside;
                let Ok(corners) = corners else {
                    return fault("a facet has fewer than three corners");
                };
                self.facets.push(normal, corners)?;
            }
            _ => return Err(Fault::Line(line, misplaced(word))),
        }
        Ok(())
    }

    /// The keyword in lower case; "end facet" and the like are one.
    fn whole_keyword(&mut self, word: &str) -> String {
        let mut keyword = word.to_ascii_lowercase();
        if keyword == "end"
            && let Some(next) = self.words.rest_of_line().next()
            && matches!(&*next.to_ascii_lowercase(), "facet" | "loop" | "solid")
        {
            self.words.next();
            keyword += &next.to_ascii_lowercase();
        }
        keyword
    }

    /// Leaves out a solid's name: the rest of the line, or what of it stands before one of some
    /// keywords, where a facet follows in the line.
    fn skip_name(&mut self, before: &[&str]) {
        let rest = || self.words.rest_of_line();
        let is = |word: &str, keyword: &str| word.eq_ignore_ascii_case(keyword);
        let pairs = rest().zip(rest().skip(1));
        let has_facet = pairs
            .into_iter()
            .any(|(a, b)| is(a, "facet") && is(b, "normal"));
        let is_next = |word: &str| has_facet && before.iter().any(|keyword| is(word, keyword));
        let length = rest().take_while(|word| !is_next(word)).count();
        for _ in 0..length {
            self.words.next_in_line();
        }
    }

    fn skip_numbers(&mut self) {
        while (self.words.rest_of_line().next()).is_some_and(|word| number(word).is_some()) {
            self.words.next_in_line();
        }
    }

    /// Goes behind the end of a facet that is wrong.
    fn leave_facet(&mut self) {
        self.place = Place::Outside;
        while let Some(word) = self.words.next() {
            if self.whole_keyword(word) == "endfacet" {
                return;
            }
        }
    }

    /// The normal after "facet normal"; zero where it is not there.
    fn facet_normal(&mut self) -> Result<DVec3, Fault> {
        let Some(word) = self.words.clone().next() else {
            return Ok(DVec3::ZERO);
        };
        match &*word.to_ascii_lowercase() {
            "normal" => {
                self.words.next();
                self.vector()
            }
            "outer" | "vertex" | "color" | "colour" => Ok(DVec3::ZERO),
            _ => {
                let what = format!("{word:?} stands where \"normal\" should");
                Err(Fault::Line(self.words.line_number(), what))
            }
        }
    }

    /// Three numbers. More of them in the line are left out.
    fn vector(&mut self) -> Result<DVec3, Fault> {
        let line = self.words.line_number();
        let mut vector = DVec3::ZERO;
        for k in 0..3 {
            let word = self.words.next().filter(|word| !is_keyword(word));
            let Some(word) = word else {
                let what = format!("there are {k} coordinates instead of 3");
                return Err(Fault::Line(line, what));
            };
            let line = self.words.line_number();
            let wrong = || Fault::Line(line, format!("{word:?} is not a number"));
            vector[k] = number(word).ok_or_else(wrong)?;
        }
        self.skip_numbers();
        Ok(vector)
    }
}

/// Keywords that may follow each other in a file.
fn is_keyword(word: &str) -> bool {
    const KEYWORDS: [&str; 12] = [
        "solid", "facet", "normal", "outer", "loop", "vertex", "endloop", "endfacet", "endsolid",
        "end", "color", "colour",
    ];
    KEYWORDS
        .iter()
        .any(|keyword| word.eq_ignore_ascii_case(keyword))
}

fn misplaced(keyword: &str) -> String {
    if is_keyword(keyword) {
        format!("{keyword:?} does not belong here")
    } else {
        format!("{keyword:?} is no keyword of an STL file")
    }
}
