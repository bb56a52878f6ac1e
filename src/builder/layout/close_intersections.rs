//! Pairs of intersections with little room between them, and whether one intersection in their place is a good one.

use std::hash::{Hash, Hasher};

use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};
use rustc_hash::{FxHashMap, FxHashSet, FxHasher};

use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::road_cut::VEHICLE;
use crate::builder::network::road_end::{is_between_crossings, leads_in, leads_out, other_end};
use crate::builder::network::{End, FeatureKind, IntersectionIx, RoadEnd, RoadIx, RoadKey, RoadNetwork};
use crate::builder::tags::road_class::RoadClass;
use crate::geometry::{Point, polygon};
use crate::lanelet::index::extent;

use super::map_layout::{IntersectionLanelets, Layout};
use super::short_links::CAR_RADIUS;

/// An intersection of which roads without room lie inside is at most this long, metres: beyond, drivers see two.
const LONGEST_MERGED: f64 = 55.0;
/// Between two intersections a map maker leaves at least this much road, metres: a car of 5 m, and a metre before and behind it.
const LEAST_ROOM: f64 = 7.0;
/// A ring of one-way roads that is at most this long, metres, is a roundabout for whoever drives on it: 32 m across.
const SMALL_RING: f64 = 100.0;
/// A lanelet that sways by more than this, degrees, wiggles: less than that is how cars cross where two side streets are staggered.
const MOST_SWAY: f64 = 45.0;

/// The roads between two intersections on which a map maker would draw no stop line, because turns took their room; in order. Of a row
/// of them every other one, the shortest first: else the row would become one intersection. Where driveways and aisles meet, those alone
/// on which no vehicle can wait, and no row. `closed` are the nodes at which such roads were merged before. Roads with a crosswalk stay:
/// it would be lost.
pub fn roads_without_room(layout: &Layout, refused: &FxHashSet<RoadKey>, closed: &FxHashSet<i64>) -> Vec<RoadIx> {
    let network = &layout.network;
    let is_closed = |at: IntersectionIx| network.intersection(at).nodes.iter().any(|node| closed.contains(node));
    let mut without_waiting: FxHashMap<IntersectionIx, usize> = FxHashMap::default();
    let between = |ix: &RoadIx| is_between_crossings(network, network.road(*ix)) && layout.left(*ix) < VEHICLE;
    let all = || RoadIx::all(network.roads.len());
    all()
        .filter(between)
        .flat_map(|ix| [network.road(ix).from, network.road(ix).to])
        .for_each(|at| *without_waiting.entry(at).or_default() += 1);
    let is_minor = |at: IntersectionIx| {
        let mut roads = network.intersection(at).arms.iter().map(|arm| network.road(arm.road));
        roads.any(|road| !road.public || road.class >= RoadClass::Service)
    };
    let has_room = |ix: RoadIx| {
        let ends = [network.road(ix).from, network.road(ix).to];
        match ends.into_iter().any(is_minor) {
            true => {
                layout.left(ix) >= VEHICLE
                    || ends.iter().any(|end| without_waiting.get(end).is_some_and(|count| *count > 1))
            }
            false => layout.left(ix) >= LEAST_ROOM,
        }
    };
    let is_one = |ix: &RoadIx| {
        let road = network.road(*ix);
        let carries_crosswalk = || road.features.iter().any(|it| matches!(it.kind, FeatureKind::Crossing { .. }));
        is_between_crossings(network, road)
            && !has_room(*ix)
            && !refused.contains(&road.key)
            && ![road.from, road.to].into_iter().any(is_closed)
            && !carries_crosswalk()
            && !is_in_small_ring(network, *ix)
    };
    let mut shortest_first: Vec<RoadIx> = all().filter(is_one).collect();
    shortest_first.sort_by_cached_key(|ix| nearness(layout, *ix));
    let mut taken: FxHashSet<IntersectionIx> = FxHashSet::default();
    shortest_first.retain(|ix| {
        let ends = [network.road(*ix).from, network.road(*ix).to];
        let is_free = !ends.iter().any(|end| taken.contains(end));
        if is_free {
            taken.extend(ends);
        }
        is_free
    });
    shortest_first.sort_unstable();
    shortest_first
}

/// What decides which of two such roads comes first: how much of each is left, in centimetres, and then what looks random. Along a street
/// on which as much is left everywhere, ids that grow would make the choice at one end depend on the other end, and a tile of the map
/// does not have that one.
fn nearness(layout: &Layout, ix: RoadIx) -> (i64, u64, RoadKey) {
    let key = layout.network.road(ix).key;
    let mut hasher = FxHasher::default();
    key.hash(&mut hasher);
    ((layout.left(ix) * 100.0).round() as i64, hasher.finish(), key)
}

/// Whether another road leads between the same two intersections: an island, a bus bay or a turning circle lies between.
fn is_around_island(network: &RoadNetwork, of: RoadIx) -> bool {
    let road = network.road(of);
    let leads_there = |arm: &&RoadEnd| network.intersection_at(other_end(**arm)) == road.to;
    network.intersection(road.from).arms.iter().filter(leads_there).count() > 1
}

