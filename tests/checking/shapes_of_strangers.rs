//! What was told wrongly of stubs, turns, rings, outlines, centre lines and heights on strangers' maps, or mended to their harm.

use lanewright::diagnostic::{Diagnostic, Severity, Subject};
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::OsmData;
use lanewright::projection::Projector;
use lanewright::settings::Settings;

use super::strangers_maps::{Sheet, found, mended};

const PAINT: &str = "type=line_thin subtype=solid lane_change=no";

/// The messages of a code.
fn of_code<'f>(found: &'f [Diagnostic], code: &str) -> Vec<&'f str> {
    found.iter().filter(|one| one.code == code).map(|one| one.finding.message.as_str()).collect()
}

/// From one lane to another over 0.2 m, where a third lanelet lies.
#[test]
fn the_ends_of_a_stub_are_not_to_be_one() {
    let map = |with_stub: bool| {
        let mut sheet = Sheet::default();
        let [a, b, c, d] = [0.0, 40.0, 40.2, 80.0].map(|x| sheet.nodes([[x, 3.5], [x, 0.0]]));
        sheet.road(&[a[0], b[0]], &[a[1], b[1]], "");
        if with_stub {
            sheet.road(&[b[0], c[0]], &[b[1], c[1]], "");
        }
        // The stub leads to the second one; the first should lead to the third, which begins where the stub ends, at the side of it.
        sheet.road(&[c[0], d[0]], &[c[1], d[1]], "");
        let aside = sheet.nodes([[80.0, 12.0], [80.0, 8.5]]);
        let beside = sheet.nodes([[40.2, 3.6]]);
        sheet.road(&[beside[0], aside[0]], &[c[1], aside[1]], "");
        found(&sheet.drawing.data())
    };
    assert!(!of_code(&map(false), "health/near-miss").is_empty());
    let told = map(true);
    let of_stub: Vec<&str> = of_code(&told, "health/near-miss");
    assert!(of_stub.iter().all(|message| !message.contains("2001")), "{of_stub:?}");
}

/// A turn out of a street, beside an oncoming lane that is shorter.
#[test]
fn a_turn_is_not_cut_where_oncoming_lanes_are() {
    let map = |tags: &str| {
        let mut sheet = Sheet::default();
        sheet.people_drive_on_the_right();
        let [low, middle, oncoming, high] =
            [0.0, 3.5, 3.52, 7.0].map(|y| sheet.nodes([0.0, 10.0, 20.0, 30.0].map(|x| [x, y])));
        let right = sheet.way(&low, PAINT);
        let left = sheet.way(&middle, PAINT);
        sheet.lanelet([left, right], &format!("subtype=road location=urban speed_limit=40 {tags}"));
        let own = sheet.way(&[oncoming[2], oncoming[1], oncoming[0]], PAINT);
        let outer = sheet.way(&[high[2], high[1], high[0]], PAINT);
        sheet.lanelet([own, outer], "subtype=road location=urban speed_limit=40");
        of_code(&found(&sheet.drawing.data()), "vm-01-04/cut-apart").len()
    };
    assert_eq!([map(""), map("turn_direction=right")], [1, 0]);
}

/// The entry of a roundabout that meets the ring almost head-on, where the element of the ring says that the entry waits.
#[test]
fn an_entry_waits_for_the_ring_where_the_map_says_so() {
    let map = |with_element: bool| {
        let mut sheet = Sheet::default();
        sheet.people_drive_on_the_right();
        let polar =
            |radius: f64, degrees: f64| [radius * degrees.to_radians().cos(), radius * degrees.to_radians().sin()];
        let join = sheet.nodes([polar(18.0, 200.0), polar(22.0, 200.0)]);
        let ring: Vec<[i64; 2]> = (0..7)
            .map(|i| sheet.nodes([polar(18.0, 130.0 + 10.0 * f64::from(i)), polar(22.0, 130.0 + 10.0 * f64::from(i))]))
            .collect();
        let [inner, outer] =
            [0, 1].map(|side| ring.iter().map(|pair| pair[side]).chain([join[side]]).collect::<Vec<_>>());
        // The entry swings to the right into the ring, around a middle south of it.
        let middle = [-30.9, -11.2];
        let arc = |radius: f64, degrees: f64| {
            let [x, y] = polar(radius, degrees);
            [middle[0] + x, middle[1] + y]
        };
        let entry: Vec<[i64; 2]> =
            [115.0, 95.0, 75.0, 55.0, 38.0].map(|at| sheet.nodes([arc(12.9, at), arc(9.0, at)])).to_vec();
        let [left, right] =
            [0, 1].map(|side| entry.iter().map(|pair| pair[side]).chain([join[side]]).collect::<Vec<_>>());
        let bounds = [&inner, &outer].map(|nodes| sheet.way(nodes, "type=road_border"));
        let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
        let element: &[(&str, char, i64)] = if with_element { &[("regulatory_element", 'r', 3000)] } else { &[] };
        let ways = [("left", 'w', bounds[0]), ("right", 'w', bounds[1])];
        sheet.drawing.members(2500, &[&ways[..], element].concat(), &format!("{tags} turn_direction=straight"));
        let entry = sheet.road(&left, &right, "turn_direction=right");
        let waits = [("right_of_way", 'r', 2500), ("yield", 'r', entry)];
        if with_element {
            sheet.drawing.members(3000, &waits, "type=regulatory_element subtype=right_of_way");
        }
        (sheet.drawing.data(), found(&sheet.drawing.data()))
    };
    let (data, told) = map(true);
    for code in ["vm-03-11/yield-unsafe", "vm-03-11/re-missing", "vm-03-11/mutual"] {
        assert!(of_code(&told, code).is_empty(), "{code}: {:?}", of_code(&told, code));
    }
    assert!(mended(data).osm.relations.iter().any(|relation| relation.id == 3000));
    // Without the element, the usual rule holds for the two.
    assert_eq!(of_code(&map(false).1, "vm-03-11/re-missing").len(), 1);
}

