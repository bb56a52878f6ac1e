//! Which road a crossing on the very node of a junction crosses: the one that the ways on foot run past.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, Vector, angle_between};
use crate::osm::{OsmData, Tags};

use super::frame::ToMetres;
use super::{End, Feature, FeatureKind, IntersectionIx, RoadEnd, RoadNetwork};

/// Directions are taken this far, metres, from the junction.
const LOOK: f64 = 4.0;

/// Keeps each crossing on the node of a junction at the roads that it crosses, and notes those of which this is not
/// known: the ways on foot around the node say it. They lie between the roads, and part them: a road that lies alone
/// between two of them is crossed.
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
        .filter(|(i, _)| i.arms.len() > 2 && i.arms.iter().any(|&at| crossing_at(network, at, i.nodes[0]).is_some()))
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
        for at in arms.into_iter().zip(crossed).filter_map(|(at, crossed)| (!crossed).then_some(at)) {
            if let Some(feature) = crossing_at(network, at, node) {
                network.roads[at.road].features.remove(feature);
            }
        }
    }
}

/// The feature at this end of a road that is a crossing on the junction's own node.
fn crossing_at(network: &RoadNetwork, at: RoadEnd, node: i64) -> Option<usize> {
    let road = network.road(at.road);
    let station = if at.end == End::Start { 0.0 } else { road.line.length() };
    let here = |f: &Feature| f.node == node && f.station == station && matches!(f.kind, FeatureKind::Crossing { .. });
    road.features.iter().position(here)
}

/// The places next to each junction's node on ways for people on foot.
fn on_foot(osm: &OsmData, to_metres: ToMetres<'_>, junctions: &[(i64, IntersectionIx)]) -> FxHashMap<i64, Vec<Point>> {
    let mut found: FxHashMap<i64, Vec<i64>> = junctions.iter().map(|(node, _)| (*node, Vec::new())).collect();
    for way in osm.ways.iter().filter(|way| for_feet(&way.tags)) {
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

fn for_feet(tags: &Tags) -> bool {
    let shared = matches!(tags.get("highway"), Some("cycleway")) && tags.get("foot").is_some_and(|v| v != "no");
    shared || matches!(tags.get("highway"), Some("footway" | "path" | "pedestrian" | "steps"))
}

/// Per arm whether the ways on foot part it from every other.
fn crossed(network: &RoadNetwork, ix: IntersectionIx, on_foot: &[Point]) -> Vec<bool> {
    let intersection = network.intersection(ix);
    let arms = &intersection.arms;
    let out = |at: &RoadEnd| {
        let line = &network.road(at.road).line;
        let (length, look) = (line.length(), LOOK.min(line.length() / 2.0));
        if at.end == End::Start { line.at(look) - line.first() } else { line.at(length - look) - line.last() }
    };
    let first = arms.first().map_or_else(Vector::x, out);
    let clockwise = |to: Vector| (-angle_between(first, to)).rem_euclid(std::f64::consts::TAU);
    let mut bearings: Vec<f64> = arms.iter().map(|at| clockwise(out(at))).collect();
    bearings[0] = 0.0;
    // Behind how many arms each way on foot lies, clockwise from the first.
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
