//! Which fixes were tried, and after which of these others were applied near them.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};

use super::fixes_by_place::ByPlace;
use super::order::APART;
use super::proposal::{Mend, Proposal};

/// The fixes that were tried, kept or not.
#[derive(Clone, Default)]
pub struct Tried {
    /// Each with the number of fixes that had been applied before.
    when: FxHashMap<Mend, usize>,
    /// The fixes that were applied, in order.
    applied: Vec<Proposal>,
}

impl Tried {
    /// Whether a fix was tried.
    pub fn has(&self, mend: &Mend) -> bool {
        self.when.contains_key(mend)
    }

    /// Notes a fix that was applied. If its finding is there again, it is one of the changes near it.
    pub fn made(&mut self, one: &Proposal) {
        self.when.insert(one.mend.clone(), self.applied.len());
        self.applied.push(one.clone());
    }

    /// Notes a fix that was not kept. Returns whether it was not known to be tried.
    pub fn refused(&mut self, mend: &Mend) -> bool {
        self.when.insert(mend.clone(), self.applied.len()).is_none()
    }

    /// Forgets some fixes: they may be tried again.
    pub fn forget(&mut self, mends: &FxHashSet<Mend>) {
        self.when.retain(|mend, _| !mends.contains(mend));
    }

    /// Forgets those of the open fixes near which others were applied after they were tried: what they do may be different now.
    /// Returns whether there is one.
    pub fn forget_changed(&mut self, open: impl Iterator<Item = Proposal>) -> bool {
        let mut by_time: BTreeMap<usize, Vec<Proposal>> = BTreeMap::new();
        for one in open {
            if let Some(&when) = self.when.get(&one.mend) {
                by_time.entry(when).or_default().push(one);
            }
        }
        let mut changed: FxHashSet<Mend> = FxHashSet::default();
        for (when, tried) in by_time {
            let later = ByPlace::of(self.applied.get(when..).unwrap_or_default());
            changed.extend(tried.into_iter().filter(|one| later.has_near(one, APART)).map(|one| one.mend));
        }
        self.when.retain(|mend, _| !changed.contains(mend));
        !changed.is_empty()
    }
}
