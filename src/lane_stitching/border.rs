//! The borders of a lane before its ends are stitched: its middle line, moved to both sides.

use crate::geometry::curve::untangled;
use crate::geometry::miter::miter;
use crate::geometry::{Point, Polyline, Vector, left_of};

use super::lane::{Shape, Widths};

/// A corner is mitred as long as the miter lies within so many times the offset, and cut straight across beyond.
const MITER_MOST: f64 = 3.0;

/// Points of a border closer together than this, metres, are one.
const APART: f64 = 1e-3;

/// The left and the right border of a lane, in its direction of travel.
pub fn borders(shape: &Shape) -> [Vec<Point>; 2] {
    match shape {
        Shape::Between(bounds) => bounds.clone().map(Polyline::into_points),
        Shape::Along(middle, widths) => beside(middle, widths),
    }
}

fn beside(middle: &Polyline, widths: &Widths) -> [Vec<Point>; 2] {
    let mut sides = [0, 1].map(|_| Side::with_room(middle.points().len() + 1));
    for Corner { place, station, directions } in corners(middle, widths) {
        let [left, right] = widths.at(station);
        // The miter is so many times the offset away as the cosine of half the turn goes into one.
        let sharp = (1.0 + directions[0].dot(&directions[1])) * MITER_MOST * MITER_MOST < 2.0;
        for (side, offset) in sides.iter_mut().zip([left, -right]) {
            if !sharp {
                side.go(miter(place, directions, offset), directions[0]);
                continue;
            }
            side.go(place + left_of(directions[0]) * offset, directions[0]);
            if offset.abs() > APART {
                side.points.push(place + left_of(directions[1]) * offset);
            }
        }
    }
    sides.map(Side::into_border)
}

/// A border as it grows.
struct Side {
    points: Vec<Point>,
    /// Whether it stands still or runs back somewhere, as inside a bend tighter than its offset.
    folded: bool,
}

impl Side {
    fn with_room(points: usize) -> Self {
        Self { points: Vec::with_capacity(points), folded: false }
    }

    /// Goes on to a point behind a segment of the middle line with this direction.
    fn go(&mut self, to: Point, direction: Vector) {
        self.folded |= self.points.last().is_some_and(|last| (to - last).dot(&direction) <= APART);
        self.points.push(to);
    }

    /// Without loops. They are dear to look for, and only a border that runs back has one that is not the lane's own.
    fn into_border(self) -> Vec<Point> {
        if self.folded { untangled(&self.points) } else { self.points }
    }
}

/// A point of the middle line.
struct Corner {
    place: Point,
    station: f64,
    /// Unit directions before and behind it.
    directions: [Vector; 2],
}

/// The points of the middle line and those where its width begins to change.
fn corners(middle: &Polyline, widths: &Widths) -> Vec<Corner> {
    let mut corners: Vec<Corner> = Vec::with_capacity(middle.points().len());
    let mut changes = widths.stations().peekable();
    let mut before = None;
    let mut station = 0.0;
    for (a, b) in middle.segments() {
        let length = (b - a).norm();
        let direction = (b - a) / length;
        let behind = before.replace(direction).unwrap_or(direction);
        corners.push(Corner { place: a, station, directions: [behind, direction] });
        while let Some(change) = changes.next_if(|change| *change < station + length - Polyline::MERGE) {
            if change > station + Polyline::MERGE {
                let place = a + direction * (change - station);
                corners.push(Corner { place, station: change, directions: [direction; 2] });
            }
        }
        station += length;
    }
    if let Some(direction) = before {
        corners.push(Corner { place: middle.last(), station, directions: [direction; 2] });
    }
    corners
}

#[cfg(test)]
mod tests {
    use crate::lane_stitching::WidthAt;

    use super::*;

    fn line(points: &[(f64, f64)]) -> Polyline {
        Polyline::new(points.iter().map(|&(x, y)| Point::new(x, y))).unwrap()
    }

    fn points(side: &[Point]) -> Vec<(f64, f64)> {
        side.iter().map(|p| (p.x, p.y)).collect()
    }

    #[test]
    fn a_lane_widens_between_the_stations_that_say_so() {
        let at = |station, left| WidthAt { station, left, right: 1.0 };
        let widths = Widths::new(vec![at(10.0, 1.0), at(30.0, 3.0)]).unwrap();
        let [left, right] = beside(&line(&[(0.0, 0.0), (20.0, 0.0), (40.0, 0.0)]), &widths);
        assert_eq!(points(&left), [(0.0, 1.0), (10.0, 1.0), (20.0, 2.0), (30.0, 3.0), (40.0, 3.0)]);
        assert_eq!(points(&right), [(0.0, -1.0), (10.0, -1.0), (20.0, -1.0), (30.0, -1.0), (40.0, -1.0)]);
    }

    #[test]
    fn a_corner_is_mitred_and_a_hairpin_is_cut_straight_across() {
        let even = Widths::even(2.0).unwrap();
        let [_, right] = beside(&line(&[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)]), &even);
        assert_eq!(points(&right), [(0.0, -1.0), (21.0, -1.0), (21.0, 20.0)]);
        let [_, right] = beside(&line(&[(0.0, 0.0), (20.0, 0.0), (0.0, 5.0)]), &even);
        assert_eq!(right.len(), 4);
        assert!(right.iter().all(|p| p.x < 20.3), "{right:?}");
    }

    #[test]
    fn inside_a_bend_tighter_than_its_offset_a_border_has_no_loop() {
        let bend = (0..=9).map(|i| f64::from(i * 10).to_radians().sin_cos());
        let bend = bend.map(|(sin, cos)| (20.0 + sin, 1.0 - cos));
        let points: Vec<_> = [(0.0, 0.0)].into_iter().chain(bend).chain([(21.0, 20.0)]).collect();
        let [left, right] = beside(&line(&points), &Widths::even(3.0).unwrap());
        assert!(left.len() == 3 && right.len() == points.len(), "{left:?}");
    }
}
