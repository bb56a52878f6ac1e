//! Applies a batch of fixes, and what follows from its leading ones, to a map, and has the result judged.

use rustc_hash::{FxHashMap, FxHashSet};

use super::fixes_by_place::elements_of;
use super::harmful_fixes;
use super::judgement::{ChangeJudge, Judge, JudgedMap};
use super::proposal::{Attempt, Mend, Proposal};
use super::routes;
use super::text_edits::{IdRange, Key, TextEdits};
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

/// Applies the fixes of a batch that change different things, and after each leading fix those that follow from it; `None` if
/// none could be applied.
pub fn attempt<J: Judge>(
    known: JudgedMap,
    may: &impl Fn(&Fix) -> bool,
    batch: &[Proposal],
    (judge, earlier): (&ChangeJudge<J>, &mut Earlier),
) -> Result<Option<Attempt>, FixError<J::Error>> {
    let mut edits = TextEdits::new(known.osm);
    edits.spare(earlier.ids.values().copied());
    let mut used = std::mem::take(&mut earlier.ids);
    let mut led: FxHashSet<Key> = FxHashSet::default();
    let make = |one: &Proposal| {
        // Of two that lead at one place it could not be told which one an error follows from: one waits.
        if one.leads && !one.in_group {
            if elements_of(one).any(|key| led.contains(&key)) {
                return None;
            }
            led.extend(elements_of(one));
        }
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
    let mut attempt = Attempt { osm, left, done, renumbered, routes: Vec::new(), is_followed: false, as_made: None };
    let leads = attempt.done.iter().any(|one| one.leads);
    if leads && !harmful_fixes::does_other_harm(known.left, &attempt) {
        follow_all(known, may, &mut attempt, judge)?;
    } else {
        attempt.compare_routes(known.osm, judge);
    }
    Ok(Some(attempt))
}

impl Attempt {
    /// Finds the routes that the batch changes.
    fn compare_routes<J: Judge>(&mut self, before: &OsmData, judge: &ChangeJudge<J>) {
        self.routes = match self.done.iter().any(routes::may_change) {
            true => judge.changed_routes(before, &self.osm, &self.renumbered),
            false => Vec::new(),
        };
    }
}

/// Applies what follows from the leading fixes of a batch, step by step.
pub fn follow_all<J: Judge>(
    known: JudgedMap,
    may: &impl Fn(&Fix) -> bool,
    attempt: &mut Attempt,
    judge: &ChangeJudge<J>,
) -> Result<(), FixError<J::Error>> {
    attempt.is_followed = true;
    for _ in 0..MOST_STEPS {
        if !follow(known.left, may, attempt, judge)? {
            break;
        }
    }
    attempt.compare_routes(known.osm, judge);
    Ok(())
}

/// The largest number of fixes that follow from each other. For example, a lane is cut beside others, then its pieces share their
/// borders one after the other, because their ends touch, and then the new borders get their tags.
const MOST_STEPS: usize = 4;

/// Applies the fixes of the errors that leading fixes brought. Returns whether there was one.
fn follow<J: Judge>(
    before: &[Diagnostic],
    may: &impl Fn(&Fix) -> bool,
    attempt: &mut Attempt,
    judge: &ChangeJudge<J>,
) -> Result<bool, FixError<J::Error>> {
    let following = harmful_fixes::following(before, attempt, may);
    let mut edits = TextEdits::new(&attempt.osm);
    let make = |(leader, one): (usize, Proposal)| {
        let creates = edits.apply(&one.fix)?;
        let reaches = one.touched().flat_map(|key| edits.made_of(key)).collect();
        Some((leader, Proposal { creates, reaches, ..one }))
    };
    let made: Vec<(usize, Proposal)> = following.into_iter().filter_map(make).collect();
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
    for (leader, one) in made {
        if let Some(leader) = attempt.done.get_mut(leader) {
            leader.creates.extend(one.creates);
            leader.reaches.extend(one.reaches);
            leader.about.extend(one.about);
            leader.followers.push((one.mend, one.fix));
        }
    }
    Ok(true)
}
