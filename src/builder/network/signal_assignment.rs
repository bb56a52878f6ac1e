//! Assigns lights and signs on the arms to the intersection that they control.

use crate::builder::tags::cross_section::Travel;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::osm::OsmData;

use super::road_end::{from_cut, other_end};
use super::{End, Feature, FeatureKind, IntersectionIx, Road, RoadEnd, RoadNetwork};

/// The largest distance of a light or sign before the intersection that it controls, metres along the road: room for a stop line, a
/// crosswalk and a bicycle box.
const SIGNAL_FROM_JUNCTION: f64 = 30.0;

/// Gives signs without a direction the travel toward the intersection beside them, and sets the control of the intersections.
pub(super) fn assign(osm: &OsmData, network: &mut RoadNetwork, notes: &mut Vec<Finding>) {
    let facing: Vec<Vec<Feature>> = network.roads.iter().map(|road| faced(network, road)).collect();
    for ix in IntersectionIx::all(network.intersections.len()) {
        let intersection = network.intersection(ix);
        let dropped = |arm: &RoadEnd| {
            let before = network.road(arm.road).features.iter().filter(|f| is_sign(f.kind)).count();
            let after = facing[arm.road].iter().filter(|f| is_sign(f.kind)).count();
            after < before
        };
        if is_crossing(network, ix) && intersection.arms.iter().all(dropped) {
            let Some(&node) = intersection.nodes.first() else { continue };
            let message =
                format!("the sign at node {node} stands where equal roads meet; it is not known whom it binds");
            notes.push(Finding::new("sign-ambiguous", Subject::Node(node), message).graded(Severity::Info));
        }
    }
    for (road, features) in network.roads.iter_mut().zip(facing) {
        road.features = features;
    }
    let controls: Vec<(bool, bool)> =
        IntersectionIx::all(network.intersections.len()).map(|ix| controls(osm, network, ix)).collect();
    for (intersection, (signals, all_way_stop)) in network.intersections.iter_mut().zip(controls) {
        intersection.signals |= signals;
        intersection.all_way_stop |= all_way_stop;
    }
}

/// Whether three or more arms meet here.
pub(super) fn is_crossing(network: &RoadNetwork, ix: IntersectionIx) -> bool {
    network.intersection(ix).arms.len() >= 3
}

fn is_sign(kind: FeatureKind) -> bool {
    matches!(kind, FeatureKind::Stop(_) | FeatureKind::GiveWay(_))
}

/// Whether a sign on the node of an intersection applies to this road: with `stop=all` to every road, else to roads of a lower
/// class than another.
fn sign_binds(network: &RoadNetwork, road: &Road, ix: IntersectionIx) -> bool {
    let intersection = network.intersection(ix);
    let highest = intersection.arms.iter().map(|arm| network.road(arm.road).class).min();
    !is_crossing(network, ix) || intersection.all_way_stop || highest.is_some_and(|highest| highest < road.class)
}

/// The road's features. Stop lines and signs without a direction get the travel toward the nearer crossing.
fn faced(network: &RoadNetwork, road: &Road) -> Vec<Feature> {
    let length = road.line.length();
    let toward = |station: f64| {
        let start = is_crossing(network, road.from).then_some((station, Travel::Backward));
        let end = is_crossing(network, road.to).then_some((length - station, Travel::Forward));
        let nearest = start.into_iter().chain(end).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or(Travel::Both, |(_, travel)| travel)
    };
    let mut features = road.features.clone();
    features.retain(|feature| {
        let end = End::BOTH.into_iter().find(|end| road.node(*end) == feature.node);
        !is_sign(feature.kind) || end.is_none_or(|end| sign_binds(network, road, road.intersection(end)))
    });
    for feature in &mut features {
        match &mut feature.kind {
            FeatureKind::Stop(travel) | FeatureKind::GiveWay(travel) | FeatureKind::StopLine(travel)
                if *travel == Travel::Both =>
            {
                *travel = toward(feature.station);
            }
            _ => {}
        }
    }
    features
}

