//! Lanelets that are missing between two lines: the borders of a lane go on where it ends, and nothing lies between them.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Polyline, Vector, angle_between, polygon};
use crate::lanelet::index::{Edge, MapIndex, center_line};
use crate::lanelet::{LineString, LineStringId, PointId, RoadType};
use crate::rules::crowd;
use crate::rules::routing_moves::RoutingMoves;

use super::params::{Params, subject};
use super::street_ends::is_alone;

/// Lines that bound no lane, whatever runs along them.
const NO_BORDERS: [&str; 8] = [
    "stop_line",
    "traffic_light",
    "light_bulbs",
    "traffic_sign",
    "pedestrian_marking",
    "zebra_marking",
    "bike_marking",
    "pose_marker",
];
/// Steps along the missing piece at which its width and its ground are looked at, metres.
const MEASURED_EVERY: f64 = 2.0;
/// The piece is at least and at most so many times as wide as the lane that it continues.
const WIDTHS: [f64; 2] = [0.6, 1.6];
/// The same where two lines that nothing else uses lead from lane to lane.
const SURE_WIDTHS: [f64; 2] = [0.4, 2.5];
/// Points closer than this, metres, are one place of two copies of a line.
const SAME_PLACE: f64 = 0.05;
/// A missing piece with more of its ground than this (1) under lanes of its direction is there, drawn in another way.
const COVERED: f64 = 0.25;

/// The same where other lanes begin or end with the piece, and nothing lies at its other end.
const COVERED_AT_FORKS: f64 = 0.6;

/// A piece of road without a lanelet.
pub struct Hole {
    /// The lane that leads into it.
    before: Option<usize>,
    /// The lane that leads on from it.
    after: Option<usize>,
    lines: [LineStringId; 2],
    outline: Vec<Point>,
    length: f64,
}

/// A line as it runs on from a point.
struct Onward {
    line: LineStringId,
    end: PointId,
    points: Vec<Point>,
}

/// Looks for missing pieces behind the ends of lanes, and before the starts of those that nothing leads to.
pub struct Holes<'m> {
    map: &'m MapIndex<'m>,
    params: &'m Params,
    moves: &'m RoutingMoves<'m>,
    /// Lines by each of their two ends.
    by_end: FxHashMap<PointId, Vec<LineStringId>>,
    /// Pairs of points that a line joins, the smaller id first.
    joined: FxHashSet<[PointId; 2]>,
    /// The two bounds of every lanelet, the smaller id first.
    used: FxHashSet<[LineStringId; 2]>,
    /// Lines that bound a lanelet.
    bounds: FxHashSet<LineStringId>,
    /// Lines that are both bounds of a lanelet, whose other bound is what is missing.
    both: FxHashSet<LineStringId>,
}

impl<'m> Holes<'m> {
    pub fn new(map: &'m MapIndex<'m>, params: &'m Params, moves: &'m RoutingMoves<'m>) -> Self {
        let mut by_end: FxHashMap<PointId, Vec<LineStringId>> = FxHashMap::default();
        let mut joined = FxHashSet::default();
        // Between these lies an area.
        let around: FxHashSet<LineStringId> =
            map.map.areas.iter().flat_map(|area| &area.outer).map(|bound| bound.line).collect();
        let lanelets = || map.map.lanelets.iter().map(|lanelet| [lanelet.left.line, lanelet.right.line]);
        let bounds: FxHashSet<LineStringId> = lanelets().flatten().collect();
        let copies = copies(map, &bounds);
        for line in map.map.linestrings.iter().filter(|line| !around.contains(&line.id) && !copies.contains(&line.id)) {
            let kind = line.attributes.get("type").unwrap_or_default();
            if let [first, .., last] = line.points[..]
                && first != last
                && !NO_BORDERS.contains(&kind)
            {
                by_end.entry(first).or_default().push(line.id);
                by_end.entry(last).or_default().push(line.id);
                joined.insert([first.min(last), first.max(last)]);
            }
        }
        Self {
            map,
            params,
            moves,
            by_end,
            joined,
            used: lanelets().map(|[a, b]| [a.min(b), a.max(b)]).collect(),
            bounds,
            both: lanelets().filter(|[a, b]| a == b).flatten().collect(),
        }
    }

