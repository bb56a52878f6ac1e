//! Applies a batch of fixes, and the fixes of what they bring, to a map, and has the result judged.

use rustc_hash::FxHashMap;

use super::fixes_by_place::elements_of;
use super::harmful_fixes;
use super::judgement::{ChangeJudge, Judge, JudgedMap};
use super::proposal::{Attempt, Mend, Proposal};
use super::routes;
use super::text_edits::{IdRange, TextEdits};
use crate::diagnostic::{Diagnostic, Fix};
use crate::osm::{OsmData, ReadError};

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

/// The results of earlier attempts of a round.
#[derive(Default)]
pub struct Earlier {
    /// The last one, without what followed from it.
    pub last: Option<(OsmData, Vec<Diagnostic>)>,
    /// The ids that fixes have used.
    ids: FxHashMap<Mend, IdRange>,
}

/// The largest number of fixes that follow from each other. For example, a lane is cut beside others, then its pieces share their
/// borders one after the other, because their ends touch, and then the new borders get their tags.
const MOST_STEPS: usize = 4;

/// Applies the fixes of a batch that change different things, and then those of the errors that they bring; `None` if none could be
/// applied.
pub fn attempt<J: Judge>(
    known: JudgedMap,
    may: &impl Fn(&Fix) -> bool,
    batch: &[Proposal],
    (judge, earlier): (&ChangeJudge<J>, &mut Earlier),
) -> Result<Option<Attempt>, FixError<J::Error>> {
    let mut edits = TextEdits::new(known.osm);
    edits.spare(earlier.ids.values().copied());
    let mut used = std::mem::take(&mut earlier.ids);
    let make = |one: &Proposal| {
        let (creates, ids) = edits.apply_again(&one.fix, used.remove(&one.mend))?;
        earlier.ids.insert(one.mend.clone(), ids);
        let reaches = one.touched().flat_map(|key| edits.made_of(key)).collect();
        Some(Proposal { creates, reaches, ..one.clone() })
    };
    let done: Vec<Proposal> = batch.iter().filter_map(make).collect();
    if done.is_empty() {
        return Ok(None);
    }
    let renumbered = edits.renumbered();
    let osm = edits.made().map_err(FixError::Read)?;
    let last = earlier.last.as_ref().map(|(osm, left)| JudgedMap { osm, left });
    let left = judge.judged(std::iter::once(known).chain(last), &osm).map_err(FixError::Judge)?;
    let mut attempt = Attempt { osm, left, done, renumbered, routes: Vec::new(), as_made: None };
    for _ in 0..MOST_STEPS {
        if !follow(known.left, may, &mut attempt, judge)? {
            break;
        }
    }
    if attempt.done.iter().any(routes::may_change) {
        attempt.routes = judge.changed_routes(known.osm, &attempt.osm, &attempt.renumbered);
    }
    Ok(Some(attempt))
}

/// Applies the fixes of the errors that a batch brought. Returns whether there was one.
fn follow<J: Judge>(
    before: &[Diagnostic],
    may: &impl Fn(&Fix) -> bool,
    attempt: &mut Attempt,
    judge: &ChangeJudge<J>,
) -> Result<bool, FixError<J::Error>> {
    let following = harmful_fixes::following(before, attempt, may);
    let mut edits = TextEdits::new(&attempt.osm);
    let make = |(leaders, one): (Vec<usize>, Proposal)| {
        let creates = edits.apply(&one.fix)?;
        let reaches = one.touched().flat_map(|key| edits.made_of(key)).collect();
        Some((leaders, Proposal { creates, reaches, ..one }))
    };
    let made: Vec<(Vec<usize>, Proposal)> = following.into_iter().filter_map(make).collect();
    if made.is_empty() {
        return Ok(false);
    }
    let renumbered = edits.renumbered();
    let osm = edits.made().map_err(FixError::Read)?;
    let known = JudgedMap { osm: &attempt.osm, left: &attempt.left };
    let left = judge.judged([known], &osm).map_err(FixError::Judge)?;
    let before = (std::mem::replace(&mut attempt.osm, osm), std::mem::replace(&mut attempt.left, left));
    attempt.as_made.get_or_insert(before);
    for ((kind, _), id) in &mut attempt.renumbered {
        *id = renumbered.get(&(*kind, *id)).copied().unwrap_or(*id);
    }
    for (key, id) in renumbered {
        attempt.renumbered.entry(key).or_insert(id);
    }
    for (leaders, one) in made {
        // Each fix that may have brought the error may have brought what comes of its fix.
        let elements: Vec<_> = elements_of(&one).collect();
        for at in &leaders {
            attempt.done.get_mut(*at).into_iter().for_each(|leader| leader.reaches.extend(&elements));
        }
        if let Some(leader) = leaders.first().and_then(|&at| attempt.done.get_mut(at)) {
            leader.creates.extend(one.creates);
            leader.about.extend(one.about);
            leader.followers.push((one.mend, one.fix));
        }
    }
    Ok(true)
}
