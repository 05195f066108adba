//! Which format a file is of, by its content.

use super::stl::{stl_facets, stl_length};
use super::text::is_utf16;

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
    Ply,
    StlText,
    StlBinary,
    Off,
    /// JSON.
    Gltf,
    /// JSON and buffers in one file.
    Glb,
}

/// How files start that are no meshes or not read.
const OTHERS: [(&[u8], &str); 7] = [
    (b"PK\x03\x04", "this is a ZIP archive (3MF files are, too)"),
    (b"Kaydara FBX", "this is an FBX file"),
    (b"BLENDER", "this is a Blender file"),
    (b"\x89PNG", "this is a PNG picture"),
    (b"\xff\xd8\xff", "this is a JPEG picture"),
    (b"7z\xbc\xaf", "this is a 7z archive"),
    (b"<", "this is an XML file"),
];

/// The format of a file, or what it is instead. A name that ends in `.stl` only helps to recognise
/// binary files that are cut off: those are known by their length.
pub(super) fn detect(bytes: &[u8], named_stl: bool) -> Result<Format, &'static str> {
    if bytes.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    if let Some((_, what)) = OTHERS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Err(what);
    }
    let word = first_word(bytes);
    if word == b"ply" {
        return Ok(Format::Ply);
    }
    if is_whole_stl(bytes) {
        return Ok(Format::StlBinary);
    }
    let is_text = is_utf16(bytes) || !bytes.contains(&0);
    match word {
        b"solid" | b"SOLID" | b"Solid" if is_text => Ok(Format::StlText),
        _ if word.starts_with(b"{") && is_text => Ok(Format::Gltf),
        _ if is_off_keyword(word) => Ok(Format::Off),
        _ if is_text => Ok(Format::Obj),
        _ if named_stl || word.starts_with(b"solid") => Ok(Format::StlBinary),
        _ => Err("this is a binary file of an unknown format"),
    }
}

/// The first word outside comments.
fn first_word(bytes: &[u8]) -> &[u8] {
    let mut lines = bytes.split(|&b| b == b'\n' || b == b'\r');
    lines
        .find_map(|line| {
            let line = line.trim_ascii_start();
            let word = line.split(u8::is_ascii_whitespace).next()?;
            (!word.is_empty() && word[0] != b'#').then_some(word)
        })
        .unwrap_or_default()
}

/// Whether the length is just what the number of facets in a binary STL's header asks for.
fn is_whole_stl(bytes: &[u8]) -> bool {
    stl_facets(bytes).is_some_and(|n| Some(bytes.len()) == stl_length(n))
}

/// Whether a word is the keyword of an OFF file, with what its vertices have: texture coordinates,
/// colours, normals, four coordinates, or as many as a number says.
pub(super) fn is_off_keyword(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"ST").unwrap_or(word);
    let word = word.strip_prefix(b"C").unwrap_or(word);
    let word = word.strip_prefix(b"N").unwrap_or(word);
    let word = word.strip_prefix(b"4").unwrap_or(word);
    word.strip_prefix(b"n").unwrap_or(word) == b"OFF"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stl(head: &[u8], facets: u32, length: usize) -> Vec<u8> {
        let mut bytes = head.to_vec();
        bytes.resize(80, 0);
        bytes.extend(facets.to_le_bytes());
        bytes.resize(length, 0);
        bytes
    }

    #[test]
    fn formats_are_told_by_content() {
        let format = |bytes: &[u8]| detect(bytes, false);
        assert_eq!(format(b"ply\r\nformat ascii 1.0\n"), Ok(Format::Ply));
        assert_eq!(format(b"solid x\nendsolid x\n"), Ok(Format::StlText));
        assert_eq!(format(b" {\"asset\": 1}"), Ok(Format::Gltf));
        assert_eq!(format(b"glTF\x02\0\0\0"), Ok(Format::Glb));
        for off in ["OFF", "# by hand\n\nOFF BINARY", "STCN4nOFF", "COFF"] {
            assert_eq!(format(off.as_bytes()), Ok(Format::Off), "{off}");
        }
        assert_eq!(format(b"OFFICE"), Ok(Format::Obj));
        assert_eq!(format(b"v 0 0 0\n"), Ok(Format::Obj));
        assert_eq!(format(b""), Ok(Format::Obj));
        assert_eq!(format(b"\xff\xfev\0 \0"), Ok(Format::Obj));
    }

    #[test]
    fn a_binary_stl_is_known_by_its_length_even_if_it_calls_itself_solid() {
        for head in [&b"solid by hand"[..], b"", b"v 0 0 0"] {
            let whole = detect(&stl(head, 2, 184), false);
            assert_eq!(whole, Ok(Format::StlBinary));
        }
        let short = stl(b"", 2, 183);
        assert_eq!(detect(&short, true), Ok(Format::StlBinary));
        assert!(detect(&short, false).is_err());
        let short = stl(b"solid", 2, 183);
        assert_eq!(detect(&short, false), Ok(Format::StlBinary));
    }

    #[test]
    fn other_files_are_named() {
        let what = |bytes: &[u8]| detect(bytes, false).unwrap_err();
        assert_eq!(what(b"<?xml version='1.0'?>"), "this is an XML file");
        assert!(what(b"PK\x03\x04").contains("3MF"));
        assert!(what(b"v 0 0 0\0").contains("unknown format"));
    }
}
