//! Which fixes of a batch did harm: those near an error that was not there before, and those that did not mend what they were for.

use std::collections::{BTreeMap, BTreeSet};

use rstar::RTree;
use rstar::primitives::GeomWithData;
use rustc_hash::{FxHashMap, FxHashSet};

use super::proposal::{Attempt, Proposal};
use super::text_edits::{Key, key_of};
use crate::diagnostic::{Diagnostic, Edit, Fix, Severity, Subject};

/// An error within this distance (m) of a fix may be its doing: an intersection with its approaches is about as large.
pub const REACH: f64 = 60.0;
/// A finding that speaks of more elements than these is about a group of them: others are about one and its neighbour.
const MANY: usize = 2;

/// What is to happen to the fixes of a batch, by their positions; nothing, where the batch does no harm.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// They do harm, or mend nothing, and nothing else can be the cause: each with the reason.
    pub refused: Vec<(usize, String)>,
    /// They bring errors that have fixes themselves, and are to be tried together with those.
    pub leading: Vec<usize>,
    /// Some of these do, together with others: they are tried again without those.
    pub put_off: Vec<usize>,
}

impl Verdict {
    /// Whether the batch may be kept.
    pub fn is_clean(&self) -> bool {
        self.refused.is_empty() && self.leading.is_empty() && self.put_off.is_empty()
    }
}

/// Judges a batch by what was found before and after it; `may` says which fixes may be made at all.
pub fn verdict(before: &[Diagnostic], attempt: &Attempt, may: impl Fn(&Fix) -> bool) -> Verdict {
    let Attempt { left: after, done, .. } = attempt;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let fixes = ByPlace::of(done);
    let mut reasons: FxHashMap<usize, String> = FxHashMap::default();
    let mut mendable: FxHashMap<usize, bool> = FxHashMap::default();
    for error in new_errors(before, attempt) {
        let near = fixes.near(error);
        if let [only] = near[..] {
            reasons.entry(only).or_insert_with(|| format!("it brings {}: {}", error.code, error.finding.message));
            *mendable.entry(only).or_insert(true) &= error.finding.fix.as_ref().is_some_and(&may);
        }
        groups.push(near);
    }
    groups.extend(without_effect(before, after, done).into_iter().map(|at| vec![at]));
    let mut verdict = Verdict::default();
    for group in united(groups) {
        match group[..] {
            [only] if mendable.get(&only) == Some(&true) && done.get(only).is_some_and(|one| !one.leads) => {
                verdict.leading.push(only);
            }
            [only] => {
                let reason = reasons.remove(&only).unwrap_or_else(|| "the finding stays".to_owned());
                verdict.refused.push((only, reason));
            }
            _ => verdict.put_off.extend(second_half(group, done)),
        }
    }
    verdict
}

/// The fixes of errors that a batch has brought, each with the position of the fix that leads to it.
pub fn following(before: &[Diagnostic], attempt: &Attempt, may: impl Fn(&Fix) -> bool) -> Vec<(usize, Proposal)> {
    let fixes = ByPlace::of(&attempt.done);
    let leader = |at: &usize| attempt.done.get(*at).is_some_and(|one| one.leads);
    let followers = new_errors(before, attempt).into_iter().filter_map(|error| {
        let leader = fixes.near(error).into_iter().find(leader)?;
        let follower = Proposal::of(error).filter(|one| may(&one.fix))?;
        Some((leader, follower))
    });
    followers.collect()
}

/// The half of a group that is put off: those that make new elements first, for they change more than tags do.
fn second_half(mut group: Vec<usize>, done: &[Proposal]) -> Vec<usize> {
    let makes_elements = |one: &Proposal| one.edits().any(makes_elements);
    group.sort_by_key(|&at| done.get(at).is_some_and(makes_elements));
    group.split_off(group.len().div_ceil(2))
}

/// How many errors of each code each element of the files has, and what the errors speak of.
pub struct ErrorCounts {
    of_each: FxHashMap<(String, Option<Key>), usize>,
    /// By code, the elements of each error that speaks of several.
    spoken_of: FxHashMap<String, Vec<FxHashSet<Key>>>,
}

impl ErrorCounts {
    /// Counts them.
    pub fn of(found: &[Diagnostic]) -> Self {
        let mut counts = Self { of_each: FxHashMap::default(), spoken_of: FxHashMap::default() };
        for one in found.iter().filter(|one| one.severity == Severity::Error) {
            *counts.of_each.entry((one.code.clone(), key_of(one.finding.subject))).or_default() += 1;
            if !one.finding.related.is_empty() {
                counts.spoken_of.entry(one.code.clone()).or_default().push(keys(one).collect());
            }
        }
        counts
    }

