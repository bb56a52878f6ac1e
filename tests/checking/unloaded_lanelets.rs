//! Lanelets that do not load because a bound is cut into several ways: they are told of, and nothing around them is missing.

use lanewright::diagnostic::Diagnostic;
use lanewright::osm::{ElementKind, Member, OsmData};

use super::strangers_maps::{Sheet, found, mended};

/// The middle lanelet of the road.
const CUT: i64 = 2002;

/// A road of three lanelets, 120 m long. The left bound of the middle one is cut into two ways that are painted as told, the second
/// of them drawn backwards.
fn road(is_cut: bool, paints: [&str; 2]) -> OsmData {
    let mut sheet = Sheet::default();
    let rows = [3.5, 0.0].map(|y| sheet.nodes([0.0, 40.0, 60.0, 80.0, 120.0].map(|x| [x, y])));
    let [left, right] = &rows;
    sheet.road(&left[..2], &right[..2], "");
    let middle = sheet.way(&right[1..4], "type=road_border");
    let pieces = match is_cut {
        true => [vec![left[1], left[2]], vec![left[3], left[2]]],
        false => [left[1..4].to_vec(), vec![left[3], left[2]]],
    };
    let [first, second] = [0, 1].map(|at| sheet.way(&pieces[at], paints[at]));
    sheet.lanelet([first, middle], "subtype=road location=urban speed_limit=40");
    sheet.road(&left[3..], &right[3..], "");
    let mut data = sheet.drawing.data();
    if is_cut {
        let relation = data.relations.iter_mut().find(|one| one.id == CUT).unwrap();
        relation.members.push(Member { kind: ElementKind::Way, id: second, role: "left".into() });
    }
    data
}

fn codes(found: &[Diagnostic]) -> Vec<&str> {
    found.iter().map(|one| one.code.as_str()).filter(|code| !code.starts_with("node/")).collect()
}

#[test]
fn nothing_is_missing_where_a_lanelet_did_not_load() {
    let whole = found(&road(false, ["type=road_border"; 2]));
    let found = found(&road(true, ["type=road_border"; 2]));
    let more: Vec<&str> = codes(&found).into_iter().filter(|code| !codes(&whole).contains(code)).collect();
    assert_eq!(more, ["load/bound-count"]);
    let told = found.iter().find(|one| one.code == "load/bound-count").unwrap();
    assert!(told.finding.message.ends_with("follow each other end to end."), "{}", told.finding.message);
}

#[test]
fn ways_that_are_painted_alike_become_one() {
    let mended = mended(road(true, ["type=road_border"; 2]));
    assert!(!codes(&mended.left).contains(&"load/bound-count"), "{:?} {:?}", codes(&mended.left), mended.refused);
    let relation = mended.osm.relations.iter().find(|one| one.id == CUT).unwrap();
    let left: Vec<_> = relation.members.iter().filter(|member| member.role == "left").collect();
    let [way] = left[..] else { panic!("{left:?}") };
    assert_eq!(mended.osm.ways.iter().find(|one| one.id == way.id).unwrap().nodes.len(), 3);
}

#[test]
fn ways_that_are_painted_otherwise_stay() {
    let paints = ["type=line_thin subtype=dashed", "type=line_thin subtype=solid"];
    let mended = mended(road(true, paints));
    assert!(codes(&mended.left).contains(&"load/bound-count"), "{:?}", codes(&mended.left));
}
