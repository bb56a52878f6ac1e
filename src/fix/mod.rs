//! Makes the edits that findings propose, as the smallest change to the files' own text, and holds each against the rules
//! again: a fix that brings a new error is not kept.

mod attempt;
mod canonical;
mod chosen;
mod finding_counts;
mod fixes_by_place;
mod harmful_fixes;
mod judgement;
mod memory;
mod mended;
mod more_warnings;
mod nearby;
mod order;
mod proposal;
mod revealed;
mod round;
mod route;
mod routes;
mod scope;
#[cfg(test)]
mod tests;
mod text_edits;
mod tried;

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::cancel;
use crate::diagnostic::{Diagnostic, Severity};
use crate::osm::OsmData;
pub use attempt::FixError;
pub use canonical::{Unkept, canonical};
pub use chosen::{applied, edited, mend_chosen};
pub use finding_counts::new_findings;
use finding_counts::{FindingCounts, errors};
pub use judgement::Judge;
use judgement::{ChangeJudge, Confirmed};
use memory::Memory;
pub use mended::Mended;
use mended::{count, of_each};
use order::first_of;
pub use proposal::Mend;
use proposal::Proposal;
use round::{UNTRIED, leave_untried, round};
pub use route::Route;
pub use scope::Scope;

/// Applies the fixes of what `judge` finds, round by round, until no fix is left that may be applied: those in `scope`, which `true` and
/// `false` stand for, too. Fixes that change different things are applied and judged together. If a batch does harm, the fixes near the
/// harm are halved, at all such places at once, so that the cost is a few judgements and not one for each fix.
///
/// # Errors
///
/// If `judge` fails, or an edited file cannot be read again.
pub fn mend<J: Judge>(osm: OsmData, scope: impl Into<Scope>, judge: J) -> Result<Mended, FixError<J::Error>> {
    let judge = ChangeJudge::new(judge);
    let left = judge.whole(&osm).map_err(FixError::Judge)?;
    mend_found(osm, left, Memory { scope: scope.into(), ..Memory::default() }, &judge)
}

/// The same where it is known what is found in the map.
fn mend_found<J: Judge>(
    osm: OsmData,
    left: Vec<Diagnostic>,
    memory: Memory,
    judge: &ChangeJudge<J>,
) -> Result<Mended, FixError<J::Error>> {
    let before = [Severity::Error, Severity::Warning].map(|severity| count(&left, severity));
    let known_warnings = of_each(&left);
    let state = Mended {
        osm,
        left,
        done: Vec::new(),
        to_look_at: 0,
        drawn: Vec::new(),
        about: Vec::new(),
        before,
        refused: Vec::new(),
        untried: 0,
        unsafe_left: 0,
        more_warnings: BTreeMap::new(),
        revealed: 0,
    };
    judge.limit(&state.osm, &state.left);
    let start = Run::new(state, memory);
    let [most, _] = before;
    let mut run = start.clone().ended(judge)?;
    // No map may have more errors than before.
    if count(&run.state.left, Severity::Error) > most {
        run = start.clone().leaving_unmarked().ended(judge)?;
    }
    if let Some(fuller) = run.filling_room(judge)? {
        run = fuller;
    }
    // Where so many do harm that not all were tried, the safe ones alone may mend more.
    if judge.is_spent() && start.memory.scope.unsafe_too {
        judge.limit(&start.state.osm, &start.state.left);
        let mut safely = start.safely().ended(judge)?;
        if safely.state.after() < run.state.after() {
            safely.memory.scope = run.memory.scope;
            let open = safely.memory.open(&safely.state.left);
            leave_untried(&mut safely.state, &mut safely.memory, open);
            run = safely;
        }
    }
    let Run { mut state, known, .. } = run;
    state.more_warnings = of_each(&state.left);
    state.more_warnings.retain(|code, count| {
        *count = count.saturating_sub(known_warnings.get(code).copied().unwrap_or_default());
        *count > 0
    });
    let open: FxHashSet<Mend> = state.left.iter().filter_map(Proposal::of).map(|one| one.mend).collect();
    state.refused.retain(|(mend, _)| open.contains(mend));
    state.untried = state.refused.iter().filter(|(_, reason)| reason == UNTRIED).count();
    state.revealed = known.exceeded_by(errors(&state.left)).len();
    state.unsafe_left =
        state.left.iter().filter(|found| found.finding.fix.as_ref().is_some_and(|fix| !fix.safe)).count();
    Ok(state)
}

