//! Turning lanelets that no car can drive, and that can be left out because their lanes have other movements.
//!
//! An intersection that was merged from several can have two lanes that no smooth curve joins: the curve would begin with a corner,
//! swing out far beyond the intersection, or run across the movement from the lane beside it. If other movements leave the first lane
//! and others reach the second, this movement is not needed.

use crate::builder::tags::cross_section::StripKind;
use crate::geometry::{Point, polygon};

use super::movement_types::Movement;
use super::turning_lanelets::TurningLanelet;

/// The largest jump of direction, degrees, between a lane and a turning lanelet.
const CORNER: f64 = 25.0;
/// No car turns on a smaller radius of its lane's middle, metres.
const TIGHT: f64 = 2.1;
/// A lanelet that reaches farther than this, metres, out of the convex hull of roads and lane ends leaves the intersection.
const SWING: f64 = 8.0;
/// Two lanelets that lead to different roads may turn by this angle, degrees, in the wrong order.
const WRONG_ORDER: f64 = 5.0;
/// Lanelets that share less than this, square metres, keep clear of each other.
const CLEAR_OVERLAP: f64 = 0.5;
/// Lanelets that share less than this, square metres, only touch.
const TOUCHING: f64 = 0.01;

/// The movements to leave out: first those that begin or end in a corner, the sharpest first; then those that swing out of the
/// intersection, the farthest first; then of two that run into each other the one that turns more. A movement stays if a lane
/// that leads in would have no other way on, or a lane that leads out would not be reached. `within` are the places at which
/// roads and lanes end, and those of the roads inside.
pub fn undrivable(paths: &[TurningLanelet], within: impl IntoIterator<Item = Point>) -> Vec<Movement> {
    let mut left: Vec<&TurningLanelet> = paths.iter().collect();
    let mut corners: Vec<&TurningLanelet> = paths.iter().filter(|path| begins_or_ends_in_corner(path)).collect();
    corners.sort_by(|a, b| b.corner.total_cmp(&a.corner).then(a.movement.cmp(&b.movement)));
    let mut dropped: Vec<Movement> = corners.into_iter().filter_map(|path| drop_needless(&mut left, path)).collect();
    let hull = polygon::convex_hull(within);
    let swings = paths.iter().map(|path| (swing(&hull, &path.outline), path)).filter(|(far, _)| *far > SWING);
    let mut swinging: Vec<_> = swings.filter(|(_, path)| !dropped.contains(&path.movement)).collect();
    swinging.sort_by(|(a, one), (b, other)| b.total_cmp(a).then(one.movement.cmp(&other.movement)));
    dropped.extend(swinging.into_iter().filter_map(|(_, path)| drop_needless(&mut left, path)));
    for (i, a) in paths.iter().enumerate() {
        for b in paths[i + 1..].iter().take_while(|b| b.movement.from == a.movement.from) {
            if [a, b].iter().all(|path| !dropped.contains(&path.movement)) && run_into_each_other(a, b) {
                let [more, less] = if a.turn.abs() > b.turn.abs() { [a, b] } else { [b, a] };
                dropped.extend(drop_needless(&mut left, more).or_else(|| drop_needless(&mut left, less)));
            }
        }
    }
    dropped.sort_unstable();
    dropped
}

/// Whether a lanelet begins or ends in a corner.
pub fn begins_or_ends_in_corner(path: &TurningLanelet) -> bool {
    path.corner > CORNER
}

/// Movements that no car can drive, though their lanes need them.
#[derive(Debug, Default, PartialEq)]
pub struct UndrivableMovements {
    /// Those that begin or end in a corner, or bend too tightly.
    pub corners: Vec<Movement>,
    /// Those that run into each other.
    pub pairs: Vec<[Movement; 2]>,
}

impl UndrivableMovements {
    /// Of the lanelets of one intersection, in order of their movements.
    pub fn of(paths: &[TurningLanelet]) -> Self {
        let is_undrivable = |path: &&TurningLanelet| begins_or_ends_in_corner(path) || path.radius < TIGHT;
        let corners = paths.iter().filter(is_undrivable).map(|path| path.movement).collect();
        let beside = |(i, a): (usize, &'_ TurningLanelet)| {
            let (from, others) = (a.movement.from, &paths[i + 1..]);
            let into = others.iter().take_while(move |b| b.movement.from == from).filter(|b| run_into_each_other(a, b));
            into.map(|b| [a.movement, b.movement]).collect::<Vec<_>>()
        };
        Self { corners, pairs: paths.iter().enumerate().flat_map(beside).collect() }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.corners.len() + self.pairs.len()
    }
}

/// How far points reach out of a convex ring, which is clockwise, metres, measured from the lines of its edges.
fn swing(hull: &[Point], points: &[Point]) -> f64 {
    let edges = hull.iter().zip(hull.iter().cycle().skip(1));
    let beyond = edges.filter_map(|(a, b)| {
        let along = (b - a).try_normalize(f64::EPSILON)?;
        Some(points.iter().map(|p| along.perp(&(p - a))).fold(0.0, f64::max))
    });
    beyond.fold(0.0, f64::max)
}

/// Removes a lanelet from those that are left if its lanes do not need it.
fn drop_needless(left: &mut Vec<&TurningLanelet>, path: &TurningLanelet) -> Option<Movement> {
    let movement = path.movement;
    let others = || left.iter().map(|path| path.movement).filter(|other| *other != movement);
    let on = others().any(|other| (other.from, other.in_lane) == (movement.from, movement.in_lane));
    let there = others().any(|other| (other.to, other.out_lane) == (movement.to, movement.out_lane));
    if !(on && there) {
        return None;
    }
    left.retain(|other| other.movement != movement);
    Some(movement)
}

