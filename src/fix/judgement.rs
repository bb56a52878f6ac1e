//! Judges a map by the findings of a map that differs little from it: only the surroundings of the difference are judged again.

use std::cell::{Cell, RefCell};
use std::hash::{DefaultHasher, Hash, Hasher};

use rustc_hash::{FxHashMap, FxHashSet};

use super::finding_counts::{FindingCounts, errors};
use super::fixes_by_place::keys;
use super::nearby::{REACHES_TRIED, around, changed, connected};
use super::route::{self, Change, Route};
use super::text_edits::{Key, key_of};
use crate::diagnostic::{Diagnostic, Subject};
use crate::osm::{ElementKind, Node, OsmData};

/// Says what is wrong with a map.
pub trait Judge {
    /// Why a map cannot be judged.
    type Error;

    /// What is found in a map.
    ///
    /// # Errors
    ///
    /// Where it cannot be judged.
    fn whole(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, Self::Error>;

    /// What is found in each of some parts of maps, of which one was judged as a whole before.
    ///
    /// # Errors
    ///
    /// Where one cannot be judged.
    fn parts(&self, parts: &[&OsmData]) -> Result<Vec<Vec<Diagnostic>>, Self::Error> {
        parts.iter().map(|part| self.whole(part)).collect()
    }

    /// Where a node lies: east and north, metres; `None` where nothing is near anything.
    fn place(&self, _node: &Node) -> Option<[f64; 2]> {
        None
    }

    /// Who may go from where to where in a part of a map.
    fn routes(&self, _part: &OsmData) -> Vec<Route> {
        Vec::new()
    }

    /// Is told now and then how many fixes were made and how many are open.
    fn tell(&self, _made: usize, _open: usize) {}

    /// The place of a code in the order of findings.
    fn rank(&self, _code: &str) -> usize {
        0
    }
}

impl<E, F: Fn(&OsmData) -> Result<Vec<Diagnostic>, E>> Judge for F {
    type Error = E;

    fn whole(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, E> {
        self(osm)
    }
}

/// A map with its findings.
#[derive(Clone, Copy, Debug)]
pub struct JudgedMap<'a> {
    pub osm: &'a OsmData,
    pub left: &'a [Diagnostic],
}

/// The largest share of the map that is judged in parts, before and after a change; beyond it, judging the whole map is faster.
const MOST_TWICE: f64 = 0.35;

/// The same where it is known what was found before the change.
const MOST_ONCE: f64 = 0.7;

/// So many times as many elements as the map has are judged at most, or [`LEAST_EFFORT`]: where everything lies on everything, each fix
/// does harm.
const MOST_EFFORT: usize = 150;
/// The same for small maps.
const LEAST_EFFORT: usize = 750_000;
/// As many elements as this are judged in the time of one finding about several of them, which were held against each other.
const OF_COMPARISON: usize = 30;

/// So often may judging the surroundings of a change alone miss an error.
const MOST_MISSES: usize = REACHES_TRIED.len();

/// Judges maps one after another.
pub struct ChangeJudge<J> {
    judge: J,
    /// Whether a map was judged by its surroundings alone since the last map that was judged as a whole.
    is_guessed: Cell<bool>,
    /// Elements with an error that such a judgement missed, and how often it did: near them more is judged.
    missed: RefCell<FxHashMap<Key, usize>>,
    /// How often such judgements missed something; after [`MOST_MISSES`] every map is judged as a whole.
    misses: Cell<usize>,
    /// The part that was judged last: often the next change is at the same place.
    last: RefCell<Option<JudgedPart>>,
    /// How much was judged: elements, and what was found, which takes longer.
    effort: Cell<usize>,
    /// How much is judged at most.
    most_effort: Cell<usize>,
}

/// A part of a map with its findings.
struct JudgedPart {
    /// The elements that it was to have.
    keys: FxHashSet<Key>,
    osm: OsmData,
    found: Vec<Diagnostic>,
}

impl JudgedPart {
    /// Whether it is the part of this map around a change near these elements, and not much more.
    fn is_around(&self, near: &FxHashSet<Key>, osm: &OsmData) -> bool {
        let is_there = |&(kind, id): &Key| match kind {
            ElementKind::Node => osm.node(id).is_some(),
            ElementKind::Way => osm.way(id).is_some(),
            ElementKind::Relation => osm.relation(id).is_some(),
        };
        self.keys.len() < 2 * near.len()
            && near.iter().all(|key| self.keys.contains(key) || !is_there(key))
            && changed(&self.osm, &osm.part(&self.keys)).is_empty()
    }
}

/// The result of judging a map as a whole.
pub enum Confirmed {
    /// The findings are as expected.
    AsIs,
    /// There are other findings, but no unexpected error.
    Otherwise(Vec<Diagnostic>),
    /// There are unexpected errors. From now on more is judged near them.
    Worse,
}

impl<J: Judge> ChangeJudge<J> {
    pub fn new(judge: J) -> Self {
        Self {
            judge,
            is_guessed: Cell::new(false),
            missed: RefCell::default(),
            misses: Cell::new(0),
            last: RefCell::default(),
            effort: Cell::new(0),
            most_effort: Cell::new(usize::MAX),
        }
    }

