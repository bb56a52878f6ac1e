//! Approaches to stop lines, on small networks.

use std::collections::BTreeMap;

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tests::{Asked, built_as, driven_on, ends};
use crate::builder::{BuildOptions, Built};
use crate::lanelet::{Bound, Lanelet, LaneletMap};
use crate::settings::MarkingSettings;

const FOUR: &str = "highway=secondary lanes=4 sidewalk=no";

/// A crossing of a road from west to east with a minor road; `rule` are the tags of its node, `length`, metres, and `west` are
/// those of its western arm.
struct Crossing<'a> {
    side: DrivingSide,
    rule: &'a str,
    length: f64,
    west: &'a str,
    /// Distance of a crosswalk from the crossing, metres.
    walk: Option<f64>,
    before_stop: Option<f64>,
}

const LIGHTS: Crossing<'static> = Crossing {
    side: DrivingSide::Right,
    rule: "highway=traffic_signals",
    length: 150.0,
    west: "",
    walk: None,
    before_stop: None,
};

fn built(Crossing { side, rule, length, west, walk, before_stop }: &Crossing<'_>) -> Built {
    let markings = MarkingSettings { before_stop: *before_stop };
    let options = BuildOptions { markings, ..driven_on(*side) };
    let nodes = [
        (1, 0.0, 0.0, *rule),
        (2, -length, 0.0, ""),
        (3, 150.0, 0.0, ""),
        (4, 0.0, -80.0, ""),
        (5, 0.0, 80.0, ""),
        (6, -walk.unwrap_or_default(), 0.0, "highway=crossing crossing=marked"),
    ];
    let along: &[i64] = if walk.is_some() { &[2, 6, 1] } else { &[2, 1] };
    let west = format!("{FOUR} name=West {west}");
    let minor = "highway=residential lanes=2 sidewalk=no";
    let ways: [(i64, &[i64], &str); 4] =
        [(10, along, &west), (11, &[1, 3], FOUR), (12, &[4, 1], minor), (13, &[1, 5], minor)];
    built_as(&Asked { nodes: &nodes, ways: &ways, options })
}

/// The lanelets of the western arm.
fn west(map: &LaneletMap) -> Vec<&Lanelet> {
    map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("road_name", "West")).collect()
}

/// The lanelets that follow a lanelet.
fn behind<'m>(map: &'m LaneletMap, lanelet: &Lanelet) -> Vec<&'m Lanelet> {
    let end = ends(map, lanelet)[1];
    map.lanelets.iter().filter(|next| ends(map, next)[0] == end).collect()
}

fn inside(lanelet: &Lanelet) -> bool {
    lanelet.attributes.has("intersection_area")
}

fn length(map: &LaneletMap, bound: Bound) -> f64 {
    map.bound_line(bound).windows(2).map(|w| (w[1] - w[0]).norm()).sum()
}

/// The markings and lengths, metres, of the lines between lanes of one direction: before the intersection, and all others.
fn between(map: &LaneletMap) -> [Vec<(String, f64)>; 2] {
    let mut uses: BTreeMap<(i64, bool), Vec<&Lanelet>> = BTreeMap::new();
    for lanelet in west(map) {
        for bound in [lanelet.left, lanelet.right] {
            uses.entry((bound.line.0, bound.inverted)).or_default().push(lanelet);
        }
    }
    let mut found = [Vec::new(), Vec::new()];
    for ((line, inverted), lanelets) in uses.into_iter().filter(|(_, lanelets)| lanelets.len() == 2) {
        let bound = Bound { line: crate::lanelet::LineStringId(line), inverted };
        let attributes = &map.linestrings.get(bound.line).unwrap().attributes;
        let paint = ["subtype", "lane_change"].map(|key| attributes.get(key).unwrap_or_default());
        let before = lanelets.iter().all(|lanelet| behind(map, lanelet).iter().any(|next| inside(next)));
        found[usize::from(!before)].push((paint.join(" "), length(map, bound)));
    }
    found
}

