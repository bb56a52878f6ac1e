//! Lanelets for both directions, of which `fix` makes one for each.

use std::convert::Infallible;

use lanewright::fix::{Mended, mend};
use lanewright::lanelet::LaneletMap;
use lanewright::lanelet::index::MapIndex;
use lanewright::osm::OsmData;
use lanewright::rules::Config;
use lanewright::settings::Settings;

use crate::common::drawing::osm;
use crate::common::judging::{judge_as, loaded};

/// Two lanelets of 22 m in a row, with these values of `one_way`, the first with a crosswalk and a traffic light.
fn drawn(one_way: [&str; 2]) -> OsmData {
    let node = |id: usize, x: f64, y: f64| {
        format!("<node id='{id}' lat='{}' lon='{}'><tag k='ele' v='10'/></node>", 35.2553 + y, 139.7257 + x)
    };
    let nodes: String = (0..3)
        .map(|at| at as f64 * 2.4e-4)
        .enumerate()
        .fold(String::new(), |all, (at, x)| all + &node(at + 1, x, 3e-5) + &node(at + 4, x, 0.0));
    let ways = [(10, 1, 2), (11, 4, 5), (12, 2, 3), (13, 5, 6)].map(|(id, a, b)| {
        format!("<way id='{id}'><nd ref='{a}'/><nd ref='{b}'/><tag k='type' v='road_border'/></way>")
    });
    let light = "<way id='14'><nd ref='2'/><nd ref='5'/><tag k='type' v='traffic_light'/></way>";
    let elements = ["crosswalk", "traffic_light"].map(|subtype| {
        let id = if subtype == "crosswalk" { 30 } else { 31 };
        format!(
            "<relation id='{id}'><member type='way' ref='14' role='refers'/><tag k='type' v='regulatory_element'/>\
             <tag k='subtype' v='{subtype}'/></relation>"
        )
    });
    let named = [
        "<member type='relation' ref='30' role='regulatory_element'/><member type='relation' ref='31' role='regulatory_element'/>",
        "",
    ];
    let lanelets = [0, 1].map(|at| {
        format!(
            "<relation id='{}'><member type='way' ref='{}' role='left'/><member type='way' ref='{}' role='right'/>{}\
             <tag k='type' v='lanelet'/><tag k='subtype' v='road'/><tag k='location' v='urban'/>\
             <tag k='one_way' v='{}'/><tag k='speed_limit' v='30'/></relation>",
            20 + at,
            10 + 2 * at,
            11 + 2 * at,
            named[at],
            one_way[at]
        )
    });
    osm(format!("<osm version='0.6'>{nodes}{}{light}{}{}</osm>", ways.concat(), elements.concat(), lanelets.concat()))
}

/// Mended as far as the rule on the direction goes.
fn mended(data: OsmData, unsafe_too: bool) -> (Mended, LaneletMap) {
    let (settings, config) = (Settings::default(), Config::default());
    let judge = |data: &OsmData| {
        let mut found = judge_as(&loaded(data), &settings, &config);
        found.retain(|one| one.code == "vm-01-01/one-way");
        Ok::<_, Infallible>(found)
    };
    let mended = mend(data, unsafe_too, judge).unwrap();
    let map = loaded(&mended.osm).map;
    (mended, map)
}

/// How many lanelets there are, how many of them are one-way, and how many pairs follow each other.
fn counts(map: &LaneletMap) -> [usize; 3] {
    let settings = Settings::default();
    let index = MapIndex::new(map, &[], &settings);
    let one_way = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("one_way", "yes")).count();
    let following = (0..index.lanes.len()).map(|lane| index.followers(lane).len()).sum();
    [index.lanes.len(), one_way, following]
}

#[test]
fn whoever_could_drive_back_still_can() {
    let (mended, map) = mended(drawn(["no", "no"]), true);
    assert!(mended.left.is_empty() && mended.refused.is_empty());
    assert_eq!(counts(&map), [4, 4, 2]);
    // The light faces one direction only, and nobody knows which.
    let elements = |id: i64| -> usize {
        map.lanelets.iter().filter(|one| one.regulatory_elements.iter().any(|element| element.0 == id)).count()
    };
    assert_eq!([elements(30), elements(31)], [2, 1]);
}

#[test]
fn a_direction_that_leads_nowhere_is_none() {
    for one_way in [["no", "yes"], ["yes", "true"]] {
        let (mended, map) = mended(drawn(one_way), true);
        assert!(mended.left.is_empty());
        assert_eq!(counts(&map), [2, 2, 1], "{one_way:?}");
    }
}

#[test]
fn a_second_direction_wants_a_look() {
    let (mended, map) = mended(drawn(["no", "no"]), false);
    assert_eq!((mended.left.len(), counts(&map)[0]), (2, 2));
}

#[test]
fn a_lane_beside_the_lane_of_the_other_direction_is_one_way() {
    let text = drawn(["no", "no"]).sources[0].text.clone();
    // The upper bound of the first lanelet gets a lanelet on its other side.
    let nodes =
        [(7, 0.0), (8, 2.4e-4)].map(|(id, x)| format!("<node id='{id}' lat='35.25536' lon='{}'/>", 139.7257 + x));
    let beside = format!(
        "{}<way id='15'><nd ref='8'/><nd ref='7'/><tag k='type' v='road_border'/></way>\
         <relation id='22'><member type='way' ref='10' role='left'/><member type='way' ref='15' role='right'/>\
         <tag k='type' v='lanelet'/><tag k='subtype' v='road'/><tag k='location' v='urban'/><tag k='one_way' v='yes'/>\
         <tag k='speed_limit' v='30'/></relation></osm>",
        nodes.concat()
    );
    let (mended, map) = mended(osm(text.replace("</osm>", &beside)), true);
    assert!(mended.left.is_empty() && mended.refused.is_empty());
    // Nothing leads on from the second one in the other direction, either: the lane beside the first starts elsewhere.
    assert_eq!(counts(&map)[..2], [3, 3], "no lanelet is made");
}
