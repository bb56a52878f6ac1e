//! Shortens dead ends that are drawn on the carriageway of a road to which OpenStreetMap does not connect them.

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::builder::network::road_end::{at_depth, inward, on_cut};
use crate::builder::network::{End, Road, RoadEnd, RoadIx, RoadNetwork};
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, Polyline, polygon};
use crate::parallel::InSmallParts;

use super::set_line;

/// Where the extract ends, lanes reach to the end of their road; they keep this distance, metres, from a carriageway ahead: a kerb
/// or a gate lies between. At other dead ends they end before the square.
const LANES_FROM_CARRIAGEWAY: f64 = 1.5;
/// So near to its edges, metres, a road that ends may lie on the carriageway of one that runs beside it: nobody drives there.
const BESIDE: f64 = 0.5;
/// The largest part of a road that is left out, metres, ...
const MOST: f64 = 12.0;
/// ... and as a share of its length.
const SHARE: f64 = 0.5;
/// The step, metres, by which it is sought.
const SEARCH_STEP: f64 = 0.5;
/// A road that ends beside itself has led around a loop that is longer, metres, than this and its width.
const LOOP_LEAST: f64 = 20.0;
/// What lies less than this, metres, behind the end of a line lies before it: two roads that end at a gate face each other.
const BEFORE: f64 = 0.01;
/// Cells of this side, metres, hold the ground around dead ends.
const CELL: f64 = 20.0;

/// The network with every dead end clear of the carriageways on its level. One that would not get clear stays as it is drawn.
#[must_use]
pub fn end_before_carriageways(mut network: RoadNetwork) -> RoadNetwork {
    let setbacks = setbacks(&network);
    for (RoadEnd { road, end }, setback) in setbacks {
        let road = &mut network.roads[road];
        let mut kept = [0.0, road.line.length()];
        kept[end] = at_depth(kept, end, setback);
        if let Some(line) = road.line.cut(kept[0], kept[1]) {
            set_line(road, line);
        }
    }
    network
}

/// The dead ends that lie on carriageways, each with how far it is set back, metres.
fn setbacks(network: &RoadNetwork) -> Vec<(RoadEnd, f64)> {
    let dead = network.intersections.iter().filter(|it| it.arms.len() == 1 && it.circle.is_none());
    let dead = dead.map(|it| DeadEnd {
        network,
        at: it.arms[0],
        clear: if it.map_edge { LANES_FROM_CARRIAGEWAY } else { 0.0 },
    });
    let reach = |end: &DeadEnd| polygon::bounds(&[0.0, MOST].map(|setback| end.ground(setback)).concat());
    let (ends, reaches): (Vec<DeadEnd>, Vec<_>) =
        dead.filter_map(|end| Some((reach(&end)?, end))).map(|(r, e)| (e, r)).unzip();
    let cells = SpatialHash::new(reaches, CELL);
    let reached = |(ix, road): (usize, &Road)| {
        let mut reached: Vec<(usize, RoadIx)> = Vec::new();
        road.segment_bounds().for_each(|reach| cells.touching(reach, |end| reached.push((end, RoadIx::new(ix)))));
        reached
    };
    let reached: Vec<(usize, RoadIx)> =
        network.roads.par_iter().in_small_parts().enumerate().flat_map_iter(reached).collect();
    let mut near: Vec<FxHashSet<RoadIx>> = vec![FxHashSet::default(); ends.len()];
    for (end, road) in reached {
        near[end].insert(road);
    }
    let ends = ends.into_iter().zip(near);
    ends.filter_map(|(end, near)| Some((end.at, end.setback(&near)?))).collect()
}

/// A dead end, and how much ground ahead of it must be clear, metres.
struct DeadEnd<'a> {
    network: &'a RoadNetwork,
    at: RoadEnd,
    clear: f64,
}

impl DeadEnd<'_> {
    fn road(&self) -> &Road {
        self.network.road(self.at.road)
    }

    /// The least setback, metres, by which it keeps clear of the roads near it; `None` without one, and where it is zero.
    fn setback(&self, near: &FxHashSet<RoadIx>) -> Option<f64> {
        let own = self.road();
        let others = near.iter().filter(|road| **road != self.at.road).map(|road| self.network.road(*road));
        let others: Vec<(&Polyline, f64)> =
            others.filter(|road| road.level == own.level).map(|road| (&road.line, road.half_width())).collect();
        // A road can lead around a loop and end beside itself.
        let length = own.line.length();
        let far = at_depth([0.0, length], self.at.end, LOOP_LEAST + own.section.width());
        let rest = match self.at.end {
            End::Start => own.line.cut(far, length),
            End::End => own.line.cut(0.0, far),
        };
        let rest = rest.as_ref().map(|line| (line, own.half_width()));
        let covered = |place: &Point| others.iter().chain(&rest).any(|(line, half)| lies_on(line, *half, *place));
        let most = MOST.min(length * SHARE);
        let mut steps = (0..).map(|i| SEARCH_STEP * f64::from(i)).take_while(|setback| *setback <= most);
        let clear = steps.find(|setback| !self.ground(*setback).iter().any(covered))?;
        (clear > 0.0).then_some(clear)
    }

    /// Places across the end of the road with this setback, metres, and those ahead of them up to which the ground must be clear.
    fn ground(&self, setback: f64) -> Vec<Point> {
        let (road, end) = (self.road(), self.at.end);
        let length = road.line.length();
        let station = at_depth([0.0, length], end, setback.min(length));
        let (left, right) = road.section.carriageway();
        let [left, right] = [left, right].map(|edge| road.section.edge(edge));
        let beyond = inward(road, end, station) * self.clear;
        let middle = f64::midpoint(left, right);
        let inner = |edge: f64| edge + (middle - edge).clamp(-BESIDE, BESIDE);
        let across = [inner(left), middle, inner(right)].map(|offset| on_cut(road, end, station, offset));
        across.into_iter().flat_map(|place| [place, place + beyond]).collect()
    }
}

/// Whether a place lies on the ground of a road with this line and half width, metres, and not before an end of it.
fn lies_on(line: &Polyline, half: f64, place: Point) -> bool {
    let nearest = line.project(place);
    nearest.offset.abs() < half && nearest.station > BEFORE && nearest.station < line.length() - BEFORE
}
