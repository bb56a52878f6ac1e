//! Spellings of bus lanes, shared lanes and lists, beside the usual ones.

use super::*;

#[test]
fn every_word_for_buses_against_a_one_way_road_is_known() {
    expect("oneway=yes lanes=2 psv:lanes:backward=yes", "B< D>");
    expect("oneway=yes lanes=3 busway:both=lane oneway:bus=no", "B< D> B>");
    expect("oneway=yes lanes=2 busway=opposite", "B< D>");
    expect("oneway=yes lanes=2 psv=opposite", "B< D>");
    expect("oneway=-1 lanes=2 bus=opposite", "D< B>");
    expect("oneway=yes lanes=1 busway=opposite", "D>");
    expect("lanes=2 busway:left=opposite_lane", "B< D>");
    expect("lanes=2 psv=opposite_lane", "B< D>");
}

#[test]
fn lists_of_access_may_name_those_who_may_pass() {
    expect("oneway=yes lanes=3 access:lanes=yes|yes|psv", "D> D> B>");
    expect("oneway=yes lanes=3 motor_vehicle:lanes=||bus;taxi", "D> D> B>");
    expect("oneway=yes lanes=2 vehicle:lanes=|agricultural|bicycle", "D> _> C>");
    expect("oneway=yes lanes=2 vehicle:lanes=|emergency psv:lanes=|yes", "D> B>");
    expect("oneway=yes lanes=2 motor_vehicle:lanes=yes|private", "D> D>");
}

#[test]
fn bicycles_share_bus_lanes_that_their_list_opens() {
    let shared = |text: &str| {
        let (layout, _) = read(&tags(text), RoadClass::Residential, DrivingSide::Right);
        layout.section.strips.iter().map(|strip| strip.bicycles).collect::<Vec<_>>()
    };
    assert_eq!(shared("oneway=yes lanes=2 bus:lanes=|designated bicycle:lanes=|yes"), [false, true]);
    assert_eq!(
        shared("oneway=yes lanes=2 access:lanes=|no psv:lanes=|yes bicycle:lanes=yes|designated"),
        [false, true]
    );
    assert_eq!(shared("oneway=yes lanes=2 bus:lanes=|designated bicycle:lanes=|no"), [false, false]);
    assert_eq!(shared("oneway=yes lanes=2 bus:lanes:backward=designated bicycle:lanes:backward=yes"), [true, false]);
    assert_eq!(
        shared("oneway=yes lanes=3 busway=opposite_lane cycleway=opposite_share_busway lanes:bus:forward=1"),
        [true, false, false]
    );
}

#[test]
fn lists_that_fit_no_number_of_lanes_are_told() {
    for text in ["lanes=2 turn:lanes=left|through|right", "lanes=3 turn:lanes=left|", "lanes=2 bus:lanes=designated"] {
        assert!(slugs(&format!("oneway=yes {text}")).contains(&"lanes-contradict"), "{text}");
    }
    for text in [
        "lanes=3 turn:lanes=left||",
        "lanes=2 bicycle:lanes=||designated",
        "lanes=3 lanes:psv:backward=1 turn:lanes=left|",
    ] {
        assert!(!slugs(&format!("oneway=yes {text}")).contains(&"lanes-contradict"), "{text}");
    }
}

#[test]
fn the_only_lane_may_be_for_both_directions() {
    expect("lanes=1 lanes:both_ways=1", "D=");
    assert!(!slugs("lanes=1 lanes:both_ways=1").contains(&"lanes-contradict"));
    assert!(slugs("lanes=2 lanes:both_ways=1").contains(&"lanes-contradict"));
}

#[test]
fn bicycles_against_the_traffic_ride_so_on_either_side() {
    expect("oneway=yes cycleway:right=opposite_lane", "D> C<");
    expect("oneway=yes cycleway:left=opposite_lane", "C< D>");
    expect("oneway=-1 cycleway:left=opposite_track", "C> D<");
}

#[test]
fn lists_of_all_lanes_include_those_against_the_cars() {
    for list in ["psv:lanes=designated|no", "psv:lanes=designated|", "access:lanes=psv|yes"] {
        expect(&format!("oneway=yes oneway:psv=no lanes=2 {list}"), "B< D>");
    }
    expect("oneway=yes oneway:psv=no lanes=3 psv:lanes=designated||designated", "B< D> B>");
    expect("oneway=yes oneway:bus=no lanes=2 access:lanes=no| bus:lanes=designated|", "B< D>");
    expect("oneway=-1 busway=opposite_lane lanes=3 bus:lanes=||yes", "D< D< B>");
    expect("oneway=yes lanes=3 lanes:backward=1 bus:lanes=designated||", "B< D> D>");
    // The list of the direction of the cars.
    expect("oneway=yes oneway:bus=no lanes=3 bus:lanes=|designated", "B< D> B>");
    expect("oneway=yes lanes=2 bus:lanes=designated|", "B> D>");
    expect("oneway=yes oneway:bus=no lanes=2 bus:lanes=yes|designated", "B< D> B>");
    let road = expect("oneway=yes oneway:bus=no lanes=2 bus:lanes=designated| width:lanes=3.5|3", "B< D>");
    assert_eq!(road.section.strips.iter().map(|strip| strip.width).collect::<Vec<_>>(), [3.5, 3.0]);
}

