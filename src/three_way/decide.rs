//! What becomes of each element.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::conflict::{Conflict, Side};
use super::content::Content;
use super::fields::{self, Clash};
use super::versions::{Deletions, Key, Taken};
use super::view::{View, plain};
use crate::diagnostic::Subject;
use crate::osm::ElementKind;
use crate::projection::LonLat;

/// What an element of the result is, where it is not that of ours.
#[derive(Clone, Debug)]
pub(super) enum Decision {
    /// Not there.
    Removed,
    /// That of theirs.
    Theirs,
    /// Both together.
    Combined(Box<Content>),
}

/// What becomes of the elements, and what contradicts.
#[derive(Debug, Default)]
pub(super) struct Decisions {
    /// Elements that are not in the result as ours has them.
    pub(super) made: FxHashMap<Key, Decision>,
    clashes: BTreeMap<Key, Vec<(Clash, Side)>>,
    /// Elements that one side has deleted and the other changed, with the side that has them. Those that are kept.
    pub(super) torn: BTreeMap<Key, Side>,
    /// What is put back brings what it refers to, without another word.
    pub(super) brought: FxHashSet<Key>,
    /// Regulatory elements of which one side took some members and the other the rest: with none left, Autoware would reject the map.
    pub(super) hollow: FxHashSet<Key>,
    /// Elements that ours has deleted and theirs changed, of which the deletion stands.
    pub(super) gone: FxHashSet<Key>,
}

