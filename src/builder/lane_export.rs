//! The lanes of streets one by one, each with a middle line of its own, to be woven and edited.

use rustc_hash::FxHashMap;

use crate::geometry::Polyline;
use crate::geometry::curve::untangled;
use crate::lane_stitching;
use crate::lane_stitching::{Kind, LaneId, Marking, Paint, Widths};
use crate::lanelet::Attributes;

use super::control::stop_line_segments::{has_stop_line, length_on};
use super::lanes::road_continuation::continued;
use super::network::{End, Road, RoadEnd, RoadIx, RoadNetwork};
use super::tags::cross_section::{CrossSection, Travel};
use super::tags::marking::{before_stop, marking as along};

/// The middle of a lane is mitred up to so many times its distance from the road's line.
const MITER_MOST: f64 = 3.0;

/// A lane at the end of a road: its strip, and whether it leads out of the road there.
type Hanging = (RoadEnd, usize, bool);

/// Every lane that motor vehicles drive on, between the stations between which its road is kept. A lane's road is the
/// index of the road. Lanes of two roads that continue each other, lane by lane, hang on a node of their own; all other
/// ends at an intersection hang on one together.
pub fn single_lanes(network: &RoadNetwork, kept: &[[f64; 2]]) -> Vec<(LaneId, lane_stitching::Lane)> {
    let nodes = own_nodes(network);
    let mut lanes = Vec::new();
    for (i, (road, kept)) in network.roads.iter().zip(kept).enumerate() {
        let ix = RoadIx(i as u32);
        let Some(line) = road.line.cut(kept[0], kept[1]) else { continue };
        for (lane, (strip, backward)) in (0..).zip(driven(&road.section)) {
            let node = |end: End| {
                let out = (end == End::End) != backward;
                let at = RoadEnd { road: ix, end };
                nodes.get(&(at, strip, out)).copied().unwrap_or_else(|| i64::from(road.intersection(end).0))
            };
            let mut nodes = [End::Start, End::End].map(|end| Some(node(end)));
            if backward {
                nodes.reverse();
            }
            let toward = if backward { End::Start } else { End::End };
            let stop = stops(network, RoadEnd { road: ix, end: toward }).then(|| length_on(network, line.length()));
            let strip = (strip, backward);
            if let Some(made) = single_lane(road, network.country.as_deref(), &line, strip, stop.flatten()) {
                lanes.push((LaneId { road: i as i64, lane }, made.on_nodes(nodes)));
            }
        }
    }
    lanes
}

/// Strips with their directions; one for both directions carries two lanes.
fn driven(section: &CrossSection) -> impl Iterator<Item = (usize, bool)> + '_ {
    section.driven().flat_map(|(strip, s)| {
        let ways: &[bool] = match s.travel {
            Travel::Forward => &[false],
            Travel::Backward => &[true],
            Travel::Both => &[false, true],
        };
        ways.iter().map(move |&backward| (strip, backward))
    })
}

/// The nodes between lanes that continue each other, numbered behind the intersections.
fn own_nodes(network: &RoadNetwork) -> FxHashMap<Hanging, i64> {
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

/// `None` where a lane leaves no line, or its width is none.
fn single_lane(
    road: &Road,
    country: Option<&str>,
    line: &Polyline,
    (strip, backward): (usize, bool),
    before_stop: Option<f64>,
) -> Option<lane_stitching::Lane> {
    let section = &road.section;
    let middle = line.offset((section.edge(strip) + section.edge(strip + 1)) / 2.0, MITER_MOST)?;
    let middle = Polyline::new(untangled(middle.points()))?;
    let middle = if backward { middle.reversed() } else { middle };
    let begin = before_stop.map(|length| middle.length() - length);
    let mut markings = [strip, strip + 1].map(|edge| markings(road, country, edge, (strip, backward), begin));
    if backward {
        markings.reverse();
    }
    let lane = lane_stitching::Lane::along(middle, Widths::even(section.strips[strip].width).ok()?);
    lane.and_then(|lane| lane.painted(markings)).ok()
}

/// Whether vehicles stop at a line where a road ends.
fn stops(network: &RoadNetwork, at: RoadEnd) -> bool {
    let intersection = network.intersection(network.road(at.road).intersection(at.end));
    intersection.arms.len() > 2 && has_stop_line(network, intersection, at)
}

/// What a lane has painted on one of its edges, otherwise from the station on where the stretch before its stop line begins:
/// each edge is painted along one lane, that to its right where one is.
fn markings(
    road: &Road,
    country: Option<&str>,
    edge: usize,
    (strip, backward): (usize, bool),
    begin: Option<f64>,
) -> Vec<Marking> {
    let paints =
        driven(&road.section).filter(|(other, _)| [*other, *other + 1].contains(&edge)).max_by_key(|at| (at.0, !at.1));
    if paints != Some((strip, backward)) {
        return Vec::new();
    }
    let marking = |station: f64, attributes: &Attributes| Marking { station, kinds: vec![kind(attributes, backward)] };
    let whole = marking(0.0, &along(&road.section, edge, &road.tags, country, false));
    let last = begin.and_then(|begin| Some((begin, before_stop(&road.section, edge, &road.tags, false)?)));
    [whole].into_iter().chain(last.map(|(begin, attributes)| marking(begin, &attributes))).collect()
}

/// What the tags of a border say, seen against its direction or along it.
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
        let weave = LaneStitching::new(lanes);
        let strokes = weave.iter().flat_map(|(_, lane)| lane.strokes().iter());
        let between = strokes.filter(|stroke| stroke.kind == Kind::Solid(Paint::White));
        let length = |line: &[Point]| line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
        let before_stop = between.filter(|stroke| (length(stroke.line) - 30.0).abs() < 1e-3);
        let solid = before_stop.count();
        assert_eq!(solid, 4, "one line of each approach");
    }
}
