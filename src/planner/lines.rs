//! The lines of the intersection module along the path: where it watches from, stops, peeks and decides.

use serde::Serialize;

use super::params::Params;
use super::path::{Front, Path, plain};
use super::road_network::RoadNetwork;
use crate::geometry::Point;
use crate::geometry::polygon::{contains, to_geo};
use crate::lanelet::{LineString, LineStringId, TurnDirection};
use geo::Intersects;

/// Metres by which a stop line is prolonged on either side: Autoware prolongs it to the bounds of the path.
const PROLONGED: f64 = 2.0;

/// What the default stop line comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "from", content = "way", rename_all = "snake_case")]
pub enum StopSource {
    /// A stop line to which a `road_marking` element of the lanelet refers.
    RoadMarking(LineStringId),
    /// The margin before the first watched lane.
    Margin,
}

/// Whether a vehicle at its stop line touches the first watched lane. If it does, the module finds no line to peek from, gives up, and
/// never stops for traffic here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ReachesIn {
    /// It does not.
    No,
    /// By less than [`EDGE`]: the vehicle's real path decides.
    AtEdge,
    /// It does, and still would a little farther back.
    Yes,
}

/// What a real path differs from the middle of the lane, metres.
pub const EDGE: f64 = 0.3;

/// Where the vehicle stops for traffic.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DefaultStop {
    /// Where its front stands.
    #[serde(flatten)]
    pub front: Front,
    /// What says so.
    #[serde(flatten)]
    pub source: StopSource,
    /// How far it reaches into the first watched lane where it stands there.
    pub reaches_in: ReachesIn,
}

/// Where a stopped vehicle is taken to block the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StuckArea {
    /// Its outline, local metres.
    #[serde(serialize_with = "plain")]
    pub outline: Vec<Point>,
    /// Where the front stands while the way is blocked; `None`: too near to the begin of the path.
    pub stop: Option<Front>,
}

/// The lines of one lanelet. Places are those of the front of the vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Lines {
    /// The last place before the first watched lane.
    pub first_attention: Option<Front>,
    /// Where it stops for traffic.
    pub default_stop: Option<DefaultStop>,
    /// How far it creeps to see more; only with `occlusion.enable`.
    pub peeking: Option<Front>,
    /// Beyond it, at the speed limit, the vehicle does not stop for traffic any more; `None` farther back than the path was followed.
    pub pass_judge: Option<Front>,
    /// Metres that braking from the speed limit takes.
    pub braking: f64,
    /// Where a stopped vehicle is taken to block the way.
    pub stuck: Option<StuckArea>,
}

/// The lines of a lanelet, and which watched and which conflicting lanelet the path meets first.
pub(super) struct Found {
    pub lines: Lines,
    pub first_watched: Option<usize>,
    pub first_conflicting: Option<usize>,
}

/// Metres that a vehicle needs to stop from a speed, m/s: `calcJudgeLineDistWithJerkLimit` of Autoware without delay, from even travel.
pub(super) fn braking(speed: f64, params: &Params) -> f64 {
    if speed <= 0.0 {
        return 0.0;
    }
    let (accel, jerk) = (params.max_accel, params.max_jerk);
    let after = speed + accel * accel / (2.0 * jerk);
    if after <= 0.0 {
        let time = (-2.0 * speed / jerk).sqrt();
        return (speed * time + jerk * time.powi(3) / 6.0).max(0.0);
    }
    let time = accel / jerk;
    (speed * time + jerk * time.powi(3) / 6.0 - after * after / (2.0 * accel)).max(0.0)
}

/// The lines for traffic alone, and the first watched lanelet that the path meets, by its position. `speed` is in m/s.
pub(super) fn for_traffic(
    network: &RoadNetwork<'_, '_>,
    path: &Path,
    watched: &[usize],
    speed: f64,
    params: &Params,
) -> (Lines, Option<usize>) {
    let attention: Vec<Vec<Point>> = watched.iter().map(|&at| network.seen(at).outline.clone()).collect();
    let first = path.first_touched(&attention, params).map(|(_, i)| i);
    let mut lines = Lines { braking: braking(speed, params), ..Lines::default() };
    if let Some(i) = first {
        attention_lines(network, path, &attention[i], &mut lines, params);
    }
    (lines, first.map(|i| watched[i]))
}

/// Finds the lines on a path. `speed` is in m/s.
pub(super) fn find(
    network: &RoadNetwork<'_, '_>,
    path: &Path,
    watched: &[usize],
    conflicting: &[usize],
    speed: f64,
    params: &Params,
) -> Found {
    let (mut lines, first_watched) = for_traffic(network, path, watched, speed, params);
    let all: Vec<Vec<Point>> = conflicting.iter().map(|&at| network.seen(at).outline.clone()).collect();
    let first_conflicting = path.first_touched(&all, params).map(|(_, i)| i);
    if let Some(i) = first_conflicting {
        let first = first_watched.map_or(&all[i], |at| &network.seen(at).outline);
        lines.stuck = stuck(network, path, first, (conflicting[i], &all[i]), params);
    }
    Found { lines, first_watched, first_conflicting: first_conflicting.map(|i| conflicting[i]) }
}

