//! No safe fix of a broken map changes a route that its finding is not about, by the real Lanelet2 library.

use std::path::PathBuf;

use lanewright::diagnostic::Severity;
use lanewright::fix::Scope;

use super::{all_kinds, bases, broken};
use crate::common::routes::changed_unasked;
use crate::common::soak;

/// Every so many kinds of mutations, or all in a soak.
const EVERY_NTH_KIND: usize = 4;

#[test]
fn no_safe_fix_of_a_broken_map_changes_a_route() {
    let bases = bases();
    let dir = tempfile::tempdir().unwrap();
    let step = if soak() { 1 } else { EVERY_NTH_KIND };
    let mut files: Vec<PathBuf> = Vec::new();
    for (at, kind) in all_kinds().enumerate().step_by(step) {
        for (_, seed, draft, _) in broken(&bases, at, kind).take(if soak() { 4 } else { 1 }) {
            let file = dir.path().join(format!("{} {seed}.osm", kind.name.replace(['/', '\''], "")));
            std::fs::write(&file, draft.text()).unwrap();
            files.push(file);
        }
    }
    let scope = Scope { least: Severity::Info, ..Scope::default() };
    let Some(changed) = changed_unasked(&files, scope) else { return };
    assert!(changed.is_empty(), "{changed:#?}");
}
