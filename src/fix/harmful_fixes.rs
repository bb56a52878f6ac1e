//! Finds the fixes of a batch that did harm: those near a new error, and those that did not mend their own finding.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::{FxHashMap, FxHashSet};

use super::finding_counts::{FindingCounts, errors};
use super::fixes_by_place::{ByPlace, keys};
use super::proposal::{Attempt, Proposal};
use super::revealed::{Marked, is_loose_end, marked_by};
use super::text_edits::Key;
use crate::diagnostic::{Diagnostic, Edit, Fix, Subject};

/// Fixes of a batch, by position, that did harm together: one of them at least is its cause.
#[derive(Debug)]
pub struct Suspected {
    /// The fixes, the likeliest cause last.
    pub fixes: Vec<usize>,
    /// What they did, in one sentence.
    pub reason: String,
}

/// The fixes that may have done harm, in groups that have nothing to do with each other; none if the batch did none. The fix that created
/// what an error is about is its cause, and so is the only one near it, for the other errors near it, too.
pub fn suspected(before: &[Diagnostic], attempt: &Attempt) -> Vec<Suspected> {
    let Attempt { left: after, done, .. } = attempt;
    let fixes = ByPlace::of(done);
    let errors = new_errors(before, attempt).0.into_iter();
    let mut errors: Vec<(&Diagnostic, Vec<usize>)> = errors
        .map(|error| (error, fixes.maker(error).map_or_else(|| fixes.near(error), |maker| vec![maker])))
        .collect();
    let single = |near: &[usize]| if let [only] = near { Some(*only) } else { None };
    let told: BTreeSet<usize> = errors.iter().filter_map(|(_, near)| single(near)).collect();
    errors.retain(|(_, near)| single(near).is_some() || !near.iter().any(|at| told.contains(at)));
    // A fix may harm what another one near it is about.
    for (error, near) in errors.iter_mut().filter(|(error, near)| near.len() == 1 && fixes.maker(error).is_none()) {
        near.extend(fixes.around(error).filter(|at| told.contains(at)));
        near.sort_unstable();
        near.dedup();
    }
    let mut reasons: FxHashMap<usize, (usize, String)> = FxHashMap::default();
    let mut suspicion: FxHashMap<usize, f64> = FxHashMap::default();
    for (number, (error, near)) in errors.iter().enumerate() {
        for &at in near {
            // An error counts more if fewer fixes are near it.
            *suspicion.entry(at).or_default() += 1.0 / near.len() as f64;
            let reason = || (number, format!("it brings {}: {}", error.code, error.finding.message));
            reasons.entry(at).or_insert_with(reason);
        }
    }
    let mut groups: Vec<Vec<usize>> = errors.into_iter().map(|(_, near)| near).collect();
    groups.extend(without_effect(before, after, done).into_iter().map(|at| vec![at]));
    let suspected = united(groups).into_iter().map(|mut fixes| {
        let reason = fixes.iter().filter_map(|at| reasons.get(at)).min().map(|(_, reason)| reason.clone());
        let change = |at: usize| done.get(at).and_then(|one| one.edits().map(change_of).max()).unwrap_or_default();
        let likely = |at: usize| suspicion.get(&at).copied().unwrap_or(0.0);
        fixes.sort_by(|&a, &b| change(a).cmp(&change(b)).then(likely(a).total_cmp(&likely(b))));
        Suspected { fixes, reason: reason.unwrap_or_else(|| "the finding stays".to_owned()) }
    });
    suspected.collect()
}

/// The fixes that draw the area of an intersection and reveal more errors there than they mend, each with the reason. Errors that
/// a fix mends and loose ends of lanes do not count.
pub fn worse_by_marking(before: &[Diagnostic], attempt: &Attempt, may: impl Fn(&Fix) -> bool) -> Vec<(usize, String)> {
    let draws = attempt.done.iter().enumerate().filter(|(_, one)| one.draws_area());
    let draws: Vec<(usize, FxHashSet<Key>)> = draws.map(|(at, one)| (at, marked_by(one).collect())).collect();
    if draws.is_empty() {
        return Vec::new();
    }
    let stays = |error: &&Diagnostic| !is_loose_end(error) && !error.finding.fix.as_ref().is_some_and(&may);
    let come: Vec<&Diagnostic> = new_errors(before, attempt).1.into_iter().filter(stays).collect();
    let gone = FindingCounts::of(errors(&attempt.left)).exceeded_by(errors(before));
    let refused = draws.into_iter().filter_map(|(at, lanelets)| {
        let there =
            |errors: &[&Diagnostic]| errors.iter().filter(|one| keys(one).any(|key| lanelets.contains(&key))).count();
        let (come_there, gone_there) = (there(&come), there(&gone));
        let first = come.iter().find(|error| keys(error).any(|key| lanelets.contains(&key)))?;
        let (code, message) = (&first.code, &first.finding.message);
        let reason = format!(
            "errors that it brings to light: {come_there}, that it mends: {gone_there}; the first is {code}: {message}"
        );
        (come_there > gone_there).then_some((at, reason))
    });
    refused.collect()
}

