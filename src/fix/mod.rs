//! Makes the edits that findings propose, as the smallest change to the files' own text, and holds each against the rules
//! again: a fix that brings a new error is not kept.

mod attempt;
mod canonical;
mod chosen;
mod error_counts;
mod fixes_by_place;
mod harmful_fixes;
mod judgement;
mod more_warnings;
mod nearby;
mod order;
mod proposal;
mod revealed;
mod route;
mod routes;
mod scope;
mod suspects;
#[cfg(test)]
mod tests;
mod text_edits;
mod tried;

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::cancel;
use crate::diagnostic::{Diagnostic, Fix, Severity};
use crate::osm::{ElementKind, OsmData};
pub use attempt::FixError;
use attempt::{Earlier, attempt, follow_all};
pub use canonical::{Unkept, canonical};
pub use chosen::{applied, edited, mend_chosen};
use error_counts::ErrorCounts;
use harmful_fixes::{Divided, Verdict};
pub use judgement::Judge;
use judgement::{ChangeJudge, Confirmed, JudgedMap};
use order::first_of;
pub use proposal::Mend;
use proposal::{Attempt, Proposal};
pub use route::Route;
pub use scope::Scope;
use suspects::Suspects;
use text_edits::Key;
use tried::Tried;

/// What came of mending.
#[derive(Clone, Debug)]
pub struct Mended {
    /// The map as it is now.
    pub osm: OsmData,
    /// What is left to find in it.
    pub left: Vec<Diagnostic>,
    /// What was done, in order.
    pub done: Vec<Mend>,
    /// How many of these fixes need a look now.
    pub to_look_at: usize,
    /// The elements that fixes have drawn, each with the place of its fix in `done`, as (kind, id).
    pub drawn: Vec<(usize, ElementKind, i64)>,
    /// How many errors and warnings there were before.
    pub before: [usize; 2],
    /// What was tried and not kept, each with the reason: it brought a new error, or did not mend what it was for.
    pub refused: Vec<(Mend, String)>,
    /// How many of the findings left have a fix that needs a look first.
    pub unsafe_left: usize,
    /// How many of the errors left existed before and are only reported now, because the fixes marked intersections or roads.
    pub revealed: usize,
}

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
    let state = Mended {
        osm,
        left,
        done: Vec::new(),
        to_look_at: 0,
        drawn: Vec::new(),
        before,
        refused: Vec::new(),
        unsafe_left: 0,
        revealed: 0,
    };
    let start = Run::new(state, memory);
    let [most, _] = before;
    let mut run = start.clone().ended(judge)?;
    // No map may have more errors than before.
    if count(&run.state.left, Severity::Error) > most {
        run = start.leaving_unmarked().ended(judge)?;
    }
    let Run { mut state, known, .. } = run;
    let open: FxHashSet<Mend> = state.left.iter().filter_map(Proposal::of).map(|one| one.mend).collect();
    state.refused.retain(|(mend, _)| open.contains(mend));
    state.revealed = known.exceeded_by(&state.left).len();
    state.unsafe_left =
        state.left.iter().filter(|found| found.finding.fix.as_ref().is_some_and(|fix| !fix.safe)).count();
    Ok(state)
}

fn count(found: &[Diagnostic], severity: Severity) -> usize {
    found.iter().filter(|one| one.severity == severity).count()
}

impl Mended {
    /// How many errors and warnings there are now.
    pub fn after(&self) -> [usize; 2] {
        [Severity::Error, Severity::Warning].map(|severity| count(&self.left, severity))
    }
}

/// The state of a run of fixes.
#[derive(Clone)]
struct Run {
    state: Mended,
    memory: Memory,
    /// The errors of the map as it was.
    known: ErrorCounts,
    /// How often it was begun anew, and how many fixes had been made then.
    passes: usize,
    made_before: usize,
}

/// The largest number of times that the fixes are tried again from the beginning: two fixes may undo each other.
const PASSES: usize = 8;

impl Run {
    fn new(state: Mended, memory: Memory) -> Self {
        let known = ErrorCounts::of(&state.left);
        Self { state, memory, known, passes: 0, made_before: 0 }
    }

    /// The same run, but an intersection is not marked if that reveals more errors than it mends.
    fn leaving_unmarked(mut self) -> Self {
        self.memory.leaves_unmarked = true;
        self
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
            if self.memory.open(&self.state.left).is_empty() && !self.begins_anew() {
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
        let Memory { scope, only, leaves_unmarked, mut tried, .. } = std::mem::take(&mut self.memory);
        let again = tried.forget_changed(self.state.left.iter().filter_map(Proposal::of));
        self.state.refused.retain(|(mend, _)| tried.has(mend));
        self.memory = Memory { scope, only, leaves_unmarked, tried, ..Memory::default() };
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
            judge.tell(self.state.done.len(), open.len());
            let renumbered = round(&mut self.state, &mut self.memory, first_of(open), judge)?;
            if !renumbered.is_empty() {
                self.known = std::mem::take(&mut self.known).renumbered(&renumbered);
            }
        }
    }
}

