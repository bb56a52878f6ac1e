//! Small files, edited; and a judge that knows one fault.

mod judgement_tests;

use super::finding_counts::FindingCounts;
use super::proposal::Proposal;
use super::text_edits::TextEdits;
use super::tried::Tried;
use super::{Judge, mend};
use crate::diagnostic::{Diagnostic, Edit, Finding, Fix, Severity, Subject};
use crate::osm::{Node, OsmData, read_bytes};

const MAP: &str = r#"<?xml version="1.0"?>
<osm version="0.6">
  <node id="1" lat="0" lon="0"/>
  <node id="2" lat="0" lon="1">
    <tag k="ele" v="3" />
  </node>
  <node id="3" lat="0" lon="2"/>
  <way id="10"><nd ref="1"/><nd ref="2"/></way>
  <!-- a word -->
  <relation id="20">
    <member type="way" role="left" ref="10"/>
    <member type="way" role="right" ref="10"/>
    <tag k="type" v="lanelet"/>
  </relation>
</osm>
"#;

fn read(text: &str) -> OsmData {
    let mut osm = OsmData::default();
    read_bytes(&mut osm, "map.osm", text.as_bytes().to_vec()).unwrap();
    osm
}

/// The lines of the map that are not as they were, after the edits; `None` if they cannot be made.
fn edited(edits: &[Edit]) -> Option<Vec<String>> {
    let osm = read(MAP);
    let mut texts = TextEdits::new(&osm);
    let fix = Fix { title: String::new(), safe: true, edits: edits.to_vec() };
    let made = texts.apply(&fix).is_some();
    let made_of_it = texts.made().unwrap();
    let text = made_of_it.sources[0].text.clone();
    let elements = |osm: &OsmData| format!("{:?} {:?} {:?} {:?}", osm.nodes, osm.ways, osm.relations, osm.oddities);
    assert_eq!(elements(&made_of_it), elements(&read(&text)), "what is edited in memory is what a reader finds");
    if !made {
        assert_eq!(text, MAP, "a fix that cannot be made changes nothing");
        return None;
    }
    let diff = similar::TextDiff::from_lines(MAP, &text);
    let changed = diff.iter_all_changes().filter(|change| change.tag() != similar::ChangeTag::Equal);
    Some(changed.map(|change| format!("{}{}", change.tag(), change.value().trim_end())).collect())
}

#[test]
fn a_version_is_written_into_the_head() {
    let version = Edit::SetFormatVersion { version: "2".into() };
    let lines = edited(std::slice::from_ref(&version)).unwrap();
    assert_eq!(lines, ["+  <MetaInfo format_version=\"2\" map_version=\"1\"/>"]);
    let osm = read(&MAP.replace("<!-- a word -->", "<MetaInfo map_version='7' format_version='x'/>"));
    let made = super::edited(&osm, &Fix { title: String::new(), safe: true, edits: vec![version] }).unwrap();
    assert!(made[0].contains("  <MetaInfo map_version='7' format_version='2'/>\n  <relation"), "{made:?}");
}

#[test]
fn a_tag_is_set_where_it_stands() {
    let edit = Edit::SetTag { on: Subject::Point(2), key: "ele".into(), value: "4 < 5".into() };
    assert_eq!(edited(&[edit]).unwrap(), ["-    <tag k=\"ele\" v=\"3\" />", "+    <tag k=\"ele\" v=\"4 &lt; 5\"/>"]);
}

#[test]
fn an_element_without_children_opens_for_a_tag() {
    let edit = Edit::SetTag { on: Subject::Point(1), key: "ele".into(), value: "4".into() };
    let lines = [
        "-  <node id=\"1\" lat=\"0\" lon=\"0\"/>",
        "+  <node id=\"1\" lat=\"0\" lon=\"0\">",
        "+    <tag k=\"ele\" v=\"4\"/>",
        "+  </node>",
    ];
    assert_eq!(edited(&[edit]).unwrap(), lines);
}

#[test]
fn the_last_child_leaves_an_element_without() {
    let edit = Edit::RemoveTag { on: Subject::Point(2), key: "ele".into() };
    assert_eq!(edited(&[edit]).unwrap()[3], "+  <node id=\"2\" lat=\"0\" lon=\"1\"/>");
}