/// The lines that depend on the first watched lane.
fn attention_lines(network: &RoadNetwork<'_, '_>, path: &Path, ring: &[Point], lines: &mut Lines, params: &Params) {
    let Some(first) = path.last_outside(ring, params) else { return };
    lines.first_attention = Some(path.front(first, params));
    let marked = marked_stop(network, path, params);
    let at = marked.map(|(at, _)| at).or_else(|| path.back(first, params.default_stopline_margin));
    if let Some(at) = at {
        let area = to_geo(ring);
        let touches = |at: usize| to_geo(&path.footprint(at, params)).intersects(&area);
        let reaches_in = match path.back(at, EDGE) {
            _ if !touches(at) => ReachesIn::No,
            Some(back) if touches(back) => ReachesIn::Yes,
            _ => ReachesIn::AtEdge,
        };
        let source = marked.map_or(StopSource::Margin, |(_, line)| StopSource::RoadMarking(line));
        lines.default_stop = Some(DefaultStop { front: path.front(at, params), source, reaches_in });
        if params.occlusion && reaches_in == ReachesIn::No {
            let offset = (params.peeking_offset / path.step).ceil() as isize;
            let peeking = first.saturating_add_signed(offset).min(path.places.len() - 1);
            lines.peeking = Some(path.front(peeking, params));
        }
    }
    let judged = path.back(first, lines.braking + params.pass_judge_line_margin);
    lines.pass_judge = judged.map(|at| path.front(at, params));
}

/// Where the rear axle stands if the front is at the stop line that a road marking of the lanelet names.
fn marked_stop(network: &RoadNetwork<'_, '_>, path: &Path, params: &Params) -> Option<(usize, LineStringId)> {
    let line = road_marking_stop_line(network, path.lanelets[path.about])?;
    let [a, b] = ends(network, line)?;
    let along = (b - a).try_normalize(1e-6)? * PROLONGED;
    let [first, last] = path.interval.map(|at| at as f64 * path.step);
    let crossed = path.crossing([a - along, b + along], first).filter(|station| *station <= last);
    let station = crossed.unwrap_or_else(|| path.line.project(nalgebra::center(&a, &b)).station);
    Some((path.back((station / path.step) as usize, params.front())?, line.id))
}

/// The stop line that the module takes from the map: the first that a `road_marking` element of the lanelet names.
pub(super) fn road_marking_stop_line<'m>(network: &RoadNetwork<'_, 'm>, at: usize) -> Option<&'m LineString> {
    let map = network.view.map;
    let lines = network.elements(at, "road_marking").flat_map(|element| element.linestrings("refers"));
    let mut lines = lines.filter_map(|id| map.linestrings.get(id));
    lines.find(|line| line.attributes.is("type", "stop_line"))
}

/// First and last point of a line.
pub(super) fn ends(network: &RoadNetwork<'_, '_>, line: &LineString) -> Option<[Point; 2]> {
    let places = network.view.places(line);
    Some([*places.first()?, *places.last()?])
}

/// Where a stopped vehicle would block the way: from the first lane that the path enters to a little behind the lanelet.
fn stuck(
    network: &RoadNetwork<'_, '_>,
    path: &Path,
    first: &[Point],
    (conflicting, conflicting_ring): (usize, &[Point]),
    params: &Params,
) -> Option<StuckArea> {
    let looks = match network.turn(path.lanelets[path.about])? {
        TurnDirection::Left => params.stuck_left,
        TurnDirection::Right => params.stuck_right,
        TurnDirection::Straight => params.stuck_straight,
    };
    let private = network.seen(conflicting).tag("location") == Some("private");
    if !looks || (private && params.disable_against_private_lane) {
        return None;
    }
    let [start, end] = path.interval;
    let inside = |at: usize, ring: &[Point]| contains(ring, path.places[at]);
    if inside(start, first) {
        return None;
    }
    let from = (start..=end).find(|&at| inside(at, first))?;
    let next = params.stuck_vehicle_detect_dist.min((path.places.len() - 1 - end) as f64 * path.step);
    let outline = path.band([from, end + (next / path.step) as usize], params);
    let stop = if params.use_stuck_stopline {
        path.last_outside(conflicting_ring, params).and_then(|at| path.back(at, params.default_stopline_margin))
    } else {
        path.back(start, params.default_stopline_margin + params.front())
    };
    Some(StuckArea { outline, stop: stop.map(|at| path.front(at, params)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 50 km/h: 0.56 s until the brakes hold, then 2.8 m/s2. Integrated by hand: 7.63 m and 30.94 m.
    #[test]
    fn braking_takes_as_long_as_autoware_says() {
        let params = Params::default();
        let speed = 50.0 / 3.6;
        let (mut at, mut v, mut a, dt) = (0.0, speed, 0.0, 1e-5);
        while v > 0.0 {
            at += v * dt;
            v += a * dt;
            a = f64::max(a + params.max_jerk * dt, params.max_accel);
        }
        assert!((braking(speed, &params) - at).abs() < 0.01, "{} is not {at}", braking(speed, &params));
        let (mut at, mut v, mut a) = (0.0, 0.5, 0.0);
        while v > 0.0 {
            at += v * dt;
            v += a * dt;
            a = f64::max(a + params.max_jerk * dt, params.max_accel);
        }
        assert!((braking(0.5, &params) - at).abs() < 0.001, "{} is not {at}", braking(0.5, &params));
        assert_eq!(braking(0.0, &params), 0.0);
    }
}
