//! Guide lines where the user has seen them: the bounds of a turn's lanes are led along the paint as far as it reaches, and
//! from there on to where their lanes end.

use rustc_hash::FxHashSet;

use crate::builder::ids::Key;
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, angle_between, curve};
use crate::lanelet::index::{Lane, MapIndex, Movement, Traffic};
use crate::lanelet::{Attributes, LaneletId, LaneletMap, LineStringId, PointId};

use super::stop_line::drivable;

/// A guide line belongs to a bound that begins within this distance, metres, of where it begins itself, ...
const START: f64 = 2.0;
/// ... into a direction that differs by this many degrees at most, ...
const HEADING: f64 = 20.0;
/// ... and that runs within this distance, metres, of it.
const OFF: f64 = 2.0;
/// At least this much, metres, is left between its end and where the lane ends.
const REST: f64 = 2.0;
/// A lane may become so many times as narrow as its ends are, or as wide.
const WIDTH: [f64; 2] = [0.8, 1.25];
/// Part of a lane that lies inside the intersection's area.
const COVERED: f64 = 0.99;

/// A guide line, before it is drawn.
pub struct TracedBounds {
    /// Where the lanes begin.
    node: PointId,
    /// The places along it, the node left out.
    painted: Vec<Point>,
    bounds: Vec<LedBound>,
    /// The lanelets that have one of the bounds, and what each of them meets: whom, and whether by more than a touch.
    lanes: Vec<(LaneletId, Vec<(LaneletId, bool)>)>,
}

/// A bound that is led along a guide line.
struct LedBound {
    line: LineStringId,
    /// Whether it runs toward the guide line's begin.
    inverted: bool,
    /// The places between the end of the guide line and that of the bound.
    rest: Vec<Point>,
}

/// What was drawn, and how the bounds were before.
pub struct Traced {
    guide: LineStringId,
    before: Vec<(LineStringId, Vec<PointId>)>,
    added: Vec<PointId>,
}

/// One side of a lane that begins where a guide line begins.
struct Side<'a> {
    movement: &'a Movement,
    side: usize,
    line: Polyline,
    /// How far the line strays from it, metres.
    off: f64,
}

impl TracedBounds {
    /// Finds the bounds for a line along some places, metres; else says why there are none.
    pub fn new(map: &MapIndex, traffic: &Traffic, places: Vec<Point>) -> Result<Self, String> {
        let line = Polyline::new(places).ok_or("its places are one and the same")?;
        let lines = [line.clone(), line.reversed()];
        let sides = drivable(map, traffic).flat_map(|movement| {
            let lines = lines.iter().flat_map(move |line| [0, 1].map(|side| (line, side)));
            lines.filter_map(move |(line, side)| side_of(map, movement, side, line))
        });
        let Some(best) = sides.min_by(|a, b| a.off.total_cmp(&b.off)) else {
            return Err(format!(
                "no bound of a lane begins within {START} m of it and heads as it does; begin it at the stop line"
            ));
        };
        let lane = &map.lanes[best.movement.lane];
        if best.off > OFF {
            return Err(format!(
                "it strays {:.1} m from the bound of lanelet {}; {OFF} m is the most",
                best.off, lane.id
            ));
        }
        let node = lane.start.ids[best.side];
        let painted = begun_at(&best.line, lane.start.points[best.side]);
        let painted = Polyline::new(painted).ok_or("its places are one and the same")?;
        let alike = drivable(map, traffic).filter(|other| {
            map.lanes[other.lane].start.ids == lane.start.ids && other.mover.turn == best.movement.mover.turn
        });
        let mut bounds: Vec<LedBound> = Vec::new();
        for other in alike.map(|other| &map.lanes[other.lane]) {
            if bounds.iter().all(|bound| bound.line != other.bounds[best.side]) {
                bounds.push(bound(map, other, best.side, &painted)?);
            }
        }
        let users: FxHashSet<usize> = bounds.iter().flat_map(|bound| map.users_of(bound.line)).copied().collect();
        let mut users: Vec<usize> = users.into_iter().collect();
        users.sort_unstable();
        let lanes = users.into_iter().map(|lane| (map.lanes[lane].id, meets(map, lane))).collect();
        Ok(Self { node, painted: painted.points()[1..].to_vec(), bounds, lanes })
    }

    /// The bounds that it leads.
    pub fn bounds(&self) -> impl Iterator<Item = LineStringId> {
        self.bounds.iter().map(|bound| bound.line)
    }

    /// Whether another line leads one of its bounds, too.
    pub fn shares_with(&self, other: &Self) -> bool {
        other.bounds().any(|line| self.bounds().any(|own| own == line))
    }

    /// Draws the line, and the bounds along it.
    pub fn draw(&self, pen: &mut MapEditor) -> Traced {
        let key = Key::new("guide line").number(self.node.0);
        let heights = self.bounds.first().map_or(LineStringId(0), |bound| bound.line);
        let mut added = Vec::new();
        let mut point = |pen: &mut MapEditor, key: Key, place: Point| {
            let ele = pen.height(heights, place);
            let id = pen.point(key, place, ele);
            added.push(id);
            id
        };
        let mut painted = vec![self.node];
        painted.extend(self.painted.iter().enumerate().map(|(i, &place)| point(pen, key.number(i as i64), place)));
        let mut before = Vec::new();
        for bound in &self.bounds {
            let key = key.word("bound").number(bound.line.0);
            let rest = bound.rest.iter().enumerate().map(|(i, &place)| point(pen, key.number(i as i64), place));
            let rest: Vec<PointId> = rest.collect();
            let Some(line) = pen.map.linestrings.get_mut(bound.line) else { continue };
            let end = if bound.inverted { line.points.first() } else { line.points.last() };
            let mut points: Vec<PointId> = painted.iter().copied().chain(rest).chain(end.copied()).collect();
            if bound.inverted {
                points.reverse();
            }
            before.push((bound.line, std::mem::replace(&mut line.points, points)));
        }
        let guide = pen.line(key, painted, Attributes::of(&[("type", "line_thin"), ("subtype", "dashed")]));
        Traced { guide, before, added }
    }

