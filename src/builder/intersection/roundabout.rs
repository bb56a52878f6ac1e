//! Ways around the island of a roundabout, where an intersection took in pieces of its ring.

use crate::builder::network::{InnerRoad, Intersection};
use crate::builder::tags::cross_section::Travel;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, angle_between, cross, curve};

/// Pieces whose ends lie no farther apart than this, metres, follow each other.
const FOLLOWS: f64 = 0.5;
/// A road whose line ends no farther than this, metres, from the ring ends on it.
const ON_RING: f64 = 2.0;
/// A way that cuts the ring by less than this, metres, drives around it.
const CUTS: f64 = 0.3;
/// A way around that bends more tightly than this radius, metres, is none: its inner bound would have no length.
const RADIUS_LEAST: f64 = 2.5;
/// One place to pass for each so many degrees of the ring.
const PLACE_EVERY: f64 = 60.0;

/// The pieces of a ring inside one intersection, each run of them as it is driven.
pub struct CirculatingRing {
    runs: Vec<Polyline>,
}

impl CirculatingRing {
    /// `None` if no piece of a ring with a single lane lies inside.
    pub fn of(intersection: &Intersection) -> Option<Self> {
        let as_driven = |inner: &InnerRoad| {
            let mut lanes = inner.section.driven();
            match (lanes.next()?.1.travel, lanes.next()) {
                (Travel::Forward, None) => Some(inner.line.clone()),
                (Travel::Backward, None) => Some(inner.line.reversed()),
                _ => None,
            }
        };
        let mut runs: Vec<Polyline> =
            intersection.inner.iter().filter(|i| i.roundabout).filter_map(as_driven).collect();
        while let Some((a, b)) = following(&runs) {
            let joined = runs[a].points().iter().chain(&runs[b].points()[1..]).copied();
            let joined = Polyline::new(joined)?;
            runs[a] = joined;
            runs.remove(b);
        }
        // Twice around, so that every way on a whole ring runs forward.
        for run in runs.iter_mut().filter(|run| follows(run, run)) {
            *run = Polyline::new(run.points().iter().chain(&run.points()[1..]).copied())?;
        }
        (!runs.is_empty()).then_some(Self { runs })
    }

    /// The way between two lanes around the island, of roads that end at two places. `None` if it does not run over the
    /// ring, or if `course`, as it is smoothest by itself, leaves the island alone.
    pub fn around(&self, roads: [Point; 2], ends: [Pose; 2], course: &[Pose]) -> Option<Vec<Pose>> {
        let course = Polyline::new(course.iter().map(|pose| pose.point))?;
        let places = self.runs.iter().find_map(|run| places(run, roads))?;
        if !places.iter().any(|place| cuts(&course, place)) {
            return None;
        }
        let stops: Vec<Pose> = std::iter::once(ends[0])
            .chain(places.into_iter().map(|place| place.pose))
            .chain(std::iter::once(ends[1]))
            .collect();
        let mut poses: Vec<Pose> = Vec::new();
        for pair in stops.windows(2) {
            poses.pop();
            poses.extend(curve::join(pair[0], pair[1]));
        }
        (curve::radius(&poses) >= RADIUS_LEAST).then_some(poses)
    }
}

/// A place on the ring that a way passes, and whether the island lies to its left.
struct Place {
    pose: Pose,
    island_left: bool,
}

/// Whether a course passes a place on the side of the island.
fn cuts(course: &Polyline, place: &Place) -> bool {
    let foot = course.project(place.pose.point);
    // The place lies outside of the course.
    if place.island_left { foot.offset < -CUTS } else { foot.offset > CUTS }
}

