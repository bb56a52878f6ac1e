//! Where roads are cut across: at the stop lines before crosswalks with lights, and where the last stretch before a stop
//! line begins, on which lanes are not changed any more: the lines between them are solid there.

mod lanelet_split;
#[cfg(test)]
mod tests;

use crate::builder::lanes::road_cut::{ConnectionLines, STOP_GAP};
use crate::builder::lanes::types::{Arm, Lanes, RoadPiece, SplitReason};
use crate::builder::layout::map_layout::IntersectionLanelets;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::road_end::at_depth;
use crate::builder::network::{End, Intersection, Road, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::tags::cross_section::Travel;
use crate::builder::tags::marking::before_stop;
use crate::parallel::Finely;

use super::pedestrian_crossing_signals::SignalisedCrossing;
use super::{Control, sign_at};
use lanelet_split::{LaneletSplitter, Painted, Stretch};

use rayon::prelude::*;

pub use lanelet_split::LaneletCut;

/// Length of the stretch, metres, where nobody says otherwise: so far before an intersection Japan's Road Traffic Act,
/// article 30, forbids to overtake, and about so far (100 ft) before lights many agencies paint solid lines.
const USUAL: f64 = 30.0;
/// Where the lines between lanes of one direction are dashed up to the stop line.
const DASHED: [&str; 1] = ["GB"];
/// Where there is only room for less than this, metres, there is none: two cars wait on as much.
const LEAST: f64 = 10.0;

/// Cuts the roads at stop lines between intersections, and before all stop lines where that changes what is painted.
pub fn split_before_stop_lines(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lines: &ConnectionLines,
    ways: &[Option<Box<IntersectionLanelets>>],
    (lit, guarded): (&[SignalisedCrossing], &[RoadEnd]),
    lanes: &mut Lanes,
) {
    let wanted = usual_length(network);
    let approaches = approaches(network, ways, guarded, lanes);
    let found = |(i, road): (usize, &Road)| {
        let ix = RoadIx::new(i);
        let lit = of_road(lit, ix, |lit| lit.road);
        let approaches = of_road(&approaches, ix, |(at, _)| at.road);
        if lit.is_empty() && approaches.is_empty() {
            return None;
        }
        let pieces = lanes.pieces_of(ix);
        let mut knife = LaneletSplitter::new(assembly, road, pieces.first()?);
        let mut stops: Vec<(SplitReason, f64, End, f64, Painted)> = Vec::new();
        for lit in lit {
            for end in End::BOTH {
                knife.cut_at_stop_line(lit, end);
            }
            for (end, painted) in before_crosswalk(road, pieces, lit) {
                // Lines do not change on the crosswalk.
                let (line, last) = (at_depth(lit.span, end.other(), -STOP_GAP), at_depth(lit.span, end, -STOP_GAP));
                stops.push((SplitReason::Approach(lit.node, end), line, end, last, painted));
            }
        }
        for (at, painted) in approaches {
            let line = lines.kept[i][at.end];
            stops.push((SplitReason::Stop(at.end), line, at.end, line, painted.clone()));
        }
        let stretches = stops.into_iter().filter_map(|(cause, line, end, last, painted)| {
            let first = knife.cut_stretch(cause, line, end, wanted, LEAST)?;
            Some(Stretch { span: [first.min(last), first.max(last)], painted })
        });
        let stretches: Vec<Stretch> = stretches.collect();
        Some((ix, knife.into_cuts(), stretches)).filter(|(_, cuts, _)| !cuts.is_empty())
    };
    let found = network.roads.par_iter().finely().enumerate().filter_map(found).collect();
    lanes.divide(assembly, network, found);
}

/// What belongs to a road among things in the order of the roads.
fn of_road<T>(all: &[T], ix: RoadIx, road: impl Fn(&T) -> RoadIx) -> &[T] {
    let first = all.partition_point(|one| road(one) < ix);
    let count = all[first..].partition_point(|one| road(one) == ix);
    &all[first..first + count]
}

/// How long the stretch before a stop line is, metres, that drivers reach over a way of some length; `None` if there is none.
pub fn length_on(network: &RoadNetwork, way: f64) -> Option<f64> {
    let wanted = usual_length(network);
    let length = wanted.min(way / 2.0);
    (length > 0.0 && length >= LEAST.min(wanted)).then_some(length)
}

/// How long the stretch is where there is room, metres.
fn usual_length(network: &RoadNetwork) -> f64 {
    let usual = || if network.country.as_deref().is_some_and(|it| DASHED.contains(&it)) { 0.0 } else { USUAL };
    network.markings.before_stop.unwrap_or_else(usual)
}

/// The ends of roads with a stop line before which other lines are painted, in order.
fn approaches(
    network: &RoadNetwork,
    ways: &[Option<Box<IntersectionLanelets>>],
    guarded: &[RoadEnd],
    lanes: &Lanes,
) -> Vec<(RoadEnd, Painted)> {
    let mut found = Vec::new();
    for (intersection, ways) in network.intersections.iter().zip(ways) {
        let Some(ways) = ways.as_ref().filter(|ways| ways.area.is_some()) else { continue };
        let stops = |at: RoadEnd| guarded.binary_search(&at).is_ok() || has_stop_line(network, intersection, at);
        for (i, &at) in intersection.arms.iter().enumerate().filter(|(_, at)| stops(**at)) {
            let leads_on = |lane: usize| {
                ways.drawn.paths.iter().any(|path| (path.movement.from, path.movement.in_lane) == (i, lane))
            };
            let painted = painted(network.road(at.road), lanes, lanes.arm(at), leads_on);
            if !painted.is_empty() {
                found.push((at, painted));
            }
        }
    }
    found.sort_by_key(|(at, _)| *at);
    found
}

/// Whether vehicles stop at a line where a road ends at an intersection.
pub fn has_stop_line(network: &RoadNetwork, intersection: &Intersection, at: RoadEnd) -> bool {
    let signed = || sign_at(network.road(at.road), at.end) == Control::Stop;
    intersection.signals || intersection.all_way_stop || signed()
}

/// What is painted between the lanes of an approach. Who came to a lane that does not lead on may leave it to the last.
fn painted(road: &Road, lanes: &Lanes, arm: &Arm, leads_on: impl Fn(usize) -> bool) -> Painted {
    let strip = |lane: usize| lanes.lanes[arm.into[lane].lane].strip;
    let pairs = (1..arm.into.len()).filter(|&lane| leads_on(lane - 1) && leads_on(lane));
    let edges = pairs.filter_map(|lane| {
        let (a, b) = (strip(lane - 1), strip(lane));
        (a.abs_diff(b) == 1).then_some(a.max(b))
    });
    repainted(road, lanes.pieces_of(arm.at.road), edges)
}

/// What is painted between the lanes that stop before a crosswalk, by the end of the road that they head for.
fn before_crosswalk(road: &Road, pieces: &[RoadPiece], lit: &SignalisedCrossing) -> Vec<(End, Painted)> {
    let towards = [(End::Start, Travel::Backward), (End::End, Travel::Forward)];
    let stopping = towards.into_iter().filter(|(end, _)| lit.stops[*end]);
    let painted = stopping.map(|(end, travel)| {
        let own = |edge: &usize| road.section.strips.get(*edge).is_some_and(|strip| strip.travel == travel);
        (end, repainted(road, pieces, (0..road.section.strips.len()).filter(own)))
    });
    painted.filter(|(_, painted)| !painted.is_empty()).collect()
}

/// Those of some edges of a road that are painted otherwise before a stop line.
fn repainted(road: &Road, pieces: &[RoadPiece], edges: impl Iterator<Item = usize>) -> Painted {
    let inverted = |edge: usize| Some((*pieces.first()?.borders.get(edge)?)?.inverted);
    edges.filter_map(|edge| Some((edge, before_stop(&road.section, edge, &road.tags, inverted(edge)?)?))).collect()
}
