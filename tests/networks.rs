//! Hand-drawn networks, built and judged: what the settings want drawn inside intersections, and lights where people cross.
//! The rules find nothing about either, and would if a part were missing.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod common;

use std::collections::{BTreeMap, BTreeSet};

use common::judge_as;
use lanewright::builder::options::Inside;
use lanewright::builder::postprocess::user_elements::UNDRAWN;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::builder::{BuildOptions, Built, build};
use lanewright::geometry::{Point, Polyline, polygon};
use lanewright::lanelet::{
    Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Loaded, PointId, RegulatoryElement, Target,
};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::rules::Config;
use lanewright::settings::{Document, Settings};

/// Latitude and longitude of the crossing's middle.
const MIDDLE: [f64; 2] = [0.5, 9.5];

/// Roads of these tags that meet at places in metres, mirrored where people drive on the left.
fn network(side: DrivingSide, nodes: &[(i64, f64, f64, &str)], ways: &[(i64, &[i64])], tags: &str) -> String {
    let ways: Vec<(i64, &[i64], &str)> = ways.iter().map(|&(id, refs)| (id, refs, tags)).collect();
    network_of(side, nodes, &ways)
}

/// The same with tags for each road.
fn network_of(side: DrivingSide, nodes: &[(i64, f64, f64, &str)], ways: &[(i64, &[i64], &str)]) -> String {
    let east = if side == DrivingSide::Right { 1.0 } else { -1.0 };
    let tags_of = |text: &str| -> String {
        let pairs = text.split_whitespace().filter_map(|tag| tag.split_once('='));
        pairs.map(|(key, value)| format!("<tag k='{key}' v='{value}'/>")).collect()
    };
    let mut xml = String::from("<osm>");
    for &(id, x, y, tags) in nodes {
        let [lat, lon] = place(x * east, y);
        xml += &format!("<node id='{id}' lat='{lat}' lon='{lon}'>{}</node>", tags_of(tags));
    }
    for (id, refs, tags) in ways {
        let refs: String = refs.iter().map(|id| format!("<nd ref='{id}'/>")).collect();
        xml += &format!("<way id='{id}'>{refs}{}</way>", tags_of(tags));
    }
    xml + "</osm>"
}

/// Four roads of 150 m that meet at node 1.
fn crossing(side: DrivingSide, middle: &str, tags: &str) -> String {
    let nodes =
        [(1, 0.0, 0.0, middle), (2, -150.0, 0.0, ""), (3, 150.0, 0.0, ""), (4, 0.0, -150.0, ""), (5, 0.0, 150.0, "")];
    let ways: [(i64, &[i64]); 4] = [(12, &[2, 1]), (13, &[3, 1]), (14, &[4, 1]), (15, &[5, 1])];
    network(side, &nodes, &ways, tags)
}

/// A signalised crossing with four lanes in and two lanes out at each arm; two of the four are for far turns.
fn large(side: DrivingSide) -> String {
    let arrows = match side {
        DrivingSide::Right => "left|left|through|through;right",
        DrivingSide::Left => "left;through|through|right|right",
    };
    let tags = format!("highway=secondary lanes=6 lanes:forward=4 lanes:backward=2 turn:lanes:forward={arrows}");
    crossing(side, "highway=traffic_signals", &tags)
}

/// Degrees of a place in metres from the middle; near the equator a degree is about as long in either direction.
fn place(x: f64, y: f64) -> [f64; 2] {
    [MIDDLE[0] + y / 110_574.0, MIDDLE[1] + x / 111_320.0]
}

fn built(xml: &str, side: DrivingSide, settings: &str) -> Built {
    let mut data = OsmData::default();
    read_bytes(&mut data, "test", xml.as_bytes().to_vec()).unwrap();
    let Settings { inside, lights, intersection, .. } = Document::parse("lanewright.toml", settings).unwrap().settings;
    let inside = Inside { everywhere: inside, lights: lights.unwrap_or_default(), intersections: intersection };
    let options = BuildOptions { driving_side: Some(side), inside, ..BuildOptions::default() };
    build(&data, &options).unwrap()
}

/// The codes of what the rules find in a map, but for hints.
fn found(map: &LaneletMap, settings: &Settings) -> Vec<String> {
    let loaded = Loaded { map: map.clone(), faults: Vec::new() };
    let found = judge_as(&loaded, settings, &Config::default());
    found.into_iter().map(|one| one.code.to_string()).collect()
}

/// The same, without what streets that are drawn without signs, and short, are told of in any case.
fn found_of_geometry(map: &LaneletMap, settings: &Settings) -> Vec<String> {
    let told = ["vm-03-11/priority-unknown", "vm-07-01/short-approach"];
    found(map, settings).into_iter().filter(|code| !told.contains(&code.as_str())).collect()
}

fn of<'a>(map: &'a LaneletMap, subtype: &'a str) -> Vec<&'a RegulatoryElement> {
    map.regulatory_elements.iter().filter(|element| element.subtype == subtype).collect()
}

fn referring<'a>(map: &'a LaneletMap, element: &RegulatoryElement) -> Vec<&'a Lanelet> {
    map.lanelets.iter().filter(|lanelet| lanelet.regulatory_elements.contains(&element.id)).collect()
}

fn undrawn(built: &Built) -> Vec<&str> {
    built.notes.iter().filter(|note| note.fault == UNDRAWN).map(|note| note.message.as_str()).collect()
}

fn guides(map: &LaneletMap) -> Vec<&LineString> {
    let bounds = map.lanelets.iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]);
    let bounds: Vec<LineStringId> = bounds.collect();
    let painted = |line: &&LineString| line.attributes.is("subtype", "dashed") && !bounds.contains(&line.id);
    map.linestrings.iter().filter(painted).collect()
}

const SIDES: [DrivingSide; 2] = [DrivingSide::Right, DrivingSide::Left];
const EVERYWHERE: &str = "[inside]\nguide_lines = true\nstop_lines = true\n";

