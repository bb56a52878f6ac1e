//! Decides which roads lie inside an intersection, because no vehicle waits on them.

use crate::builder::network::{End, FeatureKind, IntersectionIx, Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::builder::tags::cross_section::Travel;
use crate::builder::tags::road_class::RoadClass;
use crate::geometry::Vector;
use crate::parallel::InSmallParts;

use super::types::{SHORT, SHORT_ACROSS_MEDIAN, SHORT_BETWEEN_SIGNALS};
use super::user_overrides::overridden;
use super::{ConsolidateOptions, MergeReason, MergeVerdict};

use rayon::prelude::*;

/// A longer road with `junction=intersection`, metres, is a tagging mistake.
const TAGGED: f64 = 60.0;

/// A verdict for every road with a reason to merge it.
pub fn decide(network: &RoadNetwork, kept: &[Stations], options: &ConsolidateOptions) -> Vec<MergeVerdict> {
    let wishes = overridden(network, &options.wishes);
    let lengths = kept.par_iter().in_small_parts().map(|[from, to]| to - from).enumerate();
    let roads = lengths.map(|(i, left)| (RoadIx::new(i), left));
    roads.filter_map(|(ix, left)| verdict(network, ix, left, options, wishes.get(&ix).copied())).collect()
}

fn verdict(
    network: &RoadNetwork,
    ix: RoadIx,
    left: f64,
    options: &ConsolidateOptions,
    wish: Option<usize>,
) -> Option<MergeVerdict> {
    let road = network.road(ix);
    let verdict = |merge, reason| Some(MergeVerdict { road: ix, merge, reason, left, wish });
    if let Some(wish) = wish.and_then(|wish| options.wishes.get(wish)) {
        return if road.from == road.to { None } else { verdict(wish.merge, MergeReason::Wish) };
    }
    let reason = reason_to_merge(network, road, left, options)?;
    if road.from == road.to {
        return None;
    }
    let ends = [network.intersection(road.from), network.intersection(road.to)];
    if ends.iter().any(|i| i.map_edge || i.arms.len() < 2) {
        return verdict(false, MergeReason::Edge);
    }
    if reason != MergeReason::Tagged && left > SHORT && stops_inside(road) {
        return verdict(false, MergeReason::OwnStopLine);
    }
    verdict(true, reason)
}

/// Why a road with `left` metres between its cuts should merge; `None` if there is no reason.
fn reason_to_merge(network: &RoadNetwork, road: &Road, left: f64, options: &ConsolidateOptions) -> Option<MergeReason> {
    if road.tags.is("junction", "intersection") && road.line.length() <= TAGGED {
        return Some(MergeReason::Tagged);
    }
    // Vehicles do not wait on a roundabout.
    let short = if road.roundabout { options.short_on_ring } else { SHORT };
    if left < short {
        return Some(MergeReason::Short);
    }
    if road.roundabout {
        return None;
    }
    let [a, b] = [network.intersection(road.from), network.intersection(road.to)];
    if a.signals && b.signals && left < SHORT_BETWEEN_SIGNALS {
        return Some(MergeReason::BetweenSignals);
    }
    (left < SHORT_ACROSS_MEDIAN && crosses_median(network, road)).then_some(MergeReason::AcrossMedian)
}

/// Whether a stop line, for either direction, stands on the road between its intersections.
fn stops_inside(road: &Road) -> bool {
    let length = road.line.length();
    road.features.iter().any(|f| {
        let inside = f.station > 1.0 && f.station < length - 1.0;
        let is_control = match f.kind {
            FeatureKind::Crossing { .. } | FeatureKind::StopLine(_) | FeatureKind::Sidewalk => false,
            FeatureKind::Signals(_)
            | FeatureKind::MidBlockSignals(_)
            | FeatureKind::Stop(_)
            | FeatureKind::GiveWay(_) => true,
        };
        inside && is_control
    })
}

/// Whether the road connects the two carriageways of a dual carriageway: at each end a one-way street passes across it, and the
/// two have opposite directions and the same name. Service roads do not count, because the aisles of a car park look like that.
fn crosses_median(network: &RoadNetwork, road: &Road) -> bool {
    let chord = (road.line.last() - road.line.first()).normalize();
    let here = carriageways(network, road.from, road, chord);
    let there = carriageways(network, road.to, road, chord);
    here.iter().any(|a| {
        there
            .iter()
            .any(|b| a.direction.dot(&b.direction) < OPPOSITE && network.road(a.road).name == network.road(b.road).name)
    })
}

/// Cosine of the angle beyond which two carriageways run in opposite directions: 135 degrees.
const OPPOSITE: f64 = -0.7;
/// Cosine of the smallest angle at which a carriageway crosses a road instead of joining it: 45 degrees.
const ACROSS: f64 = 0.7;

struct Carriageway {
    road: RoadIx,
    direction: Vector,
}

/// The one-way streets that pass an intersection across `chord`.
fn carriageways(network: &RoadNetwork, ix: IntersectionIx, besides: &Road, chord: Vector) -> Vec<Carriageway> {
    network
        .intersection(ix)
        .arms
        .iter()
        .filter(|arm| network.road(arm.road).key != besides.key)
        .filter_map(|arm| {
            let direction = one_way_direction(network, *arm)?;
            let street = network.road(arm.road).class < RoadClass::Service;
            (street && direction.dot(&chord).abs() < ACROSS).then_some(Carriageway { road: arm.road, direction })
        })
        .collect()
}

/// Direction of travel on a one-way road near one of its ends; `None` if it is not one-way.
fn one_way_direction(network: &RoadNetwork, arm: RoadEnd) -> Option<Vector> {
    let road = network.road(arm.road);
    let travel = road.one_way()?;
    let along = match arm.end {
        End::Start => road.line.direction(0.0),
        End::End => road.line.direction(road.line.length()),
    };
    Some(if travel == Travel::Forward { along } else { -along })
}
