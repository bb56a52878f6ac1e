//! One round of fixes: a batch is made and judged, what does harm is left out, and the rest is kept.

use rustc_hash::{FxHashMap, FxHashSet};

use super::attempt::{Earlier, FixError, attempt};
use super::harmful_fixes::{self, Suspected};
use super::judgement::{ChangeJudge, Judge, JudgedMap};
use super::memory::{Memory, Waiting};
use super::mended::Mended;
use super::proposal::{Attempt, Mend, Proposal};
use super::text_edits::Key;
use super::{more_warnings, routes};
use crate::diagnostic::{Diagnostic, Edit};

/// Applies the fixes of a batch that do no harm together; returns the new ids of elements. Each call keeps or refuses at least one fix.
pub fn round<J: Judge>(
    state: &mut Mended,
    memory: &mut Memory,
    mut batch: Vec<Proposal>,
    judge: &ChangeJudge<J>,
) -> Result<FxHashMap<Key, i64>, FixError<J::Error>> {
    let to_blame = std::mem::take(&mut memory.to_blame);
    let mut waiting: Vec<Waiting> = Vec::new();
    for Waiting { fixes, reason, .. } in to_blame {
        if fixes.iter().all(|one| batch.iter().any(|other| other.mend == one.mend)) {
            waiting.push(halved(fixes, reason, &mut batch));
        }
    }
    let mut earlier = Earlier::default();
    let may = memory.allowed();
    while !batch.is_empty() {
        if judge.is_spent() {
            leave_untried(state, memory, batch);
            break;
        }
        let known = JudgedMap { osm: &state.osm, left: &state.left };
        let Some(attempt) = attempt(known, &may, &batch, (judge, &mut earlier))? else {
            // None of them can be applied, although nothing else is changed.
            let all = batch.into_iter().map(|one| (one.mend, "it cannot be made".to_owned()));
            refuse(state, memory, all);
            break;
        };
        let Verdict { suspected, refused, heavy } = judged(state, memory, &attempt);
        if suspected.is_empty() && refused.is_empty() {
            return Ok(keep(state, memory, attempt, waiting));
        }
        let Attempt { osm, left, done, as_made, .. } = attempt;
        earlier.last = Some(as_made.unwrap_or((osm, left)));
        let made: FxHashSet<&Mend> = done.iter().map(|one| &one.mend).collect();
        batch.retain(|one| made.contains(&one.mend));
        let of = |at: &usize| done.get(*at).cloned();
        for Suspected { fixes, reason } in suspected {
            match fixes[..] {
                [only] => {
                    if let Some(one) = of(&only) {
                        refuse_with_twins(state, memory, one, &reason);
                    }
                }
                _ => waiting.push(halved(fixes.iter().filter_map(of).collect(), reason, &mut batch)),
            }
        }
        for (at, reason) in refused {
            if let Some(one) = of(&at) {
                let twins = refuse_with_twins(state, memory, one, &reason);
                memory.heavy.extend(twins.into_iter().filter(|_| heavy.contains(&at)));
            }
        }
        batch.retain(|one| !memory.tried.has(&one.mend));
    }
    Ok(FxHashMap::default())
}

/// Takes the likelier half of fixes that do harm together out of a batch: they wait for the other half.
fn halved(mut fixes: Vec<Proposal>, reason: String, batch: &mut Vec<Proposal>) -> Waiting {
    let waiting = fixes.split_off(fixes.len().div_ceil(2));
    let out: FxHashSet<&Mend> = waiting.iter().map(|one| &one.mend).collect();
    batch.retain(|one| !out.contains(&one.mend));
    Waiting { tried: fixes.into_iter().map(|one| one.mend).collect(), fixes: waiting, reason }
}

/// The decision about the fixes of a batch, by position: nothing if all may be kept.
struct Verdict {
    suspected: Vec<Suspected>,
    /// Those that are the cause of what they do, each with the reason.
    refused: Vec<(usize, String)>,
    /// Those of them that draw an area and do no harm but to bring more warnings than they mend.
    heavy: Vec<usize>,
}

