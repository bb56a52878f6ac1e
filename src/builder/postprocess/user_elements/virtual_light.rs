//! Virtual traffic lights: vehicles ask an infrastructure for permission to cross. Each lane of the approach gets a start line
//! where they ask, a stop line where they wait, and end lines where they release the intersection.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::control::vehicle_signals::LIGHT_HEIGHT;
use crate::builder::ids::Key;
use crate::builder::postprocess::cross_line::{LaneletEnds, cross_line};
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::polygon;
use crate::lanelet::index::{Edge, MapIndex, Movement, Traffic};
use crate::lanelet::{Attributes, LaneletId, LineStringId, PointId, Target};
use crate::osm::Text;
use crate::settings::VirtualLightSettings;

use super::right_of_way_edit;
use super::stop_line::drivable;
use crate::lanelet::index::thresholds;

/// The default distance, metres, from the start line to the stop line: a comfortable stop from 50 km/h.
const DEFAULT_START: f64 = 50.0;
/// The smallest distance, metres, from the start line to the stop line.
const MIN_START: f64 = 2.0;
/// The smallest distance, metres, from the start of the road to the start line.
const MARGIN: f64 = 0.5;

/// The light of one lane of an approach.
pub struct VirtualLight {
    /// The lanelets that begin at the stop line.
    carriers: Vec<LaneletId>,
    start: LaneletEnds,
    stop: Edge,
    /// The stop line that the map has there.
    stop_line: Option<LineStringId>,
    /// The points at which the carriers end.
    ends: Vec<[PointId; 2]>,
    /// For each carrier, the lanelets that it conflicts with.
    conflicts: Vec<(LaneletId, Vec<LaneletId>)>,
    tags: BTreeMap<String, String>,
}

/// The lights of one intersection.
#[derive(Default)]
pub struct VirtualLights {
    /// The lights to draw.
    pub lights: Vec<VirtualLight>,
    /// The arms that have lights, by index.
    taken: BTreeSet<usize>,
}

impl VirtualLights {
    /// Adds a light for each lane of an approach.
    ///
    /// # Errors
    ///
    /// The approach cannot have a virtual light; the text says why.
    pub fn add(&mut self, map: &MapIndex, intersection: usize, settings: &VirtualLightSettings) -> Result<(), String> {
        let traffic = &map.traffic[intersection];
        let arms = map.approaches_named(intersection, &settings.approach);
        let leads_in = |arm: &usize| drivable(map, traffic).any(|movement| movement.from == *arm);
        let arms: Vec<usize> = arms.into_iter().filter(leads_in).collect();
        if arms.is_empty() {
            let others = map.intersections[intersection].arms.iter().enumerate().filter(|(arm, _)| leads_in(arm));
            let others: Vec<&str> = others.map(|(_, arm)| arm.compass).collect();
            return Err(format!("no lane leads in from {}; there are {}", settings.approach, others.join(", ")));
        }
        let signalised = |movement: &Movement| arms.contains(&movement.from) && movement.ranked.signalised;
        if drivable(map, traffic).any(signalised) {
            return Err(format!(
                "traffic lights rule {}; take them out of the input where an infrastructure gives leave instead",
                settings.approach
            ));
        }
        if arms.iter().any(|arm| self.taken.contains(arm)) {
            return Err(format!("{} has virtual traffic lights already", settings.approach));
        }
        let lanes = approach_lanes(map, traffic, &arms).into_iter();
        let lights: Result<Vec<_>, String> = lanes.map(|lanes| light(map, &lanes, settings)).collect();
        self.lights.extend(lights?);
        self.taken.extend(arms);
        Ok(())
    }
}

/// Whether a linestring joins two points.
fn joins(map: &MapIndex, line: LineStringId, ends: [PointId; 2]) -> bool {
    let points = map.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
    points == ends || points == [ends[1], ends[0]]
}

/// For each lane of some arms, the lanes of the intersection that begin there, by index.
fn approach_lanes(map: &MapIndex, traffic: &Traffic, arms: &[usize]) -> Vec<Vec<usize>> {
    let mut lanes: Vec<Vec<usize>> = Vec::new();
    for movement in drivable(map, traffic).filter(|movement| arms.contains(&movement.from)) {
        let start = map.lanes[movement.lane].start.ids;
        match lanes.iter_mut().find(|lanes| map.lanes[lanes[0]].start.ids == start) {
            Some(lanes) => lanes.push(movement.lane),
            None => lanes.push(vec![movement.lane]),
        }
    }
    lanes
}

/// The light of the lanes that begin at one stop line.
fn light(map: &MapIndex, lanes: &[usize], settings: &VirtualLightSettings) -> Result<VirtualLight, String> {
    let first = &map.lanes[lanes[0]];
    let start = start_line(map, lanes[0], settings.start)
        .map_err(|why| format!("{why} before lanelet {}, where it would begin", first.id))?;
    let mut ends: Vec<[PointId; 2]> = lanes.iter().map(|&lane| map.lanes[lane].end.ids).collect();
    ends.sort_unstable();
    ends.dedup();
    Ok(VirtualLight {
        carriers: lanes.iter().map(|&lane| map.lanes[lane].id).collect(),
        start,
        stop: first.start,
        stop_line: map.stop_line_of(lanes[0]).map(|line| line.way).filter(|way| joins(map, *way, first.start.ids)),
        ends,
        conflicts: lanes.iter().map(|&lane| (map.lanes[lane].id, conflicts(map, lane))).collect(),
        tags: settings.tags.clone(),
    })
}

