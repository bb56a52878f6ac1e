//! The centre line of a lanelet as Lanelet2 draws it if the map has none. Lanelet2 walks along both bounds at once: its next step
//! leads, on either side, to the nearest point of the bound that can be seen from the point reached on the other bound.

use geo::{Coord, Intersects, Line};
use rstar::primitives::{GeomWithData, Line as Segment};
use rstar::{AABB, RTree};

use super::view::{Seen, Spot, View, spot};
use crate::geometry::{Point as Place, orientation};
use crate::lanelet::Point;

/// Places nearer to each other than this (m) are one.
const SAME_PLACE: f64 = 1e-9;

/// Length of a lanelet in space, along its own centre line or the one that Lanelet2 draws.
pub fn length(view: &View, seen: &Seen) -> f64 {
    let own = seen.lanelet.centerline.and_then(|id| view.map.linestrings.get(id));
    length_in_space(&match own {
        Some(line) => view.points(line).into_iter().map(spot).collect(),
        None => middle(&seen.left, &seen.right),
    })
}

/// The length in the plane that counts for routes of Lanelet2: the length of the left bound, of which Lanelet2 skips some points.
pub fn length_for_routes(seen: &Seen) -> f64 {
    let step = (seen.left.len() / 10).max(1);
    let points = seen.left.iter().step_by(step).chain(seen.left.last()).map(|point| point.position);
    let points: Vec<Place> = points.collect();
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

fn length_in_space(points: &[Spot]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// A bound with an index of its segments.
struct Side<'a, 'm> {
    points: &'a [&'m Point],
    by_place: RTree<GeomWithData<[f64; 2], usize>>,
    segments: RTree<GeomWithData<Segment<[f64; 2]>, usize>>,
}

impl<'a, 'm> Side<'a, 'm> {
    fn new(points: &'a [&'m Point]) -> Self {
        let at = |point: &Point| [point.position.x, point.position.y];
        let places = points.iter().enumerate().map(|(i, point)| GeomWithData::new(at(point), i));
        let segment = |(i, pair): (usize, &[&Point])| GeomWithData::new(Segment::new(at(pair[0]), at(pair[1])), i);
        let segments = points.windows(2).enumerate().map(segment);
        Self { points, by_place: RTree::bulk_load(places.collect()), segments: RTree::bulk_load(segments.collect()) }
    }

    fn place(&self, at: usize) -> Place {
        self.points[at].position
    }

    /// Whether a stretch meets a segment of the bound of which the ends, as given, do not excuse it.
    fn meets(&self, [a, b]: [Place; 2], excused: impl Fn([Place; 2]) -> bool) -> bool {
        let corners = AABB::from_corners([a.x, a.y], [b.x, b.y]);
        let mut near = self.segments.locate_in_envelope_intersecting(&corners).map(|one| one.data);
        near.any(|at| {
            let segment = [self.place(at), self.place(at + 1)];
            meet([a, b], segment) && !excused(segment)
        })
    }
}

fn meet(a: [Place; 2], b: [Place; 2]) -> bool {
    let [a, b] = [a, b].map(|ends| {
        let [from, to] = ends.map(|p| Coord { x: p.x, y: p.y });
        Line::new(from, to)
    });
    a.intersects(&b)
}

fn same(a: Place, b: Place) -> bool {
    (a - b).norm() < SAME_PLACE
}

/// The way along both bounds.
struct Walk<'a, 'm> {
    sides: [Side<'a, 'm>; 2],
    /// Where the bounds begin and end, drawn so that the lanelet lies to the right.
    ends: [[Place; 2]; 2],
}

impl Walk<'_, '_> {
    /// Whether a step lies inside the lanelet completely.
    fn is_inside(&self, stretch: [Place; 2]) -> bool {
        let starts_there = |segment: [Place; 2]| same(segment[0], stretch[0]);
        let leaves = |&[a, b]: &[Place; 2]| meet(stretch, [a, b]) && orientation(a, b, stretch[1]) > 0.0;
        !self.sides.iter().any(|side| side.meets(stretch, starts_there)) && !self.ends.iter().any(leaves)
    }