    /// Whether the map is still sound around it; else what is wrong.
    pub fn vet(&self, map: &MapIndex) -> Result<(), String> {
        for (id, met) in &self.lanes {
            let lane = map.lane(*id).filter(|&at| map.lanes[at].simple);
            let at = lane.ok_or_else(|| format!("lanelet {id} would cross itself"))?;
            if let Some(width) = unfit_width(&map.lanes[at]) {
                return Err(format!("lanelet {id} would be {width:.1} m wide"));
            }
            let now = meets(map, at);
            let more = now.iter().find(|(other, real)| !met.contains(&(*other, *real)));
            let less = met.iter().find(|(other, real)| *real && !now.contains(&(*other, true)));
            if let Some((other, _)) = more.or(less) {
                return Err(format!("lanelet {id} would get in the way of {other} as it does not now, or no more"));
            }
            let members = map.intersections.iter().flat_map(|one| &one.members).filter(|member| member.lane == at);
            if members.map(|member| member.cover).fold(0.0, f64::max) < COVERED {
                return Err(format!("lanelet {id} would leave the intersection"));
            }
        }
        Ok(())
    }
}

impl Traced {
    /// Gives the bounds their old course.
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

    /// The points that the bounds no longer need.
    pub fn left(self) -> impl Iterator<Item = PointId> {
        self.before.into_iter().flat_map(|(_, points)| points)
    }
}

/// Takes away points of which nothing is left.
pub fn sweep(map: &mut LaneletMap, left: impl Iterator<Item = PointId>) {
    let mut left: FxHashSet<PointId> = left.collect();
    let lines = map.linestrings.iter().flat_map(|line| &line.points);
    for used in lines.chain(map.polygons.iter().flat_map(|polygon| &polygon.points)) {
        left.remove(used);
    }
    if !left.is_empty() {
        map.points.retain(|point| !left.contains(&point.id));
    }
}

fn side_of<'a>(map: &MapIndex, movement: &'a Movement, side: usize, line: &Polyline) -> Option<Side<'a>> {
    /// The line is compared with a bound at places so far from each other, metres.
    const STEP: f64 = 1.0;
    let lane = &map.lanes[movement.lane];
    let bound = lane.border(side)?;
    let turned = angle_between(lane.heading_in()?, line.direction(0.0)).abs().to_degrees();
    let near = (line.first() - lane.start.points[side]).norm() <= START;
    let off = line.resampled(STEP).points().iter().map(|&place| bound.distance(place)).fold(0.0, f64::max);
    (near && turned <= HEADING).then(|| Side { movement, side, line: line.clone(), off })
}

/// The line, moved so that it begins at a node: there by all of the difference, at its end by nothing.
fn begun_at(line: &Polyline, node: Point) -> Vec<Point> {
    let (by, length) = (node - line.first(), line.length());
    let places = line.points().iter().zip(line.stations());
    places.map(|(place, station)| place + by * (1.0 - station / length)).collect()
}

/// The bound of a lane, led along what is painted.
fn bound(map: &MapIndex, lane: &Lane, side: usize, painted: &Polyline) -> Result<LedBound, String> {
    let line = lane.bounds[side];
    let points = map.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
    let inner: FxHashSet<PointId> = points.iter().copied().skip(1).take(points.len().saturating_sub(2)).collect();
    if map.map.polygons.iter().any(|polygon| polygon.points.iter().any(|point| inner.contains(point))) {
        return Err(format!("the bound of lanelet {} lies on the intersection's outline", lane.id));
    }
    let bound = lane.border(side).ok_or("the lane has no length")?;
    if bound.project(painted.last()).station > bound.length() - REST {
        return Err(format!("it reaches to where lanelet {} ends; let it end {REST} m before", lane.id));
    }
    let from = Pose { point: painted.last(), heading: painted.direction(painted.length()) };
    let to = Pose { point: bound.last(), heading: bound.direction(bound.length()) };
    let course: Vec<Point> = curve::join(from, to).into_iter().map(|pose| pose.point).collect();
    let course = curve::untangled(&course);
    let rest = course[1.min(course.len())..course.len().max(2) - 1].to_vec();
    Ok(LedBound { line, inverted: points.first() != Some(&lane.start.ids[side]), rest })
}

/// Whom a lane meets, and whether by more than a touch.
fn meets(map: &MapIndex, lane: usize) -> Vec<(LaneletId, bool)> {
    map.conflicts[lane].iter().map(|conflict| (map.lanes[conflict.other].id, conflict.real)).collect()
}

/// A width of a lane, metres, that is far from those at its ends.
fn unfit_width(lane: &Lane) -> Option<f64> {
    let ends = [&lane.start, &lane.end].map(|edge| edge.across().norm());
    let [low, high] = [ends[0].min(ends[1]) * WIDTH[0], ends[0].max(ends[1]) * WIDTH[1]];
    let (left, right) = (lane.border(0)?, lane.border(1)?);
    let widths =
        left.points().iter().map(|&p| right.distance(p)).chain(right.points().iter().map(|&p| left.distance(p)));
    widths.into_iter().find(|width| !(low..=high).contains(width))
}
