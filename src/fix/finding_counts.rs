//! Counts the findings of each kind, and finds those that are new since.

use rustc_hash::{FxHashMap, FxHashSet};

use super::fixes_by_place::keys;
use super::text_edits::{Key, key_of};
use crate::diagnostic::{Diagnostic, Edit, Severity, Subject};

/// A finding about more elements than this is about a group; others are about one element and its neighbour.
const MANY: usize = 2;

/// A finding is known by what it is about, never by its text: that may change with what lies elsewhere.
type Kind = (Severity, String, Option<Key>);

/// The number of findings of each code on each element, and the elements that each finding is about.
#[derive(Clone, Default)]
pub struct FindingCounts {
    of_each: FxHashMap<Kind, usize>,
    /// By severity and code, the elements of each finding that speaks of several.
    spoken_of: FxHashMap<(Severity, String), Vec<FxHashSet<Key>>>,
}

/// The errors among some findings.
pub fn errors(found: &[Diagnostic]) -> impl Iterator<Item = &Diagnostic> {
    found.iter().filter(|one| one.severity == Severity::Error)
}

/// The findings of a map that another has fewer of, by severity, code and element.
pub fn new_findings<'a>(before: &[Diagnostic], after: &'a [Diagnostic]) -> Vec<&'a Diagnostic> {
    FindingCounts::of(before).exceeded_by(after)
}

impl FindingCounts {
    /// Counts findings.
    pub fn of<'a>(found: impl IntoIterator<Item = &'a Diagnostic>) -> Self {
        let mut counts = Self::default();
        for one in found {
            *counts.of_each.entry(kind(one)).or_default() += 1;
            // A finding about hundreds of elements names just the first of them; its fix names all.
            let edited = one.finding.fix.iter().flat_map(|fix| fix.edits.iter().filter_map(changed)).filter_map(key_of);
            let elements: FxHashSet<Key> = keys(one).chain(edited).collect();
            if elements.len() > MANY {
                counts.spoken_of.entry((one.severity, one.code.clone())).or_default().push(elements);
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
        let of_each = self.of_each.into_iter();
        let spoken_of = self.spoken_of.into_iter();
        Self {
            of_each: of_each
                .map(|((severity, code, key), count)| ((severity, code, key.map(renumber)), count))
                .collect(),
            spoken_of: spoken_of.map(|(code, sets)| (code, sets.into_iter().map(renumber_all).collect())).collect(),
        }
    }

    /// The findings about elements that have more of them than counted here. One is not new if a single finding of its code was
    /// about all its elements before: then a group has become smaller, and its first element is another one.
    pub fn exceeded_by<'a>(self, found: impl IntoIterator<Item = &'a Diagnostic>) -> Vec<&'a Diagnostic> {
        let Self { mut of_each, spoken_of } = self;
        let is_new = |one: &&Diagnostic| match of_each.get_mut(&kind(one)) {
            Some(count) if *count > 0 => {
                *count -= 1;
                false
            }
            _ => !spoken_of
                .get(&(one.severity, one.code.clone()))
                .is_some_and(|sets| sets.iter().any(|set| keys(one).all(|key| set.contains(&key)))),
        };
        found.into_iter().filter(is_new).collect()
    }
}

/// The element of which an edit changes the tags or the id.
const fn changed(edit: &Edit) -> Option<Subject> {
    match edit {
        Edit::SetTag { on, .. } | Edit::RemoveTag { on, .. } | Edit::Renumber { on, .. } => Some(*on),
        _ => None,
    }
}

fn kind(one: &Diagnostic) -> Kind {
    (one.severity, one.code.clone(), key_of(one.finding.subject))
}
