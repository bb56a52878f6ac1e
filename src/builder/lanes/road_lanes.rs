//! The lanes of every road between its connection lines: borders as shared lines, lanelets between them.

use crate::builder::map::map_builder::{MapBuilder, MapPart};
use crate::builder::network::road_end::{inward, lanes_at, on_cut};
use crate::builder::network::{End, Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::cross_section::{CrossSection, StripKind, Travel};
use crate::builder::tags::marking::SHARES;
use crate::builder::tags::side_strips::strip_runs;
use crate::geometry::pose::Pose;
use crate::lanelet::{Attributes, Bound, PointId};
use crate::parallel::Finely;

use super::border::borders;
use super::road_continuation::Continuations;
use super::road_cut::ConnectionLines;
use super::types::{Arm, ArmLane, Lanes, RoadLane, RoadPiece};

use compact_str::ToCompactString;
use rayon::prelude::*;

/// A cut closer than this, metres, to the end of the road's line tells no more than the road's own direction there.
const LEAST_AIM: f64 = 2.0;

/// The tag of a bus lane that bicycles may use.
pub const ADMITS_BICYCLES: &str = "participant:bicycle";

/// Roads whose lanes one thread draws at a time.
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
    let all: Vec<RoadIx> = (0..network.roads.len()).map(|i| RoadIx::new(i)).collect();
    let drawn = |below: &MapBuilder, roads: &[RoadIx]| {
        let mut part = MapBuilder::over(below);
        let kept = |ix: &RoadIx| lines.kept[*ix];
        let drawn: Vec<RoadDrawing> =
            roads.iter().map(|ix| road_lanes(&mut part, network, *ix, kept(ix), joins)).collect();
        (part.into_part(), drawn)
    };
    let parts: Vec<_> = all.par_chunks(CHUNK).finely().map(|roads| drawn(assembly, roads)).collect();
    let (parts, mut of_roads): (Vec<MapPart>, Vec<Vec<RoadDrawing>>) = parts.into_iter().unzip();
    if let Err(parts) = assembly.add_all(parts) {
        assembly.require_unique_ids();
        for ((part, of_roads), roads) in parts.into_iter().zip(&mut of_roads).zip(all.chunks(CHUNK)) {
            if assembly.add(part).is_err() {
                // A part before has taken one of its ids: it is drawn once more, over all that stands.
                let again = drawn(assembly, roads);
                let _ = assembly.add(again.0);
                *of_roads = again.1;
            }
        }
    }
    let mut lanes = Lanes::default();
    lanes.lanes.reserve_exact(of_roads.iter().flatten().map(|road| road.lanes.len()).sum());
    lanes.arms.reserve_exact(all.len());
    lanes.pieces.reserve_exact(all.len());
    for mut road in of_roads.into_iter().flatten() {
        road.begin_at(lanes.lanes.len());
        lanes.lanes.extend(road.lanes);
        lanes.arms.push(road.arms);
        lanes.pieces.push(vec![road.whole]);
    }
    assembly.set_ground(Ground::default());
    lanes
}

/// Gives back the ids of the lanes of some roads, and of their nodes but for those that they share with others.
pub fn release(assembly: &mut MapBuilder, joins: &Continuations, lanes: &Lanes, roads: impl Iterator<Item = RoadIx>) {
    let shared = joins.points();
    for ix in roads {
        for bound in lanes.pieces[ix].iter().flat_map(|piece| &piece.borders).flatten() {
            assembly.release_line(bound.line, |point| shared.contains(&point));
        }
        lanes.of_road(ix).iter().for_each(|lane| assembly.release_lanelet(lane.lanelet));
    }
}

/// Builds the lanes of some roads once more, whose cuts have moved. All elements keep their ids.
pub fn redraw(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lines: &ConnectionLines,
    joins: &mut Continuations,
    lanes: &mut Lanes,
    roads: &[RoadIx],
) {
    release(assembly, joins, lanes, roads.iter().copied());
    joins.add_points(assembly, network);
    for &ix in roads {
        let (i, range) = (ix.position(), lanes.range_of(ix));
        let mut road = road_lanes(assembly, network, ix, lines.kept[i], joins);
        road.begin_at(range.start);
        lanes.lanes.splice(range, road.lanes);
        lanes.arms[i] = road.arms;
        lanes.pieces[i] = vec![road.whole];
    }
    assembly.set_ground(Ground::default());
}

/// What is drawn of one road.
struct RoadDrawing {
    lanes: Vec<RoadLane>,
    /// With indices in `lanes`.
    arms: [Arm; 2],
    whole: RoadPiece,
}

impl RoadDrawing {
    /// Lets the arms refer to the lanes of all roads, among which these begin at an index.
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
    kept: Stations,
    joins: &Continuations,
) -> RoadDrawing {
    let road = network.road(ix);
    assembly.set_ground(Ground::under(road));
    let used = used_edges(&road.section);
    let nodes = End::BOTH.map(|end| end_nodes(assembly, (road, ix), end, kept[end], &used, joins));
    let borders = borders(assembly, road, network.country.as_deref(), kept, &nodes);
    let mut lanes = Vec::new();
    road_lanelets(assembly, road, ix, &borders, &mut lanes);
    let arms = End::BOTH.map(|end| {
        let at = RoadEnd { road: ix, end };
        arm(assembly, road, at, kept[end], &nodes[end], &lanes)
    });
    RoadDrawing { lanes, arms, whole: RoadPiece { behind: None, span: kept, borders } }
}

