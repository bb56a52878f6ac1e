//! Numbers of Boost.Geometry 1.74 for rings that cross themselves.

use super::*;

type Corners<'a> = &'a [(f64, f64)];

/// Whether the insides of two rings meet, and their common area, as they are and after they are turned.
fn common(a: Corners, b: Corners) -> (bool, f64, f64) {
    let [a, b] = [a, b].map(|ring| ring.iter().map(|&(x, y)| Point::new(x, y)).collect::<Vec<_>>());
    let rounded = |area: f64| (area * 1e6).round() / 1e6;
    (insides_meet(&a, &b), rounded(common_area(&a, &b)), rounded(common_area_turned(&a, &b)))
}

const SQUARE: Corners = &[(0.0, 0.0), (0.0, 4.0), (4.0, 4.0), (4.0, 0.0)];
const BESIDE: Corners = &[(4.0, 0.0), (4.0, 4.0), (6.0, 4.0), (6.0, 0.0)];

#[test]
fn plain_rings_have_in_common_what_they_cover_together() {
    assert_eq!(common(SQUARE, SQUARE), (true, 16.0, 16.0));
    assert_eq!(common(SQUARE, BESIDE), (false, 0.0, 0.0));
    assert_eq!(common(SQUARE, &[(3.0, 1.0), (3.0, 3.0), (6.0, 3.0), (6.0, 1.0)]), (true, 2.0, 2.0));
    // Inside, along an edge, and without touching.
    assert_eq!(common(SQUARE, &[(1.0, 0.0), (1.0, 2.0), (2.0, 2.0), (2.0, 0.0)]), (true, 2.0, 2.0));
    assert_eq!(common(SQUARE, &[(1.0, 1.0), (1.0, 2.0), (2.0, 2.0), (2.0, 1.0)]), (true, 1.0, 1.0));
}

// The numbers of the following tests are those of Boost.Geometry 1.74.

#[test]
fn a_ring_that_runs_the_other_way_round_is_met_from_outside() {
    let turned: Vec<(f64, f64)> = SQUARE.iter().rev().copied().collect();
    let (meet, _, after) = common(&turned, BESIDE);
    assert_eq!((meet, after), (true, 0.0));
}

#[test]
fn what_lies_beside_a_ring_that_crosses_itself_can_be_covered_by_it() {
    let bow: Corners = &[(0.0, 0.0), (4.0, 5.0), (4.0, 0.0), (0.0, 4.0)];
    assert_eq!(common(bow, &[(-2.0, 0.0), (-2.0, 4.0), (0.0, 4.0), (0.0, 0.0)]), (true, 8.0, 8.0));
    assert_eq!(common(bow, &[(4.0, 0.0), (4.0, 5.0), (6.0, 5.0), (6.0, 0.0)]), (false, 0.0, 0.0));
    assert_eq!(common(bow, &[(3.0, 1.0), (3.0, 3.0), (6.0, 3.0), (6.0, 1.0)]), (true, 2.0, 2.0));
}

#[test]
fn a_walk_along_rings_that_cross_themselves_leaves_parts_out() {
    let twice = [SQUARE, &[(1.0, 1.0), (1.0, 3.0), (3.0, 3.0), (3.0, 1.0)]].concat();
    assert_eq!(common(&twice, &[(2.0, 2.0), (2.0, 3.0), (6.0, 3.0), (6.0, 2.0)]), (true, 1.0, 1.0));
    let looped: Corners = &[(0.0, 0.0), (0.0, 4.0), (6.0, 4.0), (6.0, 2.0), (3.0, 6.0), (3.0, 0.0)];
    let square: Corners = &[(1.0, 1.0), (1.0, 5.0), (5.0, 5.0), (5.0, 1.0)];
    assert_eq!(common(looped, square), (true, 1.041667, 1.041667));
    let pair: Corners = &[(0.0, 0.0), (0.0, 6.0), (5.0, 1.0), (5.0, 5.0)];
    assert_eq!(common(pair, &[(1.0, 1.0), (1.0, 4.0), (4.0, 4.0), (4.0, 2.0)]), (true, 5.5, 5.5));
}
