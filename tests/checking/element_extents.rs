//! How far the parts of an element may lie from each other.

use lanewright::osm::OsmData;

use super::strangers_maps::{Sheet, found};
use crate::common::drawing::osm;

/// A lane of this length (m) with a stop sign at its end, of which the sign stands so far (m) behind the line.
fn lane_with_sign(length: f64, behind: f64) -> OsmData {
    let mut sheet = Sheet::default();
    let [left, right] = sheet.nodes([[-length, 2.0], [-length, -2.0]]);
    let end = sheet.nodes([[0.0, 2.0], [0.0, -2.0]]);
    let lane = sheet.road(&[left, end[0]], &[right, end[1]], "");
    let post = sheet.nodes([[behind, -4.0], [behind, -5.0]]);
    let line = sheet.way(&end, "type=stop_line");
    let sign = sheet.way(&post, "type=traffic_sign subtype=stop_sign");
    sheet.drawing.relation(
        3000,
        &[("refers", sign), ("ref_line", line)],
        "type=regulatory_element subtype=traffic_sign",
    );
    let lanelet = format!("<relation id='{lane}'>");
    let element = "<member type='relation' role='regulatory_element' ref='3000'/>";
    osm(sheet.drawing.xml().replace(&lanelet, &format!("{lanelet}{element}")))
}

#[test]
fn a_long_lane_makes_no_sign_large() {
    let is_large = |length: f64, behind: f64| {
        found(&lane_with_sign(length, behind)).iter().any(|one| one.code == "vm-02-02/sign-extent")
    };
    assert!(!is_large(90.0, 1.0));
    assert!(!is_large(390.0, 1.0));
    assert!(is_large(90.0, 300.0), "the sign stands elsewhere");
}