fn paints(found: &[(String, f64)]) -> Vec<&str> {
    found.iter().map(|(paint, _)| &paint[..]).collect()
}

#[test]
fn lanes_are_not_changed_on_the_approach_to_lights() {
    for side in [DrivingSide::Right, DrivingSide::Left] {
        let map = built(&Crossing { side, ..LIGHTS }).map;
        let [before, others] = between(&map);
        assert_eq!(paints(&before), ["solid no"]);
        assert!((before[0].1 - 30.0).abs() < 0.01, "{} m", before[0].1);
        // The rest of the approach, and two pieces of what leads away.
        assert_eq!(paints(&others), ["dashed yes"; 3]);
        assert_eq!(west(&map).len(), 8);
    }
}

#[test]
fn neighbours_share_bounds_and_followers_share_nodes() {
    for side in [DrivingSide::Right, DrivingSide::Left] {
        let map = built(&Crossing { side, west: "cycleway:both=lane", ..LIGHTS }).map;
        let beside = |lanelet: &&Lanelet| lanelet.attributes.is("subtype", "bicycle_lane") && !inside(lanelet);
        let bicycles: Vec<&Lanelet> = map.lanelets.iter().filter(beside).collect();
        assert_eq!(bicycles.len(), 4);
        let mut uses: BTreeMap<i64, usize> = BTreeMap::new();
        for lanelet in west(&map).into_iter().chain(bicycles.iter().copied()) {
            for bound in [lanelet.left, lanelet.right] {
                *uses.entry(bound.line.0).or_default() += 1;
            }
        }
        // Six strips, two pieces each: five lines in common and two kerbs.
        assert_eq!((uses.len(), uses.values().filter(|uses| **uses == 2).count()), (14, 10));
        let follows = |lanelet: &&Lanelet| behind(&map, lanelet).len() == 1 && !inside(behind(&map, lanelet)[0]);
        let count = west(&map).into_iter().filter(follows).count();
        assert_eq!((count, bicycles.into_iter().filter(follows).count()), (4, 2), "pieces that a piece follows");
    }
}

#[test]
fn the_last_piece_has_the_elements_of_the_stop_line() {
    // Elements of lights hang on the lanelets behind the line; those of stop signs on the ones before it.
    let map = built(&Crossing { rule: "highway=stop stop=all", ..LIGHTS }).map;
    let signed = |lanelet: &&Lanelet| {
        let own = lanelet.regulatory_elements.iter().filter_map(|id| map.regulatory_elements.get(*id));
        own.filter(|element| element.subtype == "traffic_sign").count() == 1
    };
    let west = west(&map);
    let last = |lanelet: &&Lanelet| behind(&map, lanelet).iter().any(|next| inside(next));
    assert_eq!(west.iter().copied().filter(signed).count(), 2);
    assert!(west.iter().copied().filter(signed).all(|lanelet| last(&lanelet)));
    let key = |lanelet: &Lanelet| ["road_id", "speed_limit"].map(|key| lanelet.attributes.get(key).map(str::to_owned));
    assert!(west.iter().all(|lanelet| key(lanelet) == key(west[0]) && key(lanelet)[0].is_some()));
}

#[test]
fn the_piece_under_a_crosswalk_has_its_element() {
    for (walk, last) in [(90.0, false), (35.0, true)] {
        let map = built(&Crossing { side: DrivingSide::Left, walk: Some(walk), ..LIGHTS }).map;
        let crosswalk = map.regulatory_elements.iter().find(|element| element.subtype == "crosswalk").unwrap();
        let touches = |lanelet: &Lanelet| {
            let [start, end] = ends(&map, lanelet);
            map.lanelets
                .iter()
                .filter(|way| inside(way))
                .map(|way| ends(&map, way))
                .any(|way| way[0] == end || way[1] == start)
        };
        let on = west(&map).into_iter().filter(|lanelet| lanelet.regulatory_elements.contains(&crosswalk.id));
        assert_eq!(on.map(touches).collect::<Vec<_>>(), [last; 4], "{walk} m before the crossing");
    }
}

