//! Pairs of intersections between which no vehicle can wait, and whether one intersection in their place is a good one.

use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::road_cut::VEHICLE;
use crate::builder::network::road_end::is_between_crossings;
use crate::builder::network::{IntersectionIx, RoadIx, RoadKey, RoadNetwork};
use crate::geometry::{Point, polygon};
use crate::lanelet::index::extent;

use super::map_layout::{IntersectionLanelets, Layout};
use super::short_links::CAR_RADIUS;

/// An intersection of which roads without room lie inside is at most this long, metres: beyond, drivers see two.
const LONGEST_MERGED: f64 = 55.0;
/// A lanelet that sways by more than this, degrees, wiggles.
const MOST_SWAY: f64 = 30.0;

/// The roads between two intersections on which no vehicle can wait, because turns took its room; in order. Of a row of intersections
/// there are none: it would become one, and so would what lies behind. `closed` are the nodes at which such roads were merged before.
pub fn roads_without_room(layout: &Layout, refused: &FxHashSet<RoadKey>, closed: &FxHashSet<i64>) -> Vec<RoadIx> {
    let network = &layout.network;
    let is_one = |ix: &RoadIx| is_between_crossings(network, network.road(*ix)) && layout.left(*ix) < VEHICLE;
    let all: Vec<RoadIx> = RoadIx::all(network.roads.len()).filter(is_one).collect();
    let ends = |ix: RoadIx| [network.road(ix).from, network.road(ix).to];
    let mut counts: FxHashMap<IntersectionIx, usize> = FxHashMap::default();
    all.iter().flat_map(|&ix| ends(ix)).for_each(|at| *counts.entry(at).or_default() += 1);
    let is_alone = |at: IntersectionIx| {
        counts[&at] == 1 && !network.intersection(at).nodes.iter().any(|node| closed.contains(node))
    };
    let pairs = all.iter().copied().filter(|&ix| ends(ix).into_iter().all(is_alone));
    pairs.filter(|ix| !refused.contains(&network.road(*ix).key)).collect()
}

/// The middles of all roads, by place.
pub struct RoadMiddles(RTree<GeomWithData<[f64; 2], RoadIx>>);

impl RoadMiddles {
    /// Those of a network.
    pub fn of(network: &RoadNetwork) -> Self {
        let middle = |ix: RoadIx| {
            let line = &network.road(ix).line;
            let place = line.at(line.length() / 2.0);
            GeomWithData::new([place.x, place.y], ix)
        };
        Self(RTree::bulk_load(RoadIx::all(network.roads.len()).map(middle).collect()))
    }
}

/// Whether an intersection in which roads without room lie is drawn as a map maker would: it is not too large, it leads along the ends of
/// all its roads and around no other one, and no more lanelets wiggle than before.
pub fn is_well_merged(layout: &Layout, middles: &RoadMiddles, at: IntersectionIx, swaying_before: usize) -> bool {
    let Some(turning) = &layout.turning[at.position()] else { return true };
    let Some(area) = &turning.area else { return swaying_lanelets(turning) <= swaying_before };
    let is_large = || area.places.iter().any(|a| area.places.iter().any(|b| (a - b).norm() > LONGEST_MERGED));
    let arms = &layout.network.intersection(at).arms;
    let [low, high] = extent(&area.places).map(|corner| [corner.x, corner.y]);
    let encloses = || {
        let mut near = middles.0.locate_in_envelope(&AABB::from_corners(low, high));
        near.any(|middle| {
            let [x, y] = *middle.geom();
            !arms.iter().any(|arm| arm.road == middle.data) && polygon::contains(&area.places, Point::new(x, y))
        })
    };
    area.lost.is_empty()
        && area.overrun.is_empty()
        && swaying_lanelets(turning) <= swaying_before
        && !is_large()
        && !encloses()
}

/// How many lanelets of an intersection wiggle, or bend too tightly for a car.
pub fn swaying_lanelets(turning: &IntersectionLanelets) -> usize {
    let is_one = |path: &&TurningLanelet| path.sway > MOST_SWAY || path.radius < CAR_RADIUS;
    turning.drawn.paths.iter().filter(is_one).count()
}
