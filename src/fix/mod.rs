//! Makes the edits that findings propose, as the smallest change to the files' own text, and holds each against the rules
//! again: a fix that brings a new error is not kept.

mod blame;
mod canonical;
mod element;
mod proposal;
#[cfg(test)]
mod tests;
mod text_edits;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::cancel;
use crate::diagnostic::{Diagnostic, Fix};
use crate::osm::{OsmData, ReadError, Source, read_bytes};
use blame::ErrorCounts;
pub use canonical::canonical;
pub use proposal::Mend;
use proposal::{Attempt, Proposal};
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
            place.zip(one.place).is_none_or(|places| apart(places) <= blame::REACH)
                || about.iter().any(|key| one.about.contains(key))
        })
    }
}

/// The fixes that go first: those of what does not load, since most of what else is found may only follow from it; then the
/// safe ones, which are not to share the blame for what an assumption does; then the others; areas last, over what is settled.
fn first_of(open: Vec<Proposal>) -> Vec<Proposal> {
    let rank = |one: &Proposal| match is_of_the_file(&one.mend) {
        true => 0,
        false => 1 + u8::from(!one.fix.safe) + u8::from(one.draws_area()),
    };
    let first = open.iter().map(rank).min();
    open.into_iter().filter(|one| Some(rank(one)) == first).collect()
}

/// Makes those fixes of a batch that do no harm together; gives back the new ids of elements. At the least one fix is kept or
/// refused, or is to be tried with what follows from it.
fn round<E>(
    state: &mut Mended,
    memory: &mut Memory,
    mut batch: Vec<Proposal>,
    judge: &impl Fn(&OsmData) -> Result<Vec<Diagnostic>, FixError<E>>,
) -> Result<FxHashMap<Key, i64>, FixError<E>> {
    while !batch.is_empty() {
        let Some(attempt) = attempt(state, memory, &batch, judge)? else {
            // Not one of them can be made, though nothing else is changed.
            let all = batch.into_iter().map(|one| (one.mend, "it cannot be made".to_owned()));
            refuse(state, memory, all);
            break;
        };
        let verdict = blame::verdict(&state.left, &attempt, |fix| memory.may(fix));
        if verdict.is_clean() {
            for one in attempt.done {
                memory.tried.insert(one.mend.clone());
                memory.made.push((one.place, one.about.clone()));
                state.done.extend(one.mends());
            }
            (state.osm, state.left) = (attempt.osm, attempt.left);
            return Ok(attempt.renumbered);
        }
        let mut of_each: Vec<Option<Proposal>> = attempt.done.into_iter().map(Some).collect();
        let mut take = |places: &[usize]| -> Vec<Proposal> {
            places.iter().filter_map(|&at| of_each.get_mut(at)?.take()).collect()
        };
        let (refused, reasons): (Vec<usize>, Vec<String>) = verdict.refused.into_iter().unzip();
        let refused: Vec<(Mend, String)> = take(&refused)
            .into_iter()
            .zip(reasons)
            .flat_map(|(one, reason)| twins(&state.left, one).into_iter().map(move |mend| (mend, reason.clone())))
            .collect();
        take(&verdict.put_off);
        memory.leading.extend(take(&verdict.leading).into_iter().map(|one| one.mend));
        refuse(state, memory, refused.into_iter());
        let unfollowed = |one: Proposal| Proposal { followers: Vec::new(), ..one };
        let is_open = |one: &Proposal| !memory.tried.contains(&one.mend);
        batch = of_each.into_iter().flatten().filter(is_open).map(unfollowed).collect();
    }
    Ok(FxHashMap::default())
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

/// Whether a fix mends the file itself, before anything in it means something.
fn is_of_the_file(mend: &Mend) -> bool {
    ["load/", "ids/", "node/"].iter().any(|family| mend.code.starts_with(family))
}

/// The files' texts with the edits of one fix; `None` if it cannot be made.
pub fn edited(osm: &OsmData, fix: &Fix) -> Option<Vec<String>> {
    let mut edits = TextEdits::new(osm);
    edits.apply(fix).then(|| edits.texts())
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
    let done: Vec<Proposal> = batch.iter().filter(|one| edits.apply(&one.fix)).cloned().collect();
    if done.is_empty() {
        return Ok(None);
    }
    let renumbered = edits.renumbered();
    let osm = reread(&state.osm.sources, edits.texts()).map_err(FixError::Read)?;
    let left = judge(&osm)?;
    let mut attempt = Attempt { osm, left, done, renumbered };
    if attempt.done.iter().any(|one| one.leads) {
        for _ in 0..MOST_STEPS {
            if !follow(&state.left, memory, &mut attempt, judge)? {
                break;
            }
        }
    }
    Ok(Some(attempt))
}

/// How often what follows from a fix is followed by more.
const MOST_STEPS: usize = 2;

/// Makes the fixes of the errors that leading fixes have brought; whether there was one.
fn follow<E>(
    before: &[Diagnostic],
    memory: &Memory,
    attempt: &mut Attempt,
    judge: &impl Fn(&OsmData) -> Result<Vec<Diagnostic>, FixError<E>>,
) -> Result<bool, FixError<E>> {
    let following = blame::following(before, attempt, |fix| memory.may(fix));
    let mut edits = TextEdits::new(&attempt.osm);
    let made: Vec<(usize, Proposal)> = following.into_iter().filter(|(_, one)| edits.apply(&one.fix)).collect();
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
