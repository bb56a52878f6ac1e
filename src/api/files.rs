//! Writes every output, so that a failure leaves no file half-written and the old files unchanged.
//!
//! What is drafted beside its place takes it in one move, with the owner and the rights of the file that was there. A file with other
//! names or behind a link stays what it is and gets the content. What is no file is written into. Several files are put into their
//! places together: a run that is killed meanwhile is completed by the next one (`marker.rs`).

mod failures;
mod kept;
mod lock;
mod marker;
mod place;
mod step;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::report::failure::Failure;

use failures::{failed, is_a_directory, within};
pub(super) use failures::{parent, there_already};
pub use kept::Was;
pub(super) use lock::Aside;
use lock::{Alone, sweep};
use marker::Mark;
pub use marker::complete;
use place::Place;
pub use place::{is_link, is_stdout};
use step::{How, Item, Step};

/// Writes one file, whole or not at all.
pub fn write(file: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_by(file, |out| out.write_all(bytes).and_then(|()| out.sync_all()))
}

/// Writes one file by a function that need not hold all of it in memory, whole or not at all. What is no file gets the content when
/// all of it is there.
pub fn write_by(file: &Path, content: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Failure> {
    let write = |error: io::Error| failed("write", file, &error);
    match Place::of(file).map_err(write)? {
        Place::File(target) => {
            let (dir, name) = split(&target)?;
            let mut draft = Draft::new(dir)?;
            draft.write(name, content)?;
            draft.publish()
        }
        Place::Stdout | Place::Stream(_) => {
            let mut draft = tempfile::tempfile().map_err(write)?;
            content(&mut draft).and_then(|()| step::pour(&mut draft, file)).map_err(write)
        }
    }
}

/// A file that was read, and what it is to hold.
#[derive(Clone, Debug)]
pub struct Rewritten<'a> {
    /// Where it is.
    pub file: &'a Path,
    /// What it held when it was read; `None` where it was not there.
    pub was: Option<Was>,
    /// What it is to hold.
    pub bytes: &'a [u8],
}

