//! The stage itself: from OpenStreetMap's elements to roads and intersections.

use crate::builder::tags::cross_section::{Customs, SectionReading};
use crate::builder::tags::driving_side::{Country, of_place};
use crate::builder::tags::road_class::{DrivingSide, is_roundabout};
use crate::builder::tags::speed::limit;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::{Point, Polyline};
use crate::osm::{OsmData, Tags, Text, Way};
use crate::parallel::InSmallParts;
use crate::projection::{Extent, LonLat};
use crate::settings::{AssumeSettings, RoadSettings};

use super::access::{Access, AccessVerdict, Drivable, classify, is_shared_path};
use super::arm_order::{Ray, clockwise};
use super::barriers::Barriers;
use super::crossing_ways::{cut_at_crossings, prohibited_turns};
use super::features::NodeFeatures;
use super::frame::{ToMetres, level};
use super::restriction_relations::turns;
use super::self_crossings::cut_at_self_crossings;
use super::short_dead_ends::without_short_dead_ends;
use super::way_cross_sections::WaySections;
use super::way_pieces::{WayPiece, number, pieces};
use super::{
    End, Intersection, IntersectionIx, Road, RoadEnd, RoadIx, RoadKey, RoadNetwork, crossing_assignment, features,
    islands, mid_block_signals, private_ground, signal_assignment, small_rings, stop_line_assignment, turning_loops,
    twin_ways,
};

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

/// Vertices closer than this, metres, to the line through their neighbours are dropped: it is below a mapper's accuracy.
const SIMPLIFY: f64 = 0.03;

/// Longest miter join of an offset line, as a multiple of the offset.
const SHIFT_MITER: f64 = 3.0;

/// The speed limit, km/h, of a shared path without one: vehicles keep to a walking pace, up to 10 km/h, where people walk on the
/// carriageway.
const SHARED_PATH_SPEED: u8 = 10;

/// The fault for a `[[road]]` whose way is not in the data.
pub const UNMET_ROAD: &str = "road-unmet";

/// Options of [`road_network`].
#[derive(Clone, Debug, Default)]
pub struct NetworkOptions {
    /// Which side people drive on; if absent, that of the country.
    pub driving_side: Option<DrivingSide>,
    /// The country; if absent, looked up by position.
    pub country: Option<Country>,
    /// Assumptions for missing tags.
    pub assume: Vec<AssumeSettings>,
    /// Tags that replace those of the data.
    pub roads: Vec<RoadSettings>,
}

/// The network with its notes.
#[derive(Clone, Debug)]
pub struct NetworkReading {
    /// Roads and intersections.
    pub network: RoadNetwork,
    /// What was guessed, left out or skipped; the subjects are OpenStreetMap elements.
    pub notes: Vec<Finding>,
}

/// Why no network was built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// There is no drivable road.
    #[error("there is no drivable road in the input ({ways} ways, {left_out} left out as not drivable{})", shown(.first.as_deref()))]
    NoRoad {
        /// Ways in the data.
        ways: usize,
        /// How many of them are roads that were left out.
        left_out: usize,
        /// Why the first of these was left out.
        first: Option<String>,
    },
}

fn shown(first: Option<&str>) -> String {
    first.map_or_else(String::new, |first| format!("; {first}"))
}