    /// All of them, each once; and the lanes at which more lines begin than are compared, one for each place, with their number.
    pub fn find(&self) -> (Vec<Hole>, Vec<(usize, usize)>) {
        let (mut holes, mut crowds) = (Vec::new(), Vec::new());
        let mut told: FxHashSet<PointId> = FxHashSet::default();
        let mut found: FxHashSet<[LineStringId; 2]> = FxHashSet::default();
        let loose = &self.map.settings.loose_ends;
        for forward in [true, false] {
            let known = if forward { &loose.ends } else { &loose.starts };
            let is_known = |at: usize| known.contains(&self.map.lanes[at].id.0);
            for at in (0..self.map.lanes.len()).filter(|&at| self.is_road(at) && !is_known(at)) {
                let lane = &self.map.lanes[at];
                let count = |id: &PointId| self.by_end.get(id).map_or(0, Vec::len);
                let edge = if forward { lane.end.ids } else { lane.start.ids };
                let fresh = edge.into_iter().filter(|id| count(id) > crowd::MOST && told.insert(*id));
                crowds.extend(fresh.map(|id| count(&id)).max().map(|count| (at, count)));
                for hole in self.behind(at, forward) {
                    let [a, b] = hole.lines;
                    if found.insert([a.min(b), a.max(b)]) {
                        holes.push(hole);
                    }
                }
            }
        }
        (holes, crowds)
    }

    fn is_road(&self, at: usize) -> bool {
        let lane = &self.map.lanes[at];
        // A lane in the middle, for turns from both directions, begins and ends where it is needed.
        lane.kind == RoadType::Road && lane.is_for_cars() && !lane.both_ways
    }

    /// The missing pieces behind the end of a lane, or before its start.
    fn behind(&self, at: usize, forward: bool) -> Vec<Hole> {
        let lane = &self.map.lanes[at];
        let (edge, heading) = match forward {
            true => (lane.end, lane.heading_out()),
            false => (lane.start, lane.heading_in().map(|heading| -heading)),
        };
        let Some(heading) = heading.filter(|_| !self.is_closed(edge.ids)) else { return Vec::new() };
        let [left, right] = edge.ids.map(|id| self.onward(id, heading, &lane.bounds));
        let pairs = left.iter().flat_map(|a| right.iter().map(move |b| [a, b]));
        pairs.filter_map(|pair| self.between((at, heading), forward, pair)).collect()
    }

    /// The missing piece between two lines that run on behind the end of a lane, or before its start; the lane is given with the
    /// direction of the lines.
    fn between(&self, (at, heading): (usize, Vector), forward: bool, [a, b]: [&Onward; 2]) -> Option<Hole> {
        let lane = &self.map.lanes[at];
        let (edge, next, along) = match forward {
            true => (lane.end, self.map.followers(at), heading),
            false => (lane.start, self.map.predecessors(at), -heading),
        };
        let lines = [a.line, b.line];
        if a.line == b.line || a.end == b.end || self.used.contains(&[a.line.min(b.line), a.line.max(b.line)]) {
            return None;
        }
        if lines.iter().any(|line| self.both.contains(line)) {
            return None;
        }
        let ids = [a.end, b.end];
        if self.is_there(edge.ids, ids) {
            return None;
        }
        let beyond = if forward { self.map.starting_at(ids) } else { self.map.ending_at(ids) };
        let beyond = beyond.iter().copied().find(|&other| other != at && self.is_road(other));
        let idle = lines.iter().filter(|line| !self.bounds.contains(line)).count();
        // The border of the ground of an intersection leads from road to road without a lane along it.
        let is_ground = |line: &LineStringId| !self.bounds.contains(line) && self.is_of_type(*line, "road_border");
        let back: &[usize] = match beyond {
            Some(beyond) if forward => self.map.predecessors(beyond),
            Some(beyond) => self.map.followers(beyond),
            None => &[],
        };
        if !(next.is_empty() && back.is_empty()) && idle < 2 && lines.iter().any(is_ground) {
            return None;
        }
        // Between lanes that go straight on, a lane that only turns leaves ground that looks like a lane.
        if !next.is_empty() && idle == 0 {
            return None;
        }
        if beyond.is_none() && !self.may_lead_out((at, along), next, [a, b], idle) {
            return None;
        }
        let sure = idle == 2 && beyond.is_some();
        let center = self.is_a_lane(&edge, a, b, if sure { SURE_WIDTHS } else { WIDTHS })?;
        let driven = if forward { center.clone() } else { center.reversed() };
        // Other ways on from the one lane, and other ways into the other, begin and end on the same ground. What leads from the
        // one to the other is the piece itself, drawn with copies of its borders.
        let does_not_count = |other: usize| match [next.contains(&other), back.contains(&other)] {
            _ if idle == 0 || beyond.is_none() => false,
            [true, true] => false,
            [one, two] => sure || one || two,
        };
        // Where other ways on from the lane count, they cover the ground near it.
        let most = if beyond.is_none() && !next.is_empty() { COVERED_AT_FORKS } else { COVERED };
        if covered(self.map, self.params, &driven, does_not_count) > most {
            return None;
        }
        let (before, after) = if forward { (Some(at), beyond) } else { (beyond, Some(at)) };
        let outline = a.points.iter().chain(b.points.iter().rev()).copied().collect();
        Some(Hole { before, after, lines, outline, length: center.length() })
    }

