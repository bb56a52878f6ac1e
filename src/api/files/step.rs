//! One draft and the place that it is to have.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek};
use std::path::{Path, PathBuf};

use super::failures::{changed_meanwhile, failed, is_a_directory, read_only, there_already, within};
use super::kept::{Stamp, Was, has_other_names, is_writable, keep};
use super::place::Place;
use crate::report::failure::Failure;

/// A file or folder of a draft.
#[derive(Clone, Debug)]
pub(super) struct Item {
    /// Its name in the draft, and in the directory that it is for.
    pub(super) name: String,
    /// What it replaces, where that was read: nothing, or a file of this content.
    pub(super) was: Option<Option<Was>>,
}

/// How a draft comes to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum How {
    /// It takes the place of what is there, in one move.
    Move,
    /// What is there stays and gets the content: a file with other names, or behind a link, or of somebody else.
    Copy,
    /// The same, of what is no file and cannot be had back.
    Stream,
}

/// A draft with all that is known of its place.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) name: String,
    pub(super) how: How,
    /// Where it goes, links resolved where it is not moved.
    pub(super) place: PathBuf,
    /// The draft's number on its disk.
    pub(super) new: u64,
    /// What was there.
    pub(super) old: Option<Stamp>,
}

/// Where what was at a place is kept until all are done.
pub(super) fn kept_in(drafts: &Path, name: &str) -> PathBuf {
    drafts.join(".before").join(name)
}

impl Step {
    /// Looks at the place of a draft; `away` if the draft lies elsewhere and cannot be moved.
    pub(super) fn plan(dir: &Path, drafts: &Path, item: Item, away: Option<&io::Error>) -> Result<Self, Failure> {
        let (place, draft) = (within(dir, &item.name), drafts.join(&item.name));
        let about = fs::symlink_metadata(&draft).map_err(|error| failed("write", &place, &error))?;
        let new = Stamp::of(&about).file;
        let step = |how, place, old| Self { name: item.name.clone(), how, place, new, old };
        let unwritable = || away.map_or(Ok(()), |error| Err(failed("write into", dir, error)));
        if fs::symlink_metadata(&place).is_err() {
            unwritable()?;
            return match item.was {
                Some(Some(_)) => Err(changed_meanwhile(&place)),
                _ => Ok(step(How::Move, place, None)),
            };
        }
        if about.is_dir() {
            return Err(there_already(&place));
        }
        let target = match Place::of(&place).map_err(|error| failed("write", &place, &error))? {
            Place::Stdout => return Ok(step(How::Stream, PathBuf::from("/dev/stdout"), None)),
            Place::Stream(target) => return Ok(step(How::Stream, target, None)),
            Place::File(target) => target,
        };
        let Ok(about) = fs::metadata(&target) else { return Ok(step(How::Copy, target, None)) };
        if about.is_dir() {
            return Err(is_a_directory(&place));
        }
        if !is_writable(&target, &about) {
            return Err(read_only(&place));
        }
        let is_as_read = match &item.was {
            None => true,
            Some(was) => was.as_ref().is_some_and(|was| was.is_still(&target)),
        };
        if !is_as_read {
            return Err(changed_meanwhile(&place));
        }
        let old = Some(Stamp::of(&about));
        let movable = target == place && away.is_none() && !has_other_names(&about);
        let how = if movable && keep(&draft, &place, &about).is_ok() { How::Move } else { How::Copy };
        Ok(step(how, target, old))
    }

    /// Brings the draft to its place. What was there is then beside the drafts.
    pub(super) fn go(&self, drafts: &Path) -> Result<(), Failure> {
        let (new, before) = (drafts.join(&self.name), kept_in(drafts, &self.name));
        let place = &self.place;
        let done = match (self.how, self.old) {
            (How::Stream, _) => into_stream(&new, place),
            (How::Copy, None) => into_file(&new, place),
            (How::Copy, Some(_)) => kept(place, &before).and_then(|()| {
                into_file(&new, place).inspect_err(|_| {
                    let _ = into_file(&before, place);
                })
            }),
            (How::Move, None) => fs::rename(&new, place),
            (How::Move, Some(old)) if exchanged(&new, place) => {
                if Stamp::at(&new) != Some(old) {
                    exchanged(&new, place);
                    return Err(changed_meanwhile(place));
                }
                made(&before).and_then(|()| fs::rename(&new, &before)).inspect_err(|_| {
                    exchanged(&new, place);
                })
            }
            (How::Move, Some(old)) => {
                if Stamp::at(place) != Some(old) {
                    return Err(changed_meanwhile(place));
                }
                kept(place, &before).and_then(|()| fs::rename(&new, place))
            }
        };
        done.map_err(|error| failed("write", place, &error))
    }

    /// Undoes it, as far as the file system still allows.
    pub(super) fn undo(&self, drafts: &Path) {
        let before = kept_in(drafts, &self.name);
        let _ = match (self.how, self.old) {
            (How::Stream, _) => Ok(()),
            (How::Copy, Some(_)) => into_file(&before, &self.place),
            (How::Move, Some(_)) => fs::rename(before, &self.place),
            (_, None) if self.place.is_dir() => fs::remove_dir_all(&self.place),
            (_, None) => fs::remove_file(&self.place),
        };
    }
}

/// Makes the folder of a file.
fn made(file: &Path) -> io::Result<()> {
    file.parent().map_or(Ok(()), fs::create_dir_all)
}

/// Keeps what is at a place under another name.
fn kept(place: &Path, before: &Path) -> io::Result<()> {
    made(before)?;
    fs::copy(place, before).map(drop)
}

/// Puts the content of one file into another, which stays what it is but for that.
pub(super) fn into_file(from: &Path, to: &Path) -> io::Result<()> {
    let mut from = File::open(from)?;
    let mut to = OpenOptions::new().write(true).create(true).truncate(false).open(to)?;
    let length = io::copy(&mut from, &mut to)?;
    to.set_len(length)?;
    to.sync_all()
}

/// Puts the content of a file into something that has no end yet, or no content.
pub(super) fn into_stream(from: &Path, to: &Path) -> io::Result<()> {
    pour(&mut File::open(from)?, to)
}

/// The same of an open file, from its begin.
pub(super) fn pour(from: &mut File, to: &Path) -> io::Result<()> {
    from.rewind()?;
    let poured = match Place::of(to)? {
        Place::Stdout => io::copy(from, &mut io::stdout().lock()),
        Place::Stream(to) | Place::File(to) => {
            OpenOptions::new().append(true).open(to).and_then(|mut to| io::copy(from, &mut to))
        }
    };
    match poured {
        // Whoever reads may stop at any time.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        poured => poured.map(drop),
    }
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
