//! Finds the fixes of a batch that did harm: those near a new error, and those that did not mend their own finding.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::{FxHashMap, FxHashSet};

use super::finding_counts::{FindingCounts, errors};
use super::fixes_by_place::{ByPlace, elements_of, keys};
use super::proposal::{Attempt, Proposal};
use super::revealed::{Marked, is_loose_end, marked_by};
use super::text_edits::Key;
use crate::diagnostic::{Diagnostic, Edit, Fix, Subject};

/// The decision about each fix of a batch, by its position. All lists are empty if the batch does no harm.
#[derive(Debug, Default)]
pub struct Verdict {
    /// Fixes that do harm or mend nothing and are the only possible cause, each with the reason.
    pub refused: Vec<(usize, String)>,
    /// Those of the refused that draw an area and do no harm but to bring more warnings than they mend.
    pub heavy: Vec<usize>,
    /// Fixes that bring errors with fixes of their own, and are tried again together with these.
    pub leading: Vec<usize>,
    /// Fixes that bring such errors as a group: each group is tried again together with the fixes of what it brings.
    pub leading_together: Vec<usize>,
    /// Groups of which some fixes do harm: one part of each group is tried again without the other.
    pub divided: Vec<Divided>,
}

/// A group of fixes that do harm together.
#[derive(Debug)]
pub struct Divided {
    /// Those that are tried again at once.
    pub kept: Vec<usize>,
    /// Those that are put off, at least one.
    pub put_off: Vec<usize>,
    /// What they do.
    pub harm: Harm,
}

/// The harm that refused fixes do.
#[derive(Clone, Debug)]
pub struct Harm {
    /// In one sentence.
    pub reason: String,
    /// Whether every error that they bring has a fix that may be applied.
    pub mendable: bool,
}

impl Harm {
    fn of(error: &Diagnostic, may: impl Fn(&Fix) -> bool) -> Self {
        let mendable = error.finding.fix.as_ref().is_some_and(may);
        Self { reason: format!("it brings {}: {}", error.code, error.finding.message), mendable }
    }

    /// Both, with the reason of this one.
    fn and(self, other: Self) -> Self {
        Self { mendable: self.mendable && other.mendable, ..self }
    }
}

impl Verdict {
    /// Whether the batch may be kept.
    pub fn is_clean(&self) -> bool {
        self.does_no_other_harm() && self.leading.is_empty() && self.leading_together.is_empty()
    }

    /// Whether all harm that there may be is that of fixes which bring errors with fixes of their own.
    pub fn does_no_other_harm(&self) -> bool {
        self.refused.is_empty() && self.divided.is_empty()
    }

    /// Whether the leading fixes and the others of the batch are about different elements. Else what follows from one could undo
    /// the other.
    pub fn leads_apart(&self, done: &[Proposal]) -> bool {
        let leading: BTreeSet<usize> = self.leading.iter().chain(&self.leading_together).copied().collect();
        let elements_of_those = |leads: bool| -> FxHashSet<Key> {
            let those = done.iter().enumerate().filter(|(at, _)| leading.contains(at) == leads);
            those.flat_map(|(_, one)| elements_of(one)).collect()
        };
        elements_of_those(true).is_disjoint(&elements_of_those(false))
    }

    /// A fix leads to others if it was not yet tried together with them, and if they mend all its harm.
    fn add(&mut self, at: usize, harm: Harm, leads: bool) {
        match harm.mendable && !leads {
            true => self.leading.push(at),
            false => self.refused.push((at, harm.reason)),
        }
    }
}

