//! Writes results so that a failure leaves no file half-written and the old files unchanged.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::report::failure::Failure;
use tempfile::TempDir;

use super::config::NAME;
use super::error::{Error, ErrorKind};

/// Says how the settings of a build came to be and what they are for.
pub(super) const SETTINGS_HEAD: &str =
    "# What OpenStreetMap told and the map cannot say; `lanewright check` reads it.\n";

/// Whether a build has written these settings.
pub(super) fn wrote(settings: &Path) -> bool {
    fs::read(settings).is_ok_and(|written| written.starts_with(SETTINGS_HEAD.as_bytes()))
}

/// Refuses a directory to build into where that would write over settings that no build has written: to be asked before the
/// work begins.
///
/// # Errors
///
/// Where such settings are there.
pub fn spare(directory: &Path) -> Result<(), Error> {
    let settings = directory.join(NAME);
    if settings.is_file() && !wrote(&settings) {
        let failure =
            Failure::new(format!("{} was not written by `build`, which would write over it", settings.display()));
        return Err(ErrorKind::Write.error(
            failure
                .about(settings.display().to_string())
                .help("build into a directory of its own; the settings of directories above it count there, too"),
        ));
    }
    Ok(())
}

/// Writes one file, whole or not at all.
pub fn write(file: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let (dir, name) = split(file)?;
    publish(dir, &[(name, bytes)])
}

/// Writes one file by a function that need not hold all of it in memory, whole or not at all.
pub fn write_by(file: &Path, content: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Failure> {
    let (dir, name) = split(file)?;
    let mut draft = Draft::new(dir)?;
    draft.write(name, content)?;
    draft.publish()
}

/// Writes files of one directory, all or none.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<(), Failure> {
    let Some((first, _)) = files.first() else { return Ok(()) };
    let (dir, _) = split(first)?;
    let named: Result<Vec<_>, Failure> = files.iter().map(|(file, bytes)| Ok((split(file)?.1, *bytes))).collect();
    publish(dir, &named?)
}

/// The directory of a file and its name in it.
fn split(file: &Path) -> Result<(&Path, &str), Failure> {
    let name = file.file_name().and_then(|name| name.to_str()).ok_or_else(|| {
        Failure::new(format!("{} is no name for a file", file.display())).help("give the name of a file to write")
    })?;
    let dir = file.parent().filter(|dir| !dir.as_os_str().is_empty());
    Ok((dir.unwrap_or(Path::new(".")), name))
}

/// Writes files into `dir`, made if it is not there, all or none. The disk has them before they take the place of what was
/// there, which may be a map that nobody can make again.
pub fn publish(dir: &Path, files: &[(&str, &[u8])]) -> Result<(), Failure> {
    let mut draft = Draft::new(dir)?;
    for (name, bytes) in files {
        draft.write(name, |file| file.write_all(bytes).and_then(|()| file.sync_all()))?;
    }
    draft.publish()
}

/// Temporary files that replace the old ones when all are complete.
pub struct Draft<'a> {
    dir: &'a Path,
    aside: TempDir,
    names: Vec<String>,
    /// What is not part of the result.
    scratch: Option<TempDir>,
    /// Whether `dir` is still to be made: then the draft becomes it, in one move.
    fresh: bool,
}

impl<'a> Draft<'a> {
    /// Begins a draft of files in `dir`, which need not be there.
    pub fn new(dir: &'a Path) -> Result<Self, Failure> {
        let fresh = !dir.exists();
        // On the file system of the place, because a move is atomic only within one.
        let home = if fresh { parent(dir) } else { dir };
        fs::create_dir_all(home).map_err(|e| failed("make the directory", home, e))?;
        let aside = builder(fresh).tempdir_in(home).map_err(|e| failed("write into", home, e))?;
        Ok(Self { dir, aside, names: Vec::new(), scratch: None, fresh })
    }

    /// Where the files will be.
    pub fn dir(&self) -> &Path {
        self.dir
    }

