//! Lanes are connected as the streets of OpenStreetMap are.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::Hash;

use lanewright::builder::{BuildOptions, Built, build};
use lanewright::lanelet::{Bound, Lanelet, LaneletMap, PointId};
use lanewright::osm::{OsmData, Way, read_file};
use lanewright::projection::LonLat;

use super::extracts::{DRIVABLE, SLICE};
use crate::common::extracts;

/// One step along a street, from node to node as traffic runs.
type Step = (i64, i64);

/// Connected components (union-find).
struct Parts<T> {
    numbers: HashMap<T, usize>,
    above: Vec<usize>,
}

impl<T: Copy + Eq + Hash> Parts<T> {
    fn new(things: impl IntoIterator<Item = T>) -> Self {
        let numbers: HashMap<T, usize> = things.into_iter().zip(0..).collect();
        let above = (0..numbers.len()).collect();
        Self { numbers, above }
    }

    fn top(&self, mut at: usize) -> usize {
        while self.above[at] != at {
            at = self.above[at];
        }
        at
    }

    fn of(&self, thing: T) -> Option<usize> {
        self.numbers.get(&thing).map(|&at| self.top(at))
    }

    fn join(&mut self, a: T, b: T) {
        if let (Some(a), Some(b)) = (self.of(a), self.of(b)) {
            self.above[a] = b;
        }
    }
}

/// The steps of a way that cars drive on, each as its one-way tags let it.
fn steps(way: &Way) -> Vec<Step> {
    let highway = way.tags.get("highway").unwrap_or_default();
    let class = highway.trim_end_matches("_link");
    if !DRIVABLE.contains(&class) {
        return Vec::new();
    }
    let round = matches!(way.tags.get("junction"), Some("roundabout" | "circular"));
    let [forward, backward] = match way.tags.get("oneway") {
        Some("-1" | "reverse") => [false, true],
        Some("yes" | "true" | "1") => [true, false],
        Some("no" | "reversible" | "alternating") => [true, true],
        _ if round || class == "motorway" => [true, false],
        _ => [true, true],
    };
    let pairs = || way.nodes.windows(2).map(|pair| (pair[0], pair[1]));
    let there = pairs().filter(|_| forward);
    there.chain(pairs().map(|(a, b)| (b, a)).filter(|_| backward)).collect()
}

/// Beyond this change of direction, degrees, one turns back, which nobody does who could go on.
const BACK: f64 = 150.0;

/// Whether one step leads back beside another, or over it.
fn turns_back(osm: &OsmData, [from, at, to]: [i64; 3]) -> bool {
    let places = [from, at, to].map(|id| osm.node(id).and_then(|node| node.position));
    let [Some(from), Some(at), Some(to)] = places else { return false };
    let step = |a: LonLat, b: LonLat| ((b.lon - a.lon) * at.lat.to_radians().cos(), b.lat - a.lat);
    let ((ax, ay), (bx, by)) = (step(from, at), step(at, to));
    (ax * by - ay * bx).atan2(ax * bx + ay * by).abs() > BACK.to_radians()
}

/// Whether nobody passes a node: a gate that is locked.
fn is_locked(osm: &OsmData, node: i64) -> bool {
    osm.node(node).is_some_and(|node| node.tags.has("barrier") && node.tags.is("locked", "yes"))
}

/// The connected components of the streets, without turning back.
fn streets(osm: &OsmData) -> Parts<Step> {
    let all: BTreeSet<Step> = osm.ways.iter().flat_map(steps).collect();
    let mut parts = Parts::new(all.iter().copied());
    for &(from, to) in &all {
        for &next in all.range((to, i64::MIN)..=(to, i64::MAX)) {
            if !turns_back(osm, [from, to, next.1]) && !is_locked(osm, to) {
                parts.join((from, to), next);
            }
        }
    }
    parts
}

/// The nodes between which a lane begins and ends.
fn ends(map: &LaneletMap, lane: &Lanelet) -> Option<[[PointId; 2]; 2]> {
    let ends = |bound: Bound| {
        let mut ids = map.bound_points(bound).map(|point| point.id);
        Some([ids.next()?, ids.next_back()?])
    };
    let (left, right) = (ends(lane.left)?, ends(lane.right)?);
    Some([[left[0], right[0]], [left[1], right[1]]])
}