/// Whether two lanelets for all vehicles from lanes side by side change sides, or lie over each other and do not become one. Those for
/// buses or bicycles are crossed by what turns off beside them.
fn run_into_each_other(a: &TurningLanelet, b: &TurningLanelet) -> bool {
    let ([one, other], [from, to]) = ([a, b].map(|path| path.movement), [a, b].map(|path| path.movement.in_lane));
    let all_vehicles = [a, b].iter().all(|path| path.kind == StripKind::Drive);
    if !all_vehicles || from.abs_diff(to) != 1 || (one.to, one.out_lane) == (other.to, other.out_lane) {
        return false;
    }
    let [left, right] = if from < to { [a, b] } else { [b, a] };
    let (l, r) = (left.movement, right.movement);
    let shared = || polygon::overlap(&a.outline, &b.outline);
    if l.to == r.to {
        return l.out_lane > r.out_lane || shared() > CLEAR_OVERLAP;
    }
    shared() > if left.turn < right.turn - WRONG_ORDER { TOUCHING } else { CLEAR_OVERLAP }
}

#[cfg(test)]
mod tests {
    use crate::geometry::{Point, Vector};
    use crate::lanelet::{LaneletId, LineStringId};

    use super::*;

    /// A lanelet of 3 m from one place to another, with this turn and corner, degrees.
    fn path(lanes: [usize; 4], [from, to]: [[f64; 2]; 2], [turn, corner]: [f64; 2]) -> TurningLanelet {
        let [from_arm, in_lane, to_arm, out_lane] = lanes;
        let place = |[x, y]: [f64; 2], aside: f64| Point::new(x, y + aside);
        TurningLanelet {
            movement: Movement { from: from_arm, to: to_arm, in_lane, out_lane },
            lanelet: LaneletId(1),
            turn,
            outline: vec![place(from, 1.5), place(to, 1.5), place(to, -1.5), place(from, -1.5)],
            bounds: [LineStringId(1), LineStringId(2)],
            heading: Vector::new(1.0, 0.0),
            corner,
            radius: 10.0,
            sway: 0.0,
            kind: StripKind::Drive,
        }
    }

    #[test]
    fn a_lanelet_with_a_corner_is_dropped_where_both_lanes_have_others() {
        let straight = path([0, 0, 1, 0], [[0.0, 0.0], [20.0, 0.0]], [0.0, 0.0]);
        let corner = path([0, 0, 2, 0], [[0.0, 0.0], [5.0, 9.0]], [90.0, 40.0]);
        let other = path([1, 0, 2, 0], [[20.0, 3.0], [5.0, 9.0]], [-90.0, 0.0]);
        assert_eq!(undrivable(&[straight.clone(), corner.clone(), other.clone()], []), [corner.movement]);
        assert!(undrivable(&[straight, corner.clone()], []).is_empty(), "nobody else leads to the lane");
        assert!(undrivable(&[corner, other], []).is_empty(), "the lane leads nowhere else");
    }

    #[test]
    fn no_car_drives_where_a_lanelet_bends_too_tightly_or_begins_in_a_corner() {
        let path = |corner: f64, radius: f64| TurningLanelet {
            radius,
            ..path([0, 0, 1, 0], [[0.0, 0.0], [20.0, 0.0]], [180.0, corner])
        };
        let count = |corner: f64, radius: f64| UndrivableMovements::of(&[path(corner, radius)]).count();
        assert_eq!([count(0.0, 4.0), count(0.0, 1.9), count(30.0, 4.0), count(30.0, 1.9)], [0, 1, 1, 1]);
    }

    #[test]
    fn a_lanelet_that_swings_out_is_dropped_where_both_lanes_have_others() {
        let straight = path([0, 0, 1, 0], [[0.0, 0.0], [20.0, 0.0]], [0.0, 0.0]);
        let other = path([1, 0, 2, 0], [[20.0, 3.0], [5.0, 9.0]], [-90.0, 0.0]);
        let ends = [[0.0, -2.0], [0.0, 10.0], [20.0, -2.0], [20.0, 10.0]].map(|[x, y]| Point::new(x, y));
        for (far, dropped) in [(27.0, false), (29.0, true)] {
            let mut swinging = path([0, 0, 2, 0], [[0.0, 0.0], [5.0, 9.0]], [90.0, 0.0]);
            swinging.outline.push(Point::new(far, 5.0));
            let paths = [straight.clone(), swinging.clone(), other.clone()];
            let expected = if dropped { vec![swinging.movement] } else { Vec::new() };
            assert_eq!(undrivable(&paths, ends), expected, "{far} m");
        }
    }

    #[test]
    fn of_two_that_change_sides_the_one_that_turns_more_is_dropped() {
        let places = |from: f64, to: f64| [[0.0, from], [20.0, to]];
        // The left lane to the right road, the right lane to the left one; others serve all four.
        let left = path([0, 0, 2, 0], places(3.0, -3.0), [-20.0, 0.0]);
        let right = path([0, 1, 1, 0], places(0.0, 6.0), [40.0, 0.0]);
        let others =
            [path([0, 0, 1, 0], places(3.0, 6.0), [10.0, 0.0]), path([0, 1, 2, 0], places(0.0, -3.0), [-10.0, 0.0])];
        let mut paths = vec![others[0].clone(), left, right.clone(), others[1].clone()];
        paths.sort_by_key(|path| path.movement);
        assert_eq!(undrivable(&paths, []), [right.movement]);
        paths.iter_mut().filter(|path| path.movement.in_lane == 1).for_each(|path| path.kind = StripKind::Bus);
        assert!(undrivable(&paths, []).is_empty(), "cars turn off across a bus lane");
    }
}