#[test]
fn vertices_go_where_they_are_told() {
    let way = Subject::LineString(10);
    let insert = |position| Edit::InsertVertex { way, position, point: 3 };
    let line = |edits: &[Edit]| edited(edits).map(|lines| lines[1].clone());
    assert_eq!(line(&[insert(1)]).unwrap(), "+  <way id=\"10\"><nd ref=\"1\"/><nd ref=\"3\"/><nd ref=\"2\"/></way>");
    assert_eq!(line(&[insert(2)]).unwrap(), "+  <way id=\"10\"><nd ref=\"1\"/><nd ref=\"2\"/><nd ref=\"3\"/></way>");
    assert_eq!(line(&[insert(3)]), None, "there is no such place");
    let merged = line(&[Edit::MergePoints { from: 2, to: 3 }]).unwrap();
    assert_eq!(merged, "-    <tag k=\"ele\" v=\"3\" />");
    let both = [insert(1), Edit::RemoveVertex { way, position: 1 }];
    assert_eq!(line(&both).unwrap(), "+  <way id=\"10\"><nd ref=\"1\"/><nd ref=\"3\"/></way>");
}

#[test]
fn what_is_removed_is_no_longer_referred_to() {
    let lines = edited(&[Edit::Remove { subject: Subject::LineString(10) }]).unwrap();
    assert_eq!(lines.len(), 3, "{lines:?}");
    assert!(lines.iter().all(|line| line.starts_with('-')));
}

/// The map with a multipolygon along the way.
fn with_area() -> OsmData {
    let area = "<relation id=\"30\"><member type=\"way\" role=\"outer\" ref=\"10\"/><tag k=\"type\" v=\"multipolygon\"/></relation>";
    read(&MAP.replace("</osm>", &format!("{area}\n</osm>")))
}

#[test]
fn an_area_keeps_its_outline() {
    let after = |edit: Edit| {
        let osm = with_area();
        let mut texts = TextEdits::new(&osm);
        texts.apply(&Fix { title: String::new(), safe: true, edits: vec![edit] }).unwrap();
        texts.made().unwrap()
    };
    let outline = |osm: &OsmData| osm.way(osm.relation(30).unwrap().members[0].id).unwrap().nodes.clone();
    let longer = after(Edit::SetVertices { way: Subject::LineString(10), points: vec![1, 2, 3] });
    assert_eq!(longer.way(10).unwrap().nodes, [1, 2, 3]);
    assert_eq!(outline(&longer), [1, 2], "by a way of its own");
    let gone = after(Edit::Remove { subject: Subject::LineString(10) });
    assert!(gone.relation(20).unwrap().members.is_empty());
    assert_eq!(outline(&gone), [1, 2], "by the way, which the lanelet no longer refers to");
}

#[test]
fn an_element_is_made_with_an_id_of_its_own() {
    let members = vec![("refers".into(), Subject::LineString(10))];
    let edit = Edit::CreateRegulatoryElement { subtype: "traffic_light".into(), members, referrers: vec![20] };
    let lines = edited(&[edit]).unwrap();
    assert!(
        lines.contains(&"+    <member type=\"relation\" ref=\"21\" role=\"regulatory_element\"/>".to_owned()),
        "{lines:?}"
    );
    assert!(lines.contains(&"+  <relation id=\"21\" version=\"1\">".to_owned()), "{lines:?}");
}

#[test]
fn fixes_that_reach_for_the_same_wait() {
    let osm = read(MAP);
    let mut texts = TextEdits::new(&osm);
    let set = |key: &str, value: &str| Fix {
        title: String::new(),
        safe: true,
        edits: vec![Edit::SetTag { on: Subject::Lanelet(20), key: key.into(), value: value.into() }],
    };
    assert!(texts.apply(&set("subtype", "road")).is_some());
    assert!(texts.apply(&set("speed_limit", "30")).is_some());
    assert!(texts.apply(&set("subtype", "crosswalk")).is_none());
    let remove = Fix { title: String::new(), safe: true, edits: vec![Edit::Remove { subject: Subject::Lanelet(20) }] };
    assert!(texts.apply(&remove).is_none());
}