/// The places to pass on the way over a run between roads that end at two places.
fn places(run: &Polyline, [from, to]: [Point; 2]) -> Option<Vec<Place>> {
    let from = station(run, from, 0.0)?;
    let part = run.cut(from, station(run, to, from)?)?;
    let bend: f64 = part.points().windows(3).map(|w| angle_between(w[1] - w[0], w[2] - w[1])).sum();
    let count = (bend.abs().to_degrees() / PLACE_EVERY).round().max(1.0);
    let step = part.length() / count;
    let island_left = cross(part.direction(0.0), part.at(part.length() / 2.0) - part.first()) > 0.0;
    let pose = |i: usize| {
        let at = (i as f64 + 0.5) * step;
        // Across the bends of the line, so that a place on a corner does not head along one side of it.
        let along = part.at(at + step / 4.0) - part.at(at - step / 4.0);
        Some(Pose { point: part.at(at), heading: along.try_normalize(f64::EPSILON)? })
    };
    let place = |i: usize| Some(Place { pose: pose(i)?, island_left });
    (0..count as usize).map(place).collect()
}

/// The first station of a run beyond `after` at a place; `None` if it does not lie on the run.
fn station(run: &Polyline, place: Point, after: f64) -> Option<f64> {
    let rest = run.cut(after, run.length())?;
    let near = |station: f64| (rest.at(station) - place).norm() <= ON_RING;
    let foot = rest.project(place);
    near(foot.station).then_some(after + foot.station)
}

/// Two runs of which the second follows the first, by index.
fn following(runs: &[Polyline]) -> Option<(usize, usize)> {
    let after = |a: usize| (0..runs.len()).find(|&b| a != b && follows(&runs[a], &runs[b])).map(|b| (a, b));
    (0..runs.len()).find_map(after)
}

fn follows(a: &Polyline, b: &Polyline) -> bool {
    (b.first() - a.last()).norm() <= FOLLOWS
}

#[cfg(test)]
mod tests {
    use crate::geometry::Vector;

    use super::*;

    /// A place on a circle around the origin, and the direction in which it is driven counter-clockwise.
    fn on_circle(radius: f64, degrees: f64) -> Pose {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Pose { point: Point::new(radius * cos, radius * sin), heading: Vector::new(-sin, cos) }
    }

    fn arc(from: i32, to: i32) -> Polyline {
        Polyline::new((from..=to).step_by(10).map(|angle| on_circle(8.0, f64::from(angle)).point)).unwrap()
    }

    /// The way from a street at the angle `from` to one at the angle `to`, and how close it comes to the middle.
    fn across(ring: &CirculatingRing, from: f64, to: f64) -> Option<f64> {
        let street = |angle: f64, along: f64| {
            let out = on_circle(1.0, angle).point.coords;
            Pose { point: Point::from(out * 15.0), heading: out * along }
        };
        let ends = [street(from, -1.0), street(to, 1.0)];
        let roads = [from, to].map(|angle| on_circle(8.0, angle).point);
        let way = ring.around(roads, ends, &curve::join(ends[0], ends[1]))?;
        assert_eq!([way[0], way[way.len() - 1]].map(|pose| pose.point), ends.map(|end| end.point));
        Some(way.iter().map(|pose| pose.point.coords.norm()).fold(f64::INFINITY, f64::min))
    }

    #[test]
    fn ways_lead_around_the_island() {
        let half = CirculatingRing { runs: vec![arc(0, 180)] };
        let closest = across(&half, 0.0, 180.0).unwrap();
        assert!(closest > 7.0, "{closest} m from the middle");
        // The other way round it does not run over what was taken in.
        assert_eq!(across(&half, 180.0, 0.0), None);
    }

    #[test]
    fn a_whole_ring_is_driven_past_where_its_line_begins() {
        let mut runs = vec![arc(0, 180), arc(180, 360)];
        assert_eq!(following(&runs), Some((0, 1)));
        runs = vec![arc(0, 720)];
        let closest = across(&CirculatingRing { runs }, 270.0, 90.0).unwrap();
        assert!(closest > 7.0, "{closest} m from the middle");
    }
}
