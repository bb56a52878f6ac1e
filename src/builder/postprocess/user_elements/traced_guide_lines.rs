//! Guide lines that the user has traced: the bounds of a turn's lanes follow the paint to its end, and a curve from there to
//! the end of the lane.

use rustc_hash::FxHashSet;

use crate::builder::ids::Key;
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, angle_between, curve};
use crate::lanelet::index::{Lane, MapIndex, Movement, Traffic};
use crate::lanelet::{Attributes, LaneletId, LaneletMap, LineStringId, PointId};

use super::stop_line::drivable;

/// The largest distance, metres, between the starts of a guide line and of its bound.
const MAX_START_GAP: f64 = 2.0;
/// The largest angle, degrees, between a guide line and its bound at their starts.
const MAX_ANGLE: f64 = 20.0;
/// The largest distance, metres, between a guide line and its bound.
const MAX_OFFSET: f64 = 2.0;
/// The smallest distance, metres, between the end of a guide line and the end of the lane.
const MIN_REST: f64 = 2.0;
/// How narrow and how wide a lane may become, as parts of the widths at its ends.
const WIDTH_RANGE: [f64; 2] = [0.8, 1.25];
/// The part of a lane that lies in the intersection area at least.
const MIN_COVER: f64 = 0.99;

/// A guide line and the bounds that follow it.
pub struct TracedBounds {
    /// The point at which the lanes begin.
    start: PointId,
    /// The vertices of the guide line after `start`.
    painted: Vec<Point>,
    bounds: Vec<TracedBound>,
    /// The lanelets on both sides of the bounds, each with its conflicts: the other lanelet, and whether they overlap.
    lanes: Vec<(LaneletId, Vec<(LaneletId, bool)>)>,
}

/// A bound that follows a guide line.
struct TracedBound {
    line: LineStringId,
    /// Whether it runs against the guide line.
    inverted: bool,
    /// The vertices between the end of the guide line and the end of the bound.
    rest: Vec<Point>,
}

/// The changes of the map for one guide line.
pub struct TraceChange {
    guide: LineStringId,
    before: Vec<(LineStringId, Vec<PointId>)>,
    added: Vec<PointId>,
}

/// A bound of a lane to which a guide line may belong.
struct Candidate<'a> {
    movement: &'a Movement,
    /// 0: the left bound, 1: the right bound.
    side: usize,
    line: Polyline,
    /// The largest distance of the guide line from the bound, metres.
    offset: f64,
}

impl TracedBounds {
    /// Finds the bounds that belong to a guide line.
    ///
    /// # Errors
    ///
    /// No bound is near enough, or its lane does not fit; the text says why.
    pub fn new(map: &MapIndex, traffic: &Traffic, points: Vec<Point>) -> Result<Self, String> {
        let line = Polyline::new(points).ok_or("its places are one and the same")?;
        let best = nearest_bound(map, traffic, &line)?;
        let lane = &map.lanes[best.movement.lane];
        if best.offset > MAX_OFFSET {
            return Err(format!(
                "it strays {:.1} m from the bound of lanelet {}; {MAX_OFFSET} m is the most",
                best.offset, lane.id
            ));
        }
        let painted = moved_start(&best.line, lane.start.points[best.side]);
        let painted = Polyline::new(painted).ok_or("its places are one and the same")?;
        let alike = drivable(map, traffic).filter(|other| {
            map.lanes[other.lane].start.ids == lane.start.ids && other.ranked.turn == best.movement.ranked.turn
        });
        let mut bounds: Vec<TracedBound> = Vec::new();
        for other in alike.map(|other| &map.lanes[other.lane]) {
            if bounds.iter().all(|bound| bound.line != other.bounds[best.side]) {
                bounds.push(traced_bound(map, other, best.side, &painted)?);
            }
        }
        let users: FxHashSet<usize> = bounds.iter().flat_map(|bound| map.users_of(bound.line)).copied().collect();
        let mut users: Vec<usize> = users.into_iter().collect();
        users.sort_unstable();
        let lanes = users.into_iter().map(|lane| (map.lanes[lane].id, conflicts(map, lane))).collect();
        Ok(Self { start: lane.start.ids[best.side], painted: painted.points()[1..].to_vec(), bounds, lanes })
    }

