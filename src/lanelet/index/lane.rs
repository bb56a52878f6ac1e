//! A lanelet with its geometry in the direction of travel.

use crate::geometry::{Point, Polyline, Vector, angle_between, polygon, simple_ring};
use crate::lanelet::participants::may_enter;
use crate::lanelet::{Lanelet, LaneletId, LaneletMap, LineStringId, PointId, RoadType};

/// Step along a lanelet at which headings are compared, metres: short enough for the sharpest turn, long enough that
/// the hand of a drawer does not count as a bend.
pub const HEADING_STEP: f64 = 1.0;

/// Length at both ends over which a lanelet's heading is taken, metres.
pub const HEADING_REACH: f64 = 2.0;

/// The tags of lanes in which vehicles reverse: as autoware_core 1.9.0 and autoware_universe 0.52.0 read it, and as it was called
/// before.
const REVERSING: [&str; 2] = ["direction_change", "direction_change_lane"];

/// One end of a lanelet: the line between the last points of its two bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The points, left and right in the direction of travel.
    pub ids: [PointId; 2],
    /// Where they lie.
    pub points: [Point; 2],
}

impl Edge {
    /// Its middle.
    pub fn middle(&self) -> Point {
        nalgebra::center(&self.points[0], &self.points[1])
    }

    /// From left to right.
    pub fn across(&self) -> Vector {
        self.points[1] - self.points[0]
    }

    /// Whether both have a point in common.
    pub fn touches(&self, other: &Self) -> bool {
        self.ids.iter().any(|id| other.ids.contains(id))
    }

    /// Angle between the two lines, degrees, 0..=90.
    pub fn angle_to(&self, other: &Self) -> f64 {
        let angle = angle_between(self.across(), other.across()).abs().to_degrees();
        angle.min(180.0 - angle)
    }

    /// Distance of `p` from the infinite line, metres; from the middle where the edge has no length.
    pub fn distance_from_line(&self, p: Point) -> f64 {
        let along = self.across();
        match along.norm() {
            length if length > Polyline::MERGE => (crate::geometry::cross(along, p - self.points[0]) / length).abs(),
            _ => (p - self.middle()).norm(),
        }
    }
}

/// A lanelet as the rules see it: bounds in the direction of travel, outline, centre line.
#[derive(Clone, Debug)]
pub struct Lane<'m> {
    /// Its id.
    pub id: LaneletId,
    /// The lanelet.
    pub lanelet: &'m Lanelet,
    /// The way of each bound, left and right.
    pub bounds: [LineStringId; 2],
    /// The left bound, from start to end.
    pub left: Vec<Point>,
    /// The right bound, from start to end.
    pub right: Vec<Point>,
    /// Left bound, then the right bound backwards; not closed.
    pub outline: Vec<Point>,
    /// Area of the outline, square metres.
    pub area: f64,
    /// South-west and north-east corner of the outline.
    pub extent: [Point; 2],
    /// Lowest and highest point, metres.
    pub heights: [f64; 2],
    /// Midway between the bounds; `None` if there is nothing to halve.
    pub center: Option<Polyline>,
    length: f64,
    headings: [Option<Vector>; 2],
    /// Where it starts.
    pub start: Edge,
    /// Where it ends.
    pub end: Edge,
    /// Its `subtype`.
    pub kind: RoadType,
    /// Whether Autoware's routing graph for vehicles holds it.
    pub vehicle: bool,
    /// Whether it is a bicycle lane: by its subtype, or a road that the user says is one.
    pub bicycle: bool,
    /// Whether its outline is a simple polygon, so that areas of overlap mean something.
    pub simple: bool,
    /// Whether a lanelet in the other direction lies between the same two ways: such a lane lies on neither side of the
    /// road.
    pub both_ways: bool,
}

