//! Dead ends: a lanelet is missing in one direction of a road, while the other direction is whole.

use lanewright::lanelet::from_osm;
use lanewright::osm::OsmData;
use lanewright::projection::Projector;
use lanewright::settings::Settings;

use crate::common::drawing::Drawing;
use crate::common::judging::judge;

/// Three parallel two-way roads, each in five pieces of 40 m, without the lanelets given by row, lane and number, with or without
/// the ways that only they use.
fn roads(without: &[(i64, i64, i64)], ways_stay: bool) -> OsmData {
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
            let is_used = |at: &i64| {
                let lanes = (0..2).filter(|lane| line == 1 || line == 2 * lane);
                ways_stay || lanes.into_iter().any(|lane| !without.contains(&(row, lane, *at)))
            };
            for at in (0..5).filter(is_used) {
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

/// The findings about dead ends, unreachable lanes, gaps and holes. That the three roads are apart is none of them.
fn ends(without: &[(i64, i64, i64)], ways_stay: bool) -> Vec<String> {
    let found = judge(&from_osm(&roads(without, ways_stay), &Projector::Local), &Settings::default());
    let about = |code: &&str| matches!(*code, "health/dead-end" | "health/unreachable" | "health/gap" | "health/hole");
    found.iter().map(|one| one.code.as_str()).filter(about).map(str::to_owned).collect()
}

#[test]
fn whole_roads_have_no_loose_ends() {
    assert_eq!(ends(&[], true), Vec::<String>::new());
}

#[test]
fn a_missing_piece_between_two_ways_is_a_hole() {
    for lane in 0..2 {
        // In the middle, and at either edge of the map.
        for at in [0, 2, 4] {
            assert_eq!(ends(&[(1, lane, at)], true), ["health/hole"], "lane {lane}, piece {at}");
        }
    }
    assert_eq!(ends(&[(1, 0, 2), (1, 1, 2)], true), ["health/hole", "health/hole"], "both directions");
    assert_eq!(ends(&[(1, 0, 2), (1, 0, 3)], true), ["health/hole", "health/hole"], "two pieces in a row");
}

#[test]
fn a_missing_piece_without_its_way_is_a_gap() {
    for lane in 0..2 {
        assert_eq!(ends(&[(1, lane, 2)], false), ["health/gap"], "lane {lane}");
    }
}

#[test]
fn where_both_directions_end_people_turn() {
    assert_eq!(ends(&[(1, 0, 2), (1, 1, 2)], false), Vec::<String>::new());
}

/// One lane in pieces of 10 m from 0 on, each with ways of its own; a piece is (first, last) station and the sides left and right.
fn lane(pieces: &[[f64; 2]], sides: impl Fn(f64) -> [f64; 2]) -> Vec<String> {
    let mut drawing = Drawing::default();
    for (at, piece) in (0_i64..).zip(pieces) {
        for side in [0_usize, 1] {
            let id = 100 * (at + 1) + 10 * side as i64;
            for (end, x) in (0_i64..).zip(piece) {
                // Pieces that touch share their nodes.
                let shared = at > 0 && end == 0 && pieces[at as usize - 1][1] == *x;
                if !shared {
                    let tags = format!("local_x={x} local_y={} ele=5", sides(*x)[side]);
                    drawing.node(id + end, [""; 2], &tags);
                }
            }
            let first = if at > 0 && pieces[at as usize - 1][1] == piece[0] { id - 99 } else { id };
            drawing.way(1000 + id, [first, id + 1], "type=line_thin subtype=solid");
        }
        let id = 1000 + 100 * (at + 1);
        let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
        drawing.relation(10_000 + at, &[("left", id), ("right", id + 10)], tags);
    }
    let found = judge(&from_osm(&drawing.data(), &Projector::Local), &Settings::default());
    let own = found.into_iter().map(|one| one.code).filter(|code| code.starts_with("health/"));
    own.collect()
}

#[test]
fn a_small_map_is_judged_like_a_large_one() {
    let wide = |_| [3.0, 0.0];
    assert_eq!(lane(&[[0.0, 20.0], [20.0, 40.0]], wide), Vec::<String>::new());
    assert_eq!(lane(&[[0.0, 20.0], [40.0, 60.0]], wide), ["health/gap"]);
    assert_eq!(lane(&[[0.0, 20.0], [120.0, 140.0]], wide), Vec::<String>::new(), "two maps in one");
    assert_eq!(
        lane(&[[0.0, 20.0], [40.0, 60.0]], |x| if x < 30.0 { [3.0, 0.0] } else { [9.0, 6.0] }),
        Vec::<String>::new(),
        "another road"
    );
}

#[test]
fn no_car_fits_into_a_narrow_lane() {
    assert_eq!(lane(&[[0.0, 40.0]], |_| [0.5, 0.0]), ["health/narrow"]);
    assert_eq!(lane(&[[0.0, 20.0], [20.0, 40.0]], |x| [3.0 - 0.07 * x, 0.0]), ["health/narrow"]);
    assert_eq!(lane(&[[0.0, 40.0]], |_| [1.6, 0.0]), Vec::<String>::new());
}
