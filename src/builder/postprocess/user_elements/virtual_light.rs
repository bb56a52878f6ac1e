//! Virtual traffic lights: where vehicles ask an infrastructure for leave to cross, each lane of the approach gets the
//! lines between which they ask, wait and hold the intersection.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::control::LIGHT_HEIGHT;
use crate::builder::ids::Key;
use crate::builder::postprocess::cross_line::{LaneletEnds, cross_line};
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::polygon;
use crate::lanelet::index::{Edge, MapIndex, Traffic};
use crate::lanelet::{Attributes, LaneletId, LineStringId, PointId, Target};
use crate::osm::Text;
use crate::settings::VirtualLightSettings;

use super::right_of_way;
use super::stop_line::drivable;

/// Vehicles ask for leave so far, metres, before the stop line where the settings do not tell: enough to stop gently
/// from 50 km/h.
const START: f64 = 50.0;
/// The start line lies at least this far, metres, before the stop line.
const ROOM: f64 = 2.0;
/// It lies at least this far, metres, behind where the road begins.
const MARGIN: f64 = 0.5;

/// The light of one lane, before it is drawn.
pub struct VirtualLight {
    /// The lanelets that begin at its stop line.
    carriers: Vec<LaneletId>,
    start: LaneletEnds,
    stop: Edge,
    /// The line that is there already.
    stop_line: Option<LineStringId>,
    /// Where the carriers end.
    ends: Vec<[PointId; 2]>,
    /// Per carrier all that it conflicts with.
    conflicts: Vec<(LaneletId, Vec<LaneletId>)>,
    tags: BTreeMap<String, String>,
}

/// The lights of one intersection.
#[derive(Default)]
pub struct VirtualLights {
    /// To be drawn.
    pub lights: Vec<VirtualLight>,
    /// The approaches that have some, by position.
    taken: BTreeSet<usize>,
}

impl VirtualLights {
    /// Adds a light for each lane of an approach, or says why there is none.
    pub fn add(&mut self, map: &MapIndex, at: usize, wanted: &VirtualLightSettings) -> Result<(), String> {
        let traffic = &map.traffic[at];
        let arms = map.approaches_named(at, &wanted.approach);
        let leads_in = |arm: &usize| drivable(map, traffic).any(|movement| movement.from == *arm);
        let arms: Vec<usize> = arms.into_iter().filter(leads_in).collect();
        if arms.is_empty() {
            let sides = map.intersections[at].arms.iter().enumerate().filter(|(arm, _)| leads_in(arm));
            let sides: Vec<&str> = sides.map(|(_, arm)| arm.compass).collect();
            return Err(format!("no lane leads in from {}; there are {}", wanted.approach, sides.join(", ")));
        }
        let lit = |arm: &usize| drivable(map, traffic).any(|one| one.from == *arm && one.mover.signalised);
        if arms.iter().any(lit) {
            return Err(format!(
                "traffic lights rule {}; take them out of the input where an infrastructure gives leave instead",
                wanted.approach
            ));
        }
        if arms.iter().any(|arm| self.taken.contains(arm)) {
            return Err(format!("{} has virtual traffic lights already", wanted.approach));
        }
        let lights: Vec<VirtualLight> = of_lanes(map, traffic, &arms)
            .into_iter()
            .map(|lanes| light(map, &lanes, wanted))
            .collect::<Result<_, _>>()?;
        self.lights.extend(lights);
        self.taken.extend(arms);
        Ok(())
    }
}

/// Whether a line runs from one of two points to the other.
fn lies_on(map: &MapIndex, way: LineStringId, ends: [PointId; 2]) -> bool {
    let points = map.map.linestrings.get(way).map_or(&[][..], |line| &line.points);
    points == ends || points == [ends[1], ends[0]]
}

/// The lanes of the intersection, by position, that begin at each lane of some approaches.
fn of_lanes(map: &MapIndex, traffic: &Traffic, arms: &[usize]) -> Vec<Vec<usize>> {
    let mut lanes: Vec<Vec<usize>> = Vec::new();
    for movement in drivable(map, traffic).filter(|movement| arms.contains(&movement.from)) {
        let begins = map.lanes[movement.lane].start.ids;
        match lanes.iter_mut().find(|lanes| map.lanes[lanes[0]].start.ids == begins) {
            Some(lanes) => lanes.push(movement.lane),
            None => lanes.push(vec![movement.lane]),
        }
    }
    lanes
}

/// The light of the lanes that begin at one stop line.
fn light(map: &MapIndex, lanes: &[usize], wanted: &VirtualLightSettings) -> Result<VirtualLight, String> {
    let first = &map.lanes[lanes[0]];
    let start = start_line(map, lanes[0], wanted.start)
        .map_err(|why| format!("{why} before lanelet {}, where it would begin", first.id))?;
    let mut ends: Vec<[PointId; 2]> = lanes.iter().map(|&lane| map.lanes[lane].end.ids).collect();
    ends.sort_unstable();
    ends.dedup();
    Ok(VirtualLight {
        carriers: lanes.iter().map(|&lane| map.lanes[lane].id).collect(),
        start,
        stop: first.start,
        stop_line: map.stop_line_of(lanes[0]).map(|line| line.way).filter(|way| lies_on(map, *way, first.start.ids)),
        ends,
        conflicts: lanes.iter().map(|&lane| (map.lanes[lane].id, conflicts(map, lane))).collect(),
        tags: wanted.tags.clone(),
    })
}

