//! Stop lines inside an intersection, each with a `road_marking` element.

use std::collections::BTreeSet;

use crate::builder::ids::Key;
use crate::builder::postprocess::cross_line::{LaneletEnds, cross_line, crosses};
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::{Point, Polyline, angle_between, polygon};
use crate::lanelet::index::{Lane, MapIndex, Movement, Traffic};
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{Attributes, LaneletId, Target};

/// The distance, metres, from the stop line to the first conflicting lane.
const CLEARANCE: f64 = 1.0;
/// Lanes conflict where they share this area, square metres. Lanes side by side touch without conflict.
const MIN_OVERLAP: f64 = 0.05;
/// The step in which the first conflict is searched, metres.
const SEARCH_STEP: f64 = 0.25;
/// The smallest distance, metres, from the start of the lane: a car has to fit before the line.
const MIN_STATION: f64 = 6.0;
/// Paint may end before the bound: a line is extended by this length, metres, at both ends.
const EXTENSION: f64 = 0.5;
/// The largest distance, metres, of the ends of a user's line from the bounds of its lane.
const MAX_OFFSET: f64 = 1.0;
/// The largest angle, degrees, between a user's line and a line straight across the lane.
const MAX_SKEW: f64 = 30.0;
/// Within this distance, metres, from the start of a lane lies the stop line of the approach.
const APPROACH: f64 = 2.0;

/// A stop line to draw.
pub struct StopLine {
    /// The lanelet that it crosses, and the lanelets from the same start that it crosses too.
    carriers: Vec<LaneletId>,
    ends: LaneletEnds,
}

/// The stop lines of one intersection.
#[derive(Default)]
pub struct StopLines {
    /// The lines to draw.
    pub lines: Vec<StopLine>,
    /// The lanes that have a stop line, by index.
    taken: BTreeSet<usize>,
}

impl StopLines {
    /// Adds a stop line between two points that the user names.
    ///
    /// # Errors
    ///
    /// The line does not fit a lane; the text says why.
    pub fn add(&mut self, map: &MapIndex, traffic: &Traffic, ends: [Point; 2]) -> Result<(), String> {
        let lanes = drivable(map, traffic).map(|movement| movement.lane);
        let fits = lanes.filter_map(|lane| Some((lane, fit(&map.lanes[lane], ends)?)));
        let best = fits.min_by(|a, b| a.1.offset.total_cmp(&b.1.offset).then(a.0.cmp(&b.0)));
        let (index, fit) = best.ok_or("it lies across no lane of the intersection")?;
        let lane = &map.lanes[index];
        if fit.offset > MAX_OFFSET {
            return Err(format!(
                "its ends lie {:.1} m from the bounds of lanelet {}, which comes nearest; draw it from bound to bound",
                fit.offset, lane.id
            ));
        }
        if fit.station < APPROACH {
            return Err(format!(
                "it lies where lanelet {} begins; the stop line of the approach is drawn there",
                lane.id
            ));
        }
        let carriers = carriers(map, index, fit.ends.map(|(_, place)| place));
        if let Some(taken) = carriers.iter().find(|carrier| self.taken.contains(carrier)) {
            return Err(format!("lanelet {} has a stop line inside already", map.lanes[*taken].id));
        }
        self.push(map, carriers, fit.ends);
        Ok(())
    }

    /// Adds a line for each far turn that waits inside for oncoming traffic, unless the line would stop other movements.
    pub fn add_waiting(&mut self, map: &MapIndex, traffic: &Traffic) {
        for movement in drivable(map, traffic).filter(|movement| waits_inside(movement)) {
            if self.taken.contains(&movement.lane) {
                continue;
            }
            let Some(ends) = waiting_line(map, movement.lane) else { continue };
            let carriers = carriers(map, movement.lane, ends.map(|(_, place)| place));
            let waits = |lane: &usize| traffic.of_lane(*lane).is_some_and(|x| waits_inside(&traffic.movements[x]));
            if carriers.iter().all(|lane| waits(lane) && !self.taken.contains(lane)) {
                self.push(map, carriers, ends);
            }
        }
    }

    fn push(&mut self, map: &MapIndex, carriers: Vec<usize>, ends: LaneletEnds) {
        self.lines.push(StopLine { carriers: carriers.iter().map(|&lane| map.lanes[lane].id).collect(), ends });
        self.taken.extend(carriers);
    }
}

