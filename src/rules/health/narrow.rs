//! Lanes outside intersections in which no car fits. Inside, vm-03-03 says it.

use crate::diagnostic::{Finding, Place};
use crate::geometry::line_index::LineIndex;
use crate::geometry::{Point, Polyline};
use crate::lanelet::RoadType;
use crate::lanelet::index::MapIndex;
use crate::rules::routing_moves::RoutingMoves;

use super::params::{Params, subject};

/// Step along a lane between measurements, metres.
const MEASURED_EVERY: f64 = 1.0;
/// Widths are told to this, metres.
const EXACT: f64 = 0.01;
/// A border of no more points than this is looked through for each place.
const FEW: usize = 32;
/// A lane begins or ends in a point where its edge is narrower than this, metres, be it on two nodes.
const POINT: f64 = 0.1;
/// A lane that opens or closes does so within so many lanelets.
const MOST_PIECES: usize = 8;

pub fn judge(map: &MapIndex, params: &Params, moves: &RoutingMoves) -> Vec<Finding> {
    let streets = (0..map.lanes.len()).filter(|&at| {
        let lane = &map.lanes[at];
        // A lane with one way on both sides is told of by vm-01-05.
        let [left, right] = lane.bounds;
        left != right
            && lane.kind == RoadType::Road
            && lane.is_for_cars()
            && !(map.has_area(at) && map.movement(at).is_some())
    });
    streets.filter_map(|at| too_narrow(map, params, moves, at)).collect()
}

/// The narrowest place of a lane, if no car fits there, and it neither opens nor closes.
fn too_narrow(map: &MapIndex, params: &Params, moves: &RoutingMoves, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let [left, right] = [lane.border(0)?, lane.border(1)?];
    let middle = lane.center.as_ref()?.resampled(MEASURED_EVERY);
    let fits = |width: f64| width >= params.least_width - EXACT;
    let of = |border: &Polyline| distances(border, middle.points());
    let widths: Vec<f64> = of(&left).into_iter().zip(of(&right)).map(|(left, right)| left + right).collect();
    if widths.iter().all(|&width| fits(width)) {
        return None;
    }
    let wide = |at: &usize| fits(widths[*at]);
    let first = (0..widths.len()).find(wide);
    let last = (0..widths.len()).rfind(wide);
    let opens = tapers(map, moves, params, at, false, MOST_PIECES);
    let closes = tapers(map, moves, params, at, true, MOST_PIECES);
    let from = if opens { first.unwrap_or(widths.len()) } else { 0 };
    let to = if closes { last.map_or(0, |last| last + 1) } else { widths.len() };
    let (least, place) = (from..to)
        .filter(|at| !wide(at))
        .map(|at| (widths[at], middle.points()[at]))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let message = format!("Lane {} is {least:.2} m wide; a car needs {} m.", lane.id, params.least_width);
    let finding = Finding::new("narrow", subject(map, at), message).measured(least, params.least_width, "m");
    Some(finding.at(Place::Point(place)))
}

/// How far a border is from each place, metres.
fn distances(border: &Polyline, places: &[Point]) -> Vec<f64> {
    if border.points().len() <= FEW {
        return places.iter().map(|&place| border.distance(place)).collect();
    }
    let index = LineIndex::new(border);
    places.iter().map(|&place| index.distance(place)).collect()
}

/// Whether a lane opens at its start, or closes at its end: it is narrower there, nothing leads on, and a lane lies beside it that
/// vehicles change to.
fn tapers(map: &MapIndex, moves: &RoutingMoves, params: &Params, at: usize, closes: bool, pieces: usize) -> bool {
    let lane = &map.lanes[at];
    let (edge, other, next) = match closes {
        true => (lane.end, lane.start, map.followers(at)),
        false => (lane.start, lane.end, map.predecessors(at)),
    };
    let [here, there] = [edge, other].map(|edge| edge.across().norm());
    here < params.least_width
        && here + EXACT < there
        && match next {
            [] => edge.ids[0] == edge.ids[1] || here < POINT || moves.beside(at).iter().any(|other| other.may_leave),
            [next] => pieces > 0 && tapers(map, moves, params, *next, closes, pieces - 1),
            _ => false,
        }
}