#[test]
fn nothing_is_painted_inside_unless_it_is_asked_for() {
    let map = built(&large(DrivingSide::Right), DrivingSide::Right, "").map;
    assert!(guides(&map).is_empty() && of(&map, "road_marking").is_empty());
}

#[test]
fn far_turns_wait_inside_and_follow_the_line_between_them() {
    for side in SIDES {
        let Built { map, settings, .. } = built(&large(side), side, EVERYWHERE);
        assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?}");
        assert_eq!((guides(&map).len(), of(&map, "road_marking").len()), (4, 8), "{side:?}");
        for marking in of(&map, "road_marking") {
            let lanes = referring(&map, marking);
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
        assert!(guides(&map).is_empty() && of(&map, "road_marking").is_empty());
    }
}

#[test]
fn a_lanelet_that_does_not_know_of_the_line_is_found() {
    let Built { mut map, settings, .. } = built(&large(DrivingSide::Right), DrivingSide::Right, EVERYWHERE);
    let marking = of(&map, "road_marking")[0].id;
    map.regulatory_elements.retain(|element| element.id != marking);
    map.lanelets.as_mut_slice().iter_mut().for_each(|lanelet| lanelet.regulatory_elements.retain(|id| *id != marking));
    assert_eq!(found(&map, &settings), ["vm-03-14/unreferenced"]);
}

#[test]
fn a_bound_that_leaves_its_guide_line_is_found() {
    let Built { mut map, settings, .. } = built(&large(DrivingSide::Right), DrivingSide::Right, EVERYWHERE);
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
    let bare = built(&large(side), side, "").map;
    // A third of a metre off: hands are not exact.
    let built = built(&large(side), side, &stop_line(&bare, 0.4, 0.000_002));
    assert_eq!(undrawn(&built), Vec::<&str>::new());
    let markings = of(&built.map, "road_marking");
    assert_eq!((markings.len(), referring(&built.map, markings[0]).len()), (1, 1));
    assert_eq!(found(&built.map, &built.settings), Vec::<String>::new());
}

#[test]
fn what_cannot_be_drawn_is_named_with_its_place_and_left_out() {
    let side = DrivingSide::Right;
    let bare = built(&large(side), side, "").map;
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
        let built = built(&large(side), side, &settings);
        let said = undrawn(&built).join("; ");
        assert!(said.starts_with("lanewright.toml:1: ") && said.contains(message), "{said}");
        assert!(of(&built.map, "road_marking").is_empty() && of(&built.map, "virtual_traffic_light").is_empty());
    }
    let built = built(&large(side), side, &twice);
    assert_eq!(of(&built.map, "road_marking").len(), 1);
    assert!(undrawn(&built)[0].contains("lanewright.toml:4: ") && undrawn(&built)[0].contains("has a stop line"));
}

/// The settings of a guide line along the first 0.6 of the right bound of one far turn: at its end it lies this part of the
/// lane's width inside, and everything is moved by degrees.
fn guide_line(map: &LaneletMap, inside: f64, by: f64) -> String {
    let far = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "left"));
    // By its id, as the order of the map is nobody's promise: one that leads where the move takes no width.
    let lanelet = far.max_by_key(|lanelet| lanelet.id).unwrap();
    let bound =
        |bound| -> Vec<_> { map.bound_points(bound).map(|point| (point.position, point.lonlat().unwrap())).collect() };
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
    let bare = built(&large(side), side, "").map;
    for inside in [0.0, 0.12, -0.12] {
        let built = built(&large(side), side, &guide_line(&bare, inside, 0.000_004));
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
    let bare = built(&large(side), side, "").map;
    let cases = [
        (guide_line(&bare, 0.0, 0.000_1), "no bound of a lane begins within 2 m of it"),
        (guide_line(&bare, 0.9, 0.0), "m from the bound of lanelet"),
        (guide_line(&bare, 0.4, 0.0), "m wide"),
    ];
    for (settings, message) in cases {
        let built = built(&large(side), side, &settings);
        let said = undrawn(&built).join("; ");
        assert!(
            said.starts_with("lanewright.toml:1: guide_lines[0] is not drawn: ") && said.contains(message),
            "{said}"
        );
        let shapes = |map: &LaneletMap| format!("{:?}{:?}", map.points.as_slice(), map.linestrings.as_slice());
        assert!(shapes(&built.map) == shapes(&bare));
    }
}

/// Two crossings of single lanes 90 m apart, with virtual traffic lights at all approaches.
fn coordinated(side: DrivingSide, more: &str) -> Built {
    let nodes = [
        (1, 0.0, 0.0, ""),
        (2, -150.0, 0.0, ""),
        (3, 150.0, 0.0, ""),
        (4, 0.0, -150.0, ""),
        (5, 0.0, 90.0, ""),
        (6, -150.0, 90.0, ""),
        (7, 150.0, 90.0, ""),
        (8, 0.0, 240.0, ""),
    ];
    let ways: [(i64, &[i64]); 7] =
        [(12, &[2, 1]), (13, &[3, 1]), (14, &[4, 1]), (15, &[1, 5]), (16, &[6, 5]), (17, &[7, 5]), (18, &[8, 5])];
    let light = |side: &str| format!("{{ approach = \"{side}\", {more} tags = {{ section = \"{side}\" }} }}");
    let lights: Vec<String> = ["N", "E", "S", "W"].into_iter().map(light).collect();
    let entry = |[lat, lon]: [f64; 2]| {
        format!("[[intersection]]\nat = [{lat}, {lon}]\nvirtual_lights = [{}]\n", lights.join(", "))
    };
    let settings = entry(place(0.0, 0.0)) + &entry(place(0.0, 90.0));
    built(&network(side, &nodes, &ways, "highway=residential lanes=2"), side, &settings)
}

