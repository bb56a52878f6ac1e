//! What the smaller modules read from a lanelet: private ground, the blind side, the blinker, the stop lines of lights and signs.

use serde::Serialize;

use super::params::Params;
use super::path::{Front, Path};
use super::road_network::RoadNetwork;
use crate::lanelet::number::leading_number;
use crate::lanelet::{LaneletId, LineStringId, RegulatoryElementId, TurnDirection};

/// Stop line of a traffic light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TrafficLight {
    /// The element.
    pub element: RegulatoryElementId,
    /// Its stop line; without one the light counts for nothing.
    pub line: Option<LineStringId>,
    /// Where the front stops at red; `None` where the path does not cross the line.
    pub stop: Option<Front>,
}

/// Stop line of a stop sign on the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SignLine {
    /// The element.
    pub element: RegulatoryElementId,
    /// Its stop line.
    pub line: LineStringId,
    /// Where the front stops.
    pub stop: Front,
}

/// How the module merge from private takes the lanelet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PrivateRoad {
    /// Where the front stops before it merges; `None` where it meets no lane.
    pub stop: Option<Front>,
}

/// From where the blinker is on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Blinker {
    /// `left` or `right`.
    pub side: &'static str,
    /// Metres from the front of the vehicle to the begin of the lanelet, at the speed limit.
    pub before: f64,
    /// Whether the lanelet says so by `turn_signal_distance`.
    pub tagged: bool,
    /// Where the front is then; `None` farther back than the path was followed.
    pub start: Option<Front>,
}

/// The side on which bicycles and people may come up from behind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlindSpot {
    /// `left` or `right`.
    pub side: &'static str,
    /// The lanelets beside the approach that are watched, from the nearest on.
    pub lanelets: Vec<LaneletId>,
    /// Metres that they are followed upstream; less than the parameter where the road network begins.
    pub length: f64,
}

/// The stop line of the light that the lanelet refers to first.
pub(super) fn light(network: &RoadNetwork<'_, '_>, path: &Path, params: &Params) -> Option<TrafficLight> {
    let light = network.elements(path.lanelets[path.about], "traffic_light").next()?;
    let line = network.view.lines(light, "ref_line").next();
    let crossed = line.and_then(|line| {
        let places = network.view.places(line);
        places.windows(2).filter_map(|pair| path.crossing([pair[0], pair[1]], 0.0)).min_by(f64::total_cmp)
    });
    let stop = crossed.and_then(|station| path.front_at(station - params.traffic_light_margin, params));
    Some(TrafficLight { element: light.id, line: line.map(|line| line.id), stop })
}

/// The stop lines of stop signs that the path crosses near the lanelet.
pub(super) fn signs(network: &RoadNetwork<'_, '_>, path: &Path, params: &Params) -> Vec<SignLine> {
    /// Metres before the lanelet.
    const BEFORE: f64 = 30.0;
    let map = network.view.map;
    let [start, end] = path.stations;
    let mut found: Vec<SignLine> = Vec::new();
    for &lane in &path.lanelets {
        for sign in network.elements(lane, "traffic_sign") {
            let mut refers = sign.linestrings("refers").filter_map(|id| map.linestrings.get(id));
            if !refers.next().is_some_and(|line| line.attributes.is("subtype", "stop_sign")) {
                continue;
            }
            for line in network.view.lines(sign, "ref_line") {
                let places = network.view.places(line);
                let crossed = places.windows(2).filter_map(|pair| path.crossing([pair[0], pair[1]], start - BEFORE));
                let Some(station) = crossed.min_by(f64::total_cmp).filter(|station| *station <= end) else { continue };
                let stop = path.front_at(station - params.stop_sign_margin, params);
                if let Some(stop) = stop.filter(|_| found.iter().all(|known| known.line != line.id)) {
                    found.push(SignLine { element: sign.id, line: line.id, stop });
                }
            }
        }
    }
    found.sort_by(|a, b| a.stop.from_start.total_cmp(&b.stop.from_start));
    found
}

/// Whether the vehicle comes from private ground here, and where it stops.
pub(super) fn private(
    network: &RoadNetwork<'_, '_>,
    path: &Path,
    first_conflicting: Option<usize>,
    params: &Params,
) -> Option<PrivateRoad> {
    let is_private = |at: usize| network.seen(at).tag("location") == Some("private");
    let next = path.lanelets.get(path.about + 1)?;
    if !is_private(path.lanelets[path.about]) || is_private(*next) {
        return None;
    }
    let stop = first_conflicting.and_then(|at| {
        let at = path.last_outside(&network.seen(at).outline, params)?;
        Some(path.front(path.back(at, params.private_stopline_margin).unwrap_or(0), params))
    });
    Some(PrivateRoad { stop })
}

/// From where the blinker is on; `None` for straight lanelets, and where a roundabout element decides.
pub(super) fn blinker(network: &RoadNetwork<'_, '_>, path: &Path, speed: f64, params: &Params) -> Option<Blinker> {
    let at = path.lanelets[path.about];
    let side = turn_side(network, at)?;
    if network.elements(at, "roundabout").next().is_some() {
        return None;
    }
    let tagged = network.seen(at).tag("turn_signal_distance").and_then(leading_number);
    let usual = params.turn_signal_search_distance + params.turn_signal_search_time * speed;
    let before = tagged.unwrap_or(usual);
    Some(Blinker { side, before, tagged: tagged.is_some(), start: path.front_at(path.stations[0] - before, params) })
}

/// `left` or `right`.
fn turn_side(network: &RoadNetwork<'_, '_>, at: usize) -> Option<&'static str> {
    network.turn(at).filter(|turn| *turn != TurnDirection::Straight).map(TurnDirection::as_str)
}

/// Whom the module blind spot watches beside the approach of a turn.
pub(super) fn blind_spot(network: &RoadNetwork<'_, '_>, at: usize, params: &Params) -> Option<BlindSpot> {
    let side = turn_side(network, at)?;
    let (mut lanelets, mut length, mut last) = (Vec::new(), 0.0, at);
    let mut passed = vec![at];
    while length < params.backward_attention_length {
        let previous = network.graph.previous(last);
        let straight = previous.iter().find(|&&one| network.turn(one) == Some(TurnDirection::Straight));
        let Some(&before) = straight.or(previous.first()) else { break };
        if passed.contains(&before) {
            break;
        }
        passed.push(before);
        let beside = outermost(network, before, side == "left");
        length += network.length(beside);
        lanelets.push(network.id(beside));
        last = before;
    }
    (!lanelets.is_empty()).then_some(BlindSpot { side, lanelets, length })
}

/// The shoulder or bicycle lane at the side of a road, else its outermost lane.
fn outermost(network: &RoadNetwork<'_, '_>, lane: usize, on_left: bool) -> usize {
    /// A road has no more lanes.
    const MOST: usize = 10;
    let mut last = lane;
    for _ in 0..MOST {
        match network.beside(last, on_left, |at| network.graph.passes(at)) {
            Some(next) => last = next,
            None => break,
        }
    }
    let strip = |kind: &'static str| network.beside(last, on_left, |at| network.seen(at).is(kind));
    strip("road_shoulder").or_else(|| strip("bicycle_lane")).unwrap_or(last)
}
