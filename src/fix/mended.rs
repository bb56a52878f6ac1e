//! What came of mending a map.

use std::collections::BTreeMap;

use super::proposal::Mend;
use crate::diagnostic::{Diagnostic, Severity};
use crate::osm::{ElementKind, OsmData};

/// What came of mending.
#[derive(Clone, Debug)]
pub struct Mended {
    /// The map as it is now.
    pub osm: OsmData,
    /// What is left to find in it.
    pub left: Vec<Diagnostic>,
    /// What was done, in order.
    pub done: Vec<Mend>,
    /// How many of these fixes need review now.
    pub to_look_at: usize,
    /// The elements that fixes have drawn, each with the place of its fix in `done`, as (kind, id).
    pub drawn: Vec<(usize, ElementKind, i64)>,
    /// The elements that each finding spoke of which was mended, and those that its fix changed, as (kind, id).
    pub about: Vec<Vec<(ElementKind, i64)>>,
    /// How many errors and warnings there were before.
    pub before: [usize; 2],
    /// What was tried and not kept, each with the reason: it brought a new error, or did not mend what it was for.
    pub refused: Vec<(Mend, String)>,
    /// How many of these were not tried, because as much was judged before as may be in proportion to the map.
    pub untried: usize,
    /// How many of the findings left have a fix that needs review first.
    pub unsafe_left: usize,
    /// The codes of which there are more warnings than before, each with how many more.
    pub more_warnings: BTreeMap<String, usize>,
    /// How many of the errors left existed before and are only reported now, because the fixes marked intersections or roads.
    pub revealed: usize,
}

impl Mended {
    /// Notes a fix beside the map that was made before all others, needs review, and mends a finding of this severity.
    pub fn made_first(&mut self, mend: Mend, severity: Severity) {
        self.done.insert(0, mend);
        self.drawn.iter_mut().for_each(|(at, ..)| *at += 1);
        self.to_look_at += 1;
        let [errors, warnings] = &mut self.before;
        match severity {
            Severity::Error => *errors += 1,
            Severity::Warning => *warnings += 1,
            Severity::Info => {}
        }
    }
}

/// How many warnings of each code there are.
pub fn of_each(found: &[Diagnostic]) -> BTreeMap<String, usize> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for one in found.iter().filter(|one| one.severity == Severity::Warning) {
        *counts.entry(one.code.clone()).or_default() += 1;
    }
    counts
}

pub fn count(found: &[Diagnostic], severity: Severity) -> usize {
    found.iter().filter(|one| one.severity == severity).count()
}

impl Mended {
    /// How many errors and warnings there are now.
    pub fn after(&self) -> [usize; 2] {
        [Severity::Error, Severity::Warning].map(|severity| count(&self.left, severity))
    }
}