#[test]
fn virtual_traffic_lights_have_all_their_lines() {
    for side in SIDES {
        let built = coordinated(side, "");
        assert_eq!(undrawn(&built), Vec::<&str>::new());
        let Built { map, settings, .. } = &built;
        assert_eq!(found(map, settings), Vec::<String>::new(), "{side:?}");
        let lights = of(map, "virtual_traffic_light");
        assert_eq!(lights.len(), 8);
        for light in lights {
            let count = |role| light.linestrings(role).count();
            assert_eq!([count("start_line"), count("ref_line"), count("end_line"), count("refers")], [1, 1, 3, 1]);
            assert_eq!(referring(map, light).len(), 3);
            let anchor = map.linestrings.get(light.linestrings("refers").next().unwrap()).unwrap();
            assert!(anchor.attributes.is("type", "intersection_coordination") && anchor.attributes.has("section"));
        }
        let inside = map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("intersection_area")).count();
        assert_eq!(of(map, "right_of_way").len(), inside, "each lanelet yields all whom it meets");
    }
}

#[test]
fn a_start_line_that_has_no_room_is_no_light() {
    let built = coordinated(DrivingSide::Right, "start = 120.0,");
    let said = undrawn(&built);
    assert_eq!(said.len(), 2, "the two approaches between the crossings");
    assert!(said.iter().all(|said| said.contains("m of road, so that `start` is")), "{said:?}");
    assert_eq!(of(&built.map, "virtual_traffic_light").len(), 6);
    // Nothing tells who goes first between the two approaches without a light.
    assert!(found(&built.map, &built.settings).iter().all(|code| code == "vm-03-11/priority-unknown"));
}

#[test]
fn a_virtual_traffic_light_that_lacks_something_is_found() {
    let Built { map, settings, .. } = coordinated(DrivingSide::Left, "");
    let codes = |change: &dyn Fn(&mut RegulatoryElement), subtype: &str| {
        let mut map = map.clone();
        let id = of(&map, subtype)[0].id;
        change(map.regulatory_elements.get_mut(id).unwrap());
        found(&map, &settings)
    };
    let without = |role: &'static str| {
        move |element: &mut RegulatoryElement| {
            let at = element.members.iter().position(|member| member.role == role).unwrap();
            element.members.remove(at);
        }
    };
    assert!(codes(&without("end_line"), "virtual_traffic_light").contains(&"vm-03-16/order".to_owned()));
    assert!(codes(&without("ref_line"), "virtual_traffic_light").contains(&"vm-03-16/types".to_owned()));
    assert!(codes(&without("yield"), "right_of_way").contains(&"vm-03-17/yield".to_owned()));
    // The light of one crossing begins where that of the one before does.
    let lines = |role| -> Vec<_> {
        of(&map, "virtual_traffic_light").iter().map(|light| light.linestrings(role).next().unwrap()).collect()
    };
    let starts = lines("start_line");
    let overlapping = starts.iter().any(|&start| {
        let begin = |light: &mut RegulatoryElement| {
            let member = light.members.iter_mut().find(|member| member.role == "start_line").unwrap();
            member.target = Target::LineString(start);
        };
        codes(&begin, "virtual_traffic_light").contains(&"vm-03-18/overlap".to_owned())
    });
    assert!(overlapping);
}

/// A road of 200 m that is crossed at node 2, in two ways if it is to be split there.
fn crossed(side: DrivingSide, tags: &str, split: bool) -> Built {
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, "highway=crossing crossing=traffic_signals"), (3, 100.0, 0.0, "")];
    let whole: [(i64, &[i64]); 1] = [(10, &[1, 2, 3])];
    let halves: [(i64, &[i64]); 2] = [(10, &[1, 2]), (11, &[2, 3])];
    let xml = network(side, &nodes, if split { &halves } else { &whole }, tags);
    built(&xml.replace("<way id='11'>", "<way id='11'><tag k='maxspeed' v='20'/>"), side, "")
}

/// The lights of drivers, each with the lanelet that obeys it and the distance of its stop line from the crosswalk.
fn drivers(map: &LaneletMap) -> Vec<(&Lanelet, f64)> {
    let crosswalk = map.lanelets.iter().find(|lanelet| lanelet.attributes.is("subtype", "crosswalk")).unwrap();
    let area = map.outline(crosswalk);
    let found = of(map, "traffic_light").into_iter().filter_map(|light| {
        let line = map.linestrings.get(light.linestrings("ref_line").next()?).unwrap();
        let places: Vec<_> = line.points.iter().map(|id| map.points.get(*id).unwrap().position).collect();
        let middle = nalgebra::center(&places[0], &places[1]);
        let off = Polyline::new(area.iter().copied().chain([area[0]])).unwrap().distance(middle);
        let [lane] = referring(map, light)[..] else { panic!("one lane has one stop line") };
        Some((lane, off))
    });
    found.collect()
}

#[test]
fn drivers_have_lights_where_people_have_some_between_intersections() {
    for side in SIDES {
        for (tags, split, lanes) in [
            ("highway=residential lanes=2", false, 2),
            ("highway=residential lanes=2", true, 2),
            ("highway=secondary lanes=4", false, 4),
            ("highway=secondary lanes=3 oneway=yes", false, 3),
            ("highway=residential lanes=1 width=3", false, 2),
        ] {
            let Built { map, settings, .. } = crossed(side, tags, split);
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {tags}");
            let drivers = drivers(&map);
            assert_eq!(drivers.len(), lanes, "{side:?} {tags}");
            assert!(drivers.iter().all(|(_, off)| (1.9..2.1).contains(off)), "{drivers:?}");
            let bodies = map.linestrings.iter().filter(|line| line.attributes.is("subtype", "red_yellow_green"));
            assert_eq!(bodies.count(), if tags.contains("oneway") { 1 } else { 2 }, "one for each direction");
        }
    }
}

