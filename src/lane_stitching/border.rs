//! The borders of a lane before stitching: its middle line, offset to both sides.

use crate::geometry::curve::untangled;
use crate::geometry::miter::miter;
use crate::geometry::{Point, Polyline, Vector, left_of};

use super::lane::{Shape, Widths};

/// The longest miter as a multiple of the offset. Sharper corners are bevelled.
const MITER_LIMIT: f64 = 3.0;

/// Points of a border closer together than this, metres, count as one.
const MERGE: f64 = 1e-3;

/// The left and the right border of a lane, in its direction of travel.
pub fn borders(shape: &Shape) -> [Vec<Point>; 2] {
    match shape {
        Shape::Between(bounds) => bounds.clone().map(Polyline::into_points),
        Shape::Along(middle, widths) => offset_borders(middle, widths),
    }
}

fn offset_borders(middle: &Polyline, widths: &Widths) -> [Vec<Point>; 2] {
    let capacity = middle.points().len() + 1;
    let mut borders = [0, 1].map(|_| BorderDraft { points: Vec::with_capacity(capacity), folded: false });
    for MiddleVertex { place, station, directions } in vertices(middle, widths) {
        let [left, right] = widths.at(station);
        // The miter lies at the offset divided by the cosine of half the turn.
        let sharp = (1.0 + directions[0].dot(&directions[1])) * MITER_LIMIT * MITER_LIMIT < 2.0;
        for (border, offset) in borders.iter_mut().zip([left, -right]) {
            if !sharp {
                border.push(miter(place, directions, offset), directions[0]);
                continue;
            }
            border.push(place + left_of(directions[0]) * offset, directions[0]);
            if offset.abs() > MERGE {
                border.points.push(place + left_of(directions[1]) * offset);
            }
        }
    }
    // Loops are expensive to find, and only a folded border has one that the middle line does not have.
    borders.map(|border| if border.folded { untangled(&border.points) } else { border.points })
}

struct BorderDraft {
    points: Vec<Point>,
    /// Whether it stops or runs back somewhere, as inside a bend tighter than its offset.
    folded: bool,
}

impl BorderDraft {
    /// Adds the point at the end of a segment of the middle line with this direction.
    fn push(&mut self, point: Point, direction: Vector) {
        self.folded |= self.points.last().is_some_and(|last| (point - last).dot(&direction) <= MERGE);
        self.points.push(point);
    }
}

/// A vertex of the middle line.
struct MiddleVertex {
    place: Point,
    station: f64,
    /// The unit directions before and after it.
    directions: [Vector; 2],
}

/// The vertices of the middle line, and the points at which its width begins to change.
fn vertices(middle: &Polyline, widths: &Widths) -> Vec<MiddleVertex> {
    let mut vertices: Vec<MiddleVertex> = Vec::with_capacity(middle.points().len());
    let mut changes = widths.stations().peekable();
    let mut before = None;
    let mut station = 0.0;
    for (a, b) in middle.segments() {
        let length = (b - a).norm();
        let direction = (b - a) / length;
        let previous = before.replace(direction).unwrap_or(direction);
        vertices.push(MiddleVertex { place: a, station, directions: [previous, direction] });
        while let Some(change) = changes.next_if(|change| *change < station + length - Polyline::MERGE) {
            if change > station + Polyline::MERGE {
                let place = a + direction * (change - station);
                vertices.push(MiddleVertex { place, station: change, directions: [direction; 2] });
            }
        }
        station += length;
    }
    if let Some(direction) = before {
        vertices.push(MiddleVertex { place: middle.last(), station, directions: [direction; 2] });
    }
    vertices
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
    fn a_lane_widens_between_its_stations() {
        let at = |station, left| WidthAt { station, left, right: 1.0 };
        let widths = Widths::new(vec![at(10.0, 1.0), at(30.0, 3.0)]).unwrap();
        let [left, right] = offset_borders(&line(&[(0.0, 0.0), (20.0, 0.0), (40.0, 0.0)]), &widths);
        assert_eq!(points(&left), [(0.0, 1.0), (10.0, 1.0), (20.0, 2.0), (30.0, 3.0), (40.0, 3.0)]);
        assert_eq!(points(&right), [(0.0, -1.0), (10.0, -1.0), (20.0, -1.0), (30.0, -1.0), (40.0, -1.0)]);
    }

    #[test]
    fn a_corner_is_mitred_and_a_hairpin_is_bevelled() {
        let even = Widths::even(2.0).unwrap();
        let [_, right] = offset_borders(&line(&[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)]), &even);
        assert_eq!(points(&right), [(0.0, -1.0), (21.0, -1.0), (21.0, 20.0)]);
        let [_, right] = offset_borders(&line(&[(0.0, 0.0), (20.0, 0.0), (0.0, 5.0)]), &even);
        assert_eq!(right.len(), 4);
        assert!(right.iter().all(|p| p.x < 20.3), "{right:?}");
    }

    #[test]
    fn inside_a_bend_tighter_than_its_offset_a_border_has_no_loop() {
        let bend = (0..=9).map(|i| f64::from(i * 10).to_radians().sin_cos());
        let bend = bend.map(|(sin, cos)| (20.0 + sin, 1.0 - cos));
        let points: Vec<_> = [(0.0, 0.0)].into_iter().chain(bend).chain([(21.0, 20.0)]).collect();
        let [left, right] = offset_borders(&line(&points), &Widths::even(3.0).unwrap());
        assert!(left.len() == 3 && right.len() == points.len(), "{left:?}");
    }
}
