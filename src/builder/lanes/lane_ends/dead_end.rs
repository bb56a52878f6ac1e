//! The setbacks of dead ends from carriageways beside which they end, to which OpenStreetMap does not connect them.

use std::borrow::Cow;

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::builder::network::road_end::{at_depth, from_cut, inward, on_cut};
use crate::builder::network::{End, Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, Polyline, polygon};
use crate::parallel::Finely;

use super::turn_setback::EndSetbacks;

/// Lanes that end keep this distance, metres, from a carriageway ahead: a kerb or a gate lies between.
const CLEAR: f64 = 1.5;
/// So near to its edges, metres, a road that ends may lie on the carriageway of one that runs beside it: nobody drives there.
const BESIDE: f64 = 0.5;
/// The largest setback, metres, ...
const MOST: f64 = 6.0;
/// ... and the step, metres, by which it is sought.
const STEP: f64 = 0.5;
/// A road that ends beside itself has led around a loop that is longer, metres, than this and its width.
const LOOP_LEAST: f64 = 20.0;
/// Cells of this side, metres, hold the ground around dead ends.
const CELL: f64 = 20.0;

/// The dead ends before carriageways on their level, each with its setback, metres. One that would not get clear has none. Where the
/// extract ends, roads end, too.
pub fn dead_end_setbacks(network: &RoadNetwork, least: &[Stations]) -> EndSetbacks {
    let dead = network.intersections.iter().filter(|it| it.arms.len() == 1 && it.circle.is_none());
    let reach = |at| polygon::bounds(&[0.0, MOST].map(|setback| ground_ahead(network, least, at, setback)).concat());
    let (ends, reaches): (Vec<RoadEnd>, Vec<_>) = dead.filter_map(|it| Some((it.arms[0], reach(it.arms[0])?))).unzip();
    let cells = SpatialHash::new(reaches, CELL);
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
    let ends = ends.into_iter().zip(near);
    ends.filter_map(|(at, near)| Some((at, clear_setback(network, least, at, &near)?))).collect()
}

/// The least setback, metres, by which a dead end keeps clear of the roads near it; `None` without one, and where it is zero.
fn clear_setback(network: &RoadNetwork, least: &[Stations], at: RoadEnd, near: &FxHashSet<RoadIx>) -> Option<f64> {
    let own = network.road(at.road);
    let others = near.iter().filter(|road| **road != at.road).map(|road| network.road(*road));
    let others =
        others.filter(|road| road.level == own.level).map(|road| (Cow::Borrowed(&road.line), road.half_width()));
    // A road can lead around a loop and end beside itself.
    let length = own.line.length();
    let far = at_depth([0.0, length], at.end, LOOP_LEAST + own.section.width());
    let rest = match at.end {
        End::Start => own.line.cut(far, length),
        End::End => own.line.cut(0.0, far),
    };
    let others: Vec<(Cow<Polyline>, f64)> =
        others.chain(rest.map(|line| (Cow::Owned(line), own.half_width()))).collect();
    let covered = |place: &Point| others.iter().any(|(line, half)| line.distance(*place) < *half);
    let mut steps = (0..).map(|i| STEP * f64::from(i)).take_while(|setback| *setback <= MOST);
    let clear = steps.find(|setback| !ground_ahead(network, least, at, *setback).iter().any(covered))?;
    (clear > 0.0).then_some(clear)
}

/// Places across the end of a road with this setback, metres, and those ahead of them up to which the ground must be clear.
fn ground_ahead(network: &RoadNetwork, least: &[Stations], at: RoadEnd, setback: f64) -> Vec<Point> {
    let road = network.road(at.road);
    let cut = least[at.road];
    let station = at_depth(cut, at.end, setback.min(from_cut(cut, at.end, cut[at.end.other()])));
    let (left, right) = road.section.carriageway();
    let [left, right] = [left, right].map(|edge| road.section.edge(edge));
    let beyond = inward(road, at.end, station) * CLEAR;
    let middle = (left + right) / 2.0;
    let inner = |edge: f64| edge + (middle - edge).clamp(-BESIDE, BESIDE);
    let across = [inner(left), middle, inner(right)].map(|offset| on_cut(road, at.end, station, offset));
    across.into_iter().flat_map(|place| [place, place + beyond]).collect()
}
