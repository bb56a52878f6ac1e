//! Where a map shows on which side people drive, and what counts as a contradiction.

use super::strangers_maps::{Sheet, found};

/// Whether a map contradicts itself: on a road far away people drive on the right; at an approach from the south the lane out lies on
/// the right, `gap` metres from the lane in.
fn contradicts_itself(gap: f64) -> bool {
    let mut sheet = Sheet::default();
    let [in_left, in_right, out_right, out_left] = [-3.0, 0.0, gap, gap + 3.0];
    let ends = [-60.0, -20.0].map(|y| sheet.nodes([[in_left, y], [in_right, y], [out_right, y], [out_left, y]]));
    let one_road = |[a, b, c, d]: [i64; 4]| if gap == 0.0 { [a, b, b, d] } else { [a, b, c, d] };
    let [far, near] = ends.map(one_road);
    let [west, east] = [-20.0, 20.0].map(|x| sheet.nodes([[x, 2.0], [x, 5.0]]));
    let area = sheet.way(
        &[near[0], west[0], west[1], east[1], east[0], near[3], near[2], near[1]],
        "type=intersection_area area=yes",
    );
    sheet.road(&[far[0], near[0]], &[far[1], near[1]], "");
    sheet.road(&[near[3], far[3]], &[near[2], far[2]], "");
    sheet.road(&[near[0], west[0]], &[near[1], west[1]], &format!("turn_direction=left intersection_area={area}"));
    sheet.road(&[east[0], near[3]], &[east[1], near[2]], &format!("turn_direction=left intersection_area={area}"));
    sheet.people_drive_on_the_right();
    found(&sheet.drawing.data()).iter().any(|one| one.code == "side/inconsistent")
}

#[test]
fn one_pair_of_one_way_roads_may_lie_either_way_around() {
    assert!(contradicts_itself(0.0), "the two lanes of one road");
    assert!(!contradicts_itself(1.0), "the ways in and out of a car park");
}