fn judged(state: &Mended, memory: &Memory, attempt: &Attempt) -> Verdict {
    let may = memory.allowed();
    let mut suspected = harmful_fixes::suspected(&state.left, attempt);
    if suspected.is_empty() {
        suspected = routes::unasked(attempt);
    }
    let mut refused = Vec::new();
    if memory.leaves_unmarked {
        refused = harmful_fixes::worse_by_marking(&state.left, attempt, &may);
    }
    let mut heavy = Vec::new();
    if !memory.scope.warnings_too && suspected.is_empty() && refused.is_empty() {
        refused = more_warnings::of(&state.left, attempt, &may, memory.room);
        let draws_area = |at: &usize| attempt.done.get(*at).is_some_and(Proposal::draws_area);
        heavy = refused.iter().map(|(at, _)| *at).filter(draws_area).collect();
    }
    Verdict { suspected, refused, heavy }
}

/// Keeps the effects of a batch, and blames the fixes that are then the only possible cause of harm; returns the new ids of
/// elements.
fn keep(state: &mut Mended, memory: &mut Memory, attempt: Attempt, waiting: Vec<Waiting>) -> FxHashMap<Key, i64> {
    let made: FxHashSet<Mend> = attempt.done.iter().map(|one| one.mend.clone()).collect();
    for one in attempt.done {
        memory.tried.made(&one);
        let at = state.done.len();
        state.about.push(one.about.iter().copied().chain(one.touched()).collect());
        state.drawn.extend(one.creates.iter().map(|&(kind, id)| (at, kind, id)));
        let followers = one.followers.iter().map(|(_, fix)| fix);
        state.to_look_at += std::iter::once(&one.fix).chain(followers).filter(|fix| !fix.safe).count();
        state.done.extend(one.mends());
    }
    (state.osm, state.left) = (attempt.osm, attempt.left);
    let open = open_edits(&state.left);
    // They would still make the same changes.
    let is_open = |one: &Proposal| open.get(&one.mend).is_some_and(|edits| *edits == one.fix.edits);
    let are_to_blame =
        |group: &Waiting| group.tried.iter().all(|mend| made.contains(mend)) && group.fixes.iter().all(is_open);
    let to_blame: Vec<Waiting> = waiting.into_iter().filter(are_to_blame).collect();
    for mut group in to_blame {
        match (group.fixes.len(), group.fixes.pop()) {
            (1, Some(only)) => {
                refuse_with_twins(state, memory, only, &group.reason);
            }
            (_, last) => {
                group.fixes.extend(last);
                memory.to_blame.push(group);
            }
        }
    }
    attempt.renumbered
}

/// The edits that findings propose, by what they mend.
fn open_edits(left: &[Diagnostic]) -> FxHashMap<Mend, &[Edit]> {
    let edits = left.iter().filter_map(|found| {
        let fix = found.finding.fix.as_ref()?;
        let mend = Mend { code: found.code.clone(), subject: found.finding.subject, title: fix.title.clone() };
        Some((mend, fix.edits.as_slice()))
    });
    edits.collect()
}

/// Refuses a fix, and those of other findings that would make the same change; returns all.
fn refuse_with_twins(state: &mut Mended, memory: &mut Memory, one: Proposal, reason: &str) -> Vec<Mend> {
    let twins = twins(&state.left, one);
    refuse(state, memory, twins.iter().map(|mend| (mend.clone(), reason.to_owned())));
    twins
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

/// Says of fixes that they were not tried, because too much was judged already.
pub fn leave_untried(state: &mut Mended, memory: &mut Memory, untried: Vec<Proposal>) {
    refuse(state, memory, untried.into_iter().map(|one| (one.mend, UNTRIED.to_owned())));
}

/// The reason of a fix that was not tried.
pub const UNTRIED: &str = "not tried: so many fixes do harm that trying all of them would take too long";

fn refuse(state: &mut Mended, memory: &mut Memory, refused: impl Iterator<Item = (Mend, String)>) {
    for (mend, reason) in refused {
        if memory.tried.refused(&mend) {
            state.refused.push((mend, reason));
        }
    }
}
