//! The path that a vehicle drives over a lanelet, and its outline on it.

use geo::{Intersects, Line};
use serde::{Serialize, Serializer};

use super::params::Params;
use super::road_network::RoadNetwork;
use crate::geometry::polygon::{contains, to_geo};
use crate::geometry::{Point, Polyline, Vector, left_of, segment_crossing};
use crate::lanelet::index::extent;
use crate::lanelet::index::view::boxes_meet;

/// Metres between the places at which a touch is looked for at first.
const STRIDE: f64 = 0.5;
/// Half the length over which the heading of the path is taken, metres.
const HEADING_REACH: f64 = 0.25;
/// Places on the longest path, as a number of steps: 5 km of Autoware's steps.
const MOST_PLACES: f64 = 50_000.0;

/// Where the front of the vehicle stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Front {
    /// Metres along the path from the begin of the lanelet; negative: before it.
    pub from_start: f64,
    /// The left and the right end of the bumper, local metres.
    #[serde(serialize_with = "plain")]
    pub ends: [Point; 2],
}

/// Points as pairs of numbers.
pub(super) fn plain<S: Serializer>(points: &impl AsRef<[Point]>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(points.as_ref().iter().map(|p| [p.x, p.y]))
}

/// The path over a lanelet from some way before it to some way behind it, in steps of Autoware's interpolation.
#[derive(Debug)]
pub(super) struct Path {
    /// Its lanelets from first to last.
    pub lanelets: Vec<usize>,
    /// Which of them it is about.
    pub about: usize,
    /// The whole line.
    pub line: Polyline,
    /// The places, one every `step` metres.
    pub places: Vec<Point>,
    /// Metres.
    pub step: f64,
    /// The last place before the lanelet and the first one behind it.
    pub interval: [usize; 2],
    /// Metres from the begin of the path to that of the lanelet, and to its end.
    pub stations: [f64; 2],
}

impl Path {
    /// The path over a lanelet: along a route where one is given, else along the lanelets that are most likely before and behind, as
    /// far as these lengths (m) or a little more. `None` if the lanelet itself has more places than [`MOST_PLACES`].
    pub fn over(
        network: &RoadNetwork<'_, '_>,
        at: usize,
        route: &[usize],
        [before_most, after_most]: [f64; 2],
        params: &Params,
    ) -> Option<Self> {
        let [before, after] = around(network, at, route, [before_most, after_most]);
        let mut lanelets = before;
        let about = lanelets.len();
        lanelets.push(at);
        lanelets.extend(after);
        let mut points: Vec<Point> = Vec::new();
        let mut stations = [0.0; 2];
        for (i, &lanelet) in lanelets.iter().enumerate() {
            let center = network.center(lanelet)?.into_points();
            if i == about {
                stations[0] = length(&points) + points.last().zip(center.first()).map_or(0.0, |(a, b)| (b - a).norm());
            }
            points.extend(center);
            if i == about {
                stations[1] = length(&points);
            }
        }
        let step = params.path_interpolation_ds;
        let mut line = Polyline::new(points)?;
        if line.length() > MOST_PLACES * step {
            let from = (stations[0] - before_most).max(0.0);
            line = line.cut(from, (stations[1] + after_most).min(line.length()))?;
            stations = stations.map(|station| station - from);
        }
        let count = (line.length() / step).floor().max(1.0);
        if count > MOST_PLACES {
            return None;
        }
        let count = count as usize;
        let places = line.at_each((0..=count).map(|i| i as f64 * step));
        let first = ((stations[0] / step).ceil() as usize).saturating_sub(1);
        let last = ((stations[1] / step).floor() as usize + 1).min(count);
        Some(Self { lanelets, about, line, places, step, interval: [first.min(last), last], stations })
    }

    /// Unit vector of travel at a place.
    fn heading(&self, at: usize) -> Vector {
        let reach = ((HEADING_REACH / self.step).ceil() as usize).max(1);
        let low = at.saturating_sub(reach);
        let high = (at + reach).min(self.places.len() - 1);
        (self.places[high] - self.places[low]).try_normalize(Polyline::MERGE).unwrap_or_else(Vector::x)
    }

    /// Steps in a length.
    pub fn steps(&self, length: f64) -> usize {
        (length / self.step).ceil().max(0.0) as usize
    }

    /// The place that lies a length before another, in whole steps as the module counts them; `None` before the begin of the path.
    pub fn back(&self, at: usize, length: f64) -> Option<usize> {
        at.checked_sub(self.steps(length))
    }

    /// The bumper of a vehicle whose rear axle is at a place, left and right end.
    pub fn bumper(&self, at: usize, params: &Params) -> [Point; 2] {
        let heading = self.heading(at);
        let front = self.places[at] + heading * params.front();
        [front + left_of(heading) * params.half_width(), front - left_of(heading) * params.half_width()]
    }

    /// Outline of a vehicle whose rear axle is at a place.
    pub fn footprint(&self, at: usize, params: &Params) -> Vec<Point> {
        let [left, right] = self.bumper(at, params);
        let back = self.heading(at) * (params.front() + params.rear_overhang);
        vec![left, right, right - back, left - back]
    }

    /// Where the front is if the rear axle is at a place.
    pub fn front(&self, at: usize, params: &Params) -> Front {
        let from_start = at as f64 * self.step + params.front() - self.stations[0];
        Front { from_start, ends: self.bumper(at, params) }
    }