    /// Writes a file, by a function that need not hold all of it in memory. Of what can be made again, it need not wait until the
    /// disk has it.
    pub fn write(&mut self, name: &str, content: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Failure> {
        let place = self.dir.join(name);
        let written = File::create(self.aside.path().join(name)).and_then(|mut file| content(&mut file));
        written.map_err(|e| failed("write", &place, e))?;
        if place.is_dir() {
            return Err(Failure::new(format!("{} is a directory", place.display()))
                .help("nothing was changed; move it away or give another output"));
        }
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Makes a folder for files that others write, which becomes one of the draft's files.
    pub fn folder(&mut self, name: &str) -> Result<PathBuf, Failure> {
        let (place, folder) = (self.dir.join(name), self.aside.path().join(name));
        if place.exists() {
            return Err(there_already(&place));
        }
        fs::create_dir(&folder).map_err(|e| failed("make the directory", &place, e))?;
        self.names.push(name.to_owned());
        Ok(folder)
    }

    /// Takes a folder beside the output as one of the draft's files.
    pub fn adopt(&mut self, name: &str, folder: &Path) -> Result<(), Failure> {
        let place = self.folder(name)?;
        fs::rename(folder, &place).map_err(|e| failed("write", &self.dir.join(name), e))
    }

    /// A place for a file that is not to be part of the result, and is gone when the draft is.
    pub fn scratch(&mut self, name: &str) -> Result<PathBuf, Failure> {
        let home = self.aside.path();
        let scratch = builder(false).tempdir_in(parent(home)).map_err(|e| failed("write beside", self.dir, e))?;
        Ok(self.scratch.insert(scratch).path().join(name))
    }

    /// Puts all files into their places. A new directory appears whole; in one that was there, the files are moved
    /// one by one, and when one of them cannot be, those before it are put back as they were.
    pub fn publish(self) -> Result<(), Failure> {
        if self.fresh && fs::rename(self.aside.path(), self.dir).is_ok() {
            // It stays, under its new name.
            let _ = self.aside.keep();
            return Ok(());
        }
        fs::create_dir_all(self.dir).map_err(|e| failed("make the directory", self.dir, e))?;
        let kept = builder(false).tempdir_in(self.dir).map_err(|e| failed("write into", self.dir, e))?;
        for (done, name) in self.names.iter().enumerate() {
            let [new, place, old] = [self.aside.path(), self.dir, kept.path()].map(|dir| dir.join(name));
            let moved = if exchanged(&new, &place) {
                fs::rename(&new, &old).inspect_err(|_| {
                    exchanged(&new, &place);
                })
            } else if place.exists() {
                fs::hard_link(&place, &old)
                    .or_else(|_| fs::copy(&place, &old).map(drop))
                    .and_then(|()| fs::rename(&new, &place))
            } else {
                fs::rename(&new, &place)
            };
            if let Err(error) = moved {
                self.put_back(kept.path(), done);
                return Err(failed("write", &place, error));
            }
        }
        Ok(())
    }

    /// Undoes the moves of the first files, as far as the file system still allows.
    fn put_back(&self, kept: &Path, moved: usize) {
        for name in self.names.iter().take(moved) {
            let (old, place) = (kept.join(name), self.dir.join(name));
            let _ = match (old.exists(), place.is_dir()) {
                (true, _) => fs::rename(old, place),
                (false, true) => fs::remove_dir_all(place),
                (false, false) => fs::remove_file(place),
            };
        }
    }
}

/// A directory to draft in; one that is to be the result is made with the rights that any new directory has.
fn builder<'p>(result: bool) -> tempfile::Builder<'p, 'p> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".lanewright-");
    #[cfg(unix)]
    if result {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder
}

/// A directory in another that is gone when it is dropped.
pub(super) fn aside(home: &Path) -> io::Result<TempDir> {
    builder(false).tempdir_in(home)
}

/// Whether two files could take each other's place in one move. Where one took the other's, file systems would begin to write
/// it to the disk before they go on.
#[cfg(target_os = "linux")]
fn exchanged(a: &Path, b: &Path) -> bool {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    [a, b].iter().all(|file| file.is_file()) && renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE).is_ok()
}

#[cfg(not(target_os = "linux"))]
fn exchanged(_: &Path, _: &Path) -> bool {
    false
}

/// Why nothing is written where something is.
pub(super) fn there_already(place: &Path) -> Failure {
    Failure::new(format!("{} is there already", place.display()))
        .about(place.display().to_string())
        .help("nothing was changed; move it away or give another output")
}

/// The directory in which another is, or will be.
pub(super) fn parent(dir: &Path) -> &Path {
    dir.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn failed(what: &str, path: &Path, error: io::Error) -> Failure {
    Failure::new(format!("cannot {what} {}: {error}", path.display()))
        .help("nothing was changed; check the place's permissions and free space")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_what_was_there() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a"), "old").unwrap();
        fs::create_dir(dir.path().join("b")).unwrap();
        let result = publish(dir.path(), &[("a", b"new"), ("b", b"new")]);
        assert!(result.unwrap_err().to_string().ends_with("b is a directory"));
        assert_eq!(fs::read_to_string(dir.path().join("a")).unwrap(), "old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "the draft is gone");
    }

    #[test]
    fn directories_are_made() {
        let dir = tempfile::tempdir().unwrap();
        let deep = dir.path().join("x/y");
        publish(&deep, &[("a", b"1")]).unwrap();
        assert_eq!(fs::read(deep.join("a")).unwrap(), b"1");
        assert_eq!(fs::read_dir(dir.path().join("x")).unwrap().count(), 1, "the draft became the directory");
        let plain = dir.path().join("plain");
        fs::create_dir(&plain).unwrap();
        let rights = |dir: &Path| fs::metadata(dir).unwrap().permissions();
        assert_eq!(rights(&deep), rights(&plain));
    }

    #[test]
    fn a_new_directory_appears_whole_or_not_at_all() {
        let dir = tempfile::tempdir().unwrap();
        let fresh = dir.path().join("map");
        let mut draft = Draft::new(&fresh).unwrap();
        draft.write("a", |file| file.write_all(b"1")).unwrap();
        assert!(!fresh.exists());
        assert!(draft.write("b", |_| Err(io::Error::other("the disk is full"))).is_err());
        drop(draft);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_move_that_fails_takes_back_those_before_it() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a"), "old").unwrap();
        let mut draft = Draft::new(dir.path()).unwrap();
        for name in ["a", "b", "c"] {
            draft.write(name, |file| file.write_all(b"new")).unwrap();
        }
        // What stands in the way comes only after all was written.
        fs::create_dir(dir.path().join("c")).unwrap();
        assert!(draft.publish().is_err());
        assert_eq!(fs::read_to_string(dir.path().join("a")).unwrap(), "old");
        assert!(!dir.path().join("b").exists());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "a and c, no draft");
    }
}
