//! Reads heights of nodes from `ele`, metres, and finds those between them.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::frame::ToMetres;
use crate::geometry::Point;
use crate::osm::{Node, OsmData, Way};
use crate::parallel::InSmallParts;
use crate::projection::LonLat;

use super::road_heights::road_heights;

/// Heights on earth, metres; beyond, the unit is wrong.
const RANGE: std::ops::RangeInclusive<f64> = -500.0..=9000.0;

/// Known heights, metres.
#[derive(Clone, Debug, Default)]
pub struct ElevationTags {
    /// By node.
    pub of_node: FxHashMap<i64, f64>,
    /// By way, in its order: point in local metres and height.
    pub of_way: BTreeMap<i64, Vec<(Point, f64)>>,
}

impl ElevationTags {
    /// Whether no height is known.
    pub fn is_empty(&self) -> bool {
        self.of_node.is_empty()
    }
}

/// Reads the heights of the nodes of all ways that are roads. If they tell the ground (`is_ground`), those between them are found
/// along the roads.
pub fn elevation_tags(
    osm: &OsmData,
    to_metres: ToMetres<'_>,
    is_road: impl Fn(&Way) -> bool,
    is_ground: bool,
) -> ElevationTags {
    if osm.nodes.par_iter().in_small_parts().all(|node| !node.tags.has("ele")) {
        return ElevationTags::default();
    }
    let written = |id: i64| elevation(osm.node(id)?);
    let roads = || osm.ways.iter().filter(|way| is_road(way));
    let of_node: FxHashMap<i64, f64> = if is_ground {
        let place = |id: i64| osm.node(id)?.position;
        road_heights(roads().map(|way| way.nodes.iter().copied()), place, written)
    } else {
        roads().flat_map(|way| &way.nodes).filter_map(|id| Some((*id, written(*id)?))).collect()
    };
    let mut of_way = BTreeMap::new();
    for way in roads() {
        let known = |id: &i64| Some((osm.node(*id)?.position?, *of_node.get(id)?));
        let (places, heights): (Vec<LonLat>, Vec<f64>) = way.nodes.iter().filter_map(known).unzip();
        let finite = |(place, _): &(Point, f64)| place.x.is_finite() && place.y.is_finite();
        let known: Vec<(Point, f64)> = to_metres(&places).into_iter().zip(heights).filter(finite).collect();
        if !known.is_empty() {
            of_way.insert(way.id, known);
        }
    }
    ElevationTags { of_node, of_way }
}

/// The height that a node's `ele` says, metres.
pub fn elevation(node: &Node) -> Option<f64> {
    let ele = node.tags.get("ele")?.trim().trim_end_matches('m').trim().parse().ok()?;
    RANGE.contains(&ele).then_some(ele)
}
