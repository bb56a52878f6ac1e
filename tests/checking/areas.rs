//! Areas as they are read, counted, compared, drawn and shown.

use lanewright::diagnostic::Subject;
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{AreaId, LaneletMap, LineStringId, PointId};
use lanewright::report::diff::Diff;
use lanewright::report::draw::{self, Options};
use lanewright::report::stats::Stats;
use lanewright::settings::Settings;

use crate::common::judging::load;
use crate::common::root;

fn map(name: &str) -> LaneletMap {
    load(&root().join(format!("tests/rules/area/{name}.osm"))).1.map
}

#[test]
fn the_outline_of_an_area_runs_clockwise_whatever_the_order_of_its_lines() {
    let ids = |ids: &[i64]| ids.iter().map(|&id| PointId(id)).collect::<Vec<_>>();
    let good = map("good");
    let area = good.areas.get(AreaId(301)).unwrap();
    assert_eq!(area.points, ids(&[3, 4, 6, 5]));
    let lines: Vec<(LineStringId, bool)> = area.outer.iter().map(|bound| (bound.line, bound.inverted)).collect();
    assert_eq!(lines, [105, 106, 107, 108].map(|id| (LineStringId(id), false)));
    assert_eq!(area.holes, 0);
    assert_eq!(map("bad-hole").areas.get(AreaId(301)).unwrap().holes, 1);

    // The members in another order, one line turned around, and the first one against the clock.
    let path = root().join("tests/rules/area/good.osm");
    let text = std::fs::read_to_string(&path).unwrap();
    let member = |id: i64| format!("    <member type=\"way\" role=\"outer\" ref=\"{id}\"/>\n");
    let listed: String = [105, 106, 107, 108].map(member).concat();
    let turned = text
        .replace(&listed, &[107, 105, 108, 106].map(member).concat())
        .replace("<nd ref=\"6\"/><nd ref=\"5\"/>", "<nd ref=\"5\"/><nd ref=\"6\"/>");
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("turned.osm");
    std::fs::write(&other, turned).unwrap();
    let (_, loaded) = load(&other);
    let area = loaded.map.areas.get(AreaId(301)).unwrap();
    let start = area.points.iter().position(|id| *id == PointId(3)).unwrap();
    let mut points = area.points.clone();
    points.rotate_left(start);
    assert_eq!(points, ids(&[3, 4, 6, 5]));
    let inverted: Vec<i64> = area.outer.iter().filter(|bound| bound.inverted).map(|bound| bound.line.0).collect();
    assert_eq!(inverted, [107]);
}

#[test]
fn areas_are_counted_and_compared() {
    let (good, settings) = (map("good"), Settings::default());
    let stats = Stats::of(&MapIndex::new(&good, &[], &settings));
    assert_eq!(stats.primitives["areas"], 1);
    let count = |what: &str| stats.content.iter().find(|one| one.what == what).unwrap().count;
    assert_eq!((count("areas to cross"), count("lanes to reverse in")), (1, 2));

    let told = |name: &str| -> Vec<Subject> {
        let diff = Diff::between(&good, &map(name), 0.001);
        diff.changes.into_iter().map(|change| change.subject).collect()
    };
    assert_eq!(told("bad-closed"), [Subject::Relation(301)]);
    assert!(told("bad-concave").contains(&Subject::Relation(301)));
    assert!(!told("bad-shut").contains(&Subject::Relation(301)));
}

#[test]
fn areas_that_vehicles_may_cross_are_drawn_apart_from_others() {
    let drawn = |name: &str| draw::svg(&map(name), &[], &Options::default()).unwrap();
    assert!(drawn("good").contains("class=\"passage\""));
    let closed = drawn("bad-closed");
    assert!(!closed.contains("passage") && closed.contains("freespace 301"));
}
