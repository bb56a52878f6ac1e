//! Assigns a crossing on the node of a junction to the roads that it crosses, by the footways around the node.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, Vector, angle_between};
use crate::osm::{OsmData, Tags};

use super::frame::ToMetres;
use super::road_end::outward;
use super::{End, Feature, FeatureKind, IntersectionIx, RoadEnd, RoadNetwork};

/// Distance from the junction at which directions are taken, metres.
const LOOK: f64 = 4.0;

/// Keeps each crossing on the node of a junction only on the roads that it crosses, with a note if there are none. The footways
/// around the node separate its arms: an arm alone between two footways is crossed.
pub(super) fn assign_crossings(
    osm: &OsmData,
    to_metres: ToMetres<'_>,
    network: &mut RoadNetwork,
    notes: &mut Vec<Finding>,
) {
    let junctions: Vec<(i64, IntersectionIx)> = network
        .intersections
        .iter()
        .zip(0..)
        .filter(|(i, _)| i.arms.len() > 2 && i.arms.iter().any(|&arm| crossing_at(network, arm, i.nodes[0]).is_some()))
        .map(|(i, ix)| (i.nodes[0], IntersectionIx(ix)))
        .collect();
    let on_foot = on_foot(osm, to_metres, &junctions);
    for (node, ix) in junctions {
        let intersection = network.intersection(ix);
        let place = intersection.position;
        let paths = on_foot.get(&node).map_or(&[][..], Vec::as_slice);
        let arms = intersection.arms.clone();
        let crossed = crossed(network, ix, paths);
        if !crossed.contains(&true) {
            let message = format!("it is not known which road the crossing at node {node}, where roads meet, crosses");
            let note = Finding::new("crossing-ambiguous", Subject::Node(node), message).at(Place::Point(place));
            notes.push(note.graded(Severity::Info));
        }
        for arm in arms.into_iter().zip(crossed).filter_map(|(arm, crossed)| (!crossed).then_some(arm)) {
            if let Some(feature) = crossing_at(network, arm, node) {
                network.roads[arm.road].features.remove(feature);
            }
        }
    }
}

/// The position of the feature at this road end that is a crossing on the junction's node.
fn crossing_at(network: &RoadNetwork, arm: RoadEnd, node: i64) -> Option<usize> {
    let road = network.road(arm.road);
    let station = if arm.end == End::Start { 0.0 } else { road.line.length() };
    let here = |f: &Feature| f.node == node && f.station == station && matches!(f.kind, FeatureKind::Crossing { .. });
    road.features.iter().position(here)
}

/// The points next to each junction's node on footways.
fn on_foot(osm: &OsmData, to_metres: ToMetres<'_>, junctions: &[(i64, IntersectionIx)]) -> FxHashMap<i64, Vec<Point>> {
    let mut found: FxHashMap<i64, Vec<i64>> = junctions.iter().map(|(node, _)| (*node, Vec::new())).collect();
    for way in osm.ways.iter().filter(|way| is_footway(&way.tags)) {
        for (a, b) in way.nodes.windows(2).flat_map(|w| [(w[0], w[1]), (w[1], w[0])]) {
            if let Some(next) = found.get_mut(&a) {
                next.push(b);
            }
        }
    }
    let places =
        |ids: Vec<i64>| to_metres(&ids.into_iter().filter_map(|id| osm.node(id)?.position).collect::<Vec<_>>());
    found.into_iter().map(|(node, next)| (node, places(next))).collect()
}

fn is_footway(tags: &Tags) -> bool {
    let shared = matches!(tags.get("highway"), Some("cycleway")) && tags.get("foot").is_some_and(|v| v != "no");
    shared || matches!(tags.get("highway"), Some("footway" | "path" | "pedestrian" | "steps"))
}

/// Per arm whether the footways separate it from all others.
fn crossed(network: &RoadNetwork, ix: IntersectionIx, on_foot: &[Point]) -> Vec<bool> {
    let intersection = network.intersection(ix);
    let arms = &intersection.arms;
    let outward = |arm: &RoadEnd| {
        let road = network.road(arm.road);
        outward(road, arm.end, LOOK.min(road.line.length() / 2.0))
    };
    let first = arms.first().map_or_else(Vector::x, outward);
    let clockwise = |to: Vector| (-angle_between(first, to)).rem_euclid(std::f64::consts::TAU);
    let mut bearings: Vec<f64> = arms.iter().map(|arm| clockwise(outward(arm))).collect();
    bearings[0] = 0.0;
    // After how many arms each footway lies, clockwise from the first arm.
    let mut gaps: Vec<usize> = on_foot
        .iter()
        .map(|place| clockwise(place - intersection.position))
        .map(|bearing| bearings.iter().filter(|&&arm| arm <= bearing).count() % arms.len())
        .collect();
    gaps.sort_unstable();
    gaps.dedup();
    (0..arms.len())
        .map(|arm| gaps.len() > 1 && gaps.contains(&arm) && gaps.contains(&((arm + 1) % arms.len())))
        .collect()
}
