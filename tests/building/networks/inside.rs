//! What the settings want drawn inside intersections: stop lines, guide lines.

use std::collections::BTreeSet;

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::geometry::Point;
use lanewright::lanelet::{Lanelet, LaneletMap, LineString, LineStringId, PointId};
use lanewright::settings::Document;

use super::{SIDES, built, crossing, elements, found, referrers, signalised_crossing, undrawn};

const EVERYWHERE: &str = "[inside]\nguide_lines = true\nstop_lines = true\n";

#[test]
fn nothing_is_painted_inside_unless_it_is_asked_for() {
    let map = built(&signalised_crossing(DrivingSide::Right), DrivingSide::Right, "").map;
    assert!(guides(&map).is_empty() && elements(&map, "road_marking").is_empty());
}

#[test]
fn far_turns_wait_inside_and_follow_the_line_between_them() {
    for side in SIDES {
        let Built { map, settings, .. } = built(&signalised_crossing(side), side, EVERYWHERE);
        assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?}");
        assert_eq!((guides(&map).len(), elements(&map, "road_marking").len()), (4, 8), "{side:?}");
        for marking in elements(&map, "road_marking") {
            let lanes = referrers(&map, marking);
            let far = if side == DrivingSide::Right { "left" } else { "right" };
            assert!(lanes.len() == 1 && lanes[0].attributes.is("turn_direction", far));
            let line = map.linestrings.get(marking.linestrings("refers").next().unwrap()).unwrap();
            let bounds = [lanes[0].left, lanes[0].right].map(|bound| &map.linestrings.get(bound.line).unwrap().points);
            assert!(line.points.iter().all(|node| bounds.iter().any(|bound| bound.contains(node))), "a node of either");
        }
    }
}

#[test]
fn where_others_leave_by_the_same_lane_nobody_stops_inside() {
    for side in SIDES {
        let xml = crossing(side, "highway=traffic_signals", "highway=secondary lanes=2");
        let Built { map, settings, .. } = built(&xml, side, EVERYWHERE);
        assert_eq!(found(&map, &settings), Vec::<String>::new());
        assert!(guides(&map).is_empty() && elements(&map, "road_marking").is_empty());
    }
}

#[test]
fn a_lanelet_that_does_not_know_of_the_line_is_found() {
    let Built { mut map, settings, .. } =
        built(&signalised_crossing(DrivingSide::Right), DrivingSide::Right, EVERYWHERE);
    let marking = elements(&map, "road_marking")[0].id;
    map.regulatory_elements.retain(|element| element.id != marking);
    map.lanelets.as_mut_slice().iter_mut().for_each(|lanelet| lanelet.regulatory_elements.retain(|id| *id != marking));
    assert_eq!(found(&map, &settings), ["vm-03-14/unreferenced"]);
}

#[test]
fn a_bound_that_leaves_its_guide_line_is_found() {
    let Built { mut map, settings, .. } =
        built(&signalised_crossing(DrivingSide::Right), DrivingSide::Right, EVERYWHERE);
    let guide = guides(&map)[0].clone();
    let along = |line: &&LineString| line.id != guide.id && guide.points.iter().all(|node| line.points.contains(node));
    let bound = map.linestrings.iter().find(along).unwrap().id;
    let points = &mut map.linestrings.get_mut(bound).unwrap().points;
    *points = vec![points[0], points[points.len() - 1]];
    assert!(found(&map, &settings).contains(&"vm-03-06/off-guide".to_owned()));
}

/// The settings of one stop line across the first far turn of a map, this far from its begin (of 1) and moved by degrees.
fn stop_line(map: &LaneletMap, part: f64, by: f64) -> String {
    let far = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "left"));
    // By its id, as the order of the map is nobody's promise: one that leads where the move takes no width.
    let lanelet = far.max_by_key(|lanelet| lanelet.id).unwrap();
    let place = |bound| {
        let points: Vec<_> = map.bound_points(bound).map(|point| point.lonlat().unwrap()).collect();
        let at = points[(points.len() as f64 * part) as usize];
        format!("[{}, {}]", at.lat + by, at.lon + by)
    };
    format!("[[intersection]]\nat = [0.5, 9.5]\nstop_lines = [[{}, {}]]\n", place(lanelet.left), place(lanelet.right))
}

