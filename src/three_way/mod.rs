//! Merges two maps that were made from one: by element and by meaning, so that what either side changed is in the result.
//!
//! Elements are the same if their kinds and ids are. What only one side has changed is taken from it, letter for letter; of what both
//! have changed, each field: position, each tag, the list of nodes, each member with its role. Elements that both sides have made
//! under one id are told apart by place and parts; those of theirs get other ids, with all that refers to them. What both have
//! changed to something else is a [`Conflict`]; the result then says what ours says. What one side deleted and the other changed
//! or uses is kept, with all that it needs: nothing is lost, and no reference leads nowhere.
//!
//! The result is the text of ours with the fewest elements exchanged.

mod conflict;
mod content;
mod decide;
mod fields;
mod id_tags;
mod kept;
mod lists;
mod meta_info;
mod new_ids;
mod plain_text;
mod settings;
#[cfg(test)]
mod tests;
mod versions;
mod view;
mod written;

use rustc_hash::FxHashMap;

use crate::diagnostic::Subject;

pub use conflict::{Conflict, Side};
pub use plain_text::plain_text;
pub use settings::{SettingsConflict, merge_settings, renumbered_settings};
pub use versions::{Deletions, Key, Taken, Versions};

use decide::Decisions;
use view::View;

/// A merged map.
#[derive(Clone, Debug)]
pub struct Merged {
    /// The text of its file.
    pub text: String,
    /// What contradicts; empty where all could be merged.
    pub conflicts: Vec<Conflict>,
    /// What was taken from theirs.
    pub taken: Taken,
    /// Elements that both sides have made under one id: kind, the id that both gave, and the one that that of theirs has now.
    pub renumbered: Vec<(Subject, i64)>,
    /// The same, to look up.
    pub new_ids: FxHashMap<Key, i64>,
}

/// Merges three versions of a map.
#[must_use]
pub fn merge(versions: Versions<'_>, deletions: Deletions) -> Merged {
    let new_ids = new_ids::of(versions);
    let base = View::new(versions.base);
    let ours = View::new(versions.ours);
    let theirs = View::renumbered(versions.theirs, &new_ids);
    let mut decisions = Decisions::of([&base, &ours, &theirs], deletions);
    kept::keep_what_is_needed(&mut decisions, [&base, &ours, &theirs], deletions);
    let (conflicts, taken) = decisions.summed_up([&base, &ours, &theirs]);
    let text = written::text(&decisions, &ours, &theirs);
    let text = meta_info::merged(&text, [versions.base, versions.ours, versions.theirs]);
    let mut renumbered: Vec<(Key, i64)> = new_ids.iter().map(|(key, id)| (*key, *id)).collect();
    renumbered.sort_unstable();
    let renumbered = renumbered
        .into_iter()
        .map(|((kind, id), new)| (theirs.subject((kind, new)).unwrap_or_else(|| view::plain((kind, id))), id, new))
        .map(|(subject, id, new)| (view::with_id(subject, id), new))
        .collect();
    Merged { text, conflicts, taken, renumbered, new_ids }
}
