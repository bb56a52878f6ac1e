//! Counts the errors of each kind, and finds the errors that are new since.

use rustc_hash::{FxHashMap, FxHashSet};

use super::fixes_by_place::keys;
use super::text_edits::{Key, key_of};
use crate::diagnostic::{Diagnostic, Severity};

/// A finding about more elements than this is about a group; others are about one element and its neighbour.
const MANY: usize = 2;

/// The number of errors of each code on each element, and the elements that each error is about.
#[derive(Clone, Default)]
pub struct ErrorCounts {
    of_each: FxHashMap<(String, Option<Key>), usize>,
    /// By code, the elements of each error that speaks of several.
    spoken_of: FxHashMap<String, Vec<FxHashSet<Key>>>,
}

impl ErrorCounts {
    /// Counts errors.
    pub fn of(found: &[Diagnostic]) -> Self {
        let mut counts = Self { of_each: FxHashMap::default(), spoken_of: FxHashMap::default() };
        for one in found.iter().filter(|one| one.severity == Severity::Error) {
            *counts.of_each.entry((one.code.clone(), key_of(one.finding.subject))).or_default() += 1;
            if !one.finding.related.is_empty() {
                counts.spoken_of.entry(one.code.clone()).or_default().push(keys(one).collect());
            }
        }
        counts
    }

    /// The same, with the new ids of elements that have one.
    pub fn renumbered(self, fresh: &FxHashMap<Key, i64>) -> Self {
        if fresh.is_empty() {
            return self;
        }
        let renumber = |(kind, id): Key| (kind, fresh.get(&(kind, id)).copied().unwrap_or(id));
        let renumber_all = |set: FxHashSet<Key>| set.into_iter().map(renumber).collect();
        let Self { of_each, spoken_of } = self;
        Self {
            of_each: of_each.into_iter().map(|((code, key), count)| ((code, key.map(renumber)), count)).collect(),
            spoken_of: spoken_of
                .into_iter()
                .map(|(code, sets)| (code, sets.into_iter().map(renumber_all).collect()))
                .collect(),
        }
    }

    /// The errors of elements that have more of them than counted here. An error is not new if a single error of its code was
    /// about all its elements before: then a group has become smaller, and its first element is another one.
    pub fn exceeded_by(self, found: &[Diagnostic]) -> Vec<&Diagnostic> {
        let Self { mut of_each, spoken_of } = self;
        let errors = found.iter().filter(|one| one.severity == Severity::Error);
        let is_new = |one: &&Diagnostic| match of_each.get_mut(&(one.code.clone(), key_of(one.finding.subject))) {
            Some(count) if *count > 0 => {
                *count -= 1;
                false
            }
            _ => !spoken_of
                .get(&one.code)
                .is_some_and(|sets| sets.iter().any(|set| set.len() > MANY && keys(one).all(|key| set.contains(&key)))),
        };
        errors.filter(is_new).collect()
    }
}