/// Across the one way that leads to a lane: as far before it as is wanted, or as that way reaches where nothing is.
fn start_line(map: &MapIndex, lane: usize, wanted: Option<f64>) -> Result<LaneletEnds, String> {
    let before = |at: usize| match map.predecessors(at) {
        [before] if map.intersections_of(*before).is_empty() && map.lanes[*before].vehicle => Some(*before),
        _ => None,
    };
    let mut at = before(lane).ok_or("no single lane leads on")?;
    let mut ahead = map.lanes[at].length();
    while ahead < wanted.unwrap_or(START) + MARGIN
        && let Some(next) = before(at)
    {
        at = next;
        ahead += map.lanes[at].length();
    }
    let back = wanted.unwrap_or(START.min(ahead - ROOM));
    if back < ROOM || back > ahead - MARGIN {
        let most = (ahead - ROOM).max(0.0);
        return Err(format!("there are {ahead:.0} m of road, so that `start` is {most:.0} at most,"));
    }
    cross_line(&map.lanes[at], (ahead - back).min(map.lanes[at].length())).ok_or("no lane has a middle".to_owned())
}

/// All lanes of vehicles that a lane meets, those that begin with it included, unless they are its neighbours.
fn conflicts(map: &MapIndex, lane: usize) -> Vec<LaneletId> {
    let own = &map.lanes[lane];
    let crossed = map.conflicts[lane].iter().filter(|conflict| !conflict.grade_separated);
    let together = map.siblings(lane).filter(|&other| {
        let other = &map.lanes[other];
        let beside = own.bounds.iter().any(|way| other.bounds.contains(way));
        let area = polygon::overlap(&own.outline, &other.outline);
        !beside && (area >= map.thresholds.real_area || area >= map.thresholds.real_share * own.area)
    });
    let all = crossed.map(|conflict| conflict.other).chain(together);
    let all: BTreeSet<usize> = all.filter(|&other| map.lanes[other].vehicle).collect();
    all.into_iter().map(|other| map.lanes[other].id).collect()
}

/// End lines that are drawn, by the nodes where their lanelets end.
pub type EndLines = BTreeMap<[PointId; 2], LineStringId>;

/// Draws a light with all its lines, and lets its lanelets yield to nobody whom it holds back.
pub fn draw(pen: &mut MapEditor, drawn: &mut EndLines, light: VirtualLight) {
    let VirtualLight { carriers, start, stop, stop_line, ends, conflicts, tags: known } = light;
    let key = Key::new("virtual light").number(stop.ids[0].0).number(stop.ids[1].0);
    let start = start_of(pen, key.word("start"), start);
    let stop_line = stop_line.unwrap_or_else(|| {
        pen.line(key.word("stop"), stop.ids.to_vec(), Attributes::of(&[("type", "stop_line"), ("subtype", "solid")]))
    });
    let anchor = anchor_of(pen, key.word("anchor"), &stop, known);
    let mut members = vec![("start_line", Target::LineString(start)), ("ref_line", Target::LineString(stop_line))];
    members.extend(ends.into_iter().map(|nodes| ("end_line", Target::LineString(end_of(pen, drawn, nodes)))));
    members.push(("refers", Target::LineString(anchor)));
    pen.element(key, "virtual_traffic_light", members, &carriers);
    for (lane, others) in conflicts.into_iter().filter(|(_, others)| !others.is_empty()) {
        // Leave to drive is all that it waits for.
        right_of_way::amend(pen, lane, &[], &others);
    }
}

fn start_of(pen: &mut MapEditor, key: Key, ends: LaneletEnds) -> LineStringId {
    let nodes = ["left", "right"].into_iter().zip(ends).map(|(side, (bound, place))| {
        let ele = pen.height(bound, place);
        pen.point(key.word(side), place, ele)
    });
    let nodes = nodes.collect();
    pen.line(key, nodes, Attributes::of(&[("type", "virtual")]))
}

/// Lanelets that leave by one lane share its line.
fn end_of(pen: &mut MapEditor, drawn: &mut EndLines, nodes: [PointId; 2]) -> LineStringId {
    let key = Key::new("virtual light end").number(nodes[0].0).number(nodes[1].0);
    *drawn.entry(nodes).or_insert_with(|| pen.line(key, nodes.to_vec(), Attributes::of(&[("type", "virtual")])))
}

/// What stands for the infrastructure: a line above the stop line, with the tags by which it is known.
fn anchor_of(pen: &mut MapEditor, key: Key, stop: &Edge, known: BTreeMap<String, String>) -> LineStringId {
    let ele = |id: PointId| pen.map.points.get(id).and_then(|point| point.ele()).unwrap_or_default();
    let ele = (ele(stop.ids[0]) + ele(stop.ids[1])) / 2.0 + LIGHT_HEIGHT;
    let places = [0.25, 0.75].map(|part| stop.points[0] + stop.across() * part);
    let nodes = ["left", "right"].into_iter().zip(places).map(|(side, place)| pen.point(key.word(side), place, ele));
    let nodes = nodes.collect();
    let mut attributes = Attributes::of(&[("type", "intersection_coordination")]);
    for (name, value) in &known {
        attributes.set(name, Text::from(value.as_str()));
    }
    pen.line(key, nodes, attributes)
}
