//! Reads heights of nodes from `ele`, metres.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::frame::ToMetres;
use crate::geometry::Point;
use crate::osm::OsmData;
use crate::parallel::Finely;

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

/// Reads the heights of the nodes of all roads.
pub fn elevation_tags(osm: &OsmData, to_metres: ToMetres<'_>) -> ElevationTags {
    let mut spots = ElevationTags::default();
    if osm.nodes.par_iter().finely().all(|node| !node.tags.has("ele")) {
        return spots;
    }
    for way in osm.ways.iter().filter(|way| way.tags.has("highway")) {
        let known = |id: &i64| {
            let node = osm.node(*id)?;
            let ele = node.tags.get("ele")?.trim().trim_end_matches('m').trim().parse::<f64>().ok()?;
            RANGE.contains(&ele).then_some((*id, node.position?, ele))
        };
        let known: Vec<_> = way.nodes.iter().filter_map(known).collect();
        if known.is_empty() {
            continue;
        }
        let places = to_metres(&known.iter().map(|(_, place, _)| *place).collect::<Vec<_>>());
        let finite = |p: &Point| p.x.is_finite() && p.y.is_finite();
        let projected: Vec<(Point, f64)> =
            places.into_iter().zip(&known).map(|(p, (_, _, ele))| (p, *ele)).filter(|(p, _)| finite(p)).collect();
        spots.of_node.extend(known.iter().map(|(id, _, ele)| (*id, *ele)));
        spots.of_way.insert(way.id, projected);
    }
    spots
}
