//! Which fixes of a batch did harm: those near an error that was not there before, and those that did not mend what they were for.

use rstar::RTree;
use rstar::primitives::GeomWithData;
use rustc_hash::FxHashMap;

use super::text_edits::{Key, key_of};
use super::{Attempt, Proposal};
use crate::diagnostic::{Diagnostic, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::index::union_find::UnionFind;

/// An error within this distance (m) of a fix may be its doing: an intersection with its approaches is about as large.
const REACH: f64 = 60.0;

/// What is to happen to the fixes of a batch, by their positions; nothing, where the batch does no harm.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// They do harm, or mend nothing, and nothing else can be the cause.
    pub refused: Vec<usize>,
    /// Some of these do, together with others: they are tried again without those.
    pub put_off: Vec<usize>,
}

/// Judges a batch by what was found before and after it.
pub fn verdict(before: &[Diagnostic], attempt: &Attempt) -> Verdict {
    let Attempt { left: after, done, .. } = attempt;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let fixes = ByPlace::of(done);
    for error in new_errors(before, attempt) {
        groups.push(fixes.near(error));
    }
    groups.extend(without_effect(before, after, done).into_iter().map(|at| vec![at]));
    let mut verdict = Verdict::default();
    for group in united(groups, done.len()) {
        match group[..] {
            [only] => verdict.refused.push(only),
            _ => verdict.put_off.extend(&group[group.len().div_ceil(2)..]),
        }
    }
    verdict
}

/// The errors of elements that have more of them than before, be it under another id.
fn new_errors<'a>(before: &'a [Diagnostic], attempt: &'a Attempt) -> Vec<&'a Diagnostic> {
    let mut known: FxHashMap<(&str, Option<Key>), usize> = FxHashMap::default();
    for one in before.iter().filter(|one| one.severity == Severity::Error) {
        let key = key_of(one.finding.subject).map(|(kind, id)| {
            let id = attempt.renumbered.get(&(kind, id)).copied().unwrap_or(id);
            (kind, id)
        });
        *known.entry((&one.code, key)).or_default() += 1;
    }
    let errors = attempt.left.iter().filter(|one| one.severity == Severity::Error);
    let is_new = |one: &&'a Diagnostic| match known.get_mut(&(one.code.as_str(), key_of(one.finding.subject))) {
        Some(count) if *count > 0 => {
            *count -= 1;
            false
        }
        _ => true,
    };
    errors.filter(is_new).collect()
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
    let stays = |at: &usize| {
        let mend = &done[*at].mend;
        let key = (mend.code.as_str(), mend.subject, mend.title.as_str());
        after.get(&key).is_some_and(|count| before.get(&key).is_some_and(|known| count >= known))
    };
    (0..done.len()).filter(stays).collect()
}

/// The fixes of a batch by place and by what they are about.
struct ByPlace {
    tree: RTree<GeomWithData<[f64; 2], usize>>,
    subjects: FxHashMap<Subject, Vec<usize>>,
    /// Those without a place.
    nowhere: Vec<usize>,
    count: usize,
}

impl ByPlace {
    fn of(done: &[Proposal]) -> Self {
        let mut subjects: FxHashMap<Subject, Vec<usize>> = FxHashMap::default();
        let (mut placed, mut nowhere) = (Vec::new(), Vec::new());
        for (at, one) in done.iter().enumerate() {
            subjects.entry(one.mend.subject).or_default().push(at);
            match one.place.filter(|place| place.x.is_finite() && place.y.is_finite()) {
                Some(place) => placed.push(GeomWithData::new([place.x, place.y], at)),
                None => nowhere.push(at),
            }
        }
        Self { tree: RTree::bulk_load(placed), subjects, nowhere, count: done.len() }
    }

    /// The fixes that may have caused an error: those about what it speaks of, those within reach; else all.
    fn near(&self, error: &Diagnostic) -> Vec<usize> {
        let spoken_of =
            std::iter::once(error.finding.subject).chain(error.finding.related.iter().map(|one| one.subject));
        let mut found: Vec<usize> =
            spoken_of.filter_map(|subject| self.subjects.get(&subject)).flatten().copied().collect();
        if found.is_empty()
            && let Some(Point { coords, .. }) = error.local
        {
            let within = self.tree.locate_within_distance([coords.x, coords.y], REACH * REACH);
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

/// Groups that have a fix in common, as one; each sorted, in the order of their first.
fn united(groups: Vec<Vec<usize>>, count: usize) -> Vec<Vec<usize>> {
    let mut sets = UnionFind::new(count);
    let mut blamed = vec![false; count];
    for group in &groups {
        for &at in group {
            blamed[at] = true;
            sets.join(group[0], at);
        }
    }
    let mut by_root: FxHashMap<usize, usize> = FxHashMap::default();
    let mut united: Vec<Vec<usize>> = Vec::new();
    for at in (0..count).filter(|&at| blamed[at]) {
        let place = *by_root.entry(sets.root(at)).or_insert_with(|| {
            united.push(Vec::new());
            united.len() - 1
        });
        united[place].push(at);
    }
    united
}
