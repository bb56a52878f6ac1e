//! Ends of lanes that should be one and are not.

use std::cell::{LazyCell, OnceCell};
use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::geometry::{Point, angle_between};
use crate::lanelet::index::{Edge, MapIndex};
use crate::lanelet::{LineStringId, PointId};

use super::params::Params;
use crate::rules::near_nodes::{NodeClusters, ends_of_borders};

/// Two nodes that nearly coincide, with the lanes that they keep apart.
struct Miss {
    distance: f64,
    /// Each pair of them, where one ends and another starts.
    lanes: Vec<[usize; 2]>,
    place: Point,
}

/// All pairs of nodes that should be one, and the lanes whose start or end they are.
pub struct Misses<'m> {
    map: &'m MapIndex<'m>,
    limit: f64,
    pairs: BTreeMap<[PointId; 2], Miss>,
    ends: FxHashSet<usize>,
    starts: FxHashSet<usize>,
}

/// Where a lane of an intersection nearly starts at the end of another, or ends at its start.
pub fn near_misses<'m>(map: &'m MapIndex<'m>, params: &Params) -> Misses<'m> {
    let mut misses = Misses {
        map,
        limit: params.near_miss,
        pairs: BTreeMap::new(),
        ends: FxHashSet::default(),
        starts: FxHashSet::default(),
    };
    let stubs = ends_of_borders(map);
    for y in (0..map.lanes.len()).filter(|&lane| map.lanes[lane].is_drivable()) {
        for x in ending_near(map, params, y, &map.lanes[y].start) {
            if map.movement(x).is_none() && map.movement(y).is_none() {
                continue;
            }
            // A short lanelet lies between them.
            let pairs = map.lanes[x].end.ids.into_iter().zip(map.lanes[y].start.ids);
            if pairs.map(|(a, b)| [a.min(b), a.max(b)]).any(|pair| stubs.contains(&pair)) {
                continue;
            }
            misses.ends.insert(x);
            misses.starts.insert(y);
            let (end, start) = (map.lanes[x].end, map.lanes[y].start);
            for side in 0..2 {
                let [a, b] = [end.ids[side], start.ids[side]];
                let distance = (end.points[side] - start.points[side]).norm();
                if a != b {
                    let miss = || Miss { distance, lanes: Vec::new(), place: end.points[side] };
                    misses.pairs.entry([a.min(b), a.max(b)]).or_insert_with(miss).lanes.push([x, y]);
                }
            }
        }
    }
    misses
}

/// Lanes that end close to where a lane starts, in its direction, but not there, and that no lane leads on to it.
fn ending_near(map: &MapIndex, params: &Params, y: usize, start: &Edge) -> Vec<usize> {
    let near = map.edges_near(start.middle(), params.near_miss, true);
    near.into_iter().filter(|&x| ends_near(map, params, x, y, start)).collect()
}

/// Whether one lane ends close to where another starts, as [`ending_near`] asks.
fn ends_near(map: &MapIndex, params: &Params, x: usize, y: usize, start: &Edge) -> bool {
    let end = &map.lanes[x].end;
    x != y
        && map.lanes[x].is_drivable()
        && end.ids != start.ids
        && end.points.iter().zip(start.points).all(|(a, b)| (b - a).norm() < params.near_miss)
        && map.are_ends_level(end, start)
        && straight_on(map, params, x, y)
        && !map.are_linked(x, y)
}

fn straight_on(map: &MapIndex, params: &Params, x: usize, y: usize) -> bool {
    let headings = map.lanes[x].heading_out().zip(map.lanes[y].heading_in());
    headings.is_some_and(|(a, b)| angle_between(a, b).abs().to_degrees() <= params.near_angle)
}

/// Which lanes come so close to another one's end that near-miss says what is wrong; asked once for each end, however many areas it
/// lies on.
pub struct NearContinuations<'m> {
    map: &'m MapIndex<'m>,
    params: &'m Params,
    /// Per lane, of its start and of its end.
    known: Vec<[OnceCell<bool>; 2]>,
}

impl<'m> NearContinuations<'m> {
    pub fn new(map: &'m MapIndex<'m>, params: &'m Params) -> Self {
        Self { map, params, known: map.lanes.iter().map(|_| Default::default()).collect() }
    }

    /// Whether another lane nearly leads to one, or nearly goes on from it.
    pub fn has(&self, at: usize, edge: &Edge) -> bool {
        let is_start = *edge == self.map.lanes[at].start;
        *self.known[at][usize::from(!is_start)]
            .get_or_init(|| nearly_continues(self.map, self.params, at, edge, is_start))
    }
}

fn nearly_continues(map: &MapIndex, params: &Params, at: usize, edge: &Edge, is_start: bool) -> bool {
    if is_start {
        return !ending_near(map, params, at, edge).is_empty();
    }
    let reach = nalgebra::Vector2::repeat(params.near_miss);
    let near = map.lanes_near(edge.middle() - reach, edge.middle() + reach);
    near.into_iter().any(|y| ends_near(map, params, at, y, &map.lanes[y].start))
}

impl Misses<'_> {
    /// One finding for each pair of nodes.
    pub fn into_findings(self) -> Vec<Finding> {
        let map = self.map;
        let clusters = NodeClusters::of(map, self.pairs.keys().copied(), self.limit);
        let clusters = clusters.between(self.pairs.iter().map(|(pair, miss)| (*pair, miss.lanes.as_slice())));
        let told = self.pairs.into_iter().filter(|(pair, _)| clusters.tells(*pair));
        let findings = told.filter_map(|([older, newer], miss)| {
            let [a, b] = miss.lanes.first()?.map(|lane| map.lanes[lane].id);
            let message =
                format!("Nodes {older} and {newer} are {:.3} m apart; {a} and {b} do not connect.", miss.distance);
            let finding = Finding::new("near-miss", Subject::Point(newer.0), message)
                .with(Subject::Point(older.0), "node nearby")
                .with(Subject::Lanelet(a.0), "ends here")
                .with(Subject::Lanelet(b.0), "starts here")
                .measured(miss.distance, self.limit, "m")
                .at(Place::Point(miss.place));
            Some(clusters.made_one(map, finding, [older, newer]))
        });
        findings.collect()
    }
}

