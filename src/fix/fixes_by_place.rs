//! Finds fixes by place, and by the elements that they change or that their findings name.

use rstar::RTree;
use rstar::primitives::GeomWithData;
use rustc_hash::FxHashMap;

use super::proposal::Proposal;
use super::text_edits::{Key, key_of};
use crate::diagnostic::Diagnostic;

/// A fix may have caused an error within this distance (m), which is about the size of an intersection with its approaches.
pub const BLAME_DISTANCE: f64 = 60.0;

/// The fixes of a batch by place and by what they are about.
pub struct ByPlace {
    tree: RTree<GeomWithData<[f64; 2], usize>>,
    elements: FxHashMap<Key, Vec<usize>>,
    /// By element, the fix that created it.
    makers: FxHashMap<Key, usize>,
    /// Those without a place.
    nowhere: Vec<usize>,
    count: usize,
}

impl ByPlace {
    /// Those of a batch.
    pub fn of(done: &[Proposal]) -> Self {
        let mut elements: FxHashMap<Key, Vec<usize>> = FxHashMap::default();
        let mut makers: FxHashMap<Key, usize> = FxHashMap::default();
        let (mut placed, mut nowhere) = (Vec::new(), Vec::new());
        for (at, one) in done.iter().enumerate() {
            makers.extend(one.creates.iter().map(|&key| (key, at)));
            for key in elements_of(one) {
                elements.entry(key).or_default().push(at);
            }
            match place_of(one) {
                Some(place) => placed.push(GeomWithData::new(place, at)),
                None => nowhere.push(at),
            }
        }
        Self { tree: RTree::bulk_load(placed), elements, makers, nowhere, count: done.len() }
    }

    /// The fixes that may have caused an error: those about its elements, else those within reach, else all.
    pub fn near(&self, error: &Diagnostic) -> Vec<usize> {
        let mut found: Vec<usize> = keys(error).filter_map(|key| self.elements.get(&key)).flatten().copied().collect();
        if found.is_empty() {
            found.extend(self.around(error));
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

    /// The fixes that change or create one of these elements, or something that it is made of, or whose finding is about it.
    pub fn about_any(&self, keys: &[Key]) -> Vec<usize> {
        let mut found: Vec<usize> = keys.iter().filter_map(|key| self.elements.get(key)).flatten().copied().collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The only fix that created the subject of an error: without it there would be no such error.
    pub fn maker(&self, error: &Diagnostic) -> Option<usize> {
        let key = key_of(error.finding.subject)?;
        let maker = self.makers.get(&key).copied()?;
        self.elements.get(&key)?.iter().all(|&at| at == maker).then_some(maker)
    }

    /// Whether one of these fixes may have caused an error: it is about the same elements, or within reach. A fix or an error
    /// without a place may be anywhere.
    pub fn has_caused(&self, error: &Diagnostic) -> bool {
        !self.nowhere.is_empty()
            || keys(error).any(|key| self.elements.contains_key(&key))
            || self.around(error).next().is_some()
    }

    /// The fixes within reach of an error.
    pub fn around(&self, error: &Diagnostic) -> impl Iterator<Item = usize> + '_ {
        let place = error.local.map(|place| [place.x, place.y]);
        let within = place.map(|place| self.tree.locate_within_distance(place, BLAME_DISTANCE * BLAME_DISTANCE));
        within.into_iter().flatten().map(|one| one.data)
    }

    /// Whether a fix is within a distance (m) of one of these, or about the same elements. A fix without a place may be anywhere.
    pub fn has_near(&self, one: &Proposal, distance: f64) -> bool {
        let is_within = |place: [f64; 2]| self.tree.locate_within_distance(place, distance * distance).next().is_some();
        let is_far = || self.nowhere.is_empty() && place_of(one).is_some_and(|place| !is_within(place));
        self.count > 0 && (!is_far() || elements_of(one).any(|key| self.elements.contains_key(&key)))
    }
}

fn place_of(one: &Proposal) -> Option<[f64; 2]> {
    one.place.filter(|place| place.iter().all(|number| number.is_finite()))
}

/// The elements that a fix changes, those that contain them, those that it creates, and those that its finding is about.
pub fn elements_of(one: &Proposal) -> impl Iterator<Item = Key> + '_ {
    one.touched().chain([&one.creates, &one.reaches, &one.about].into_iter().flatten().copied())
}

/// The elements that a finding speaks of.
pub fn keys(found: &Diagnostic) -> impl Iterator<Item = Key> + '_ {
    let related = found.finding.related.iter().map(|one| one.subject);
    std::iter::once(found.finding.subject).chain(related).filter_map(key_of)
}
