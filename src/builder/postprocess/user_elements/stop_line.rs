//! Stop lines in the middle of an intersection, each with its `road_marking` element.

use std::collections::BTreeSet;

use crate::builder::ids::Key;
use crate::builder::postprocess::cross_line::{LaneletEnds, cross_line, crosses};
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::{Point, Polyline, angle_between, polygon};
use crate::lanelet::index::{Lane, MapIndex, Movement, Traffic};
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{Attributes, LaneletId, Target};

/// Who waits stands this far, metres, before the first lane that he has to watch.
const CLEAR: f64 = 1.0;
/// A lane is reached where so much of it, square metres, lies on the way: lanes side by side touch.
const COMMON: f64 = 0.05;
/// That is looked for in steps of this length, metres.
const STEP: f64 = 0.25;
/// A line nearer to where the lane begins than this, metres, has no room for a car behind it.
const ROOM: f64 = 6.0;
/// Paint does not reach the border of the lane: a line counts as so much longer, metres, at either end.
const EXTRA: f64 = 0.5;
/// The ends of a line that the user draws lie at most this far, metres, from the bounds of its lane.
const OFF: f64 = 1.0;
/// It is this far, degrees, from straight across at most.
const ASKEW: f64 = 30.0;
/// Nearer to the begin of a lane than this, metres, lies the stop line of the approach.
const BEGIN: f64 = 2.0;

/// A stop line, before it is drawn.
pub struct StopLine {
    /// The lanelet across which it lies, and those from the same lane that cross it too.
    carriers: Vec<LaneletId>,
    ends: LaneletEnds,
}

/// The lines of one intersection.
#[derive(Default)]
pub struct StopLines {
    /// To be drawn.
    pub lines: Vec<StopLine>,
    /// The lanes that have one, by position.
    taken: BTreeSet<usize>,
}

impl StopLines {
    /// Adds the line that a user draws from one place to another, metres; else says why there is none.
    pub fn add(&mut self, map: &MapIndex, traffic: &Traffic, ends: [Point; 2]) -> Result<(), String> {
        let lanes = drivable(map, traffic).map(|movement| movement.lane);
        let fits = lanes.filter_map(|at| Some((at, fit(&map.lanes[at], ends)?)));
        let Some((at, fit)) = fits.min_by(|a, b| a.1.off.total_cmp(&b.1.off).then(a.0.cmp(&b.0))) else {
            return Err("it lies across no lane of the intersection".to_owned());
        };
        let lane = &map.lanes[at];
        if fit.off > OFF {
            return Err(format!(
                "its ends lie {:.1} m from the bounds of lanelet {}, which comes nearest; draw it from bound to bound",
                fit.off, lane.id
            ));
        }
        if fit.station < BEGIN {
            return Err(format!(
                "it lies where lanelet {} begins; the stop line of the approach is drawn there",
                lane.id
            ));
        }
        let carriers = carriers(map, at, fit.ends.map(|(_, place)| place));
        if let Some(twice) = carriers.iter().find(|carrier| self.taken.contains(carrier)) {
            return Err(format!("lanelet {} has a stop line inside already", map.lanes[*twice].id));
        }
        self.push(map, carriers, fit.ends);
        Ok(())
    }

    /// Adds a line for each far turn that waits inside for oncoming traffic, where nobody else would stop at it.
    pub fn add_waiting(&mut self, map: &MapIndex, traffic: &Traffic) {
        for movement in drivable(map, traffic).filter(|movement| waits(movement)) {
            if self.taken.contains(&movement.lane) {
                continue;
            }
            let Some(ends) = waiting_line(map, movement.lane) else { continue };
            let carriers = carriers(map, movement.lane, ends.map(|(_, place)| place));
            let far = |lane: &usize| traffic.of_lane(*lane).is_some_and(|x| waits(&traffic.movements[x]));
            if carriers.iter().all(|lane| far(lane) && !self.taken.contains(lane)) {
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

/// Whether a movement drives into the intersection and then lets oncoming traffic pass.
fn waits(movement: &Movement) -> bool {
    let mover = movement.mover;
    mover.turn == Turn::Far && (mover.signalised || mover.priority == Some(true))
}

/// The line before the first lane that a lane has to watch, with room for a car behind it.
fn waiting_line(map: &MapIndex, at: usize) -> Option<LaneletEnds> {
    let lane = &map.lanes[at];
    let watched = map.attention(at).into_iter().filter_map(|other| reached(lane, &map.lanes[other]));
    let station = watched.min_by(f64::total_cmp)? - CLEAR;
    (station >= ROOM).then(|| cross_line(lane, station)).flatten()
}

/// How far along a lane, metres, another one is reached; `None` if it never is.
fn reached(lane: &Lane, other: &Lane) -> Option<f64> {
    let center = lane.center.as_ref()?;
    let common = |station: f64| polygon::overlap(&lane_before(lane, station).unwrap_or_default(), &other.outline);
    let steps = (center.length() / STEP).ceil() as usize;
    let stations: Vec<f64> = (0..=steps).map(|step| step as f64 * STEP).collect();
    let first = stations.partition_point(|&station| common(station) < COMMON);
    stations.get(first).copied()
}

/// The outline of a lane up to a station, metres.
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

/// The lane and those from the same lane that cross a line, by position.
fn carriers(map: &MapIndex, lane: usize, line: [Point; 2]) -> Vec<usize> {
    let crossing = |other: &usize| map.lanes[*other].vehicle && crosses(&map.lanes[*other], line, EXTRA).is_some();
    [lane].into_iter().chain(map.siblings(lane).filter(crossing)).collect()
}

/// How a line lies across a lane.
struct Fit {
    /// Where along the lane's middle, metres.
    station: f64,
    /// Distance of its ends from the lane's bounds, metres.
    off: f64,
    /// The places on the bounds nearest to its ends.
    ends: LaneletEnds,
}

fn fit(lane: &Lane, ends: [Point; 2]) -> Option<Fit> {
    let station = crosses(lane, ends, EXTRA)?;
    let heading = lane.center.as_ref()?.direction(station);
    let angle = angle_between(heading, ends[1] - ends[0]).abs().to_degrees();
    let bounds = [lane.border(0)?, lane.border(1)?];
    let [left, right] = if angle_between(heading, ends[1] - ends[0]) > 0.0 { [ends[1], ends[0]] } else { ends };
    let off = bounds[0].distance(left).max(bounds[1].distance(right));
    let ends = [(lane.bounds[0], bounds[0].project(left).point), (lane.bounds[1], bounds[1].project(right).point)];
    ((angle - 90.0).abs() <= ASKEW).then_some(Fit { station, off, ends })
}

/// Draws a line over one node of either bound, and its element.
pub fn draw(pen: &mut MapEditor, StopLine { carriers, ends }: StopLine) {
    let Some(first) = carriers.first() else { return };
    let key = Key::new("inside stop line").number(first.0);
    let nodes: Vec<_> = ["left", "right"]
        .into_iter()
        .zip(ends)
        .map(|(side, (line, at))| pen.point_on(key.word(side), line, at))
        .collect();
    let line = pen.line(key, nodes, Attributes::of(&[("type", "stop_line"), ("subtype", "solid")]));
    pen.element(key.word("marking"), "road_marking", vec![("refers", Target::LineString(line))], &carriers);
}
