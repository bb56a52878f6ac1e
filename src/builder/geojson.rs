//! Writes roads, lanes and intersections as GeoJSON: the geometry alone, for other tools and for measuring it.

use serde::Serialize;

use crate::geometry::{Point, Polyline};
use crate::projection::LonLat;

use super::cross_section::{StripKind, Travel};
use super::outline::{Case, MITER_LIMIT, Outline, Outlines};
use super::road_network::{End, Intersection, IntersectionIx, Road, RoadKey, RoadNetwork};

/// From local metres to longitude and latitude, for many places at once, in their order.
pub type ToLonLat<'a> = &'a dyn Fn(&[Point]) -> Vec<LonLat>;

/// The whole file as text: `to_lonlat` gives longitude and latitude, as GeoJSON wants it; without it coordinates stay
/// local metres and a member `"units": "m"` says so.
pub fn geometry_geojson(
    network: &RoadNetwork,
    outlines: &Outlines,
    to_lonlat: Option<ToLonLat<'_>>,
) -> serde_json::Result<String> {
    let place = Placer { to_lonlat };
    let mut features = Vec::new();
    for (i, road) in network.roads.iter().enumerate() {
        road_features(network, outlines, i, road, &place, &mut features);
    }
    for (i, outline) in outlines.intersections.iter().enumerate() {
        features.push(intersection_feature(network, IntersectionIx(i as u32), outline, &place));
    }
    let units = if to_lonlat.is_none() { Some("m") } else { None };
    serde_json::to_string(&Collection { kind: "FeatureCollection", units, features })
}

#[derive(Serialize)]
struct Collection {
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    units: Option<&'static str>,
    features: Vec<Feature>,
}

#[derive(Serialize)]
struct Feature {
    #[serde(rename = "type")]
    kind: &'static str,
    properties: Properties,
    geometry: Option<Geometry>,
}

#[derive(Serialize)]
struct Geometry {
    #[serde(rename = "type")]
    kind: &'static str,
    coordinates: [Vec<[f64; 2]>; 1],
}

#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Properties {
    Road(RoadProperties),
    Lane(LaneProperties),
    Intersection(IntersectionProperties),
}

#[derive(Serialize)]
struct RoadProperties {
    id: String,
    src: String,
    dst: String,
    osm_ids: Vec<i64>,
    drive: bool,
    layer: f64,
    width: f64,
    length: f64,
    trim_start: f64,
    trim_end: f64,
    oblivion: bool,
    ends: Vec<EndProperties>,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    class: String,
    link: bool,
    roundabout: bool,
}

#[derive(Serialize)]
struct EndProperties {
    int: String,
    pts: [[f64; 2]; 2],
}

#[derive(Serialize)]
struct LaneProperties {
    id: String,
    road: String,
    drive: bool,
    layer: f64,
    kind: &'static str,
    travel: &'static str,
    width: f64,
}

#[derive(Serialize)]
struct IntersectionProperties {
    id: String,
    roads: Vec<String>,
    drive: bool,
    layer: Vec<f64>,
    case: Case,
    terminal: bool,
    fallback: bool,
    merged_from: Vec<i64>,
    signals: bool,
}

/// Puts points into the units of the file.
struct Placer<'a> {
    to_lonlat: Option<ToLonLat<'a>>,
}

impl Placer<'_> {
    fn points(&self, points: &[Point]) -> Vec<[f64; 2]> {
        // A tenth of a millimetre, in either unit.
        let rounded = |v: f64, per_unit: f64| (v * per_unit).round() / per_unit;
        match self.to_lonlat {
            None => points.iter().map(|p| [rounded(p.x, 1e4), rounded(p.y, 1e4)]).collect(),
            Some(to_lonlat) => to_lonlat(points).iter().map(|p| [rounded(p.lon, 1e9), rounded(p.lat, 1e9)]).collect(),
        }
    }

    fn polygon(&self, ring: &[Point]) -> Option<Geometry> {
        let mut closed = self.points(ring);
        closed.push(*closed.first()?);
        (closed.len() > 3).then_some(Geometry { kind: "Polygon", coordinates: [closed] })
    }
}

fn road_id(key: &RoadKey) -> String {
    format!("{}:{}-{}:{}", key.way, key.first, key.last, key.turn)
}

fn intersection_id(network: &RoadNetwork, ix: IntersectionIx) -> String {
    network.intersection(ix).nodes.first().map_or_else(|| format!("#{}", ix.0), i64::to_string)
}

