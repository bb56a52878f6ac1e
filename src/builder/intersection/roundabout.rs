//! Centre lines around the island of a roundabout, where consolidation took pieces of its ring into an intersection. Other pieces
//! of a ring are roads, and get their lanelets in `lanes::road_lanes`.

use crate::builder::network::{InnerRoad, Intersection};
use crate::builder::tags::cross_section::Travel;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, angle_between, cross, curve};

/// Pieces whose ends are at most this far apart, metres, follow each other.
const FOLLOWS: f64 = 0.5;
/// A road whose line ends at most this far, metres, from the ring ends on it.
const ON_RING: f64 = 2.0;
/// A centre line that leaves the ring toward the island by less than this, metres, leads around the island.
const CUTS: f64 = 0.3;
/// The least radius of a centre line around the island, metres: no car turns more tightly, so cars drive over smaller islands.
const RADIUS_LEAST: f64 = 4.0;
/// Degrees of the ring between two places to pass.
const PLACE_EVERY: f64 = 60.0;

/// The pieces of a ring inside one intersection, joined, in their direction of travel.
pub struct CirculatingRing {
    runs: Vec<Polyline>,
}

impl CirculatingRing {
    /// `None` if there is no piece with a single lane inside.
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
        // A closed ring goes around twice, so that the way between any two places on it runs forward.
        for run in runs.iter_mut().filter(|run| follows(run, run)) {
            *run = Polyline::new(run.points().iter().chain(&run.points()[1..]).copied())?;
        }
        (!runs.is_empty()).then_some(Self { runs })
    }

    /// The centre line around the island between two lanes, of roads that end at two places. `None` if it does not run over the
    /// ring, or if the direct centre line does not run over the island.
    pub fn around(&self, roads: [Point; 2], [from, to]: [Pose; 2], direct: &[Pose]) -> Option<Vec<Pose>> {
        let direct = Polyline::new(direct.iter().map(|pose| pose.point))?;
        let places = self.runs.iter().find_map(|run| ring_places(run, roads))?;
        if !places.iter().any(|place| place.is_cut_off(&direct)) {
            return None;
        }
        let passed: Vec<Pose> = std::iter::once(from)
            .chain(places.into_iter().map(|place| place.pose))
            .chain(std::iter::once(to))
            .collect();
        let poses = curve::through(&passed);
        (curve::radius(&poses) >= RADIUS_LEAST).then_some(poses)
    }
}

/// A place on the ring to pass.
struct RingPlace {
    pose: Pose,
    /// Whether the island lies to its left.
    island_left: bool,
}

impl RingPlace {
    /// Whether a centre line passes it on the side of the island.
    fn is_cut_off(&self, centerline: &Polyline) -> bool {
        let offset = centerline.project(self.pose.point).offset;
        if self.island_left { offset < -CUTS } else { offset > CUTS }
    }
}

/// The places to pass on a run between roads that end at two places.
fn ring_places(run: &Polyline, [from, to]: [Point; 2]) -> Option<Vec<RingPlace>> {
    let from = station(run, from, 0.0)?;
    let part = run.cut(from, station(run, to, from)?)?;
    let bend: f64 = part.points().windows(3).map(|w| angle_between(w[1] - w[0], w[2] - w[1])).sum();
    let count = (bend.abs().to_degrees() / PLACE_EVERY).round().max(1.0);
    let step = part.length() / count;
    let island_left = cross(part.direction(0.0), part.at(part.length() / 2.0) - part.first()) > 0.0;
    let pose = |i: usize| {
        let station = (i as f64 + 0.5) * step;
        // The chord around the place: on a corner of the line its direction lies between those of both sides.
        let chord = part.at(station + step / 4.0) - part.at(station - step / 4.0);
        Some(Pose { point: part.at(station), heading: chord.try_normalize(f64::EPSILON)? })
    };
    let place = |i: usize| Some(RingPlace { pose: pose(i)?, island_left });
    (0..count as usize).map(place).collect()
}

/// The first station of a run, metres, beyond `after` that is at a place; `None` if the place is not on the run.
fn station(run: &Polyline, place: Point, after: f64) -> Option<f64> {
    let rest = run.cut(after, run.length())?;
    let station = rest.project(place).station;
    ((rest.at(station) - place).norm() <= ON_RING).then_some(after + station)
}

/// Two pieces, by index, of which the second follows the first.
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

    /// An arc of a ring with a radius of 8 m.
    fn arc(from: i32, to: i32) -> Polyline {
        arc_of(8.0, from, to)
    }

    fn arc_of(radius: f64, from: i32, to: i32) -> Polyline {
        Polyline::new((from..=to).step_by(10).map(|angle| on_circle(radius, f64::from(angle)).point)).unwrap()
    }

    /// The least distance from the middle, metres, of the centre line between streets at these angles, degrees.
    fn across(ring: &CirculatingRing, from: f64, to: f64) -> Option<f64> {
        across_of(8.0, ring, from, to)
    }

    fn across_of(radius: f64, ring: &CirculatingRing, from: f64, to: f64) -> Option<f64> {
        let street = |angle: f64, along: f64| {
            let out = on_circle(1.0, angle).point.coords;
            Pose { point: Point::from(out * 15.0), heading: out * along }
        };
        let ends = [street(from, -1.0), street(to, 1.0)];
        let roads = [from, to].map(|angle| on_circle(radius, angle).point);
        let poses = ring.around(roads, ends, &curve::join(ends[0], ends[1]))?;
        assert_eq!([poses[0], poses[poses.len() - 1]].map(|pose| pose.point), ends.map(|end| end.point));
        Some(poses.iter().map(|pose| pose.point.coords.norm()).fold(f64::INFINITY, f64::min))
    }

    #[test]
    fn centerlines_lead_around_the_island() {
        let half = CirculatingRing { runs: vec![arc(0, 180)] };
        let closest = across(&half, 0.0, 180.0).unwrap();
        assert!(closest > 7.0, "{closest} m from the middle");
        // In the opposite direction it would leave the intersection.
        assert_eq!(across(&half, 180.0, 0.0), None);
    }

    #[test]
    fn no_centerline_leads_around_an_island_that_a_car_cannot_drive_around() {
        let ring = CirculatingRing { runs: vec![arc_of(2.6, 0, 720)] };
        assert_eq!(across_of(2.6, &ring, 270.0, 180.0), None);
    }

    #[test]
    fn a_closed_ring_is_driven_past_the_begin_of_its_line() {
        let mut runs = vec![arc(0, 180), arc(180, 360)];
        assert_eq!(following(&runs), Some((0, 1)));
        runs = vec![arc(0, 720)];
        let closest = across(&CirculatingRing { runs }, 270.0, 90.0).unwrap();
        assert!(closest > 7.0, "{closest} m from the middle");
    }
}
