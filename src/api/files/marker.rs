//! The mark of a run that is putting several files into their places: if it is killed, the next run that writes or reads there
//! completes it. All drafts are complete before the mark is set.
//!
//! A mark is believed only where the files have the numbers, on this disk, that it names: one that came with a download or a copy
//! moves nothing.

use std::fs;
use std::io::Write;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::failures::failed;
use super::kept::Stamp;
use super::lock::{Alone, Aside, swept_name};
use super::place::Place;
use super::step::{How, Step, into_file, kept_in};
use crate::report::failure::Failure;

/// The folder of the drafts while they are put into their places.
const MARK: &str = ".lanewright-writing";
/// What is to be done, in that folder.
const PLAN: &str = ".plan.json";

/// One draft as the plan has it.
#[derive(Debug, Serialize, Deserialize)]
struct Planned {
    name: String,
    copy: bool,
    /// Number of the draft on the disk.
    new: u64,
    /// Number, length and time of what was there.
    old: Option<[u64; 3]>,
}

/// A set mark: it holds the drafts under another name until it is dropped.
pub(super) struct Mark<'a> {
    aside: &'a Aside,
    folder: PathBuf,
}

impl<'a> Mark<'a> {
    /// Sets the mark in a directory.
    pub(super) fn set(dir: &Path, aside: &'a Aside, steps: &[Step]) -> Result<Self, Failure> {
        let planned = steps.iter().filter(|step| step.how != How::Stream).map(|step| Planned {
            name: step.name.clone(),
            copy: step.how == How::Copy,
            new: step.new,
            old: step.old.map(|old| [old.file, old.length, old.changed]),
        });
        let planned: Vec<Planned> = planned.collect();
        let folder = dir.join(MARK);
        let plan = aside.path().join(PLAN);
        let written = serde_json::to_vec(&planned).map_err(std::io::Error::other).and_then(|text| {
            fs::File::create(plan)?.write_all(&text)?;
            fs::rename(aside.path(), &folder)
        });
        written.map_err(|error| failed("write into", dir, &error))?;
        Ok(Self { aside, folder })
    }

    /// Where the drafts are.
    pub(super) fn drafts(&self) -> &Path {
        &self.folder
    }
}

impl Drop for Mark<'_> {
    fn drop(&mut self) {
        // Under its old name it is removed.
        let _ = fs::rename(&self.folder, self.aside.path());
    }
}

/// Completes what a killed run has begun in a directory. Says whether there was something.
///
/// # Errors
///
/// Where it cannot be completed.
pub fn complete(dir: &Path) -> Result<bool, Failure> {
    if fs::symlink_metadata(dir.join(MARK)).is_err() {
        return Ok(false);
    }
    let _alone = Alone::in_directory(dir)?;
    complete_alone(dir)
}

/// The same where no other run writes.
pub(super) fn complete_alone(dir: &Path) -> Result<bool, Failure> {
    let folder = dir.join(MARK);
    if fs::symlink_metadata(&folder).is_err() {
        // The other run has done it itself.
        return Ok(false);
    }
    let stuck = |why: &str| {
        let what = "a run was killed while it put files into their places, and this one cannot complete it";
        Failure::new(format!("{}: {what}: {why}", folder.display())).about(folder.display().to_string()).help(format!(
            "the new files are in {0}, those that they replace in {0}/.before: move what is wanted, then remove the folder",
            folder.display()
        ))
    };
    let plan: Vec<Planned> = fs::read(folder.join(PLAN))
        .ok()
        .and_then(|text| serde_json::from_slice(&text).ok())
        .ok_or_else(|| stuck("it has no plan"))?;
    let open: Result<Vec<(bool, PathBuf, PathBuf)>, Failure> =
        plan.iter().filter_map(|one| one.open(dir, &folder).map_err(&stuck).transpose()).collect();
    for (copy, draft, place) in open? {
        let done = if copy { into_file(&draft, &place) } else { fs::rename(&draft, &place) };
        done.map_err(|error| stuck(&format!("{}: {error}", place.display())))?;
    }
    let swept = swept_name(dir);
    fs::rename(&folder, &swept).map_err(|error| stuck(&error.to_string()))?;
    let _ = fs::remove_dir_all(swept);
    Ok(true)
}