impl Decisions {
    pub(super) fn of(sides: [&View<'_>; 3], deletions: Deletions) -> Self {
        let [base, _, theirs] = sides;
        let mut decisions = Self::default();
        // Most elements are as they were, letter for letter; the others are few.
        let (all, before): (Vec<Key>, Vec<Key>) = (theirs.keys().collect(), base.keys().collect());
        let changed: Vec<Key> = all.into_par_iter().filter(|key| theirs.text(*key) != base.text(*key)).collect();
        let deleted: Vec<Key> = before.into_par_iter().filter(|key| !theirs.has(*key)).collect();
        changed.into_iter().for_each(|key| decisions.of_element(key, sides, deletions));
        deleted.into_iter().for_each(|key| decisions.of_deleted(key, sides));
        decisions
    }

    /// An element that theirs has.
    fn of_element(&mut self, key: Key, sides: [&View<'_>; 3], deletions: Deletions) {
        let [base, ours, theirs] = sides;
        let text = theirs.text(key);
        let was = base.text(key);
        if text == was {
            return;
        }
        let Some(own) = ours.text(key) else {
            match was {
                None => {
                    self.made.insert(key, Decision::Theirs);
                }
                // Ours has deleted it.
                Some(_) if base.content(key) == theirs.content(key) => {}
                Some(_) if deletions == Deletions::OfOursStand => {
                    self.gone.insert(key);
                }
                Some(_) => {
                    self.made.insert(key, Decision::Theirs);
                    self.torn.insert(key, Side::Theirs);
                }
            }
            return;
        };
        if Some(&own) == text.as_ref() {
            return;
        }
        if Some(&own) == was.as_ref() {
            self.made.insert(key, Decision::Theirs);
            return;
        }
        let [before, own, other] = sides.map(|side| side.content(key).unwrap_or_default());
        // What is only written otherwise was not changed.
        if other == before || own == other {
            return;
        }
        if own == before && was.is_some() {
            self.made.insert(key, Decision::Theirs);
            return;
        }
        let along = |from: Option<i64>, both: [&[i64]; 2], to: Option<i64>| along(sides, from, both, to);
        let (content, clashes) = fields::merged([&before, &own, &other], along);
        let is_rule = own.tags.get("type").is_some_and(|kind| kind == "regulatory_element");
        if is_rule
            && clashes.is_empty()
            && content.members.is_empty()
            && !own.members.is_empty()
            && !other.members.is_empty()
        {
            self.made.insert(key, Decision::Removed);
            self.hollow.insert(key);
            return;
        }
        if content != own {
            self.made.insert(key, Decision::Combined(Box::new(content)));
        }
        if !clashes.is_empty() {
            self.clashes.insert(key, clashes.into_iter().map(|clash| (clash, Side::Ours)).collect());
        }
    }

    /// An element that theirs has deleted.
    fn of_deleted(&mut self, key: Key, [base, ours, _]: [&View<'_>; 3]) {
        let Some(own) = ours.text(key) else { return };
        if Some(own) == base.text(key) || base.content(key) == ours.content(key) {
            self.made.insert(key, Decision::Removed);
        } else {
            self.torn.insert(key, Side::Ours);
        }
    }

    /// Whether an element is in the result.
    pub(super) fn has(&self, key: Key, ours: &View<'_>) -> bool {
        match self.made.get(&key) {
            Some(Decision::Removed) => false,
            Some(_) => true,
            None => ours.has(key),
        }
    }

    /// What an element of the result refers to.
    pub(super) fn references(&self, key: Key, [_, ours, theirs]: [&View<'_>; 3]) -> Vec<Key> {
        match self.made.get(&key) {
            Some(Decision::Removed) => Vec::new(),
            Some(Decision::Theirs) => theirs.references(key),
            Some(Decision::Combined(content)) => content.references().collect(),
            None => ours.references(key),
        }
    }

    /// Puts an element back that one side has deleted.
    pub(super) fn restore(&mut self, key: Key, from: Side) {
        match from {
            Side::Ours => self.made.remove(&key),
            Side::Theirs => self.made.insert(key, Decision::Theirs),
        };
    }

    /// Leaves a reference out that an element can do without: of a regulatory element, or of a lanelet to one. Whether it could.
    pub(super) fn leave_out(&mut self, user: Key, key: Key, [_, ours, theirs]: [&View<'_>; 3]) -> bool {
        let content = match self.made.get(&user) {
            Some(Decision::Removed) => return false,
            Some(Decision::Combined(content)) => Some(content.as_ref().clone()),
            Some(Decision::Theirs) => theirs.content(user),
            None => ours.content(user),
        };
        let Some(mut content) = content else { return false };
        let is = |kind: &str| content.tags.get("type").is_some_and(|one| one == kind);
        let is_spare = is("regulatory_element")
            || (is("lanelet") && matches!(theirs.subject(key), Some(Subject::RegulatoryElement(_))));
        let before = content.members.len();
        content.members.retain(|member| (member.kind, member.id) != key);
        if !is_spare || content.members.len() == before {
            return false;
        }
        self.made.insert(user, Decision::Combined(Box::new(content)));
        true
    }

    /// Notes what contradicts.
    pub(super) fn clash(&mut self, key: Key, clash: Clash, taken: Side) {
        self.clashes.entry(key).or_default().push((clash, taken));
    }

    /// Whether a conflict is about the members of an element.
    pub(super) fn tells_of_members(&self, of: Key) -> bool {
        let is_other = |about: &str| about.starts_with("tag ") || about == "deletion";
        of.0 == ElementKind::Relation
            && self.clashes.get(&of).is_some_and(|all| all.iter().any(|(clash, _)| !is_other(&clash.about)))
    }

    /// The conflicts, in the order of kinds and ids, and how much was taken from theirs.
    pub(super) fn summed_up(&self, [base, ours, theirs]: [&View<'_>; 3]) -> (Vec<Conflict>, Taken) {
        let conflict = |key: Key, (Clash { about, said: [was, own, other] }, taken): &(Clash, Side)| {
            let sides = match taken {
                Side::Ours => [ours, theirs, base],
                Side::Theirs => [theirs, ours, base],
            };
            Conflict {
                subject: sides.iter().find_map(|side| side.subject(key)).unwrap_or_else(|| plain(key)),
                about: about.clone(),
                base: was.clone(),
                ours: own.clone(),
                theirs: other.clone(),
                taken: *taken,
                at: sides.iter().find_map(|side| side.place(key)),
            }
        };
        let conflicts = self.clashes.iter().flat_map(|(key, all)| all.iter().map(|one| conflict(*key, one))).collect();
        let mut taken = Taken::default();
        for (key, decision) in &self.made {
            match decision {
                Decision::Removed => taken.removed += 1,
                _ if !ours.has(*key) => taken.added += 1,
                Decision::Theirs => taken.changed += 1,
                Decision::Combined(_) => taken.combined += 1,
            }
        }
        (conflicts, taken)
    }
}

/// The order of vertices that both sides insert between two others: that in which they lie on the way from one to the other. `None`
/// where that does not tell, as beyond the end of a line.
fn along(sides: [&View<'_>; 3], from: Option<i64>, [own, other]: [&[i64]; 2], to: Option<i64>) -> Option<Vec<i64>> {
    let place = |id: i64| {
        let key = (ElementKind::Node, id);
        // Where it was before either side moved it, so that the sides are alike.
        let place = sides.iter().find_map(|side| side.content(key))?.position;
        let local = || Some([place.local[0].as_ref()?.parse().ok()?, place.local[1].as_ref()?.parse().ok()?]);
        let globe = place.lonlat.filter(|place| *place != LonLat::default());
        globe.map(|at| [at.lon * at.lat.to_radians().cos(), at.lat]).or_else(local)
    };
    let ([ax, ay], [bx, by]): ([f64; 2], [f64; 2]) = (place(from?)?, place(to?)?);
    let (dx, dy) = (bx - ax, by - ay);
    let share = |id: i64| place(id).map(|[x, y]| ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy));
    let shares = |ids: &[i64]| ids.iter().map(|id| Some((share(*id)?, *id))).collect::<Option<Vec<_>>>();
    let (own, other) = (shares(own)?, shares(other)?);
    let is_between = |list: &[(f64, i64)]| {
        list.iter().all(|(share, _)| *share > 0.0 && *share < 1.0) && list.windows(2).all(|two| two[0].0 < two[1].0)
    };
    if !is_between(&own) || !is_between(&other) {
        return None;
    }
    let mut both = [own, other].concat();
    both.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    both.dedup_by_key(|(_, id)| *id);
    // Two at one place are the same vertex, drawn twice.
    let apart = both.windows(2).all(|two| two[1].0 > two[0].0);
    apart.then(|| both.into_iter().map(|(_, id)| id).collect())
}