#[test]
fn a_short_road_keeps_half_of_its_length_to_change_lanes() {
    let of = |length: f64| between(&built(&Crossing { length, ..LIGHTS }).map);
    let [before, others] = of(60.0);
    let rest: Vec<f64> = others.iter().map(|(_, length)| *length).collect();
    assert_eq!(paints(&before), ["solid no"]);
    assert!(before[0].1 > 10.0 && before[0].1 < 30.0);
    assert!(rest.iter().any(|rest| (rest - before[0].1).abs() < 0.02), "half of the way");
    let [before, _] = of(30.0);
    assert_eq!(paints(&before), ["dashed yes"], "too short for both");
}

#[test]
fn tags_and_settings_override_the_usual_length() {
    let tagged = |west: &str| between(&built(&Crossing { west, ..LIGHTS }).map)[0].clone();
    assert_eq!(paints(&tagged("change:lanes:forward=yes|yes")), ["dashed yes"]);
    assert_eq!(paints(&tagged("change:lanes:forward=not_right|yes")), ["solid_dashed "], "by side");
    assert_eq!(paints(&tagged("lane_markings=no")), [" yes"]);
    let wanted = |metres: f64| between(&built(&Crossing { before_stop: Some(metres), ..LIGHTS }).map)[0].clone();
    assert_eq!(paints(&wanted(0.0)), ["dashed yes"]);
    let twenty = wanted(20.0);
    assert!((twenty[0].1 - 20.0).abs() < 0.01 && twenty[0].0 == "solid no");
}

#[test]
fn lanes_are_not_changed_before_and_on_a_crosswalk_with_lights() {
    for (side, sign) in [(DrivingSide::Right, 1.0), (DrivingSide::Left, -1.0)] {
        let nodes =
            [(1, -150.0, 0.0, ""), (2, 0.0, 0.0, "highway=crossing crossing=traffic_signals"), (3, 150.0, 0.0, "")];
        let ways: [(i64, &[i64], &str); 1] = [(10, &[1, 2, 3], FOUR)];
        let map = built_as(&Asked { nodes: &nodes, ways: &ways, options: driven_on(side) }).map;
        let crosswalk = map.lanelets.iter().find(|lanelet| lanelet.attributes.is("subtype", "crosswalk")).unwrap();
        let corners = map.outline(crosswalk);
        let middle = nalgebra::center(&corners[0], &corners[2]);
        // Of the lanes that head east: where each line between them begins and ends, and what is painted.
        let mut found: Vec<(i64, i64, String)> = Vec::new();
        for line in &map.linestrings {
            let places: Vec<_> = line.points.iter().map(|id| map.points.get(*id).unwrap().position).collect();
            let paint = ["subtype", "lane_change"].map(|key| line.attributes.get(key).unwrap_or_default()).join(" ");
            let off = (places[0].y - middle.y) * sign;
            if line.attributes.is("type", "line_thin") && (-4.5..-1.5).contains(&off) {
                let ends =
                    [places[0], places[places.len() - 1]].map(|place| ((place.x - middle.x) * 2.0).round() as i64);
                found.push((ends[0].min(ends[1]), ends[0].max(ends[1]), paint));
            }
        }
        found.sort();
        // In half metres; the first and the last reach to the ends of the road.
        let (first, last) = (found[0].0, found[found.len() - 1].1);
        let dashed = [(first, -67), (7, 67), (67, last)].map(|(from, to)| (from, to, "dashed yes".to_owned()));
        let solid = [(-67, -7), (-7, 7)].map(|(from, to)| (from, to, "solid no".to_owned()));
        let mut expected: Vec<_> = dashed.into_iter().chain(solid).collect();
        expected.sort();
        assert_eq!(found, expected, "{side:?}");
    }
}

#[test]
fn without_control_there_is_no_approach() {
    let [before, others] = between(&built(&Crossing { rule: "", ..LIGHTS }).map);
    assert_eq!((paints(&before), paints(&others)), (vec!["dashed yes"], vec!["dashed yes"]));
}
