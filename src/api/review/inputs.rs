//! What a review begins with: files that it may edit, and what was known before.

use std::path::Path;

use crate::api::checked::read_baseline;
use crate::api::error::{Error, ErrorKind};
use crate::api::fixed::undivided;
use crate::api::load::Loaded;
use crate::report::failure::Failure;
use crate::triage::Baseline;

/// Why the files of a map cannot be edited, if so.
pub(super) fn editable(loaded: &Loaded) -> Result<(), Error> {
    if loaded.divided {
        return Err(ErrorKind::Write.error(undivided("reviews")));
    }
    match loaded.is_editable() {
        true => Ok(()),
        false => Err(ErrorKind::Write
            .error(Failure::new("the map is packed, and only plain .osm files are edited").help("unpack it first"))),
    }
}

/// Reads a baseline; an empty one where the file is not there yet.
pub(super) fn read(file: &Path) -> Result<Baseline, Error> {
    if file.exists() { read_baseline(&file.into()) } else { Ok(Baseline::default()) }
}
