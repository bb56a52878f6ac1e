//! vm-07-06: a lane that is added beside others can be entered, one that is dropped can be left.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::Vector;
use crate::lanelet::RoadType;
use crate::lanelet::index::{Edge, MapIndex};

use super::routing_moves::RoutingMoves;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    loose: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let moves = RoutingMoves::new(map);
    let roads = (0..map.lanes.len()).filter(|&at| {
        let lane = &map.lanes[at];
        lane.kind == RoadType::Road && lane.is_for_cars() && map.movement(at).is_none()
    });
    roads.flat_map(|at| [added(map, &moves, params, at), dropped(map, &moves, params, at)]).flatten().collect()
}

/// A lane that begins beside one that comes from somewhere, and that no lane change leads into.
fn added(map: &MapIndex, moves: &RoutingMoves, params: &Params, at: usize) -> Option<Finding> {
    let beside = moves.beside(at).into_iter().map(|other| other.lane).find(|&other| moves.is_led_to(other))?;
    if !map.predecessors(at).is_empty() || loose(map, params, at, &map.lanes[at].start) || crossed(map, moves, at, true)
    {
        return None;
    }
    let (lane, other) = (&map.lanes[at], map.lanes[beside].id);
    let message = format!("Lane {} begins beside lane {other}, and no route leads into it.", lane.id);
    let finding = Finding::new("no-way-in", Subject::Lanelet(lane.id.0), message);
    Some(finding.with(Subject::Lanelet(other.0), "lane beside").at(Place::Line(lane.start.points.to_vec())))
}

/// A lane that ends beside one that goes on, and that no lane change leads out of.
fn dropped(map: &MapIndex, moves: &RoutingMoves, params: &Params, at: usize) -> Option<Finding> {
    let beside = moves.beside(at).into_iter().map(|other| other.lane).find(|&other| moves.leads_on(other))?;
    if !map.followers(at).is_empty() || loose(map, params, at, &map.lanes[at].end) || crossed(map, moves, at, false) {
        return None;
    }
    let (lane, other) = (&map.lanes[at], map.lanes[beside].id);
    let message = format!("Lane {} ends beside lane {other}, and no route leads out of it.", lane.id);
    let finding = Finding::new("no-way-out", Subject::Lanelet(lane.id.0), message);
    Some(finding.with(Subject::Lanelet(other.0), "lane beside").at(Place::Line(lane.end.points.to_vec())))
}

/// Whether another lane starts or ends right here, over nodes of its own or the other way round, or would if it had loaded: then this
/// lane is neither added nor dropped, but torn off.
fn loose(map: &MapIndex, params: &Params, at: usize, edge: &Edge) -> bool {
    if map.is_at_unloaded(edge) {
        return true;
    }
    let reach = Vector::repeat(params.loose);
    let [a, b] = edge.points;
    let near = map.lanes_near(edge.middle() - reach, edge.middle() + reach);
    let here = |other: &Edge| {
        let [c, d] = other.points;
        let far = ((a - c).norm().max((b - d).norm())).min((a - d).norm().max((b - c).norm()));
        far <= params.loose
    };
    near.into_iter().filter(|&other| other != at && map.lanes[other].vehicle).any(|other| {
        let lane = &map.lanes[other];
        here(&lane.start) || here(&lane.end)
    })
}

/// Whether a border of a lane, or of one of the pieces that continue it up to an intersection, may be crossed.
fn crossed(map: &MapIndex, moves: &RoutingMoves, first: usize, forward: bool) -> bool {
    let mut pieces = vec![first];
    let mut next = 0;
    while let Some(&at) = pieces.get(next) {
        next += 1;
        if moves.beside(at).iter().any(|other| if forward { other.may_enter } else { other.may_leave }) {
            return true;
        }
        let behind = if forward { map.followers(at) } else { map.predecessors(at) };
        for &piece in behind.iter().filter(|&&piece| map.movement(piece).is_none()) {
            if !pieces.contains(&piece) {
                pieces.push(piece);
            }
        }
    }
    false
}
