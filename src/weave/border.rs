//! The borders of a lane before its ends are stitched: its middle line, moved to both sides.

use crate::geometry::{Point, Polyline, Vector, curve::untangled, left_of, miter::miter};

use super::lane::{Shape, Widths};

/// A corner is mitred as long as the miter lies within so many times the offset, and cut straight across beyond.
const MITER_MOST: f64 = 3.0;

/// The left and the right border of a lane, in its direction of travel.
pub fn borders(shape: &Shape) -> [Vec<Point>; 2] {
    match shape {
        Shape::Between(bounds) => bounds.clone().map(Polyline::into_points),
        Shape::Along(middle, widths) => beside(middle, widths),
    }
}

fn beside(middle: &Polyline, widths: &Widths) -> [Vec<Point>; 2] {
    let corners = corners(middle, widths);
    let mut sides = [0, 1].map(|_| Vec::with_capacity(corners.len() + 1));
    for Corner { place, station, directions } in corners {
        let [left, right] = widths.at(station);
        // The miter is so many times the offset away as the cosine of half the turn goes into one.
        let sharp = (1.0 + directions[0].dot(&directions[1])) * MITER_MOST * MITER_MOST < 2.0;
        for (side, offset) in sides.iter_mut().zip([left, -right]) {
            if sharp {
                side.extend(directions.map(|d| place + left_of(d) * offset));
            } else {
                side.push(miter(place, directions, offset));
            }
        }
    }
    sides.map(|side| untangled(&side))
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
    use super::*;
    use crate::weave::WidthAt;

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
}
