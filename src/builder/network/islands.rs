//! Traffic islands and planted medians that OpenStreetMap maps as areas, assigned to the intersections nearby.
//!
//! These count: `area:highway=traffic_island`, `traffic_calming=island` (an area between carriageways, by OpenStreetMap's
//! wiki), `highway=traffic_island`, closed `barrier=kerb` lines and small planted areas, as closed ways or multipolygons.
//! Whether traffic avoids an island is decided when the lanelets through the intersection are drawn.

use std::collections::BTreeMap;

use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::geometry::{Point, Polyline, Vector, polygon, simple_ring};
use crate::osm::{ElementKind, OsmData, Relation, Tags, Way};
use crate::projection::LonLat;

use super::frame::{ToMetres, level};
use super::{Intersection, Road};

/// An area that no vehicle drives on.
#[derive(Clone, Debug, PartialEq)]
pub struct Island {
    /// Id of the OpenStreetMap way that runs around it.
    pub way: i64,
    /// Simple, not closed, local metres.
    pub ring: Vec<Point>,
}

/// How far an island may lie from the node of an intersection whose outline it reaches into, metres: outlines end at stop
/// lines, before the crossings.
const ISLAND_FROM_NODE: f64 = 40.0;
/// A smaller area, square metres, is a post.
const LEAST: f64 = 0.5;
/// A larger area, square metres, is a park or a block; its edge is not a kerb of the intersection.
const MOST: f64 = 5_000.0;

/// Assigns to every intersection the islands near it on one of its levels.
pub(super) fn assign(osm: &OsmData, to_metres: ToMetres<'_>, roads: &[Road], intersections: &mut [Intersection]) {
    let islands = islands(osm, to_metres);
    let boxes: Vec<Bounds> = islands.iter().filter_map(|(island, _)| polygon::bounds(&island.ring)).collect();
    if boxes.is_empty() {
        return;
    }
    let cells = SpatialHash::new(boxes, ISLAND_FROM_NODE);
    for intersection in intersections.iter_mut().filter(|i| i.arms.len() > 1) {
        let (position, around) = (intersection.position, Vector::repeat(ISLAND_FROM_NODE));
        let levels: Vec<f64> = intersection.arms.iter().map(|arm| roads[arm.road].level).collect();
        let mut near = Vec::new();
        cells.touching([position - around, position + around], |i| near.push(i));
        near.sort_unstable();
        near.dedup();
        let here = near.into_iter().map(|i| &islands[i]);
        let here =
            here.filter(|(island, level)| levels.contains(level) && distance(island, position) <= ISLAND_FROM_NODE);
        intersection.islands = here.map(|(island, _)| island.clone()).collect();
    }
}

fn distance(island: &Island, position: Point) -> f64 {
    let rim = Polyline::new(island.ring.iter().chain(island.ring.first()).copied());
    rim.map_or(f64::INFINITY, |rim| rim.distance(position))
}

/// All islands with their levels, in order of their ways.
fn islands(osm: &OsmData, to_metres: ToMetres<'_>) -> Vec<(Island, f64)> {
    let mut found: BTreeMap<i64, f64> = BTreeMap::new();
    let of_ways = osm.ways.iter().filter(|way| is_island(&way.tags));
    found.extend(of_ways.map(|way| (way.id, level(&way.tags))));
    for relation in osm.relations.iter().filter(|r| r.tags.is("type", "multipolygon") && is_island(&r.tags)) {
        found.extend(outer(relation).map(|way| (way, level(&relation.tags))));
    }
    let ring = |id: i64| closed(osm, osm.way(id)?);
    let rings: Vec<(i64, f64, Vec<LonLat>)> =
        found.into_iter().filter_map(|(id, level)| Some((id, level, ring(id)?))).collect();
    let places: Vec<LonLat> = rings.iter().flat_map(|(_, _, places)| places.iter().copied()).collect();
    let mut points = to_metres(&places).into_iter();
    let projected = rings.into_iter().map(|(way, level, places)| {
        let ring: Vec<Point> = points.by_ref().take(places.len()).collect();
        (Island { way, ring }, level)
    });
    let is_valid = |(island, _): &(Island, f64)| {
        let finite = island.ring.iter().all(|p| p.x.is_finite() && p.y.is_finite());
        finite
            && (LEAST..=MOST).contains(&polygon::signed_area(&island.ring).abs())
            && simple_ring::is_simple(&island.ring)
    };
    projected.filter(is_valid).collect()
}

fn is_island(tags: &Tags) -> bool {
    if tags.has("highway") {
        return tags.is("highway", "traffic_island");
    }
    let planted = [
        ("landuse", &["grass", "flowerbed"][..]),
        ("landcover", &["grass", "flowerbed"][..]),
        ("natural", &["shrubbery", "scrub", "grassland"][..]),
        ("area:highway", &["traffic_island"][..]),
        ("traffic_calming", &["island"][..]),
        ("barrier", &["kerb"][..]),
    ];
    planted.iter().any(|(key, values)| tags.get(key).is_some_and(|value| values.contains(&value)))
}

/// The outer ways of a multipolygon.
fn outer(relation: &Relation) -> impl Iterator<Item = i64> + '_ {
    let outer = relation.members.iter().filter(|m| m.kind == ElementKind::Way && m.role != "inner");
    outer.map(|member| member.id)
}

/// The corners of a closed way without missing nodes.
fn closed(osm: &OsmData, way: &Way) -> Option<Vec<LonLat>> {
    let (last, corners) = way.nodes.split_last()?;
    if corners.len() < 3 || corners.first() != Some(last) {
        return None;
    }
    let mut places: Vec<LonLat> = corners.iter().map(|id| osm.node(*id)?.position).collect::<Option<_>>()?;
    places.dedup();
    Some(places)
}