fn feature(properties: Properties, geometry: Option<Geometry>) -> Feature {
    Feature { kind: "Feature", properties, geometry }
}

fn road_features(
    network: &RoadNetwork,
    outlines: &Outlines,
    index: usize,
    road: &Road,
    place: &Placer<'_>,
    features: &mut Vec<Feature>,
) {
    let [from, to] = outlines.kept[index];
    let id = road_id(&road.key);
    let line = road.line.cut(from, to);
    let strip = |left: f64, right: f64| line.as_ref().and_then(|line| place.polygon(&strip(line, left, right)?));
    let ends = [End::Start, End::End].map(|end| EndProperties {
        int: intersection_id(network, road.intersection(end)),
        pts: end_points(outlines, network, index, end, place),
    });
    let half = road.half_width();
    let properties = RoadProperties {
        id: id.clone(),
        src: ends[0].int.clone(),
        dst: ends[1].int.clone(),
        osm_ids: road.ways.clone(),
        drive: true,
        layer: road.level,
        width: half * 2.0,
        length: line.as_ref().map_or(0.0, Polyline::length),
        trim_start: from,
        trim_end: road.line.length() - to,
        oblivion: line.is_none(),
        ends: ends.into(),
        name: road.name.as_ref().map(ToString::to_string),
        class: format!("{:?}", road.class).to_lowercase(),
        link: road.link,
        roundabout: road.roundabout,
    };
    features.push(feature(Properties::Road(properties), strip(half, -half)));
    for (i, lane) in road.section.strips.iter().enumerate() {
        let properties = LaneProperties {
            id: format!("{id}:{i}"),
            road: id.clone(),
            drive: true,
            layer: road.level,
            kind: kind_name(lane.kind),
            travel: travel_name(lane.travel),
            width: lane.width,
        };
        let geometry = strip(road.section.edge(i), road.section.edge(i + 1));
        features.push(feature(Properties::Lane(properties), geometry));
    }
}

/// The ring between two offsets of a line.
fn strip(line: &Polyline, left: f64, right: f64) -> Option<Vec<Point>> {
    let mut ring = line.offset(left, MITER_LIMIT)?.points().to_vec();
    ring.extend(line.offset(right, MITER_LIMIT)?.points().iter().rev());
    Some(ring)
}

/// The ends of the cut across one end of a road.
fn end_points(outlines: &Outlines, network: &RoadNetwork, road: usize, end: End, place: &Placer<'_>) -> [[f64; 2]; 2] {
    let at = network.roads[road].intersection(end);
    let cut =
        outlines.intersections[at.0 as usize].cuts.iter().find(|c| c.at.road.0 as usize == road && c.at.end == end);
    let points = cut.map_or_else(Vec::new, |cut| place.points(&[cut.left, cut.right]));
    [points.first().copied().unwrap_or_default(), points.get(1).copied().unwrap_or_default()]
}

fn intersection_feature(network: &RoadNetwork, ix: IntersectionIx, outline: &Outline, place: &Placer<'_>) -> Feature {
    let intersection: &Intersection = network.intersection(ix);
    let mut layer: Vec<f64> = intersection.arms.iter().map(|arm| network.road(arm.road).level).collect();
    layer.sort_by(f64::total_cmp);
    layer.dedup();
    let properties = IntersectionProperties {
        id: intersection_id(network, ix),
        roads: intersection.arms.iter().map(|arm| road_id(&network.road(arm.road).key)).collect(),
        drive: true,
        layer,
        case: outline.case,
        terminal: intersection.arms.len() < 2,
        fallback: outline.case == Case::Fallback,
        merged_from: intersection.nodes.clone(),
        signals: intersection.signals,
    };
    feature(Properties::Intersection(properties), place.polygon(&outline.ring))
}

fn kind_name(kind: StripKind) -> &'static str {
    match kind {
        StripKind::Drive => "drive",
        StripKind::Bus => "bus",
        StripKind::Bicycle => "bicycle",
        StripKind::Parking => "parking",
        StripKind::Shoulder => "shoulder",
        StripKind::Sidewalk => "sidewalk",
        StripKind::Buffer => "buffer",
    }
}

fn travel_name(travel: Travel) -> &'static str {
    match travel {
        Travel::Forward => "forward",
        Travel::Backward => "backward",
        Travel::Both => "both",
    }
}
