//! Merges of small maps, and of random edits of random maps.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use rustc_hash::FxHashMap;

use super::content::Content;
use super::{Deletions, Key, Merged, Side, Versions, merge};
use crate::diagnostic::Subject;
use crate::lanelet::{from_osm, projector_for};
use crate::osm::{ElementKind, Member, OsmData, OsmText, read_bytes};
use crate::projection::LonLat;

const MAP: &str = r#"<?xml version="1.0"?>
<osm version="0.6">
  <MetaInfo format_version="1" map_version="3"/>
  <node id="1" lat="48.1000000" lon="11.5000000"><tag k="ele" v="1"/></node>
  <node id="2" lat="48.1000000" lon="11.5001000"/>
  <node id="3" lat="48.1000000" lon="11.5002000"/>
  <node id="4" lat="48.1001000" lon="11.5000000"/>
  <node id="5" lat="48.1001000" lon="11.5002000"/>
  <node id="6" lat="48.1002000" lon="11.5000000"/>
  <node id="7" lat="48.1002000" lon="11.5002000"/>
  <way id="11">
    <nd ref="1"/>
    <nd ref="2"/>
    <nd ref="3"/>
    <tag k="type" v="line_thin"/>
  </way>
  <way id="12"><nd ref="4"/><nd ref="5"/></way>
  <way id="13"><nd ref="6"/><nd ref="7"/></way>
  <!-- a word -->
  <relation id="21">
    <member type="way" ref="11" role="left"/>
    <member type="way" ref="12" role="right"/>
    <tag k="type" v="lanelet"/>
    <tag k="speed_limit" v="30"/>
  </relation>
  <relation id="22">
    <member type="way" ref="12" role="left"/>
    <member type="way" ref="13" role="right"/>
    <tag k="type" v="lanelet"/>
  </relation>
  <relation id="31">
    <member type="relation" ref="21" role="right_of_way"/>
    <member type="relation" ref="22" role="yield"/>
    <tag k="type" v="regulatory_element"/>
    <tag k="subtype" v="right_of_way"/>
  </relation>
</osm>
"#;

fn read(text: &str) -> OsmData {
    let mut osm = OsmData::default();
    read_bytes(&mut osm, "map.osm", text.as_bytes().to_vec()).unwrap_or_else(|error| panic!("{error}\n{text}"));
    osm
}

fn merged(base: &str, ours: &str, theirs: &str) -> Merged {
    let [base, ours, theirs] = [base, ours, theirs].map(read);
    merge(Versions { base: &base, ours: &ours, theirs: &theirs }, Deletions::Kept)
}

/// The map with some text in place of other text, all of which is there.
fn with(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(MAP.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    })
}

/// What is merged without a conflict.
#[track_caller]
fn clean(ours: &str, theirs: &str) -> String {
    let merged = merged(MAP, ours, theirs);
    assert_eq!(merged.conflicts, [], "{}", merged.text);
    merged.text
}

const NEW_NODE: (&str, &str) =
    ("  <node id=\"3\"", "  <node id=\"8\" lat=\"48.1\" lon=\"11.50015\"/>\n  <node id=\"3\"");

#[test]
fn each_side_s_changes_are_there_and_no_other_letter_changes() {
    let moved = ("<node id=\"2\" lat=\"48.1000000\"", "<node id=\"2\" lat=\"48.1000050\"");
    let inserted = ("    <nd ref=\"3\"/>\n", "    <nd ref=\"8\"/>\n    <nd ref=\"3\"/>\n");
    let faster = ("v=\"30\"", "v=\"50\"");
    let tagged = ("<way id=\"13\"><nd", "<way id=\"13\"><tag k=\"type\" v=\"road_border\"/><nd");
    // One moves a vertex of a line, the other inserts one.
    let text = clean(&with(&[moved, tagged]), &with(&[inserted, faster, NEW_NODE]));
    // Nodes are in the order of ids, so that the new one comes behind the others.
    let new = ("  <way id=\"11\"", "  <node id=\"8\" lat=\"48.1\" lon=\"11.50015\"/>\n  <way id=\"11\"");
    assert_eq!(text, with(&[moved, tagged, inserted, faster, new]));
    // Both change one line, each something else.
    let solid = ("    <tag k=\"type\" v=\"line_thin\"/>", "    <tag k=\"type\" v=\"line_thick\"/>");
    let text = clean(&with(&[solid]), &with(&[inserted, NEW_NODE]));
    assert!(text.contains(
        "    <nd ref=\"2\"/>\n    <nd ref=\"8\"/>\n    <nd ref=\"3\"/>\n    <tag k=\"type\" v=\"line_thick\"/>"
    ));
}