    /// Whether a lane leads from one pair of points to another, whichever way, over other lines than those.
    fn is_there(&self, [a, b]: [PointId; 2], [c, d]: [PointId; 2]) -> bool {
        let leads = |from: [PointId; 2], to: [PointId; 2]| {
            self.map.starting_at(from).iter().any(|&at| self.map.lanes[at].end.ids == to)
        };
        leads([a, b], [c, d]) || leads([c, d], [a, b]) || leads([b, a], [d, c]) || leads([d, c], [b, a])
    }

    /// Whether two lines beyond a lane, of which so many bound no lanelet, may be the borders of a lane that leads to none. The lane is
    /// given with the direction in which vehicles drive there.
    fn may_lead_out(&self, (at, along): (usize, Vector), next: &[usize], sides: [&Onward; 2], idle: usize) -> bool {
        let lines = sides.map(|side| side.line);
        if !next.is_empty() {
            // Nobody draws a line that is not there but along a lane.
            let is_drawn_for_a_lane = lines.iter().any(|&line| self.is_of_type(line, "virtual"));
            return idle == 2 && is_drawn_for_a_lane && !lines.iter().any(|&line| self.is_of_type(line, "road_border"));
        }
        // A kerb goes on where the map ends.
        let is_kerb = lines.iter().all(|&line| self.is_of_type(line, "curbstone"));
        // A lane that is dropped beside one that goes on, where paint or nothing takes its place; not between two that go on.
        let is_alone = [true, false].into_iter().all(|end| is_alone(self.moves, at, end));
        let is_dropped = idle == 0 && !is_alone && !self.is_between_lanes(at, along, sides);
        !is_kerb && !is_dropped
    }

    /// Whether both lines bound lanes that run as this one does: between the directions of a road there may be painted ground.
    fn is_between_lanes(&self, at: usize, heading: Vector, sides: [&Onward; 2]) -> bool {
        let runs_along = |side: &Onward| {
            let users = self.map.users_of(side.line).iter().filter(|&&user| user != at && self.map.lanes[user].vehicle);
            let headings = users.filter_map(|&user| {
                let line = self.map.lanes[user].center.as_ref()?;
                Some(line.direction(line.project(*side.points.first()?).station))
            });
            headings
                .into_iter()
                .any(|other: Vector| angle_between(heading, other).abs().to_degrees() <= self.params.straight_on)
        };
        sides.into_iter().all(runs_along)
    }

    /// Whether a line joins two points: behind an end so closed lies an area, no lane.
    fn is_closed(&self, [a, b]: [PointId; 2]) -> bool {
        a == b || self.joined.contains(&[a.min(b), a.max(b)])
    }

    fn is_of_type(&self, line: LineStringId, kind: &str) -> bool {
        self.map.map.linestrings.get(line).is_some_and(|line| line.attributes.is("type", kind))
    }

    /// The lines that run on from a point, roughly in a direction; of too many only the first are looked at.
    fn onward(&self, from: PointId, heading: Vector, own: &[LineStringId; 2]) -> Vec<Onward> {
        let lines = self.by_end.get(&from).into_iter().flatten().filter(|line| !own.contains(line)).take(crowd::MOST);
        let onward = lines.filter_map(|&id| {
            let line = self.map.map.linestrings.get(id)?;
            let mut ids = line.points.clone();
            if ids.first() != Some(&from) {
                ids.reverse();
            }
            let place = |id: &PointId| self.map.map.points.get(*id).map(|point| point.position);
            let points: Vec<Point> = ids.iter().map(place).collect::<Option<_>>()?;
            let first = *points.first()?;
            let along = Polyline::new(points.iter().copied())?.at(MEASURED_EVERY) - first;
            let turn = angle_between(heading, along).abs().to_degrees();
            (turn <= self.params.straight_on).then(|| Onward { line: id, end: *ids.last().unwrap_or(&from), points })
        });
        onward.collect()
    }