#[test]
fn the_stop_line_lies_before_the_crosswalk_on_the_lane_that_leads_to_it() {
    for side in SIDES {
        let Built { map, .. } = crossed(side, "highway=residential lanes=2", true);
        let lanes = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road")).count();
        assert_eq!(lanes, 6, "two roads, the first of them cut at one stop line: at the other it ends");
        let stopping: Vec<LaneletId> = drivers(&map).iter().map(|(lane, _)| lane.id).collect();
        assert!(stopping.len() == 2 && stopping[0] != stopping[1]);
        for light in of(&map, "traffic_light").into_iter().filter(|light| light.role("ref_line").next().is_some()) {
            let place = |line: LineStringId| {
                let id = map.linestrings.get(line).unwrap().points[0];
                map.points.get(id).unwrap().position
            };
            let (stop, body) =
                (light.linestrings("ref_line").next().unwrap(), light.linestrings("refers").next().unwrap());
            let lane = referring(&map, light)[0];
            let bound = map.bound_line(lane.left);
            let heading = bound[bound.len() - 1] - bound[0];
            assert!((place(body) - place(stop)).dot(&heading) > 0.0, "drivers look ahead");
        }
    }
}

#[test]
fn whoever_has_just_left_an_intersection_with_lights_stops_at_no_other() {
    for side in SIDES {
        let nodes = [
            (1, 0.0, 0.0, "highway=traffic_signals"),
            (2, -100.0, 0.0, ""),
            (3, 200.0, 0.0, ""),
            (4, 0.0, -100.0, ""),
            (5, 0.0, 100.0, ""),
            (6, 32.0, 0.0, "highway=crossing crossing=traffic_signals"),
            (7, 120.0, 0.0, "highway=crossing crossing=traffic_signals"),
        ];
        for (road, lights) in [(&[3, 6, 1][..], 1), (&[3, 7, 1], 2), (&[3, 7, 6, 1], 3)] {
            let ways: [(i64, &[i64]); 4] = [(12, &[2, 1]), (13, road), (14, &[4, 1]), (15, &[5, 1])];
            let built = built(&network(side, &nodes, &ways, "highway=residential lanes=2"), side, "");
            let Built { map, settings, .. } = &built;
            assert_eq!(found(map, settings), Vec::<String>::new());
            let outside = |light: &&&RegulatoryElement| {
                light.role("ref_line").next().is_some()
                    && referring(map, light).iter().all(|lane| !lane.attributes.has("intersection_area"))
            };
            assert_eq!(of(map, "traffic_light").iter().filter(outside).count(), lights, "{side:?} {road:?}");
            assert!(built.notes.iter().all(|note| note.fault != "crossing-unlit"));
        }
    }
}

#[test]
fn lights_hang_on_the_lanes_between_two_stop_lines() {
    // Two crossings 60 m apart on a road of 400 m, and two with 5 m between them.
    let crossing = "highway=crossing crossing=traffic_signals";
    let at = |x: f64, id: i64| (id, x, 0.0, crossing);
    for side in SIDES {
        for (places, groups) in [(vec![at(-30.0, 3), at(30.0, 4)], 2), (vec![at(-4.0, 3), at(4.0, 4)], 1)] {
            let mut nodes = vec![(1, -200.0, 0.0, ""), (2, 200.0, 0.0, "")];
            nodes.extend(places);
            let ways: [(i64, &[i64]); 1] = [(10, &[1, 3, 4, 2])];
            let Built { map, settings, .. } =
                built(&network(side, &nodes, &ways, "highway=secondary lanes=4"), side, "");
            assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {groups}");
            let lights = of(&map, "traffic_light").into_iter().filter(|light| light.role("ref_line").next().is_some());
            let mut lanes: Vec<LaneletId> = Vec::new();
            for light in lights {
                let [lane] = referring(&map, light)[..] else { panic!("one lane obeys it") };
                let line = map.linestrings.get(light.linestrings("ref_line").next().unwrap()).unwrap();
                let starts = [lane.left, lane.right].map(|bound| map.bound_points(bound).next().unwrap().id);
                assert_eq!(line.points, starts, "the lane begins at the stop line");
                let crosses = of(&map, "crosswalk").into_iter().filter(|it| lane.regulatory_elements.contains(&it.id));
                assert_eq!(crosses.count(), 2 / groups);
                lanes.push(lane.id);
            }
            lanes.sort_unstable();
            lanes.dedup();
            assert_eq!(lanes.len(), 4 * groups);
        }
    }
}

/// A T of a main road with people's lights so far east of it, and a side road of these tags.
fn crossed_near(side: DrivingSide, off: f64, side_road: &str) -> Built {
    let nodes = [
        (1, 0.0, 0.0, ""),
        (2, -100.0, 0.0, ""),
        (3, 100.0, 0.0, ""),
        (4, 0.0, -80.0, ""),
        (5, off, 0.0, "highway=crossing crossing=traffic_signals"),
    ];
    let xml = network(side, &nodes, &[(12, &[2, 1]), (13, &[1, 5, 3])], "highway=tertiary lanes=2");
    let stem = network(side, &[], &[(14, &[4, 1])], side_road);
    let (xml, stem) = (xml.replace("</osm>", ""), stem.replace("<osm>", ""));
    built(&(xml + &stem), side, "")
}