#[test]
fn what_both_insert_between_two_vertices_lies_in_the_order_of_the_line() {
    let at = |id: i64, lon: &str| {
        let node = format!("  <node id=\"{id}\" lat=\"48.1\" lon=\"{lon}\"/>\n  <node id=\"3\"");
        with(&[
            ("  <node id=\"3\"", &node),
            ("    <nd ref=\"3\"/>\n", &format!("    <nd ref=\"{id}\"/>\n    <nd ref=\"3\"/>\n")),
        ])
    };
    for (ours, theirs) in [(at(8, "11.50013"), at(9, "11.50017")), (at(9, "11.50017"), at(8, "11.50013"))] {
        let nodes = read(&clean(&ours, &theirs)).way(11).map(|way| way.nodes.clone());
        assert_eq!(nodes, Some(vec![1, 2, 8, 9, 3]));
    }
    let beyond = merged(MAP, &at(8, "11.50013"), &at(9, "11.50030"));
    assert_eq!(beyond.conflicts[0].about, "nodes");
    assert_eq!(beyond.conflicts[0].theirs.as_deref(), Some("1 2 9 3"));
}

#[test]
fn members_are_merged_by_their_roles() {
    let elements = |rows: &str| {
        let old = "    <member type=\"relation\" ref=\"21\" role=\"right_of_way\"/>\n    <member type=\"relation\" ref=\"22\" role=\"yield\"/>\n";
        with(&[(
            old,
            &rows
                .split(' ')
                .map(|row| {
                    let (id, role) = row.split_once(':').unwrap();
                    format!("    <member type=\"relation\" ref=\"{id}\" role=\"{role}\"/>\n")
                })
                .collect::<String>(),
        )])
    };
    let roles = |text: &str| {
        let osm = read(text);
        let members = osm.relation(31).unwrap().members.iter().map(|one| format!("{}:{}", one.id, one.role));
        members.collect::<Vec<_>>().join(" ")
    };
    // One takes a yield away, the other adds one.
    let text = clean(&elements("21:right_of_way"), &elements("21:right_of_way 22:yield 21:yield"));
    assert_eq!(roles(&text), "21:right_of_way 21:yield");
    let both = merged(MAP, &elements("21:right_of_way 22:right_of_way"), &elements("21:right_of_way"));
    assert_eq!(both.conflicts[0].about, "role of relation 22");
    assert_eq!((both.conflicts[0].ours.as_deref(), both.conflicts[0].theirs.as_deref()), (Some("right_of_way"), None));
    assert_eq!(roles(&both.text), "21:right_of_way 22:right_of_way");
    // A lanelet has one left bound.
    let bound = |id: &str| with(&[("ref=\"11\" role=\"left\"", &format!("ref=\"{id}\" role=\"left\""))]);
    let both = merged(MAP, &bound("13"), &bound("12"));
    assert!(both.conflicts.iter().any(|one| one.about == "left"), "{:?}", both.conflicts);
    let lefts = read(&both.text).relation(21).unwrap().members.iter().filter(|one| one.role == "left").count();
    assert_eq!(lefts, 1);
}