#[test]
fn a_stop_line_lies_where_the_settings_have_it() {
    let side = DrivingSide::Right;
    let bare = built(&signalised_crossing(side), side, "").map;
    // A third of a metre off: hands are not exact.
    let built = built(&signalised_crossing(side), side, &stop_line(&bare, 0.4, 0.000_002));
    assert_eq!(undrawn(&built), Vec::<&str>::new());
    let markings = elements(&built.map, "road_marking");
    assert_eq!((markings.len(), referrers(&built.map, markings[0]).len()), (1, 1));
    assert_eq!(found(&built.map, &built.settings), Vec::<String>::new());
}

#[test]
fn what_cannot_be_drawn_is_named_with_its_place_and_left_out() {
    let side = DrivingSide::Right;
    let bare = built(&signalised_crossing(side), side, "").map;
    let line = stop_line(&bare, 0.4, 0.0);
    let twice = format!("{line}{line}");
    let light = |more: &str| format!("[[intersection]]\nat = [0.5, 9.5]\nvirtual_lights = [{{ approach = {more} }}]\n");
    let cases = [
        (stop_line(&bare, 0.4, 0.000_3), "lies across no lane"),
        (stop_line(&bare, 0.0, 0.0), "the stop line of the approach is drawn there"),
        (line.replace("at = [0.5, 9.5]", "at = [0.501, 9.5]"), "lies in no intersection_area; the nearest is that of"),
        (line.replace("at = [0.5, 9.5]", "ia = 5"), "the map has no intersection_area 5"),
        (light("\"S\""), "traffic lights rule S"),
        (light("17"), "no lane leads in from 17; there are "),
    ];
    for (settings, message) in cases {
        let built = built(&signalised_crossing(side), side, &settings);
        let said = undrawn(&built).join("; ");
        assert!(said.starts_with("lanewright.toml:1: ") && said.contains(message), "{said}");
        assert!(
            elements(&built.map, "road_marking").is_empty() && elements(&built.map, "virtual_traffic_light").is_empty()
        );
    }
    let built = built(&signalised_crossing(side), side, &twice);
    assert_eq!(elements(&built.map, "road_marking").len(), 1);
    assert!(undrawn(&built)[0].contains("lanewright.toml:4: ") && undrawn(&built)[0].contains("has a stop line"));
}

/// The settings of a guide line along the first 0.6 of the right bound of one far turn: at its end it lies this part of the
/// lane's width inside, and everything is moved by degrees.
fn guide_line(map: &LaneletMap, inside: f64, by: f64) -> String {
    let far = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "left"));
    let bound =
        |bound| -> Vec<_> { map.bound_points(bound).map(|point| (point.position, point.lonlat().unwrap())).collect() };
    // One along which the move, to the north-east, leads, so that it takes and gives little width.
    let north_east = |bound: &[(Point, _)]| bound.iter().map(|(at, _)| at.x + at.y).sum::<f64>() / bound.len() as f64;
    let room = |lanelet: &&Lanelet| north_east(&bound(lanelet.right)) - north_east(&bound(lanelet.left));
    let lanelet = far.min_by(|a, b| room(a).abs().total_cmp(&room(b).abs())).unwrap();
    let (left, right) = (bound(lanelet.left), bound(lanelet.right));
    let count = right.len() * 6 / 10;
    let places = right.iter().take(count).enumerate().map(|(i, (place, at))| {
        let off = |p: &Point| (p - place).norm();
        let beside = left.iter().min_by(|a, b| off(&a.0).total_cmp(&off(&b.0))).unwrap().1;
        let part = inside * i as f64 / (count - 1) as f64;
        let [lat, lon] = [at.lat + (beside.lat - at.lat) * part + by, at.lon + (beside.lon - at.lon) * part + by];
        format!("[{lat}, {lon}]")
    });
    let places = places.collect::<Vec<_>>().join(", ");
    format!("[[intersection]]\nat = [0.5, 9.5]\nguide_lines = [[{places}]]\n")
}