    /// The same, with the new ids of elements that have one.
    pub fn renumbered(self, fresh: &FxHashMap<Key, i64>) -> Self {
        if fresh.is_empty() {
            return self;
        }
        let renumber = |(kind, id): Key| (kind, fresh.get(&(kind, id)).copied().unwrap_or(id));
        let renumber_all = |set: FxHashSet<Key>| set.into_iter().map(renumber).collect();
        let Self { of_each, spoken_of } = self;
        Self {
            of_each: of_each.into_iter().map(|((code, key), count)| ((code, key.map(renumber)), count)).collect(),
            spoken_of: spoken_of
                .into_iter()
                .map(|(code, sets)| (code, sets.into_iter().map(renumber_all).collect()))
                .collect(),
        }
    }

    /// The errors of elements that have more of them than these. One that speaks only of what a single error of its code spoke of
    /// before is not new: a group has become smaller, and its first element another.
    pub fn exceeded_by(self, found: &[Diagnostic]) -> Vec<&Diagnostic> {
        let Self { mut of_each, spoken_of } = self;
        let errors = found.iter().filter(|one| one.severity == Severity::Error);
        let is_new = |one: &&Diagnostic| match of_each.get_mut(&(one.code.clone(), key_of(one.finding.subject))) {
            Some(count) if *count > 0 => {
                *count -= 1;
                false
            }
            _ => !spoken_of
                .get(&one.code)
                .is_some_and(|sets| sets.iter().any(|set| set.len() > MANY && keys(one).all(|key| set.contains(&key)))),
        };
        errors.filter(is_new).collect()
    }
}

/// The elements that a finding speaks of.
fn keys(found: &Diagnostic) -> impl Iterator<Item = Key> + '_ {
    let related = found.finding.related.iter().map(|one| one.subject);
    std::iter::once(found.finding.subject).chain(related).filter_map(key_of)
}

/// The errors that a batch has brought.
fn new_errors<'a>(before: &[Diagnostic], attempt: &'a Attempt) -> Vec<&'a Diagnostic> {
    let mut errors = ErrorCounts::of(before).renumbered(&attempt.renumbered).exceeded_by(&attempt.left);
    let marked = Marked::by(&attempt.done);
    errors.retain(|error| !marked.reveal(error));
    errors
}

/// Errors by which a vehicle goes where it has to wait: a fix that comes with one is not kept, whatever else it brings to light.
const UNSAFE: [&str; 4] =
    ["vm-03-10/yield-unsafe", "vm-03-11/yield-unsafe", "vm-03-11/priority-inverted", "vm-03-11/mutual"];

/// A lane that comes to an intersection and goes no further, or begins there: it was so before the intersection was marked.
const LOOSE_ENDS: [&str; 2] = ["vm-03-04/in-lane-dead-end", "vm-03-04/out-lane-unreached"];

/// What the fixes of a batch make part of an intersection.
struct Marked {
    lanelets: FxHashSet<i64>,
    /// Whether all that the batch does leaves the ends of lanes as they are.
    ends_stay: bool,
}

impl Marked {
    fn by(done: &[Proposal]) -> Self {
        let edits = || done.iter().flat_map(Proposal::edits);
        let lanelets = edits().filter_map(|edit| match edit {
            Edit::CreateArea { lanelets, .. } => Some(lanelets),
            _ => None,
        });
        let leaves_ends = |edit: &Edit| {
            use Edit::{AddMember, CreateArea, CreateRegulatoryElement, CreateStopLine, SetTag};
            let is_made = matches!(edit, CreateArea { .. } | CreateRegulatoryElement { .. } | CreateStopLine { .. });
            is_made || matches!(edit, SetTag { .. } | AddMember { .. })
        };
        Self { lanelets: lanelets.flatten().copied().collect(), ends_stay: edits().all(leaves_ends) }
    }

