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
    // Nothing is tried twice, so that two fixes cannot undo each other for ever.
    let mut tried: FxHashSet<Mend> = FxHashSet::default();
    let mut done_before = 0;
    loop {
        cancel::look();
        let open = state.left.iter().filter_map(Proposal::of);
        let open: Vec<Proposal> =
            open.filter(|one| (one.fix.safe || unsafe_too) && !tried.contains(&one.mend)).collect();
        if open.is_empty() {
            if state.refused.is_empty() || state.done.len() == done_before {
                break;
            }
            // What did harm may do none now that others are done; so a second run finds nothing to do.
            done_before = state.done.len();
            state.refused.drain(..).for_each(|(mend, _)| _ = tried.remove(&mend));
            continue;
        }
        let renumbered = round(&mut state, &mut tried, first_of(open), &judge)?;
        known = known.renumbered(&renumbered);
    }
    state.revealed = known.exceeded_by(&state.left).len();
    state.unsafe_left =
        state.left.iter().filter(|found| found.finding.fix.as_ref().is_some_and(|fix| !fix.safe)).count();
    Ok(state)
}

/// The fixes that go first: those of what does not load, since most of what else is found may only follow from it; then the
/// safe ones, which are not to share the blame for what an assumption does; then the others.
fn first_of(open: Vec<Proposal>) -> Vec<Proposal> {
    let rank = |one: &Proposal| if is_of_the_file(&one.mend) { 0 } else { 1 + u8::from(!one.fix.safe) };
    let first = open.iter().map(rank).min();
    open.into_iter().filter(|one| Some(rank(one)) == first).collect()
}

/// Makes those fixes of a batch that do no harm together; gives back the new ids of elements. At the least one fix is kept or
/// refused.
fn round<E>(
    state: &mut Mended,
    tried: &mut FxHashSet<Mend>,
    mut batch: Vec<Proposal>,
    judge: &impl Fn(&OsmData) -> Result<Vec<Diagnostic>, FixError<E>>,
) -> Result<FxHashMap<Key, i64>, FixError<E>> {
    while !batch.is_empty() {
        let Some(attempt) = attempt(state, &batch, judge)? else {
            // Not one of them can be made, though nothing else is changed.
            let all = batch.into_iter().map(|one| (one.mend, "it cannot be made".to_owned()));
            refuse(state, tried, all);
            break;
        };
        let verdict = blame::verdict(&state.left, &attempt);
        if verdict.refused.is_empty() && verdict.put_off.is_empty() {
            let done = attempt.done.into_iter().map(|one| one.mend);
            state.done.extend(done.inspect(|mend| _ = tried.insert(mend.clone())));
            (state.osm, state.left) = (attempt.osm, attempt.left);
            return Ok(attempt.renumbered);
        }
        let mut of_each: Vec<Option<Proposal>> = attempt.done.into_iter().map(Some).collect();
        let mut take = |places: &[usize]| -> Vec<Proposal> {
            places.iter().filter_map(|&at| of_each.get_mut(at)?.take()).collect()
        };
        let (refused, reasons): (Vec<usize>, Vec<String>) = verdict.refused.into_iter().unzip();
        let refused = take(&refused).into_iter().map(|one| one.mend).zip(reasons);
        take(&verdict.put_off);
        refuse(state, tried, refused);
        batch = of_each.into_iter().flatten().collect();
    }
    Ok(FxHashMap::default())
}

fn refuse(state: &mut Mended, tried: &mut FxHashSet<Mend>, refused: impl Iterator<Item = (Mend, String)>) {
    let fresh = refused.filter(|(mend, _)| tried.insert(mend.clone()));
    state.refused.extend(fresh);
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

/// Applies those fixes of a batch that do not change the same thing; `None` if none could be applied.
fn attempt<E>(
    state: &Mended,
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
    Ok(Some(Attempt { osm, left, done, renumbered }))
}

fn reread(sources: &[Source], texts: Vec<String>) -> Result<OsmData, ReadError> {
    let mut osm = OsmData::default();
    for (source, text) in sources.iter().zip(texts) {
        read_bytes(&mut osm, &source.name, text.into_bytes())?;
    }
    Ok(osm)
}
