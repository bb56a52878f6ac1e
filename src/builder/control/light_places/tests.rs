//! Tests of where lights stand.

use super::*;
use crate::geometry::Polyline;

fn ring(places: &[[f64; 2]]) -> Vec<Point> {
    places.iter().map(|[x, y]| Point::new(*x, *y)).collect()
}

/// The place of a light for a lane that arrives at the origin northward, its kerb on the right.
fn place(area: &[[f64; 2]], lanelets: &[&[[f64; 2]]]) -> Point {
    let ground =
        LightGround { rings: vec![ring(area)], lanelets: lanelets.iter().map(|it| ring(it)).collect(), arms: &[] };
    let [start, heading, kerbward] = [Vector::zeros(), Vector::new(0.0, 1.0), Vector::new(1.0, 0.0)];
    ground.place(&LightAim { start: Point::from(start), heading, kerbward, half: 1.5 })
}

fn distance(lanelet: &[[f64; 2]], place: Point) -> f64 {
    let closed: Vec<[f64; 2]> = lanelet.iter().chain(lanelet.first()).copied().collect();
    Polyline::new(ring(&closed)).map_or(f64::INFINITY, |line| line.distance(place))
}

const ACROSS: [[f64; 2]; 4] = [[-20.0, 10.0], [20.0, 10.0], [20.0, 13.0], [-20.0, 13.0]];

#[test]
fn behind_the_far_edge_where_a_lane_runs_along_it() {
    assert_eq!(place(&[[-20.0, 0.0], [20.0, 0.0], [20.0, 13.0], [-20.0, 13.0]], &[&ACROSS]), Point::new(0.0, 14.0));
}

#[test]
fn not_behind_an_arm_of_the_area_that_is_not_ahead() {
    // To the right the area reaches 30 m farther: the light stands where the lane leaves the area.
    let area = [[-20.0, 0.0], [20.0, 0.0], [20.0, 43.0], [15.0, 43.0], [15.0, 13.0], [-20.0, 13.0]];
    assert_eq!(place(&area, &[&ACROSS]), Point::new(0.0, 14.0));
}

#[test]
fn beside_bare_ground_where_a_lane_is() {
    // Ahead lies ground without lanes; 7 m to the right a lane leads out.
    let out = [[7.0, 0.0], [10.0, 0.0], [10.0, 30.0], [7.0, 30.0]];
    let at = place(&[[-20.0, 0.0], [20.0, 0.0], [20.0, 25.0], [-20.0, 25.0]], &[&out]);
    assert_eq!(at.y, 26.0);
    assert!(at.x > 0.0 && (distance(&out, at) <= FROM_LANE), "{at}");
}

#[test]
fn at_the_near_kerb_where_the_far_side_is_out_of_sight() {
    let out = [[-1.5, 0.0], [1.5, 0.0], [1.5, 70.0], [-1.5, 70.0]];
    assert_eq!(place(&[[-20.0, 0.0], [20.0, 0.0], [20.0, 70.0], [-20.0, 70.0]], &[&out]), Point::new(2.5, 0.0));
}