#[test]
fn drivers_on_the_main_road_have_lights_where_people_cross_it_beside_an_intersection() {
    for side in SIDES {
        for side_road in ["highway=residential lanes=2", "highway=tertiary lanes=2"] {
            for off in [5.0, 8.0, 12.0, 14.0] {
                let Built { map, settings, notes, .. } = crossed_near(side, off, side_road);
                assert_eq!(found(&map, &settings), Vec::<String>::new(), "{side:?} {off} {side_road}");
                assert!(notes.iter().all(|note| note.fault != "crossing-unlit"));
                let inside = |lanelet: &&&Lanelet| lanelet.attributes.has("intersection_area");
                let lit = |lanelet: &&Lanelet| {
                    of(&map, "traffic_light").iter().any(|light| lanelet.regulatory_elements.contains(&light.id))
                };
                let lit: Vec<&Lanelet> =
                    map.lanelets.iter().filter(|it| it.attributes.is("subtype", "road")).filter(lit).collect();
                // Both approaches of the main road, straight on and around a corner; the side road gives way.
                assert_eq!((lit.len(), lit.iter().filter(inside).count()), (4, 4), "{side:?} {off} {side_road}");
                let crosswalk = map.lanelets.iter().find(|it| it.attributes.is("subtype", "crosswalk")).unwrap();
                assert!(
                    of(&map, "traffic_light").iter().any(|light| crosswalk.regulatory_elements.contains(&light.id))
                );
            }
        }
    }
}

#[test]
fn drivers_wait_behind_the_intersection_where_there_is_room() {
    for side in SIDES {
        for off in [18.0, 20.0, 25.0, 30.0, 50.0] {
            let Built { map, settings, .. } = crossed_near(side, off, "highway=residential lanes=2");
            let mut found = found(&map, &settings);
            found.retain(|code| code != "vm-03-11/priority-unknown");
            assert_eq!(found, Vec::<String>::new(), "{side:?} {off}");
            let drivers = drivers(&map);
            assert!(drivers.iter().all(|(lane, _)| !lane.attributes.has("intersection_area")));
            assert_eq!(drivers.len(), 2, "{side:?} {off}");
        }
    }
}

#[test]
fn who_gives_way_beside_lights_of_people_has_none_and_is_named() {
    for side in SIDES {
        // People cross what gives way: a lower road, and one of four equal ones.
        let built = crossed_near(side, 8.0, "highway=primary lanes=2");
        assert!(of(&built.map, "traffic_light").iter().all(|light| light.role("ref_line").next().is_none()));
        assert_eq!(built.notes.iter().filter(|note| note.fault == "crossing-unlit").count(), 1);
    }
}

#[test]
fn where_people_have_no_lights_drivers_have_none() {
    let side = DrivingSide::Right;
    let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, "highway=crossing crossing=zebra"), (3, 100.0, 0.0, "")];
    let map = built(&network(side, &nodes, &[(10, &[1, 2, 3])], "highway=residential lanes=2"), side, "").map;
    assert!(of(&map, "traffic_light").is_empty() && !of(&map, "crosswalk").is_empty());
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

#[test]
fn roads_that_leave_side_by_side_are_approaches_of_their_own() {
    for side in SIDES {
        for east in [6.0, 20.0, 30.0] {
            let nodes = [
                (1, 0.0, 0.0, ""),
                (2, -90.0, 3.0, ""),
                (3, 90.0, 0.0, ""),
                (4, 0.0, 90.0, ""),
                (5, 0.0, -80.0, ""),
                (6, east, -80.0, ""),
            ];
            let ways: [(i64, &[i64]); 5] = [(12, &[2, 1]), (13, &[3, 1]), (14, &[4, 1]), (15, &[5, 1]), (16, &[6, 1])];
            let xml = network(side, &nodes, &ways, "highway=residential lanes=2");
            let Built { map, settings, .. } = built(&xml, side, "");
            let mut found = found(&map, &settings);
            // Nothing says which of them has priority.
            found.retain(|code| code != "vm-03-11/priority-unknown");
            assert_eq!(found, Vec::<String>::new(), "{side:?}, {east} m apart at their ends");
        }
    }
}

#[test]
fn nobody_misses_the_way_once_more_around_a_small_loop() {
    for side in SIDES {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, 80.0, 20.0, ""),
            (3, -10.8, 3.0, ""),
            (4, -18.0, -2.0, ""),
            (5, -18.9, -6.3, ""),
            (6, -14.4, -10.8, ""),
            (7, -7.2, -7.2, ""),
        ];
        let ways: [(i64, &[i64]); 2] = [(12, &[2, 1]), (13, &[1, 3, 4, 5, 6, 7, 1])];
        let Built { map, settings, notes, .. } =
            built(&network(side, &nodes, &ways, "highway=residential lanes=2"), side, "");
        let dropped = notes.iter().filter(|note| note.fault == "movement-dropped").count();
        assert_eq!(dropped, 2, "{side:?}: there is no room for it");
        let missed = found(&map, &settings).into_iter().filter(|code| code == "vm-03-04/movement-missing").count();
        assert_eq!(missed, 0, "{side:?}");
    }
}

/// The settings that are written beside a map, read again.
fn read_again(settings: &Settings) -> Settings {
    Document::parse("lanewright.toml", &toml::to_string(settings).unwrap()).unwrap().settings
}

/// Of each lanelet inside the others that it may ignore.
fn ignored(map: &LaneletMap) -> Vec<(LaneletId, Vec<LaneletId>)> {
    let listed = of(map, "right_of_way").into_iter().map(|element| {
        let mut others: Vec<LaneletId> = element.lanelets("yield").collect();
        others.sort_unstable();
        (element.lanelets("right_of_way").next().unwrap(), others)
    });
    let mut all: Vec<_> = listed.collect();
    all.sort_unstable();
    all
}