/// The state of a run of fixes.
#[derive(Clone)]
struct Run {
    state: Mended,
    memory: Memory,
    /// The errors of the map as it was.
    known: FindingCounts,
    /// How often it was begun anew, and how many fixes had been made then.
    passes: usize,
    made_before: usize,
}

/// The largest number of times that the fixes are tried again from the beginning: two fixes may undo each other.
const PASSES: usize = 8;

/// The largest number of times that areas are chosen so that the map has no more warnings than before: what follows from them may bring
/// some, too.
const ROOMS: usize = 4;

impl Run {
    fn new(state: Mended, memory: Memory) -> Self {
        let known = FindingCounts::of(errors(&state.left));
        Self { state, memory, known, passes: 0, made_before: 0 }
    }

    /// The same run, but an intersection is not marked if that reveals more errors than it mends.
    fn leaving_unmarked(mut self) -> Self {
        self.memory.leaves_unmarked = true;
        self
    }

    /// The same run without fixes that need review.
    fn safely(mut self) -> Self {
        self.memory.scope.unsafe_too = false;
        self
    }

    /// The same run with areas that bring more warnings than they mend errors, as far as the map as a whole has no more warnings than it
    /// had; `None` where that mends nothing.
    fn filling_room<J: Judge>(&self, judge: &ChangeJudge<J>) -> Result<Option<Self>, FixError<J::Error>> {
        let ([errors, warnings], [_, most]) = (self.state.after(), self.state.before);
        let mut room = most;
        for times in 1..=ROOMS {
            if self.memory.heavy.is_empty() || room <= warnings || judge.is_spent() {
                break;
            }
            let mut run = self.clone();
            let heavy = std::mem::take(&mut run.memory.heavy);
            run.memory.tried.forget(&heavy);
            run.state.refused.retain(|(mend, _)| !heavy.contains(mend));
            run.memory.room = Some(room);
            let run = run.ended(judge)?;
            let [errors_now, warnings_now] = run.state.after();
            if warnings_now <= most {
                return Ok((errors_now < errors).then_some(run));
            }
            room = room.saturating_sub(times * (warnings_now - most));
        }
        Ok(None)
    }

    /// Makes fixes to the end.
    fn ended<J: Judge>(mut self, judge: &ChangeJudge<J>) -> Result<Self, FixError<J::Error>> {
        let mut sure = self.clone();
        loop {
            self.run(judge)?;
            // A result that was judged by its surroundings alone is judged as a whole before it is kept.
            match judge.confirm(&self.state.osm, &self.state.left).map_err(FixError::Judge)? {
                Confirmed::AsIs => {}
                Confirmed::Otherwise(left) => self.state.left = left,
                Confirmed::Worse => {
                    self = sure.clone();
                    continue;
                }
            }
            if self.memory.open(&self.state.left).is_empty() && (judge.is_spent() || !self.begins_anew()) {
                return Ok(self);
            }
            sure = self.clone();
        }
    }

    /// Forgets which fixes were tried before others were applied near them, so that a second run of the program finds nothing to
    /// do: a fix that did harm may do none after these. `false` if there is none.
    fn begins_anew(&mut self) -> bool {
        if self.state.done.len() == self.made_before || self.passes == PASSES {
            return false;
        }
        self.passes += 1;
        self.made_before = self.state.done.len();
        let Memory { scope, only, leaves_unmarked, mut tried, heavy, room, .. } = std::mem::take(&mut self.memory);
        let again = tried.forget_changed(self.state.left.iter().filter_map(Proposal::of));
        self.state.refused.retain(|(mend, _)| tried.has(mend));
        self.memory = Memory { scope, only, leaves_unmarked, tried, heavy, room, ..Memory::default() };
        again
    }

    /// Makes fixes until none is open that was not tried.
    fn run<J: Judge>(&mut self, judge: &ChangeJudge<J>) -> Result<(), FixError<J::Error>> {
        loop {
            cancel::look();
            let open = self.memory.open(&self.state.left);
            if open.is_empty() {
                return Ok(());
            }
            if judge.is_spent() {
                leave_untried(&mut self.state, &mut self.memory, open);
                return Ok(());
            }
            judge.tell(self.state.done.len(), open.len());
            let renumbered = round(&mut self.state, &mut self.memory, first_of(open), judge)?;
            if !renumbered.is_empty() {
                self.known = std::mem::take(&mut self.known).renumbered(&renumbered);
            }
        }
    }
}
