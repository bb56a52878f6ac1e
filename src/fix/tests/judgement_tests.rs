//! How many judgements it takes to find out which fixes do harm, and which lead to others.

use std::cell::Cell;
use std::convert::Infallible;

use super::{diagnostic, mend, read};
use crate::diagnostic::{Diagnostic, Edit, Fix, Subject};
use crate::geometry::Point;
use crate::osm::OsmData;

/// The fix that sets a tag on a node to 0, safe.
fn set(id: i64, key: &'static str) -> Fix {
    let edits = vec![Edit::SetTag { on: Subject::Point(id), key: key.into(), value: "0".into() }];
    Fix { title: format!("set {key}"), safe: true, edits }
}

/// Mends a map by what a judge finds; returns how many fixes were made, how many were refused, and how often the judge was asked.
fn counts(osm: OsmData, judge: impl Fn(&OsmData) -> Vec<Diagnostic>) -> (usize, usize, usize) {
    let asked = Cell::new(0);
    let judge = |osm: &OsmData| {
        asked.set(asked.get() + 1);
        let place = Some(Point::new(0.0, 0.0));
        Ok::<_, Infallible>(judge(osm).into_iter().map(|one| Diagnostic { local: place, ..one }).collect())
    };
    let mended = mend(osm, false, judge).unwrap();
    (mended.done.len(), mended.refused.len(), asked.get())
}

/// Sixteen lanelets at one place want an element. That of lanelet 27 is wrong, which is told of the element and of all lanelets.
#[test]
fn what_a_fix_has_made_is_its_own_fault() {
    let ids = 20..36;
    let bound = "<node id=\"1\" lat=\"0\" lon=\"0\"/><way id=\"10\"><nd ref=\"1\"/></way>";
    let lanelet = |id| format!("<relation id=\"{id}\"><member type=\"way\" role=\"left\" ref=\"10\"/></relation>\n");
    let lanelets: String = ids.clone().map(lanelet).collect();
    let osm = read(&format!("<osm version=\"0.6\">\n{bound}\n{lanelets}</osm>\n"));
    let judge = |osm: &OsmData| {
        let lanelets = osm.relations.iter().filter(|one| ids.contains(&one.id));
        let found =
            lanelets.filter_map(|lanelet| match lanelet.members.iter().find(|one| one.role == "regulatory_element") {
                None => {
                    let subtype = "traffic_light".into();
                    let edit =
                        Edit::CreateRegulatoryElement { subtype, members: Vec::new(), referrers: vec![lanelet.id] };
                    let fix = Fix { title: "create the element".to_owned(), safe: true, edits: vec![edit] };
                    Some(diagnostic("lanelet/element", Subject::Lanelet(lanelet.id), Some(fix)))
                }
                Some(element) if lanelet.id == 27 => {
                    let mut wrong = diagnostic("element/wrong", Subject::RegulatoryElement(element.id), None);
                    wrong.finding =
                        ids.clone().fold(wrong.finding, |all, id| all.with(Subject::Lanelet(id), "lanelet"));
                    Some(wrong)
                }
                Some(_) => None,
            });
        found.collect()
    };
    // As it is, with all, without the wrong one, which is tried once more at the end.
    assert_eq!(counts(osm, judge), (15, 1, 4));
}

/// Nodes 1 to 4 want `a`. Where one of them has it, node 1 wants `b`, which is told of all four. The finding of node 4 names node 5,
/// too, which wants `c`: what follows does not wait until that is decided.
#[test]
fn a_group_is_kept_with_the_fix_of_what_it_brings() {
    let nodes: String = (1..=5).map(|id| format!("<node id=\"{id}\" lat=\"0\" lon=\"0\"/>\n")).collect();
    let osm = read(&format!("<osm version=\"0.6\">\n{nodes}</osm>\n"));
    let judge = |osm: &OsmData| {
        let has = |id: i64, key: &str| osm.node(id).unwrap().tags.has(key);
        let wants = |id: i64, key: &'static str, code: &str| diagnostic(code, Subject::Point(id), Some(set(id, key)));
        let mut found: Vec<Diagnostic> =
            (1..=4).filter(|&id| !has(id, "a")).map(|id| wants(id, "a", "node/a")).collect();
        for one in found.iter_mut().filter(|one| one.finding.subject == Subject::Point(4)) {
            one.finding = one.finding.clone().with(Subject::Point(5), "neighbour");
        }
        if !has(5, "c") {
            found.push(wants(5, "c", "node/c"));
        }
        if found.iter().filter(|one| one.code == "node/a").count() < 4 && !has(1, "b") {
            let mut group = diagnostic("group/b", Subject::Map, Some(set(1, "b")));
            group.finding = (1..=4).fold(group.finding, |all, id| all.with(Subject::Point(id), "node"));
            found.push(group);
        }
        found
    };
    // As it is, with all, and with what follows from it.
    assert_eq!(counts(osm, judge), (6, 0, 3));
}
