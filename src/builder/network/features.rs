//! Reads crossings, lights and signs from the tags of nodes, and places them on the roads.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::tags::cross_section::Travel;
use crate::geometry::{Point, Polyline};
use crate::osm::{OsmData, Tags};

use super::way_pieces::WayPiece;
use super::{Feature, FeatureKind, Road};

/// How far along the line a node may lie from the station that its share of the way's length gives, metres: an offset line
/// grows and shrinks in bends.
const WINDOW: f64 = 10.0;

/// Looks up the features at a node.
pub(super) struct NodeFeatures<'a> {
    osm: &'a OsmData,
    crossing_ways: FxHashMap<i64, Crossing>,
    /// The nodes of sidewalks with ways of their own.
    sidewalks: FxHashSet<i64>,
}

#[derive(Clone, Copy)]
struct Crossing {
    signals: bool,
    marked: bool,
}

impl<'a> NodeFeatures<'a> {
    /// Collects the crossings and sidewalks that are mapped as ways: their nodes may have no tags.
    pub fn new(osm: &'a OsmData) -> Self {
        let mut crossing_ways = FxHashMap::default();
        let mut sidewalks = FxHashSet::default();
        for way in &osm.ways {
            let crosses = ["footway", "path", "cycleway"].iter().any(|key| way.tags.is(key, "crossing"));
            if let (true, Some(crossing)) = (crosses, crossing(&way.tags)) {
                crossing_ways.extend(way.nodes.iter().map(|id| (*id, crossing)));
            }
            if way.tags.is("footway", "sidewalk") {
                sidewalks.extend(&way.nodes);
            }
        }
        Self { osm, crossing_ways, sidewalks }
    }

    /// The features at a node.
    pub fn at(&self, id: i64) -> Vec<FeatureKind> {
        let mut kinds = Vec::new();
        let tags = self.osm.node(id).map(|node| &node.tags);
        let highway = tags.and_then(|tags| tags.get("highway"));
        let crossing_tagged = tags.is_some_and(|tags| tags.has("crossing") || tags.has("crossing:markings"));
        let crossing = match tags {
            Some(tags) if highway == Some("crossing") || crossing_tagged => crossing(tags),
            _ => self.crossing_ways.get(&id).copied(),
        };
        if let Some(Crossing { signals, marked }) = crossing {
            // Lights for vehicles at a crossing protect the people on it.
            let signals = signals || highway == Some("traffic_signals");
            kinds.push(FeatureKind::Crossing { signals, marked });
        } else if self.sidewalks.contains(&id) {
            kinds.push(FeatureKind::Sidewalk);
        }
        let Some(tags) = tags else { return kinds };
        let (kind, key): (fn(Travel) -> FeatureKind, _) = match highway {
            // A ramp meter holds those on its ramp, before they come to an intersection.
            Some("traffic_signals") if tags.is("traffic_signals", "ramp_meter") => {
                (FeatureKind::MidBlockSignals, "traffic_signals:direction")
            }
            Some("traffic_signals") => (FeatureKind::Signals, "traffic_signals:direction"),
            Some("stop") => (FeatureKind::Stop, "direction"),
            Some("give_way") => (FeatureKind::GiveWay, "direction"),
            _ => return kinds,
        };
        let travel = tagged_travel(tags, key);
        // Vehicles stop before a crossing, not on it.
        if crossing.is_none() {
            kinds.push(FeatureKind::StopLine(travel));
        }
        kinds.push(kind(travel));
        kinds
    }
}

/// The crossing that the tags of a node or way describe; `None` for `crossing=no`.
fn crossing(tags: &Tags) -> Option<Crossing> {
    let kind = tags.get("crossing");
    let lights = matches!(kind, Some("traffic_signals" | "pelican" | "toucan" | "puffin" | "pegasus"));
    let signals = match tags.get("crossing:signals") {
        Some(value) => value != "no",
        None => lights,
    };
    let marked = match tags.get("crossing:markings") {
        Some(value) => value != "no",
        None => lights || matches!(kind, Some("marked" | "zebra" | "uncontrolled")) || tags.has("crossing_ref"),
    };
    (kind != Some("no")).then_some(Crossing { signals, marked })
}

/// The direction of travel that lights or a sign apply to.
fn tagged_travel(tags: &Tags, key: &str) -> Travel {
    match tags.get(key).or_else(|| tags.get("direction")) {
        Some("forward") => Travel::Forward,
        Some("backward") => Travel::Backward,
        _ => Travel::Both,
    }
}

/// The features of one road, by station.
pub(super) fn along(
    piece: &WayPiece,
    road: &Road,
    positions: &FxHashMap<i64, Point>,
    at_nodes: &NodeFeatures<'_>,
) -> Vec<Feature> {
    let found: Vec<(usize, FeatureKind)> = piece
        .nodes
        .iter()
        .enumerate()
        .flat_map(|(i, id)| at_nodes.at(*id).into_iter().map(move |kind| (i, kind)))
        .filter(|(_, kind)| *kind != FeatureKind::Sidewalk || !road.public)
        .collect();
    if found.is_empty() {
        return Vec::new();
    }
    let points: Vec<Point> = piece.nodes.iter().filter_map(|id| positions.get(id).copied()).collect();
    let mut sums = vec![0.0];
    sums.extend(points.windows(2).scan(0.0, |sum, pair| {
        *sum += (pair[1] - pair[0]).norm();
        Some(*sum)
    }));
    let (total, length) = (sums.last().copied().unwrap_or(0.0), road.line.length());
    let one_way = road.one_way();
    let of_road = |travel| if travel == Travel::Both { one_way.unwrap_or(travel) } else { travel };
    let mut features: Vec<Feature> = found
        .into_iter()
        .filter_map(|(i, kind)| {
            let (point, share) = (*points.get(i)?, sums.get(i)? / total);
            let station = match i {
                0 => 0.0,
                _ if i + 1 == points.len() => length,
                _ => station(&road.line, point, share * length),
            };
            Some(Feature { station, node: piece.nodes[i], kind: kind.map_travel(of_road) })
        })
        .filter(|feature| feature.kind != FeatureKind::StopLine(Travel::Both))
        .collect();
    features.sort_by(|a, b| a.station.total_cmp(&b.station));
    features
}

/// The station of `point` on the line, metres, within [`WINDOW`] of the guess.
fn station(line: &Polyline, point: Point, guess: f64) -> f64 {
    let from = (guess - WINDOW).max(0.0);
    match line.cut(from, guess + WINDOW) {
        Some(part) => from + part.project(point).station,
        None => guess.clamp(0.0, line.length()),
    }
}