/// Judges a batch by the findings before and after it; `may` says which fixes may be applied at all. The fix that created the
/// subject of an error is its cause, and what is near that fix is judged at the next try. If only one fix can be the cause of
/// another error, and no other such fix is within reach, it is the cause, of the other errors near it, too. Other groups are
/// divided: at the first try in a round (`is_first`) only the likeliest causes are put off, later half of the group.
pub fn verdict(before: &[Diagnostic], attempt: &Attempt, may: impl Fn(&Fix) -> bool, is_first: bool) -> Verdict {
    let Attempt { left: after, done, .. } = attempt;
    let fixes = ByPlace::of(done);
    let (brought, _) = new_errors(before, attempt);
    let mut errors: Vec<(&Diagnostic, Vec<usize>)> =
        brought.into_iter().map(|error| (error, fixes.near(error))).collect();
    let leads = |at: usize| done.get(at).is_some_and(|one| one.leads);
    let leads_alone = |at: usize| done.get(at).is_some_and(|one| one.leads && !one.in_group);
    if !attempt.is_followed {
        errors.retain(|(_, near)| !near.iter().any(|&at| leads(at)));
    }
    let of_makers = harm_of_each(errors.iter().filter_map(|(error, _)| Some((fixes.maker(error)?, *error))), &may);
    errors.retain(|(_, near)| !near.iter().any(|at| of_makers.contains_key(at)));
    let alone = errors.iter().filter_map(|(error, near)| match near[..] {
        [only] => Some((only, *error)),
        _ => None,
    });
    let mut told = harm_of_each(alone, &may);
    let open: Vec<&(&Diagnostic, Vec<usize>)> =
        errors.iter().filter(|(_, near)| !near.iter().any(|at| told.contains_key(at))).collect();
    let mut idle = without_effect(before, after, done);
    idle.retain(|at| !told.contains_key(at) && !of_makers.contains_key(at));
    let groups = open.iter().map(|(_, near)| near.clone()).chain(idle.iter().map(|&at| vec![at]));
    let shared = suspicion(open.iter().map(|(_, near)| near.as_slice()));
    let own = suspicion(errors.iter().map(|(_, near)| near.as_slice()).filter(|near| near.len() == 1));
    let mut harms = harms(&open, &may);
    let mut verdict = Verdict::default();
    of_makers.into_iter().for_each(|(at, harm)| verdict.add(at, harm, leads_alone(at)));
    for group in united(groups.collect()) {
        let harm = group.iter().filter_map(|at| harms.remove(at)).reduce(Harm::and);
        let harm = harm.unwrap_or_else(|| Harm { reason: "the finding stays".to_owned(), mendable: false });
        match group[..] {
            [only] => verdict.add(only, harm, leads_alone(only)),
            _ if may_lead(&group, &harm, attempt) => verdict.leading_together.extend(group),
            _ => verdict.divided.push(divided(group, harm, done, &shared, is_first)),
        }
    }
    let doubtful = blamed_in_group(&errors, &fixes, done);
    for cluster in competing(&errors, &told, &fixes) {
        let harms: Vec<Harm> = cluster.iter().filter_map(|at| told.remove(at)).collect();
        let Some(harm) = harms.into_iter().reduce(Harm::and) else { continue };
        match cluster[..] {
            [only] if doubtful.contains(&only) => verdict.leading.push(only),
            [only] => verdict.add(only, harm, leads_alone(only)),
            _ if may_lead(&cluster, &harm, attempt) => verdict.leading_together.extend(cluster),
            _ => verdict.divided.push(divided(cluster, harm, done, &own, is_first)),
        }
    }
    verdict
}

/// The harm that each fix does, given the errors of each.
fn harm_of_each<'a>(
    errors: impl Iterator<Item = (usize, &'a Diagnostic)>,
    may: impl Fn(&Fix) -> bool,
) -> BTreeMap<usize, Harm> {
    let mut harms: BTreeMap<usize, Harm> = BTreeMap::new();
    for (at, error) in errors {
        let harm = Harm::of(error, &may);
        harms.entry(at).and_modify(|known| known.mendable &= harm.mendable).or_insert(harm);
    }
    harms
}

