//! Outputs that a run may write over: those that an earlier run has written, and nobody has changed since.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::config::NAME;
use super::error::{Error, ErrorKind};
use super::files::Draft;
use crate::lanelet::{INFO, MAP};
use crate::report::failure::Failure;

/// Says how the settings of a build came to be and what they are for.
pub(super) const SETTINGS_HEAD: &str =
    "# What OpenStreetMap told and the map cannot say; `lanewright check` reads it.\n";
/// Begins the line of the settings that says what was written beside them.
const WRITTEN: &str = "# Written with it: ";

/// Whether a build has written these settings.
pub(super) fn wrote(settings: &Path) -> bool {
    fs::read(settings).is_ok_and(|written| written.starts_with(SETTINGS_HEAD.as_bytes()))
}

/// Refuses a directory to build into where that would write over settings that no build has written, or, unless `force` is given, of
/// a map that no run has written, or that was changed since: to be asked before the work begins.
///
/// # Errors
///
/// Where such settings, or such a map, are there.
pub fn spare(directory: &Path, force: bool) -> Result<(), Error> {
    spare_settings(directory)?;
    if force { Ok(()) } else { spare_files(directory, &[MAP, INFO]) }
}

/// Refuses a directory whose settings no build has written.
pub(super) fn spare_settings(directory: &Path) -> Result<(), Error> {
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

/// Refuses to write over files of these names in a directory that no run has written, or that were changed since.
pub(crate) fn spare_files(directory: &Path, names: &[&str]) -> Result<(), Error> {
    let settings = fs::read_to_string(directory.join(NAME)).unwrap_or_default();
    let known = |name: &str| known_hash(&settings, name);
    for name in names {
        let file = directory.join(name);
        // What is no file, such as a fifo, holds nothing that could be lost.
        if file.is_file() && !known(name).is_some_and(|hash| hash_of(&file).is_ok_and(|own| own == hash)) {
            let failure = Failure::new(format!(
                "{} was not written so by lanewright: it is hand-made, or was changed since",
                file.display()
            ));
            return Err(ErrorKind::Write.error(
                failure
                    .about(file.display().to_string())
                    .help("nothing was changed; --keep keeps what people have changed, --force writes over it, or give another directory"),
            ));
        }
    }
    Ok(())
}

/// The hash of what was written under a name together with these settings.
pub(super) fn known_hash<'s>(settings: &'s str, name: &str) -> Option<&'s str> {
    settings.lines().find_map(|line| line.strip_prefix(WRITTEN)?.strip_prefix(name)?.strip_prefix(" sha256:"))
}

/// The hash of some bytes, as settings say it.
pub(super) fn hash_of_bytes(bytes: &[u8]) -> String {
    Hashing { out: io::sink(), hash: Sha256::new_with_prefix(bytes) }.said()
}

/// What is to stand in the settings of a map of which a file was written so first, and then merged with what people had changed.
pub(super) fn known_line(name: &str, bytes: &[u8]) -> String {
    format!("{WRITTEN}{name} sha256:{}\n", hash_of_bytes(bytes))
}

fn hash_of(file: &Path) -> io::Result<String> {
    let mut hash = Hashing { out: io::sink(), hash: Sha256::new() };
    io::copy(&mut File::open(file)?, &mut hash)?;
    Ok(hash.said())
}

/// Adds a file to a draft, and says what is to stand in the settings beside it, so that a later run knows it again.
pub(super) fn write_known(
    draft: &mut Draft,
    name: &str,
    content: impl FnOnce(&mut Hashing<&mut File>) -> io::Result<()>,
) -> Result<String, Failure> {
    let mut hash = String::new();
    draft.write(name, |file| {
        let mut out = Hashing { out: file, hash: Sha256::new() };
        content(&mut out)?;
        hash = out.said();
        Ok(())
    })?;
    Ok(format!("{WRITTEN}{name} sha256:{hash}\n"))
}

/// Settings without the lines that say what was written beside them.
pub(super) fn without_hashes(settings: &str) -> String {
    settings.split_inclusive('\n').filter(|line| !line.starts_with(WRITTEN)).collect()
}

/// Passes bytes on and remembers their hash.
pub(super) struct Hashing<W> {
    out: W,
    hash: Sha256,
}

impl<W> Hashing<W> {
    fn said(self) -> String {
        self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hash.update(bytes.get(..written).unwrap_or_default());
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