/// Reads the road network from the data.
///
/// # Errors
/// If the data has no drivable road.
pub fn road_network(
    osm: &OsmData,
    to_metres: ToMetres<'_>,
    options: &NetworkOptions,
) -> Result<NetworkReading, NetworkError> {
    let mut notes = Vec::new();
    let mut corrected = corrected(osm, &options.roads, &mut notes);
    twin_ways::unite(osm, &mut corrected, &mut notes);
    let mut drivable = drivable(osm, &corrected, &mut notes);
    let (ids, places) = located(osm, &drivable);
    let barriers = Barriers::read(osm, &ids, &mut drivable);
    let place = options.country.clone().unwrap_or_else(|| of_place(middle(&places)));
    let side = options.driving_side.unwrap_or(place.side);
    let country = place.country;
    let customs = Customs { side, country: country.as_deref(), assume: &options.assume };
    // In parallel, because cutting the ways takes one thread only.
    let cut_ways = || {
        let ways = &drivable[..barriers.ways()];
        let mut positions = small_rings::widened(ways, positions(ids, to_metres(&places)), &mut notes);
        let pieces = pieces(ways, barriers.nodes(), &positions, &mut notes);
        let pieces = cut_at_self_crossings(pieces, &drivable, &mut positions, &mut notes);
        let (pieces, mut crossed) = cut_at_crossings(pieces, &drivable, &mut positions, &mut notes);
        crossed.sort_unstable();
        let mut pieces = barriers.part(pieces, &drivable, &mut positions, &mut notes);
        number(&mut pieces, &drivable);
        (positions, pieces, crossed)
    };
    let read_tags = || (NodeFeatures::new(osm), WaySections::read(&drivable, customs));
    let ((positions, pieces, crossed), (at_nodes, sections)) = rayon::join(cut_ways, read_tags);
    let pieces: Vec<(WayPiece, Polyline)> = pieces
        .into_par_iter()
        .in_small_parts()
        .filter_map(|piece| centre(&piece, &positions).map(|line| (piece, line)))
        .collect();
    if pieces.is_empty() {
        return Err(no_road(osm, &notes));
    }
    let used = pieces.iter().map(|(piece, _)| piece.way);
    let layouts = sections.of_ways(used, &positions, &mut notes);
    let (pieces, centres): (Vec<WayPiece>, Vec<Polyline>) =
        without_short_dead_ends(pieces, &drivable, &layouts, &mut notes).into_iter().unzip();
    let mut nodes: Vec<i64> = pieces.iter().flat_map(WayPiece::ends).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let index: FxHashMap<i64, IntersectionIx> = nodes.iter().zip(0..).map(|(id, i)| (*id, IntersectionIx(i))).collect();

    let roads = pieces.par_iter().in_small_parts().zip(&centres).map(|(piece, centre)| {
        let layout = &layouts[&piece.way];
        let mut road = road(piece, &drivable[piece.way], layout, &customs, centre, &index);
        road.features = features::along(piece, &road, &positions, &at_nodes);
        road
    });
    let mut roads: Vec<Road> = roads.collect();
    stop_line_assignment::assign(osm, to_metres, &mut roads);
    let mut intersections = intersections(osm, &nodes, &positions, &pieces, &roads, &centres);
    islands::assign(osm, to_metres, &roads, &mut intersections);
    let mut network = RoadNetwork { side, country, roads, intersections, ..RoadNetwork::default() };
    turning_loops::direct(&mut network, &mut notes);
    private_ground::close(&mut network, &barriers.private_gates());
    crossing_assignment::assign_crossings(osm, to_metres, &mut network, &mut notes);
    signal_assignment::assign(osm, &mut network, &mut notes);
    mid_block_signals::find(&mut network);
    (network.restrictions, network.connections) = turns(osm, &network, &mut notes);
    let across = prohibited_turns(&network.intersections, &network.roads, &crossed);
    network.restrictions.extend(across);
    Ok(NetworkReading { network, notes })
}

fn no_road(osm: &OsmData, notes: &[Finding]) -> NetworkError {
    let mut skipped = notes.iter().filter(|note| note.fault == "way-skipped").map(|note| &note.message);
    let (left_out, first) = (skipped.clone().count(), skipped.next().cloned());
    NetworkError::NoRoad { ways: osm.ways.len(), left_out, first }
}

/// The ways whose tags `[[road]]` changes, with a note for each that is not in the data.
fn corrected(osm: &OsmData, roads: &[RoadSettings], notes: &mut Vec<Finding>) -> FxHashMap<i64, Way> {
    let mut corrected: FxHashMap<i64, Way> = FxHashMap::default();
    // The last entry comes from the outermost file: earlier entries overrule it.
    for setting in roads.iter().rev() {
        for id in &setting.ways {
            let Some(way) = osm.way(*id) else {
                let place = setting
                    .origin
                    .as_ref()
                    .map(|origin| format!("{}:{}: ", origin.file, origin.line))
                    .unwrap_or_default();
                let message = format!("{place}[[road]] does nothing for way {id}: it is not in the data");
                notes.push(Finding::new(UNMET_ROAD, Subject::Way(*id), message).graded(Severity::Warning));
                continue;
            };
            correct(&mut corrected.entry(*id).or_insert_with(|| way.clone()).tags, &setting.tags);
        }
    }
    for setting in roads.iter().filter(|setting| setting.shared_paths) {
        let shared = osm.ways.iter().filter(|way| is_shared_path(&corrected.get(&way.id).unwrap_or(way).tags));
        for way in shared.collect::<Vec<_>>() {
            let tags = &mut corrected.entry(way.id).or_insert_with(|| way.clone()).tags;
            let speed = if tags.has("maxspeed") { String::new() } else { format!(" at {SHARED_PATH_SPEED} km/h") };
            let highway = tags.get("highway").unwrap_or_default();
            let message = format!(
                "way {} (highway={highway}) is built as a private road{speed}, because [[road]] has `shared_paths = true`",
                way.id
            );
            notes.push(Finding::new("path-shared", Subject::Way(way.id), message).graded(Severity::Info));
            open_shared_path(tags, setting);
        }
    }
    corrected
}

