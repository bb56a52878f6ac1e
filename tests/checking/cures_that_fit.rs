//! What `check` advises where the usual cure of a fault would not mend the map, or would spoil it.

use lanewright::diagnostic::{Diagnostic, Edit, Subject};
use lanewright::lanelet::{Evidence, inferred_projector};
use lanewright::osm::OsmData;
use lanewright::projection::Projector;

use crate::common::drawing::Drawing;

use super::strangers_maps::{Sheet, found};

fn of_code(data: &OsmData, code: &str) -> Vec<Diagnostic> {
    found(data).into_iter().filter(|one| one.code == code).collect()
}

#[test]
fn a_lane_without_length_is_told_of_once() {
    let mut sheet = Sheet::default();
    let [left, right] = sheet.nodes([[0.0, 3.5], [0.0, 0.0]]);
    sheet.road(&[left, left], &[right, right], "");
    let data = sheet.drawing.data();
    let counts =
        ["zero-length", "loop", "repeated-point"].map(|fault| of_code(&data, &format!("health/{fault}")).len());
    assert_eq!(counts, [1, 0, 0]);
}

/// A lane without heights, and a light above it with the height `ele`.
fn lane_below_light(ele: &str) -> OsmData {
    let mut drawing = Drawing::default();
    for (id, [x, y]) in [(1, [0.0, 3.5]), (2, [40.0, 3.5]), (3, [0.0, 0.0]), (4, [40.0, 0.0])] {
        drawing.node(id, [""; 2], &format!("local_x={x} local_y={y}"));
    }
    for (id, x) in [(5, 44.0), (6, 45.0)] {
        drawing.node(id, [""; 2], &format!("local_x={x} local_y=2 {ele}"));
    }
    drawing.way(11, [1, 2], "type=road_border");
    drawing.way(12, [3, 4], "type=road_border");
    drawing.way(13, [5, 6], "type=traffic_light subtype=red_yellow_green height=0.5");
    drawing.relation(
        21,
        &[("left", 11), ("right", 12)],
        "type=lanelet subtype=road location=urban speed_limit=40 one_way=yes",
    );
    drawing.data()
}

#[test]
fn a_road_does_not_lie_as_high_as_the_lights_above_it() {
    let mended = |ele: &str| {
        let all = of_code(&lane_below_light(ele), "node/no-ele");
        let of_lane = all.iter().filter(|one| matches!(one.finding.subject, Subject::Point(1..=4)));
        of_lane.map(|one| one.finding.fix.is_some()).collect::<Vec<_>>()
    };
    assert_eq!(mended("ele=5"), [false; 4], "5 m is the height of the light");
    // Where no point has a height, all load at 0.
    assert!(mended("").iter().all(|fixed| *fixed));
}

#[test]
fn an_empty_turn_direction_goes_where_no_intersection_is_marked() {
    let crossing = |tags: &str| {
        let mut sheet = Sheet::default();
        let [a, b, c, d] = sheet.nodes([[-40.0, 1.5], [40.0, 1.5], [-40.0, -1.5], [40.0, -1.5]]);
        let turn = sheet.road(&[a, b], &[c, d], tags);
        let [e, f, g, h] = sheet.nodes([[-1.5, -40.0], [-1.5, 40.0], [1.5, -40.0], [1.5, 40.0]]);
        sheet.road(&[e, f], &[g, h], "");
        (sheet.drawing.data(), turn)
    };
    let (data, turn) = crossing("turn_direction=");
    let all = of_code(&data, "vm-03-02/turn-invalid");
    let [one] = &all[..] else { panic!("{} findings", all.len()) };
    let fix = one.finding.fix.as_ref().unwrap();
    assert_eq!(fix.edits, [Edit::RemoveTag { on: Subject::Lanelet(turn), key: "turn_direction".into() }]);
    assert!(fix.safe, "an empty value says nothing");
    // A word tells that an intersection was to be drawn.
    let (data, _) = crossing("turn_direction=ahead");
    let all = of_code(&data, "vm-03-02/turn-invalid");
    let edits = all.iter().filter_map(|one| one.finding.fix.as_ref()).flat_map(|fix| &fix.edits);
    assert!(all.len() == 1 && edits.into_iter().all(|edit| !matches!(edit, Edit::RemoveTag { .. })));
}

#[test]
fn few_degrees_do_not_outweigh_many_metres() {
    let with_degrees = |count: usize| {
        let mut drawing = Drawing::default();
        for at in 0..40 {
            let place = if at < count { ["35.68", "139.69"] } else { ["0.0", "0.0"] };
            drawing.node(at + 1, place, &format!("local_x={} local_y=0 ele=1", 5 * at));
        }
        inferred_projector(&drawing.data())
    };
    for few in [0, 1, 2] {
        let inferred = with_degrees(few);
        assert_eq!((inferred.projector, inferred.evidence), (Projector::Local, Evidence::NoDegrees), "{few} of 40");
    }
    assert_ne!(with_degrees(20).projector, Projector::Local);
}

#[test]
fn the_lanelet_that_is_missing_in_a_roundabout_is_told_of_once() {
    let ring = |is_listed: bool| {
        let mut sheet = Sheet::default();
        let rows = [3.5, 0.0].map(|y| sheet.nodes([0.0, 20.0, 40.0, 60.0].map(|x| [x, y])));
        let lanes: Vec<i64> = (0..3).map(|at| sheet.road(&rows[0][at..at + 2], &rows[1][at..at + 2], "")).collect();
        let mut members = vec![("entry", 'r', lanes[0]), ("exit", 'r', lanes[2])];
        if is_listed {
            members.push(("internal", 'r', lanes[1]));
        }
        sheet.drawing.members(3001, &members, "type=regulatory_element subtype=roundabout");
        (sheet.drawing.data(), lanes[1])
    };
    let (data, link) = ring(false);
    let all = of_code(&data, "roundabout/apart");
    let [one] = &all[..] else { panic!("{} findings", all.len()) };
    assert_eq!(one.finding.subject, Subject::Lanelet(link));
    assert_eq!(one.help.as_deref(), Some("List it in the element with the role internal."));
    assert_eq!(of_code(&ring(true).0, "roundabout/apart").len(), 0);
}