#[test]
fn what_both_change_to_something_else_is_told_with_both_values() {
    let of = |speed: &str, lat: &str| {
        with(&[
            ("v=\"30\"", &format!("v=\"{speed}\"")),
            ("<node id=\"5\" lat=\"48.1001000\"", &format!("<node id=\"5\" lat=\"{lat}\"")),
        ])
    };
    let merged = merged(MAP, &of("50", "48.1001500"), &of("20", "48.1001700"));
    assert_eq!(merged.text, of("50", "48.1001500"), "the result is what ours says");
    let [place, speed] = &merged.conflicts[..] else { panic!("{:?}", merged.conflicts) };
    assert_eq!((place.subject, place.about.as_str()), (Subject::Point(5), "position"));
    assert_eq!(place.at.map(|at| at.lat), Some(48.10015));
    let said = [&speed.base, &speed.ours, &speed.theirs].map(|one| one.as_deref().unwrap_or_default());
    assert_eq!(
        (speed.subject, speed.about.as_str(), said),
        (Subject::Lanelet(21), "tag speed_limit", ["30", "50", "20"])
    );
    assert!(speed.text().contains("conflict: lanelet 21: tag speed_limit (at 48.1"), "{}", speed.text());
    assert!(speed.text().contains("ours    50  <- in the result\n  theirs  20\n"), "{}", speed.text());
}

/// The map without lanelet 22 and what only it needs.
fn without_lanelet() -> String {
    let text = with(&[
        ("    <member type=\"relation\" ref=\"22\" role=\"yield\"/>\n", ""),
        ("  <way id=\"13\"><nd ref=\"6\"/><nd ref=\"7\"/></way>\n", ""),
        ("  <node id=\"6\" lat=\"48.1002000\" lon=\"11.5000000\"/>\n", ""),
        ("  <node id=\"7\" lat=\"48.1002000\" lon=\"11.5002000\"/>\n", ""),
    ]);
    let (before, rest) = text.split_once("  <relation id=\"22\">").unwrap();
    format!("{before}{}", rest.split_once("</relation>\n").unwrap().1)
}

#[test]
fn what_one_deletes_and_the_other_changes_or_uses_is_kept_whole() {
    let moved = with(&[("<node id=\"7\" lat=\"48.1002000\"", "<node id=\"7\" lat=\"48.1002100\"")]);
    for (ours, theirs, taken) in
        [(moved.clone(), without_lanelet(), Side::Ours), (without_lanelet(), moved, Side::Theirs)]
    {
        let merged = merged(MAP, &ours, &theirs);
        let [conflict] = &merged.conflicts[..] else { panic!("{:?}", merged.conflicts) };
        assert_eq!(
            (conflict.subject, conflict.about.as_str(), conflict.taken),
            (Subject::Lanelet(22), "deletion", taken)
        );
        let osm = read(&merged.text);
        assert!(osm.relation(22).is_some() && osm.way(13).is_some() && osm.node(6).is_some(), "{}", merged.text);
        assert!(merged.text.contains("48.1002100"));
    }
    let used = with(&[(
        "    <tag k=\"type\" v=\"regulatory_element\"/>",
        "    <member type=\"way\" ref=\"13\" role=\"ref_line\"/>\n    <tag k=\"type\" v=\"regulatory_element\"/>",
    )]);
    for (ours, theirs) in [(used.clone(), without_lanelet()), (without_lanelet(), used)] {
        let merged = merged(MAP, &ours, &theirs);
        let [conflict] = &merged.conflicts[..] else { panic!("{:?}", merged.conflicts) };
        assert_eq!(conflict.subject, Subject::LineString(13));
        let said = [&conflict.ours, &conflict.theirs].into_iter().flatten().next().map(String::as_str);
        assert_eq!(said, Some("used by regulatory element 31"));
        let osm = read(&merged.text);
        assert!(osm.relation(22).is_none() && osm.way(13).is_some() && osm.node(6).is_some(), "{}", merged.text);
    }
    // What both delete is gone.
    assert!(read(&clean(&without_lanelet(), &without_lanelet())).relation(22).is_none());
    assert_eq!(clean(MAP, &without_lanelet()), without_lanelet());
}

