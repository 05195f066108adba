//! Files that are damaged, for tests of the readers.

use proptest::prelude::*;
use proptest::sample::{Index, select};

use crate::Loader;

/// One of the files with some bytes and digits changed, and perhaps cut off.
pub(crate) fn damaged(files: Vec<Vec<u8>>) -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop::collection::vec((any::<Index>(), any::<u8>()), 0..5);
    // Changed digits leave the rest whole, and so get further.
    let digits = prop::collection::vec((any::<Index>(), b'0'..=b'9'), 0..5);
    let cut = prop::option::of(any::<Index>());
    (select(files), bytes, digits, cut).prop_map(|(mut file, bytes, digits, cut)| {
        for (at, byte) in bytes {
            let at = at.index(file.len());
            file[at] = byte;
        }
        let places: Vec<usize> = (0..file.len())
            .filter(|&i| file[i].is_ascii_digit())
            .collect();
        for (at, digit) in digits {
            if !places.is_empty() {
                file[places[at.index(places.len())]] = digit;
            }
        }
        if let Some(cut) = cut {
            file.truncate(cut.index(file.len()));
        }
        file
    })
}

/// Reads a file, also leniently: an error names it, and a mesh is sound.
pub(crate) fn check(file: Vec<u8>) -> Result<(), TestCaseError> {
    check_by(Loader::new(), file.clone())?;
    check_by(Loader::new().lenient(true), file)
}

fn check_by(loader: Loader<'_>, file: Vec<u8>) -> Result<(), TestCaseError> {
    let parts = loader.load_parts_bytes(file.clone(), "damaged".as_ref());
    let whole = loader.load_bytes(file, "damaged");
    prop_assert_eq!(parts.is_ok(), whole.is_ok());
    if let (Ok(parts), Ok(whole)) = (parts, &whole) {
        prop_assert_eq!(parts.parts.triangles(), whole.mesh.triangles().len());
        prop_assert_eq!(parts.scenery, whole.scenery.clone());
    }
    match whole {
        Err(error) => prop_assert!(error.to_string().starts_with("damaged:"), "{error}"),
        Ok(loaded) => {
            let mesh = loaded.mesh;
            prop_assert!(mesh.positions().iter().all(|p| p.is_finite()));
            prop_assert!(mesh.normals().iter().all(|n| n.is_normalized()));
            prop_assert_eq!(mesh.positions().len(), mesh.normals().len());
            let mut indices = mesh.triangles().as_flattened().iter();
            prop_assert!(indices.all(|&i| (i as usize) < mesh.positions().len()));
        }
    }
    Ok(())
}