    /// Whether an error was there before and is only told now, since rules look at lanes of intersections that do not look at
    /// others: it is about how such a lane is drawn, and not about the area or the tags that the fix has made.
    fn reveal(&self, error: &Diagnostic) -> bool {
        if self.ends_stay && !self.lanelets.is_empty() && LOOSE_ENDS.contains(&error.code.as_str()) {
            return true;
        }
        let of_the_fix = ["vm-03-01/", "vm-03-02/", "vm-03-08/"].iter().any(|rule| error.code.starts_with(rule))
            || UNSAFE.contains(&error.code.as_str());
        let finding = &error.finding;
        let mut subjects = std::iter::once(finding.subject).chain(finding.related.iter().map(|one| one.subject));
        let is_marked = |subject| matches!(subject, Subject::Lanelet(id) if self.lanelets.contains(&id));
        !of_the_fix && subjects.any(is_marked)
    }
}

/// The fixes whose finding is there as often as before.
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

/// The fixes of a batch by place and by what they are about.
struct ByPlace {
    tree: RTree<GeomWithData<[f64; 2], usize>>,
    elements: FxHashMap<Key, Vec<usize>>,
    /// Those without a place.
    nowhere: Vec<usize>,
    count: usize,
}

impl ByPlace {
    fn of(done: &[Proposal]) -> Self {
        let mut elements: FxHashMap<Key, Vec<usize>> = FxHashMap::default();
        let (mut placed, mut nowhere) = (Vec::new(), Vec::new());
        for (at, one) in done.iter().enumerate() {
            let touched = one.edits().flat_map(touched);
            for key in touched.filter_map(key_of).chain(one.about.iter().copied()) {
                elements.entry(key).or_default().push(at);
            }
            match one.place.filter(|place| place.iter().all(|number| number.is_finite())) {
                Some(place) => placed.push(GeomWithData::new(place, at)),
                None => nowhere.push(at),
            }
        }
        Self { tree: RTree::bulk_load(placed), elements, nowhere, count: done.len() }
    }

    /// The fixes that may have caused an error: those about what it speaks of, those within reach; else all.
    fn near(&self, error: &Diagnostic) -> Vec<usize> {
        let mut found: Vec<usize> = keys(error).filter_map(|key| self.elements.get(&key)).flatten().copied().collect();
        if found.is_empty()
            && let Some(place) = error.local
        {
            let within = self.tree.locate_within_distance([place.x, place.y], REACH * REACH);
            found.extend(within.map(|one| one.data));
        }
        if found.is_empty() {
            found.clone_from(&self.nowhere);
        }
        if found.is_empty() {
            found.extend(0..self.count);
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// What an edit changes, or makes part of something else.
fn touched(edit: &Edit) -> Vec<Subject> {
    match edit {
        Edit::SetTag { on, .. }
        | Edit::RemoveTag { on, .. }
        | Edit::RemoveRepeat { on, .. }
        | Edit::Renumber { on, .. } => {
            vec![*on]
        }
        Edit::AddMember { on, member, .. }
        | Edit::RemoveMember { on, member, .. }
        | Edit::SetRole { on, member, .. } => {
            vec![*on, *member]
        }
        Edit::MergePoints { from, to } => vec![Subject::Point(*from), Subject::Point(*to)],
        Edit::InsertVertex { way, .. }
        | Edit::RemoveVertex { way, .. }
        | Edit::SetVertices { way, .. }
        | Edit::ReverseWay { way } => vec![*way],
        Edit::ReplaceWay { lanelet, .. } => vec![Subject::Lanelet(*lanelet)],
        Edit::SetPlace { point, .. } | Edit::PlaceBetween { point, .. } => vec![Subject::Point(*point)],
        Edit::Remove { subject } => vec![*subject],
        Edit::CreateStopLine { element, .. } => vec![*element],
        Edit::CreateArea { lanelets, .. } => lanelets.iter().copied().map(Subject::Lanelet).collect(),
        Edit::CreateRegulatoryElement { referrers, .. } => referrers.iter().copied().map(Subject::Lanelet).collect(),
    }
}

/// Whether an edit makes lanelets part of something else.
fn makes_elements(edit: &Edit) -> bool {
    matches!(edit, Edit::CreateArea { .. } | Edit::CreateRegulatoryElement { .. } | Edit::ReplaceWay { .. })
}

/// Groups that have a fix in common, as one; each sorted, in the order of their first.
fn united(groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut place_of: FxHashMap<usize, usize> = FxHashMap::default();
    let mut united: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (new, group) in groups.into_iter().enumerate() {
        let known: BTreeSet<usize> = group.iter().filter_map(|at| place_of.get(at).copied()).collect();
        // The smaller ones go into the largest, so that nothing is moved often.
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
