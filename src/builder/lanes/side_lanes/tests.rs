//! Side lanes on small networks.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tests::{Asked, built_as, driven_on, ends, of_subtype};
use crate::builder::{BuildOptions, Built};
use crate::geometry::left_of;
use crate::lanelet::{Lanelet, LaneletMap};

use super::*;

/// A street from west to east of two ways, with these tags.
fn street(first: &str, second: &str, options: BuildOptions) -> Built {
    let nodes = [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 60.0, 0.0, "")];
    // Of unlike class: ways that differ in nothing become one road.
    let tags = [format!("highway=residential lanes=2 {first}"), format!("highway=unclassified lanes=2 {second}")];
    built_as(&Asked { nodes: &nodes, ways: &[(10, &[1, 2], &tags[0]), (11, &[2, 3], &tags[1])], options })
}

fn right() -> BuildOptions {
    driven_on(DrivingSide::Right)
}

/// Lanelets of a subtype that share a border with this one.
fn neighbours(map: &LaneletMap, lanelet: &Lanelet, subtype: &str) -> usize {
    let lines = |lanelet: &Lanelet| [lanelet.left.line, lanelet.right.line];
    let shares = |other: &&&Lanelet| other.id != lanelet.id && lines(other).iter().any(|l| lines(lanelet).contains(l));
    of_subtype(map, subtype).iter().filter(shares).count()
}

fn line_type(map: &LaneletMap, bound: Bound) -> &str {
    map.linestrings.get(bound.line).and_then(|line| line.attributes.get("type")).unwrap()
}

#[test]
fn a_bicycle_lane_shares_its_border_with_the_lane_and_runs_as_it_does() {
    for (options, near) in [(right(), "right"), (driven_on(DrivingSide::Left), "left")] {
        let built = street("cycleway:both=lane", "cycleway:both=lane", options);
        let bicycles = of_subtype(&built.map, "bicycle_lane");
        assert_eq!(bicycles.len(), 4);
        for lane in bicycles {
            assert_eq!(neighbours(&built.map, lane, "road"), 1);
            // The kerb lies on the near side: the lanelet runs as the lane beside it does.
            let outer = if near == "right" { lane.right } else { lane.left };
            assert_eq!(line_type(&built.map, outer), "road_border");
            let inner = if near == "right" { lane.left } else { lane.right };
            let line = built.map.linestrings.get(inner.line).unwrap();
            assert!(line.attributes.is("lane_change", "no") && line.attributes.is("subtype", "solid"));
        }
    }
}

#[test]
fn a_side_lane_continues_one_of_the_same_use_on_the_next_road() {
    let follow = |map: &LaneletMap, subtypes: [&str; 2]| {
        let (before, after) = (of_subtype(map, subtypes[0]), of_subtype(map, subtypes[1]));
        before.iter().flat_map(|a| after.iter().map(move |b| (a, b))).any(|(a, b)| ends(map, a)[1] == ends(map, b)[0])
    };
    let same = street("cycleway:right=lane parking:right=lane", "cycleway:right=lane parking:right=lane", right()).map;
    assert!(follow(&same, ["bicycle_lane"; 2]) && follow(&same, ["road_shoulder"; 2]));
    // A shoulder as wide as the bicycle lane before it is no continuation of that.
    let other = street("cycleway:right=lane", "shoulder:right=yes shoulder:right:width=1.5", right()).map;
    assert_eq!([of_subtype(&other, "bicycle_lane").len(), of_subtype(&other, "road_shoulder").len()], [1, 1]);
    assert!(follow(&other, ["road"; 2]) && !follow(&other, ["bicycle_lane", "road_shoulder"]));
}

#[test]
fn parked_cars_and_a_shoulder_are_one_shoulder_behind_the_bicycle_lane() {
    let tags = "cycleway:right=lane cycleway:right:buffer=0.5 parking:right=lane shoulder:right=yes";
    let built = street(tags, tags, right());
    let shoulders = of_subtype(&built.map, "road_shoulder");
    assert_eq!(shoulders.len(), 2);
    for shoulder in shoulders {
        assert_eq!(neighbours(&built.map, shoulder, "bicycle_lane"), 1);
        assert_eq!(line_type(&built.map, shoulder.right), "road_border");
    }
    for lane in of_subtype(&built.map, "bicycle_lane") {
        assert_eq!(neighbours(&built.map, lane, "road"), 1, "the painted buffer belongs to the bicycle lane");
    }
}

#[test]
fn people_on_foot_have_a_pedestrian_lane_beside_the_lane() {
    let built = street("pedestrian_lane=right", "pedestrian_lane:both=yes", right());
    let strips = of_subtype(&built.map, "pedestrian_lane");
    assert_eq!(strips.len(), 3);
    for strip in strips {
        assert_eq!(neighbours(&built.map, strip, "road"), 1);
        assert_eq!(line_type(&built.map, strip.right), "road_border");
    }
}

#[test]
fn no_side_lane_is_drawn_without_tags_or_against_the_settings() {
    let subtypes = ["bicycle_lane", "road_shoulder", "pedestrian_lane"];
    let plain = street("sidewalk=both", "", right()).map;
    assert!(subtypes.iter().all(|subtype| of_subtype(&plain, subtype).is_empty()));
    let none = BesideSettings {
        bicycle_lanes: BicycleLanes::None,
        shoulders: false,
        parking: false,
        pedestrian_lanes: false,
        walkways: false,
    };
    let tags = "cycleway:right=lane parking:left=lane shoulder:right=yes pedestrian_lane:left=yes";
    let silent = street(tags, tags, BuildOptions { beside: none, ..right() }).map;
    assert!(subtypes.iter().all(|subtype| of_subtype(&silent, subtype).is_empty()));
    let earlier = BesideSettings { bicycle_lanes: BicycleLanes::Road, ..none };
    let earlier = street("", "cycleway:right=lane", BuildOptions { beside: earlier, ..right() }).map;
    assert!(of_subtype(&earlier, "bicycle_lane").is_empty());
    let road = of_subtype(&earlier, "road");
    assert_eq!(road.iter().filter(|lane| !lane.attributes.has("participant:vehicle")).count(), 1);
}

#[test]
fn a_crosswalk_with_signals_has_a_light_at_both_ends() {
    for options in [right(), driven_on(DrivingSide::Left)] {
        let nodes =
            [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, "highway=crossing crossing=traffic_signals"), (3, 60.0, 0.0, "")];
        let ways: [(i64, &[i64], &str); 1] = [(10, &[1, 2, 3], "highway=residential lanes=2")];
        let map = built_as(&Asked { nodes: &nodes, ways: &ways, options }).map;
        let lights: Vec<_> = map.linestrings.iter().filter(|line| line.attributes.is("subtype", "red_green")).collect();
        assert_eq!(lights.len(), 2);
        let crosswalk = of_subtype(&map, "crosswalk")[0];
        let element = map.regulatory_elements.iter().find(|element| element.subtype == "traffic_light").unwrap();
        assert!(crosswalk.regulatory_elements.contains(&element.id));
        assert!(element.members.iter().all(|member| member.role != "ref_line"));
        for light in lights {
            // Left to right for those who come from the other end: the middle of the road lies before the light.
            let at = |i: usize| map.points.get(light.points[i]).unwrap().position;
            let ahead = left_of(at(1) - at(0));
            let outline = map.outline(crosswalk);
            let middle = nalgebra::center(&outline[0], &outline[2]);
            assert!(ahead.dot(&(at(0) - middle)) > 0.0, "a light shows its back");
        }
    }
}
