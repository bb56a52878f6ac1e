//! Tests of what lanes do whose arrows lead across others.

use super::lane_across;

/// A lane on the right whose arrow leads to a road on the left of where the others go straight on: the arrow is meant for the next
/// intersection.
#[test]
fn a_lane_that_crosses_several_leads_where_the_one_beside_it_does() {
    assert_eq!(lane_across(&[vec![0], vec![2], vec![2], vec![1]]), Some((3, 2)));
    assert_eq!(lane_across(&[vec![1], vec![0], vec![0], vec![2]]), Some((0, 0)));
}

/// Of two lanes that cross each other nobody knows which arrow is wrong.
#[test]
fn of_two_lanes_that_cross_none_is_chosen() {
    assert_eq!(lane_across(&[vec![1], vec![0]]), None);
    assert_eq!(lane_across(&[vec![0, 1], vec![1], vec![1, 2]]), None, "neighbours may lead to the same road");
}