    /// The middle between two lines that could be the borders of a lane from here on.
    fn is_a_lane(&self, edge: &Edge, a: &Onward, b: &Onward, [low, high]: [f64; 2]) -> Option<Polyline> {
        let own = edge.across().norm();
        let [left, right] = [a, b].map(|line| Polyline::new(line.points.iter().copied()));
        let (left, right) = (left?, right?);
        let center = center_line(&a.points, &b.points)?;
        let fits = |place: Point| {
            let width = left.distance(place) + right.distance(place);
            (low * own..=high * own).contains(&width)
        };
        let outline: Vec<Point> = a.points.iter().chain(b.points.iter().rev()).copied().collect();
        (center.places(MEASURED_EVERY).all(fits) && crate::geometry::simple_ring::is_simple(&outline)).then_some(center)
    }
}

/// Lines that bound no lanelet, and run point for point where a bound does.
fn copies(map: &MapIndex, bounds: &FxHashSet<LineStringId>) -> FxHashSet<LineStringId> {
    let course = |line: &LineString| -> Option<Vec<[i64; 2]>> {
        let place = |id: &PointId| map.map.points.get(*id).map(|point| point.position);
        let cells =
            line.points.iter().map(|id| place(id).map(|at| [at.x, at.y].map(|x| (x / SAME_PLACE).round() as i64)));
        let mut cells: Vec<[i64; 2]> = cells.collect::<Option<_>>()?;
        // Whichever way it was drawn.
        if cells.first() > cells.last() {
            cells.reverse();
        }
        Some(cells)
    };
    let (used, idle): (Vec<_>, Vec<_>) = map.map.linestrings.iter().partition(|line| bounds.contains(&line.id));
    let courses: FxHashSet<Vec<[i64; 2]>> = used.into_iter().filter_map(course).collect();
    idle.into_iter().filter(|line| course(line).is_some_and(|it| courses.contains(&it))).map(|line| line.id).collect()
}

/// Whether lanelets of the same direction, or along which people walk, lie on the ground of a missing piece.
pub fn is_covered(map: &MapIndex, params: &Params, center: &Polyline) -> bool {
    covered(map, params, center, |_| false) > COVERED
}

/// The share (1) of the ground of a missing piece that lies under such lanelets, without those that `do_not_count`.
fn covered(map: &MapIndex, params: &Params, center: &Polyline, do_not_count: impl Fn(usize) -> bool) -> f64 {
    let places: Vec<Point> = center.places(MEASURED_EVERY).collect();
    let inner = places.iter().skip(1).take(places.len().saturating_sub(2));
    let [mut all, mut covered] = [0_u32, 0_u32];
    for place in inner {
        all += 1;
        let heading = center.direction(center.project(*place).station);
        let lies_on = |&at: &usize| {
            let lane = &map.lanes[at];
            let along = lane.center.as_ref().map(|line| line.direction(line.project(*place).station));
            let turn = along.map_or(0.0, |along| angle_between(heading, along).abs().to_degrees());
            // What people walk along takes the place of a lane; what leads across does not.
            let turn = if lane.vehicle { turn } else { turn.min(180.0 - turn) };
            !do_not_count(at) && turn <= params.straight_on && polygon::contains(&lane.outline, *place)
        };
        covered += u32::from(map.lanes_near(*place, *place).iter().any(lies_on));
    }
    f64::from(covered) / f64::from(all.max(1))
}

impl Hole {
    /// The lanes whose end and whose start it explains.
    pub fn lanes(&self) -> [Option<usize>; 2] {
        [self.before, self.after]
    }

    pub fn into_finding(self, map: &MapIndex) -> Option<Finding> {
        let [left, right] = self.lines;
        let id = |lane: usize| map.lanes[lane].id;
        let (first, between) = match (self.before, self.after) {
            (Some(before), Some(after)) => (before, format!("from lane {} to lane {}", id(before), id(after))),
            (Some(before), None) => (before, format!("on from lane {}", id(before))),
            (None, Some(after)) => (after, format!("up to lane {}", id(after))),
            (None, None) => return None,
        };
        let message =
            format!("No lanelet lies between ways {left} and {right}, which lead {between} over {:.0} m.", self.length);
        let finding = Finding::new("hole", subject(map, first), message)
            .with(Subject::LineString(left.0), "border")
            .with(Subject::LineString(right.0), "border")
            .at(Place::Polygon(self.outline));
        let other = self.after.filter(|&after| after != first);
        Some(other.into_iter().fold(finding, |finding, other| finding.with(subject(map, other), "goes on here")))
    }
}