/// What is known of the fixes so far.
#[derive(Clone, Default)]
struct Memory {
    scope: Scope,
    /// The fixes that somebody chose, where they did: others are made only if they follow from these.
    only: Option<Arc<FxHashSet<Mend>>>,
    /// Whether intersections are left unmarked where marking them brings more errors to light than it mends.
    leaves_unmarked: bool,
    /// No fix is tried twice, so that two fixes cannot undo each other forever.
    tried: Tried,
    /// Fixes that brought errors with fixes of their own: they are tried again together with these.
    leading: FxHashSet<Mend>,
    /// Fixes that were tried so as a group.
    led: FxHashSet<Mend>,
    /// Groups of fixes that do harm together, as is known from earlier rounds.
    to_blame: Vec<Suspects>,
}

impl Memory {
    /// Says which fixes may be applied at all.
    fn allowed(&self) -> impl Fn(&Fix) -> bool + use<> {
        let scope = self.scope;
        move |fix| scope.may(fix)
    }

    fn open(&self, left: &[Diagnostic]) -> Vec<Proposal> {
        let open = left.iter().filter(|found| self.scope.wants(found)).filter_map(Proposal::of);
        let is_chosen = |mend: &Mend| self.only.as_ref().is_none_or(|only| only.contains(mend));
        let open = open.filter(|one| self.scope.may(&one.fix) && !self.tried.has(&one.mend) && is_chosen(&one.mend));
        let leads = |one: Proposal| {
            let leads = self.leading.contains(&one.mend);
            Proposal { leads, in_group: !leads && self.led.contains(&one.mend), ..one }
        };
        open.map(leads).collect()
    }
}

/// Applies the fixes of a batch that do no harm together; returns the new ids of elements. Each call keeps or refuses at least
/// one fix, or marks one to be tried with the fixes that follow from it.
fn round<J: Judge>(
    state: &mut Mended,
    memory: &mut Memory,
    mut batch: Vec<Proposal>,
    judge: &ChangeJudge<J>,
) -> Result<FxHashMap<Key, i64>, FixError<J::Error>> {
    let to_blame = std::mem::take(&mut memory.to_blame);
    let mut suspects: Vec<Suspects> = to_blame.into_iter().filter_map(|group| group.divide(&mut batch)).collect();
    let mut is_first = true;
    let mut earlier = Earlier::default();
    let may = memory.allowed();
    while !batch.is_empty() {
        let known = JudgedMap { osm: &state.osm, left: &state.left };
        let Some(mut attempt) = attempt(known, &may, &batch, (judge, &mut earlier))? else {
            // None of them can be applied, although nothing else is changed.
            let all = batch.into_iter().map(|one| (one.mend, "it cannot be made".to_owned()));
            refuse(state, memory, all);
            break;
        };
        let mut verdict = verdict(state, memory, &attempt, is_first);
        let apart = verdict.leads_apart(&attempt.done);
        if apart && verdict.does_no_other_harm() && !verdict.is_clean() && !attempt.is_followed {
            // What follows is known from this attempt.
            lead(memory, &verdict, &mut attempt.done);
            follow_all(known, &may, &mut attempt, judge)?;
            verdict = self::verdict(state, memory, &attempt, is_first);
        }
        if verdict.is_clean() {
            return Ok(keep(state, memory, attempt, suspects));
        }
        is_first = false;
        lead(memory, &verdict, &mut attempt.done);
        earlier.last = Some(attempt.as_made.take().unwrap_or((attempt.osm, attempt.left)));
        let mut of_each: Vec<Option<Proposal>> = attempt.done.into_iter().map(Some).collect();
        for Divided { kept, put_off, harm } in verdict.divided {
            let mend = |at: usize| Some(of_each.get(at)?.as_ref()?.mend.clone());
            let mends = kept.iter().copied().filter_map(mend).collect();
            for at in kept {
                of_each.get_mut(at).and_then(Option::as_mut).into_iter().for_each(Proposal::leads_no_group);
            }
            suspects.push(Suspects { kept: mends, put_off: take(&mut of_each, put_off), harm });
        }
        if !apart {
            // They wait until the others are decided. A group is tried as one again.
            for one in take(&mut of_each, verdict.leading.iter().chain(&verdict.leading_together).copied()) {
                memory.led.remove(&one.mend);
            }
        }
        for (at, reason) in verdict.refused {
            for one in take(&mut of_each, [at]) {
                refuse_with_twins(state, memory, one, &reason);
            }
        }
        let unfollowed = |one: Proposal| Proposal { followers: Vec::new(), ..one };
        let is_open = |one: &Proposal| !memory.tried.has(&one.mend);
        batch = of_each.into_iter().flatten().filter(is_open).map(unfollowed).collect();
    }
    Ok(FxHashMap::default())
}