/// Writes files of one directory anew, all or none, and only where they are as they were read.
pub fn rewrite(files: &[Rewritten<'_>]) -> Result<(), Failure> {
    // Of one file the draft lies beside what its links lead to, so that it can be moved there.
    let target = match files {
        [one] => Place::of(one.file).map_err(|error| failed("write", one.file, &error))?,
        [first, ..] => Place::File(first.file.to_path_buf()),
        [] => return Ok(()),
    };
    let Place::File(target) = target else {
        return files.iter().try_for_each(|one| write(one.file, one.bytes));
    };
    let mut draft = Draft::new(split(&target)?.0)?;
    for one in files {
        let name = if files.len() == 1 { split(&target)?.1 } else { split(one.file)?.1 };
        draft.write(name, |file| file.write_all(one.bytes).and_then(|()| file.sync_all()))?;
        if let Some(item) = draft.items.last_mut() {
            item.was = Some(one.was.clone());
        }
    }
    draft.publish()
}

/// The directory of a file and its name in it.
fn split(file: &Path) -> Result<(&Path, &str), Failure> {
    let name = file.file_name().and_then(|name| name.to_str()).ok_or_else(|| {
        Failure::new(format!("{} is no name for a file", file.display())).help("give the name of a file to write")
    })?;
    Ok((parent(file), name))
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
#[derive(Debug)]
pub struct Draft {
    dir: PathBuf,
    aside: Aside,
    items: Vec<Item>,
    /// What is not part of the result.
    scratch: Option<Aside>,
    /// Whether `dir` is still to be made: then the draft becomes it, in one move.
    fresh: bool,
    /// Why the draft lies elsewhere than beside its place, where it does: then it can only be copied into files that are there.
    away: Option<io::Error>,
}

impl Draft {
    /// Begins a draft of files in `dir`, which need not be there.
    pub fn new(dir: &Path) -> Result<Self, Failure> {
        let fresh = !dir.exists();
        // On the file system of the place, because a move is atomic only within one.
        let home = if fresh { parent(dir) } else { dir };
        fs::create_dir_all(home).map_err(|error| failed("make the directory", home, &error))?;
        sweep(home);
        let write = |error: io::Error| failed("write into", home, &error);
        let (aside, away) = match Aside::new(home, fresh) {
            // A directory in which nothing may be made can have files that may be written.
            Err(error) if !fresh && matches!(error.kind(), io::ErrorKind::PermissionDenied) => {
                (Aside::new(&std::env::temp_dir(), false).map_err(write)?, Some(error))
            }
            aside => (aside.map_err(write)?, None),
        };
        Ok(Self { dir: dir.to_path_buf(), aside, items: Vec::new(), scratch: None, fresh, away })
    }

    /// Where the files will be.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Writes a file, by a function that need not hold all of it in memory. Of what can be made again, it need not wait until the
    /// disk has it.
    pub fn write(&mut self, name: &str, content: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Failure> {
        let place = within(&self.dir, name);
        let written = File::create(self.aside.path().join(name)).and_then(|mut file| content(&mut file));
        written.map_err(|error| failed("write", &place, &error))?;
        if place.is_dir() {
            return Err(is_a_directory(&place));
        }
        self.items.push(Item { name: name.to_owned(), was: None });
        Ok(())
    }

    /// Makes a folder for files that others write, which becomes one of the draft's files.
    pub fn folder(&mut self, name: &str) -> Result<PathBuf, Failure> {
        let (place, folder) = (self.dir.join(name), self.aside.path().join(name));
        if fs::symlink_metadata(&place).is_ok() {
            return Err(there_already(&place));
        }
        fs::create_dir(&folder).map_err(|error| failed("make the directory", &place, &error))?;
        self.items.push(Item { name: name.to_owned(), was: None });
        Ok(folder)
    }

    /// Takes a folder beside the output as one of the draft's files.
    pub fn adopt(&mut self, name: &str, folder: &Path) -> Result<(), Failure> {
        let place = self.folder(name)?;
        fs::rename(folder, &place).map_err(|error| failed("write", &self.dir.join(name), &error))
    }

    /// A place for a file that is not to be part of the result, and is gone when the draft is.
    pub fn scratch(&mut self, name: &str) -> Result<PathBuf, Failure> {
        let home = parent(self.aside.path());
        let scratch = Aside::new(home, false).map_err(|error| failed("write beside", &self.dir, &error))?;
        Ok(self.scratch.insert(scratch).path().join(name))
    }

    /// Puts all files into their places. A new directory appears whole; in one that was there, the files are moved
    /// one by one, and when one of them cannot be, those before it are put back as they were.
    pub fn publish(self) -> Result<(), Failure> {
        let Self { dir, aside, items, fresh, away, .. } = self;
        if fresh && fs::rename(aside.path(), &dir).is_ok() {
            aside.keep();
            return Ok(());
        }
        fs::create_dir_all(&dir).map_err(|error| failed("make the directory", &dir, &error))?;
        // One file that nobody has read is moved at once: nobody need be waited for.
        let alone = items.len() > 1 || items.iter().any(|item| item.was.is_some());
        let _alone = if alone { Some(Alone::in_directory(&dir)?) } else { None };
        if alone {
            marker::complete_alone(&dir)?;
        } else {
            complete(&dir)?;
        }
        let plan = |item| Step::plan(&dir, aside.path(), item, away.as_ref());
        let steps: Vec<Step> = items.into_iter().map(plan).collect::<Result<_, _>>()?;
        // What is done in one move, or cannot be done again, needs no mark; what lies elsewhere is found by nobody.
        let at_once = matches!(&steps[..], [Step { how: How::Move | How::Stream, .. }]);
        if at_once || away.is_some() {
            return go(&steps, aside.path());
        }
        let mark = Mark::set(&dir, &aside, &steps)?;
        go(&steps, mark.drafts())
    }
}

/// Brings all drafts to their places, or none.
fn go(steps: &[Step], drafts: &Path) -> Result<(), Failure> {
    for (done, step) in steps.iter().enumerate() {
        if let Err(failure) = step.go(drafts) {
            steps.iter().take(done).for_each(|step| step.undo(drafts));
            return Err(failure);
        }
    }
    Ok(())
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
