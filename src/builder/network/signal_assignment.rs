//! Which intersection the lights and signs on its arms belong to.

use crate::builder::tags::cross_section::Travel;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::osm::OsmData;

use super::features::only_travel;
use super::{End, Feature, FeatureKind, IntersectionIx, Road, RoadEnd, RoadNetwork};

/// Lights and signs stand no further than this before the intersection they rule, metres along the road: behind a
/// stop line, a crosswalk and a bicycle box.
const REACH: f64 = 30.0;

/// Gives signs without a direction the travel toward the intersection they stand at, and tells the intersections
/// what stands on their arms.
pub(super) fn assign(osm: &OsmData, network: &mut RoadNetwork, notes: &mut Vec<Finding>) {
    let facing: Vec<Vec<Feature>> = network.roads.iter().map(|road| faced(network, road)).collect();
    for (intersection, ix) in network.intersections.iter().zip(0..) {
        let dropped = |arm: &RoadEnd| {
            let before = network.road(arm.road).features.iter().filter(|f| is_sign(f.kind)).count();
            let after = facing[arm.road].iter().filter(|f| is_sign(f.kind)).count();
            after < before
        };
        if is_crossing(network, IntersectionIx(ix)) && intersection.arms.iter().all(dropped) {
            let Some(&node) = intersection.nodes.first() else { continue };
            let message =
                format!("the sign at node {node} stands where equal roads meet; it is not known whom it binds");
            notes.push(Finding::new("sign-ambiguous", Subject::Node(node), message).graded(Severity::Info));
        }
    }
    for (road, features) in network.roads.iter_mut().zip(facing) {
        road.features = features;
    }
    let ruled: Vec<(bool, bool)> =
        (0..network.intersections.len() as u32).map(|i| ruled(osm, network, IntersectionIx(i))).collect();
    for (intersection, (signals, all_way_stop)) in network.intersections.iter_mut().zip(ruled) {
        intersection.signals |= signals;
        intersection.all_way_stop |= all_way_stop;
    }
}

/// Whether roads really meet here, or one only continues as another or ends.
fn is_crossing(network: &RoadNetwork, ix: IntersectionIx) -> bool {
    network.intersection(ix).arms.len() >= 3
}

fn is_sign(kind: FeatureKind) -> bool {
    matches!(kind, FeatureKind::Stop(_) | FeatureKind::GiveWay(_))
}

/// Whether a sign on the very node of an intersection binds the traffic of this road: everybody with `stop=all`,
/// else those on a road of a lower class than another.
fn sign_binds(network: &RoadNetwork, road: &Road, ix: IntersectionIx) -> bool {
    let intersection = network.intersection(ix);
    let highest = intersection.arms.iter().map(|arm| network.road(arm.road).class).min();
    !is_crossing(network, ix) || intersection.all_way_stop || highest.is_some_and(|highest| highest < road.class)
}

/// The road's features, with stop lines, stop and give-way signs meant for the travel toward the nearer crossing.
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
        let at =
            [(road.key.first, road.from), (road.key.last, road.to)].into_iter().find(|(id, _)| *id == feature.node);
        !is_sign(feature.kind) || at.is_none_or(|(_, ix)| sign_binds(network, road, ix))
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

/// Whether lights rule an intersection, and whether all who arrive must stop: a sign says `stop=all`, or there is one for each
/// of them and none says `stop=minor`.
fn ruled(osm: &OsmData, network: &RoadNetwork, ix: IntersectionIx) -> (bool, bool) {
    if !is_crossing(network, ix) {
        return (false, false);
    }
    let arriving: Vec<RoadEnd> =
        network.intersection(ix).arms.iter().copied().filter(|arm| arrives(network.road(arm.road), arm.end)).collect();
    let stands = |arm: &RoadEnd, wanted: &dyn Fn(&Feature) -> bool| stands_on(network, *arm, wanted);
    let is_stop = |feature: &Feature| matches!(feature.kind, FeatureKind::Stop(_));
    let says = |feature: &Feature, whom: &str| {
        is_stop(feature) && osm.node(feature.node).is_some_and(|node| node.tags.is("stop", whom))
    };
    let any = |wanted: &dyn Fn(&Feature) -> bool| arriving.iter().any(|arm| stands(arm, wanted));
    let signals = any(&|feature| matches!(feature.kind, FeatureKind::Signals(_)));
    let on_each = arriving.len() >= 3 && arriving.iter().all(|arm| stands(arm, &is_stop));
    let all_stop = (on_each || any(&|feature| says(feature, "all"))) && !any(&|feature| says(feature, "minor"));
    (signals, all_stop)
}

/// Whether traffic reaches this end of the road.
pub(super) fn arrives(road: &Road, end: End) -> bool {
    let wanted = end.inbound();
    only_travel(road).is_none_or(|only| only == wanted)
}

/// Whether a feature of the wanted kind, meant for traffic that arrives on `arm`, stands within reach; looks on where
/// one road only continues as another.
fn stands_on(network: &RoadNetwork, arm: RoadEnd, wanted: impl Fn(&Feature) -> bool) -> bool {
    let mut arm = arm;
    let mut before = 0.0;
    // Each step goes over a road; a ring of tiny roads must end too.
    for _ in 0..8 {
        let road = network.road(arm.road);
        let length = road.line.length();
        let other = match arm.end {
            End::Start => End::End,
            End::End => End::Start,
        };
        let far_crossing = is_crossing(network, road.intersection(other));
        let here = road.features.iter().any(|feature| {
            let distance = match arm.end {
                End::Start => feature.station,
                End::End => length - feature.station,
            };
            let nearer = !far_crossing || before + distance <= length - distance;
            let faces = match feature.kind {
                FeatureKind::Signals(Travel::Both) => nearer,
                FeatureKind::Signals(t) | FeatureKind::Stop(t) | FeatureKind::GiveWay(t) => t == arm.end.inbound(),
                FeatureKind::Crossing { .. } | FeatureKind::StopLine(_) | FeatureKind::Sidewalk => false,
            };
            // What stands at the far crossing itself rules that one.
            let own = !far_crossing || distance < length;
            wanted(feature) && faces && own && before + distance <= REACH
        });
        if here {
            return true;
        }
        before += length;
        let next = network.intersection(road.intersection(other));
        let beyond = next.arms.iter().find(|a| a.road != arm.road);
        match beyond {
            Some(beyond) if next.arms.len() == 2 && before <= REACH => arm = *beyond,
            _ => return false,
        }
    }
    false
}