#[test]
fn a_rule_of_which_both_take_the_members_is_gone() {
    let yielding = "    <member type=\"relation\" ref=\"22\" role=\"yield\"/>\n";
    let first = "    <member type=\"relation\" ref=\"21\" role=\"right_of_way\"/>\n";
    let text = clean(&with(&[(yielding, "")]), &with(&[(first, "")]));
    assert!(read(&text).relation(31).is_none(), "{text}");
    // A lanelet that names it names it no more.
    let names = "    <member type=\"way\" ref=\"11\" role=\"left\"/>\n";
    let named = |text: String| {
        text.replacen(
            names,
            &format!("{names}    <member type=\"relation\" ref=\"31\" role=\"regulatory_element\"/>\n"),
            1,
        )
    };
    let merged = merged(&named(MAP.to_owned()), &named(with(&[(yielding, "")])), &named(with(&[(first, "")])));
    let osm = read(&merged.text);
    assert!(osm.relation(31).is_none() && osm.relation(21).unwrap().members.len() == 2, "{}", merged.text);
    assert_eq!(merged.conflicts, []);
}

#[test]
fn elements_that_both_made_under_one_id_are_told_apart() {
    let made = |lon: &str, role: &str| {
        let node = format!("  <node id=\"9\" lat=\"48.1\" lon=\"{lon}\"/>\n  <way id=\"11\"");
        let way = "  <way id=\"14\"><nd ref=\"9\"/><nd ref=\"1\"/><tag k=\"area\" v=\"yes\"/></way>\n  <!-- a word -->";
        let names = format!("<tag k=\"speed_limit\" v=\"30\"/>\n    <tag k=\"{role}\" v=\"14\"/>");
        with(&[("  <way id=\"11\"", &node), ("  <!-- a word -->", way), ("<tag k=\"speed_limit\" v=\"30\"/>", &names)])
    };
    let merged = merged(MAP, &made("11.51", "intersection_area"), &made("11.52", "waypoints"));
    assert_eq!(merged.conflicts, []);
    assert_eq!(merged.renumbered, [(Subject::Point(9), 10), (Subject::Polygon(14), 15)]);
    let osm = read(&merged.text);
    assert_eq!((osm.way(14).unwrap().nodes.clone(), osm.way(15).unwrap().nodes.clone()), (vec![9, 1], vec![10, 1]));
    let tags = &osm.relation(21).unwrap().tags;
    assert_eq!((tags.get("intersection_area"), tags.get("waypoints")), (Some("14"), Some("15")));
    // The same drawn twice, as where a change is on both branches, is one.
    let twice = super::tests::merged(MAP, &made("11.51", "waypoints"), &made("11.510000001", "waypoints"));
    assert_eq!((twice.renumbered.len(), twice.text), (0, made("11.51", "waypoints")));
}

#[test]
fn of_two_version_numbers_the_higher_counts() {
    let version = |number: &str| with(&[("map_version=\"3\"", &format!("map_version=\"{number}\""))]);
    assert_eq!(clean(&version("4"), &version("5")), version("5"));
    assert_eq!(clean(&version("5"), &version("4")), version("5"));
    assert_eq!(clean(MAP, &version("4")), version("4"));
}

#[test]
fn what_only_one_has_formatted_is_formatted() {
    let formatted = crate::fix::canonical(MAP).unwrap();
    let changed = with(&[("v=\"30\"", "v=\"50\"")]);
    let text = clean(&changed, &formatted);
    assert!(text.contains("  <way id=\"12\" version=\"1\">\n    <nd ref=\"4\"/>"), "{text}");
    assert!(text.contains("v=\"50\""));
}

// Random maps, random edits.

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
                let position = super::content::Position {
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
        let view = super::view::View::new(&osm);
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
                let position = super::content::Position { lonlat: Some(lonlat), ..Default::default() };
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
            let faults = from_osm(&osm, &projector_for(&osm)).faults;
            faults.into_iter().map(|fault| format!("{} {:?}", fault.subject, fault.condition)).collect::<BTreeSet<String>>()
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