/// Makes a way of people and bicycles that admits motor vehicles a private road, with the tags of the setting.
fn open_shared_path(tags: &mut Tags, setting: &RoadSettings) {
    let mut own = BTreeMap::from([("highway", "service"), ("motor_vehicle", "private"), ("motorcar", "")]);
    let speed = SHARED_PATH_SPEED.to_string();
    if !tags.has("maxspeed") {
        own.insert("maxspeed", &speed);
    }
    let own = own.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned()));
    let own: BTreeMap<String, String> = own.chain(setting.tags.clone()).collect();
    correct(tags, &own);
}

/// Puts the tags of a setting in the place of others.
fn correct(tags: &mut Tags, own: &BTreeMap<String, String>) {
    let others = tags.iter().filter(|(key, _)| !own.contains_key(*key));
    let own = own.iter().filter(|(_, value)| !value.is_empty());
    *tags = others.chain(own.map(|(key, value)| (key.as_str(), value.as_str()))).collect();
}

/// Whether cars drive on a way, with the tags that these settings give it.
pub fn is_driven(way: &Way, roads: &[RoadSettings]) -> bool {
    let about = roads.iter().rev().filter(|setting| setting.ways.contains(&way.id));
    let corrected = about.fold(None, |corrected: Option<Way>, setting| {
        let mut way = corrected.unwrap_or_else(|| way.clone());
        correct(&mut way.tags, &setting.tags);
        Some(way)
    });
    let shared = roads.iter().find(|setting| setting.shared_paths);
    let corrected = match shared.filter(|_| is_shared_path(&corrected.as_ref().unwrap_or(way).tags)) {
        Some(setting) => {
            let mut way = corrected.unwrap_or_else(|| way.clone());
            open_shared_path(&mut way.tags, setting);
            Some(way)
        }
        None => corrected,
    };
    matches!(classify(corrected.as_ref().unwrap_or(way)), AccessVerdict::Road(_))
}

/// Whether a way is a road by its tags, for whomever, or driven with the tags that these settings give it.
pub fn is_highway(way: &Way, roads: &[RoadSettings]) -> bool {
    way.tags.has("highway") || is_driven(way, roads)
}

/// The drivable ways in order of their ids, with a note for each road that is left out.
fn drivable<'a>(osm: &'a OsmData, corrected: &'a FxHashMap<i64, Way>, notes: &mut Vec<Finding>) -> Vec<Drivable<'a>> {
    let verdict = |way: &'a Way| {
        // Of ways with the same id the last counts.
        let is_last = || osm.way(way.id).is_some_and(|last| std::ptr::eq(last, way));
        let way_in_force = corrected.get(&way.id).unwrap_or(way);
        let verdict = classify(way_in_force);
        (!matches!(verdict, AccessVerdict::NoRoad) && is_last()).then_some((way_in_force, verdict))
    };
    let mut verdicts: Vec<(&Way, AccessVerdict)> = osm.ways.par_iter().in_small_parts().filter_map(verdict).collect();
    verdicts.sort_unstable_by_key(|(way, _)| way.id);
    let mut drivable = Vec::new();
    for (way, verdict) in verdicts {
        match verdict {
            AccessVerdict::Road(road) => drivable.push(road),
            AccessVerdict::LeftOut(why) => {
                let message = format!("way {} is not built: {why}", way.id);
                notes.push(Finding::new("way-skipped", Subject::Way(way.id), message).graded(Severity::Info));
            }
            AccessVerdict::NoRoad => {}
        }
    }
    drivable
}

