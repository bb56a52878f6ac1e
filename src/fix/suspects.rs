//! Fixes that were left out of a batch because their group did harm. If the rest of the group does none, they are the cause, and
//! the map need not be judged again to find that out.

use rustc_hash::{FxHashMap, FxHashSet};

use super::harmful_fixes::Harm;
use super::proposal::{Mend, Proposal};
use crate::diagnostic::{Diagnostic, Edit};

/// Fixes that were put off because they do harm together with those that were kept.
#[derive(Clone, Debug)]
pub struct Suspects {
    /// Those that were kept.
    pub kept: Vec<Mend>,
    /// Those that were put off, the likeliest cause last.
    pub put_off: Vec<Proposal>,
    /// The harm that they do together.
    pub harm: Harm,
}

impl Suspects {
    /// Whether they are to blame: those kept were applied and do no harm, and these would still make the same changes.
    pub fn are_to_blame(&self, made: &FxHashSet<Mend>, open: &FxHashMap<Mend, &[Edit]>) -> bool {
        let is_same = |one: &Proposal| open.get(&one.mend).is_some_and(|edits| *edits == one.fix.edits);
        self.kept.iter().all(|mend| made.contains(mend)) && self.put_off.iter().all(is_same)
    }

    /// Divides a group that is to blame: one half is tried, and the other half is removed from the batch. `None` if the batch
    /// does not contain all of them.
    pub fn divide(mut self, batch: &mut Vec<Proposal>) -> Option<Self> {
        let in_batch: FxHashSet<&Mend> = batch.iter().map(|one| &one.mend).collect();
        if !self.put_off.iter().all(|one| in_batch.contains(&one.mend)) {
            return None;
        }
        let put_off = self.put_off.split_off(self.put_off.len().div_ceil(2));
        let out: FxHashSet<&Mend> = put_off.iter().map(|one| &one.mend).collect();
        batch.retain(|one| !out.contains(&one.mend));
        let kept = self.put_off.into_iter().map(|one| one.mend).collect();
        Some(Self { kept, put_off, harm: self.harm })
    }
}

/// The edits that findings propose, by what they mend.
pub fn open_edits(left: &[Diagnostic]) -> FxHashMap<Mend, &[Edit]> {
    let edits = left.iter().filter_map(|found| {
        let fix = found.finding.fix.as_ref()?;
        let mend = Mend { code: found.code.clone(), subject: found.finding.subject, title: fix.title.clone() };
        Some((mend, fix.edits.as_slice()))
    });
    edits.collect()
}
