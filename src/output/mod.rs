//! Files that appear whole or not at all.

mod destination;
mod part;

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use destination::Destination;
use part::Part;
pub use part::remove_unfinished;

/// A file in the making: written beside its place and renamed when it is complete, so that whoever
/// looks finds the old file or the new one. Dropped before that, it leaves nothing behind. A program that
/// handles signals calls [`remove_unfinished`] before it ends; what one that was killed has left is removed
/// when the same output is written again.
///
/// Links are followed, also to a file that is not there yet. The new file has the old one's permissions.
/// What is not a regular file (a pipe, a device) is written directly.
///
/// ```
/// use curvetri::output::{OutputError, OutputFile};
///
/// let path = std::env::temp_dir().join("curvetri-example.txt");
/// let file = OutputFile::create(&path)?; // fails here where nothing can be written
/// file.finish(|out| out.write_all(b"all of it"))?;
/// # std::fs::remove_file(path).unwrap();
/// # Ok::<(), OutputError>(())
/// ```
pub struct OutputFile {
    path: PathBuf,
    writer: BufWriter<Sink>,
}

/// Why a file could not be written.
#[derive(Debug, Error)]
#[error("cannot write {}", path.display())]
pub struct OutputError {
    /// The file.
    pub path: PathBuf,
    /// Why, as the operating system or whoever writes the content says.
    pub source: io::Error,
}

enum Sink {
    /// Beside its place until it is complete.
    Beside(Part),
    Direct(File),
}

impl OutputFile {
    /// Begins a file, so that an output that cannot be written is known before the work.
    ///
    /// # Errors
    /// If the directory does not exist or cannot be written to, or the path is a directory.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref();
        let sink = Sink::open(path).map_err(|source| OutputError {
            path: path.into(),
            source,
        })?;
        Ok(Self {
            path: path.into(),
            writer: BufWriter::new(sink),
        })
    }

    /// Writes the content and puts the file in its place.
    ///
    /// # Errors
    /// What `write` or the operating system says; the place is as it was before.
    pub fn finish<W>(mut self, write: W) -> Result<(), OutputError>
    where
        W: FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
    {
        write(&mut self.writer)
            .and_then(|()| {
                self.writer
                    .into_inner()
                    .map_err(io::IntoInnerError::into_error)
            })
            .and_then(Sink::close)
            .map_err(|source| OutputError {
                path: self.path,
                source,
            })
    }
}

/// Where content goes: archives need to go back to what they have written.
pub trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

impl Sink {
    fn open(path: &Path) -> io::Result<Self> {
        match Destination::find(path)? {
            Destination::File { place, old } => {
                Ok(Self::Beside(Part::create(place, old.as_ref())?))
            }
            Destination::Special => Ok(Self::Direct(File::options().write(true).open(path)?)),
        }
    }

    fn close(self) -> io::Result<()> {
        match self {
            Self::Beside(part) => part.finish(),
            Self::Direct(mut file) => file.flush(),
        }
    }

    fn file(&mut self) -> &mut File {
        match self {
            Self::Beside(part) => part.file(),
            Self::Direct(file) => file,
        }
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file().flush()
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.file().seek(to)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn a_file_appears_when_it_is_complete() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        let file = OutputFile::create(&path).unwrap();
        assert!(!path.exists());
        file.finish(|out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(directory.path()), ["a.txt"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_beside_it() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let file = OutputFile::create(&path).unwrap();
        let error = file
            .finish(|out| {
                out.write_all(b"half")?;
                Err(io::Error::other("no more"))
            })
            .unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("cannot write {}", path.display())
        );
        assert_eq!(error.source.to_string(), "no more");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(OutputFile::create(&path).unwrap());
        assert_eq!(names(directory.path()), ["a.txt"]);
    }

    #[test]
    fn a_directory_that_is_not_there_is_named() {
        let path = Path::new("/no/such/directory/a.png");
        let error = OutputFile::create(path).err().unwrap();
        assert_eq!(error.to_string(), "cannot write /no/such/directory/a.png");
        assert_eq!(error.source.kind(), io::ErrorKind::NotFound);
        assert!(OutputFile::create("/").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_stay_devices() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let (path, link) = (directory.path().join("a"), directory.path().join("b"));
        File::create(&path).unwrap();
        let usual = fs::metadata(&path).unwrap().permissions().mode();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        OutputFile::create(&link)
            .unwrap()
            .finish(|out| out.write_all(b"x"))
            .unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"x");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode(), usual);
        OutputFile::create("/dev/null")
            .unwrap()
            .finish(|out| out.write_all(b"x"))
            .unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn a_private_file_stays_private() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a");
        for mode in [0o600, 0o640, 0o666] {
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            let file = OutputFile::create(&path).unwrap();
            file.finish(|out| out.write_all(b"new")).unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"new");
            let found = fs::metadata(&path).unwrap().permissions().mode();
            assert_eq!(found & 0o7777, mode);
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_to_what_is_not_there_yet_are_followed() {
        use std::os::unix::fs::symlink;
        let directory = tempfile::tempdir().unwrap();
        let in_it = |name: &str| directory.path().join(name);
        fs::create_dir(in_it("there")).unwrap();
        symlink("there/target", in_it("second")).unwrap();
        symlink(in_it("second"), in_it("first")).unwrap();
        let file = OutputFile::create(in_it("first")).unwrap();
        file.finish(|out| out.write_all(b"x")).unwrap();
        assert_eq!(fs::read(in_it("there/target")).unwrap(), b"x");
        assert!(fs::symlink_metadata(in_it("first")).unwrap().is_symlink());
        assert!(fs::symlink_metadata(in_it("second")).unwrap().is_symlink());

        symlink("nowhere/target", in_it("broken")).unwrap();
        assert!(OutputFile::create(in_it("broken")).is_err());
        symlink("circle", in_it("circle")).unwrap();
        assert!(OutputFile::create(in_it("circle")).is_err());
        assert!(fs::symlink_metadata(in_it("broken")).unwrap().is_symlink());
    }
}
