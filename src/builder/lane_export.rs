//! Exports the lanes of streets one by one for lane stitching, each with its own middle line.

use rustc_hash::FxHashMap;

use crate::geometry::Polyline;
use crate::geometry::curve::untangled;
use crate::lane_stitching;
use crate::lane_stitching::{Kind, LaneId, Marking, Paint, Widths};
use crate::lanelet::Attributes;

use super::control::stop_line_segments::{has_stop_line, length_on};
use super::lanes::road_continuation::continued;
use super::network::{End, Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use super::tags::cross_section::{CrossSection, Travel};
use super::tags::marking::{before_stop, marking as along};

/// The longest miter of a lane's middle line as a multiple of its offset from the road's line.
const MITER_LIMIT: f64 = 3.0;

/// A lane at the end of a road: the index of its strip, and whether it leads out of the road there.
type StripEnd = (RoadEnd, usize, bool);

/// Every lane for motor vehicles, trimmed as its road. The road of a lane is the index of its road. Lanes of two roads that
/// continue each other share a node of their own; all other lane ends at an intersection share one node.
pub fn single_lanes(network: &RoadNetwork, kept: &[Stations]) -> Vec<(LaneId, lane_stitching::Lane)> {
    let nodes = continuation_nodes(network);
    let mut lanes = Vec::new();
    for (i, (road, kept)) in network.roads.iter().zip(kept).enumerate() {
        let ix = RoadIx::new(i);
        let Some(line) = road.line.cut(kept[0], kept[1]) else { continue };
        for (lane, (strip, backward)) in (0..).zip(driven(&road.section)) {
            let ends = if backward { [End::End, End::Start] } else { End::BOTH };
            let lane_nodes = ends.map(|end| {
                let strip_end = (RoadEnd { road: ix, end }, strip, end == ends[1]);
                Some(nodes.get(&strip_end).copied().unwrap_or_else(|| i64::from(road.intersection(end).0)))
            });
            let stop = stops(network, RoadEnd { road: ix, end: ends[1] }).then(|| length_on(network, line.length()));
            let strip = (strip, backward);
            if let Some(exported) = single_lane(road, network.country.as_deref(), &line, strip, stop.flatten()) {
                lanes.push((LaneId { road: i as i64, lane }, exported.on_nodes(lane_nodes)));
            }
        }
    }
    lanes
}

/// The lanes of a section: the strip, and whether it runs backward. A strip for both directions has two lanes.
fn driven(section: &CrossSection) -> impl Iterator<Item = (usize, bool)> + '_ {
    section.driven().flat_map(|(strip, s)| {
        let directions: &[bool] = match s.travel {
            Travel::Forward => &[false],
            Travel::Backward => &[true],
            Travel::Both => &[false, true],
        };
        directions.iter().map(move |&backward| (strip, backward))
    })
}

/// The nodes of lanes that continue each other, numbered after the intersections.
fn continuation_nodes(network: &RoadNetwork) -> FxHashMap<StripEnd, i64> {
    let mut nodes = FxHashMap::default();
    let mut next = network.intersections.len() as i64;
    for intersection in &network.intersections {
        let [a, b] = intersection.arms[..] else { continue };
        if a.road == b.road {
            continue;
        }
        for [x, y] in continued(network, a, b).into_iter().flatten() {
            nodes.insert((a, x.strip, x.onward), next);
            nodes.insert((b, y.strip, !y.onward), next);
            next += 1;
        }
    }
    nodes
}

/// A lane between two edges of its road. `before_stop` is the length, metres, of the markings before its stop line. `None` if the
/// lane has no length or no width.
fn single_lane(
    road: &Road,
    country: Option<&str>,
    line: &Polyline,
    (strip, backward): (usize, bool),
    before_stop: Option<f64>,
) -> Option<lane_stitching::Lane> {
    let section = &road.section;
    let middle = line.offset((section.edge(strip) + section.edge(strip + 1)) / 2.0, MITER_LIMIT)?;
    let middle = Polyline::new(untangled(middle.points()))?;
    let middle = if backward { middle.reversed() } else { middle };
    let start = before_stop.map(|length| middle.length() - length);
    let mut markings = [strip, strip + 1].map(|edge| markings(road, country, edge, (strip, backward), start));
    if backward {
        markings.reverse();
    }
    let lane = lane_stitching::Lane::along(middle, Widths::even(section.strips.get(strip)?.width).ok()?);
    lane.and_then(|lane| lane.painted(markings)).ok()
}

