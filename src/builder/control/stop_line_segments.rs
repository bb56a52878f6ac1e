//! Where roads are split: at the stop lines before crosswalks with lights, and where the approach to a stop line begins, on which
//! the lines between lanes are solid and lanes are not changed.

mod lanelet_split;
#[cfg(test)]
mod tests;

use crate::builder::lanes::road_cut::{ConnectionLines, STOP_GAP};
use crate::builder::lanes::types::{Arm, Lanes, RoadPiece, SplitReason};
use crate::builder::layout::map_layout::IntersectionLanelets;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::approach_control::{Control, sign_at};
use crate::builder::network::road_end::at_depth;
use crate::builder::network::{End, Intersection, Road, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::tags::marking::before_stop;
use crate::parallel::InSmallParts;

use super::mid_block_signals::SignalisedCrossing;
use lanelet_split::{EdgeMarkings, LaneletSplitter, RepaintedSegment, RoadSplits, StopApproach, split_lanes};

use rayon::prelude::*;

/// Usual length of the approach, metres: Japan's Road Traffic Act, article 30, forbids to overtake on it, and many agencies paint
/// solid lines over about this length (100 ft) before lights.
const USUAL: f64 = 30.0;
/// Countries where the lines between lanes of one direction are dashed up to the stop line.
const DASHED: [&str; 1] = ["GB"];
/// The least length of an approach, metres: two cars wait on it.
const LEAST: f64 = 10.0;

/// Splits the roads at stop lines between intersections, and before all stop lines where markings change there. `guarded` are
/// the road ends with pedestrian signals only.
pub fn split_before_stop_lines(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lines: &ConnectionLines,
    turning: &[Option<Box<IntersectionLanelets>>],
    (crossings, guarded): (&[SignalisedCrossing], &[RoadEnd]),
    lanes: Lanes,
) -> Lanes {
    let length = usual_length(network);
    let approaches = approaches(network, turning, guarded, &lanes);
    let road_splits = |(i, road): (usize, &Road)| {
        let ix = RoadIx::new(i);
        let crossings = of_road(crossings, ix, |crossing| crossing.road);
        let approaches = of_road(&approaches, ix, |(at, _)| at.road);
        if crossings.is_empty() && approaches.is_empty() {
            return None;
        }
        let pieces = lanes.pieces_of(ix);
        let mut splitter = LaneletSplitter::new(assembly, road, pieces.first()?);
        // The approaches, and the station where their other markings end.
        let mut stops: Vec<(StopApproach, f64, EdgeMarkings)> = Vec::new();
        let approach = |reason, stop_line, toward| StopApproach { reason, stop_line, toward, length, least: LEAST };
        for crossing in crossings {
            End::BOTH.into_iter().for_each(|end| splitter.split_at_stop_line(crossing, end));
            for (end, markings) in before_crosswalk(road, pieces, crossing) {
                // Markings do not change on the crosswalk.
                let [line, last] = [end.other(), end].map(|end| at_depth(crossing.span, end, -STOP_GAP));
                stops.push((approach(SplitReason::Approach(crossing.node, end), line, end), last, markings));
            }
        }
        for (at, markings) in approaches {
            let line = lines.kept[ix][at.end];
            stops.push((approach(SplitReason::Stop(at.end), line, at.end), line, markings.clone()));
        }
        let repainted = stops.into_iter().filter_map(|(approach, last, markings)| {
            let first = splitter.split_at_approach(&approach)?;
            Some(RepaintedSegment { span: [first.min(last), first.max(last)], markings })
        });
        let repainted = repainted.collect();
        Some(RoadSplits { road: ix, splits: splitter.splits, repainted }).filter(|found| !found.splits.is_empty())
    };
    let splits = network.roads.par_iter().in_small_parts().enumerate().filter_map(road_splits).collect();
    split_lanes(assembly, network, lanes, splits)
}

/// The items of a road among all, which are in order of roads.
fn of_road<T>(all: &[T], ix: RoadIx, road: impl Fn(&T) -> RoadIx) -> &[T] {
    let first = all.partition_point(|one| road(one) < ix);
    let count = all[first..].partition_point(|one| road(one) == ix);
    &all[first..first + count]
}

/// The length of the approach, metres, on a way of this length, metres, to a stop line; `None` if there is none.
pub fn length_on(network: &RoadNetwork, way: f64) -> Option<f64> {
    let usual = usual_length(network);
    let length = usual.min(way / 2.0);
    (length > 0.0 && length >= LEAST.min(usual)).then_some(length)
}

/// The length of an approach where there is room, metres.
fn usual_length(network: &RoadNetwork) -> f64 {
    let usual = || if network.country.as_deref().is_some_and(|it| DASHED.contains(&it)) { 0.0 } else { USUAL };
    network.markings.before_stop.unwrap_or_else(usual)
}

/// The ends of roads with a stop line, in order, and the other markings before it.
fn approaches(
    network: &RoadNetwork,
    turning: &[Option<Box<IntersectionLanelets>>],
    guarded: &[RoadEnd],
    lanes: &Lanes,
) -> Vec<(RoadEnd, EdgeMarkings)> {
    let mut found = Vec::new();
    for (intersection, turning) in network.intersections.iter().zip(turning) {
        let Some(turning) = turning.as_ref().filter(|turning| turning.area.is_some()) else { continue };
        let stops = |at: RoadEnd| guarded.binary_search(&at).is_ok() || has_stop_line(network, intersection, at);
        for (i, &at) in intersection.arms.iter().enumerate().filter(|(_, at)| stops(**at)) {
            let leads_on = |lane: usize| {
                turning.drawn.paths.iter().any(|path| (path.movement.from, path.movement.in_lane) == (i, lane))
            };
            let markings = approach_markings(network.road(at.road), lanes, lanes.arm(at), leads_on);
            if !markings.is_empty() {
                found.push((at, markings));
            }
        }
    }
    found.sort_by_key(|(at, _)| *at);
    found
}

/// Whether the end of a road at an intersection has a stop line at which all vehicles stop.
pub fn has_stop_line(network: &RoadNetwork, intersection: &Intersection, at: RoadEnd) -> bool {
    let sign = || sign_at(network.road(at.road), at.end);
    intersection.signals || intersection.all_way_stop || sign() == Control::Stop
}

/// The markings between the lanes of an approach. A lane that does not lead on may be left up to the stop line.
fn approach_markings(road: &Road, lanes: &Lanes, arm: &Arm, leads_on: impl Fn(usize) -> bool) -> EdgeMarkings {
    let strip = |lane: usize| lanes.lanes[arm.into[lane].lane].strip;
    let pairs = (1..arm.into.len()).filter(|&lane| leads_on(lane - 1) && leads_on(lane));
    let edges = pairs.filter_map(|lane| {
        let (a, b) = (strip(lane - 1), strip(lane));
        (a.abs_diff(b) == 1).then_some(a.max(b))
    });
    changed_markings(road, lanes.pieces_of(arm.at.road), edges)
}

/// The markings between the lanes that stop before a crosswalk, by the end of the road to which they lead.
fn before_crosswalk(road: &Road, pieces: &[RoadPiece], crossing: &SignalisedCrossing) -> Vec<(End, EdgeMarkings)> {
    let stopping = End::BOTH.into_iter().filter(|end| crossing.stops[*end]);
    let markings = stopping.map(|end| {
        let own = |edge: &usize| road.section.strips.get(*edge).is_some_and(|strip| strip.travel == end.inbound());
        (end, changed_markings(road, pieces, (0..road.section.strips.len()).filter(own)))
    });
    markings.filter(|(_, markings)| !markings.is_empty()).collect()
}

/// Those of `edges` whose marking changes before a stop line, each with its marking there.
fn changed_markings(road: &Road, pieces: &[RoadPiece], edges: impl Iterator<Item = usize>) -> EdgeMarkings {
    let inverted = |edge: usize| Some((*pieces.first()?.borders.get(edge)?)?.inverted);
    edges.filter_map(|edge| Some((edge, before_stop(&road.section, edge, &road.tags, inverted(edge)?)?))).collect()
}