/// The connected components of the lanes for cars, bus lanes included: cars cross them where they turn.
fn lanes(map: &LaneletMap) -> Parts<i64> {
    let driven = |lane: &&Lanelet| ["road", "bus_lane"].iter().any(|kind| lane.attributes.is("subtype", kind));
    let all: Vec<&Lanelet> = map.lanelets.iter().filter(driven).collect();
    let mut parts = Parts::new(all.iter().map(|lane| lane.id.0));
    let mut beginning: BTreeMap<[PointId; 2], Vec<i64>> = BTreeMap::new();
    let mut left_of: BTreeMap<(i64, bool), Vec<i64>> = BTreeMap::new();
    for lane in &all {
        beginning.entry(ends(map, lane).unwrap()[0]).or_default().push(lane.id.0);
        left_of.entry((lane.left.line.0, lane.left.inverted)).or_default().push(lane.id.0);
    }
    for lane in &all {
        let followers = beginning.get(&ends(map, lane).unwrap()[1]);
        let neighbours = left_of.get(&(lane.right.line.0, lane.right.inverted));
        followers.into_iter().chain(neighbours).flatten().for_each(|&other| parts.join(lane.id.0, other));
    }
    parts
}

/// The parts of the streets that a lane of a road may belong to: those of its way in its direction.
fn part_of(osm: &OsmData, built: &Built, streets: &Parts<Step>, lane: &Lanelet) -> BTreeSet<usize> {
    let road = lane.attributes.get("road_id").unwrap_or_default();
    let mut names = road.split(':');
    let Some(way) = names.next().and_then(|way| osm.way(way.parse().ok()?)) else { return BTreeSet::new() };
    let nodes = names.next().and_then(|nodes| nodes.rsplit_once('-')).unwrap_or_default();
    let at = |node: &str| way.nodes.iter().position(|id| id.to_string() == node);
    let place = |node: &str| {
        let position = osm.node(node.parse().ok()?)?.position?;
        built.projector.forward(position, 0.0)
    };
    let order = at(nodes.0).zip(at(nodes.1)).filter(|(first, last)| first != last);
    let along = order.zip(place(nodes.0)).zip(ends(&built.map, lane)).and_then(|((order, first), [from, to])| {
        let off = |id: PointId| Some((built.map.points.get(id)?.position - first).norm());
        Some((off(from[0])? < off(to[0])?) == (order.0 < order.1))
    });
    let drawn = |(a, b): &Step| {
        let ahead = way.nodes.windows(2).any(|pair| pair == [*a, *b]);
        along.is_none_or(|along| along == ahead)
    };
    steps(way).into_iter().filter(drawn).filter_map(|step| streets.of(step)).collect()
}

#[test]
fn lanes_are_connected_where_streets_are() {
    let mut loose = Vec::new();
    for input in extracts(SLICE) {
        let osm = read_file(&input).unwrap();
        let built = build(&osm, &BuildOptions::default()).unwrap();
        let (streets, lanes) = (streets(&osm), lanes(&built.map));
        let mut parts: BTreeMap<usize, Vec<&Lanelet>> = BTreeMap::new();
        for lane in &built.map.lanelets {
            if let Some(part) = lanes.of(lane.id.0) {
                parts.entry(part).or_default().push(lane);
            }
        }
        let mut parts: Vec<Vec<&Lanelet>> = parts.into_values().collect();
        parts.sort_by_key(|part| std::cmp::Reverse(part.len()));
        let Some((largest, others)) = parts.split_first() else { continue };
        let mut count: BTreeMap<usize, usize> = BTreeMap::new();
        for part in largest.iter().flat_map(|lane| part_of(&osm, &built, &streets, lane)) {
            *count.entry(part).or_default() += 1;
        }
        let main = count.iter().max_by_key(|(_, count)| **count).map(|(part, _)| *part);
        for other in others {
            let of_roads = other.iter().filter(|lane| lane.attributes.has("road_id"));
            let joined: Vec<&&Lanelet> = of_roads
                .filter(|lane| {
                    let parts = part_of(&osm, &built, &streets, lane);
                    parts.iter().all(|part| Some(*part) == main)
                })
                .collect();
            if let Some(lane) = joined.first() {
                let road = lane.attributes.get("road_id").unwrap_or_default();
                loose.push(format!("{}: {} lanes, among them {} of {road}", input.display(), other.len(), lane.id));
            }
        }
    }
    assert!(loose.is_empty(), "{}", loose.join("\n"));
}