impl<'m> Lane<'m> {
    /// From a lanelet of the map; `None` if a bound has fewer than two points or a coordinate is no number.
    pub fn new(map: &LaneletMap, lanelet: &'m Lanelet) -> Option<Self> {
        let edge = |left: &crate::lanelet::Point, right: &crate::lanelet::Point| Edge {
            ids: [left.id, right.id],
            points: [left.position, right.position],
        };
        let points = [lanelet.left, lanelet.right].map(|bound| map.bound_points(bound).collect::<Vec<_>>());
        let [[left_first, .., left_last], [right_first, .., right_last]] = points.each_ref().map(|points| &points[..])
        else {
            return None;
        };
        let [left, right] = points.each_ref().map(|points| points.iter().map(|p| p.position).collect::<Vec<Point>>());
        let outline: Vec<Point> = left.iter().chain(right.iter().rev()).copied().collect();
        if !outline.iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
            return None;
        }
        let heights = points
            .iter()
            .flatten()
            .map(|p| p.ele().unwrap_or(0.0))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
        let center = center_line(&left, &right);
        let length = center.as_ref().map_or(0.0, Polyline::length);
        let headings = center.as_ref().map_or([None; 2], |center| {
            let ends = [center.at(HEADING_REACH) - center.first(), center.last() - center.at(length - HEADING_REACH)];
            ends.map(|along| along.try_normalize(Polyline::MERGE))
        });
        Some(Self {
            id: lanelet.id,
            lanelet,
            bounds: [lanelet.left.line, lanelet.right.line],
            area: polygon::signed_area(&outline).abs(),
            extent: extent(&outline),
            heights,
            headings,
            length,
            center,
            start: edge(left_first, right_first),
            end: edge(left_last, right_last),
            kind: RoadType::of(&lanelet.attributes),
            vehicle: drivable_by_vehicle(lanelet),
            bicycle: RoadType::of(&lanelet.attributes) == RoadType::BicycleLane,
            simple: simple_ring::is_simple(&outline),
            both_ways: false,
            left,
            right,
            outline,
        })
    }

    /// Whether vehicles change between forward and reverse in it: by its tag, or the name that the tag had at first.
    pub fn reverses(&self) -> bool {
        REVERSING.iter().any(|key| self.lanelet.attributes.is(key, "yes"))
    }

    /// A bound as a line, 0 left, 1 right; `None` if it has no length.
    pub fn border(&self, side: usize) -> Option<Polyline> {
        Polyline::new(if side == 0 { &self.left } else { &self.right }.iter().copied())
    }

    /// Whether a car or a bicycle is meant to drive here: `road` and `bicycle_lane`.
    pub fn is_drivable(&self) -> bool {
        self.vehicle || matches!(self.kind, RoadType::Road | RoadType::BicycleLane)
    }

    /// Whether it is meant for cars.
    pub fn is_for_cars(&self) -> bool {
        self.vehicle && !self.bicycle
    }

    /// Whether buses alone drive here: no car is routed over it, yet it is a lane of its road.
    pub fn is_for_buses(&self) -> bool {
        let tags = &self.lanelet.attributes;
        !self.vehicle && (tags.is("subtype", "bus_lane") || tags.is("participant:vehicle:bus", "yes"))
    }

    /// By how much it turns from start to end, degrees, left positive: the sum of the changes of heading of the
    /// centre line, so that a full loop is 360.
    pub fn turn(&self) -> f64 {
        self.center.as_ref().map_or(0.0, turn_along)
    }

    /// Heading where it starts, over the first metres.
    pub fn heading_in(&self) -> Option<Vector> {
        self.headings[0]
    }

    /// Heading where it ends, over the last metres.
    pub fn heading_out(&self) -> Option<Vector> {
        self.headings[1]
    }

    /// Length of the centre line, metres.
    pub fn length(&self) -> f64 {
        self.length
    }
}

