//! Maps that differ in one thing each, and what is said of them.

use super::{Diff, Fact, Kind, Sign};
use crate::diagnostic::Subject;
use crate::geometry::Point as PlanePoint;
use crate::lanelet::{
    Attributes, Bound, Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Member, Point, PointId,
    RegulatoryElement, RegulatoryElementId, Target,
};

fn tags(pairs: &[(&str, &str)]) -> Attributes {
    let mut tags = Attributes::new();
    for (key, value) in pairs {
        tags.push(*key, *value);
    }
    tags
}

/// Lanelets 100 and 200, one after the other, each 10 m long: nodes 1, 2, 3 on the right, 4, 5, 6 on the left.
fn map() -> LaneletMap {
    let mut map = LaneletMap::default();
    for id in 1..=6 {
        let position = PlanePoint::new(f64::from((id - 1) % 3) * 10.0, if id > 3 { 3.0 } else { 0.0 });
        let id = PointId(i64::from(id));
        map.points.insert(Point::new(id, position, None));
    }
    for (id, points) in [(10, [1, 2]), (11, [4, 5]), (20, [2, 3]), (21, [5, 6])] {
        let points = points.map(PointId).to_vec();
        let attributes = tags(&[("type", "line_thin"), ("subtype", "solid")]);
        map.linestrings.insert(LineString { id: LineStringId(id), points, attributes, span: None });
    }
    for (id, right, left) in [(100, 10, 11), (200, 20, 21)] {
        let bound = |line| Bound { line: LineStringId(line), inverted: false };
        map.lanelets.insert(Lanelet {
            id: LaneletId(id),
            left: bound(left),
            right: bound(right),
            centerline: None,
            regulatory_elements: Vec::new(),
            attributes: tags(&[("type", "lanelet"), ("subtype", "road"), ("speed_limit", "50")]),
            span: None,
        });
    }
    map
}

fn facts(diff: &Diff, subject: Subject) -> Vec<Fact> {
    diff.changes.iter().find(|change| change.subject == subject).map_or(Vec::new(), |change| change.facts.clone())
}

#[test]
fn a_map_does_not_differ_from_itself() {
    let diff = Diff::between(&map(), &map(), 0.001);
    assert!(diff.is_empty());
    assert_eq!(diff.totals["lanelets"].same, 2);
    assert_eq!(diff.text(), "no difference\n");
}

#[test]
fn a_tag_is_told_with_both_values() {
    let mut new = map();
    new.lanelets.get_mut(LaneletId(100)).unwrap().attributes.set("speed_limit", "30");
    let diff = Diff::between(&map(), &new, 0.001);
    assert_eq!(
        diff.text(),
        "lanelets: 0 added, 0 removed, 1 changed, 1 the same\n~ lanelet 100: speed_limit from `50` to `30`\n"
    );
}

#[test]
fn a_point_that_moves_moves_what_is_made_of_it() {
    let mut new = map();
    new.points.get_mut(PointId(5)).unwrap().position.y += 0.25;
    let diff = Diff::between(&map(), &new, 0.001);
    let moved = |subject| facts(&diff, subject).iter().find_map(Fact::metres).unwrap_or(0.0);
    assert!((moved(Subject::Point(5)) - 0.25).abs() < 1e-9);
    assert!((moved(Subject::LineString(11)) - 0.25).abs() < 1e-9);
    assert!((moved(Subject::Lanelet(200)) - 0.25).abs() < 1e-9);
    assert_eq!(moved(Subject::LineString(10)), 0.0);
    assert!(Diff::between(&map(), &new, 0.3).is_empty(), "within the tolerance nothing moved");
}

#[test]
fn lanelets_that_no_longer_share_their_end_no_longer_follow() {
    let mut new = map();
    let mut copy = new.points.get(PointId(2)).unwrap().clone();
    copy.id = PointId(7);
    new.points.insert(copy);
    new.linestrings.get_mut(LineStringId(20)).unwrap().points[0] = PointId(7);
    let diff = Diff::between(&map(), &new, 0.001);
    assert_eq!(facts(&diff, Subject::Lanelet(100)), [Fact::LeadsTo { sign: Sign::Removed, id: 200 }]);
    assert_eq!(facts(&diff, Subject::LineString(20)), [Fact::Points { added: 1, removed: 1 }]);
}

#[test]
fn rights_of_way_are_told_of_the_lanelet_that_has_them() {
    let mut new = map();
    let member = |role: &str, id| Member { role: role.into(), target: Target::Lanelet(LaneletId(id)) };
    new.regulatory_elements.insert(RegulatoryElement {
        id: RegulatoryElementId(300),
        subtype: "right_of_way".into(),
        members: vec![member("right_of_way", 100), member("yield", 200)],
        attributes: tags(&[("type", "regulatory_element"), ("subtype", "right_of_way")]),
        span: None,
    });
    new.lanelets.get_mut(LaneletId(100)).unwrap().regulatory_elements.push(RegulatoryElementId(300));
    let diff = Diff::between(&map(), &new, 0.001);
    assert_eq!(
        facts(&diff, Subject::Lanelet(100)),
        [Fact::Element { sign: Sign::Added, id: 300 }, Fact::RightOfWay { sign: Sign::Added, over: 200 }]
    );
    let back = Diff::between(&new, &map(), 0.001);
    let gone = back.changes.iter().find(|change| change.subject == Subject::RegulatoryElement(300)).unwrap();
    assert_eq!((gone.change, gone.line()), (Kind::Removed, "- regulatory element 300: right_of_way".to_owned()));
}

#[test]
fn what_was_cut_has_not_moved() {
    let mut new = map();
    for id in [3, 6] {
        let id = PointId(id);
        let position = new.points.get(id).unwrap().position - nalgebra::Vector2::new(4.0, 0.0);
        new.points.insert(Point::new(id, position, None));
    }
    let diff = Diff::between(&map(), &new, 0.001);
    for subject in [Subject::Lanelet(200), Subject::LineString(20), Subject::LineString(21)] {
        let facts = facts(&diff, subject);
        assert!(matches!(facts.as_slice(), [Fact::Longer { by }] if (by + 4.0).abs() < 1e-9), "{subject}: {facts:?}");
    }
    assert_eq!(facts(&diff, Subject::Lanelet(100)), []);
    let back = Diff::between(&new, &map(), 0.001);
    assert!(back.text().contains("~ lanelet 200: longer by 4.000 m"), "{}", back.text());
    // Cut, and pushed aside by a hand's width.
    for id in [2, 3] {
        let id = PointId(id);
        let position = new.points.get(id).unwrap().position - nalgebra::Vector2::new(0.0, 0.1);
        new.points.insert(Point::new(id, position, None));
    }
    let facts = facts(&Diff::between(&map(), &new, 0.001), Subject::LineString(20));
    let [Fact::Longer { by: longer }, Fact::Moved { by: moved }] = facts[..] else { panic!("{facts:?}") };
    assert!((longer + 4.0).abs() < 0.01 && (moved - 0.1).abs() < 0.01, "{facts:?}");
}