#[test]
fn who_is_never_green_with_a_lanelet_is_ignored_by_it() {
    let [lat, lon] = MIDDLE;
    for side in SIDES {
        let phased = |phases: &str| {
            let settings = format!("[[intersection]]\nat = [{lat}, {lon}]\nphases = {phases}\n");
            let built = built(&large(side), side, &settings);
            assert_eq!(undrawn(&built), Vec::<&str>::new(), "{side:?} {phases}");
            let settings = read_again(&built.settings);
            assert_eq!(found(&built.map, &settings), Vec::<String>::new(), "{side:?} {phases}");
            (ignored(&built.map), built)
        };
        let bare = built(&large(side), side, "");
        let (opposite, as_usual) = phased("[[\"S\", \"N\"], [\"E\", \"W\"]]");
        assert_eq!(opposite, ignored(&bare.map), "{side:?}: what is assumed where nothing is said");
        assert_eq!(as_usual.settings.intersection.len(), 1);
        // One after the other: far turns ignore the oncoming ones too.
        let (single, apart) = phased("[[\"S\"], [\"N\"], [\"E\"], [\"W\"]]");
        let count = |all: &[(LaneletId, Vec<LaneletId>)]| all.iter().map(|(_, others)| others.len()).sum::<usize>();
        assert!(count(&single) > count(&opposite), "{side:?}");
        let unsaid = found(&apart.map, &bare.settings);
        assert!(unsaid.iter().any(|code| code.starts_with("vm-03-10/")), "{side:?}: they need the phases, {unsaid:?}");
        // Approaches side by side that are green together.
        let (beside, _) = phased("[[\"S\", \"E\"], [\"N\", \"W\"]]");
        assert_ne!(beside, opposite, "{side:?}");
        // The lanelets of a far turn by their ids: they alone are green without oncoming traffic.
        let far = if side == DrivingSide::Right { "left" } else { "right" };
        let turns = bare.map.lanelets.iter().filter(|one| one.attributes.is("turn_direction", far));
        let turns: Vec<String> = turns.map(|lanelet| lanelet.id.to_string()).collect();
        let (turning, _) = phased(&format!("[[\"S\", \"N\"], [\"E\", \"W\"], [{}]]", turns.join("], [")));
        assert!(count(&turning) > count(&opposite), "{side:?}");
    }
}

#[test]
fn phases_of_approaches_without_lights_are_named() {
    let [lat, lon] = MIDDLE;
    let settings = format!("[[intersection]]\nat = [{lat}, {lon}]\nphases = [[\"S\", \"N\"], [\"E\", 7]]\n");
    let side = DrivingSide::Right;
    let said = |xml: &str| undrawn(&built(xml, side, &settings)).iter().map(ToString::to_string).collect::<Vec<_>>();
    let said_of_lit = said(&large(side));
    let told = "lanewright.toml:1: phases[1] is not heeded: 7 has no traffic lights; there are none but those of ";
    assert!(said_of_lit.len() == 1 && said_of_lit[0].starts_with(told), "{said_of_lit:?}");
    let unlit = said(&crossing(side, "", "highway=residential lanes=2"));
    assert!(unlit.len() == 4 && unlit.iter().all(|said| said.ends_with("there are none here")), "{unlit:?}");
}

/// Per light of drivers the arrow that it has, and where those go that obey it.
fn arrows(map: &LaneletMap) -> Vec<(Option<&str>, BTreeSet<&str>)> {
    let mut ruled: BTreeMap<LineStringId, BTreeSet<&str>> = BTreeMap::new();
    for element in of(map, "traffic_light") {
        let bulbs = element.linestrings("light_bulbs").next().unwrap();
        let lanes = referring(map, element);
        let ways = lanes.iter().filter_map(|lane| lane.attributes.get("turn_direction"));
        ruled.entry(bulbs).or_default().extend(ways);
    }
    let arrow = |bulbs: LineStringId| {
        let bulbs = &map.linestrings.get(bulbs).unwrap().points;
        let bulbs: Vec<_> = bulbs.iter().map(|&id| map.points.get(id).unwrap().attributes()).collect();
        let arrows: Vec<&str> = bulbs.iter().filter_map(|tags| tags.get("arrow")).collect();
        assert_eq!(bulbs.len(), 3 + arrows.len(), "three colours, and what is an arrow");
        assert!(bulbs.iter().all(|tags| !tags.has("arrow") || tags.is("color", "green")));
        arrows.first().copied()
    };
    ruled.into_iter().map(|(bulbs, ways)| (arrow(bulbs), ways)).collect()
}

#[test]
fn lanes_from_which_all_go_one_way_have_an_arrow() {
    let [lat, lon] = MIDDLE;
    let here = |arrows: bool| format!("[[intersection]]\nat = [{lat}, {lon}]\narrows = {arrows}\n");
    for side in SIDES {
        for (settings, wanted) in [
            (String::new(), false),
            ("[lights]\narrows = true\n".to_owned(), true),
            (here(true), true),
            (format!("[lights]\narrows = true\n{}", here(false)), false),
        ] {
            let built = built(&large(side), side, &settings);
            assert_eq!(found(&built.map, &built.settings), Vec::<String>::new(), "{side:?} {settings}");
            let lights = arrows(&built.map);
            // Two lanes for far turns, one straight on, one for both others; or all together.
            assert_eq!(lights.len(), if wanted { 12 } else { 4 }, "{side:?} {settings}");
            for (arrow, ways) in lights {
                let way = arrow.map(|arrow| if arrow == "up" { "straight" } else { arrow });
                let only = (ways.len() == 1 && wanted).then(|| *ways.first().unwrap());
                assert_eq!(way, only, "{side:?} {settings}: where all go");
            }
        }
    }
    let unlit = built(&crossing(SIDES[0], "", "highway=residential lanes=2"), SIDES[0], &here(true));
    assert_eq!(undrawn(&unlit), ["lanewright.toml:1: arrows is not heeded: there are no traffic lights here"]);
}

/// The bus lanes outside and inside the intersection that bicycles may use, and those that they may not.
fn bus_lanes(map: &LaneletMap) -> [[usize; 2]; 2] {
    let mut count = [[0; 2]; 2];
    for lanelet in map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "bus_lane")) {
        let tags = &lanelet.attributes;
        assert!(tags.is("participant:vehicle:bus", "yes") && !tags.has("participant:vehicle"), "buses only");
        let inside = usize::from(tags.has("intersection_area"));
        count[inside][usize::from(!tags.is("participant:bicycle", "yes"))] += 1;
    }
    count
}

