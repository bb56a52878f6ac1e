//! One round of fixes: a batch is made and judged, what does harm is left out, and the rest is kept.

use rustc_hash::{FxHashMap, FxHashSet};

use super::attempt::{Earlier, FixError, attempt, follow_all};
use super::harmful_fixes::{self, Divided, Verdict};
use super::judgement::{ChangeJudge, Judge, JudgedMap};
use super::memory::Memory;
use super::mended::Mended;
use super::proposal::{Attempt, Mend, Proposal};
use super::suspects::{self, Suspects};
use super::text_edits::Key;
use super::{more_warnings, routes};
use crate::diagnostic::Diagnostic;

/// Applies the fixes of a batch that do no harm together; returns the new ids of elements. Each call keeps or refuses at least
/// one fix, or marks one to be tried with the fixes that follow from it.
pub fn round<J: Judge>(
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
        if judge.is_spent() {
            leave_untried(state, memory, batch);
            break;
        }
        let known = JudgedMap { osm: &state.osm, left: &state.left };
        let Some(mut attempt) = attempt(known, &may, &batch, (judge, &mut earlier))? else {
            // None of them can be applied, although nothing else is changed.
            let all = batch.into_iter().map(|one| (one.mend, "it cannot be made".to_owned()));
            refuse(state, memory, all);
            break;
        };
        let mut verdict = judged(state, memory, &attempt, is_first);
        let apart = verdict.leads_apart(&attempt.done);
        if apart && verdict.does_no_other_harm() && !verdict.is_clean() && !attempt.is_followed {
            // What follows is known from this attempt.
            lead(memory, &verdict, &mut attempt.done);
            follow_all(known, &may, &mut attempt, judge)?;
            verdict = judged(state, memory, &attempt, is_first);
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
            let is_heavy = verdict.heavy.contains(&at);
            for one in take(&mut of_each, [at]) {
                let refused = refuse_with_twins(state, memory, one, &reason);
                memory.heavy.extend(refused.into_iter().filter(|_| is_heavy));
            }
        }
        let unfollowed = |one: Proposal| Proposal { followers: Vec::new(), ..one };
        let is_open = |one: &Proposal| !memory.tried.has(&one.mend);
        batch = of_each.into_iter().flatten().filter(is_open).map(unfollowed).collect();
    }
    Ok(FxHashMap::default())
}

/// The decision about each fix of a batch.
fn judged(state: &Mended, memory: &Memory, attempt: &Attempt, is_first: bool) -> Verdict {
    let may = memory.allowed();
    let mut verdict = harmful_fixes::verdict(&state.left, attempt, &may, is_first);
    if memory.leaves_unmarked {
        verdict.refused.extend(harmful_fixes::worse_by_marking(&state.left, attempt, &may));
    }
    verdict.refused.extend(routes::unasked(attempt));
    if !memory.scope.warnings_too && verdict.is_clean() {
        let heavy = more_warnings::of(&state.left, attempt, &may, memory.room);
        let draws_area = |at: &usize| attempt.done.get(*at).is_some_and(Proposal::draws_area);
        verdict.heavy = heavy.iter().map(|(at, _)| *at).filter(draws_area).collect();
        verdict.refused.extend(heavy);
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
        state.about.push(one.about.iter().copied().chain(one.touched()).collect());
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
            (1, Some(only)) => {
                refuse_with_twins(state, memory, only, &group.harm.reason);
            }
            (_, last) => {
                group.put_off.extend(last);
                memory.to_blame.push(group);
            }
        }
    }
    attempt.renumbered
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
