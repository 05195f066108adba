//! Binary STL: a header, the number of facets, and 50 bytes a facet.

use glam::DVec3;

use super::Facets;
use crate::error::Fault;
use crate::formats::Parsed;
use crate::skipped::Skipped;

/// Bytes before the facets: anything, then their number.
const HEAD: usize = 84;

/// Bytes of each facet: the normal, three corners, and the attribute byte count.
const FACET: usize = 50;

/// Numbers of facets that say nothing: programs that write before they have counted leave them.
const UNKNOWN: [u32; 2] = [0, u32::MAX];

/// The facets of a file.
struct Layout {
    /// Where each starts.
    offsets: Vec<usize>,
    /// Where the last ends.
    end: usize,
}

impl Layout {
    /// Facets behind each other, as many as that, which there may be less of.
    fn plain(bytes: &[u8], count: usize) -> Layout {
        let whole = bytes.len().saturating_sub(HEAD) / FACET;
        let count = whole.min(count);
        Layout {
            offsets: (0..count).map(|facet| HEAD + FACET * facet).collect(),
            end: HEAD + FACET * count,
        }
    }

    /// Facets each followed by as many bytes as its attribute byte count says, if they end where the
    /// file does; and there are so many, if that is known.
    fn with_attributes(bytes: &[u8], count: Option<usize>) -> Option<Layout> {
        let mut offsets = Vec::new();
        let mut end = HEAD;
        while end < bytes.len() && count.is_none_or(|count| offsets.len() < count) {
            offsets.push(end);
            let &attributes = bytes.get(end..end + FACET)?.last_chunk()?;
            end += FACET + usize::from(u16::from_le_bytes(attributes));
        }
        let is_whole = end == bytes.len() && count.is_none_or(|count| offsets.len() == count);
        is_whole.then_some(Layout { offsets, end })
    }
}

/// The number of facets that the header promises.
fn promised(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(80..HEAD)?.first_chunk()?;
    Some(u32::from_le_bytes(*count))
}

/// Whether the length is just what the header's number of facets asks for, or where that number says
/// nothing, what some facets take.
pub(in crate::formats) fn is_whole_binary(bytes: &[u8]) -> bool {
    let Some(promised) = promised(bytes) else {
        return false;
    };
    let behind = bytes.len() - HEAD;
    if UNKNOWN.contains(&promised) {
        let is_whole =
            || behind.is_multiple_of(FACET) || Layout::with_attributes(bytes, None).is_some();
        return is_plausible(&bytes[HEAD..]) && is_whole();
    }
    let count = promised as usize;
    behind as u64 == FACET as u64 * u64::from(promised)
        || Layout::with_attributes(bytes, Some(count)).is_some()
}

/// Whether there is a header that promises no facets, and nothing behind it.
pub(in crate::formats) fn is_empty_binary(bytes: &[u8]) -> bool {
    bytes.len() == HEAD && promised(bytes) == Some(0)
}

/// Whether some bytes start with a facet of usual numbers.
fn is_plausible(facet: &[u8]) -> bool {
    let Some(facet) = facet.first_chunk::<FACET>() else {
        return false;
    };
    let (_, corners) = numbers(facet);
    let is_usual = |x: f64| x == 0.0 || (1e-12..1e12).contains(&x.abs());
    let [a, b, c] = corners;
    corners
        .iter()
        .all(|p| p.to_array().into_iter().all(is_usual))
        && a != b
        && b != c
        && c != a
}

/// The normal and the corners of a facet.
fn numbers(facet: &[u8; FACET]) -> (DVec3, [DVec3; 3]) {
    let (numbers, _) = facet.as_chunks::<4>();
    let vector = |k: usize| {
        let part = |i: usize| f64::from(f32::from_le_bytes(numbers[3 * k + i]));
        DVec3::new(part(0), part(1), part(2))
    };
    (vector(0), [vector(1), vector(2), vector(3)])
}

/// Reads a binary STL.
pub(in crate::formats) fn read_binary(bytes: &[u8], skipped: Skipped) -> Result<Parsed, Fault> {
    let Some(promised) = promised(bytes) else {
        return Err(Fault::Content(
            "the file is too short for a binary STL".into(),
        ));
    };
    let mut facets = Facets::new(skipped);
    let layout = layout(bytes, promised, &mut facets)?;
    facets.positions.reserve_exact(3 * layout.offsets.len());
    for offset in layout.offsets {
        let facet = bytes[offset..].first_chunk();
        let (normal, corners) = numbers(facet.expect("the layout ends within the file"));
        facets.number += 1;
        if let Err(fault) = facets.push(normal, corners) {
            facets.skipped.skip("the facet", fault)?;
        }
    }
    let behind = bytes.len() - layout.end;
    if behind > 0 {
        let warning = format!("{behind} bytes after the last facet were not read");
        facets.warnings.push(warning);
    }
    facets.into_parsed()
}

/// Where the facets are: with bytes behind each where the file's length agrees with that, else
/// without.
fn layout(bytes: &[u8], promised: u32, facets: &mut Facets) -> Result<Layout, Fault> {
    let is_unknown = UNKNOWN.contains(&promised);
    let count = (!is_unknown).then_some(promised as usize);
    let plain = Layout::plain(bytes, count.unwrap_or(usize::MAX));
    let layout = if plain.end == bytes.len() && count.is_none_or(|n| n == plain.offsets.len()) {
        plain
    } else {
        Layout::with_attributes(bytes, count).unwrap_or(plain)
    };
    let found = layout.offsets.len();
    match count {
        None if found > 0 => facets.warnings.push(format!(
            "the header says {promised} facets, which is wrong; {found} were read, as the file's \
             length says"
        )),
        Some(count) if found < count => {
            let what = format!(
                "the file ends in facet {}, but its header promises {count} facets",
                found + 1
            );
            let missing = "the facets that are missing";
            facets.skipped.skip(missing, Fault::Content(what))?;
        }
        _ => {}
    }
    Ok(layout)
}
