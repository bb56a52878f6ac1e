//! What was told wrongly of strangers' maps, and what of one mistake is told once.

use std::f64::consts::TAU;

use lanewright::diagnostic::{Diagnostic, Subject};
use lanewright::lanelet::from_osm;
use lanewright::osm::OsmData;
use lanewright::projection::Projector;
use lanewright::report::{Next, Report, Sources, TextStyle, text};

use super::strangers_maps::{Sheet, found};

const PAINT: &str = "type=line_thin subtype=solid lane_change=no";

fn codes(found: &[Diagnostic]) -> Vec<&str> {
    found.iter().map(|one| one.code.as_str()).collect()
}

/// The text of a check.
fn told(data: &OsmData, found: &[Diagnostic]) -> String {
    let (sources, loaded) = (Sources::new([]), from_osm(data, &Projector::Local));
    let next = Next { map: "map.osm", fixable: true, page: None };
    let mut out = Vec::new();
    text(&mut out, &Report::new(found, &sources, &loaded.map), &next, TextStyle::default()).unwrap();
    String::from_utf8(out).unwrap()
}

/// Three arcs of one ring that reach over each other by so many metres.
fn ring(over: f64) -> OsmData {
    let mut sheet = Sheet::default();
    for piece in 0..3 {
        let bounds = [8.25, 11.75].map(|radius: f64| {
            let angle = |step: i32| TAU * f64::from(piece) / 3.0 + (TAU / 3.0 + over / 10.0) * f64::from(step) / 12.0;
            let place = |step| [radius * angle(step).cos(), radius * angle(step).sin()];
            (0..=12).map(|step| sheet.nodes([place(step)])[0]).collect::<Vec<_>>()
        });
        sheet.road(&bounds[0], &bounds[1], "");
    }
    sheet.drawing.data()
}

#[test]
fn pieces_of_one_ring_are_no_intersection() {
    for over in [0.1, 0.5] {
        let data = ring(over);
        let found = found(&data);
        let codes = codes(&found);
        assert!(!codes.contains(&"vm-03-01/unmarked"), "{codes:?}");
        // That nothing joins them is what is told.
        assert!(over > 0.3 || codes.contains(&"health/near-miss"), "{codes:?}");
    }
}

#[test]
fn a_light_is_looked_at_where_its_stop_line_crosses_a_long_lanelet() {
    let mut sheet = Sheet::default();
    // Northward for 100 m, over the stop line, then to the left: the end is nearer to the line than the start is.
    let bend = |dx: f64| [[dx, -100.0], [dx, 0.0], [dx, 12.0 + dx], [-8.0, 20.0 + dx], [-30.0, 20.0 + dx]];
    let bounds = [0.0, 3.5].map(|dx| sheet.nodes(bend(dx))).map(|nodes| sheet.way(&nodes, "type=road_border"));
    let line = sheet.nodes([[0.0, 0.0], [3.5, 0.0]]);
    let line = sheet.way(&line, "type=stop_line");
    let mut light = |from: [f64; 2], to: [f64; 2]| {
        let ends = sheet.nodes([from, to]);
        sheet.way(&ends, "type=traffic_light subtype=red_yellow_green height=0.5")
    };
    let (facing, across) = (light([1.0, 30.0], [2.0, 30.0]), light([6.0, 9.0], [6.0, 10.0]));
    for (element, body) in [(3000, facing), (3001, across)] {
        let members = [("ref_line", line), ("refers", body)];
        sheet.drawing.relation(element, &members, "type=regulatory_element subtype=traffic_light");
    }
    let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
    let [left, right] = bounds;
    let ways = [("left", 'w', left), ("right", 'w', right)];
    let elements = [3000, 3001].map(|element| ("regulatory_element", 'r', element));
    sheet.drawing.members(2000, &[&ways[..], &elements].concat(), tags);
    let found = found(&sheet.drawing.data());
    let sides: Vec<_> = found.iter().filter(|one| one.code.starts_with("vm-04-02/")).collect();
    let sides: Vec<_> = sides.into_iter().map(|one| (one.code.as_str(), one.finding.subject)).collect();
    assert_eq!(sides, [("vm-04-02/sideways", Subject::LineString(across))]);
}

