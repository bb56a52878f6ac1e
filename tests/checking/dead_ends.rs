//! Dead ends: a lanelet is missing in one direction of a road, while the other direction is whole.

use lanewright::lanelet::from_osm;
use lanewright::osm::OsmData;
use lanewright::projection::Projector;
use lanewright::settings::Settings;

use crate::common::drawing::Drawing;
use crate::common::judging::judge;

/// Three parallel two-way roads, each in five pieces of 40 m, without the lanelets given by row, lane and number.
fn roads(without: &[(i64, i64, i64)]) -> OsmData {
    let mut drawing = Drawing::default();
    let node = |row: i64, line: i64, at: i64| 1000 * row + 100 * line + at + 1;
    let way = |row: i64, line: i64, at: i64| 10_000 + node(row, line, at);
    for row in 0..3 {
        for line in 0..3 {
            for at in 0..6 {
                let tags = format!("local_x={} local_y={} ele=5", 40 * at, 80 * row + 3 * line);
                drawing.node(node(row, line, at), [""; 2], &tags);
            }
            let kind = if line == 1 { "type=line_thin subtype=solid" } else { "type=road_border subtype=solid" };
            for at in 0..5 {
                drawing.way(way(row, line, at), [at, at + 1].map(|at| node(row, line, at)), kind);
            }
        }
        for lane in 0..2 {
            for at in (0..5).filter(|&at| !without.contains(&(row, lane, at))) {
                // On the right: eastward below the middle line, westward above it.
                let bounds = [("left", way(row, 1, at)), ("right", way(row, 2 * lane, at))];
                let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
                drawing.relation(20_000 + node(row, lane, at), &bounds, tags);
            }
        }
    }
    drawing.data()
}

/// The findings about dead ends, unreachable lanes and gaps.
fn ends(without: &[(i64, i64, i64)]) -> Vec<String> {
    let found = judge(&from_osm(&roads(without), &Projector::Local), &Settings::default());
    let about = |code: &&str| matches!(*code, "health/dead-end" | "health/unreachable" | "health/gap");
    found.iter().map(|one| one.code.as_str()).filter(about).map(str::to_owned).collect()
}

#[test]
fn whole_roads_have_no_loose_ends() {
    assert_eq!(ends(&[]), Vec::<String>::new());
}

#[test]
fn a_missing_piece_of_one_direction_is_a_dead_end() {
    for lane in 0..2 {
        assert_eq!(ends(&[(1, lane, 2)]), ["health/dead-end", "health/unreachable"], "lane {lane}");
    }
}

#[test]
fn where_both_directions_end_people_turn() {
    assert_eq!(ends(&[(1, 0, 2), (1, 1, 2)]), Vec::<String>::new());
}