/// South-west and north-east corner.
pub fn extent(points: &[Point]) -> [Point; 2] {
    let far = f64::INFINITY;
    points.iter().fold([Point::new(far, far), Point::new(-far, -far)], |[low, high], p| [low.inf(p), high.sup(p)])
}

/// The sum of a line's changes of heading, degrees, left positive.
pub fn turn_along(line: &Polyline) -> f64 {
    let steps: Vec<Vector> = line.segments().map(|(a, b)| b - a).collect();
    steps.windows(2).map(|pair| angle_between(pair[0], pair[1])).sum::<f64>().to_degrees()
}

/// Unit direction in which a centre line begins: that of its first step of [`HEADING_STEP`] metres, less half the bend to the second.
pub(crate) fn tangent(line: &Polyline) -> Option<Vector> {
    let [a, b, c] = [0.0, HEADING_STEP, 2.0 * HEADING_STEP].map(|station| line.at(station));
    let (first, second) = (b - a, c - b);
    if second.norm() < HEADING_STEP / 2.0 {
        return first.try_normalize(Polyline::MERGE);
    }
    let bend = angle_between(first, second);
    (nalgebra::Rotation2::new(-bend / 2.0) * first).try_normalize(Polyline::MERGE)
}

/// Midpoints of both bounds, each cut into the same number of pieces of about [`HEADING_STEP`].
pub fn center_line(left: &[Point], right: &[Point]) -> Option<Polyline> {
    let measured = |bound: &[Point]| Polyline::new(bound.iter().copied()).map(|line| (line.stations(), line));
    let lines = [left, right].map(measured);
    let longest = lines.iter().flatten().filter_map(|(stations, _)| stations.last()).copied().fold(0.0, f64::max);
    let pieces = (longest / HEADING_STEP).ceil().clamp(1.0, Polyline::MOST_PIECES) as usize;
    let spread = |line: Option<(Vec<f64>, Polyline)>, bound: &[Point]| match line {
        Some((stations, line)) => line.spread(&stations, pieces + 1).into_points(),
        // A bound of no length is one place, as often as needed.
        None => vec![bound.first().copied().unwrap_or_default(); pieces + 1],
    };
    let [first, second] = lines;
    let (left, right) = (spread(first, left), spread(second, right));
    Polyline::new(left.iter().zip(&right).map(|(a, b)| nalgebra::center(a, b)))
}

/// Whether Autoware's vehicle routing takes it: participants, where any is named, decide alone; else the subtype.
pub(super) fn drivable_by_vehicle(lanelet: &Lanelet) -> bool {
    may_enter(&lanelet.attributes, "vehicle")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_circle_turns_by_90_degrees() {
        let arc = |radius: f64| -> Vec<Point> {
            (0..=30)
                .map(|i| f64::to_radians(3.0 * f64::from(i)))
                .map(|a| Point::new(radius * a.cos(), radius * a.sin()))
                .collect()
        };
        // Counter-clockwise: the inner arc is the left bound.
        let center = center_line(&arc(8.5), &arc(11.5)).unwrap();
        let steps: Vec<Vector> = center.segments().map(|(a, b)| b - a).collect();
        let turn: f64 = steps.windows(2).map(|w| angle_between(w[0], w[1])).sum();
        assert!((84.0..=90.0).contains(&turn.to_degrees()), "{}", turn.to_degrees());
    }

    #[test]
    fn the_line_of_an_edge_is_infinite() {
        let edge = Edge { ids: [PointId(1), PointId(2)], points: [Point::new(0.0, 0.0), Point::new(3.0, 0.0)] };
        assert!((edge.distance_from_line(Point::new(20.0, 0.4)) - 0.4).abs() < 1e-12);
        let turned = Edge { ids: [PointId(2), PointId(3)], points: [Point::new(3.0, 0.0), Point::new(0.0, 3.0)] };
        assert!((edge.angle_to(&turned) - 45.0).abs() < 1e-9);
        assert!(edge.touches(&turned));
    }
}
