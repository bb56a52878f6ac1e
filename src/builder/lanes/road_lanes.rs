//! The lanes of every road between its connection lines: shared borders and the lanelets between them.

use crate::builder::map::map_builder::{MapBuilder, MapPart};
use crate::builder::network::road_end::{inward, lanes_at, on_cut};
use crate::builder::network::{End, Road, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::cross_section::{CrossSection, StripKind, Travel};
use crate::builder::tags::marking::SHARES;
use crate::builder::tags::side_strips::strip_runs;
use crate::geometry::{Point, Vector};
use crate::lanelet::index::{center_line, tangent};
use crate::lanelet::{Attributes, Bound, PointId};
use crate::osm::Text;
use crate::parallel::InSmallParts;

use super::border::borders;
use super::road_continuation::Continuations;
use super::road_cut::{ConnectionLines, RoadCut};
use super::types::{Arm, ArmLane, Lanes, RoadLane, RoadPiece};

use compact_str::ToCompactString;
use rayon::prelude::*;

/// A cut closer than this, metres, to the end of the road's line has the direction of the road for its aim.
const LEAST_AIM: f64 = 2.0;

/// Length of a lane, metres, up to which it may begin and end in other directions than its road at its cuts.
const SHORT: f64 = 4.0;

/// The tag of a bus lane that bicycles may use.
pub const ADMITS_BICYCLES: &str = "participant:bicycle";

/// Number of roads whose lanes one thread draws at a time.
const CHUNK: usize = 128;

/// Builds the lanes of all roads.
pub fn lanes(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lines: &ConnectionLines,
    joins: &mut Continuations,
) -> Lanes {
    joins.add_points(assembly, network);
    let joins = &*joins;
    let all: Vec<RoadIx> = (0..network.roads.len()).map(RoadIx::new).collect();
    let draw = |below: &MapBuilder, roads: &[RoadIx]| {
        let mut part = MapBuilder::over(below);
        let drawn: Vec<RoadDrawing> =
            roads.iter().map(|&ix| road_lanes(&mut part, network, ix, lines.cut(ix), joins)).collect();
        (part.into_part(), drawn)
    };
    let parts: Vec<_> = all.par_chunks(CHUNK).in_small_parts().map(|roads| draw(assembly, roads)).collect();
    let (parts, of_roads): (Vec<MapPart>, Vec<Vec<RoadDrawing>>) = parts.into_iter().unzip();
    assembly.add_all(parts);
    let mut lanes = Lanes::default();
    lanes.lanes.reserve_exact(of_roads.iter().flatten().map(|road| road.lanes.len()).sum());
    lanes.arms.reserve_exact(all.len());
    lanes.pieces.reserve_exact(all.len());
    for mut road in of_roads.into_iter().flatten() {
        road.begin_at(lanes.lanes.len());
        lanes.lanes.extend(road.lanes);
        lanes.arms.push(road.arms);
        lanes.pieces.push(vec![road.piece]);
    }
    assembly.set_ground(Ground::default());
    lanes
}

/// Builds the lanes of some roads again after their cuts have moved. All elements keep their ids.
pub fn redraw(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lines: &ConnectionLines,
    joins: &mut Continuations,
    lanes: &mut Lanes,
    roads: &[RoadIx],
) {
    joins.add_points(assembly, network);
    for &ix in roads {
        let range = lanes.range_of(ix);
        let mut road = road_lanes(assembly, network, ix, lines.cut(ix), joins);
        road.begin_at(range.start);
        lanes.move_behind(ix, range.len(), road.lanes.len());
        lanes.lanes.splice(range, road.lanes);
        lanes.arms[ix] = road.arms;
        lanes.pieces[ix] = vec![road.piece];
    }
    assembly.set_ground(Ground::default());
}

/// The drawn lanes of one road.
struct RoadDrawing {
    lanes: Vec<RoadLane>,
    /// With indices in `lanes`.
    arms: [Arm; 2],
    piece: RoadPiece,
}

impl RoadDrawing {
    /// Makes the arms refer to the lanes of all roads, among which these begin at `first`.
    fn begin_at(&mut self, first: usize) {
        let ends = self.arms.iter_mut().flat_map(|arm| arm.into.iter_mut().chain(&mut arm.out));
        ends.for_each(|end| end.lane += first);
    }
}

/// The lanes of one road between its cuts.
fn road_lanes(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    ix: RoadIx,
    cut: &RoadCut,
    joins: &Continuations,
) -> RoadDrawing {
    let (road, kept) = (network.road(ix), cut.kept);
    assembly.set_ground(Ground::under(road));
    let used = used_edges(&road.section);
    let ends = End::BOTH.map(|end| RoadEnd { road: ix, end });
    let nodes = ends.map(|at| end_nodes(assembly, road, at, kept[at.end], &used, joins));
    let borders = borders(assembly, road, network.country.as_deref(), kept, &nodes);
    let lanes = road_lanelets(assembly, road, ix, &borders);
    let arms = ends.map(|at| arm(assembly, road, at, cut, &nodes[at.end], &lanes));
    RoadDrawing { lanes, arms, piece: RoadPiece { behind: None, span: kept, borders } }
}

/// Which edges of the cross-section bound a driven strip or a side lane, or are a kerb.
fn used_edges(section: &CrossSection) -> Vec<bool> {
    let mut used = vec![false; section.strips.len() + 1];
    let side_lanes = strip_runs(section).into_iter().map(|run| (run.strips.start, run.strips.end));
    let lanes = section.driven().map(|(strip, _)| (strip, strip + 1));
    for (left, right) in side_lanes.chain(lanes).chain([section.carriageway()]) {
        (used[left], used[right]) = (true, true);
    }
    used
}

/// The nodes on a cut by edge of the cross-section; `None` where nothing ends.
fn end_nodes(
    assembly: &mut MapBuilder,
    road: &Road,
    at: RoadEnd,
    station: f64,
    used: &[bool],
    joins: &Continuations,
) -> Vec<Option<PointId>> {
    let key = road.key_of("road end").number(at.end.index() as i64);
    let mut node = |edge: usize| {
        let place = || on_cut(road, at.end, station, road.section.edge(edge));
        joins.point(at, edge).unwrap_or_else(|| assembly.point(key.number(edge as i64), place(), 0.0))
    };
    used.iter().enumerate().map(|(edge, used)| used.then(|| node(edge))).collect()
}

/// The bounds of a lanelet between two borders along the road's line, in its direction of travel.
pub(super) fn directed([left, right]: [Bound; 2], backward: bool) -> [Bound; 2] {
    let reversed = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
    if backward { [reversed(right), reversed(left)] } else { [left, right] }
}

/// Adds the lanelets of a road, strip by strip.
fn road_lanelets(assembly: &mut MapBuilder, road: &Road, ix: RoadIx, borders: &[Option<Bound>]) -> Vec<RoadLane> {
    let mut lanes = Vec::new();
    for (i, strip) in road.section.driven() {
        let (Some(left), Some(right)) = (borders[i], borders[i + 1]) else { continue };
        let directions: &[bool] = match strip.travel {
            Travel::Forward => &[false],
            Travel::Backward => &[true],
            Travel::Both => &[false, true],
        };
        for &backward in directions {
            let [left, right] = directed([left, right], backward);
            let key = road.key_of("lane").number(i as i64).number(i64::from(backward));
            let lanelet = assembly.lanelet(key, left, right, lane_attributes(road, i, backward));
            lanes.push(RoadLane { road: ix, strip: i, backward, lanelet, left, right });
        }
    }
    lanes
}

/// Tags of the lanelet of a strip in one direction.
fn lane_attributes(road: &Road, strip: usize, backward: bool) -> Attributes {
    let own = &road.section.strips[strip];
    let speed = own.speed.unwrap_or(road.speed[usize::from(backward)]);
    let mut attributes = road_attributes(road, own.kind, speed);
    if is_shared_bus_lane(road, strip) {
        attributes.push(ADMITS_BICYCLES, "yes");
    }
    attributes.push("road_id", Text::from(road.key.to_string()));
    for (key, value) in [("road_name", road.name.as_deref()), ("road_surface", road.tags.get("surface"))] {
        if let Some(value) = value {
            attributes.push(key, Text::from(value));
        }
    }
    attributes
}

/// Whether a strip is a bus lane that bicycles may use: by its own tags, or `cycleway=share_busway` on its half of the carriageway.
fn is_shared_bus_lane(road: &Road, strip: usize) -> bool {
    let section = &road.section;
    let left = section.edge(strip) + section.edge(strip + 1) > 0.0;
    let keys = ["cycleway", "cycleway:both", if left { "cycleway:left" } else { "cycleway:right" }];
    let by_cycleway = || keys.iter().any(|key| road.tags.is(key, SHARES));
    section.strips[strip].kind == StripKind::Bus && (section.strips[strip].bicycles || by_cycleway())
}

/// Bytes that the tags of a lanelet usually take.
const USUAL_TAGS: usize = 176;

/// Tags of a vehicle lanelet; `speed` is in km/h.
pub fn road_attributes(road: &Road, kind: StripKind, speed: f64) -> Attributes {
    let location = if road.public { "urban" } else { "private" };
    // The routing graph of cars holds the lanelets of subtype `road`.
    let (subtype, participant) = match kind {
        StripKind::Bus => ("bus_lane", "participant:vehicle:bus"),
        _ => ("road", "participant:vehicle"),
    };
    let mut attributes = Attributes::with_room(USUAL_TAGS);
    let known = [("type", "lanelet"), ("subtype", subtype), ("location", location), ("one_way", "yes")];
    known.into_iter().for_each(|(key, value)| attributes.push(key, value));
    attributes.push("speed_limit", (speed.round().clamp(5.0, 130.0) as u8).to_compact_string());
    attributes.push(participant, "yes");
    attributes
}

/// The arm at one end of a road.
fn arm(
    assembly: &MapBuilder,
    road: &Road,
    at: RoadEnd,
    cut: &RoadCut,
    nodes: &[Option<PointId>],
    lanes: &[RoadLane],
) -> Arm {
    let station = cut.kept[at.end];
    let inward = inward(road, at.end, station);
    let inside = road.place(at.end) - road.line.at(station);
    let ends = lanes_at(&road.section, at.end);
    let leading_in = ends.iter().filter(|lane| lane.into).count();
    let mut arm = Arm {
        at,
        inward,
        aim: inside.try_normalize(LEAST_AIM).unwrap_or(inward),
        into: Vec::with_capacity(leading_in),
        out: Vec::with_capacity(ends.len() - leading_in),
        cut: nodes.iter().flatten().copied().collect(),
    };
    if at.end == End::End {
        arm.cut.reverse();
    }
    for lane_at in ends {
        let backward = lane_at.into == (at.end == End::Start);
        let found = lanes.iter().position(|l| l.strip == lane_at.strip && l.backward == backward);
        let (Some(lane), Some(a), Some(b)) = (found, nodes[lane_at.strip], nodes[lane_at.strip + 1]) else { continue };
        let nodes = if backward { [b, a] } else { [a, b] };
        let strip = &road.section.strips[lane_at.strip];
        let (list, heading) = if lane_at.into { (&mut arm.into, inward) } else { (&mut arm.out, -inward) };
        let heading =
            lanes.get(lane).and_then(|lane| heading_of_short(assembly, lane, lane_at.into)).unwrap_or(heading);
        let end = ArmLane::new(assembly, lane, nodes, heading, strip.kind);
        list.push(ArmLane { arrows: strip.arrows, straight: cut.straight[at.end], ..end });
    }
    // From left to right in their own direction of travel.
    arm.out.reverse();
    arm
}

/// The unit direction at the end of a lane, or at its begin where it leads out of an intersection, as the lanelet is read.
/// `None` for a lane that is long enough to take up the direction of its road.
fn heading_of_short(assembly: &MapBuilder, lane: &RoadLane, leads_in: bool) -> Option<Vector> {
    let [left, right] = [lane.left, lane.right].map(|bound| assembly.bound_line(bound));
    let long = |bound: &[Point]| bound.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>() > SHORT;
    if long(&left) && long(&right) {
        return None;
    }
    let center = center_line(&left, &right).filter(|center| center.length() <= SHORT)?;
    if leads_in { tangent(&center.reversed()).map(|back| -back) } else { tangent(&center) }
}
