//! Makes the edits that findings propose, as the smallest change to the files' own text, and holds each against the rules
//! again: a fix that brings a new error is not kept.

mod canonical;
mod element;
#[cfg(test)]
mod tests;
mod text_edits;

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::cancel;
use crate::diagnostic::{Diagnostic, Fix, Severity, Subject};
use crate::osm::{OsmData, ReadError, Source, read_bytes};
pub use canonical::canonical;
use text_edits::TextEdits;

/// A fix and what it mends.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Mend {
    /// Code of the finding.
    pub code: String,
    /// What it is about.
    pub subject: Subject,
    /// What the fix does, in one line.
    pub title: String,
}

/// What came of mending.
#[derive(Debug)]
pub struct Mended {
    /// The map as it is now.
    pub osm: OsmData,
    /// What is left to find in it.
    pub left: Vec<Diagnostic>,
    /// What was done, in order.
    pub done: Vec<Mend>,
    /// What was tried and not kept: it brought a new error, or did not mend what it was for.
    pub refused: Vec<Mend>,
    /// How many of the findings left have a fix that needs a look first.
    pub unsafe_left: usize,
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
/// or all with `unsafe_too`. The cost is a judgement for each round, and some more for each fix that is refused.
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
    let mut state = Mended { osm, left, done: Vec::new(), refused: Vec::new(), unsafe_left: 0 };
    // Nothing is tried twice, so that two fixes cannot undo each other for ever.
    let mut tried: FxHashSet<Mend> = FxHashSet::default();
    loop {
        cancel::look();
        let open: Vec<(Mend, Fix)> = state
            .left
            .iter()
            .filter_map(|found| Some((mend_of(found)?, found.finding.fix.clone()?)))
            .filter(|(mend, fix)| (fix.safe || unsafe_too) && !tried.contains(mend))
            .collect();
        // What does not load goes first: most of what else is found may only follow from it.
        let loading: Vec<(Mend, Fix)> = open.iter().filter(|(mend, _)| is_of_the_file(mend)).cloned().collect();
        let open = if loading.is_empty() { open } else { loading };
        let mut batch = &open[..];
        // Halved until it does no harm: at the least one fix is kept or refused in each round.
        loop {
            let Some(attempt) = attempt(&state, batch, &judge)? else {
                if let [only, ..] = batch {
                    tried.insert(only.0.clone());
                    state.refused.push(only.0.clone());
                }
                break;
            };
            if attempt.good {
                tried.extend(attempt.done.iter().cloned());
                state.done.extend(attempt.done);
                (state.osm, state.left) = (attempt.osm, attempt.left);
                break;
            }
            if attempt.done.len() == 1 {
                tried.insert(attempt.done[0].clone());
                state.refused.extend(attempt.done);
                break;
            }
            batch = &batch[..batch.len().div_ceil(2)];
        }
        if open.is_empty() {
            break;
        }
    }
    state.unsafe_left =
        state.left.iter().filter(|found| found.finding.fix.as_ref().is_some_and(|fix| !fix.safe)).count();
    Ok(state)
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

/// A batch of fixes, made and judged.
struct Attempt {
    osm: OsmData,
    left: Vec<Diagnostic>,
    done: Vec<Mend>,
    good: bool,
}

/// Applies those fixes of a batch that do not change the same thing; `None` if none could be applied.
fn attempt<E>(
    state: &Mended,
    batch: &[(Mend, Fix)],
    judge: &impl Fn(&OsmData) -> Result<Vec<Diagnostic>, FixError<E>>,
) -> Result<Option<Attempt>, FixError<E>> {
    let mut edits = TextEdits::new(&state.osm);
    let done: Vec<Mend> = batch.iter().filter(|(_, fix)| edits.apply(fix)).map(|(mend, _)| mend.clone()).collect();
    if done.is_empty() {
        return Ok(None);
    }
    let osm = reread(&state.osm.sources, edits.texts()).map_err(FixError::Read)?;
    let left = judge(&osm)?;
    let good = !worse(&state.left, &left) && done.iter().all(|mend| count(&left, mend) < count(&state.left, mend));
    Ok(Some(Attempt { osm, left, done, good }))
}

fn reread(sources: &[Source], texts: Vec<String>) -> Result<OsmData, ReadError> {
    let mut osm = OsmData::default();
    for (source, text) in sources.iter().zip(texts) {
        read_bytes(&mut osm, &source.name, text.into_bytes())?;
    }
    Ok(osm)
}

fn mend_of(found: &Diagnostic) -> Option<Mend> {
    let fix = found.finding.fix.as_ref()?;
    Some(Mend { code: found.code.clone(), subject: found.finding.subject, title: fix.title.clone() })
}

/// How often a fix is called for.
fn count(found: &[Diagnostic], mend: &Mend) -> usize {
    found.iter().filter(|one| mend_of(one).as_ref() == Some(mend)).count()
}

/// Whether there is an error that was not there before, of any element.
fn worse(before: &[Diagnostic], after: &[Diagnostic]) -> bool {
    let errors = |found: &[Diagnostic]| {
        let mut counts: BTreeMap<(String, Subject), usize> = BTreeMap::new();
        for one in found.iter().filter(|one| one.severity == Severity::Error) {
            *counts.entry((one.code.clone(), one.finding.subject)).or_default() += 1;
        }
        counts
    };
    let before = errors(before);
    errors(after).into_iter().any(|(error, count)| before.get(&error).is_none_or(|&known| count > known))
}
