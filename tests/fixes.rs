//! The edits that rules propose.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must stop")]

mod common;

use std::path::Path;

use common::{judge, load};
use lanewright::diagnostic::{Diagnostic, Edit, Subject};
use lanewright::settings::Settings;

/// The first finding of a rule's bad map that has this code.
fn finding(rule: &str, map: &str, code: &str) -> Diagnostic {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/rules").join(rule).join(map);
    let (_, loaded) = load(&path);
    judge(&loaded, &Settings::default()).into_iter().find(|diagnostic| diagnostic.code == code).unwrap()
}

fn edits(diagnostic: &Diagnostic) -> &[Edit] {
    &diagnostic.finding.fix.as_ref().unwrap().edits
}

#[test]
fn pieces_are_merged_point_by_point() {
    let found = finding("vm-03-05", "bad-divided.osm", "vm-03-05/divided");
    let merged = edits(&found);
    // Ways 141 and 143 get the far points of 142 and 144 (nodes 4 and 5, the lanes' ends in the east).
    assert_eq!(merged[0], Edit::InsertVertex { way: Subject::LineString(141), position: 2, point: 4 });
    assert_eq!(merged[1], Edit::InsertVertex { way: Subject::LineString(143), position: 2, point: 5 });
    let (role, member) = ("right_of_way".into(), Subject::Lanelet(217));
    assert!(merged.contains(&Edit::RemoveMember { on: Subject::RegulatoryElement(311), role, member }));
    for subject in [Subject::Lanelet(217), Subject::LineString(142), Subject::LineString(144)] {
        assert!(merged.contains(&Edit::Remove { subject }), "{subject} stays");
    }
}

#[test]
fn a_missing_node_goes_between_its_neighbours() {
    let found = finding("vm-03-08", "bad-lane-node-missing.osm", "vm-03-08/lane-node-missing");
    // The outline begins with the kerb, then the south and the north end of the lanes; node 2 lies between the two.
    assert_eq!(edits(&found), [Edit::InsertVertex { way: Subject::Polygon(150), position: 2, point: 2 }]);
}

#[test]
fn a_label_follows_the_shape() {
    let found = finding("vm-03-02", "bad-turn-mismatch.osm", "vm-03-02/turn-mismatch");
    let on = Subject::Lanelet(213);
    assert_eq!(edits(&found), [Edit::SetTag { on, key: "turn_direction".into(), value: "right".into() }]);
}

#[test]
fn a_blinker_starts_behind_the_turn_before() {
    let found = finding("vm-03-02", "bad-turn-signal-overlap.osm", "vm-03-02/turn-signal-overlap");
    let on = Subject::Lanelet(214);
    let [Edit::SetTag { on: set_on, key, value }] = edits(&found) else { panic!("{found:?}") };
    assert_eq!((*set_on, key.as_str()), (on, "turn_signal_distance"));
    assert!((29.9..=30.0).contains(&value.parse::<f64>().unwrap()), "{value}");
}