/// Whether an intersection has lights, and whether it is an all-way stop: a sign has `stop=all`, or every approach has one and
/// none has `stop=minor`.
fn controls(osm: &OsmData, network: &RoadNetwork, ix: IntersectionIx) -> (bool, bool) {
    if !is_crossing(network, ix) {
        return (false, false);
    }
    let approaches: Vec<RoadEnd> = approaches(network, ix).collect();
    let any = |fits: &dyn Fn(&Feature) -> bool| approaches.iter().any(|arm| controls_arm(network, *arm, fits));
    let stop_for = |feature: &Feature, whom: &str| {
        is_stop(feature) && osm.node(feature.node).is_some_and(|node| node.tags.is("stop", whom))
    };
    let signals = approaches.iter().any(|arm| has_lights(network, *arm));
    let on_each = approaches.len() >= 3 && approaches.iter().all(|arm| controls_arm(network, *arm, is_stop));
    let all_stop = (on_each || any(&|feature| stop_for(feature, "all"))) && !any(&|feature| stop_for(feature, "minor"));
    (signals, all_stop)
}

/// The arms on which traffic arrives.
pub(super) fn approaches(network: &RoadNetwork, ix: IntersectionIx) -> impl Iterator<Item = RoadEnd> + '_ {
    let arms = network.intersection(ix).arms.iter().copied();
    arms.filter(|arm| arrives(network.road(arm.road), arm.end))
}

fn is_stop(feature: &Feature) -> bool {
    matches!(feature.kind, FeatureKind::Stop(_))
}

/// Whether traffic reaches this end of the road.
pub fn arrives(road: &Road, end: End) -> bool {
    road.one_way().is_none_or(|travel| travel == end.inbound())
}

/// Whether lights face the traffic that arrives on an arm.
pub fn has_lights(network: &RoadNetwork, arm: RoadEnd) -> bool {
    controls_arm(network, arm, |feature| matches!(feature.kind, FeatureKind::Signals(_)))
}

/// Whether a feature that fits controls the traffic that arrives on `arm`; the search goes on where one road only continues as
/// another.
pub(super) fn controls_arm(network: &RoadNetwork, mut arm: RoadEnd, mut fits: impl FnMut(&Feature) -> bool) -> bool {
    let mut before = 0.0;
    // The limit ends the search in a ring of tiny roads.
    for _ in 0..8 {
        let road = network.road(arm.road);
        if road.features.iter().any(|feature| faces(network, arm, feature, before) && fits(feature)) {
            return true;
        }
        before += road.line.length();
        let next = network.intersection(network.intersection_at(other_end(arm)));
        let beyond = next.arms.iter().find(|a| a.road != arm.road);
        match beyond {
            Some(beyond) if next.arms.len() == 2 && before <= SIGNAL_FROM_JUNCTION => arm = *beyond,
            _ => return false,
        }
    }
    false
}

/// Whether a feature faces the traffic that arrives on `arm`, within reach of an intersection `before` metres ahead.
fn faces(network: &RoadNetwork, arm: RoadEnd, feature: &Feature, before: f64) -> bool {
    let length = network.road(arm.road).line.length();
    let far_crossing = is_crossing(network, network.intersection_at(other_end(arm)));
    let distance = from_cut([0.0, length], arm.end, feature.station);
    let faces = match feature.kind {
        FeatureKind::Signals(Travel::Both) => !far_crossing || before + distance <= length - distance,
        FeatureKind::Signals(t) | FeatureKind::Stop(t) | FeatureKind::GiveWay(t) => t == arm.end.inbound(),
        FeatureKind::Crossing { .. }
        | FeatureKind::MidBlockSignals(_)
        | FeatureKind::StopLine(_)
        | FeatureKind::Sidewalk => false,
    };
    // A feature on the node of the far crossing controls that one.
    faces && (!far_crossing || distance < length) && before + distance <= SIGNAL_FROM_JUNCTION
}
