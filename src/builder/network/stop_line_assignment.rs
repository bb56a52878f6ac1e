//! Stop lines that OpenStreetMap maps as ways, assigned to roads and directions of travel.

use crate::builder::tags::cross_section::Travel;
use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::geometry::{Point, left_of, polygon};
use crate::osm::{OsmData, Tags, Way};
use crate::projection::LonLat;

use super::frame::{ToMetres, level};
use super::{Feature, FeatureKind, Road};

/// Shortest and longest stop line, metres: a longer line runs along a road.
const LENGTH: [f64; 2] = [1.0, 40.0];
/// Largest angle between a stop line and the perpendicular of the road, radians: 30 degrees.
const ASKEW: f64 = std::f64::consts::FRAC_PI_6;
/// Least share of a stop line that lies on the driven lanes: their position is known to a metre or two.
const ON_ROAD: f64 = 0.5;
/// A direction of travel with this share of the covered lanes is the only one that the line stops.
const STOPPED: f64 = 0.7;
/// Distance within which a mapped line replaces the stop line of a sign or light, metres.
const OVERRULED: f64 = 25.0;

/// A mapped stop line.
struct MappedStopLine {
    node: i64,
    level: f64,
    ends: [Point; 2],
}

/// Where a stop line lies on a road.
struct StopPlace {
    road: usize,
    /// Whether line and road are on one level.
    level: bool,
    /// Length of the line on the lanes that it stops, metres.
    covers: f64,
    station: f64,
    travel: Travel,
}

/// Adds every mapped stop line to the road that it lies on, and removes the stop lines of signs and lights near it.
pub(super) fn assign(osm: &OsmData, to_metres: ToMetres<'_>, roads: &mut [Road]) {
    let lines = mapped(osm, to_metres);
    if lines.is_empty() {
        return;
    }
    let boxes: Vec<Bounds> = lines.iter().filter_map(|line| polygon::bounds(&line.ends)).collect();
    let cells = SpatialHash::new(boxes, LENGTH[1]);
    let mut best: Vec<Option<StopPlace>> = lines.iter().map(|_| None).collect();
    for (i, road) in roads.iter().enumerate() {
        for bounds in road.segment_bounds() {
            cells.touching(bounds, |line| {
                let found = place(i, road, &lines[line]);
                let better = |a: &StopPlace, b: &StopPlace| (a.level, a.covers) > (b.level, b.covers);
                if let Some(found) = found
                    && best[line].as_ref().is_none_or(|best| better(&found, best))
                {
                    best[line] = Some(found);
                }
            });
        }
    }
    let placed: Vec<(i64, StopPlace)> =
        lines.iter().zip(best).filter_map(|(line, place)| Some((line.node, place?))).collect();
    for (_, StopPlace { road, station, travel, .. }) in &placed {
        let is_overruled =
            |f: &Feature| f.kind == FeatureKind::StopLine(*travel) && (f.station - station).abs() < OVERRULED;
        roads[*road].features.retain(|feature| !is_overruled(feature));
    }
    for (node, StopPlace { road, station, travel, .. }) in placed {
        let features = &mut roads[road].features;
        features.push(Feature { station, node, kind: FeatureKind::StopLine(travel) });
        features.sort_by(|a, b| a.station.total_cmp(&b.station));
    }
}

/// `road_marking=stop_line`, or the older `solid_stop_line` and `dashed_stop_line`.
fn is_stop_line(tags: &Tags) -> bool {
    tags.get("road_marking").is_some_and(|value| value == "stop_line" || value.ends_with("_stop_line"))
}

/// All mapped stop lines, in order of their ids.
fn mapped(osm: &OsmData, to_metres: ToMetres<'_>) -> Vec<MappedStopLine> {
    let mut ways: Vec<&Way> = osm.ways.iter().filter(|way| is_stop_line(&way.tags)).collect();
    ways.sort_by_key(|way| way.id);
    let ends = ways.into_iter().filter_map(|way| {
        let (first, last) = (*way.nodes.first()?, *way.nodes.last()?);
        let places = [osm.node(first)?.position?, osm.node(last)?.position?];
        Some((first, level(&way.tags), places))
    });
    let ends: Vec<(i64, f64, [LonLat; 2])> = ends.collect();
    let places: Vec<LonLat> = ends.iter().flat_map(|(.., places)| *places).collect();
    let points = to_metres(&places);
    let lines = ends.into_iter().zip(points.chunks_exact(2));
    let lines = lines.map(|((node, level, _), ends)| MappedStopLine { node, level, ends: [ends[0], ends[1]] });
    lines.filter(|line| (LENGTH[0]..=LENGTH[1]).contains(&(line.ends[1] - line.ends[0]).norm())).collect()
}

/// Where a stop line lies on a road; `None` if it does not lie across its lanes.
fn place(index: usize, road: &Road, line: &MappedStopLine) -> Option<StopPlace> {
    let [a, b] = line.ends;
    let foot = road.line.project(nalgebra::center(&a, &b));
    let along = road.line.direction(foot.station);
    let length = (b - a).norm();
    let ahead = (b - a).dot(&along).abs() <= ASKEW.sin() * length;
    let offsets = [a, b].map(|end| (end - foot.point).dot(&left_of(along)));
    let (low, high) = (offsets[0].min(offsets[1]), offsets[0].max(offsets[1]));
    let on = |travels: [Travel; 2]| -> f64 {
        let strips = road.section.driven().filter(|(_, strip)| travels.contains(&strip.travel));
        let part = |i: usize| high.min(road.section.edge(i)) - low.max(road.section.edge(i + 1));
        strips.map(|(i, _)| part(i).max(0.0)).sum()
    };
    let [with, against] = [[Travel::Forward, Travel::Both], [Travel::Backward, Travel::Both]].map(on);
    let all = on([Travel::Forward, Travel::Backward]) + on([Travel::Both; 2]);
    let (covers, travel) = match () {
        () if with >= STOPPED * all && with > against => (with, Travel::Forward),
        () if against >= STOPPED * all && against > with => (against, Travel::Backward),
        () => (all, Travel::Both),
    };
    let inside = foot.station > 0.0 && foot.station < road.line.length();
    let level = line.level == road.level;
    let found = StopPlace { road: index, level, covers, station: foot.station, travel };
    (inside && ahead && all >= ON_ROAD * length).then_some(found)
}
