//! The file beside an output that holds it until it is complete.
//!
//! It is named `.NAME.XXXXXX.part`. A lock on it says that its writer lives. What a killed program has left has no
//! lock, and the next one that writes the same output removes it.

use std::collections::BTreeSet;
use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use super::destination::directory_of;

const SUFFIX: &str = ".part";
/// Random characters in a name.
const RANDOM: usize = 6;
/// Most bytes of the output's own name in the part's: file systems take 255 in all.
const LONGEST_NAME: usize = 200;
/// How often a part is made again that another program took for one that was left behind.
const ATTEMPTS: usize = 16;

/// The parts that this program is writing.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Nothing that holds the lock leaves the set half changed.
fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what this program has begun to write and not finished, then calls `end`, which should end the
/// program. For handlers of signals: until `end` returns no output is begun or finished.
///
/// ```no_run
/// curvetri::output::remove_unfinished(|| std::process::exit(130));
/// ```
pub fn remove_unfinished(end: impl FnOnce()) {
    let parts = unfinished();
    for part in parts.iter() {
        // what is gone already is as good
        let _ = fs::remove_file(part);
    }
    end();
}

/// A file beside its output. Dropped before it is put in its place, it is removed.
pub(super) struct Part {
    file: Option<NamedTempFile>,
    place: PathBuf,
}

impl Part {
    /// Begins a file that is to become `place`, with the permissions of the one that is there.
    pub fn create(place: PathBuf, old: Option<&Metadata>) -> io::Result<Self> {
        let directory = directory_of(&place).ok_or(io::ErrorKind::IsADirectory)?;
        let prefix = prefix(&place)?;
        remove_abandoned(directory, &prefix);
        for _ in 0..ATTEMPTS {
            let part = Self {
                file: Some(make(directory, &prefix, old)?),
                place: place.clone(),
            };
            if part.lock()? {
                return Ok(part);
            }
        }
        Err(io::Error::other(
            "other programs remove the file as soon as it is made",
        ))
    }

    pub fn file(&mut self) -> &mut File {
        self.named_mut().as_file_mut()
    }

    /// Puts the file in its place.
    pub fn finish(mut self) -> io::Result<()> {
        let mut parts = unfinished();
        if let Some(file) = self.file.take() {
            parts.remove(file.path());
            file.persist(&self.place)?;
        }
        Ok(())
    }

    fn named(&self) -> &NamedTempFile {
        self.file
            .as_ref()
            .expect("a part has its file until it is finished")
    }

    fn named_mut(&mut self) -> &mut NamedTempFile {
        self.file
            .as_mut()
            .expect("a part has its file until it is finished")
    }

    /// Says that the writer lives. Whether the file is still there: another program may have looked
    /// between its making and its lock.
    fn lock(&self) -> io::Result<bool> {
        match self.named().as_file().try_lock() {
            Ok(()) => self.named().path().try_exists(),
            Err(TryLockError::WouldBlock) => Ok(false),
            // Where a file system has no locks, nothing that was left behind is found either.
            Err(TryLockError::Error(_)) => Ok(true),
        }
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            let mut parts = unfinished();
            parts.remove(file.path());
            drop(file);
        }
    }
}

fn make(directory: &Path, prefix: &str, old: Option<&Metadata>) -> io::Result<NamedTempFile> {
    let mut parts = unfinished();
    let file = tempfile::Builder::new()
        .prefix(prefix)
        .suffix(SUFFIX)
        .rand_bytes(RANDOM)
        .make_in(directory, |path| new_file(old).open(path))?;
    if let Some(old) = old {
        file.as_file().set_permissions(old.permissions())?;
    }
    parts.insert(file.path().to_path_buf());
    Ok(file)
}

/// Any new file has the permissions that the user wants for new files; one that takes the place of a private
/// one is never open to others.
fn new_file(old: Option<&Metadata>) -> OpenOptions {
    let mut options = File::options();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    if old.is_some() {
        use std::os::unix::fs::OpenOptionsExt;
        options.mode(0o600);
    }
    #[cfg(not(unix))]
    let _ = old;
    options
}

/// What the names of all parts of an output begin with.
fn prefix(place: &Path) -> io::Result<String> {
    let name = place.file_name().ok_or(io::ErrorKind::IsADirectory)?;
    let name = name.to_string_lossy();
    let end = (0..=LONGEST_NAME.min(name.len())).rfind(|&end| name.is_char_boundary(end));
    Ok(format!(".{}.", &name[..end.unwrap_or(0)]))
}

fn is_part(name: &str, prefix: &str) -> bool {
    let random = name
        .strip_prefix(prefix)
        .and_then(|rest| rest.strip_suffix(SUFFIX));
    random.is_some_and(|random| {
        random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
    })
}

/// Removes parts of the same output whose writer lives no more. What cannot be looked at is left there.
fn remove_abandoned(directory: &Path, prefix: &str) {
    let Ok(entries) = fs::read_dir(directory) else {
        return;
    };
    for entry in entries.flatten() {
        let regular = entry.file_type().is_ok_and(|kind| kind.is_file());
        if regular && is_part(&entry.file_name().to_string_lossy(), prefix) {
            let path = entry.path();
            // writing, as some file systems lock no file that is open for reading
            let file = File::options().write(true).open(&path);
            if file.is_ok_and(|file| file.try_lock().is_ok()) {
                let _ = fs::remove_file(path);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_program_left_is_removed_and_what_is_being_written_stays() {
        let directory = tempfile::tempdir().unwrap();
        let in_it = |name: &str| directory.path().join(name);
        let others = [".b.txt.abcdef.part", ".a.txt.abc.part", "a.txt.abcdef.part"];
        for name in others.iter().chain(&[".a.txt.abcdef.part"]) {
            fs::write(in_it(name), "half").unwrap();
        }
        let first = Part::create(in_it("a.txt"), None).unwrap();
        let second = Part::create(in_it("a.txt"), None).unwrap();
        assert!(!in_it(".a.txt.abcdef.part").exists());
        assert!(others.iter().all(|name| in_it(name).exists()));
        for part in [first, second] {
            assert!(part.named().path().exists());
            part.finish().unwrap();
        }
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 4);
    }

    #[test]
    fn a_long_name_has_a_part_too() {
        let directory = tempfile::tempdir().unwrap();
        let name = "\u{e9}".repeat(127); // 254 bytes
        let place = directory.path().join(&name);
        Part::create(place.clone(), None).unwrap().finish().unwrap();
        assert!(place.exists());
    }
}