#[test]
fn lists_of_all_lanes_follow_the_numbers_of_each_direction() {
    expect("lanes=3 lanes:backward=1 bus:lanes=||designated", "D< D> B>");
    expect("lanes=3 lanes:forward=1 bus:lanes=designated||", "B< D< D>");
    expect("lanes=4 lanes:both_ways=1 lanes:forward=1 bus:lanes=designated|||", "B< D< D= D>");
    let road = expect("lanes=3 lanes:backward=1 width:lanes=4|3|3.5 maxspeed:lanes=30|50|60", "D< D> D>");
    assert_eq!(road.section.strips.iter().map(|strip| strip.width).collect::<Vec<_>>(), [4.0, 3.0, 3.5]);
    assert_eq!(road.section.strips.iter().map(|strip| strip.speed).collect::<Vec<_>>(), [30.0, 50.0, 60.0].map(Some));
}

#[test]
fn lists_that_lack_a_direction_are_told() {
    for text in [
        "lanes=3 turn:lanes=left|through|right",
        "lanes=4 change:lanes=yes|no|no|yes",
        "lanes=3 lanes:backward=1 bus:lanes=|designated",
    ] {
        assert!(slugs(text).contains(&"lanes-contradict"), "{text}");
    }
    for text in [
        "lanes=2 turn:lanes:forward=left turn:lanes:backward=right turn:lanes=left|right",
        "lanes=2 width:lanes=3|3",
        "lanes=2 hov:lanes=|",
    ] {
        assert!(!slugs(text).contains(&"lanes-contradict"), "{text}");
    }
}

#[test]
fn a_bus_lane_at_the_near_side_takes_a_lane_before_buses_against_the_traffic_do() {
    expect("oneway=yes oneway:bus=no lanes=2 busway:right=lane", "D> B>");
    expect("oneway=yes oneway:bus=no lanes=2 busway=lane", "D> B>");
    expect("oneway=-1 oneway:bus=no lanes=2 busway:left=lane", "B< D<");
    expect("oneway=yes oneway:bus=no lanes=3 busway:right=lane", "B< D> B>");
    assert!(slugs("oneway=yes oneway:bus=no lanes=2 busway:right=lane").contains(&"lanes-guessed"));
}

#[test]
fn a_bus_lane_may_be_for_both_directions() {
    expect("lanes=3 lanes:bus:both_ways=1", "D< B= D>");
    expect("lanes=3 lanes:both_ways=1 lanes:psv:both_ways=1", "D< B= D>");
    expect("oneway=yes lanes=2 lanes:bus:both_ways=1", "B= D>");
    expect("oneway=-1 lanes=3 lanes:psv:both_ways=1", "D< D< B=");
}

#[test]
fn a_track_of_buses_beside_the_road_is_told() {
    for key in ["busway", "busway:left", "busway:both"] {
        expect(&format!("oneway=yes lanes=2 {key}=opposite_track"), "D> D>");
        assert!(slugs(&format!("oneway=yes lanes=2 {key}=opposite_track")).contains(&"lanes-guessed"), "{key}");
    }
}

#[test]
fn more_lanes_than_tagged_are_told() {
    for (text, is_told) in [
        ("oneway=yes lanes=1 busway=lane", false),
        ("oneway=yes lanes=2 busway:both=lane oneway:bus=no", true),
        ("oneway=yes lanes=2 busway=lane", false),
        ("oneway=yes lanes=1 bicycle:lanes=|designated", false),
        ("lanes=4 busway=lane", false),
    ] {
        assert_eq!(slugs(text).iter().any(|slug| slug.starts_with("lanes-")), is_told, "{text}");
    }
}

#[test]
fn a_road_without_a_lane_for_cars_is_told() {
    for text in ["oneway=yes lanes=1 bus:lanes=designated", "lanes=2 busway=opposite_lane bus:lanes=|designated"] {
        assert!(slugs(text).contains(&"lanes-contradict"), "{text}");
    }
    assert!(!slugs("oneway=yes lanes=2 bus:lanes=|designated").contains(&"lanes-contradict"));
}
