//! Lanes that begin or end where the streets lead nowhere: a note if the input says so, a finding if the build ended them.

use lanewright::builder::Built;
use lanewright::diagnostic::Severity;
use lanewright::lanelet::{Lanelet, Loaded};
use lanewright::settings::Settings;

use crate::common::judging::judge;

use super::{AGAINST_A_ONE_WAY_STREET, SIDES, built, network_of};

#[test]
fn a_one_way_street_that_begins_where_none_leads_is_a_note() {
    for side in SIDES {
        // It begins 40 m beside another street, and ends at that behind it.
        let nodes = [
            (1, -200.0, 300.0, ""),
            (2, 200.0, 300.0, ""),
            (3, 200.0, 40.0, ""),
            (4, 200.0, -300.0, ""),
            (5, 0.0, -300.0, ""),
            (6, -200.0, -300.0, ""),
            (7, -200.0, 40.0, ""),
            (8, 0.0, 0.0, ""),
            (9, 0.0, 41.0, ""),
        ];
        let street = "highway=residential";
        let ways: [(i64, &[i64], &str); 3] = [
            (11, &[1, 2, 3, 4, 5, 6, 7, 1], street),
            (12, &[7, 9, 3], street),
            (13, &[8, 5], "highway=residential oneway=yes"),
        ];
        let Built { map, settings, notes, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let told: Vec<&str> =
            notes.iter().filter(|note| note.fault == "lane-closed").map(|note| &*note.message).collect();
        assert_eq!(told, ["way 13 is one-way, and no road leads to where it begins"], "{side:?}");
        let graded = |settings: &Settings| {
            let found = judge(&Loaded { map: map.clone(), faults: Vec::new() }, settings);
            let unreachable = found.into_iter().filter(|it| it.code == "health/unreachable");
            unreachable.map(|it| it.severity).collect::<Vec<_>>()
        };
        assert_eq!(graded(&settings), [Severity::Info], "{side:?}");
        assert_eq!(graded(&Settings::default()), [Severity::Warning], "{side:?}");
    }
}

#[test]
fn a_one_way_street_that_the_build_ends_is_a_note_only_if_restrictions_close_it() {
    for side in SIDES {
        // A one-way street leads into another: across it, or almost against it.
        let ends = |bend: (f64, f64), restriction: &str| {
            let nodes = [(1, 0.0, 0.0, ""), (2, 0.0, -150.0, ""), (3, 0.0, 150.0, ""), (4, bend.0, bend.1, "")];
            let oneway = "highway=residential oneway=yes";
            let ways: [(i64, &[i64], &str); 3] = [(12, &[2, 1], oneway), (13, &[1, 3], oneway), (14, &[4, 1], oneway)];
            let xml = network_of(side, &nodes, &ways).replace("</osm>", &format!("{restriction}</osm>"));
            let Built { map, settings, notes, .. } = built(&xml, side, "");
            assert!(notes.iter().all(|note| note.message != "way 14 is one-way, and no road leads on where it ends"));
            let closed = notes.iter().filter(|note| note.fault == "lanes-unreachable").map(|note| note.message.clone());
            let last = closed.map(|told| told.rsplit(": ").next().unwrap().to_owned()).collect::<Vec<_>>();
            let named = map.lanelets.iter().filter(|lanelet| settings.loose_ends.ends.contains(&lanelet.id.0));
            let street = |lanelet: &&Lanelet| lanelet.attributes.get("road_id").is_some_and(|id| id.starts_with("14:"));
            (last, named.filter(street).count())
        };
        let forbidden = "<relation id='20'><member type='way' role='from' ref='14'/><member type='node' role='via' ref='1'/>\
                         <member type='way' role='to' ref='13'/><tag k='type' v='restriction'/>\
                         <tag k='restriction' v='no_entry'/></relation>";
        assert_eq!(ends((-120.0, 0.0), ""), (vec![], 0), "{side:?}");
        assert_eq!(ends((-120.0, 0.0), forbidden), (vec!["restrictions forbid every turn".into()], 1), "{side:?}");
        assert_eq!(ends((-20.0, 118.0), ""), (vec!["there is no room for the turns".into()], 0), "{side:?}");
    }
}

#[test]
fn a_single_track_loses_a_direction_beyond_the_place_where_its_tags_change() {
    for side in SIDES {
        // A track, which is a bridge farther on.
        let nodes = [&AGAINST_A_ONE_WAY_STREET[..], &[(9, 120.0, 100.0, ""), (10, 120.0, -100.0, "")]].concat();
        let ways: [(i64, &[i64], &str); 4] = [
            (11, &[1, 2, 3], "highway=secondary oneway=yes lanes=1"),
            (12, &[2, 4, 5, 6, 7], "highway=track tracktype=grade1"),
            (13, &[7, 8], "highway=track tracktype=grade1 bridge=yes layer=1"),
            (14, &[9, 8, 10], "highway=residential"),
        ];
        let Built { map, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let lanelets = |way: &str| {
            let of_way = |lane: &&Lanelet| lane.attributes.get("road_id").is_some_and(|id| id.starts_with(way));
            map.lanelets.iter().filter(of_way).count()
        };
        assert_eq!(["12:", "13:"].map(lanelets), [1, 1], "{side:?}");
    }
}

/// At the edge of the data a two-way street meets a one-way street that leads against it.
#[test]
fn a_street_that_loses_a_direction_meets_the_next_face_to_face() {
    let nodes =
        [(1, -220.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 60.0, 3.0, ""), (4, -220.0, 80.0, ""), (5, -220.0, -80.0, "")];
    let ways: [(i64, &[i64], &str); 4] = [
        (11, &[1, 2, 99], "highway=primary"),
        (12, &[3, 2], "highway=tertiary oneway=yes"),
        (13, &[4, 1], "highway=primary"),
        (14, &[5, 1], "highway=primary"),
    ];
    for side in SIDES {
        let Built { map, .. } = built(&network_of(side, &nodes, &ways), side, "");
        let is_between = |lane: &&Lanelet| !lane.attributes.has("road_id") && !lane.attributes.has("intersection_area");
        assert_eq!(map.lanelets.iter().filter(is_between).count(), 0, "{side:?}");
        assert_eq!(map.lanelets.iter().filter(|lane| lane.attributes.has("road_id")).count(), 6, "{side:?}");
    }
}