    /// Tells how many fixes were made and how many are open.
    pub fn tell(&self, made: usize, open: usize) {
        self.judge.tell(made, open);
    }

    /// What is found in a map.
    ///
    /// # Errors
    ///
    /// Where it cannot be judged.
    pub fn whole(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, J::Error> {
        let found = self.judge.whole(osm)?;
        self.count(osm, &found);
        Ok(found)
    }

    /// Sets how much is judged at most, by the size of a map that was judged.
    pub fn limit(&self, osm: &OsmData, found: &[Diagnostic]) {
        self.effort.set(0);
        self.count(osm, found);
        self.most_effort.set((MOST_EFFORT * size(osm)).max(LEAST_EFFORT));
    }

    /// Whether as much was judged as may be.
    pub fn is_spent(&self) -> bool {
        self.effort.get() > self.most_effort.get()
    }

    fn count(&self, osm: &OsmData, found: &[Diagnostic]) {
        let compared = found.iter().filter(|one| !one.finding.related.is_empty()).count();
        self.effort.set(self.effort.get() + size(osm) + found.len() + OF_COMPARISON * compared);
    }

    /// The findings in a map, given those of the map from which it differs least.
    ///
    /// # Errors
    ///
    /// Where it cannot be judged.
    pub fn judged<'a>(
        &self,
        known: impl IntoIterator<Item = JudgedMap<'a>>,
        osm: &OsmData,
    ) -> Result<Vec<Diagnostic>, J::Error> {
        if self.misses.get() > MOST_MISSES {
            return self.whole(osm);
        }
        let differences = known.into_iter().map(|known| (known, changed(known.osm, osm)));
        let least = differences.min_by_key(|(_, changed)| changed.len());
        if let Some((known, changed)) = least {
            for (number, reach) in REACHES_TRIED.into_iter().enumerate() {
                let near = around([known.osm, osm], &changed, reach, |node| self.judge.place(node));
                let is_last = number + 1 == REACHES_TRIED.len();
                let near = near.filter(|near| self.missed_near(near) <= usize::from(is_last));
                let judged = near.map(|near| self.judged_in_part(known, osm, (&changed, reach.is_close), near));
                if let Some(found) = judged.transpose()?.flatten() {
                    return Ok(found);
                }
            }
        }
        self.whole(osm)
    }

    /// How often an error was missed that is about one of some elements.
    fn missed_near(&self, near: &FxHashSet<Key>) -> usize {
        let missed = self.missed.borrow();
        missed.iter().filter(|(key, _)| near.contains(key)).map(|(_, times)| *times).max().unwrap_or_default()
    }

    /// The routes that a map has and another has not. `fresh` are the new ids of elements of the old one.
    pub fn changed_routes(&self, old: &OsmData, new: &OsmData, fresh: &FxHashMap<Key, i64>) -> Vec<Change> {
        let near = connected([old, new], &changed(old, new));
        let [before, after] = [old, new].map(|osm| self.judge.routes(&osm.part(&near)));
        route::changes(before, after, fresh)
    }

    /// The findings in a map that differs from a known one near some elements alone; `None` where these are most of the map, or do not show
    /// what is known of those that change.
    fn judged_in_part(
        &self,
        known: JudgedMap,
        osm: &OsmData,
        (changed, is_close): (&FxHashSet<Key>, bool),
        mut near: FxHashSet<Key>,
    ) -> Result<Option<Vec<Diagnostic>>, J::Error> {
        let before = self.last.take().filter(|last| last.is_around(&near, known.osm));
        let before = before.map(|last| {
            near.extend(last.keys);
            last.found
        });
        let most = if before.is_some() { MOST_ONCE } else { MOST_TWICE };
        if near.len() as f64 >= most * size(osm) as f64 {
            return Ok(None);
        }
        self.is_guessed.set(true);
        let part = osm.part(&near);
        let (before, after) = match before {
            Some(before) => (before, self.judge.parts(&[&part])?.pop().unwrap_or_default()),
            None => {
                let part_before = known.osm.part(&near);
                let mut both = self.judge.parts(&[&part_before, &part])?;
                let after = both.pop().unwrap_or_default();
                let before = both.pop().unwrap_or_default();
                self.count(&part_before, &before);
                (before, after)
            }
        };
        self.count(&part, &after);
        let shows_known = !is_close || shows_what_is_known(known.left, &before, changed);
        if !shows_known || shows_more_than_is_known(known.left, &before, changed) {
            return Ok(None);
        }
        self.last.replace(Some(JudgedPart { keys: near, osm: part, found: after.clone() }));
        Ok(Some(changed_by(known.left, before, after, |code| self.judge.rank(code))))
    }