/// A stop line that is drawn around its paint, on the corners of the lane.
#[test]
fn an_outline_of_paint_is_told_as_one_and_moves_no_corner() {
    let mut sheet = Sheet::default();
    let [a, b, c] = [0.0, 40.0, 80.0].map(|x| sheet.nodes([[x, 3.5], [x, 0.0]]));
    let far = sheet.nodes([[40.6, 0.0], [40.6, 3.5]]);
    let light = sheet.nodes([[60.0, 1.0], [60.0, 2.0]]);
    sheet.road(&[a[0], b[0]], &[a[1], b[1]], "");
    let line = sheet.way(&[b[0], b[1], far[0], far[1]], "type=stop_line");
    let body = sheet.way(&light, "type=traffic_light subtype=red_yellow_green height=0.5");
    let bounds = [0, 1].map(|side| sheet.way(&[b[side], c[side]], "type=road_border"));
    let ways = [("left", 'w', bounds[0]), ("right", 'w', bounds[1]), ("regulatory_element", 'r', 3000)];
    let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
    sheet.drawing.members(2500, &ways, tags);
    let members = [("ref_line", line), ("refers", body)];
    sheet.drawing.relation(3000, &members, "type=regulatory_element subtype=traffic_light");
    let data = sheet.drawing.data();
    let told = found(&data);
    assert!(of_code(&told, "vm-02-04/off-lane").is_empty());
    let bent = of_code(&told, "vm-02-01/bent");
    assert!(bent.len() == 1 && bent[0].contains("the outline of its paint"), "{bent:?}");
    let before = from_osm(&data, &Projector::Local).map;
    let after = from_osm(&mended(data).osm, &Projector::Local).map;
    for point in b {
        let id = lanewright::lanelet::PointId(point);
        assert_eq!(before.points.get(id).unwrap().position, after.points.get(id).unwrap().position);
    }
}

#[test]
fn no_type_makes_a_centre_line_a_border() {
    let map = |kind: &str| {
        let mut sheet = Sheet::default();
        let [left, middle, right] = [3.5, 1.75, 0.0].map(|y| sheet.nodes([[0.0, y], [40.0, y]]));
        let [left, right] = [left, right].map(|nodes| sheet.way(&nodes, "type=road_border"));
        let middle = sheet.way(&middle, &format!("type={kind}"));
        let tags = "type=lanelet subtype=road location=urban one_way=yes speed_limit=40";
        sheet.drawing.relation(2500, &[("left", left), ("right", right), ("centerline", middle)], tags);
        of_code(&found(&sheet.drawing.data()), "tag/value").len()
    };
    assert_eq!([map("road"), map("centreline"), map("centerline")], [0, 1, 0]);
}

/// A road of lanelets whose points have these tags.
fn road(pieces: i32, tags: impl Fn(i32) -> String) -> OsmData {
    let mut sheet = Sheet::default();
    let mut id = 0;
    let mut rows = [Vec::new(), Vec::new()];
    for at in 0..=pieces {
        for (row, y) in rows.iter_mut().zip([3.5, 0.0]) {
            id += 1;
            let x = f64::from(20 * at);
            sheet.drawing.node(id, [""; 2], &format!("local_x={x} local_y={y} {}", tags(at)));
            row.push(id);
        }
    }
    for at in 0..pieces as usize {
        sheet.road(&rows[0][at..at + 2], &rows[1][at..at + 2], "");
    }
    sheet.drawing.data()
}

