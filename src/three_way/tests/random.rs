//! Merges of random edits of random maps.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use rustc_hash::FxHashMap;

use super::{merged, read};
use crate::lanelet::{from_osm, projector_for};
use crate::osm::{ElementKind, Member, OsmText};
use crate::projection::LonLat;
use crate::three_way::content::{Content, Position};
use crate::three_way::view::View;
use crate::three_way::{Key, Merged};

/// A map as a value: what is random is built of it.
#[derive(Clone, Default, PartialEq)]
struct Model(BTreeMap<Key, Content>);

impl std::fmt::Debug for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text())
    }
}

impl Model {
    /// Lanelets in a row that share bounds, and an element that refers to some.
    fn of(lanelets: i64, points: i64) -> Self {
        let mut map = BTreeMap::new();
        for line in 0..=lanelets {
            let nodes: Vec<i64> = (0..points).map(|at| 1 + line * points + at).collect();
            for (at, id) in nodes.iter().enumerate() {
                let position = Position {
                    lonlat: Some(LonLat { lon: 11.5 + at as f64 * 1e-4, lat: 48.1 + line as f64 * 1e-4 }),
                    ..Default::default()
                };
                map.insert(
                    (ElementKind::Node, *id),
                    Content { position, tags: tags(&[("ele", "1")]), ..Content::default() },
                );
            }
            let tags = tags(&[("type", "line_thin")]);
            map.insert((ElementKind::Way, 1000 + line), Content { nodes, tags, ..Content::default() });
        }
        for lanelet in 0..lanelets {
            let members = vec![
                member(ElementKind::Way, 1000 + lanelet, "left"),
                member(ElementKind::Way, 1001 + lanelet, "right"),
            ];
            let tags = tags(&[("type", "lanelet"), ("speed_limit", "30")]);
            map.insert((ElementKind::Relation, 2000 + lanelet), Content { members, tags, ..Content::default() });
        }
        let members = (0..lanelets).map(|at| member(ElementKind::Relation, 2000 + at, "yield")).collect();
        let tags = tags(&[("type", "regulatory_element"), ("subtype", "right_of_way")]);
        map.insert((ElementKind::Relation, 3000), Content { members, tags, ..Content::default() });
        Self(map)
    }

    fn text(&self) -> String {
        let mut text = OsmText::default();
        for ((kind, id), content) in &self.0 {
            let tags = content.tags.iter().map(|(key, value)| (key.as_str(), value.as_str()));
            match kind {
                ElementKind::Node => text.node(*id, content.position.lonlat, tags),
                ElementKind::Way => text.way(*id, content.nodes.iter().copied(), tags),
                ElementKind::Relation => {
                    let members = content.members.iter().map(|one| (one.kind, one.id, one.role.as_str()));
                    text.relation(*id, members, tags);
                }
            }
        }
        format!("<osm version=\"0.6\">\n{}</osm>\n", String::from_utf8_lossy(text.as_bytes()))
    }

    fn read(text: &str) -> Self {
        let osm = read(text);
        assert_eq!(osm.oddities, [], "{text}");
        let view = View::new(&osm);
        Self(view.keys().map(|key| (key, view.content(key).unwrap())).collect())
    }

    fn dangling(&self) -> Vec<(Key, Key)> {
        let all = self.0.iter().flat_map(|(from, content)| content.references().map(|to| (*from, to)));
        all.filter(|(_, to)| !self.0.contains_key(to)).collect()
    }

    fn nth(&self, kind: ElementKind, which: usize) -> Option<Key> {
        let keys: Vec<Key> = self.0.keys().filter(|key| key.0 == kind).copied().collect();
        keys.get(which % keys.len().max(1)).copied()
    }

    /// Makes an edit, where the map has what it is about; which elements it has touched.
    fn edit(&mut self, edit: &Edit, own: i64) -> BTreeSet<Key> {
        self.try_edit(edit, own).unwrap_or_default()
    }

