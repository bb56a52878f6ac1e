//! Makes the edits that findings propose, as the smallest change to the files' own text, and holds each against the rules
//! again: a fix that brings a new error is not kept.

mod blame;
mod canonical;
mod element;
mod order;
mod places;
mod proposal;
mod suspects;
#[cfg(test)]
mod tests;
mod text_edits;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::cancel;
use crate::diagnostic::{Diagnostic, Fix};
use crate::osm::{OsmData, ReadError, Source, read_bytes};
use blame::{Divided, ErrorCounts};
pub use canonical::canonical;
use order::first_of;
pub use proposal::Mend;
use proposal::{Attempt, Proposal};
use suspects::Suspects;
use text_edits::{Key, TextEdits};

/// What came of mending.
#[derive(Debug)]
pub struct Mended {
    /// The map as it is now.
    pub osm: OsmData,
    /// What is left to find in it.
    pub left: Vec<Diagnostic>,
    /// What was done, in order.
    pub done: Vec<Mend>,
    /// What was tried and not kept, each with the reason: it brought a new error, or did not mend what it was for.
    pub refused: Vec<(Mend, String)>,
    /// How many of the findings left have a fix that needs a look first.
    pub unsafe_left: usize,
    /// How many errors are told only now, since rules look at the intersections that were marked.
    pub revealed: usize,
}

/// Why mending stopped.
#[derive(Debug, thiserror::Error)]
pub enum FixError<E> {
    /// The map could not be judged.
    #[error(transparent)]
    Judge(E),
    /// The edited text could not be read: a fault of ours.
    #[error("the edited map cannot be read again: {0}")]
    Read(ReadError),
}

/// Fixes what `judge` finds, round by round, until there is nothing left that a fix may be made for: those that are safe,
/// or all with `unsafe_too`. Fixes that do not touch the same thing are made and judged together; where that does harm, those
/// near the harm are halved, at all such places at once, so that the cost is a few judgements and not one for each fix.
///
/// # Errors
///
/// If `judge` fails, or an edited file cannot be read again.
pub fn mend<E>(
    osm: OsmData,
    unsafe_too: bool,
    judge: impl Fn(&OsmData) -> Result<Vec<Diagnostic>, E>,
) -> Result<Mended, FixError<E>> {
    let judge = |osm: &OsmData| judge(osm).map_err(FixError::Judge);
    let left = judge(&osm)?;
    let mut known = ErrorCounts::of(&left);
    let mut state = Mended { osm, left, done: Vec::new(), refused: Vec::new(), unsafe_left: 0, revealed: 0 };
    let mut memory = Memory { unsafe_too, ..Memory::default() };
    let (mut done_before, mut fewest) = (0, usize::MAX);
    loop {
        cancel::look();
        let open = memory.open(&state.left);
        if open.is_empty() {
            if state.done.len() == done_before {
                break;
            }
            done_before = state.done.len();
            if !memory.again(&mut state, &mut fewest) {
                break;
            }
            continue;
        }
        let renumbered = round(&mut state, &mut memory, first_of(open), &judge)?;
        known = known.renumbered(&renumbered);
    }
    let open: FxHashSet<Mend> = state.left.iter().filter_map(Proposal::of).map(|one| one.mend).collect();
    state.refused.retain(|(mend, _)| open.contains(mend));
    state.revealed = known.exceeded_by(&state.left).len();
    state.unsafe_left =
        state.left.iter().filter(|found| found.finding.fix.as_ref().is_some_and(|fix| !fix.safe)).count();
    Ok(state)
}

/// What is known of the fixes so far.
#[derive(Default)]
struct Memory {
    unsafe_too: bool,
    /// Nothing is tried twice, so that two fixes cannot undo each other for ever.
    tried: FxHashSet<Mend>,
    /// Those that brought errors that have fixes: they are tried once more, together with these.
    leading: FxHashSet<Mend>,
    /// Where each fix was made, and what it was about.
    made: Vec<(Option<[f64; 2]>, Vec<Key>)>,
    /// How many had been made when a fix was refused.
    refused_at: FxHashMap<Mend, usize>,
    /// Groups of fixes that do harm together, as is known from earlier rounds.
    to_blame: Vec<Suspects>,
}

impl Memory {
    fn may(&self, fix: &Fix) -> bool {
        fix.safe || self.unsafe_too
    }

