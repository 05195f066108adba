//! Which format a file has, by its content.

use super::text::{contains_ignoring_case, first_line, length_without_padding, number};
use super::{off, stl};

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

/// How files start that are no meshes or not read, in any case, and what they are.
const OTHERS: [(&str, &str); 48] = [
    (
        "version https://git-lfs",
        "this is a Git LFS pointer in place of the file; `git lfs pull` fetches the file itself",
    ),
    (
        "ISO-10303-21",
        "this is a STEP file; its program can export a mesh",
    ),
    ("#VRML", "this is a VRML file"),
    ("#X3D", "this is an X3D file"),
    ("#usda", "this is a USD file"),
    ("PXR-USDC", "this is a USD file"),
    ("; FBX", "this is an FBX file"),
    ("Kaydara FBX", "this is an FBX file"),
    ("BLENDER", "this is a Blender file; Blender can export it"),
    (
        "# .PCD",
        "this is a point cloud (PCD); it has points, no faces",
    ),
    (
        "LASF",
        "this is a point cloud (LAS); it has points, no faces",
    ),
    (
        "ASTM-E57",
        "this is a point cloud (E57); it has points, no faces",
    ),
    ("0\nSECTION", DXF),
    ("0\r\nSECTION", DXF),
    ("999\n", DXF),
    ("999\r\n", DXF),
    ("AutoCAD Binary DXF", DXF),
    (
        "//Maya ASCII",
        "this is a Maya file; Maya can export a mesh",
    ),
    ("*HEADING", "this is an Abaqus file"),
    ("\u{89}HDF", "this is an HDF5 file"),
    ("# vtk DataFile", "this is a VTK file"),
    ("$MeshFormat", "this is a Gmsh file"),
    ("MeshVersionFormatted", "this is a Medit file"),
    (
        "3D Geometry File Format",
        "this is a Rhino file; Rhino can export a mesh",
    ),
    (
        "DBRep_DrawableShape",
        "this is a BREP file; its program can export a mesh",
    ),
    (
        "CASCADE Topology",
        "this is a BREP file; its program can export a mesh",
    ),
    ("Ogawa", "this is an Alembic file"),
    ("xof 0", "this is a DirectX file"),
    (
        "AC10",
        "this is a DWG drawing; its program can export a mesh",
    ),
    ("0\rSECTION", DXF),
    (
        "DRACO",
        "this is a Draco file; `draco_decoder` makes an OBJ or PLY file of it",
    ),
    (
        "newmtl",
        "this is a material library; the OBJ file that names it has the mesh",
    ),
    (
        "PK\x03\x04",
        "this is a ZIP archive (3MF and USDZ files are, too)",
    ),
    ("7z¼¯", "this is a 7z archive; unpack it first"),
    ("Rar!", "this is a RAR archive; unpack it first"),
    ("BZh", "this is packed by bzip2; unpack it first"),
    ("ý7zXZ", "this is packed by xz; unpack it first"),
    ("(µ/ý", "this is packed by Zstandard; unpack it first"),
    (
        "ÐÏ\x11à",
        "this is a file of SolidWorks or another Windows program; export a mesh there",
    ),
    ("%PDF", "this is a PDF file"),
    ("\u{89}PNG", "this is a PNG picture"),
    ("ÿØÿ", "this is a JPEG picture"),
    ("GIF8", "this is a GIF picture"),
    ("<!DOCTYPE html", HTML),
    ("<html", HTML),
    ("<COLLADA", COLLADA),
    ("<X3D", "this is an X3D file"),
    ("<", "this is an XML file"),
];

const HTML: &str = "this is a web page in place of the file; see what it says in a browser";
const DXF: &str = "this is a DXF drawing; its program can export a mesh";
const COLLADA: &str = "this is a COLLADA file";

/// How many bytes at the start of an XML file are searched for its kind, which may come late.
const XML_HEAD: usize = 1024;

/// How much of a line is told.
const LONGEST_QUOTE: usize = 40;