    /// The bounds that follow the guide line.
    pub fn bounds(&self) -> impl Iterator<Item = LineStringId> {
        self.bounds.iter().map(|bound| bound.line)
    }

    /// Whether a bound follows both guide lines.
    pub fn shares_with(&self, other: &Self) -> bool {
        other.bounds().any(|line| self.bounds().any(|own| own == line))
    }

    /// Draws the guide line and moves the bounds onto it.
    pub fn draw(&self, editor: &mut MapEditor) -> TraceChange {
        let key = Key::new("guide line").number(self.start.0);
        let mut painted = vec![self.start];
        painted.extend(self.points(editor, key, &self.painted));
        let mut added = painted[1..].to_vec();
        let mut before = Vec::new();
        for bound in &self.bounds {
            let rest = self.points(editor, key.word("bound").number(bound.line.0), &bound.rest);
            added.extend(&rest);
            let Some(line) = editor.map.linestrings.get_mut(bound.line) else { continue };
            let end = if bound.inverted { line.points.first() } else { line.points.last() };
            let mut points: Vec<PointId> = painted.iter().copied().chain(rest).chain(end.copied()).collect();
            if bound.inverted {
                points.reverse();
            }
            before.push((bound.line, std::mem::replace(&mut line.points, points)));
        }
        let guide = editor.line(key, painted, Attributes::of(&[("type", "line_thin"), ("subtype", "dashed")]));
        TraceChange { guide, before, added }
    }

    /// Adds points at the elevation of the first bound.
    fn points(&self, editor: &mut MapEditor, key: Key, places: &[Point]) -> Vec<PointId> {
        let bound = self.bounds.first().map_or(LineStringId(0), |bound| bound.line);
        let points = places.iter().enumerate().map(|(i, &place)| {
            let ele = editor.height(bound, place);
            editor.point(key.number(i as i64), place, ele)
        });
        points.collect()
    }

    /// Checks the lanes of the bounds in the changed map.
    ///
    /// # Errors
    ///
    /// A lane is no longer valid; the text says why.
    pub fn check(&self, map: &MapIndex) -> Result<(), String> {
        for (id, before) in &self.lanes {
            let lane = map.lane(*id).filter(|&lane| map.lanes[lane].simple);
            let lane = lane.ok_or_else(|| format!("lanelet {id} would cross itself"))?;
            if let Some(width) = unfit_width(&map.lanes[lane]) {
                return Err(format!("lanelet {id} would be {width:.1} m wide"));
            }
            let now = conflicts(map, lane);
            let gained = now.iter().find(|conflict| !before.contains(conflict));
            let lost = before.iter().find(|(other, real)| *real && !now.contains(&(*other, true)));
            if let Some((other, _)) = gained.or(lost) {
                return Err(format!("lanelet {id} would get in the way of {other} as it does not now, or no more"));
            }
            let members = map.intersections.iter().flat_map(|one| &one.members).filter(|member| member.lane == lane);
            if members.map(|member| member.cover).fold(0.0, f64::max) < MIN_COVER {
                return Err(format!("lanelet {id} would leave the intersection"));
            }
        }
        Ok(())
    }
}

impl TraceChange {
    /// Undoes the changes.
    pub fn undo(self, map: &mut LaneletMap) {
        for (line, points) in self.before {
            if let Some(line) = map.linestrings.get_mut(line) {
                line.points = points;
            }
        }
        map.linestrings.retain(|line| line.id != self.guide);
        let added: FxHashSet<PointId> = self.added.into_iter().collect();
        map.points.retain(|point| !added.contains(&point.id));
    }

    /// The points of the bounds before the change.
    pub fn replaced_points(self) -> impl Iterator<Item = PointId> {
        self.before.into_iter().flat_map(|(_, points)| points)
    }
}

/// Removes those of the points that no linestring or polygon uses.
pub fn remove_unused(map: &mut LaneletMap, points: impl Iterator<Item = PointId>) {
    let mut unused: FxHashSet<PointId> = points.collect();
    let lines = map.linestrings.iter().flat_map(|line| &line.points);
    for used in lines.chain(map.polygons.iter().flat_map(|polygon| &polygon.points)) {
        unused.remove(used);
    }
    if !unused.is_empty() {
        map.points.retain(|point| !unused.contains(&point.id));
    }
}