    fn open(&self, left: &[Diagnostic]) -> Vec<Proposal> {
        let open = left.iter().filter_map(Proposal::of);
        let open = open.filter(|one| self.may(&one.fix) && !self.tried.contains(&one.mend));
        open.map(|one| Proposal { leads: self.leading.contains(&one.mend), ..one }).collect()
    }

    /// Lets fixes be tried again, so that a second run finds nothing to do: those that did harm, which may do none now that others
    /// are done near them, and where fewer findings are left than ever, also those whose finding has come back. Whether there
    /// are any.
    fn again(&mut self, state: &mut Mended, fewest: &mut usize) -> bool {
        let refused: FxHashSet<&Mend> = state.refused.iter().map(|(mend, _)| mend).collect();
        let mut again: Vec<Mend> = Vec::new();
        for one in state.left.iter().filter_map(Proposal::of).filter(|one| self.tried.contains(&one.mend)) {
            let is_due = match refused.contains(&one.mend) {
                true => self.is_changed_near(&one),
                false => state.left.len() < *fewest,
            };
            if is_due {
                again.push(one.mend);
            }
        }
        *fewest = state.left.len().min(*fewest);
        for mend in &again {
            self.tried.remove(mend);
            self.leading.remove(mend);
        }
        state.refused.retain(|(mend, _)| self.tried.contains(mend));
        !again.is_empty()
    }

    /// Whether another fix was made near one since it was refused.
    fn is_changed_near(&self, one: &Proposal) -> bool {
        let since = self.refused_at.get(&one.mend).copied().unwrap_or(0);
        self.made.get(since..).unwrap_or_default().iter().any(|(place, about)| {
            let apart = |(a, b): ([f64; 2], [f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]);
            place.zip(one.place).is_none_or(|places| apart(places) <= places::REACH)
                || about.iter().any(|key| one.about.contains(key))
        })
    }
}

/// Makes those fixes of a batch that do no harm together; gives back the new ids of elements. At the least one fix is kept or
/// refused, or is to be tried with what follows from it.
fn round<E>(
    state: &mut Mended,
    memory: &mut Memory,
    mut batch: Vec<Proposal>,
    judge: &impl Fn(&OsmData) -> Result<Vec<Diagnostic>, FixError<E>>,
) -> Result<FxHashMap<Key, i64>, FixError<E>> {
    let to_blame = std::mem::take(&mut memory.to_blame);
    let mut suspects: Vec<Suspects> = to_blame.into_iter().filter_map(|group| group.divide(&mut batch)).collect();
    let mut is_first = true;
    while !batch.is_empty() {
        let Some(attempt) = attempt(state, memory, &batch, judge)? else {
            // Not one of them can be made, though nothing else is changed.
            let all = batch.into_iter().map(|one| (one.mend, "it cannot be made".to_owned()));
            refuse(state, memory, all);
            break;
        };
        let verdict = blame::verdict(&state.left, &attempt, |fix| memory.may(fix), is_first);
        if verdict.is_clean() {
            return Ok(keep(state, memory, attempt, suspects));
        }
        is_first = false;
        let mut of_each: Vec<Option<Proposal>> = attempt.done.into_iter().map(Some).collect();
        for Divided { kept, put_off, harm } in verdict.divided {
            let mend = |at: usize| Some(of_each.get(at)?.as_ref()?.mend.clone());
            let kept = kept.into_iter().filter_map(mend).collect();
            suspects.push(Suspects { kept, put_off: take(&mut of_each, put_off), harm });
        }
        memory.leading.extend(take(&mut of_each, verdict.leading).into_iter().map(|one| one.mend));
        for (at, reason) in verdict.refused {
            for one in take(&mut of_each, [at]) {
                refuse_with_twins(state, memory, one, &reason);
            }
        }
        let unfollowed = |one: Proposal| Proposal { followers: Vec::new(), ..one };
        let is_open = |one: &Proposal| !memory.tried.contains(&one.mend);
        batch = of_each.into_iter().flatten().filter(is_open).map(unfollowed).collect();
    }
    Ok(FxHashMap::default())
}

fn take(of_each: &mut [Option<Proposal>], places: impl IntoIterator<Item = usize>) -> Vec<Proposal> {
    places.into_iter().filter_map(|at| of_each.get_mut(at)?.take()).collect()
}