/// The decision about each fix of a batch.
fn verdict(state: &Mended, memory: &Memory, attempt: &Attempt, is_first: bool) -> Verdict {
    let may = memory.allowed();
    let mut verdict = harmful_fixes::verdict(&state.left, attempt, &may, is_first);
    if memory.leaves_unmarked {
        verdict.refused.extend(harmful_fixes::worse_by_marking(&state.left, attempt, &may));
    }
    verdict.refused.extend(routes::unasked(attempt));
    if !memory.scope.warnings_too && verdict.is_clean() {
        verdict.refused.extend(more_warnings::of(&state.left, attempt));
    }
    verdict
}

/// Marks the fixes that are tried again together with those of the errors that they bring.
fn lead(memory: &mut Memory, verdict: &Verdict, done: &mut [Proposal]) {
    for &at in &verdict.leading {
        if let Some(one) = done.get_mut(at) {
            (one.leads, one.in_group) = (true, false);
            memory.leading.insert(one.mend.clone());
        }
    }
    for &at in &verdict.leading_together {
        if let Some(one) = done.get_mut(at) {
            (one.leads, one.in_group) = (true, true);
            memory.led.insert(one.mend.clone());
        }
    }
}

fn take(of_each: &mut [Option<Proposal>], places: impl IntoIterator<Item = usize>) -> Vec<Proposal> {
    places.into_iter().filter_map(|at| of_each.get_mut(at)?.take()).collect()
}

/// Keeps the effects of a batch, and blames the fixes that are then the only possible cause of harm; returns the new ids of
/// elements.
fn keep(state: &mut Mended, memory: &mut Memory, attempt: Attempt, suspects: Vec<Suspects>) -> FxHashMap<Key, i64> {
    let made: FxHashSet<Mend> = attempt.done.iter().map(|one| one.mend.clone()).collect();
    for one in attempt.done {
        memory.tried.made(&one);
        let at = state.done.len();
        state.drawn.extend(one.creates.iter().map(|&(kind, id)| (at, kind, id)));
        let followers = one.followers.iter().map(|(_, fix)| fix);
        state.to_look_at += std::iter::once(&one.fix).chain(followers).filter(|fix| !fix.safe).count();
        state.done.extend(one.mends());
    }
    (state.osm, state.left) = (attempt.osm, attempt.left);
    let open = suspects::open_edits(&state.left);
    let to_blame: Vec<Suspects> = suspects.into_iter().filter(|group| group.are_to_blame(&made, &open)).collect();
    for mut group in to_blame {
        match (group.put_off.len(), group.put_off.pop()) {
            (1, Some(only)) if group.harm.mendable && !only.leads => {
                memory.leading.insert(only.mend);
            }
            (1, Some(only)) => refuse_with_twins(state, memory, only, &group.harm.reason),
            (_, last) => {
                group.put_off.extend(last);
                memory.to_blame.push(group);
            }
        }
    }
    attempt.renumbered
}

/// Refuses a fix, and those of other findings that would make the same change.
fn refuse_with_twins(state: &mut Mended, memory: &mut Memory, one: Proposal, reason: &str) {
    let twins = twins(&state.left, one);
    refuse(state, memory, twins.into_iter().map(|mend| (mend, reason.to_owned())));
}

/// A fix and those of other findings that would make the same change: each lanelet of an intersection proposes its area.
fn twins(left: &[Diagnostic], one: Proposal) -> Vec<Mend> {
    let others = left.iter().filter_map(|found| {
        let fix = found.finding.fix.as_ref().filter(|fix| fix.edits == one.fix.edits)?;
        Some(Mend { code: found.code.clone(), subject: found.finding.subject, title: fix.title.clone() })
    });
    let mut twins: Vec<Mend> = others.collect();
    if !twins.contains(&one.mend) {
        twins.push(one.mend);
    }
    twins
}

fn refuse(state: &mut Mended, memory: &mut Memory, refused: impl Iterator<Item = (Mend, String)>) {
    for (mend, reason) in refused {
        if memory.tried.refused(&mend) {
            state.refused.push((mend, reason));
        }
    }
}