/// The bound to which a guide line belongs, in whichever direction the user has drawn the line.
fn nearest_bound<'a>(map: &'a MapIndex, traffic: &'a Traffic, line: &Polyline) -> Result<Candidate<'a>, String> {
    let lines = [line.clone(), line.reversed()];
    let mut candidates = Vec::new();
    for movement in drivable(map, traffic) {
        for (line, side) in lines.iter().flat_map(|line| [(line, 0), (line, 1)]) {
            candidates.extend(candidate(map, movement, side, line));
        }
    }
    candidates.into_iter().min_by(|a, b| a.offset.total_cmp(&b.offset)).ok_or_else(|| {
        format!(
            "no bound of a lane begins within {MAX_START_GAP} m of it and heads as it does; begin it at the stop line"
        )
    })
}

/// A bound of a lane that begins where the guide line begins and in its direction.
fn candidate<'a>(map: &MapIndex, movement: &'a Movement, side: usize, line: &Polyline) -> Option<Candidate<'a>> {
    /// The distance between places where the line is compared with the bound, metres.
    const COMPARED_EVERY: f64 = 1.0;
    let lane = &map.lanes[movement.lane];
    let bound = lane.border(side)?;
    let angle = angle_between(lane.heading_in()?, line.direction(0.0)).abs().to_degrees();
    let near = (line.first() - lane.start.points[side]).norm() <= MAX_START_GAP;
    let offset = line.resampled(COMPARED_EVERY).points().iter().map(|&place| bound.distance(place)).fold(0.0, f64::max);
    (near && angle <= MAX_ANGLE).then(|| Candidate { movement, side, line: line.clone(), offset })
}

/// The line with its start moved to a point. The shift decreases linearly to 0 at its end.
fn moved_start(line: &Polyline, start: Point) -> Vec<Point> {
    let (shift, length) = (start - line.first(), line.length());
    let points = line.points().iter().zip(line.stations());
    points.map(|(point, station)| point + shift * (1.0 - station / length)).collect()
}

/// The bound of a lane that follows a painted line.
fn traced_bound(map: &MapIndex, lane: &Lane, side: usize, painted: &Polyline) -> Result<TracedBound, String> {
    let line = lane.bounds[side];
    let points = map.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
    let inner: FxHashSet<PointId> = points.iter().copied().skip(1).take(points.len().saturating_sub(2)).collect();
    if map.map.polygons.iter().any(|polygon| polygon.points.iter().any(|point| inner.contains(point))) {
        return Err(format!("the bound of lanelet {} lies on the intersection's outline", lane.id));
    }
    let bound = lane.border(side).ok_or("the lane has no length")?;
    if bound.project(painted.last()).station > bound.length() - MIN_REST {
        return Err(format!("it reaches to where lanelet {} ends; let it end {MIN_REST} m before", lane.id));
    }
    let from = Pose { point: painted.last(), heading: painted.direction(painted.length()) };
    let to = Pose { point: bound.last(), heading: bound.direction(bound.length()) };
    let joint: Vec<Point> = curve::join(from, to).into_iter().map(|pose| pose.point).collect();
    let joint = curve::untangled(&joint);
    let rest = joint[1.min(joint.len())..joint.len().max(2) - 1].to_vec();
    Ok(TracedBound { line, inverted: points.first() != Some(&lane.start.ids[side]), rest })
}

/// The conflicts of a lane: the other lanelet, and whether they overlap by more than a touch.
fn conflicts(map: &MapIndex, lane: usize) -> Vec<(LaneletId, bool)> {
    map.conflicts[lane].iter().map(|conflict| (map.lanes[conflict.other].id, conflict.real)).collect()
}

/// A width of a lane, metres, that is too small or too large for the widths at its ends.
fn unfit_width(lane: &Lane) -> Option<f64> {
    let ends = [&lane.start, &lane.end].map(|edge| edge.across().norm());
    let [low, high] = [ends[0].min(ends[1]) * WIDTH_RANGE[0], ends[0].max(ends[1]) * WIDTH_RANGE[1]];
    let (left, right) = (lane.border(0)?, lane.border(1)?);
    let widths =
        left.points().iter().map(|&p| right.distance(p)).chain(right.points().iter().map(|&p| left.distance(p)));
    widths.into_iter().find(|width| !(low..=high).contains(width))
}