/// The movements of cars.
pub fn drivable<'a>(map: &'a MapIndex, traffic: &'a Traffic) -> impl Iterator<Item = &'a Movement> {
    traffic.movements.iter().filter(|movement| {
        let lane = &map.lanes[movement.lane];
        lane.vehicle && !lane.bicycle
    })
}

/// Whether a movement enters the intersection and waits there for oncoming traffic.
fn waits_inside(movement: &Movement) -> bool {
    let ranked = movement.ranked;
    ranked.turn == Turn::Far && (ranked.signalised || ranked.priority == Some(true))
}

/// The line before the first lane to which a lane gives way; `None` if a car does not fit before it.
fn waiting_line(map: &MapIndex, index: usize) -> Option<LaneletEnds> {
    let lane = &map.lanes[index];
    let conflicts = map.attention(index).into_iter().filter_map(|other| first_conflict(lane, &map.lanes[other]));
    let station = conflicts.min_by(f64::total_cmp)? - CLEARANCE;
    if station >= MIN_STATION { cross_line(lane, station) } else { None }
}

/// The station of a lane, metres, at which it first overlaps another lane.
fn first_conflict(lane: &Lane, other: &Lane) -> Option<f64> {
    let center = lane.center.as_ref()?;
    let overlap = |station: f64| polygon::overlap(&lane_before(lane, station).unwrap_or_default(), &other.outline);
    let steps = (center.length() / SEARCH_STEP).ceil() as usize;
    let stations: Vec<f64> = (0..=steps).map(|step| step as f64 * SEARCH_STEP).collect();
    let first = stations.partition_point(|&station| overlap(station) < MIN_OVERLAP);
    stations.get(first).copied()
}

/// The outline of a lane from its start to a station, metres.
fn lane_before(lane: &Lane, station: f64) -> Option<Vec<Point>> {
    let [left, right] = cross_line(lane, station)?.map(|(_, place)| place);
    let part = |points: &[Point], end: Point| {
        let line = Polyline::new(points.iter().copied())?;
        line.cut(0.0, line.project(end).station)
    };
    let mut outline = part(&lane.left, left)?.into_points();
    outline.extend(part(&lane.right, right)?.reversed().into_points());
    Some(outline)
}

/// The lane and the lanes from the same start that cross a line, by index.
fn carriers(map: &MapIndex, lane: usize, line: [Point; 2]) -> Vec<usize> {
    let crossing = |other: &usize| map.lanes[*other].vehicle && crosses(&map.lanes[*other], line, EXTENSION).is_some();
    [lane].into_iter().chain(map.siblings(lane).filter(crossing)).collect()
}

/// How a line crosses a lane.
struct LineFit {
    /// The station on the middle of the lane, metres.
    station: f64,
    /// The larger distance of its ends from the bounds, metres.
    offset: f64,
    /// The nearest places to its ends on the bounds.
    ends: LaneletEnds,
}

fn fit(lane: &Lane, ends: [Point; 2]) -> Option<LineFit> {
    let station = crosses(lane, ends, EXTENSION)?;
    let heading = lane.center.as_ref()?.direction(station);
    let angle = angle_between(heading, ends[1] - ends[0]);
    let bounds = [lane.border(0)?, lane.border(1)?];
    let [left, right] = if angle > 0.0 { [ends[1], ends[0]] } else { ends };
    let offset = bounds[0].distance(left).max(bounds[1].distance(right));
    let ends = [(lane.bounds[0], bounds[0].project(left).point), (lane.bounds[1], bounds[1].project(right).point)];
    ((angle.abs().to_degrees() - 90.0).abs() <= MAX_SKEW).then_some(LineFit { station, offset, ends })
}

/// Draws a stop line between points of both bounds, and its regulatory element.
pub fn draw(editor: &mut MapEditor, StopLine { carriers, ends }: StopLine) {
    let Some(first) = carriers.first() else { return };
    let key = Key::new("inside stop line").number(first.0);
    let points = ["left", "right"].into_iter().zip(ends);
    let points = points.map(|(side, (line, place))| editor.point_on(key.word(side), line, place)).collect();
    let line = editor.line(key, points, Attributes::of(&[("type", "stop_line"), ("subtype", "solid")]));
    editor.element(key.word("marking"), "road_marking", vec![("refers", Target::LineString(line))], &carriers);
}
