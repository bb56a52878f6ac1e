//! Lanes that should follow each other and do not: nodes apart, a piece missing, roles exchanged.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Point, Polyline, Vector, angle_between, cross};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{LaneletId, PointId};
use crate::rules::crowd;
use crate::rules::near_nodes::{NodeClusters, are_on_one_floor, ends_of_borders};
use crate::rules::routing_moves::RoutingMoves;
use crate::rules::two_way::leads_on_backwards;

use super::holes::{Hole, Holes, is_covered};
use super::params::{Params, subject};
use super::street_ends::{is_alone, is_street, is_turning_place};

/// The end of a lane that is no wider than this, metres, is a point.
const THIN: f64 = 0.2;

/// How far apart two nodes are, metres, which lanes they keep apart, and where.
struct Miss {
    distance: f64,
    /// Each pair of lanes, where one ends and another starts.
    lanes: Vec<[usize; 2]>,
    place: Point,
}

/// Lanes outside intersections that nearly continue each other. Those of intersections are the business of vm-03-04.
pub struct Links<'m> {
    map: &'m MapIndex<'m>,
    near_miss: f64,
    /// Two nodes that should be one, with the lanes that they keep apart.
    misses: BTreeMap<[PointId; 2], Miss>,
    /// The length of a gap, the longest that is looked for there, and the lanes before and behind it.
    gaps: Vec<(f64, f64, usize, usize)>,
    head_on: Vec<(usize, usize, bool)>,
    /// A lane with more lanes at one of its ends than are compared: the fault, their number, and what they do there.
    crowds: Vec<(&'static str, usize, usize, &'static str)>,
    holes: Vec<Hole>,
    /// Lanes of which it is already said what is wrong with their end.
    pub ends: BTreeSet<usize>,
    /// The same of their start.
    pub starts: BTreeSet<usize>,
}

impl<'m> Links<'m> {
    pub fn new(map: &'m MapIndex<'m>, params: &Params, moves: &RoutingMoves) -> Self {
        let mut links = Self {
            map,
            near_miss: params.near_miss,
            misses: BTreeMap::new(),
            gaps: Vec::new(),
            head_on: Vec::new(),
            crowds: Vec::new(),
            holes: Vec::new(),
            ends: (0..map.lanes.len()).filter(|&at| map.is_at_unloaded(&map.lanes[at].end)).collect(),
            starts: (0..map.lanes.len()).filter(|&at| map.is_at_unloaded(&map.lanes[at].start)).collect(),
        };
        links.find_near_misses(params);
        links.find_head_on();
        links.find_gaps(params);
        links.find_holes(params, moves);
        links.find_wide_gaps(params, moves);
        links
    }