impl Planned {
    /// The draft and its place, if the one is not yet at the other; whether it is to be copied.
    fn open(&self, dir: &Path, folder: &Path) -> Result<Option<(bool, PathBuf, PathBuf)>, &'static str> {
        /// Without numbers of files, nothing tells whether a mark was set here.
        const FOREIGN: &str = "what is there is not what that run has left";
        let mut parts = Path::new(&self.name).components();
        if !matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None)) || self.new == 0 {
            return Err(FOREIGN);
        }
        let (draft, place) = (folder.join(&self.name), dir.join(&self.name));
        let old = self.old.map(|[file, length, changed]| Stamp { file, length, changed });
        let is_draft = Stamp::at(&draft).is_some_and(|stamp| stamp.file == self.new);
        if self.copy {
            let Ok(Place::File(target)) = Place::of(&place) else { return Err(FOREIGN) };
            let (there, old) = (Stamp::at(&target).ok_or(FOREIGN)?, old.ok_or(FOREIGN)?);
            let is_ours = there == old || is_partly(&target, &draft, &kept_in(folder, &self.name));
            return match is_draft && there.file == old.file && is_ours {
                true => Ok(Some((true, draft, target))),
                false => Err(FOREIGN),
            };
        }
        match Stamp::at(&place) {
            Some(there) if there.file == self.new => Ok(None),
            there if is_draft && there == old => Ok(Some((false, draft, place))),
            _ => Err(FOREIGN),
        }
    }
}

/// Whether a file holds what another is to be written over it, up to somewhere, and behind that what it held before.
fn is_partly(file: &Path, new: &Path, before: &Path) -> bool {
    let [Ok(there), Ok(new), Ok(before)] = [file, new, before].map(fs::read) else { return false };
    let written = there.iter().zip(&new).take_while(|(a, b)| a == b).count();
    there.get(written..) == before.get(written..) || written == there.len()
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::super::step::Item;
    use super::*;

    const NAMES: [&str; 3] = ["a", "b", "c"];

    /// A directory in which a run was killed after so many of three files, one of them behind a link, were put into their places.
    fn killed_after(done: usize) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("else")).unwrap();
        fs::write(dir.path().join("else/b"), "old b").unwrap();
        fs::write(dir.path().join("a"), "old a").unwrap();
        symlink("else/b", dir.path().join("b")).unwrap();
        let aside = Aside::new(dir.path(), false).unwrap();
        for name in NAMES {
            fs::write(aside.path().join(name), format!("new {name}, longer")).unwrap();
        }
        let step = |name: &str| Step::plan(dir.path(), aside.path(), Item { name: name.to_owned(), was: None }, None);
        let steps = NAMES.map(|name| step(name).unwrap());
        assert_eq!(steps.each_ref().map(|step| step.how), [How::Move, How::Copy, How::Move]);
        let mark = Mark::set(dir.path(), &aside, &steps).unwrap();
        steps.iter().take(done).for_each(|step| step.go(mark.drafts()).unwrap());
        if done == 1 {
            // In the midst of the second.
            fs::create_dir_all(kept_in(mark.drafts(), "")).unwrap();
            fs::copy(dir.path().join("b"), kept_in(mark.drafts(), "b")).unwrap();
            fs::write(dir.path().join("else/b"), "new bb").unwrap();
            let file = fs::OpenOptions::new().write(true).open(dir.path().join("else/b")).unwrap();
            std::os::unix::fs::FileExt::write_all_at(&file, b"new b", 0).unwrap();
            file.set_len(5).unwrap();
        }
        std::mem::forget(mark);
        aside.keep();
        dir
    }

    #[test]
    fn a_killed_run_is_completed_wherever_it_was() {
        for done in 0..=3 {
            let dir = killed_after(done);
            assert!(complete(dir.path()).unwrap(), "after {done}");
            for name in NAMES {
                assert_eq!(fs::read_to_string(dir.path().join(name)).unwrap(), format!("new {name}, longer"));
            }
            assert!(fs::symlink_metadata(dir.path().join("b")).unwrap().is_symlink());
            assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 4, "after {done}: something is left");
            assert!(!complete(dir.path()).unwrap());
        }
    }

    #[test]
    fn what_was_changed_since_is_left_alone() {
        let dir = killed_after(0);
        fs::write(dir.path().join("a"), "by somebody else, later").unwrap();
        assert!(complete(dir.path()).unwrap_err().to_string().contains("cannot complete it"));
        assert_eq!(fs::read_to_string(dir.path().join("a")).unwrap(), "by somebody else, later");
        assert_eq!(fs::read_to_string(dir.path().join("b")).unwrap(), "old b");
    }
}