/// Whether a group is tried together with the fixes of what it brings: all its harm can be mended, and none of it was tried so.
fn may_lead(group: &[usize], harm: &Harm, attempt: &Attempt) -> bool {
    let was_tried = |at: &usize| attempt.done.get(*at).is_some_and(|one| one.in_group);
    harm.mendable && !attempt.is_followed && !group.iter().any(was_tried)
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

/// The harm that errors do, by the first fix near each.
fn harms(errors: &[&(&Diagnostic, Vec<usize>)], may: impl Fn(&Fix) -> bool) -> FxHashMap<usize, Harm> {
    let mut harms: FxHashMap<usize, Harm> = FxHashMap::default();
    for (error, near) in errors {
        if let Some(&first) = near.first() {
            let harm = Harm::of(error, &may);
            let harm = harms.remove(&first).into_iter().fold(harm, |harm, earlier| earlier.and(harm));
            harms.insert(first, harm);
        }
    }
    harms
}

/// Groups of fixes that are each the only one near an error. Fixes within reach of each other are one group, because a fix may
/// harm what another fix is about.
fn competing(errors: &[(&Diagnostic, Vec<usize>)], told: &BTreeMap<usize, Harm>, fixes: &ByPlace) -> Vec<Vec<usize>> {
    let clusters = errors.iter().filter_map(|(error, near)| match near[..] {
        [only] => {
            let around = fixes.around(error).filter(|at| told.contains_key(at));
            Some(std::iter::once(only).chain(around).collect::<BTreeSet<usize>>().into_iter().collect())
        }
        _ => None,
    });
    united(clusters.collect())
}

/// The fixes of groups that are the only ones near an error although another leading fix is within reach: the error may be about
/// what follows from that one, so that they are tried alone.
fn blamed_in_group(errors: &[(&Diagnostic, Vec<usize>)], fixes: &ByPlace, done: &[Proposal]) -> FxHashSet<usize> {
    let is = |at: usize, what: fn(&Proposal) -> bool| done.get(at).is_some_and(what);
    let blamed = errors.iter().filter_map(|(error, near)| match near[..] {
        [only] if is(only, |one| one.in_group) => {
            let other = fixes.around(error).any(|at| at != only && is(at, |one| one.leads));
            other.then_some(only)
        }
        _ => None,
    });
    blamed.collect()
}

/// How likely each fix is the cause of errors: an error counts more if fewer fixes are near it.
fn suspicion<'a>(errors: impl Iterator<Item = &'a [usize]>) -> FxHashMap<usize, f64> {
    let mut suspicion: FxHashMap<usize, f64> = FxHashMap::default();
    for near in errors {
        for &at in near {
            *suspicion.entry(at).or_default() += 1.0 / near.len() as f64;
        }
    }
    suspicion
}

/// Divides a group: the fixes that change most are put off first, and of these the likeliest causes.
fn divided(
    mut group: Vec<usize>,
    harm: Harm,
    done: &[Proposal],
    suspicion: &FxHashMap<usize, f64>,
    is_first: bool,
) -> Divided {
    let rank = |at: &usize| {
        let change = done.get(*at).and_then(|one| one.edits().map(change_of).max()).unwrap_or_default();
        (change, suspicion.get(at).copied().unwrap_or(0.0))
    };
    let by_rank = |a: &usize, b: &usize| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    };
    group.sort_by(by_rank);
    let half = group.len().div_ceil(2);
    let as_likely = |last: &usize| group.partition_point(|at| by_rank(at, last).is_lt());
    let likeliest = group.last().map_or(half, as_likely);
    let put_off = group.split_off(if is_first { likeliest.max(half) } else { half });
    Divided { kept: group, put_off, harm }
}

/// Whether a batch has brought errors that are not near a leading fix: these are dealt with first.
pub fn does_other_harm(before: &[Diagnostic], attempt: &Attempt) -> bool {
    let fixes = ByPlace::of(&attempt.done);
    let leads = |at: usize| attempt.done.get(at).is_some_and(|one| one.leads);
    new_errors(before, attempt).0.into_iter().any(|error| !fixes.near(error).into_iter().any(leads))
}

/// The fixes of the errors that a batch has brought, each with the position of the leading fix.
pub fn following(before: &[Diagnostic], attempt: &Attempt, may: impl Fn(&Fix) -> bool) -> Vec<(usize, Proposal)> {
    let fixes = ByPlace::of(&attempt.done);
    let leader = |at: &usize| attempt.done.get(*at).is_some_and(|one| one.leads);
    let followers = new_errors(before, attempt).0.into_iter().filter_map(|error| {
        let leader = fixes.near(error).into_iter().find(leader)?;
        let follower = Proposal::of(error).filter(|one| may(&one.fix))?;
        Some((leader, follower))
    });
    followers.collect()
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
fn united(groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
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