#[test]
fn bicycles_share_the_bus_lanes_of_their_side_of_the_road() {
    for side in SIDES {
        let shared = |tags: &str| {
            let xml = crossing(side, "", &format!("highway=secondary lanes=4 busway=lane {tags}"));
            let Built { map, settings, .. } = built(&xml, side, "");
            let mut found = found(&map, &settings);
            // Nothing says which of them has priority.
            found.retain(|code| code != "vm-03-11/priority-unknown");
            assert_eq!(found, Vec::<String>::new(), "{side:?} {tags}");
            bus_lanes(&map)
        };
        // Each of the four roads has one in either direction.
        let [outside, inside] = shared("");
        assert_eq!(outside, [0, 8], "{side:?}");
        assert!(inside[0] == 0 && inside[1] > 0, "{side:?} {inside:?}");
        for tags in ["cycleway=share_busway", "cycleway:both=share_busway"] {
            assert_eq!(shared(tags), [[8, 0], [inside[1], 0]], "{side:?} {tags}");
        }
        assert_eq!(shared("cycleway:right=share_busway")[0], [4, 4], "{side:?}");
        assert_eq!(shared("cycleway:left=share_busway")[0], [4, 4], "{side:?}");
    }
}

/// Where lanes that go straight on from south to north begin and end, each counted from the left.
fn northbound(map: &LaneletMap) -> BTreeSet<[usize; 2]> {
    let middle = |lanelet: &Lanelet, last: bool| {
        let [left, right] = [lanelet.left, lanelet.right].map(|bound| {
            let mut points = map.bound_points(bound).map(|point| point.position);
            if last { points.next_back() } else { points.next() }
        });
        nalgebra::center(&left.unwrap(), &right.unwrap())
    };
    let straight = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "straight"));
    let ends = straight.map(|lanelet| [false, true].map(|last| middle(lanelet, last)));
    let ends: Vec<[f64; 2]> = ends.filter(|[a, b]| b.y > a.y + 10.0).map(|[a, b]| [a.x, b.x]).collect();
    let rank = |side: usize, x: f64| {
        let mut all: Vec<i64> = ends.iter().map(|end| end[side].round() as i64).collect();
        all.sort_unstable();
        all.dedup();
        1 + all.iter().position(|other| *other == x.round() as i64).unwrap()
    };
    ends.iter().map(|[a, b]| [rank(0, *a), rank(1, *b)]).collect()
}

#[test]
fn lanes_lead_where_a_relation_says() {
    let relation = |tags: &str| {
        format!(
            "<relation id='9'><member type='way' ref='14' role='from'/><member type='node' ref='1' role='via'/>\
             <member type='way' ref='15' role='to'/><tag k='type' v='connectivity'/>{tags}</relation></osm>"
        )
    };
    for side in SIDES {
        let plain = crossing(side, "highway=traffic_signals", "highway=secondary lanes=6");
        let judged = |tags: &str| {
            let built = built(&plain.replace("</osm>", &relation(tags)), side, "");
            assert_eq!(found(&built.map, &built.settings), Vec::<String>::new(), "{side:?} {tags}");
            let notes: Vec<_> = built.notes.iter().filter(|note| note.fault == "connectivity-skipped").collect();
            (northbound(&built.map), notes.len())
        };
        let usual = BTreeSet::from([[1, 1], [2, 2], [3, 3]]);
        let told = BTreeSet::from([[1, 1], [2, 2], [2, 3]]);
        assert_eq!(judged("<tag k='connectivity' v='1:1|2:2,3|3:(3)'/>"), (told, 0), "{side:?}");
        assert_eq!(judged("<tag k='connectivity' v='1:2|2:1'/>"), (usual.clone(), 1), "{side:?}: they would cross");
        assert_eq!(judged("<tag k='connectivity' v='1:1|4:3'/>"), (usual, 0), "{side:?}: there is no fourth lane");
    }
}

#[test]
fn lanes_fan_out_where_the_settings_have_it() {
    for side in SIDES {
        let xml = crossing(side, "highway=traffic_signals", "highway=secondary lanes=4");
        let turns = |settings: &str| {
            let built = built(&xml, side, settings);
            assert_eq!(found(&built.map, &built.settings), Vec::<String>::new(), "{side:?} {settings}");
            built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("turn_direction")).count()
        };
        assert_eq!(turns(""), 4 * (2 + 1 + 1), "{side:?}: straight on, and a lane to either side");
        assert_eq!(turns("[inside]\nfan_out = true\n"), 4 * (2 + 2 + 2), "{side:?}");
    }
}

#[test]
fn what_is_left_of_a_road_too_short_for_the_turns_at_its_ends_lies_inside() {
    for side in SIDES {
        for apart in [18.0, 20.0, 22.0] {
            let nodes = [
                (1, 0.0, 0.0, ""),
                (2, apart, 0.0, ""),
                (3, -150.0, 0.0, ""),
                (4, apart + 150.0, 0.0, ""),
                (5, 85.0, 120.0, ""),
                (6, apart - 85.0, -120.0, ""),
            ];
            let ways: [(i64, &[i64]); 3] = [(11, &[3, 1, 2, 4]), (14, &[1, 5]), (15, &[2, 6])];
            let built = built(&network(side, &nodes, &ways, "highway=residential"), side, "");
            let found = found_of_geometry(&built.map, &built.settings);
            assert!(found.is_empty(), "{side:?} {apart}: {found:?}");
            assert_eq!((built.summary.roads, built.summary.intersections), (4, 1), "{side:?} {apart}");
        }
    }
}