    /// Whether `point` can be seen from another: the line between them meets the bound of `point` only there.
    fn is_seen(&self, point: Place, from: Place, side: usize) -> bool {
        let ends_there = |segment: [Place; 2]| segment.iter().any(|end| same(*end, point));
        !self.sides[side].meets([from, point], ends_there)
    }

    /// The point of a side behind `passed` that is nearest to the point reached on the other side, and its distance, metres.
    fn next(&self, side: usize, passed: usize, beside: Place, last: Place) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let reached = (beside - last).norm();
        for candidate in self.sides[side].by_place.nearest_neighbor_iter(&[beside.x, beside.y]) {
            let at = candidate.data;
            if at <= passed {
                continue;
            }
            let place = self.sides[side].place(at);
            let distance = (place - beside).norm() / 2.0;
            match best {
                Some((_, least)) if distance - reached > least => break,
                Some((_, least)) if least <= distance => continue,
                _ => {}
            }
            let seen = self.is_inside([last, nalgebra::center(&beside, &place)])
                && self.is_seen(place, beside, side)
                && self.is_seen(beside, place, 1 - side);
            if seen {
                best = Some((at, distance));
            }
        }
        best
    }
}

/// The points midway between two bounds.
fn middle(left: &[&Point], right: &[&Point]) -> Vec<Spot> {
    let (Some(&first), Some(&last)) = (left.first(), left.last()) else { return Vec::new() };
    let (Some(&beside), Some(&beside_last)) = (right.first(), right.last()) else { return Vec::new() };
    let between = |a: &Point, b: &Point| nalgebra::center(&spot(a), &spot(b));
    let ends = [[beside.position, first.position], [last.position, beside_last.position]];
    let walk = Walk { sides: [Side::new(left), Side::new(right)], ends };
    let mut points = vec![between(first, beside)];
    // A lanelet that begins in a point begins with the next one on its left.
    let mut at = [usize::from(first.id == beside.id), 0];
    while at[0] < left.len() {
        let back = points[points.len() - 1];
        let back = Place::new(back.x, back.y);
        let [on_left, on_right] = [0, 1].map(|side| {
            let beside = walk.sides[1 - side].place(at[1 - side]);
            walk.next(side, at[side], beside, back)
        });
        match (on_left, on_right) {
            (Some((next, distance)), other) if other.is_none_or(|(_, beside)| distance <= beside) => at[0] = next,
            (_, Some((next, _))) => at[1] = next,
            _ => break,
        }
        points.push(between(left[at[0]], right[at[1]]));
    }
    if at != [left.len() - 1, right.len() - 1] {
        points.push(between(last, beside_last));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanelet::PointId;

    fn points(places: &[(f64, f64)]) -> Vec<Point> {
        let ids = (1..).map(PointId);
        places.iter().zip(ids).map(|(&(x, y), id)| Point::new(id, Place::new(x, y), None)).collect()
    }

    /// A bend of two lines with another number of points, and what Lanelet2 makes of it.
    #[test]
    fn the_middle_of_a_bend_is_that_of_lanelet2() {
        let left =
            points(&[(1.755_80, 8.130_18), (9.200_17, 8.372_10), (15.047_30, 11.899_75), (17.027_77, 19.751_88)]);
        let mut right = points(&[(1.864_15, 4.796_08), (10.779_33, 5.642_08), (20.786_06, 18.761_49)]);
        right.iter_mut().for_each(|point| point.id.0 += 100);
        let [left, right] = [&left, &right].map(|bound| bound.iter().collect::<Vec<_>>());
        let drawn = middle(&left, &right);
        let expected = [
            (1.809_98, 6.463_13),
            (5.532_16, 6.584_09),
            (9.989_75, 7.007_09),
            (12.913_32, 8.770_91),
            (17.916_68, 15.330_62),
            (18.906_92, 19.256_68),
        ];
        assert_eq!(drawn.len(), expected.len());
        for (found, (x, y)) in drawn.iter().zip(expected) {
            assert!((found.xy() - Place::new(x, y)).norm() < 2e-5, "{found} is not {x}, {y}");
        }
    }

    #[test]
    fn a_bound_without_points_has_no_middle() {
        let left = points(&[(0.0, 0.0), (1.0, 0.0)]);
        assert_eq!(middle(&left.iter().collect::<Vec<_>>(), &[]), Vec::<Spot>::new());
    }
}
