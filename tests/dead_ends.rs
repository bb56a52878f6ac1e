//! A piece that is missing from one lane of a road, while the other direction passes by.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod common;

use std::fmt::Write;

use common::judge;
use lanewright::lanelet::from_osm;
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::Projector;
use lanewright::settings::Settings;

/// Three two-way roads abreast, each in five pieces of 40 m; without the pieces that are named by row, lane and number.
fn roads(without: &[(i64, i64, i64)]) -> String {
    let mut text = String::from("<osm version=\"0.6\"><MetaInfo format_version=\"2\"/>\n");
    let node = |row: i64, line: i64, at: i64| 1000 * row + 100 * line + at + 1;
    let way = |row: i64, line: i64, at: i64| 10_000 + node(row, line, at);
    for row in 0..3 {
        for line in 0..3 {
            for at in 0..6 {
                let (x, y) = (40 * at, 80 * row + 3 * line);
                let tags =
                    format!("<tag k=\"local_x\" v=\"{x}\"/><tag k=\"local_y\" v=\"{y}\"/><tag k=\"ele\" v=\"5\"/>");
                writeln!(text, "<node id=\"{}\" lat=\"\" lon=\"\">{tags}</node>", node(row, line, at)).unwrap();
            }
            for at in 0..5 {
                let nodes = [at, at + 1].map(|at| format!("<nd ref=\"{}\"/>", node(row, line, at))).concat();
                let kind = if line == 1 { "line_thin" } else { "road_border" };
                let tags = format!("<tag k=\"type\" v=\"{kind}\"/><tag k=\"subtype\" v=\"solid\"/>");
                writeln!(text, "<way id=\"{}\">{nodes}{tags}</way>", way(row, line, at)).unwrap();
            }
        }
        for lane in 0..2 {
            for at in (0..5).filter(|&at| !without.contains(&(row, lane, at))) {
                // On the right: eastward below the middle line, westward above it.
                let bounds = format!(
                    "<member type=\"way\" role=\"left\" ref=\"{}\"/><member type=\"way\" role=\"right\" ref=\"{}\"/>",
                    way(row, 1, at),
                    way(row, 2 * lane, at)
                );
                let tags = ["type=lanelet", "subtype=road", "location=urban", "one_way=yes", "speed_limit=40"]
                    .map(|tag| tag.split_once('=').unwrap())
                    .map(|(key, value)| format!("<tag k=\"{key}\" v=\"{value}\"/>"))
                    .concat();
                writeln!(text, "<relation id=\"{}\">{bounds}{tags}</relation>", 20_000 + node(row, lane, at)).unwrap();
            }
        }
    }
    text + "</osm>\n"
}

/// What is said of loose ends.
fn ends(without: &[(i64, i64, i64)]) -> Vec<String> {
    let mut data = OsmData::default();
    read_bytes(&mut data, "map.osm", roads(without).into_bytes()).unwrap();
    let found = judge(&from_osm(&data, &Projector::Local), &Settings::default());
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
