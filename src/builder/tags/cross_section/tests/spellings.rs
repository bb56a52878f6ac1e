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