    /// Judges a map as a whole, and compares the result with the expected findings.
    ///
    /// # Errors
    ///
    /// Where it cannot be judged.
    pub fn confirm(&self, osm: &OsmData, left: &[Diagnostic]) -> Result<Confirmed, J::Error> {
        if !self.is_guessed.replace(false) {
            return Ok(Confirmed::AsIs);
        }
        let found = self.whole(osm)?;
        let unexpected = FindingCounts::of(errors(left)).exceeded_by(errors(&found));
        if unexpected.is_empty() {
            return Ok(Confirmed::Otherwise(found));
        }
        self.misses.set(self.misses.get() + 1);
        let about: FxHashSet<Key> = unexpected.into_iter().flat_map(keys).collect();
        let mut missed = self.missed.borrow_mut();
        about.into_iter().for_each(|key| *missed.entry(key).or_default() += 1);
        Ok(Confirmed::Worse)
    }
}

fn size(osm: &OsmData) -> usize {
    osm.nodes.len() + osm.ways.len() + osm.relations.len()
}

/// Whether a part of a map shows what is known of the elements that change and may be mended: else that depends on what lies outside, as
/// a turn signal does on the lanes before it.
fn shows_what_is_known(known: &[Diagnostic], found: &[Diagnostic], changed: &FxHashSet<Key>) -> bool {
    let found: FxHashSet<u64> = found.iter().map(hashed).collect();
    let is_mendable = |one: &&Diagnostic| {
        one.finding.fix.is_some() && key_of(one.finding.subject).is_some_and(|key| changed.contains(&key))
    };
    known.iter().filter(is_mendable).all(|one| found.contains(&hashed(one)))
}

/// Whether a part of a map shows errors of the elements that change which the whole map does not have: there they would not be new.
fn shows_more_than_is_known(known: &[Diagnostic], found: &[Diagnostic], changed: &FxHashSet<Key>) -> bool {
    let about = errors(found).filter(|one| keys(one).any(|key| changed.contains(&key)));
    about.into_iter().any(|one| !known.iter().any(|other| hashed(other) == hashed(one) && may_be_same(other, one)))
}

/// The findings after a part of the map has changed: those of the part that are new are added, those that are gone are removed.
fn changed_by(
    left: &[Diagnostic],
    before: Vec<Diagnostic>,
    after: Vec<Diagnostic>,
    rank: impl Fn(&str) -> usize,
) -> Vec<Diagnostic> {
    let mut gone: FxHashMap<u64, Vec<Diagnostic>> = FxHashMap::default();
    for one in before {
        gone.entry(hashed(&one)).or_default().push(one);
    }
    let mut come: Vec<Diagnostic> = Vec::new();
    for one in after {
        let twin = gone.get_mut(&hashed(&one)).and_then(|list| {
            let at = list.iter().position(|known| is_same(known, &one))?;
            Some(list.swap_remove(at))
        });
        if twin.is_none() {
            come.push(one);
        }
    }
    let mut take = |one: &Diagnostic, is_twin: fn(&Diagnostic, &Diagnostic) -> bool| {
        let list = gone.get_mut(&hashed(one))?;
        let at = list.iter().position(|known| is_twin(known, one))?;
        Some(list.swap_remove(at))
    };
    let stays: Vec<&Diagnostic> = left.iter().filter(|one| take(one, is_same).is_none()).collect();
    // Some findings depend on the whole map, so that a part gives a wrong result for them.
    let stays = stays.into_iter().filter(|one| take(one, may_be_same).is_none());
    let mut all: Vec<Diagnostic> = stays.cloned().collect();
    all.extend(come);
    all.sort_by_cached_key(|one| (rank(&one.code), one.finding.subject, one.finding.message.clone()));
    all
}

/// By code and subject.
fn hashed(one: &Diagnostic) -> u64 {
    let key: (&str, Subject) = (&one.code, one.finding.subject);
    let mut hasher = DefaultHasher::new();
    key.hash(&mut hasher);
    hasher.finish()
}

/// Whether two findings of one code and subject may be the same one though they say something else: one about a pair is about that pair.
fn may_be_same(a: &Diagnostic, b: &Diagnostic) -> bool {
    let [x, y] = [a, b].map(|one| one.finding.related.iter().map(|other| other.subject));
    x.len() != 1 || y.len() != 1 || x.eq(y)
}

/// Whether two findings say the same, wherever they are in the file.
fn is_same(a: &Diagnostic, b: &Diagnostic) -> bool {
    let (x, y) = (&a.finding, &b.finding);
    a.code == b.code
        && a.severity == b.severity
        && x.subject == y.subject
        && x.related == y.related
        && x.message == y.message
        && x.fix == y.fix
}