fn diagnostic(code: &str, subject: Subject, fix: Option<Fix>) -> Diagnostic {
    let mut finding = Finding::new("fault", subject, "It is so.");
    finding.fix = fix;
    Diagnostic::new(code, Severity::Error, finding)
}

/// Every node wants `ele`; node 3 must not have it.
fn judge(osm: &OsmData) -> Result<Vec<Diagnostic>, std::convert::Infallible> {
    let mut found = Vec::new();
    for node in &osm.nodes {
        let on = Subject::Point(node.id);
        if node.tags.get("ele").is_none() {
            let edits = vec![Edit::SetTag { on, key: "ele".into(), value: "0".into() }];
            let fix = Fix { title: "Set ele".to_owned(), safe: node.id < 4, edits };
            found.push(diagnostic("node/ele", on, Some(fix)));
        } else if node.id == 3 {
            found.push(diagnostic("node/no-ele", on, None));
        }
    }
    Ok(found)
}

#[test]
fn a_fix_that_brings_an_error_is_not_kept() {
    let mended = mend(read(MAP), false, judge).unwrap();
    assert_eq!(mended.done.iter().map(|mend| mend.subject).collect::<Vec<_>>(), [Subject::Point(1)]);
    let refused: Vec<(Subject, &str)> =
        mended.refused.iter().map(|(mend, reason)| (mend.subject, reason.as_str())).collect();
    assert_eq!(refused, [(Subject::Point(3), "it brings node/no-ele: It is so.")]);
    assert_eq!(mended.left.len(), 1);
    assert!(mended.osm.node(1).unwrap().tags.is("ele", "0"));
    assert!(mended.osm.node(3).unwrap().tags.is_empty());
}

#[test]
fn unsafe_fixes_are_made_when_they_are_asked_for() {
    let map = MAP.replace("id=\"3\"", "id=\"4\"");
    let mended = mend(read(&map), false, judge).unwrap();
    assert_eq!((mended.done.len(), mended.unsafe_left), (1, 1));
    let mended = mend(read(&map), true, judge).unwrap();
    assert_eq!((mended.done.len(), mended.left.len()), (2, 0));
}