#[test]
fn bounds_are_led_along_the_guide_lines_of_the_settings() {
    let side = DrivingSide::Right;
    let bare = built(&signalised_crossing(side), side, "").map;
    for inside in [0.0, 0.12, -0.12] {
        let built = built(&signalised_crossing(side), side, &guide_line(&bare, inside, 0.000_004));
        assert_eq!(undrawn(&built), Vec::<&str>::new());
        let Built { map, settings, .. } = &built;
        assert_eq!(found(map, settings), Vec::<String>::new());
        let [guide] = guides(map)[..] else { panic!("one line") };
        let led =
            |line: &&LineString| line.id != guide.id && guide.points.iter().all(|node| line.points.contains(node));
        let bound = map.linestrings.iter().find(led).unwrap();
        assert!(bare.linestrings.get(bound.id).is_some_and(|before| before.points != bound.points));
        let used: BTreeSet<PointId> = map.linestrings.iter().flat_map(|line| line.points.iter().copied()).collect();
        assert!(bound.points.iter().chain(&guide.points).all(|id| map.points.contains(*id)));
        assert_eq!(used.len(), map.points.len(), "no point is left of the bound as it was");
    }
}

#[test]
fn a_guide_line_that_no_lane_can_follow_changes_nothing() {
    let side = DrivingSide::Right;
    let bare = built(&signalised_crossing(side), side, "").map;
    let cases = [
        (guide_line(&bare, 0.0, 0.000_1), "no bound of a lane begins within 2 m of it"),
        (guide_line(&bare, 0.9, 0.0), "m from the bound of lanelet"),
        (guide_line(&bare, 0.4, 0.0), "m wide"),
    ];
    for (settings, message) in cases {
        let built = built(&signalised_crossing(side), side, &settings);
        let said = undrawn(&built).join("; ");
        assert!(
            said.starts_with("lanewright.toml:1: guide_lines[0] is not drawn: ") && said.contains(message),
            "{said}"
        );
        let shapes = |map: &LaneletMap| format!("{:?}{:?}", map.points.as_slice(), map.linestrings.as_slice());
        assert!(shapes(&built.map) == shapes(&bare));
    }
}

#[test]
fn what_cannot_be_meant_is_an_error_with_its_place() {
    let entry = "[[intersection]]\nat = [0.5, 9.5]\n";
    for (line, at, message) in [
        ("stop_lines = [[[139.7, 35.6], [139.7, 35.7]]]\n", "[[139", "stop_lines: one of its places is not a latitude"),
        ("guide_lines = [7, [[0.5, 9.5]]]\n", "[[0.5", "guide_lines: a line has two places at least"),
        (
            "virtual_lights = [{ approach = \"S\", start = 0.0 }]\n",
            "{ ",
            "virtual_lights: `start` is a number of metres",
        ),
        ("virtual_lights = [{ approach = 7, tags = { type = \"x\" } }]\n", "{ ", "virtual_lights: its `type` is"),
        ("guide_lines = [\"x\"]\n", "[\"x\"", "a guide line is the id of a way, or its places"),
    ] {
        let text = format!("{entry}{line}");
        let error = Document::parse("lanewright.toml", &text).unwrap_err();
        assert!(error.message.contains(message), "{error}");
        assert_eq!(error.offset, text.find(at).unwrap(), "{error}");
    }
    let said = |text: &str| Document::parse("a", text).unwrap().settings;
    let both = said("[inside]\nstop_lines = false\n").over(said("[inside]\nstop_lines = true\nguide_lines = true\n"));
    assert_eq!((both.inside.stop_lines, both.inside.guide_lines), (Some(false), Some(true)));
}

fn guides(map: &LaneletMap) -> Vec<&LineString> {
    let bounds = map.lanelets.iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]);
    let bounds: Vec<LineStringId> = bounds.collect();
    let painted = |line: &&LineString| line.attributes.is("subtype", "dashed") && !bounds.contains(&line.id);
    map.linestrings.iter().filter(painted).collect()
}