    fn try_edit(&mut self, edit: &Edit, own: i64) -> Option<BTreeSet<Key>> {
        let mut touched = BTreeSet::new();
        match *edit {
            Edit::Move { which, by } => {
                let key = self.nth(ElementKind::Node, which)?;
                self.0.get_mut(&key)?.position.lonlat.as_mut()?.lat += f64::from(by) * 1e-6;
                touched.insert(key);
            }
            Edit::Tag { which, ref key, value } => {
                let on = self.nth(ElementKind::Relation, which)?;
                self.0.get_mut(&on)?.tags.insert(key.clone(), value.to_string());
                touched.insert(on);
            }
            Edit::Insert { which, at, id } => {
                let way = self.nth(ElementKind::Way, which)?;
                let nodes = self.0.get(&way)?.nodes.clone();
                let at = 1 + at % (nodes.len() - 1);
                let place = |id: i64| self.0.get(&(ElementKind::Node, id))?.position.lonlat;
                let (a, b) = (place(nodes[at - 1])?, place(nodes[at])?);
                let share = 0.25 + 0.5 * (own as f64 / 8.0);
                let lonlat = LonLat { lon: a.lon + (b.lon - a.lon) * share, lat: a.lat + (b.lat - a.lat) * share };
                let key = (ElementKind::Node, id + own * 100_000);
                if self.0.contains_key(&key) {
                    return None;
                }
                let position = Position { lonlat: Some(lonlat), ..Default::default() };
                self.0.insert(key, Content { position, tags: tags(&[("ele", "1")]), ..Content::default() });
                self.0.get_mut(&way)?.nodes.insert(at, key.1);
                touched.extend([key, way]);
            }
            Edit::Delete { which } => {
                let lanelets = |key: &&Key| {
                    self.0.get(key).is_some_and(|one| one.tags.get("type").is_some_and(|kind| kind == "lanelet"))
                };
                let all: Vec<Key> = self.0.keys().filter(lanelets).copied().collect();
                let key = *all.get(which % all.len().max(1))?;
                touched.extend(self.delete(key));
            }
            Edit::Role { which, ref role } => {
                let element = self.0.get_mut(&(ElementKind::Relation, 3000))?;
                let count = element.members.len().max(1);
                let one = element.members.get_mut(which % count)?;
                one.role = role.as_str().into();
                touched.insert((ElementKind::Relation, 3000));
            }
        }
        Some(touched)
    }

    /// Deletes an element, all references to it, and what nothing refers to any more.
    fn delete(&mut self, key: Key) -> BTreeSet<Key> {
        let mut touched = BTreeSet::from([key]);
        let Some(gone) = self.0.remove(&key) else { return touched };
        for (other, content) in &mut self.0 {
            let before = content.members.len();
            content.members.retain(|one| (one.kind, one.id) != key);
            touched.extend((content.members.len() < before).then_some(*other));
        }
        for part in gone.references().collect::<BTreeSet<_>>() {
            if !self.0.values().any(|content| content.references().any(|to| to == part)) {
                touched.extend(self.delete(part));
            }
        }
        touched
    }
}

fn tags(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    pairs.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
}

fn member(kind: ElementKind, id: i64, role: &str) -> Member {
    Member { kind, id, role: role.into() }
}

#[derive(Clone, Debug)]
enum Edit {
    Move { which: usize, by: i8 },
    Tag { which: usize, key: String, value: u8 },
    Insert { which: usize, at: usize, id: i64 },
    Delete { which: usize },
    Role { which: usize, role: String },
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let edit = prop_oneof![
        (any::<usize>(), 1..100i8).prop_map(|(which, by)| Edit::Move { which, by }),
        (any::<usize>(), "[abc]", any::<u8>()).prop_map(|(which, key, value)| Edit::Tag { which, key, value }),
        (any::<usize>(), any::<usize>(), 5000..5100i64).prop_map(|(which, at, id)| Edit::Insert { which, at, id }),
        any::<usize>().prop_map(|which| Edit::Delete { which }),
        (any::<usize>(), "right_of_way|yield|refers").prop_map(|(which, role)| Edit::Role { which, role }),
    ];
    proptest::collection::vec(edit, 0..6)
}

/// A map, and two versions of it with what each has touched. Ids of new elements are the same on both sides, or not.
fn versions() -> impl Strategy<Value = (Model, [(Model, BTreeSet<Key>); 2])> {
    (1..6i64, 2..6i64, edits(), edits(), any::<bool>()).prop_map(|(lanelets, points, ours, theirs, same_ids)| {
        let base = Model::of(lanelets, points);
        let edited = |edits: &[Edit], own: i64| {
            let mut map = base.clone();
            let touched = edits.iter().flat_map(|edit| map.edit(edit, own)).collect();
            (map, touched)
        };
        let sides = [edited(&ours, 0), edited(&theirs, i64::from(!same_ids))];
        (base, sides)
    })
}

/// The members in no order: that of roles means nothing.
fn unordered(model: &Model) -> Model {
    let mut model = model.clone();
    for content in model.0.values_mut() {
        content.members.sort_by_key(|one| (one.kind, one.id, one.role.to_string()));
    }
    model
}