/// Lanelets of intersections that come from nowhere or lead nowhere.
pub fn dangling(map: &MapIndex, params: &Params, misses: &Misses) -> Vec<Finding> {
    let mut findings = Vec::new();
    let edges = LazyCell::new(|| Edges::of(map));
    // A lanelet without turn_direction is not finished; what follows shows when it is.
    let all = map.traffic.iter().flat_map(|traffic| &traffic.movements).map(|movement| movement.lane);
    for lane in all.filter(|&lane| map.turn_direction(lane).is_some()) {
        let id = map.lanes[lane].id;
        let before = map.predecessors(lane).is_empty();
        let after = map.followers(lane).is_empty();
        let what = match (before, after) {
            (true, true) => "predecessor and no successor",
            (true, false) => "predecessor",
            (false, true) => "successor",
            (false, false) => continue,
        };
        let edge = if before { map.lanes[lane].start } else { map.lanes[lane].end };
        let message = format!("Lanelet {id} of the intersection has no {what}.");
        let finding = Finding::new("dangling-il", Subject::Lanelet(id.0), message);
        let inside = (before && !misses.starts.contains(&lane) && goes_on(map, params, lane, true))
            || (after && !misses.ends.contains(&lane) && goes_on(map, params, lane, false));
        let finding = finding.at(Place::Line(edge.points.to_vec()));
        let finding = if inside { finding.graded(Severity::Error) } else { finding };
        let turned = before && after && edges.would_connect(map, lane);
        findings.push(match turned {
            true => turned_around(map, finding, lane),
            false if before && after && is_stray(map, lane) => {
                let edits = vec![Edit::Remove { subject: finding.subject }];
                finding.fixed_by("remove the lanelet, which touches nothing", false, edits)
            }
            false => finding,
        });
    }
    findings
}

/// Whether no other lane has a node or a bound of a lane, and no regulatory element rules it.
fn is_stray(map: &MapIndex, lane: usize) -> bool {
    let nodes = |lane: usize| {
        let lines = map.lanes[lane].bounds.into_iter().filter_map(|way| map.map.linestrings.get(way));
        lines.flat_map(|line| line.points.iter().copied())
    };
    let own: FxHashSet<PointId> = nodes(lane).collect();
    let [low, high] = map.lanes[lane].extent;
    let touches = |other: usize| nodes(other).any(|node| own.contains(&node));
    map.lanes[lane].lanelet.regulatory_elements.is_empty()
        && map.lanes_near(low, high).into_iter().all(|other| other == lane || !touches(other))
}

/// The points, left and right, where lanes start and where they end.
struct Edges {
    starts: FxHashSet<[PointId; 2]>,
    ends: FxHashSet<[PointId; 2]>,
}

impl Edges {
    fn of(map: &MapIndex) -> Self {
        let starts = map.lanes.iter().map(|lane| lane.start.ids).collect();
        Self { starts, ends: map.lanes.iter().map(|lane| lane.end.ids).collect() }
    }

    /// Whether a lane would follow one lane and lead to another if it ran the other way.
    fn would_connect(&self, map: &MapIndex, lane: usize) -> bool {
        let [start, end] = [map.lanes[lane].start, map.lanes[lane].end].map(|edge| [edge.ids[1], edge.ids[0]]);
        self.ends.contains(&end) && self.starts.contains(&start)
    }
}

/// Adds the edits that exchange the roles of a lanelet's bounds, so that it runs the other way.
fn turned_around(map: &MapIndex, finding: Finding, lane: usize) -> Finding {
    let lanelet = map.lanes[lane].lanelet;
    let (on, [left, right]) = (finding.subject, [lanelet.left.line, lanelet.right.line]);
    let role = |line: LineStringId, from: &'static str, to: &'static str| Edit::SetRole {
        on,
        member: Subject::LineString(line.0),
        from: from.into(),
        to: to.into(),
    };
    let edits = vec![role(left, "left", "right"), role(right, "right", "left")];
    finding.fixed_by("exchange its bounds, so that it runs from lane to lane", false, edits)
}

/// Whether the map goes on behind a loose end: a lane lies straight ahead, or behind, close by.
fn goes_on(map: &MapIndex, params: &Params, lane: usize, backward: bool) -> bool {
    let this = &map.lanes[lane];
    let (edge, heading) = match backward {
        true => (&this.start, this.heading_in().map(|heading| -heading)),
        false => (&this.end, this.heading_out()),
    };
    let Some(heading) = heading else { return false };
    let ahead = edge.middle() + heading * params.map_border;
    let near = map.lanes_near(edge.middle().inf(&ahead), edge.middle().sup(&ahead));
    near.into_iter().any(|other| {
        let other_lane = &map.lanes[other];
        let direction = if backward { other_lane.heading_out() } else { other_lane.heading_in().map(|h| -h) };
        let end = if backward { &other_lane.end } else { &other_lane.start };
        let toward = direction.is_some_and(|d| angle_between(d, -heading).abs().to_degrees() <= params.near_angle);
        let on_line = heading.dot(&(end.middle() - edge.middle())) > 0.0
            && (end.middle() - edge.middle()).norm() <= params.map_border;
        other != lane && other_lane.is_drivable() && map.movement(other).is_none() && toward && on_line
    })
}
