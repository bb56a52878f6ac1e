//! A fix that a finding proposes, and a batch of them, made and judged.

use rustc_hash::FxHashMap;

use super::text_edits::Key;
use crate::diagnostic::{Diagnostic, Fix, Subject};
use crate::osm::OsmData;

/// A fix and what it mends.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Mend {
    /// Code of the finding.
    pub code: String,
    /// What it is about.
    pub subject: Subject,
    /// What the fix does, in one line.
    pub title: String,
}

/// A fix that a finding proposes.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// What is mended.
    pub mend: Mend,
    /// The edits.
    pub fix: Fix,
    /// Where the finding is: east and north, local metres.
    pub place: Option<[f64; 2]>,
}

impl Proposal {
    /// That of a finding; `None` if it has none.
    pub fn of(found: &Diagnostic) -> Option<Self> {
        let fix = found.finding.fix.clone()?;
        let mend = Mend { code: found.code.clone(), subject: found.finding.subject, title: fix.title.clone() };
        Some(Self { mend, fix, place: found.local.map(|place| [place.x, place.y]) })
    }
}

/// A batch of fixes, made and judged.
pub struct Attempt {
    /// The map as it would be.
    pub osm: OsmData,
    /// What would be left to find in it.
    pub left: Vec<Diagnostic>,
    /// The fixes that were made.
    pub done: Vec<Proposal>,
    /// New ids of elements, by their old ones.
    pub renumbered: FxHashMap<Key, i64>,
}
