//! Reads the intersections of a file: their arms, turn restrictions and lane connections.

use rustc_hash::FxHashMap;

use crate::builder::network::{
    End, InnerRoad, Intersection, Island, LaneConnection, Ray, Road, RoadEnd, RoadIx, RoadKey, TurnRestriction,
    clockwise,
};
use crate::geometry::{Point, Polyline, simple_ring as rings};

use super::ReadError;
use super::id::FeatureId;
use super::parse::{Parsed, Spanned};
use super::schema::{ArmShape, Feature, IntersectionShape};
use super::values::{Node, centre, mean, point, ring, section_of};

/// The largest number of arms of an intersection. A file with more is damaged.
const MAX_ARMS: usize = 1000;

/// The intersections of a network of which the roads are read.
///
/// # Errors
///
/// `arms` or `passages` of an intersection do not fit its roads, or it has too many roads.
pub fn intersections(
    nodes: &[Node<'_>],
    roads: &[Road],
    by_id: &FxHashMap<&FeatureId, RoadIx>,
) -> Result<Vec<Intersection>, ReadError> {
    let mut ends: Vec<Vec<RoadEnd>> = vec![Vec::new(); nodes.len()];
    for (road, ix) in roads.iter().zip(0..) {
        for (end, intersection) in [(End::Start, road.from), (End::End, road.to)] {
            ends[intersection.0 as usize].push(RoadEnd { road: RoadIx(ix), end });
        }
    }
    nodes.iter().zip(ends).map(|(node, ends)| intersection(node, ends, roads, by_id)).collect()
}

fn intersection(
    node: &Node<'_>,
    ends: Vec<RoadEnd>,
    roads: &[Road],
    by_id: &FxHashMap<&FeatureId, RoadIx>,
) -> Result<Intersection, ReadError> {
    let last_point = |road_end: &RoadEnd| {
        let line = &roads[road_end.road.0 as usize].line;
        if road_end.end == End::Start { line.first() } else { line.last() }
    };
    let in_file = node.feature.and_then(|feature| centre(&feature.value));
    let position = in_file.or_else(|| mean(&ends.iter().map(last_point).collect::<Vec<_>>())).unwrap_or_default();
    let Some(feature) = node.feature else {
        return Ok(map_edge(node.nodes.clone(), position, ends));
    };
    let shape = &feature.value.properties;
    let arms = arms(feature, ends, position, roads, by_id)?;
    let passages = passages(feature, &arms)?;
    let dead_end = arms.len() < 2;
    Ok(Intersection {
        position,
        map_edge: shape.map_edge.unwrap_or(dead_end && ring(feature.value.geometry.as_ref()).is_empty()),
        signals: shape.signals,
        all_way_stop: shape.all_way_stop,
        circle: shape.circle.clone(),
        inner: inner(feature),
        islands: islands(feature),
        passages,
        ..map_edge(node.nodes.clone(), position, arms)
    })
}

/// The pairs of arms between which traffic passes.
fn passages(
    feature: &Spanned<Feature<IntersectionShape>>,
    arms: &[RoadEnd],
) -> Result<Option<Vec<(RoadEnd, RoadEnd)>>, ReadError> {
    let shape = &feature.value.properties;
    let passage = |&[from, to]: &[usize; 2]| {
        arms.get(from).copied().zip(arms.get(to).copied()).ok_or_else(|| {
            let message =
                format!("a passage of intersection {} is [{from}, {to}], but it has {} arms", shape.id.0, arms.len());
            ReadError::new(feature.offset, message, "passages are pairs of indices into `arms`, from 0")
        })
    };
    shape.passages.as_ref().map(|list| list.iter().map(passage).collect()).transpose()
}

/// An intersection that the file does not describe: the map ends there.
fn map_edge(nodes: Vec<i64>, position: Point, arms: Vec<RoadEnd>) -> Intersection {
    Intersection { map_edge: true, ..Intersection::of_arms(nodes, position, arms) }
}

/// The arms clockwise: in the order of the file, which must list all; else sorted by the directions in which they leave.
fn arms(
    feature: &Spanned<Feature<IntersectionShape>>,
    ends: Vec<RoadEnd>,
    position: Point,
    roads: &[Road],
    by_id: &FxHashMap<&FeatureId, RoadIx>,
) -> Result<Vec<RoadEnd>, ReadError> {
    let shape = &feature.value.properties;
    if ends.len() > MAX_ARMS {
        let message = format!("{} roads end at intersection {}", ends.len(), shape.id.0);
        return Err(ReadError::new(feature.offset, message, "give each intersection an id of its own"));
    }
    if shape.arms.is_empty() {
        let rays: Vec<Ray<(RoadKey, End)>> = ends
            .iter()
            .map(|&RoadEnd { road, end }| {
                let road = &roads[road.0 as usize];
                let line = if end == End::Start { road.line.clone() } else { road.line.reversed() };
                // A line may end at the outline: it is continued to the middle of the intersection.
                let from_middle = Polyline::new(std::iter::once(position).chain(line.points().iter().copied()));
                Ray { line: from_middle.unwrap_or(line), key: (road.key, end) }
            })
            .collect();
        return Ok(clockwise(position, &rays).into_iter().map(|i| ends[i]).collect());
    }
    let listed: Vec<RoadEnd> = shape.arms.iter().filter_map(|arm| arm_of(arm, by_id)).collect();
    let (mut a, mut b) = (listed.clone(), ends);
    a.sort();
    b.sort();
    if a != b {
        let message =
            format!("the arms of intersection {} are not the {} road ends that lie at it", shape.id.0, b.len());
        let help = "list each end of each road once, clockwise, or leave `arms` out";
        return Err(ReadError::new(feature.offset, message, help));
    }
    Ok(listed)
}

fn arm_of(arm: &ArmShape, by_id: &FxHashMap<&FeatureId, RoadIx>) -> Option<RoadEnd> {
    Some(RoadEnd { road: *by_id.get(&arm.road)?, end: arm.end })
}

/// The islands. Rings that are not simple are left out: no area can be cut out along them.
fn islands(feature: &Spanned<Feature<IntersectionShape>>) -> Vec<Island> {
    let islands = feature.value.properties.islands.iter().map(|island| {
        let ring: Vec<Point> = island.ring.iter().map(point).collect();
        Island { way: island.osm_id, ring }
    });
    islands.filter(|island| rings::is_simple(&island.ring)).collect()
}

fn inner(feature: &Spanned<Feature<IntersectionShape>>) -> Vec<InnerRoad> {
    let inner = feature.value.properties.inner.iter().filter_map(|inner| {
        Some(InnerRoad {
            key: inner.key.into(),
            ways: inner.osm_ids.clone(),
            line: Polyline::new(inner.centerline.iter().map(point))?,
            section: section_of(&inner.lanes),
            roundabout: inner.roundabout,
        })
    });
    inner.collect()
}

/// All lane connections, sorted.
///
/// # Errors
///
/// A connection names a road that is not in the file.
pub fn connections(parsed: &Parsed, by_id: &FxHashMap<&FeatureId, RoadIx>) -> Result<Vec<LaneConnection>, ReadError> {
    let mut found = Vec::new();
    for feature in &parsed.intersections {
        for shape in &feature.value.properties.connections {
            let (Some(from), Some(to)) = (arm_of(&shape.from, by_id), arm_of(&shape.to, by_id)) else {
                let id = &feature.value.properties.id.0;
                let message =
                    format!("a connection of lanes at intersection {id} names a road that is not in the file");
                return Err(ReadError::new(feature.offset, message, "add the road, or leave the connection out"));
            };
            found.push(LaneConnection { relation: shape.relation, from, to, lanes: shape.lanes.clone() });
        }
    }
    found.sort_unstable();
    Ok(found)
}

/// All turn restrictions, sorted.
///
/// # Errors
///
/// A restriction names a road that is not in the file.
pub fn restrictions(parsed: &Parsed, by_id: &FxHashMap<&FeatureId, RoadIx>) -> Result<Vec<TurnRestriction>, ReadError> {
    let mut found = Vec::new();
    for feature in &parsed.intersections {
        for shape in &feature.value.properties.restrictions {
            let via: Option<Vec<RoadIx>> = shape.via.iter().map(|via| by_id.get(via).copied()).collect();
            let ends = (arm_of(&shape.from, by_id), arm_of(&shape.to, by_id), via);
            let (Some(from), Some(to), Some(via)) = ends else {
                let id = &feature.value.properties.id.0;
                let message = format!("a turn restriction of intersection {id} names a road that is not in the file");
                return Err(ReadError::new(feature.offset, message, "add the road, or leave the restriction out"));
            };
            found.push(TurnRestriction { relation: shape.relation, from, via, to, only: shape.only });
        }
    }
    found.sort_unstable();
    Ok(found)
}
