//! Where the roads of a file meet: intersections, their arms, and the turns between them.

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

/// Roads that one intersection joins at most; more are damage.
const MAX_ARMS: usize = 1000;

/// The intersections of a network whose roads are known.
pub fn intersections(
    nodes: &[Node<'_>],
    roads: &[Road],
    by_id: &FxHashMap<&FeatureId, RoadIx>,
) -> Result<Vec<Intersection>, ReadError> {
    let mut meeting: Vec<Vec<RoadEnd>> = vec![Vec::new(); nodes.len()];
    for (road, ix) in roads.iter().zip(0..) {
        for (end, at) in [(End::Start, road.from), (End::End, road.to)] {
            meeting[at.0 as usize].push(RoadEnd { road: RoadIx(ix), end });
        }
    }
    nodes.iter().zip(meeting).map(|(node, ends)| intersection(node, ends, roads, by_id)).collect()
}

fn intersection(
    node: &Node<'_>,
    ends: Vec<RoadEnd>,
    roads: &[Road],
    by_id: &FxHashMap<&FeatureId, RoadIx>,
) -> Result<Intersection, ReadError> {
    let tip = |at: &RoadEnd| {
        let line = &roads[at.road.0 as usize].line;
        if at.end == End::Start { line.first() } else { line.last() }
    };
    let tips: Vec<Point> = ends.iter().map(tip).collect();
    let own = node.feature.and_then(|feature| centre(&feature.it));
    let position = own.or_else(|| mean(&tips)).unwrap_or_else(Point::origin);
    let Some(feature) = node.feature else {
        return Ok(bare(node.nodes.clone(), position, ends));
    };
    let shape = &feature.it.properties;
    let named = |ends: Vec<RoadEnd>| arms(feature, ends, position, roads, by_id);
    let arms = named(ends)?;
    let passage = |[from, to]: [usize; 2]| {
        let both = arms.get(from).zip(arms.get(to)).map(|(from, to)| (*from, *to));
        both.ok_or_else(|| {
            let message =
                format!("a passage of intersection {} is [{from}, {to}], but it has {} arms", shape.id.0, arms.len());
            ReadError::new(feature.offset, message, "passages are pairs of indices into `arms`, from 0")
        })
    };
    let passages = shape.passages.as_ref().map(|list| list.iter().copied().map(passage).collect()).transpose()?;
    let dead_end = arms.len() < 2;
    Ok(Intersection {
        position,
        map_edge: shape.map_edge.unwrap_or(dead_end && ring(feature.it.geometry.as_ref()).is_empty()),
        signals: shape.signals,
        all_way_stop: shape.all_way_stop,
        circle: shape.circle.clone(),
        inner: inner(feature),
        islands: islands(feature),
        passages,
        ..bare(node.nodes.clone(), position, arms)
    })
}

/// An intersection of which nothing is known but its roads: the map ends there.
fn bare(nodes: Vec<i64>, position: Point, arms: Vec<RoadEnd>) -> Intersection {
    Intersection {
        nodes,
        position,
        arms,
        map_edge: true,
        signals: false,
        all_way_stop: false,
        circle: None,
        inner: Vec::new(),
        passages: None,
        islands: Vec::new(),
    }
}

/// The arms in clockwise order: as the file says, which must be all; else by the directions in which they leave.
fn arms(
    feature: &Spanned<Feature<IntersectionShape>>,
    ends: Vec<RoadEnd>,
    position: Point,
    roads: &[Road],
    by_id: &FxHashMap<&FeatureId, RoadIx>,
) -> Result<Vec<RoadEnd>, ReadError> {
    let shape = &feature.it.properties;
    if ends.len() > MAX_ARMS {
        let message = format!("{} roads end at intersection {}", ends.len(), shape.id.0);
        return Err(ReadError::new(feature.offset, message, "give each intersection an id of its own"));
    }
    if shape.arms.is_empty() {
        let rays: Vec<Ray<(RoadKey, End)>> = ends
            .iter()
            .map(|at| {
                let road = &roads[at.road.0 as usize];
                let line = if at.end == End::Start { road.line.clone() } else { road.line.reversed() };
                // Lines that end at the outline are seen from its middle.
                let from_middle = Polyline::new(std::iter::once(position).chain(line.points().iter().copied()));
                Ray { line: from_middle.unwrap_or(line), key: (road.key, at.end) }
            })
            .collect();
        return Ok(clockwise(position, &rays).into_iter().map(|i| ends[i]).collect());
    }
    let said: Vec<RoadEnd> = shape.arms.iter().filter_map(|arm| arm_of(arm, by_id)).collect();
    let (mut a, mut b) = (said.clone(), ends);
    a.sort();
    b.sort();
    if a != b {
        let message =
            format!("the arms of intersection {} are not the {} road ends that lie at it", shape.id.0, b.len());
        return Err(ReadError::new(
            feature.offset,
            message,
            "list each end of each road once, clockwise, or leave `arms` out",
        ));
    }
    Ok(said)
}

fn arm_of(arm: &ArmShape, by_id: &FxHashMap<&FeatureId, RoadIx>) -> Option<RoadEnd> {
    Some(RoadEnd { road: *by_id.get(&arm.road)?, end: arm.end })
}

/// The islands whose rings are simple; nothing can be cut out along others.
fn islands(feature: &Spanned<Feature<IntersectionShape>>) -> Vec<Island> {
    let islands = feature.it.properties.islands.iter().map(|island| {
        let ring: Vec<Point> = island.ring.iter().map(point).collect();
        Island { way: island.osm_id, ring }
    });
    islands.filter(|island| rings::is_simple(&island.ring)).collect()
}

fn inner(feature: &Spanned<Feature<IntersectionShape>>) -> Vec<InnerRoad> {
    let inner = feature.it.properties.inner.iter().filter_map(|inner| {
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

/// All connections of lanes, by relation as in the input they came from.
pub fn connections(parsed: &Parsed, by_id: &FxHashMap<&FeatureId, RoadIx>) -> Result<Vec<LaneConnection>, ReadError> {
    let mut found = Vec::new();
    for feature in &parsed.intersections {
        for shape in &feature.it.properties.connections {
            let (Some(from), Some(to)) = (arm_of(&shape.from, by_id), arm_of(&shape.to, by_id)) else {
                let id = &feature.it.properties.id.0;
                let message =
                    format!("a connection of lanes at intersection {id} names a road that is not in the file");
                return Err(ReadError::new(feature.offset, message, "add the road, or leave the connection out"));
            };
            found.push(LaneConnection { relation: shape.relation, from, to, lanes: shape.lanes.clone() });
        }
    }
    found.sort_by_key(|connection: &LaneConnection| (connection.relation, connection.from, connection.to));
    Ok(found)
}

/// All turn restrictions, by relation as in the input they came from.
pub fn restrictions(parsed: &Parsed, by_id: &FxHashMap<&FeatureId, RoadIx>) -> Result<Vec<TurnRestriction>, ReadError> {
    let mut found = Vec::new();
    for feature in &parsed.intersections {
        for shape in &feature.it.properties.restrictions {
            let via: Option<Vec<RoadIx>> = shape.via.iter().map(|via| by_id.get(via).copied()).collect();
            let ends = (arm_of(&shape.from, by_id), arm_of(&shape.to, by_id), via);
            let (Some(from), Some(to), Some(via)) = ends else {
                let id = &feature.it.properties.id.0;
                let message = format!("a turn restriction of intersection {id} names a road that is not in the file");
                return Err(ReadError::new(feature.offset, message, "add the road, or leave the restriction out"));
            };
            found.push(TurnRestriction { relation: shape.relation, from, via, to, only: shape.only });
        }
    }
    found.sort_by(|a, b| (a.relation, a.from, &a.via, a.to).cmp(&(b.relation, b.from, &b.via, b.to)));
    Ok(found)
}
