//! How far dead ends are cut back from carriageways beside which they end, with which OpenStreetMap does not join them.

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::builder::network::road_end::{at_depth, from_cut, inward, on_cut};
use crate::builder::network::{Intersection, Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::geometry::{Point, polygon};
use crate::parallel::Finely;

/// Lanes that end keep clear, metres, of a carriageway ahead: there is a kerb, or a gate, between the two.
const CLEAR: f64 = 1.5;
/// Each is cut back so far, metres, at most ...
const MOST: f64 = 6.0;
/// ... by steps of this length, metres.
const STEP: f64 = 0.5;
/// Cells of this side, metres, hold the ground around dead ends.
const CELL: f64 = 20.0;

/// A dead end, and the ground that matters to it.
struct DeadEnd {
    at: RoadEnd,
    reach: Bounds,
}

/// The dead ends before carriageways on their level, each with how far it is cut back. One that would not get clear stays.
pub fn clearances(network: &RoadNetwork, least: &[Stations]) -> Vec<(RoadEnd, f64)> {
    let dead = |at: &&Intersection| at.arms.len() == 1 && !at.map_edge && at.circle.is_none();
    let ends: Vec<DeadEnd> = network
        .intersections
        .iter()
        .filter(dead)
        .filter_map(|at| {
            let places = [0.0, MOST].map(|by| ahead(network, least, at.arms[0], by)).concat();
            Some(DeadEnd { at: at.arms[0], reach: polygon::bounds(&places)? })
        })
        .collect();
    let cells = SpatialHash::new(ends.iter().map(|end| end.reach).collect(), CELL);
    let reached = |(ix, road): (usize, &Road)| {
        let mut reached: Vec<(usize, RoadIx)> = Vec::new();
        road.segment_bounds().for_each(|reach| cells.touching(reach, |end| reached.push((end, RoadIx::new(ix)))));
        reached
    };
    let reached: Vec<(usize, RoadIx)> = network.roads.par_iter().finely().enumerate().flat_map_iter(reached).collect();
    let mut near: Vec<FxHashSet<RoadIx>> = vec![FxHashSet::default(); ends.len()];
    for (end, road) in reached {
        near[end].insert(road);
    }
    let clearance = |(end, mut near): (DeadEnd, FxHashSet<RoadIx>)| {
        near.remove(&end.at.road);
        let level = network.road(end.at.road).level;
        near.retain(|road| network.road(*road).level == level);
        let covered = |place: &Point| {
            near.iter().map(|road| network.road(*road)).any(|road| road.line.distance(*place) < road.half_width())
        };
        let steps = (0..).map(|i| STEP * f64::from(i)).take_while(|by| *by <= MOST);
        let clear = steps.into_iter().find(|by| !ahead(network, least, end.at, *by).iter().any(covered))?;
        (clear > 0.0).then_some((end.at, clear))
    };
    ends.into_iter().zip(near).filter_map(clearance).collect()
}

/// Places across the end of a road that is cut so far back, and those so far ahead of them as is to be clear.
fn ahead(network: &RoadNetwork, least: &[Stations], at: RoadEnd, by: f64) -> Vec<Point> {
    let road = network.road(at.road);
    let cut = least[at.road];
    let depth = by.min(from_cut(cut, at.end, cut[1 - at.end.index()]));
    let station = at_depth(cut, at.end, depth);
    let (left, right) = road.section.carriageway();
    let [left, right] = [left, right].map(|edge| road.section.edge(edge));
    let beyond = inward(road, at.end, station) * CLEAR;
    let across = [left, (left + right) / 2.0, right].map(|offset| on_cut(road, at.end, station, offset));
    across.into_iter().flat_map(|place| [place, place + beyond]).collect()
}