/// The start line across the road before a lane: `distance` metres before it, or the default if the road is long enough.
fn start_line(map: &MapIndex, lane: usize, distance: Option<f64>) -> Result<LaneletEnds, String> {
    let mut road = road_before(map, lane).ok_or("no single lane leads on")?;
    let mut length = map.lanes[road].length();
    while length < distance.unwrap_or(DEFAULT_START) + MARGIN
        && let Some(before) = road_before(map, road)
    {
        road = before;
        length += map.lanes[road].length();
    }
    let distance = distance.unwrap_or(DEFAULT_START.min(length - MIN_START));
    if distance < MIN_START || distance > length - MARGIN {
        let most = (length - MIN_START).max(0.0);
        return Err(format!("there are {length:.0} m of road, so that `start` is {most:.0} at most,"));
    }
    let station = (length - distance).min(map.lanes[road].length());
    cross_line(&map.lanes[road], station).ok_or("no lane has a middle".to_owned())
}

/// The only lane that leads to a lane, if it is a road for vehicles outside intersections.
fn road_before(map: &MapIndex, lane: usize) -> Option<usize> {
    let &[before] = map.predecessors(lane) else { return None };
    (map.intersections_of(before).is_empty() && map.lanes[before].vehicle).then_some(before)
}

/// The lanes for vehicles that a lane conflicts with, those with the same start included, but no neighbours.
fn conflicts(map: &MapIndex, lane: usize) -> Vec<LaneletId> {
    let crossing = map.conflicts[lane].iter().filter(|conflict| !conflict.grade_separated);
    let siblings = map.siblings(lane).filter(|&other| {
        let (lane, other) = (&map.lanes[lane], &map.lanes[other]);
        let neighbours = lane.bounds.iter().any(|line| other.bounds.contains(line));
        let area = polygon::overlap(&lane.outline, &other.outline);
        !neighbours && (area >= thresholds::REAL_AREA || area >= thresholds::REAL_SHARE * lane.area)
    });
    let all = crossing.map(|conflict| conflict.other).chain(siblings);
    let all: BTreeSet<usize> = all.filter(|&other| map.lanes[other].vehicle).collect();
    all.into_iter().map(|other| map.lanes[other].id).collect()
}

/// The end lines drawn so far, by the points at which their lanelets end.
pub type EndLines = BTreeMap<[PointId; 2], LineStringId>;

/// Draws a light with its lines. Its lanelets have the right of way: the infrastructure holds the others back.
pub fn draw(editor: &mut MapEditor, end_lines: &mut EndLines, light: VirtualLight) {
    let VirtualLight { carriers, start, stop, stop_line, ends, conflicts, tags } = light;
    let key = Key::new("virtual light").number(stop.ids[0].0).number(stop.ids[1].0);
    let start = draw_start_line(editor, key.word("start"), start);
    let stop_line = stop_line.unwrap_or_else(|| {
        editor.line(key.word("stop"), stop.ids.to_vec(), Attributes::of(&[("type", "stop_line"), ("subtype", "solid")]))
    });
    let anchor = draw_anchor(editor, key.word("anchor"), &stop, tags);
    let mut members = vec![("start_line", Target::LineString(start)), ("ref_line", Target::LineString(stop_line))];
    for points in ends {
        members.push(("end_line", Target::LineString(draw_end_line(editor, end_lines, points))));
    }
    members.push(("refers", Target::LineString(anchor)));
    editor.element(key, "virtual_traffic_light", members, &carriers);
    for (lane, others) in conflicts.into_iter().filter(|(_, others)| !others.is_empty()) {
        right_of_way_edit::amend(editor, lane, &[], &others);
    }
}

fn draw_start_line(editor: &mut MapEditor, key: Key, ends: LaneletEnds) -> LineStringId {
    let points = ["left", "right"].into_iter().zip(ends).map(|(side, (bound, place))| {
        let ele = editor.height(bound, place);
        editor.point(key.word(side), place, ele)
    });
    let points = points.collect();
    editor.line(key, points, Attributes::of(&[("type", "virtual")]))
}

/// Lanelets that end at the same points share an end line.
fn draw_end_line(editor: &mut MapEditor, end_lines: &mut EndLines, points: [PointId; 2]) -> LineStringId {
    let key = Key::new("virtual light end").number(points[0].0).number(points[1].0);
    let line = || editor.line(key, points.to_vec(), Attributes::of(&[("type", "virtual")]));
    *end_lines.entry(points).or_insert_with(line)
}

/// The line that represents the infrastructure: above the stop line, with the tags of the settings.
fn draw_anchor(editor: &mut MapEditor, key: Key, stop: &Edge, tags: BTreeMap<String, String>) -> LineStringId {
    let ele = |id: PointId| editor.map.points.get(id).and_then(|point| point.ele()).unwrap_or_default();
    let ele = (ele(stop.ids[0]) + ele(stop.ids[1])) / 2.0 + LIGHT_HEIGHT;
    let places = [0.25, 0.75].map(|part| stop.points[0] + stop.across() * part);
    let points = ["left", "right"].into_iter().zip(places);
    let points = points.map(|(side, place)| editor.point(key.word(side), place, ele)).collect();
    let mut attributes = Attributes::of(&[("type", "intersection_coordination")]);
    for (name, value) in &tags {
        attributes.set(name, Text::from(value.as_str()));
    }
    editor.line(key, points, attributes)
}
