//! What is known of the fixes of a run.

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::proposal::{Mend, Proposal};
use super::scope::Scope;
use super::tried::Tried;
use crate::diagnostic::{Diagnostic, Fix};

/// What is known of the fixes so far.
#[derive(Clone, Default)]
pub struct Memory {
    pub scope: Scope,
    /// The fixes that somebody chose, where they did: others are made only if they follow from these.
    pub only: Option<Arc<FxHashSet<Mend>>>,
    /// Whether intersections are left unmarked where marking them brings more errors to light than it mends.
    pub leaves_unmarked: bool,
    /// No fix is tried twice, so that two fixes cannot undo each other forever.
    pub tried: Tried,
    /// Fixes that draw an area and were not kept because they bring more warnings than they mend errors.
    pub heavy: FxHashSet<Mend>,
    /// The most warnings that the map may have, where such fixes are made as long as it has no more.
    pub room: Option<usize>,
    /// Groups of fixes that do harm together, as is known from earlier rounds.
    pub to_blame: Vec<Waiting>,
}

/// Fixes that do harm together with others, and wait until these are tried without them. Where the others do none, they are the cause.
#[derive(Clone, Debug)]
pub struct Waiting {
    /// The others.
    pub tried: Vec<Mend>,
    /// Those that wait, the likeliest cause last.
    pub fixes: Vec<Proposal>,
    /// What they do together, in one sentence.
    pub reason: String,
}

impl Memory {
    /// Says which fixes may be applied at all.
    pub fn allowed(&self) -> impl Fn(&Fix) -> bool + use<> {
        let scope = self.scope;
        move |fix| scope.may(fix)
    }

    pub fn open(&self, left: &[Diagnostic]) -> Vec<Proposal> {
        let open = left.iter().filter(|found| self.scope.wants(found)).filter_map(Proposal::of);
        let is_chosen = |mend: &Mend| self.only.as_ref().is_none_or(|only| only.contains(mend));
        open.filter(|one| self.scope.may(&one.fix) && !self.tried.has(&one.mend) && is_chosen(&one.mend)).collect()
    }
}
