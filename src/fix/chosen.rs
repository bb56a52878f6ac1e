//! Makes the fixes that a person chose, and edits of their own.

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::judgement::ChangeJudge;
use super::text_edits::TextEdits;
use super::{FixError, Judge, Memory, Mend, Mended, Scope, mend_found};
use crate::diagnostic::{Diagnostic, Fix};
use crate::osm::{OsmData, ReadError};

/// Makes some fixes and those that follow from them, judged as [`super::mend`] judges; `left` is what is found in the map. What a fix
/// brings in warnings is for the person to weigh who chose it.
///
/// # Errors
///
/// If `judge` fails, or an edited file cannot be read again.
pub fn mend_chosen<J: Judge>(
    osm: OsmData,
    left: Vec<Diagnostic>,
    chosen: FxHashSet<Mend>,
    judge: J,
) -> Result<Mended, FixError<J::Error>> {
    let scope = Scope { ids_too: true, ..Scope::from(true) };
    let memory = Memory { scope, only: Some(Arc::new(chosen)), ..Memory::default() };
    mend_found(osm, left, memory, &ChangeJudge::new(judge))
}

/// The map with the edits of one fix, whatever comes of it; `None` if it cannot be made.
///
/// # Errors
///
/// If an edited element cannot be read again: a fault of ours.
pub fn applied(osm: &OsmData, fix: &Fix) -> Result<Option<OsmData>, ReadError> {
    let mut edits = TextEdits::new(osm);
    match edits.apply(fix) {
        Some(_) => edits.made().map(Some),
        None => Ok(None),
    }
}

/// The files' texts with the edits of one fix; `None` if it cannot be made.
pub fn edited(osm: &OsmData, fix: &Fix) -> Option<Vec<String>> {
    let mut edits = TextEdits::new(osm);
    edits.apply(fix)?;
    Some(edits.texts())
}
