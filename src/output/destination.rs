//! Where a path leads, and what is there.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// As many links as Linux follows.
const MOST_LINKS: usize = 40;

/// What a path leads to.
pub(super) enum Destination {
    /// A regular file, or nothing yet. Every link on the way there has been followed.
    File {
        place: PathBuf,
        /// What is there.
        old: Option<Metadata>,
    },
    /// A pipe or a device.
    Special,
}

impl Destination {
    pub fn find(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(old) if old.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(old) if old.is_file() => Ok(Self::File {
                place: fs::canonicalize(path)?,
                old: Some(old),
            }),
            Ok(_) => Ok(Self::Special),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self::File {
                place: follow_dangling(path)?,
                old: None,
            }),
            Err(error) => Err(error),
        }
    }
}

/// The file that a link names which is not there yet; the path itself where that is no link.
fn follow_dangling(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&place) {
            Ok(found) if found.is_symlink() => {
                let target = fs::read_link(&place)?;
                place.pop();
                place.push(target); // an absolute target replaces all
            }
            _ => return Ok(place),
        }
    }
    Err(io::Error::other("too many links lead to one another"))
}

/// The directory that a file is in; none for a root.
pub(super) fn directory_of(place: &Path) -> Option<&Path> {
    match place.parent()? {
        directory if directory.as_os_str().is_empty() => Some(Path::new(".")),
        directory => Some(directory),
    }
}
