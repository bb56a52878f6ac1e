//! What is said where a file cannot be written.

use std::io;
use std::path::{Path, PathBuf};

use crate::report::failure::Failure;

/// Why nothing is written where something is.
pub fn there_already(place: &Path) -> Failure {
    Failure::new(format!("{} is there already", place.display()))
        .about(place.display().to_string())
        .help("nothing was changed; move it away or give another output")
}

/// The directory in which another is, or will be.
pub fn parent(dir: &Path) -> &Path {
    dir.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file of a directory as messages call it.
pub(super) fn within(dir: &Path, name: &str) -> PathBuf {
    if dir == Path::new(".") { name.into() } else { dir.join(name) }
}

pub(super) fn failed(what: &str, path: &Path, error: &io::Error) -> Failure {
    Failure::new(format!("cannot {what} {}: {error}", path.display()))
        .about(path.display().to_string())
        .help("nothing was changed; check the place's permissions and free space")
}

pub(super) fn is_a_directory(place: &Path) -> Failure {
    Failure::new(format!("{} is a directory", place.display()))
        .about(place.display().to_string())
        .help("nothing was changed; move it away or give another output")
}

pub(super) fn read_only(place: &Path) -> Failure {
    Failure::new(format!("{} is write-protected", place.display()))
        .about(place.display().to_string())
        .help(format!("nothing was changed; allow it first: chmod u+w {}", place.display()))
}

pub(super) fn changed_meanwhile(place: &Path) -> Failure {
    Failure::new(format!("{} was changed by somebody else after it was read", place.display()))
        .about(place.display().to_string())
        .help("nothing was changed; run again, which reads the file as it is now")
}