/// Whether a road is part of a small ring of one-way roads, such as a roundabout without tags: from its one end vehicles come around to the
/// other. Half a ring is no intersection.
fn is_in_small_ring(network: &RoadNetwork, of: RoadIx) -> bool {
    let is_one_way = |arm: RoadEnd| leads_out(network, arm) && !leads_in(network, arm);
    let length = |ix: RoadIx| network.road(ix).line.length();
    let [start, end] = [End::Start, End::End].map(|end| RoadEnd { road: of, end });
    let Some(first) = [start, end].into_iter().find(|arm| is_one_way(*arm)) else { return false };
    let goal = network.intersection_at(first);
    let mut open = vec![(network.intersection_at(other_end(first)), length(of))];
    let mut seen: FxHashSet<IntersectionIx> = FxHashSet::default();
    while let Some((at, driven)) = open.pop() {
        if at == goal {
            return true;
        }
        if seen.insert(at) {
            let onward = network.intersection(at).arms.iter().filter(|arm| is_one_way(**arm));
            let reached = onward.map(|arm| (network.intersection_at(other_end(*arm)), driven + length(arm.road)));
            open.extend(reached.filter(|(_, driven)| *driven <= SMALL_RING));
        }
    }
    false
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

/// The end of a road, whatever the network.
type Place = (RoadKey, End);

/// Two intersections before they become one.
pub struct Pair {
    /// How many of their lanelets wiggle.
    swaying: usize,
    /// From which ends of roads vehicles drive to which, at either of them or over the road between.
    ways: FxHashSet<[Place; 2]>,
    /// Whether another road leads from the one to the other, around an island.
    has_island: bool,
}

impl Pair {
    /// Those at the ends of a road.
    pub fn of(layout: &Layout, road: RoadIx) -> Self {
        let ends = [layout.network.road(road).from, layout.network.road(road).to];
        let swaying = |at: IntersectionIx| layout.turning[at.position()].as_deref().map_or(0, swaying_lanelets);
        let at_each = ends.map(|at| ways_at(layout, at));
        let place = |end: RoadEnd| (layout.network.road(end.road).key, end.end);
        let is_outer = |[from, to]: &[RoadEnd; 2]| from.road != road && to.road != road;
        let mut ways: FxHashSet<[Place; 2]> =
            at_each.iter().flatten().filter(|way| is_outer(way)).map(|way| way.map(place)).collect();
        for [first, second] in [[0, 1], [1, 0]] {
            let into = at_each[first].iter().filter(|[from, to]| from.road != road && to.road == road);
            let out = || at_each[second].iter().filter(|[from, to]| from.road == road && to.road != road);
            ways.extend(into.flat_map(|[from, _]| out().map(move |[_, to]| [place(*from), place(*to)])));
        }
        let has_island = is_around_island(&layout.network, road);
        Self { swaying: ends.into_iter().map(swaying).sum(), ways, has_island }
    }
}

/// From which ends of roads vehicles drive to which at an intersection.
fn ways_at(layout: &Layout, at: IntersectionIx) -> FxHashSet<[RoadEnd; 2]> {
    let arms = &layout.network.intersection(at).arms;
    let paths = layout.turning[at.position()].iter().flat_map(|turning| &turning.drawn.paths);
    paths.map(|path| [arms[path.movement.from], arms[path.movement.to]]).collect()
}

/// Whether an intersection in which a road without room lies is drawn as a map maker would: it is not too large, it leads along the ends of
/// all its roads and around no other one, vehicles drive wherever they did before, and no more lanelets wiggle.
pub fn is_well_merged(layout: &Layout, middles: &RoadMiddles, at: IntersectionIx, before: &Pair) -> bool {
    let Some(turning) = &layout.turning[at.position()] else { return true };
    let place = |end: RoadEnd| (layout.network.road(end.road).key, end.end);
    let ways: FxHashSet<[Place; 2]> = ways_at(layout, at).into_iter().map(|way| way.map(place)).collect();
    // Other roads than the one between may lie inside, too.
    let arms: FxHashSet<Place> = layout.network.intersection(at).arms.iter().map(|&arm| place(arm)).collect();
    let mut kept = before.ways.iter().filter(|way| way.iter().all(|end| arms.contains(end)));
    // An island goes only where a turn had no room before.
    let is_needless = before.has_island && kept.clone().count() == ways.len();
    if is_needless || swaying_lanelets(turning) > before.swaying || !kept.all(|way| ways.contains(way)) {
        return false;
    }
    let Some(area) = &turning.area else { return true };
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
    area.lost.is_empty() && area.overrun.is_empty() && !is_large() && !encloses()
}

/// How many lanelets of an intersection wiggle, or bend too tightly for a car.
fn swaying_lanelets(turning: &IntersectionLanelets) -> usize {
    let is_one = |path: &&TurningLanelet| path.sway > MOST_SWAY || path.radius < CAR_RADIUS;
    turning.drawn.paths.iter().filter(is_one).count()
}