#[test]
fn a_dead_end_too_short_for_the_turn_into_it_is_left_out() {
    for side in SIDES {
        for (length, roads) in [(9.0, 2), (20.0, 3)] {
            let nodes = [(1, 0.0, 0.0, ""), (3, -150.0, 0.0, ""), (4, 150.0, 0.0, ""), (5, 0.0, length, "")];
            let ways: [(i64, &[i64]); 3] = [(11, &[3, 1]), (13, &[1, 4]), (14, &[1, 5])];
            let built = built(&network(side, &nodes, &ways, "highway=residential"), side, "");
            let found = found_of_geometry(&built.map, &built.settings);
            assert!(found.is_empty(), "{side:?} {length}: {found:?}");
            assert_eq!(built.summary.roads, roads, "{side:?} {length}");
            let told = built.notes.iter().any(|note| note.fault == "way-skipped" && note.message.contains("way 14"));
            assert_eq!(told, roads == 2, "{side:?} {length}");
        }
    }
}

#[test]
fn a_lane_in_the_middle_leads_only_where_it_is_needed() {
    let middle = "highway=primary lanes=5 lanes:forward=2 lanes:backward=2 lanes:both_ways=1";
    let one_way = "highway=primary lanes=2 oneway=yes";
    for side in SIDES {
        // Into two carriageways, with and without a side street at the end; beyond it, or into a road of five lanes.
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -200.0, 0.0, ""),
            (3, 200.0, -9.0, ""),
            (4, 200.0, 9.0, ""),
            (5, 0.0, 120.0, ""),
            (6, -400.0, 0.0, ""),
            (7, -200.0, 120.0, ""),
        ];
        let parts: [(i64, &[i64], &str); 3] = [(11, &[2, 1], middle), (12, &[1, 3], one_way), (13, &[4, 1], one_way)];
        let at_the_end: (i64, &[i64], &str) = (14, &[1, 5], "highway=residential");
        let before: [(i64, &[i64], &str); 2] = [(15, &[6, 2], middle), (16, &[2, 7], "highway=residential")];
        let of_ways = |map: &LaneletMap| {
            [11, 15].map(|way| {
                let of_way = |id: &str| id.starts_with(&format!("{way}:"));
                map.lanelets.iter().filter(|l| l.attributes.get("road_id").is_some_and(of_way)).count()
            })
        };
        let lanes = |ways: &[(i64, &[i64], &str)]| {
            let built = built(&network_of(side, &nodes, ways), side, "");
            let mut found = found_of_geometry(&built.map, &built.settings);
            // Beside a side street the lane at the far edge meets nobody.
            found.retain(|code| code != "vm-03-12/no-conflict");
            assert!(found.is_empty(), "{side:?} {}: {found:?}", ways.len());
            of_ways(&built.map)
        };
        assert_eq!(lanes(&parts), [5, 0], "{side:?}: not into the two carriageways");
        assert_eq!(lanes(&[&parts[..], &[at_the_end]].concat()), [6, 0], "{side:?}: to turn");
        assert_eq!(lanes(&[&parts[..], &before].concat()), [5, 6], "{side:?}: to turn before the end");
        // The road becomes narrower, and the lane in its middle goes on.
        let narrower = "highway=primary lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1";
        let narrowed = network_of(side, &nodes, &[(11, &[2, 1], middle), (15, &[6, 2], narrower)]);
        assert_eq!(of_ways(&built(&narrowed, side, "").map), [6, 4], "{side:?}: to go on");
    }
}

#[test]
fn a_crossing_of_narrow_streets_is_no_larger_than_its_turns_need() {
    for side in SIDES {
        // The two halves of a street in line with each other, but for a hair, and at an angle that an eye sees.
        for off in [0.0, 0.01, 1.0] {
            let nodes = [
                (1, 0.0, 0.0, ""),
                (2, -150.0, off, ""),
                (3, 150.0, off, ""),
                (4, off, -150.0, ""),
                (5, off, 150.0, ""),
            ];
            let ways: [(i64, &[i64]); 4] = [(12, &[2, 1]), (13, &[3, 1]), (14, &[4, 1]), (15, &[5, 1])];
            let built = built(&network(side, &nodes, &ways, "highway=residential"), side, "");
            assert_eq!(found_of_geometry(&built.map, &built.settings), Vec::<String>::new(), "{side:?} {off}");
            let area = built.map.polygons.iter().next().unwrap();
            let places = area.points.iter().map(|&id| built.map.points.get(id).unwrap().position);
            let (low, high) = places.fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p.x), high.max(p.x)));
            // Streets of 6 m, and a turn of 6 m in the middle of lanes of 3 m at either side.
            assert!(high - low < 2.0 * (1.5 + 6.0) + 0.5, "{side:?} {off}: {}", high - low);
        }
    }
}

#[test]
fn who_leaves_a_driveway_below_a_bridge_crosses_nobody_on_it() {
    for side in SIDES {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -120.0, 0.0, ""),
            (3, 120.0, 0.0, ""),
            (4, 0.0, 40.0, ""),
            (6, -150.0, -70.0, ""),
            (7, 150.0, 82.0, ""),
        ];
        let ways: [(i64, &[i64], &str); 3] = [
            (10, &[2, 1, 3], "highway=residential lanes=2 sidewalk=both"),
            (11, &[1, 4], "highway=service service=driveway"),
            (12, &[6, 7], "highway=primary lanes=2 bridge=yes layer=1"),
        ];
        let built = built(&network_of(side, &nodes, &ways), side, "");
        let walkways = built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "walkway"));
        let bridge = built.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("road_id", "12:6-7:0"));
        let [walkways, bridge] = [walkways.collect::<Vec<_>>(), bridge.collect()];
        assert_eq!((walkways.len(), bridge.len()), (1, 2));
        let walkway = built.map.outline(walkways[0]);
        let above = |lane: &&Lanelet| polygon::common_area(&built.map.outline(lane), &walkway) > 1.0;
        assert!(bridge.iter().any(above), "the bridge leads over the walkway");
        let found = found(&built.map, &built.settings);
        assert!(!found.iter().any(|code| code.starts_with("vm-03-13")), "{found:?}");
    }
}
