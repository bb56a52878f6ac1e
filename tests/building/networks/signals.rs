//! Virtual traffic lights, signal phases and arrows.

use std::collections::{BTreeMap, BTreeSet};

use lanewright::builder::Built;
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::lanelet::{LaneletId, LaneletMap, LineStringId, RegulatoryElement, Target};
use lanewright::settings::{Document, Settings};

use super::{MIDDLE, SIDES, built, crossing, elements, found, network, place, referrers, signalised_crossing, undrawn};

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
        let lights = elements(map, "virtual_traffic_light");
        assert_eq!(lights.len(), 8);
        for light in lights {
            let count = |role| light.linestrings(role).count();
            assert_eq!([count("start_line"), count("ref_line"), count("end_line"), count("refers")], [1, 1, 3, 1]);
            assert_eq!(referrers(map, light).len(), 3);
            let anchor = map.linestrings.get(light.linestrings("refers").next().unwrap()).unwrap();
            assert!(anchor.attributes.is("type", "intersection_coordination") && anchor.attributes.has("section"));
        }
        let inside = map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("intersection_area")).count();
        assert_eq!(elements(map, "right_of_way").len(), inside, "each lanelet yields all whom it meets");
    }
}

#[test]
fn a_start_line_that_has_no_room_is_no_light() {
    let built = coordinated(DrivingSide::Right, "start = 120.0,");
    let said = undrawn(&built);
    assert_eq!(said.len(), 2, "the two approaches between the crossings");
    assert!(said.iter().all(|said| said.contains("m of road, so that `start` is")), "{said:?}");
    assert_eq!(elements(&built.map, "virtual_traffic_light").len(), 6);
    // Nothing tells who goes first between the two approaches without a light.
    assert!(found(&built.map, &built.settings).iter().all(|code| code == "vm-03-11/priority-unknown"));
}

#[test]
fn a_virtual_traffic_light_that_lacks_something_is_found() {
    let Built { map, settings, .. } = coordinated(DrivingSide::Left, "");
    let codes = |change: &dyn Fn(&mut RegulatoryElement), subtype: &str| {
        let mut map = map.clone();
        let id = elements(&map, subtype)[0].id;
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
        elements(&map, "virtual_traffic_light").iter().map(|light| light.linestrings(role).next().unwrap()).collect()
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

/// The settings that are written beside a map, read again.
fn read_again(settings: &Settings) -> Settings {
    Document::parse("lanewright.toml", &toml::to_string(settings).unwrap()).unwrap().settings
}

/// Of each lanelet inside the others that it may ignore.
fn ignored(map: &LaneletMap) -> Vec<(LaneletId, Vec<LaneletId>)> {
    let listed = elements(map, "right_of_way").into_iter().map(|element| {
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
            let built = built(&signalised_crossing(side), side, &settings);
            assert_eq!(undrawn(&built), Vec::<&str>::new(), "{side:?} {phases}");
            let settings = read_again(&built.settings);
            let mut found = found(&built.map, &settings);
            // What the planner makes of approaches that cross and are green together is told, and right.
            found.retain(|code| !code.starts_with("planner/") || !phases.contains("\"S\", \"E\""));
            assert_eq!(found, Vec::<String>::new(), "{side:?} {phases}");
            (ignored(&built.map), built)
        };
        let bare = built(&signalised_crossing(side), side, "");
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
    let said_of_lit = said(&signalised_crossing(side));
    let told = "lanewright.toml:1: phases[1] is not heeded: 7 has no traffic lights; there are none but those of ";
    assert!(said_of_lit.len() == 1 && said_of_lit[0].starts_with(told), "{said_of_lit:?}");
    let unlit = said(&crossing(side, "", "highway=residential lanes=2"));
    assert!(unlit.len() == 4 && unlit.iter().all(|said| said.ends_with("there are none here")), "{unlit:?}");
}

/// Per light of drivers the arrow that it has, and where those go that obey it.
fn arrows(map: &LaneletMap) -> Vec<(Option<&str>, BTreeSet<&str>)> {
    let mut ruled: BTreeMap<LineStringId, BTreeSet<&str>> = BTreeMap::new();
    for element in elements(map, "traffic_light") {
        let bulbs = element.linestrings("light_bulbs").next().unwrap();
        let lanes = referrers(map, element);
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
            let built = built(&signalised_crossing(side), side, &settings);
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