    /// Lanes for vehicles that drive forward, outside intersections.
    fn lanes(&self) -> impl Iterator<Item = usize> + 'm {
        let map = self.map;
        let is_forward = move |at: usize| map.lanes[at].vehicle && !map.lanes[at].reverses();
        (0..map.lanes.len()).filter(move |&at| is_forward(at) && map.movement(at).is_none())
    }

    /// Lanes whose end lies no farther from a lane's start, and that head the same way.
    fn ending_near(&self, params: &Params, y: usize, reach: f64) -> Vec<usize> {
        let (map, start) = (self.map, self.map.lanes[y].start);
        let near = map.edges_near(start.middle(), reach, true);
        let heading = map.lanes[y].heading_in();
        let fits = |&x: &usize| {
            let lane = &map.lanes[x];
            x != y
                && lane.vehicle
                && lane.end.ids != start.ids
                && (lane.end.middle() - start.middle()).norm() <= reach
                && lane.heading_out().zip(heading).is_some_and(|(a, b)| turn(a, b) <= params.straight_on)
                && map.movement(x).is_none()
                && !lane.reverses()
        };
        near.into_iter().filter(fits).collect()
    }

    fn find_near_misses(&mut self, params: &Params) {
        let stubs = ends_of_borders(self.map);
        for y in self.lanes() {
            let start = self.map.lanes[y].start;
            let near = self.ending_near(params, y, 2.0 * params.near_miss);
            if near.len() > crowd::MOST {
                self.crowds.push(("near-miss", y, near.len(), "lanes end where it starts"));
            }
            for x in near.into_iter().take(crowd::MOST) {
                let end = self.map.lanes[x].end;
                let apart = |side: usize| (end.points[side] - start.points[side]).norm();
                let is_level = (0..2).all(|side| are_on_one_floor(self.map, end.ids[side], start.ids[side]));
                // The lane beside a narrow one starts close to its end, too.
                let half = end.across().norm().min(start.across().norm()) / 2.0;
                let is_beside = half > THIN && (end.middle() - start.middle()).norm() > half;
                // Lanes that lead on from here as they should need no other way on.
                // Where a short lanelet lies between them, they are not to be one.
                let mut pairs = end.ids.into_iter().zip(start.ids).map(|(a, b)| [a.min(b), a.max(b)]);
                let is_beside = is_beside || pairs.any(|pair| stubs.contains(&pair));
                if is_beside || apart(0).max(apart(1)) >= params.near_miss || !is_level || self.map.are_linked(x, y) {
                    continue;
                }
                self.ends.insert(x);
                self.starts.insert(y);
                for side in (0..2).filter(|&side| end.ids[side] != start.ids[side]) {
                    let [a, b] = [end.ids[side], start.ids[side]];
                    let miss = || Miss { distance: apart(side), lanes: Vec::new(), place: end.points[side] };
                    self.misses.entry([a.min(b), a.max(b)]).or_insert_with(miss).lanes.push([x, y]);
                }
            }
        }
    }

    /// Lanes that end on the same nodes from opposite sides, or start there, and that nothing else leads on from.
    fn find_head_on(&mut self) {
        let map = self.map;
        for start in [false, true] {
            let mut open: BTreeMap<[PointId; 2], Vec<usize>> = BTreeMap::new();
            for at in self.lanes() {
                let (edge, next) = match start {
                    true => (map.lanes[at].start, map.predecessors(at)),
                    false => (map.lanes[at].end, map.followers(at)),
                };
                if next.is_empty() && !leads_on_backwards(map, at, !start) {
                    open.entry(edge.ids).or_default().push(at);
                }
            }
            let mut pairs: Vec<(usize, usize)> = Vec::new();
            for (&[left, right], lanes) in &open {
                let others = open.get(&[right, left]).map_or(&[][..], Vec::as_slice);
                if lanes.len() > crowd::MOST && !others.is_empty() {
                    let what = if start { "lanes start on the same points" } else { "lanes end on the same points" };
                    self.crowds.push(("head-on", lanes[0], lanes.len(), what));
                }
                let others = others.iter().take(crowd::MOST);
                let lanes = lanes.iter().take(crowd::MOST);
                pairs.extend(others.flat_map(|&y| lanes.clone().map(move |&x| (x, y))).filter(|(x, y)| x < y));
            }
            pairs.sort_unstable();
            for (x, y) in pairs {
                self.head_on.push((x, y, start));
                let said = if start { &mut self.starts } else { &mut self.ends };
                said.extend([x, y]);
            }
        }
    }

    /// Lanes that end a little before another one starts.
    fn find_gaps(&mut self, params: &Params) {
        let map = self.map;
        for y in self.lanes().filter(|&y| map.predecessors(y).is_empty()) {
            if self.starts.contains(&y) || leads_on_backwards(map, y, false) {
                continue;
            }
            let start = map.lanes[y].start;
            let before = self.ending_near(params, y, params.gap);
            let is_loose = |x: &usize| map.followers(*x).is_empty() && !leads_on_backwards(map, *x, true);
            let open = before.into_iter().filter(|x| is_loose(x) && !self.ends.contains(x));
            let ahead = |x: usize| -> Option<f64> {
                let (end, heading) = (map.lanes[x].end, map.lanes[x].heading_out()?);
                let way = start.middle() - end.middle();
                let half = end.across().norm().min(start.across().norm()) / 2.0;
                (heading.dot(&way) > 0.0 && cross(heading, way).abs() < half && map.are_ends_level(&end, &start))
                    .then(|| way.norm())
            };
            let nearest = open.filter_map(|x| Some((ahead(x)?, x))).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((length, x)) = nearest {
                self.gaps.push((length, params.gap, x, y));
            }
        }
        self.note_gaps();
    }

    fn note_gaps(&mut self) {
        for &(.., x, y) in &self.gaps {
            self.ends.insert(x);
            self.starts.insert(y);
        }
    }

    /// Roads that end where nobody can turn, and resume farther on along one bend, with nothing in between.
    fn find_wide_gaps(&mut self, params: &Params, moves: &RoutingMoves) {
        let map = self.map;
        let loose = |end: bool| if end { &map.settings.loose_ends.ends } else { &map.settings.loose_ends.starts };
        let is_loose = |at: usize, end: bool| {
            let next = if end { map.followers(at) } else { map.predecessors(at) };
            next.is_empty()
                && !leads_on_backwards(map, at, end)
                && is_street(map, at)
                && !loose(end).contains(&map.lanes[at].id.0)
                && is_alone(moves, at, end)
                && !is_turning_place(map, params, at, end)
        };
        // Asked once for each lane: many may end near where many start.
        let ending: FxHashSet<usize> = self.lanes().filter(|&x| !self.ends.contains(&x) && is_loose(x, true)).collect();
        let mut found: Vec<(f64, f64, usize, usize)> = Vec::new();
        for y in self.lanes().filter(|&y| !self.starts.contains(&y) && is_loose(y, false)) {
            let before = self.ending_near(params, y, params.wide_gap);
            let open = before.into_iter().filter(|x| ending.contains(x));
            let nearest = open.filter_map(|x| Some((self.bend(params, x, y)?, x))).min_by(|a, b| a.0.total_cmp(&b.0));
            found.extend(nearest.map(|(length, x)| (length, params.wide_gap, x, y)));
        }
        self.gaps.extend(found);
        self.note_gaps();
    }

    /// The distance from the end of a lane to the start of another, if one bend leads there over ground without lanes along it.
    fn bend(&self, params: &Params, x: usize, y: usize) -> Option<f64> {
        let [a, b] = [&self.map.lanes[x], &self.map.lanes[y]];
        let way = b.start.middle() - a.end.middle();
        let turns = [angle_between(a.heading_out()?, way), angle_between(way, b.heading_in()?)];
        // By so much the road would have to swing sideways and back.
        let sideways = (turns[0] - turns[1]).abs() / 2.0 * way.norm();
        let half = a.end.across().norm().min(b.start.across().norm()) / 2.0;
        let is_ahead = turns.iter().all(|turn| turn.abs().to_degrees() <= params.straight_on);
        if !is_ahead || sideways > half || !self.map.are_ends_level(&a.end, &b.start) {
            return None;
        }
        let line = Polyline::new([a.end.middle(), b.start.middle()])?;
        (!is_covered(self.map, params, &line)).then(|| way.norm())
    }

    /// Pieces of road of which the borders are there and the lanelet is not.
    fn find_holes(&mut self, params: &Params, moves: &RoutingMoves) {
        let is_said = |hole: &Hole| {
            let [before, after] = hole.lanes();
            before.is_some_and(|lane| self.ends.contains(&lane))
                || after.is_some_and(|lane| self.starts.contains(&lane))
        };
        let (holes, crowds) = Holes::new(self.map, params, moves).find();
        self.holes = holes.into_iter().filter(|hole| !is_said(hole)).collect();
        self.crowds
            .extend(crowds.into_iter().map(|(lane, count)| ("hole", lane, count, "lines meet at its end or start")));
        for [before, after] in self.holes.iter().map(Hole::lanes) {
            self.ends.extend(before);
            self.starts.extend(after);
        }
    }

    pub fn into_findings(mut self) -> Vec<Finding> {
        let map = self.map;
        let near = self.near_miss;
        let holes = std::mem::take(&mut self.holes);
        let name = |lane: usize| map.lanes[lane].id;
        let clusters = NodeClusters::of(map, self.misses.keys().copied(), near);
        let clusters = clusters.between(self.misses.iter().map(|(pair, miss)| (*pair, miss.lanes.as_slice())));
        let told = self.misses.iter().filter(|(pair, _)| clusters.tells(**pair));
        let misses = told.filter_map(|([older, newer], Miss { distance, lanes, place })| {
            let [x, y] = lanes.first()?;
            let (a, b) = (name(*x), name(*y));
            let message = format!("Nodes {older} and {newer} are {distance:.3} m apart; {a} and {b} do not connect.");
            let finding = Finding::new("near-miss", Subject::Point(newer.0), message)
                .with(Subject::Point(older.0), "node nearby")
                .with(subject(map, *x), "ends here")
                .with(subject(map, *y), "starts here")
                .measured(*distance, near, "m")
                .at(Place::Point(*place));
            Some(clusters.made_one(map, finding, [*older, *newer]))
        });
        let gaps = self.gaps.iter().map(|&(length, gap, x, y)| {
            let message = format!("Lane {} ends {length:.2} m before lane {} starts.", name(x), name(y));
            Finding::new("gap", subject(map, x), message)
                .with(subject(map, y), "starts here")
                .measured(length, gap, "m")
                .at(Place::Line(vec![map.lanes[x].end.middle(), map.lanes[y].start.middle()]))
        });
        let mut ends: FxHashMap<usize, usize> = FxHashMap::default();
        self.head_on
            .iter()
            .for_each(|&(x, y, _)| [x, y].into_iter().for_each(|lane| *ends.entry(lane).or_default() += 1));
        let both = |lane: usize| ends.get(&lane).is_some_and(|count| *count > 1);
        let head_on = self.head_on.iter().map(|&(x, y, start)| self.opposed([x, y], [both(x), both(y)], start));
        let crowds = self.crowds.iter().map(|&(fault, lane, count, what)| {
            let message = format!("Lane {}: {}", name(lane), crowd::too_many(count, what));
            Finding::new(fault, subject(map, lane), message)
        });
        let holes = holes.into_iter().filter_map(|hole| hole.into_finding(map));
        misses.chain(gaps).chain(head_on).chain(crowds).chain(holes).collect()
    }

    /// Two lanes that meet head on, or drive away from each other; `both` tells of each whether it is wrong at both ends.
    fn opposed(&self, [x, y]: [usize; 2], both: [bool; 2], start: bool) -> Finding {
        let map = self.map;
        // The one that is wrong at both ends is the one with the roles exchanged.
        let turned = both[0] != both[1];
        let (at, other) = if turned && both[1] { (y, x) } else { (x, y) };
        let [a, b] = [at, other].map(|lane| map.lanes[lane].id);
        let (what, edge) = match start {
            true => ("start on the same points, away from each other", map.lanes[at].start),
            false => ("end on the same points, against each other", map.lanes[at].end),
        };
        let finding = Finding::new("head-on", subject(map, at), format!("Lanes {a} and {b} {what}."))
            .with(subject(map, other), "other lane")
            .at(Place::Line(edge.points.to_vec()));
        if turned { exchanged(map, a, finding) } else { finding }
    }
}

/// Proposes to exchange the roles of a lanelet's bounds.
fn exchanged(map: &MapIndex, id: LaneletId, finding: Finding) -> Finding {
    let Some(lanelet) = map.map.lanelets.get(id) else { return finding };
    let role = |line: i64, from: &str, to: &str| Edit::SetRole {
        on: Subject::Lanelet(id.0),
        member: Subject::LineString(line),
        from: from.into(),
        to: to.into(),
    };
    let edits = vec![role(lanelet.left.line.0, "left", "right"), role(lanelet.right.line.0, "right", "left")];
    finding.fixed_by(format!("exchange the roles left and right of lanelet {id}"), false, edits)
}

/// Angle between two headings, degrees.
fn turn(a: Vector, b: Vector) -> f64 {
    angle_between(a, b).abs().to_degrees()
}
