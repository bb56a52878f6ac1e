//! What a review proposes in the map as it is now, and under which projector that is judged.

use rustc_hash::FxHashSet;

use super::{Decision, Item, Review, item};
use crate::api::fixed::PROJECTOR_MISSING;
use crate::api::judge::MapJudge;
use crate::diagnostic::Fix;
use crate::lanelet::ProjectorInfo;
use crate::projection::Projector;

impl Review {
    /// The projector with which the map is read, and what is known of its file.
    pub(super) fn plane(&self, with_projector_file: bool) -> (Projector, ProjectorInfo) {
        match self.missing.as_ref().filter(|_| with_projector_file) {
            Some(file) => (file.projector, file.info()),
            None => (self.loaded.projector, self.loaded.info.clone()),
        }
    }

    pub(super) fn projector(&self) -> Projector {
        self.plane(self.now.with_projector_file).0
    }

    pub(super) fn judge<'a>(&'a self, (projector, info): &'a (Projector, ProjectorInfo)) -> MapJudge<'a> {
        MapJudge::telling(&self.loaded, projector, info, &|_, _| {}).knowing(Some(&self.baseline))
    }

    /// The fixes that the present findings propose; the file that is missing is one of them.
    fn proposed(&self) -> Vec<Item> {
        let Some(file) = self.missing.as_ref().filter(|_| !self.now.with_projector_file) else {
            return item::of(&self.now.left);
        };
        let mut found = self.now.left.as_ref().clone();
        for one in found.iter_mut().filter(|one| one.code == PROJECTOR_MISSING) {
            one.finding.fix = Some(Fix { title: file.title(), safe: false, edits: Vec::new() });
        }
        item::of(&found)
    }

    /// Notes the fixes that the present findings propose: those that were not there before come last.
    pub(super) fn list(&mut self) {
        for item in self.proposed() {
            let known = item.mends.iter().find_map(|mend| self.by_mend.get(mend).copied());
            let at = known.unwrap_or(self.items.len());
            self.by_mend.extend(item.mends.iter().map(|mend| (mend.clone(), at)));
            match self.items.get_mut(at) {
                Some(old) => *old = item,
                None => self.items.push(item),
            }
        }
    }

    /// All fixes that were ever proposed, in the order in which they are looked at; each with its number.
    pub fn items(&self) -> impl Iterator<Item = (usize, &Item)> {
        self.items.iter().enumerate()
    }

    /// What was decided about a fix.
    pub fn decision(&self, item: usize) -> Option<&Decision> {
        self.now.decisions.get(&item)
    }

    /// The fixes that can be made in the map as it is now and are neither accepted nor rejected.
    pub fn open_items(&self) -> Vec<usize> {
        let proposed: FxHashSet<usize> = (self.proposed().iter())
            .filter_map(|item| item.mends.iter().find_map(|mend| self.by_mend.get(mend).copied()))
            .collect();
        let is_open = |at: &usize| matches!(self.decision(*at), None | Some(Decision::Later));
        (0..self.items.len()).filter(|at| proposed.contains(at)).filter(is_open).collect()
    }

    /// Fixes of the kind of one, itself included, that are open.
    pub fn alike(&self, item: usize) -> Vec<usize> {
        let kind = self.items.get(item).map(|item| &item.kind);
        let is_alike = |at: &usize| self.items.get(*at).map(|item| &item.kind) == kind;
        self.open_items().into_iter().filter(is_alike).collect()
    }
}