/// Heights under another key are heights; what is none is renamed nowhere.
#[test]
fn heights_under_another_key_count_if_they_are_heights() {
    let data = road(20, |_| "elevation=298.5".to_owned());
    let told = found(&data);
    assert!(of_code(&told, "node/ele-left-out").is_empty());
    assert_eq!(of_code(&told, "node/no-ele"), ["42 of 42 points have no ele; point 1 is the first."]);
    let after = from_osm(&mended(data).osm, &Projector::Local).map;
    assert!(after.points.iter().all(|point| point.ele() == Some(298.5)));
    let none = road(20, |_| "elevation=None".to_owned());
    let after = mended(none).osm;
    assert!(after.nodes.iter().all(|node| node.tags.first("elevation") == Some("None")));
}

/// Where half of the points have heights, the others get theirs all at once, from lanes and not from lights.
#[test]
fn missing_heights_are_those_of_lanes() {
    let mut data = road(20, |at| if at < 3 { "ele=100".to_owned() } else { String::new() });
    data.nodes.iter_mut().filter(|node| node.id == 7).for_each(|node| node.tags.set("ele", "100"));
    let after = from_osm(&mended(data).osm, &Projector::Local).map;
    assert!(after.points.iter().all(|point| point.ele() == Some(100.0)));
}

#[test]
fn ids_below_zero_are_told_once_for_each_kind() {
    let mut sheet = Sheet::default();
    for at in 0..40_i64 {
        sheet.drawing.node(-1 - at, [""; 2], &format!("local_x={} local_y={} ele=5", at / 2 * 20, at % 2 * 3));
    }
    for at in 0..19_i64 {
        let bounds = [1, 0].map(|side| sheet.way(&[-1 - (2 * at + side), -3 - (2 * at + side)], "type=road_border"));
        sheet.lanelet(bounds, "subtype=road location=urban speed_limit=40");
    }
    let data = sheet.drawing.data();
    let told = found(&data);
    assert_eq!(of_code(&told, "ids/range"), ["40 nodes have ids that are not positive; point -1 is the first."]);
    assert!(mended(data).osm.nodes.iter().all(|node| node.id > 0));
}

/// The loader looks at the bounds of some lanelets, and says how many it leaves out.
#[test]
fn lanelets_along_one_endless_line_are_left_out_and_told() {
    let mut sheet = Sheet::default();
    let ends = sheet.nodes([[0.0, 0.0], [1.0, 0.0]]);
    let common = sheet.way(&ends.repeat(2_000), PAINT);
    for at in 0..100 {
        let y = f64::from(at).mul_add(0.01, 3.0);
        let other = sheet.nodes([[0.0, y], [20.0, y]]);
        let other = sheet.way(&other, PAINT);
        sheet.lanelet([other, common], "subtype=road location=urban speed_limit=40");
    }
    let Loaded { map, faults, .. } = from_osm(&sheet.drawing.data(), &Projector::Local);
    let settings = Settings::default();
    let index = MapIndex::new(&map, &faults, &settings);
    let told = lanewright::rules::run(&index, &lanewright::rules::Config::from(&settings)).unwrap();
    let skipped: Vec<_> = told.iter().filter(|one| one.code == "load/skipped").collect();
    assert_eq!(map.lanelets.len(), 74);
    assert!(
        matches!(skipped[..], [one] if one.severity == Severity::Error && one.finding.subject == Subject::Lanelet(2075))
    );
    assert!(skipped[0].finding.message.contains("26 lanelets"), "{}", skipped[0].finding.message);
}

/// Ways that join or branch where no area is drawn lie over each other.
#[test]
fn lanes_that_join_need_not_lie_side_by_side() {
    let map = |joins: bool| {
        let mut sheet = Sheet::default();
        sheet.people_drive_on_the_right();
        let [a, b] = [sheet.nodes([[0.0, 3.5], [0.0, 0.0]]), sheet.nodes([[40.0, 3.5], [40.0, 0.0]])];
        sheet.road(&[a[0], b[0]], &[a[1], b[1]], "");
        let [c, d] = [sheet.nodes([[40.0, 2.2], [40.0, 5.7]]), sheet.nodes([[0.0, 2.2], [0.0, 5.7]])];
        sheet.road(&[c[0], d[0]], &[c[1], d[1]], "");
        if joins {
            let from = sheet.nodes([[20.0, -20.0], [23.5, -20.0]]);
            sheet.road(&[from[0], b[0]], &[from[1], b[1]], "");
        }
        of_code(&found(&sheet.drawing.data()), "vm-01-13/overlap").len()
    };
    assert_eq!([map(false), map(true)], [1, 0]);
}