/// The fixes of the errors that a batch has brought, each with the positions of those that may have brought it.
pub fn following(before: &[Diagnostic], attempt: &Attempt, may: impl Fn(&Fix) -> bool) -> Vec<(Vec<usize>, Proposal)> {
    let fixes = ByPlace::of(&attempt.done);
    let brought = new_errors(before, attempt).0.into_iter();
    let mendable = brought.filter_map(|error| Some((error, Proposal::of(error).filter(|one| may(&one.fix))?)));
    mendable.map(|(error, one)| (fixes.near(error), one)).collect()
}

/// The errors that a batch has brought, and those that it has revealed.
fn new_errors<'a>(before: &[Diagnostic], attempt: &'a Attempt) -> (Vec<&'a Diagnostic>, Vec<&'a Diagnostic>) {
    let known = FindingCounts::of(errors(before)).renumbered(&attempt.renumbered);
    let errors = known.exceeded_by(errors(&attempt.left));
    let marked = Marked::by(&attempt.done);
    errors.into_iter().partition(|error| !marked.reveals(error))
}

/// The fixes whose finding occurs as often as before.
fn without_effect(before: &[Diagnostic], after: &[Diagnostic], done: &[Proposal]) -> Vec<usize> {
    let [before, after] = [before, after].map(|found| {
        let mut counts: FxHashMap<(&str, Subject, &str), usize> = FxHashMap::default();
        for one in found {
            if let Some(fix) = &one.finding.fix {
                *counts.entry((&one.code, one.finding.subject, &fix.title)).or_default() += 1;
            }
        }
        counts
    });
    let stays = |(_, Proposal { mend, .. }): &(usize, &Proposal)| {
        let key = (mend.code.as_str(), mend.subject, mend.title.as_str());
        after.get(&key).is_some_and(|count| before.get(&key).is_some_and(|known| count >= known))
    };
    done.iter().enumerate().filter(stays).map(|(at, _)| at).collect()
}

/// How much an edit changes: tags and members least, then points and lines, most if lanelets become part of something else.
fn change_of(edit: &Edit) -> u8 {
    match edit {
        Edit::SetTag { .. }
        | Edit::RemoveTag { .. }
        | Edit::AddMember { .. }
        | Edit::RemoveMember { .. }
        | Edit::SetRole { .. }
        | Edit::SetFormatVersion { .. } => 0,
        Edit::CreateArea { .. }
        | Edit::CreateRegulatoryElement { .. }
        | Edit::CreateOpposite { .. }
        | Edit::ReplaceWay { .. }
        | Edit::Divide(_) => 2,
        _ => 1,
    }
}

/// Merges groups that have a fix in common. Each group is sorted, and the groups are in the order of their first fixes.
pub fn united(groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut place_of: FxHashMap<usize, usize> = FxHashMap::default();
    let mut united: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (new, group) in groups.into_iter().enumerate() {
        let known: BTreeSet<usize> = group.iter().filter_map(|at| place_of.get(at).copied()).collect();
        // The smaller groups are added to the largest, so that no fix is moved often.
        let size = |place: &usize| united.get(place).map_or(0, Vec::len);
        let largest = known.iter().copied().max_by_key(size).unwrap_or(new);
        let mut added: Vec<usize> = group.into_iter().filter(|at| !place_of.contains_key(at)).collect();
        added
            .extend(known.iter().filter(|place| **place != largest).filter_map(|place| united.remove(place)).flatten());
        place_of.extend(added.iter().map(|&at| (at, largest)));
        united.entry(largest).or_default().extend(added);
    }
    let mut united: Vec<Vec<usize>> = united.into_values().collect();
    united.iter_mut().for_each(|group| group.sort_unstable());
    united.sort_unstable();
    united
}