#[test]
fn nobody_asks_for_a_way_back_on_the_other_carriageway() {
    let mut sheet = Sheet::default();
    // Two carriageways 25 m apart, in one area.
    for (y, [x0, x1, x2, x3]) in [(0.0, [-60.0, 0.0, 20.0, 80.0]), (25.0, [80.0, 20.0, 0.0, -60.0])] {
        let side = if x1 > x0 { 3.5 } else { -3.5 };
        let [a, b, c, d] = [x0, x1, x2, x3].map(|x| sheet.nodes([[x, y + side], [x, y]]));
        for ([left, right], [next_left, next_right], tags) in
            [(a, b, ""), (b, c, "turn_direction=straight intersection_area=9000"), (c, d, "")]
        {
            sheet.road(&[left, next_left], &[right, next_right], tags);
        }
    }
    // A turn from the one road in to where the other leads back would be a movement of its own.
    let corners = sheet.nodes([[0.0, -5.0], [0.0, 30.0], [20.0, 30.0], [20.0, -5.0]]);
    sheet.drawing.way(9000, corners, "type=intersection_area area=yes");
    let found = found(&sheet.drawing.data());
    let missing: Vec<_> = found.iter().filter(|one| one.code == "vm-03-04/movement-missing").collect();
    let missing: Vec<_> = missing.into_iter().map(|one| &one.finding.message).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// Two lanes side by side of this subtype, and a third behind the first.
fn lanes(tags: &str) -> OsmData {
    let mut sheet = Sheet::default();
    let [high, middle, low] = [7.0, 3.5, 0.0].map(|y| sheet.nodes([[0.0, y], [60.0, y], [120.0, y]]));
    let bounds = [&high, &middle, &low].map(|line| sheet.way(&line[..2], PAINT));
    for pair in bounds.windows(2) {
        sheet.lanelet([pair[0], pair[1]], tags);
    }
    let next = [&high, &middle].map(|line| sheet.way(&line[1..], PAINT));
    sheet.lanelet(next, "subtype=road location=urban speed_limit=40");
    sheet.drawing.data()
}

#[test]
fn lanes_without_a_subtype_are_told_once() {
    for (tags, cause) in [
        ("location=urban speed_limit=40", "access/not-road"),
        ("subtype=highway location=urban speed_limit=40", "access/not-road"),
        ("subtype=raod participant:vehicle=yes location=urban speed_limit=40", "tag/value"),
    ] {
        let data = lanes(tags);
        let found = found(&data);
        let codes = codes(&found);
        assert!(codes.contains(&cause), "{tags}: {codes:?}");
        assert!(!codes.contains(&"vm-01-20/neighbours"), "{tags}: {codes:?}");
        // That roads follow them is counted under it.
        let told = told(&data, &found);
        assert!(codes.contains(&"vm-01-21/other-kind") && !told.contains("error[vm-01-21"), "{told}");
        assert!(told.contains("so: 1 error more follows from this"), "{told}");
    }
}

#[test]
fn one_way_on_both_sides_is_one_finding() {
    let mut sheet = Sheet::default();
    sheet.people_drive_on_the_right();
    let [left, right] = [3.5, 0.0].map(|y| sheet.nodes([[0.0, y], [40.0, y], [80.0, y], [120.0, y]]));
    for at in 0..3 {
        let bounds = [left, right].map(|line| sheet.way(&line[at..at + 2], "type=road_border"));
        let bounds = if at == 1 { [bounds[0]; 2] } else { bounds };
        sheet.lanelet(bounds, "subtype=road location=urban speed_limit=40");
    }
    let found = found(&sheet.drawing.data());
    let about = |one: &&Diagnostic| one.finding.message.contains("both the left and the right bound");
    assert_eq!(found.iter().filter(about).count(), 1);
    let codes = codes(&found);
    assert!(["health/narrow", "health/hole"].iter().all(|code| !codes.contains(code)), "{codes:?}");
}

#[test]
fn a_lane_drawn_twice_does_not_branch_off() {
    let mut sheet = Sheet::default();
    let [left, right] = [3.5, 0.0].map(|y| sheet.nodes([[0.0, y], [60.0, y], [120.0, y]]));
    let [first, next] = [0, 1].map(|at| [left, right].map(|line| sheet.way(&line[at..at + 2], "type=road_border")));
    sheet.lanelet(first, "subtype=road location=urban speed_limit=40 turn_direction=straight");
    for _ in 0..2 {
        sheet.lanelet(next, "subtype=road location=urban speed_limit=40");
    }
    let found = found(&sheet.drawing.data());
    let turn = found.iter().find(|one| one.code == "vm-03-01/turn-without-ia").unwrap();
    assert!(turn.finding.message.ends_with("but no lane crosses, joins or leaves it."), "{}", turn.finding.message);
}

#[test]
fn bounds_of_a_tight_turn_around_are_not_turned() {
    let mut sheet = Sheet::default();
    // The inner bound is a small hook, whose start lies nearer to the end of the outer bound than to its start.
    let left = [[0.0, 0.3], [-0.3, -0.3], [0.0, -0.4], [0.4, -0.35], [0.1, -0.1]];
    let right = [[0.4, -2.5], [2.4, -0.9], [2.5, 0.8], [1.1, 2.3], [-0.1, 2.6]];
    let [left, right] = [left, right].map(|bound| sheet.nodes(bound));
    sheet.road(&left, &right, "");
    let found = found(&sheet.drawing.data());
    assert!(!codes(&found).contains(&"load/align"), "{:?}", codes(&found));
}

#[test]
fn the_two_directions_of_a_bend_are_no_intersection() {
    let mut sheet = Sheet::default();
    // A right angle, whose middle is drawn twice, each time a little too far.
    let corner = |far: f64| {
        let turn = |step: i32| (f64::from(step) * TAU / 32.0).sin_cos();
        let bend = (0..=8).map(turn).map(|(sin, cos)| [(12.0 - far) * sin, 12.0 - (12.0 - far) * cos]);
        let straight = [[12.0 - far, 40.0]];
        [[-30.0, far]].into_iter().chain(bend).chain(straight).collect::<Vec<_>>()
    };
    let lines = [-3.5, -0.05, 0.05, 3.5].map(|far| corner(far).into_iter().map(|at| sheet.nodes([at])[0]).collect());
    let [outer, middle, other, inner]: [Vec<i64>; 4] = lines;
    sheet.road(&other, &outer, "");
    let back = |line: Vec<i64>| line.into_iter().rev().collect::<Vec<_>>();
    sheet.road(&back(middle), &back(inner), "");
    let found = found(&sheet.drawing.data());
    let codes = codes(&found);
    assert!(codes.contains(&"vm-07-08/overlap"), "{codes:?}");
    assert!(!["vm-03-01/unmarked", "vm-07-08/crossing"].iter().any(|code| codes.contains(code)), "{codes:?}");
}

#[test]
fn a_lane_for_both_directions_leads_on() {
    let mut sheet = Sheet::default();
    // East to west over a lane that is drawn from west to east, and on; another lane of the road goes on beside it.
    let [high, low] = [3.5, 0.0].map(|y| sheet.nodes([[120.0, y], [80.0, y], [40.0, y], [0.0, y]]));
    for at in [0, 2] {
        sheet.road(&low[at..at + 2], &high[at..at + 2], "");
    }
    let bounds = [[high[2], high[1]], [low[2], low[1]]].map(|line| sheet.way(&line, "type=road_border"));
    let members = [("left", bounds[0]), ("right", bounds[1])];
    let tags = "type=lanelet subtype=road location=urban speed_limit=40 one_way=";
    sheet.drawing.relation(2900, &members, &format!("{tags}no"));
    let codes_of = |data: &OsmData| found(data).into_iter().map(|one| one.code).collect::<Vec<_>>();
    let loose = ["health/gap", "health/hole", "health/dead-end", "health/unreachable", "health/head-on"];
    let said = codes_of(&sheet.drawing.data());
    assert!(said.iter().any(|code| code == "vm-01-01/one-way"), "{said:?}");
    assert!(!said.iter().any(|code| loose.contains(&code.as_str())), "{said:?}");
    // In one direction, it runs against both.
    let xml = sheet.drawing.xml().replace("k='one_way' v='no'", "k='one_way' v='yes'");
    let said = codes_of(&crate::common::drawing::osm(xml));
    assert!(said.iter().any(|code| code == "health/head-on"), "{said:?}");
}

#[test]
fn what_follows_from_a_bound_of_no_length_is_counted_under_it() {
    let mut sheet = Sheet::default();
    // The first node of the left bound lies where its second one lies.
    let left = sheet.nodes([[40.0, 3.5], [40.0, 3.5], [80.0, 3.5]]);
    let right = sheet.nodes([[0.0, 0.0], [40.0, 0.0], [80.0, 0.0]]);
    // Drawn against the direction of travel, which the loader cannot know of a bound without length.
    for at in 0..2 {
        sheet.road(&[left[at + 1], left[at]], &[right[at + 1], right[at]], "");
    }
    let data = sheet.drawing.data();
    let found = found(&data);
    assert!(
        ["parts/point-bound", "health/near-miss"].iter().all(|code| codes(&found).contains(code)),
        "{:?}",
        codes(&found)
    );
    let told = told(&data, &found);
    assert!(told.contains("error[parts/point-bound]") && !told.contains("[health/near-miss]"), "{told}");
    assert!(told.contains("so: 1 error more follows from this"), "{told}");
}

/// A road of two lanes in three pieces, and a ramp of one piece that lies on its right lane and leaves it little by little. It begins where
/// that lane begins, or beside its right end.
fn ramp(forks: bool) -> OsmData {
    let mut sheet = Sheet::default();
    let tags = "subtype=road location=urban speed_limit=40";
    let rows = [6.5, 3.25, 0.0].map(|y| sheet.nodes([0.0, 5.0, 10.0, 25.0].map(|x| [x, y])));
    let paint = ["type=road_border", "type=line_thin subtype=dashed lane_change=yes", "type=virtual lane_change=no"];
    for piece in 0..3 {
        let [outer, between, inner] = [0, 1, 2].map(|row| sheet.way(&rows[row][piece..=piece + 1], paint[row]));
        sheet.lanelet([outer, between], tags);
        sheet.lanelet([between, inner], tags);
    }
    let own = sheet.nodes([[0.0, -0.1]])[0];
    let left = sheet.nodes([[8.0, 3.22], [15.0, 3.1], [25.0, 2.7]]);
    let right = sheet.nodes([[8.0, -0.04], [15.0, -0.2], [25.0, -0.7]]);
    let begin = [rows[1][0], if forks { rows[2][0] } else { own }];
    let left = sheet.way(&[&begin[..1], &left].concat(), PAINT);
    let right = sheet.way(&[&begin[1..], &right].concat(), "type=road_border");
    sheet.lanelet([left, right], tags);
    sheet.drawing.data()
}

#[test]
fn a_ramp_does_not_lie_beside_the_neighbour_of_the_lane_that_it_leaves() {
    let told = |forks: bool| codes(&found(&ramp(forks))).contains(&"vm-01-03/partly-shared");
    assert_eq!([true, false].map(told), [false, true]);
}