/// The format of a file, or what it is instead. A name that ends in `.stl` only helps to recognise
/// binary files that are cut off: those are known by their length.
pub(super) fn detect(bytes: &[u8], named_stl: bool) -> Result<Format, String> {
    if bytes.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    if stl::is_whole_binary(bytes) || named_stl && stl::is_empty_binary(bytes) {
        return Ok(Format::StlBinary);
    }
    if let Some(what) = other(bytes.trim_ascii_start()) {
        return Err(what.into());
    }
    let word = first_word(bytes);
    if word.eq_ignore_ascii_case(b"ply") {
        return Ok(Format::Ply);
    }
    let text = &bytes[..length_without_padding(bytes)];
    let is_text = !text.contains(&0);
    if stl::starts_as_text(word) && (is_text || stl::has_text_keywords(text)) {
        return Ok(Format::StlText);
    }
    if off::is_keyword(word) {
        return Ok(Format::Off);
    }
    if is_text {
        return match word.first() {
            Some(b'{') => Ok(Format::Gltf),
            _ if is_obj(text) => Ok(Format::Obj),
            _ => Err(unknown_text(text)),
        };
    }
    if named_stl || stl::starts_as_text(word) {
        return Ok(Format::StlBinary);
    }
    Err("this is a binary file of an unknown format".into())
}

/// What a file is that is not read.
fn other(bytes: &[u8]) -> Option<&'static str> {
    let starts = |start: &str| {
        // The table's characters stand for bytes.
        let mut start = start.chars().map(|c| c as u32 as u8);
        let start: Vec<u8> = start.by_ref().collect();
        let head = bytes.get(..start.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(&start))
    };
    let (start, what) = OTHERS.iter().find(|(start, _)| starts(start))?;
    if *start != "<" {
        return Some(what);
    }
    let head = &bytes[..bytes.len().min(XML_HEAD)];
    let inner = |tag: &&(&str, &str)| tag.0.starts_with('<') && contains_ignoring_case(head, tag.0);
    // The last is any XML.
    let (_, what) = OTHERS
        .iter()
        .find(inner)
        .unwrap_or(&OTHERS[OTHERS.len() - 1]);
    Some(what)
}

/// The lines that are neither blank nor start with `#`.
fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut left = bytes;
    let all = std::iter::from_fn(move || {
        let (length, end) = first_line(left);
        let line = &left[..length];
        left = &left[length + end..];
        (length + end > 0).then(|| line.trim_ascii())
    });
    all.filter(|line| !line.is_empty() && line[0] != b'#')
}

/// The first word outside comments.
fn first_word(bytes: &[u8]) -> &[u8] {
    let line = lines(bytes).next().unwrap_or_default();
    line.split(u8::is_ascii_whitespace)
        .next()
        .unwrap_or_default()
}

/// Whether a text is OBJ: some line has a keyword of it and a number, or all lines have keywords.
fn is_obj(text: &[u8]) -> bool {
    const NUMBERS: [&[u8]; 11] = [
        b"v", b"f", b"vn", b"vt", b"vp", b"fo", b"l", b"p", b"curv", b"curv2", b"surf",
    ];
    const NAMES: [&[u8]; 5] = [b"o", b"g", b"s", b"mtllib", b"usemtl"];
    fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
        let words = line.split(u8::is_ascii_whitespace);
        words.filter(|word| !word.is_empty())
    }
    let has_number = |line| {
        let mut words = words(line);
        words.next().is_some_and(|word| NUMBERS.contains(&word))
            && words.next().is_some_and(starts_as_number)
    };
    let has_keyword = |line| {
        let word = words(line).next();
        word.is_some_and(|word| NUMBERS.contains(&word) || NAMES.contains(&word))
    };
    lines(text).any(has_number) || lines(text).next().is_some() && lines(text).all(has_keyword)
}

/// Whether a word of an OBJ file may be a number; a backslash may stand before it, in the next line.
fn starts_as_number(word: &[u8]) -> bool {
    word.starts_with(b"\\")
        || word
            .iter()
            .find(|byte| !b"+-.".contains(byte))
            .is_some_and(u8::is_ascii_digit)
        || std::str::from_utf8(word).is_ok_and(|word| number(word).is_some())
}

/// What a text is that is no mesh.
fn unknown_text(text: &[u8]) -> String {
    if text.trim_ascii().is_empty() {
        return "the file is empty".into();
    }
    let points = || lines(text).filter(|line| is_point(line)).count();
    // The first line may say how many there are, or name the columns.
    if lines(text).skip(1).take(2).any(is_point) || lines(text).next().is_some_and(is_point) {
        return format!(
            "this is a point cloud (XYZ text): {} points, no faces",
            points()
        );
    }
    let all = text.split(|&byte| byte == b'\n' || byte == b'\r');
    let mut first = all.map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    let line = String::from_utf8_lossy(first.next().unwrap_or_default());
    let quote: String = line.chars().take(LONGEST_QUOTE).collect();
    let more = if line.chars().nth(LONGEST_QUOTE).is_some() {
        "..."
    } else {
        ""
    };
    format!("this is a text of an unknown format: it begins with {quote:?}{more}")
}