/// Which edges of the cross-section bound a driven strip, or a lanelet beside them, or are a kerb.
fn used_edges(section: &CrossSection) -> Vec<bool> {
    let mut used = vec![false; section.strips.len() + 1];
    for run in strip_runs(section) {
        used[run.strips.start] = true;
        used[run.strips.end] = true;
    }
    for (i, _) in section.driven() {
        used[i] = true;
        used[i + 1] = true;
    }
    let (left, right) = section.carriageway();
    used[left] = true;
    used[right] = true;
    used
}

/// The nodes on a cut by edge of the cross-section; `None` where nothing ends.
fn end_nodes(
    assembly: &mut MapBuilder,
    (road, ix): (&Road, RoadIx),
    end: End,
    station: f64,
    used: &[bool],
    joins: &Continuations,
) -> Vec<Option<PointId>> {
    let key = road.key_of("road end").number(end.index() as i64);
    used.iter()
        .enumerate()
        .map(|(edge, used)| {
            used.then(|| {
                joins.point(RoadEnd { road: ix, end }, edge).unwrap_or_else(|| {
                    let place = on_cut(road, end, station, road.section.edge(edge));
                    assembly.point(key.number(edge as i64), place, 0.0)
                })
            })
        })
        .collect()
}

/// Adds the lanelets of a road, strip by strip.
fn road_lanelets(
    assembly: &mut MapBuilder,
    road: &Road,
    ix: RoadIx,
    borders: &[Option<Bound>],
    lanes: &mut Vec<RoadLane>,
) {
    for (i, strip) in road.section.driven() {
        let (Some(left), Some(right)) = (borders[i], borders[i + 1]) else { continue };
        let ways = match strip.travel {
            Travel::Forward => [true, false],
            Travel::Backward => [false, true],
            Travel::Both => [true, true],
        };
        for (backward, used) in [false, true].into_iter().zip(ways) {
            if !used {
                continue;
            }
            let turned = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
            let (left, right) = if backward { (turned(right), turned(left)) } else { (left, right) };
            let key = road.key_of("lane").number(i as i64).number(i64::from(backward));
            let mut attributes = road_attributes(road, strip.kind, road.speed[usize::from(backward)]);
            if shares_bus_lane(road, i) {
                attributes.push(ADMITS_BICYCLES, "yes");
            }
            attributes.push("road_id", crate::osm::Text::from(road.key.to_string()));
            let known = [("road_name", road.name.as_deref()), ("road_surface", road.tags.get("surface"))];
            for (key, value) in known.into_iter().filter_map(|(key, value)| Some((key, value?))) {
                attributes.push(key, crate::osm::Text::from(value));
            }
            let lanelet = assembly.lanelet(key, left, right, attributes);
            lanes.push(RoadLane { road: ix, strip: i, backward, lanelet, left, right, kind: strip.kind });
        }
    }
}

/// Whether a strip is a bus lane that bicycles may use: the bus lanes in the half of the carriageway of which
/// `cycleway=share_busway` tells.
fn shares_bus_lane(road: &Road, strip: usize) -> bool {
    let section = &road.section;
    let left = section.edge(strip) + section.edge(strip + 1) > 0.0;
    let keys = ["cycleway", "cycleway:both", if left { "cycleway:left" } else { "cycleway:right" }];
    section.strips[strip].kind == StripKind::Bus && keys.iter().any(|key| road.tags.is(key, SHARES))
}

/// So many bytes the tags of a way through an intersection take in the end, and hardly those of a lane fewer.
const USUAL_TAGS: usize = 176;

/// Tags of a vehicle lanelet.
pub fn road_attributes(road: &Road, kind: StripKind, speed: f64) -> Attributes {
    let location = if road.public { "urban" } else { "private" };
    // No lane of a car's graph, which holds what `road` names.
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
    station: f64,
    nodes: &[Option<PointId>],
    lanes: &[RoadLane],
) -> Arm {
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
        let ends = if backward { [b, a] } else { [a, b] };
        let [left, right] = ends.map(|id| assembly.position(id));
        let strip = &road.section.strips[lane_at.strip];
        let heading = if lane_at.into { arm.inward } else { -arm.inward };
        let placed = ArmLane {
            lane,
            nodes: ends,
            places: [left, right],
            pose: Pose { point: nalgebra::center(&left, &right), heading },
            width: (left - right).norm(),
            kind: strip.kind,
            arrows: strip.arrows,
        };
        if lane_at.into { arm.into.push(placed) } else { arm.out.push(placed) }
    }
    // Looking in, the lanes that lead out are seen from their front: their own left is our right.
    arm.out.reverse();
    arm
}