proptest! {
    #[test]
    fn merging_with_oneself_or_with_the_base_changes_nothing((base, [(ours, _), _]) in versions()) {
        let [base, ours] = [base, ours].map(|map| map.text());
        for (first, second) in [(&ours, &ours), (&ours, &base), (&base, &ours)] {
            let merged = merged(&base, first, second);
            prop_assert_eq!(&merged.text, &ours);
            prop_assert!(merged.conflicts.is_empty() && merged.renumbered.is_empty());
        }
    }

    #[test]
    fn the_order_of_the_sides_decides_of_conflicts_alone((base, [(ours, _), (theirs, _)]) in versions()) {
        let [base, ours, theirs] = [base, ours, theirs].map(|map| map.text());
        let (one, other) = (merged(&base, &ours, &theirs), merged(&base, &theirs, &ours));
        prop_assert_eq!(one.renumbered.len(), other.renumbered.len());
        // New ids go to one side or the other.
        if one.renumbered.is_empty() {
            let of = |merged: &Merged| merged.conflicts.iter().map(|one| (one.subject, one.about.clone())).collect::<Vec<_>>();
            prop_assert_eq!(of(&one), of(&other));
            if one.conflicts.is_empty() {
                prop_assert_eq!(unordered(&Model::read(&one.text)), unordered(&Model::read(&other.text)));
            }
        }
    }

    #[test]
    fn edits_of_different_elements_are_all_made((base, [(ours, own), _]) in versions(), edits in edits()) {
        let mut theirs = base.clone();
        for edit in &edits {
            let mut edited = theirs.clone();
            if edited.edit(edit, 1).is_disjoint(&own) {
                theirs = edited;
            }
        }
        // Neither deletes what the other's edits need.
        let one_of_both = |key: &Key| {
            let from = if own.contains(key) { &ours } else { &theirs };
            Some((*key, from.0.get(key)?.clone()))
        };
        let both = Model(ours.0.keys().chain(theirs.0.keys()).filter_map(one_of_both).collect());
        prop_assume!(both.dangling().is_empty());
        let merged = merged(&base.text(), &ours.text(), &theirs.text());
        prop_assert!(merged.conflicts.is_empty(), "{:?}", merged.conflicts);
        prop_assert_eq!(Model::read(&merged.text), both);
    }

    #[test]
    fn what_loads_on_both_sides_loads_when_it_is_merged((base, [(ours, _), (theirs, _)]) in versions()) {
        let loads = |text: &str| {
            let osm = read(text);
            let faults = from_osm(&osm, &projector_for(&osm)).faults.into_iter();
            // Lanelet2 loads a lanelet that is twisted, as one may be where each side has moved a node of its own.
            let faults = faults.filter(|fault| !fault.condition.is_unsaid());
            faults.map(|fault| format!("{} {:?}", fault.subject, fault.condition)).collect::<BTreeSet<String>>()
        };
        // What is said of the whole map, such as that it has no version, is said of all.
        let known = loads(&base.text());
        if [&ours, &theirs].into_iter().any(|side| !loads(&side.text()).is_subset(&known)) {
            return Ok(());
        }
        let merged = merged(&base.text(), &ours.text(), &theirs.text());
        let new: Vec<String> = loads(&merged.text).difference(&known).cloned().collect();
        prop_assert_eq!(new, Vec::<String>::new());
    }

    #[test]
    fn nothing_is_lost_and_no_reference_leads_nowhere((base, [(ours, _), (theirs, _)]) in versions()) {
        let merged = merged(&base.text(), &ours.text(), &theirs.text());
        let result = Model::read(&merged.text);
        prop_assert_eq!(result.dangling(), []);
        let new_ids: &FxHashMap<Key, i64> = &merged.new_ids;
        let told: BTreeSet<i64> = merged.conflicts.iter().filter_map(|one| one.subject.id()).collect();
        let changed = |side: &Model| -> Vec<(Key, Content)> {
            let is_changed = |(key, content): &(&Key, &Content)| base.0.get(*key) != Some(*content);
            side.0.iter().filter(is_changed).map(|(key, content)| (*key, content.clone())).collect()
        };
        // What ours has made or changed is there: its position, its tags, its vertices.
        for (key, content) in changed(&ours) {
            let made = result.0.get(&key);
            // But for the element of which each took some members.
            if key == (ElementKind::Relation, 3000) && made.is_none() {
                continue;
            }
            prop_assert!(made.is_some(), "{key:?} of ours is lost");
            if base.0.get(&key).is_none_or(|before| before.position != content.position) {
                prop_assert_eq!(&made.unwrap().position, &content.position);
            }
        }
        // So is what theirs has made or changed, unless a conflict says so.
        for ((kind, id), content) in changed(&theirs) {
            let key = (kind, new_ids.get(&(kind, id)).copied().unwrap_or(id));
            let made = result.0.get(&key);
            if key == (ElementKind::Relation, 3000) && made.is_none() {
                continue;
            }
            prop_assert!(made.is_some(), "{key:?} of theirs is lost");
            let before = base.0.get(&(kind, id)).cloned().unwrap_or_default();
            for (tag, value) in content.tags.iter().filter(|(tag, value)| before.tags.get(*tag) != Some(*value)) {
                prop_assert!(made.unwrap().tags.get(tag) == Some(value) || told.contains(&id), "{key:?} {tag}");
            }
        }
    }
}