/// Whether a road end has a stop line.
fn stops(network: &RoadNetwork, end: RoadEnd) -> bool {
    let intersection = network.intersection(network.road(end.road).intersection(end.end));
    intersection.arms.len() > 2 && has_stop_line(network, intersection, end)
}

/// The markings of a lane at one of its edges; `stop_start` is the station, metres, where those before its stop line begin. Each
/// edge is painted along one lane: the lane to its right, if there is one.
fn markings(
    road: &Road,
    country: Option<&str>,
    edge: usize,
    (strip, backward): (usize, bool),
    stop_start: Option<f64>,
) -> Vec<Marking> {
    let paints = driven(&road.section)
        .filter(|(other, _)| [*other, *other + 1].contains(&edge))
        .max_by_key(|lane| (lane.0, !lane.1));
    if paints != Some((strip, backward)) {
        return Vec::new();
    }
    let marking = |station: f64, attributes: &Attributes| Marking { station, kinds: vec![kind(attributes, backward)] };
    let mut markings = vec![marking(0.0, &along(&road.section, edge, &road.tags, country, false))];
    if let Some(start) = stop_start {
        let before_stop = before_stop(&road.section, edge, &road.tags, false);
        markings.extend(before_stop.map(|attributes| marking(start, &attributes)));
    }
    markings
}

/// The kind of marking of the Lanelet2 tags of a border, seen along it or, if `backward`, against it.
fn kind(attributes: &Attributes, backward: bool) -> Kind {
    let subtype = attributes.get("subtype").unwrap_or_default();
    let paint = if attributes.is("color", "yellow") { Paint::Yellow } else { Paint::White };
    match (attributes.get("type").unwrap_or_default(), subtype, backward) {
        ("road_border", ..) => Kind::Kerb,
        ("virtual", ..) => Kind::Virtual,
        ("line_thin" | "line_thick", "solid", _) => Kind::Solid(paint),
        ("line_thin" | "line_thick", "dashed", _) => Kind::Dashed(paint),
        ("line_thin" | "line_thick", "solid_solid", _) => Kind::Double(paint),
        ("line_thin", "solid_dashed", false) | ("line_thin", "dashed_solid", true) => Kind::SolidDashed(paint),
        ("line_thin", "dashed_solid", false) | ("line_thin", "solid_dashed", true) => Kind::DashedSolid(paint),
        _ => Kind::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::{BuildOptions, plan};
    use crate::geometry::Point;
    use crate::lane_stitching::LaneStitching;
    use crate::osm::{OsmData, read_bytes};

    use super::*;

    #[test]
    fn lines_between_lanes_are_solid_before_lights() {
        let mut text = String::from("<osm version='0.6'>");
        let lights = "<tag k='highway' v='traffic_signals'/>";
        for (id, x, y, tags) in
            [(1, -100, 0, ""), (2, 0, 0, lights), (3, 100, 0, ""), (4, 0, -100, ""), (5, 0, 100, "")]
        {
            let (lat, lon) = (49.0 + f64::from(y) / 111_200.0, 8.5 + f64::from(x) / 73_000.0);
            text += &format!("<node id='{id}' lat='{lat:.9}' lon='{lon:.9}'>{tags}</node>");
        }
        for (id, refs) in [(10, [1, 2]), (11, [2, 3]), (12, [4, 2]), (13, [2, 5])] {
            text += &format!("<way id='{id}'><nd ref='{}'/><nd ref='{}'/>", refs[0], refs[1]);
            for (k, v) in [("highway", "secondary"), ("lanes", "4"), ("sidewalk", "no")] {
                text += &format!("<tag k='{k}' v='{v}'/>");
            }
            text += "</way>";
        }
        let mut osm = OsmData::default();
        read_bytes(&mut osm, "test", (text + "</osm>").into_bytes()).unwrap();
        let streets = plan(&osm, &BuildOptions::default()).unwrap().streets;
        let lanes = single_lanes(&streets.network, &streets.outlines.kept);
        assert_eq!(lanes.len(), 16);
        let stitching = LaneStitching::new(lanes);
        let strokes = stitching.iter().flat_map(|(_, lane)| lane.strokes().iter());
        let between = strokes.filter(|stroke| stroke.kind == Kind::Solid(Paint::White));
        let length = |line: &[Point]| line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
        let before_stop = between.filter(|stroke| (length(stroke.line) - 30.0).abs() < 1e-3);
        let solid = before_stop.count();
        assert_eq!(solid, 4, "one line of each approach");
    }
}