    /// The front at a station of the path, metres; `None` before the begin of the path.
    pub fn front_at(&self, station: f64, params: &Params) -> Option<Front> {
        let at = (station - params.front()) / self.step;
        let front = (at >= 0.0).then(|| self.front((at.round() as usize).min(self.places.len() - 1), params))?;
        Some(Front { from_start: station - self.stations[0], ..front })
    }

    /// Metres along the path where it first crosses a segment, from a station on.
    pub fn crossing(&self, [a, b]: [Point; 2], from: f64) -> Option<f64> {
        let stations = self.line.stations();
        let segments = self.line.segments().zip(stations.windows(2));
        let mut crossings = segments.filter_map(|((p, q), station)| {
            let (t, _, _) = segment_crossing(p, q, a, b)?;
            Some(station[0] + (station[1] - station[0]) * t)
        });
        crossings.find(|station| *station >= from)
    }

    /// Metres along the path where it first enters a ring, from a station on.
    pub fn entry(&self, ring: &[Point], from: f64) -> Option<f64> {
        let closed = ring.iter().zip(ring.iter().cycle().skip(1));
        let crossings = closed.filter_map(|(&a, &b)| self.crossing([a, b], from));
        crossings.min_by(f64::total_cmp)
    }

    /// The first places in a range at which something of the vehicle touches a ring, each with the ring's position.
    pub fn first_touched(&self, rings: &[Vec<Point>], params: &Params) -> Option<(usize, usize)> {
        let boxes: Vec<_> = rings.iter().map(|ring| extent(ring)).collect();
        let touched = |at: usize| {
            let footprint = self.footprint(at, params);
            let reach = extent(&footprint);
            let vehicle = to_geo(&footprint);
            // Where it meets no edge, it is outside of the ring, or all of it inside.
            let meets = |ring: &[Point]| {
                edges_in(ring, reach).any(|edge| vehicle.intersects(&edge))
                    || footprint.first().is_some_and(|&corner| contains(ring, corner))
            };
            (0..rings.len()).find(|&i| boxes_meet(reach, boxes[i]) && meets(&rings[i]))
        };
        // A vehicle is longer than a stride, so that it passes over nothing between two of them.
        let (first, last) = self.search(params).into_inner();
        let stride = self.steps(STRIDE).max(1);
        let near = (first..last).step_by(stride).chain([last]).find(|&at| touched(at).is_some())?;
        (near.saturating_sub(stride).max(first)..=near).find_map(|at| Some((at, touched(at)?)))
    }

    /// The last place before the bumper touches a ring; `None` if it never does, or does at once.
    pub fn last_outside(&self, ring: &[Point], params: &Params) -> Option<usize> {
        let reach = extent(ring);
        let touched = self.search(params).find(|&at| {
            let bumper = self.bumper(at, params);
            boxes_meet(extent(&bumper), reach) && touches(bumper, ring)
        });
        touched?.checked_sub(1)
    }

    /// Where the module looks: from a vehicle's length before the lanelet to its end.
    fn search(&self, params: &Params) -> std::ops::RangeInclusive<usize> {
        let [first, last] = self.interval;
        first.saturating_sub((params.front() / self.step) as usize)..=last
    }

    /// The band that the vehicle's width sweeps between two places.
    pub fn band(&self, [from, to]: [usize; 2], params: &Params) -> Vec<Point> {
        let stride = self.steps(0.5).max(1);
        let at = (from..to).step_by(stride).chain([to]);
        let sides: Vec<[Point; 2]> = at
            .map(|at| {
                let aside = left_of(self.heading(at)) * params.half_width();
                [self.places[at] + aside, self.places[at] - aside]
            })
            .collect();
        sides.iter().map(|side| side[0]).chain(sides.iter().rev().map(|side| side[1])).collect()
    }
}

/// The edges of a ring whose boxes meet a box.
fn edges_in(ring: &[Point], reach: [Point; 2]) -> impl Iterator<Item = Line<f64>> {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let near = edges.filter(move |&(&a, &b)| boxes_meet(reach, extent(&[a, b])));
    near.map(|(a, b)| Line::new((a.x, a.y), (b.x, b.y)))
}

/// Whether a segment and a ring with its inside have a point in common.
fn touches([a, b]: [Point; 2], ring: &[Point]) -> bool {
    let mut edges = ring.iter().zip(ring.iter().cycle().skip(1));
    contains(ring, a) || contains(ring, b) || edges.any(|(&c, &d)| segment_crossing(a, b, c, d).is_some())
}

fn length(points: &[Point]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// The lanelets before and behind one.
fn around(network: &RoadNetwork<'_, '_>, at: usize, route: &[usize], lengths: [f64; 2]) -> [Vec<usize>; 2] {
    let on_route = route.iter().position(|&one| one == at);
    let [given_before, given_after] = on_route.map_or([&[][..]; 2], |i| [&route[..i], &route[i + 1..]]);
    let chain = |given: &mut dyn Iterator<Item = usize>, next: &dyn Fn(usize) -> Option<usize>, most: f64| {
        let (mut found, mut sum, mut last) = (Vec::new(), 0.0, at);
        while sum < most {
            let Some(one) = given.next().or_else(|| next(last)) else { break };
            if one == at || found.contains(&one) {
                break;
            }
            sum += network.length(one);
            found.push(one);
            last = one;
        }
        found
    };
    let mut before = chain(&mut given_before.iter().rev().copied(), &|at| network.likely_previous(at), lengths[0]);
    before.reverse();
    let after = chain(&mut given_after.iter().copied(), &|at| network.likely_following(at), lengths[1]);
    [before, after]
}