#[test]
fn a_stop_line_is_drawn_with_its_element() {
    let lines = edited(&[Edit::CreateMarking { points: vec![1, 2], lanelets: vec![20] }]).unwrap().join("\n");
    for tag in [r#"k="type" v="stop_line""#, r#"k="subtype" v="road_marking""#, r#"role="regulatory_element""#] {
        assert!(lines.contains(tag), "{lines}");
    }
    assert!(lines.contains(r#"<member type="way" ref="21" role="refers"/>"#), "{lines}");
}

/// Two nodes want `ele`, which is a warning, and the lanelet an area, under which it has some warnings more.
fn judge_area(osm: &OsmData, brings: usize) -> Vec<Diagnostic> {
    let graded = |one: Diagnostic, severity| Diagnostic { severity, ..one };
    let bare = osm.nodes.iter().filter(|node| node.tags.get("ele").is_none());
    let mut found: Vec<Diagnostic> =
        bare.map(|node| graded(wants_ele(Subject::Point(node.id)), Severity::Warning)).collect();
    let on = Subject::Lanelet(20);
    if osm.relations.iter().any(|one| one.tags.has("intersection_area")) {
        found.extend((0..brings).map(|_| graded(diagnostic("area/shape", on, None), Severity::Warning)));
    } else {
        let edits = vec![Edit::CreateArea { points: vec![1, 2, 3], corners: Vec::new(), lanelets: vec![20] }];
        let fix = Fix { title: "draw the area".to_owned(), safe: false, edits };
        found.push(diagnostic("area/none", on, Some(fix)));
    }
    found
}

/// An area may bring more warnings than it mends errors only as far as the map had them before.
#[test]
fn an_area_is_drawn_as_long_as_the_map_has_no_more_warnings() {
    let scope = super::Scope { unsafe_too: true, ..super::Scope::default() };
    let mended = |brings: usize| {
        mend(read(MAP), scope, |osm: &OsmData| Ok::<_, std::convert::Infallible>(judge_area(osm, brings))).unwrap()
    };
    let (few, many) = (mended(2), mended(3));
    assert_eq!((few.before, few.after()), ([1, 2], [0, 2]), "{:?}", few.refused);
    assert_eq!((many.before, many.after()), ([1, 2], [1, 0]));
    assert!(many.more_warnings.is_empty());
    let (_, reason) = many.refused.first().unwrap();
    assert!(reason == "it brings 2 more warnings than it mends, --allow-warnings makes it: 3 × area/shape", "{reason}");
}

#[test]
fn a_finding_is_known_by_its_element_and_not_by_its_text() {
    let said = |message: &str| {
        let finding = Finding::new("fault", Subject::Point(1), message);
        Diagnostic::new("node/other-square", Severity::Error, finding)
    };
    assert!(super::new_findings(&[said("in one of 4 squares")], &[said("in one of 2 squares")]).is_empty());
    assert_eq!(super::new_findings(&[said("a")], &[said("a"), said("b")]).len(), 1);
}

/// Every id below 100 is wrong, and every way has a fault of its own that stays.
fn judge_ids(osm: &OsmData, asked: &std::cell::Cell<usize>) -> Vec<Diagnostic> {
    asked.set(asked.get() + 1);
    let nodes = osm.nodes.iter().map(|node| Subject::Node(node.id));
    let subjects = nodes.chain(osm.ways.iter().map(|way| Subject::Way(way.id)));
    let wrong = subjects.filter(|on| on.id().is_some_and(|id| id < 100)).map(|on| {
        let edits = vec![Edit::Renumber { on, nth: 0, referrers: None }];
        diagnostic("ids/range", on, Some(Fix { title: "renumber".to_owned(), safe: true, edits }))
    });
    let stays = osm.ways.iter().map(|way| diagnostic("way/fault", Subject::LineString(way.id), None));
    wrong.chain(stays).collect()
}

#[test]
fn all_nodes_of_a_way_are_renumbered_at_once() {
    let map = MAP.replace("relation id=\"20\"", "relation id=\"200\"");
    let asked = std::cell::Cell::new(0);
    let mended =
        mend(read(&map), false, |osm: &OsmData| Ok::<_, std::convert::Infallible>(judge_ids(osm, &asked))).unwrap();
    assert_eq!((mended.done.len(), mended.refused.len(), mended.left.len()), (4, 0, 1), "{:?}", mended.refused);
    assert_eq!(mended.osm.ways[0].nodes, [201, 202]);
    assert_eq!(mended.osm.relations[0].members[0].id, mended.osm.ways[0].id);
    assert!(asked.get() <= 3, "nodes, then the way that names them: {} judgements", asked.get());
}

/// A node that is to have `ele`, with the safe fix that sets it.
fn wants_ele(on: Subject) -> Diagnostic {
    let edits = vec![Edit::SetTag { on, key: "ele".into(), value: "0".into() }];
    diagnostic("node/ele", on, Some(Fix { title: "Set ele".to_owned(), safe: true, edits }))
}

/// Five thousand nodes want `ele`; one in a hundred must not have it, and says so of another at its place.
#[test]
fn what_does_harm_is_found_in_few_judgements() {
    let nodes: String = (1..=5000).map(|id| format!("<node id=\"{id}\" lat=\"0\" lon=\"0\"/>\n")).collect();
    let osm = read(&format!("<osm version=\"0.6\">\n{nodes}</osm>\n"));
    let asked = std::cell::Cell::new(0);
    let judge = |osm: &OsmData| {
        asked.set(asked.get() + 1);
        let mut found = Vec::new();
        for node in &osm.nodes {
            let on = Subject::Point(node.id);
            let place = crate::geometry::Point::new(200.0 * (node.id / 10) as f64, 0.0);
            if node.tags.get("ele").is_none() {
                found.push(Diagnostic { local: Some(place), ..wants_ele(on) });
            } else if node.id % 100 == 7 {
                // Said of another node at the same place.
                let other = Subject::Point(10_000 + node.id);
                found.push(Diagnostic { local: Some(place), ..diagnostic("node/no-ele", other, None) });
            }
        }
        Ok::<_, std::convert::Infallible>(found)
    };
    let mended = mend(osm, false, judge).unwrap();
    assert_eq!((mended.done.len(), mended.refused.len()), (4950, 50));
    assert!(asked.get() <= 12, "{} judgements", asked.get());
}

/// Where nearly every fix does harm, and it cannot be told which one, the map is judged only so often; what was not tried is listed as such,
/// and the safe fixes are made that do no harm.
#[test]
fn what_would_take_too_long_is_not_tried_and_listed() {
    const NODES: usize = 2_000;
    let nodes: String = (1..=NODES).map(|id| format!("<node id=\"{id}\" lat=\"0\" lon=\"0\"/>\n")).collect();
    let osm = format!("<osm version=\"0.6\">\n{nodes}</osm>\n");
    let is_safe = |id: i64| id % 20 == 0;
    let asked = std::cell::Cell::new(0);
    let judge = |osm: &OsmData| {
        asked.set(asked.get() + 1);
        let (without, with): (Vec<_>, Vec<_>) = osm.nodes.iter().partition(|node| node.tags.get("ele").is_none());
        let local = Some(crate::geometry::Point::new(0.0, 0.0));
        let wanting = without.iter().map(|node| {
            let mut found = Diagnostic { local, ..wants_ele(Subject::Point(node.id)) };
            found.finding.fix.as_mut().unwrap().safe = is_safe(node.id);
            found
        });
        let harmful = with.iter().filter(|node| !is_safe(node.id));
        let harmed = harmful.map(|node| {
            let other = Subject::Point(1_000_000 + node.id);
            Diagnostic { local, ..diagnostic("node/no-ele", other, None) }
        });
        Ok::<_, std::convert::Infallible>(wanting.chain(harmed).collect::<Vec<_>>())
    };
    let mended = mend(read(&osm), true, judge).unwrap();
    assert_eq!((mended.done.len(), mended.left.len()), (NODES / 20, NODES - NODES / 20));
    assert!(mended.untried > NODES / 2, "{} not tried", mended.untried);
    assert!(asked.get() <= 220, "{} judgements", asked.get());
}

/// A map of so many places, each with 16 nodes that want `ele`, of which one must not have it, and in every other place a second one. The
/// error is told of the place, so that each node of it may be the cause.
fn judgements_of_places(places: i64) -> usize {
    let nodes: String =
        (16..16 * (places + 1)).map(|id| format!("<node id=\"{id}\" lat=\"0\" lon=\"0\"/>\n")).collect();
    let osm = read(&format!("<osm version=\"0.6\">\n{nodes}</osm>\n"));
    let asked = std::cell::Cell::new(0);
    let judge = |osm: &OsmData| {
        asked.set(asked.get() + 1);
        let mut found = Vec::new();
        for node in &osm.nodes {
            let (number, at) = (node.id / 16, node.id % 16);
            let place = Some(crate::geometry::Point::new(500.0 * number as f64, 0.0));
            if node.tags.get("ele").is_none() {
                found.push(Diagnostic { local: place, ..wants_ele(Subject::Point(node.id)) });
            } else if at == number % 13 || (number % 2 == 0 && at == 15) {
                let place_itself = Subject::Point(1_000_000 + node.id);
                found.push(Diagnostic { local: place, ..diagnostic("node/no-ele", place_itself, None) });
            }
        }
        Ok::<_, std::convert::Infallible>(found)
    };
    let mended = mend(osm, false, judge).unwrap();
    let refused = places + places / 2;
    assert_eq!((mended.done.len() as i64, mended.refused.len() as i64), (16 * places - refused, refused));
    asked.get()
}

/// Places far apart are halved together: a hundred of them cost at most twice what two cost, and not fifty times.
#[test]
fn places_with_trouble_do_not_wait_for_each_other() {
    let [few, many] = [2, 100].map(judgements_of_places);
    // Sixteen nodes are halved four times; each half may be judged, and kept, for each of the two that do harm. In the end these two are
    // tried once more.
    let halvings = 4;
    assert!(few <= 2 + 2 * 2 * halvings + 2, "{few} judgements for two places");
    assert!(many <= 2 * few, "{few} judgements for two places, {many} for a hundred");
}

/// Fixes that are known to do harm together are not tried together again: where the others of their group do none, the last is blamed
/// without a further judgement: it was tried together with all that was applied near it.
#[test]
fn what_follows_is_not_asked() {
    let osm =
        read("<osm version=\"0.6\">\n<node id=\"1\" lat=\"0\" lon=\"0\"/><node id=\"2\" lat=\"0\" lon=\"0\"/></osm>\n");
    let asked = std::cell::Cell::new(0);
    let judge = |osm: &OsmData| {
        asked.set(asked.get() + 1);
        let mut found = judge(osm)?;
        if osm.nodes.iter().any(|node| node.id == 2 && node.tags.has("ele")) {
            found.push(diagnostic("map/fault", Subject::Map, None));
        }
        Ok::<_, std::convert::Infallible>(found)
    };
    let mended = mend(osm, true, judge).unwrap();
    assert_eq!((mended.done.len(), mended.refused.len()), (1, 1));
    assert_eq!(asked.get(), 3, "as it is, with both, with one");
}

/// A node without `ele` wants it; one with `ele` and without `name` wants that. Neither is an error alone for node 3, where a
/// `name` brings an error that nothing mends.
#[test]
fn a_fix_is_kept_with_the_fix_of_what_it_brings() {
    let judge = |osm: &OsmData| {
        let wants = |on: Subject, key: &'static str| {
            let edits = vec![Edit::SetTag { on, key: key.into(), value: "0".into() }];
            diagnostic("node/wants", on, Some(Fix { title: format!("set {key}"), safe: true, edits }))
        };
        let mut found = Vec::new();
        for node in &osm.nodes {
            let on = Subject::Point(node.id);
            match (node.tags.has("ele"), node.tags.has("name")) {
                (false, _) => found.push(wants(on, "ele")),
                (true, false) => found.extend([Diagnostic { code: "node/name".to_owned(), ..wants(on, "name") }]),
                (true, true) if node.id == 3 => found.push(diagnostic("node/three", on, None)),
                _ => {}
            }
        }
        Ok::<_, std::convert::Infallible>(found)
    };
    let mended = mend(read(MAP), false, judge).unwrap();
    let done: Vec<(Subject, &str)> = mended.done.iter().map(|mend| (mend.subject, mend.title.as_str())).collect();
    // Node 2 has `ele` from the start, so that its fix stands alone; that of node 1 leads to another.
    assert!(
        done.contains(&(Subject::Point(1), "set ele")) && done.contains(&(Subject::Point(1), "set name")),
        "{done:?}"
    );
    assert!(mended.osm.node(1).unwrap().tags.has("name"));
    assert!(!mended.osm.node(3).unwrap().tags.has("ele"), "what it leads to does harm");
    assert_eq!(mended.refused.iter().map(|(mend, _)| mend.subject).collect::<Vec<_>>(), [Subject::Point(3)]);
}

/// A group that loses a member is told by another first element, and that is no new error.
#[test]
fn a_group_that_becomes_smaller_is_not_new() {
    let group = |ids: &[i64]| {
        let mut found = diagnostic("group/open", Subject::Lanelet(ids[0]), None);
        for &id in &ids[1..] {
            found.finding = found.finding.with(Subject::Lanelet(id), "lanelet");
        }
        found
    };
    let known = || FindingCounts::of(&[group(&[1, 2, 3, 4])]);
    assert!(known().exceeded_by(&[group(&[2, 3, 4])]).is_empty());
    assert_eq!(known().exceeded_by(&[group(&[2, 3, 5])]).len(), 1);
}

/// How many places there are, half a kilometre apart, and how many nodes each has.
const PLACES: i64 = 100;
const NODES: i64 = 16;

/// Wants `ele` of every node; in one place a node must not have it, which is said of the place.
struct Places {
    /// How many nodes it has looked at.
    looked: std::cell::Cell<usize>,
    /// Whether it sees that of the whole map only.
    is_blind: bool,
}

impl Places {
    fn found(&self, osm: &OsmData, is_whole: bool) -> Vec<Diagnostic> {
        self.looked.set(self.looked.get() + osm.nodes.len());
        let mut found = Vec::new();
        for node in &osm.nodes {
            let (place, at) = (node.id / NODES, node.id % NODES);
            let local = Some(crate::geometry::Point::new(500.0 * place as f64, 0.0));
            if !node.tags.has("ele") {
                found.push(Diagnostic { local, ..wants_ele(Subject::Point(node.id)) });
            } else if (place, at) == (PLACES / 2, 5) && (is_whole || !self.is_blind) {
                found.push(Diagnostic { local, ..diagnostic("place/fault", Subject::Point(1_000_000 + place), None) });
            }
        }
        found
    }
}

impl Judge for &Places {
    type Error = std::convert::Infallible;

    fn whole(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, std::convert::Infallible> {
        Ok(self.found(osm, true))
    }

    fn parts(&self, parts: &[&OsmData]) -> Result<Vec<Vec<Diagnostic>>, std::convert::Infallible> {
        Ok(parts.iter().map(|osm| self.found(osm, false)).collect())
    }

    fn place(&self, node: &Node) -> Option<[f64; 2]> {
        node.position.map(|place| [500.0 * place.lon, 0.0])
    }
}

fn places() -> OsmData {
    let node = |id: i64| format!("<node id=\"{id}\" lat=\"0\" lon=\"{}\"/>\n", id / NODES);
    let nodes: String = (NODES..NODES * (PLACES + 1)).map(node).collect();
    read(&format!("<osm version=\"0.6\">\n{nodes}</osm>\n"))
}

#[test]
fn what_is_far_from_a_change_is_not_judged_again() {
    let judge = Places { looked: std::cell::Cell::new(0), is_blind: false };
    let mended = mend(places(), false, &judge).unwrap();
    let all = PLACES * NODES;
    assert_eq!((mended.done.len() as i64, mended.refused.len()), (all - 1, 1));
    // As it was, with all fixes, and two times to be sure. Between them the one place is judged nine times after a change, and
    // three times before it: the other times that is known from the change before.
    let most = 4 * all as usize + 12 * NODES as usize;
    assert!(judge.looked.get() <= most, "{} nodes looked at, of {all}", judge.looked.get());
}

#[test]
fn what_only_the_whole_map_shows_is_not_kept() {
    let judge = Places { looked: std::cell::Cell::new(0), is_blind: true };
    // One node lacks `ele` at first, the one that must not have it, so that its place alone is judged.
    let mut edits = places().sources[0].text.clone();
    for id in (NODES..NODES * (PLACES + 1)).filter(|id| *id != PLACES / 2 * NODES + 5) {
        let bare = format!("<node id=\"{id}\" lat=\"0\" lon=\"{}\"/>", id / NODES);
        edits = edits.replace(&bare, &bare.replace("/>", "><tag k=\"ele\" v=\"0\"/></node>"));
    }
    let mended = mend(read(&edits), false, &judge).unwrap();
    assert_eq!((mended.done.len(), mended.refused.len()), (0, 1));
    assert_eq!(mended.left.len(), 1, "no error has come");
}

/// A fix that was not kept is tried again only after another was applied near it.
#[test]
fn what_did_harm_is_tried_again_after_a_change_near_it() {
    let at = |id: i64, x: f64| {
        let local = Some(crate::geometry::Point::new(x, 0.0));
        Proposal::of(&Diagnostic { local, ..wants_ele(Subject::Point(id)) }).unwrap()
    };
    let (near, far, later) = (at(1, 0.0), at(2, 500.0), at(3, 50.0));
    let mut tried = Tried::default();
    let is_new: Vec<bool> = [&near, &far, &far].into_iter().map(|one| tried.refused(&one.mend)).collect();
    assert_eq!(is_new, [true, true, false]);
    assert!(!tried.forget_changed([near.clone(), far.clone()].into_iter()), "nothing was applied since");
    tried.made(&later);
    assert!(tried.forget_changed([near.clone(), far.clone()].into_iter()));
    assert_eq!((tried.has(&near.mend), tried.has(&far.mend)), (false, true));
    assert!(tried.forget_changed(std::iter::once(later.clone())), "the finding of an applied fix is there again");
}