/// The nodes of the ways that have a position, by ascending id, and their positions.
fn located(osm: &OsmData, drivable: &[Drivable<'_>]) -> (Vec<i64>, Vec<LonLat>) {
    let mut ids: Vec<i64> = drivable.iter().flat_map(|d| d.way.nodes.iter().copied()).collect();
    ids.par_sort_unstable();
    ids.dedup();
    let known: Vec<(i64, LonLat)> =
        ids.into_par_iter().in_small_parts().filter_map(|id| Some((id, osm.node(id)?.position?))).collect();
    known.into_iter().unzip()
}

/// The finite points by node id.
fn positions(ids: Vec<i64>, points: Vec<Point>) -> FxHashMap<i64, Point> {
    let finite = |p: &Point| p.x.is_finite() && p.y.is_finite();
    let mut positions = FxHashMap::with_capacity_and_hasher(ids.len(), FxBuildHasher);
    positions.extend(ids.into_iter().zip(points).filter(|(_, p)| finite(p)));
    positions
}

/// The middle of the bounding box of the places; no place on Earth if there are none.
fn middle(places: &[LonLat]) -> LonLat {
    Extent::of(places.iter().copied()).map_or(LonLat { lon: f64::NAN, lat: f64::NAN }, |extent| extent.center())
}

/// The piece's line without vertices that lie on the line through their neighbours.
fn centre(piece: &WayPiece, positions: &FxHashMap<i64, Point>) -> Option<Polyline> {
    let line = Polyline::new(piece.nodes.iter().filter_map(|id| positions.get(id).copied()))?;
    Some(line.straightened(SIMPLIFY))
}

fn road(
    piece: &WayPiece,
    way: &Drivable<'_>,
    layout: &SectionReading,
    customs: &Customs<'_>,
    centre: &Polyline,
    index: &FxHashMap<i64, IntersectionIx>,
) -> Road {
    let tags = &way.way.tags;
    let [first, last] = piece.ends();
    let line = if layout.shift == 0.0 { None } else { centre.offset(layout.shift, SHIFT_MITER) };
    Road {
        key: RoadKey { way: way.way.id, first, last, turn: piece.turn },
        ways: vec![way.way.id],
        from: index[&first],
        to: index[&last],
        line: line.unwrap_or_else(|| centre.clone()),
        heights: Vec::new(),
        section: layout.section.clone(),
        class: way.class,
        link: way.link,
        level: level(tags) + f64::from(piece.raised),
        // A ring that is driven both ways has intersections like other streets.
        roundabout: is_roundabout(tags) && layout.section.one_way().is_some(),
        public: way.access != Access::Private,
        name: tags.get("name").or_else(|| tags.get("ref")).map(Text::from),
        speed: limit(tags, way.class, way.link, customs),
        features: Vec::new(),
        tags: tags.clone(),
    }
}

fn intersections(
    osm: &OsmData,
    nodes: &[i64],
    positions: &FxHashMap<i64, Point>,
    pieces: &[WayPiece],
    roads: &[Road],
    centres: &[Polyline],
) -> Vec<Intersection> {
    let mut ends: Vec<Vec<RoadEnd>> = vec![Vec::new(); nodes.len()];
    for (road, ix) in roads.iter().zip(0..) {
        for end in End::BOTH {
            ends[road.intersection(end)].push(RoadEnd { road: RoadIx(ix), end });
        }
    }
    let ray = |&RoadEnd { road, end }: &RoadEnd| {
        let (road, centre) = (&roads[road], &centres[road]);
        let line = if end == End::Start { centre.clone() } else { centre.reversed() };
        Ray { line, key: (road.key, end) }
    };
    let mut edges: FxHashSet<i64> = FxHashSet::default();
    for piece in pieces {
        edges.extend(piece.ends().into_iter().zip(piece.edge).filter(|(_, edge)| *edge).map(|(id, _)| id));
    }
    nodes
        .par_iter()
        .in_small_parts()
        .zip(ends)
        .map(|(&id, ends)| {
            let position = positions[&id];
            let rays: Vec<Ray<_>> = ends.iter().map(ray).collect();
            let arms = clockwise(position, &rays).into_iter().map(|i| ends[i]).collect();
            let node = osm.node(id);
            let highway = node.and_then(|node| node.tags.get("highway"));
            let place = node.and_then(|node| node.position);
            let cut_off = ends.len() == 1 && place.is_some_and(|place| !osm.reaches_beyond(place));
            Intersection {
                map_edge: edges.contains(&id) || cut_off,
                signals: highway == Some("traffic_signals"),
                all_way_stop: highway == Some("stop") && osm.node(id).is_some_and(|node| node.tags.is("stop", "all")),
                circle: highway
                    .filter(|v| matches!(*v, "mini_roundabout" | "turning_circle" | "turning_loop"))
                    .map(Text::from),
                ..Intersection::of_arms(vec![id], position, arms)
            }
        })
        .collect()
}