/// Whether a line is three numbers or more.
fn is_point(line: &[u8]) -> bool {
    let words = line.split(|byte| byte.is_ascii_whitespace() || b",;".contains(byte));
    let mut words = words.filter(|word| !word.is_empty());
    let is_number = |word: &[u8]| std::str::from_utf8(word).is_ok_and(|w| number(w).is_some());
    words.clone().count() >= 3 && words.all(is_number)
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
    fn formats_are_known_by_content() {
        let format = |bytes: &[u8]| detect(bytes, false);
        assert_eq!(format(b"ply\r\nformat ascii 1.0\n"), Ok(Format::Ply));
        assert_eq!(format(b"PLY\nformat ascii 1.0\n"), Ok(Format::Ply));
        assert_eq!(format(b"solid x\nendsolid x\n"), Ok(Format::StlText));
        assert_eq!(format(b"\nSOLID\nfacet\n"), Ok(Format::StlText));
        assert_eq!(format(b"Facet normal 0 0 1\n"), Ok(Format::StlText));
        assert_eq!(format(b" {\"asset\": 1}"), Ok(Format::Gltf));
        assert_eq!(format(b"glTF\x02\0\0\0"), Ok(Format::Glb));
        for off in [
            "OFF",
            "# by hand\n\nOFF BINARY",
            "STCN4nOFF",
            "NCOFF",
            "off",
            "OFF490 518 0",
        ] {
            assert_eq!(format(off.as_bytes()), Ok(Format::Off), "{off}");
        }
        assert_eq!(format(b"v 0 0 0\n"), Ok(Format::Obj));
        assert_eq!(format(b"rubbish\rf 1 2 3"), Ok(Format::Obj));
        for obj in [
            "mtllib x\n\0\0\x1a",
            "see below\nv -.5 0 0\n",
            "v \\\n 0 0 0\n",
            "v nan 0 0",
        ] {
            assert_eq!(format(obj.as_bytes()), Ok(Format::Obj), "{obj}");
        }
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
    fn other_files_are_named_and_the_way_out_where_there_is_one() {
        let what = |bytes: &[u8]| detect(bytes, true).unwrap_err();
        assert_eq!(what(b"<?xml version='1.0'?>"), "this is an XML file");
        assert_eq!(
            what(b"<?xml version='1.0'?>\n<collada>"),
            "this is a COLLADA file"
        );
        assert!(what(b"<!doctype HTML>").contains("web page"));
        assert!(what(b"PK\x03\x04").contains("3MF"));
        assert!(what(b"\xff\xd8\xff\xe0").contains("JPEG"));
        assert!(what(b"\xd0\xcf\x11\xe0\xa1").contains("SolidWorks"));
        assert!(what(b"version https://git-lfs.github.com/spec/v1\n").contains("git lfs pull"));
        assert!(what(b"ISO-10303-21;\nHEADER;\n").contains("STEP"));
        assert!(what(b"#VRML V2.0 utf8\n").contains("VRML"));
        assert!(what(b"//Maya ASCII 2022 scene\n").contains("Maya"));
        assert!(what(b"#usda 1.0\n").contains("USD"));
        assert!(what(b"  0\r\nSECTION\r\n  2\r\nHEADER").contains("DXF"));
        assert_eq!(what(b""), "the file is empty");
        assert_eq!(what(b"\r\n \0\0"), "the file is empty");
    }

    #[test]
    fn point_clouds_and_other_texts_are_told() {
        let what = |text: &str| detect(text.as_bytes(), true).unwrap_err();
        let cloud = "this is a point cloud (XYZ text): 3 points, no faces";
        assert_eq!(what("0 0 0\n1 0 0 255\n\n# x\n0 1 nan\n"), cloud);
        assert_eq!(what("3\r0 0 0\r1 0 0\r0 1 0\r"), cloud);
        assert_eq!(what("x,y,z\n0,0,0\n1,0,0\n0,1,0"), cloud);
        assert_eq!(
            what("\n# dear all\nhello"),
            "this is a text of an unknown format: it begins with \"# dear all\""
        );
        let long = what(&"a".repeat(100));
        assert!(
            long.ends_with(&format!("with \"{}\"...", "a".repeat(40))),
            "{long}"
        );
        for prose in [
            "v is a letter\nas is o\n",
            "f. 12\np and q",
            "\ng force\nof l is 12",
        ] {
            assert!(what(prose).contains("unknown format"), "{prose}");
        }
        assert!(what("OFFICE hours").contains("OFFICE"));
        assert!(what("coffee 1 2 3").contains("coffee"));
    }
}