/// Keeps what a batch has done, and blames those whom it leaves as the only cause of harm; gives back the new ids of elements.
fn keep(state: &mut Mended, memory: &mut Memory, attempt: Attempt, suspects: Vec<Suspects>) -> FxHashMap<Key, i64> {
    let made: FxHashSet<Mend> = attempt.done.iter().map(|one| one.mend.clone()).collect();
    for one in attempt.done {
        memory.tried.insert(one.mend.clone());
        memory.made.push((one.place, one.about.clone()));
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

/// Refuses a fix and those of other findings that would do the very same.
fn refuse_with_twins(state: &mut Mended, memory: &mut Memory, one: Proposal, reason: &str) {
    let twins = twins(&state.left, one);
    refuse(state, memory, twins.into_iter().map(|mend| (mend, reason.to_owned())));
}

/// A fix and those of other findings that would do the very same: each lanelet of an intersection proposes its area.
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
        memory.refused_at.insert(mend.clone(), memory.made.len());
        if memory.tried.insert(mend.clone()) {
            state.refused.push((mend, reason));
        }
    }
}

/// The files' texts with the edits of one fix; `None` if it cannot be made.
pub fn edited(osm: &OsmData, fix: &Fix) -> Option<Vec<String>> {
    let mut edits = TextEdits::new(osm);
    edits.apply(fix)?;
    Some(edits.texts())
}

/// Applies those fixes of a batch that do not change the same thing, and with those that lead to others these, too; `None` if
/// none could be applied.
fn attempt<E>(
    state: &Mended,
    memory: &Memory,
    batch: &[Proposal],
    judge: &impl Fn(&OsmData) -> Result<Vec<Diagnostic>, FixError<E>>,
) -> Result<Option<Attempt>, FixError<E>> {
    let mut edits = TextEdits::new(&state.osm);
    let make = |one: &Proposal| Some(Proposal { creates: edits.apply(&one.fix)?, ..one.clone() });
    let done: Vec<Proposal> = batch.iter().filter_map(make).collect();
    if done.is_empty() {
        return Ok(None);
    }
    let renumbered = edits.renumbered();
    let osm = reread(&state.osm.sources, edits.texts()).map_err(FixError::Read)?;
    let left = judge(&osm)?;
    let mut attempt = Attempt { osm, left, done, renumbered, is_followed: false };
    let leads = attempt.done.iter().any(|one| one.leads);
    if leads && !blame::does_other_harm(&state.left, &attempt) {
        attempt.is_followed = true;
        for _ in 0..MOST_STEPS {
            if !follow(&state.left, memory, &mut attempt, judge)? {
                break;
            }
        }
    }
    Ok(Some(attempt))
}

/// How often what follows from a fix is followed by more: where a lane is cut beside others, its pieces share their borders by turns, since
/// they have ends in common, and the new borders then get their tags.
const MOST_STEPS: usize = 4;

/// Makes the fixes of the errors that leading fixes have brought; whether there was one.
fn follow<E>(
    before: &[Diagnostic],
    memory: &Memory,
    attempt: &mut Attempt,
    judge: &impl Fn(&OsmData) -> Result<Vec<Diagnostic>, FixError<E>>,
) -> Result<bool, FixError<E>> {
    let following = blame::following(before, attempt, |fix| memory.may(fix));
    let mut edits = TextEdits::new(&attempt.osm);
    let make = |(leader, one): (usize, Proposal)| {
        let creates = edits.apply(&one.fix)?;
        Some((leader, Proposal { creates, ..one }))
    };
    let made: Vec<(usize, Proposal)> = following.into_iter().filter_map(make).collect();
    if made.is_empty() {
        return Ok(false);
    }
    let renumbered = edits.renumbered();
    let osm = reread(&attempt.osm.sources, edits.texts()).map_err(FixError::Read)?;
    attempt.left = judge(&osm)?;
    attempt.osm = osm;
    for ((kind, _), id) in &mut attempt.renumbered {
        *id = renumbered.get(&(*kind, *id)).copied().unwrap_or(*id);
    }
    for (key, id) in renumbered {
        attempt.renumbered.entry(key).or_insert(id);
    }
    for (leader, one) in made {
        if let Some(leader) = attempt.done.get_mut(leader) {
            leader.creates.extend(one.creates);
            leader.followers.push((one.mend, one.fix));
        }
    }
    Ok(true)
}

fn reread(sources: &[Source], texts: Vec<String>) -> Result<OsmData, ReadError> {
    let mut osm = OsmData::default();
    for (source, text) in sources.iter().zip(texts) {
        read_bytes(&mut osm, &source.name, text.into_bytes())?;
    }
    Ok(osm)
}
