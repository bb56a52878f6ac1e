//! Two roads that continue each other lane by lane: they meet face to face and share their end nodes.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::network_diff::NetworkDiff;
use crate::builder::network::road_end::{LaneAt, inward, lanes_at};
use crate::builder::network::{End, IntersectionIx, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::cross_section::StripKind;
use crate::builder::tags::side_strips::strip_runs;
use crate::geometry::miter::miter;
use crate::geometry::{Point, angle_between};
use crate::lanelet::PointId;

use super::gore::{EdgeAt, GoreCorner};

/// Roads meet face to face up to this change of direction, degrees; beyond, a curve joins them.
const ANGLE_MOST: f64 = 30.0;
/// Borders meet face to face up to this distance, metres; beyond, a taper joins them.
const STEP_MOST: f64 = 0.5;
/// Ends that are not to be one lie so far apart, metres.
const APART: f64 = 0.06;

/// Where the edges of two roads meet.
#[derive(Clone, Debug, PartialEq)]
struct Meeting {
    /// Key of the shared node.
    key: Key,
    /// Its place.
    place: Point,
}

/// All places where roads meet face to face, and where they lie side by side.
#[derive(Debug, Default)]
pub struct Continuations {
    intersections: Vec<bool>,
    meetings: Vec<Meeting>,
    of_edge: FxHashMap<(RoadEnd, usize), usize>,
    /// The nodes of the meetings, once they are placed.
    points: FxHashMap<usize, PointId>,
    /// The meetings of roads that lie side by side.
    seams: FxHashMap<[EdgeAt; 2], usize>,
}

impl Continuations {
    /// Finds them in the network.
    pub fn find(network: &RoadNetwork) -> Self {
        let mut joins = Self::default();
        for (i, intersection) in network.intersections.iter().enumerate() {
            let pairs = match intersection.arms[..] {
                [a, b] if a.road != b.road => edge_pairs(network, a, b),
                _ => None,
            };
            joins.intersections.push(pairs.is_some());
            let [a, b] = intersection.arms[..] else { continue };
            let node = intersection.nodes.first().copied().unwrap_or(i as i64);
            for EdgePair { edges: [edge_a, edge_b], place, shared } in pairs.unwrap_or_default() {
                let key = Key::new("join").number(node).number(edge_a as i64);
                joins.of_edge.insert((a, edge_a), joins.meetings.len());
                if !shared {
                    joins.meetings.push(Meeting { key, place });
                }
                joins.of_edge.insert((b, edge_b), joins.meetings.len());
                let beyond = || Meeting { key: key.word("beyond"), place: behind(network, b, place) };
                joins.meetings.push(if shared { Meeting { key, place } } else { beyond() });
            }
        }
        joins
    }

    /// Takes these corners as those that roads share side by side, instead of what was. Gives the roads for which that
    /// changes anything.
    pub fn beside(&mut self, seams: Vec<GoreCorner>) -> FxHashSet<RoadIx> {
        let mut wanted: FxHashMap<[EdgeAt; 2], GoreCorner> = seams.iter().map(|seam| (seam.edges, *seam)).collect();
        let mut changed = FxHashSet::default();
        let Self { meetings, of_edge, points, seams: known, .. } = self;
        known.retain(|edges, meeting| {
            let stays = wanted.get(edges).is_some_and(|seam| seam.place == meetings[*meeting].place);
            if stays {
                wanted.remove(edges);
            } else {
                changed.extend(edges.iter().map(|(at, _)| at.road));
                edges.iter().for_each(|edge| {
                    of_edge.remove(edge);
                });
                points.remove(meeting);
            }
            stays
        });
        for GoreCorner { edges, key, place } in seams.into_iter().filter(|seam| wanted.contains_key(&seam.edges)) {
            changed.extend(edges.iter().map(|(at, _)| at.road));
            self.of_edge.extend(edges.map(|edge| (edge, self.meetings.len())));
            self.seams.insert(edges, self.meetings.len());
            self.meetings.push(Meeting { key, place });
        }
        changed
    }

    /// Takes over the nodes where the same edges met at the same places in the network before. Gives the roads that end
    /// elsewhere than before.
    pub fn take_over(&mut self, before: &Self, origins: &NetworkDiff) -> FxHashSet<RoadIx> {
        // How many edges met in each place and do so no more.
        let mut missing = vec![0_usize; before.meetings.len()];
        before.of_edge.values().for_each(|meeting| missing[*meeting] += 1);
        let mut was: Vec<Option<usize>> = vec![None; self.meetings.len()];
        let mut other = vec![false; self.meetings.len()];
        for (&(at, edge), &meeting) in &self.of_edge {
            let met = before.of_edge.get(&(origins.of_end(at), edge));
            match met.filter(|met| before.meetings[**met] == self.meetings[meeting]) {
                Some(&met) => {
                    missing[met] -= 1;
                    was[meeting] = Some(met);
                }
                None => other[meeting] = true,
            }
        }
        let mut changed = FxHashSet::default();
        let Self { of_edge, points, .. } = self;
        for (&(at, _), &meeting) in &*of_edge {
            let stays = was[meeting].filter(|met| !other[meeting] && missing[*met] == 0);
            match stays.and_then(|met| before.points.get(&met)) {
                Some(&node) => {
                    points.insert(meeting, node);
                }
                None => {
                    changed.insert(at.road);
                }
            }
        }
        let now = |&(at, edge): &EdgeAt| Some((RoadEnd { road: origins.now(at.road)?, ..at }, edge));
        let parted = before.of_edge.keys().filter_map(now).filter(|edge| !of_edge.contains_key(edge));
        changed.extend(parted.map(|(at, _)| at.road));
        changed
    }

    /// Whether the roads of this intersection meet face to face.
    pub fn joined(&self, ix: IntersectionIx) -> bool {
        self.intersections.get(ix.position()).copied().unwrap_or(false)
    }

    /// Adds the nodes that two roads share, as far as they are not there yet.
    pub fn place(&mut self, assembly: &mut MapBuilder, network: &RoadNetwork) {
        let new = self.of_edge.iter().filter(|(_, meeting)| !self.points.contains_key(meeting));
        let new: BTreeSet<(usize, RoadIx)> = new.map(|((at, _), meeting)| (*meeting, at.road)).collect();
        for (meeting, road) in new {
            if !self.points.contains_key(&meeting) {
                assembly.set_ground(Ground::under(network.road(road)));
                let Meeting { key, place } = self.meetings[meeting].clone();
                self.points.insert(meeting, assembly.point(key, place, 0.0));
            }
        }
        assembly.set_ground(Ground::default());
    }

    /// Takes back the nodes that these roads share with others, to be placed anew.
    pub fn lift(&mut self, roads: &[RoadIx]) {
        let of_roads = self.of_edge.iter().filter(|((at, _), _)| roads.binary_search(&at.road).is_ok());
        let lifted: FxHashSet<usize> = of_roads.map(|(_, meeting)| *meeting).collect();
        self.points.retain(|meeting, _| !lifted.contains(meeting));
    }

    /// All nodes that two roads share.
    pub fn nodes(&self) -> FxHashSet<PointId> {
        self.points.values().copied().collect()
    }

    /// The node that an edge of a road's cross-section shares with another road; `None` if it shares none.
    pub fn node(&self, at: RoadEnd, edge: usize) -> Option<PointId> {
        self.points.get(self.of_edge.get(&(at, edge))?).copied()
    }
}

/// The same place, but so far back on the second road that two nodes are told apart.
fn behind(network: &RoadNetwork, at: RoadEnd, place: Point) -> Point {
    let road = network.road(at.road);
    let station = if at.end == End::Start { 0.0 } else { road.line.length() };
    place - inward(road, at.end, station) * APART
}

/// A lane at the end of a road, for the comparison of two roads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// What its strip is for.
    kind: StripKind,
    /// Whether it runs from the first road to the second.
    pub onward: bool,
    /// Index of its strip.
    pub strip: usize,
    /// Its left and its right edge, seen along the way from the first road to the second.
    edges: [usize; 2],
}

/// Lanes at an end, left to right along the way from the first road to the second, of which this is one.
fn slots(network: &RoadNetwork, at: RoadEnd, first: bool) -> Vec<Slot> {
    let section = &network.road(at.road).section;
    let mut lanes = lanes_at(section, at.end);
    if !first {
        lanes.reverse();
    }
    let flipped = (at.end == End::End) != first;
    let slot = |LaneAt { strip, into }| {
        let edges = if flipped { [strip + 1, strip] } else { [strip, strip + 1] };
        Slot { kind: section.strips[strip].kind, onward: into == first, strip, edges }
    };
    lanes.into_iter().map(slot).collect()
}

/// The lanes of two roads that continue each other; `None` if not all do.
pub fn continued(network: &RoadNetwork, a: RoadEnd, b: RoadEnd) -> Option<Vec<[Slot; 2]>> {
    let (of_a, of_b) = (slots(network, a, true), slots(network, b, false));
    let alike = |(x, y): (&Slot, &Slot)| x.kind == y.kind && x.onward == y.onward;
    let all = !of_a.is_empty() && of_a.len() == of_b.len() && of_a.iter().zip(&of_b).all(alike);
    all.then(|| of_a.into_iter().zip(of_b).map(|(x, y)| [x, y]).collect())
}

/// Edges of two roads that meet.
struct EdgePair {
    /// By index in the cross-section of each road.
    edges: [usize; 2],
    place: Point,
    /// Whether one node is the end of both.
    shared: bool,
}

/// The edges of both roads that meet; `None` if the roads do not continue each other.
fn edge_pairs(network: &RoadNetwork, a: RoadEnd, b: RoadEnd) -> Option<Vec<EdgePair>> {
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for [x, y] in continued(network, a, b)? {
        pairs.extend(x.edges.into_iter().zip(y.edges));
    }
    let (kerbs_a, kerbs_b) = (network.road(a.road).section.carriageway(), network.road(b.road).section.carriageway());
    let ends = |(first, last): (usize, usize), turned: bool| if turned { [last, first] } else { [first, last] };
    let kerbs = ends(kerbs_a, a.end == End::Start).into_iter().zip(ends(kerbs_b, b.end == End::End));
    pairs.extend(kerbs);
    pairs.sort_unstable();
    pairs.dedup();
    // An edge must meet one edge only, on both sides.
    let mut others: Vec<usize> = pairs.iter().map(|p| p.1).collect();
    others.sort_unstable();
    if pairs.windows(2).any(|w| w[0].0 == w[1].0) || others.windows(2).any(|w| w[0] == w[1]) {
        return None;
    }
    let pair = |(i, j)| {
        let shared = alike_at(network, (a, i), (b, j));
        meeting(network, (a, i), (b, j)).map(|place| EdgePair { edges: [i, j], place, shared })
    };
    let mut pairs: Vec<EdgePair> = pairs.into_iter().map(pair).collect::<Option<_>>()?;
    for beside in pairs_beside(network, a, b) {
        if !pairs.iter().any(|pair| pair.edges[0] == beside.edges[0] || pair.edges[1] == beside.edges[1]) {
            pairs.push(beside);
        }
    }
    Some(pairs)
}

/// Whether what lies beside the lanes at an edge is for the same use on both roads: else a shoulder would be continued by
/// a lane for bicycles.
fn alike_at(network: &RoadNetwork, (a, i): (RoadEnd, usize), (b, j): (RoadEnd, usize)) -> bool {
    let used = |at: RoadEnd, edge: usize| {
        let section = &network.road(at.road).section;
        let driven = section.driven().any(|(strip, _)| strip == edge || strip + 1 == edge);
        let beside = strip_runs(section).into_iter().find(|run| run.strips.start == edge || run.strips.end == edge);
        beside.filter(|_| !driven).map(|run| run.used)
    };
    used(a, i).zip(used(b, j)).is_none_or(|(one, other)| one == other)
}

/// The edges of what lies beside the lanes of both roads for the same use, as far as they meet.
fn pairs_beside(network: &RoadNetwork, a: RoadEnd, b: RoadEnd) -> Vec<EdgePair> {
    let [ours, theirs] = [a, b].map(|at| strip_runs(&network.road(at.road).section));
    let mirrored = a.end == b.end;
    let mut pairs = Vec::new();
    for (run, other) in ours.iter().flat_map(|run| theirs.iter().map(move |other| (run, other))) {
        let (from, to) = (other.strips.start, other.strips.end);
        let ends = if mirrored { [to, from] } else { [from, to] };
        let edges = [run.strips.start, run.strips.end].into_iter().zip(ends);
        let pair = |(i, j)| Some(EdgePair { edges: [i, j], place: meeting(network, (a, i), (b, j))?, shared: true });
        let meet: Option<Vec<EdgePair>> = edges.map(pair).collect();
        pairs.extend(meet.filter(|_| run.used == other.used).into_iter().flatten());
    }
    pairs
}

/// The mitred meeting of two edges; `None` if they miss each other by too much.
fn meeting(network: &RoadNetwork, (a, i): (RoadEnd, usize), (b, j): (RoadEnd, usize)) -> Option<Point> {
    let end = |at: RoadEnd| {
        let road = network.road(at.road);
        let station = if at.end == End::Start { 0.0 } else { road.line.length() };
        (road.line.at(station), inward(road, at.end, station))
    };
    let ((place_a, into), (place_b, back)) = (end(a), end(b));
    let out = -back;
    // Offsets to the left of the way from a to b.
    let offset = |at: RoadEnd, edge: usize, along: End| {
        let offset = network.road(at.road).section.edge(edge);
        if at.end == along { offset } else { -offset }
    };
    let (left, right) = (offset(a, i, End::End), offset(b, j, End::Start));
    let turn = angle_between(into, out);
    if turn.abs() > ANGLE_MOST.to_radians()
        || (left - right).abs() > STEP_MOST
        || (place_a - place_b).norm() > STEP_MOST
    {
        return None;
    }
    Some(miter(nalgebra::center(&place_a, &place_b), [into, out], (left + right) / 2.0))
}

#[cfg(test)]
mod tests {
    use crate::builder::lane_export::single_lanes;
    use crate::builder::lanes::lane_ends::{RequiredSetbacks, connection_lines};
    use crate::builder::{BuildOptions, plan};
    use crate::lane_stitching::{LaneEnd, LaneStitching, Meeting};
    use crate::osm::{OsmData, read_bytes};

    use super::*;

    /// A street of three ways that bends where they meet and has other limits on each.
    fn street() -> OsmData {
        let mut text = String::from("<osm version='0.6'>");
        for (id, x, y) in [(1, 0.0, 0.0), (2, 100.0, 0.0), (3, 190.0, 30.0), (4, 280.0, 25.0)] {
            let (lat, lon) = (49.0 + y / 111_200.0, 8.5 + x / 73_000.0);
            text += &format!("<node id='{id}' lat='{lat:.9}' lon='{lon:.9}'/>");
        }
        for (id, refs, speed) in [(10, [1, 2], 50), (11, [3, 2], 60), (12, [3, 4], 70)] {
            text += &format!("<way id='{id}'><nd ref='{}'/><nd ref='{}'/>", refs[0], refs[1]);
            let speed = speed.to_string();
            for (k, v) in [("highway", "secondary"), ("lanes", "4"), ("sidewalk", "no"), ("maxspeed", &speed)] {
                text += &format!("<tag k='{k}' v='{v}'/>");
            }
            text += "</way>";
        }
        let mut osm = OsmData::default();
        read_bytes(&mut osm, "test", (text + "</osm>").into_bytes()).unwrap();
        osm
    }

    #[test]
    fn roads_meet_where_their_lanes_do_when_woven() {
        let streets = plan(street(), &BuildOptions::default()).unwrap().streets;
        let network = &streets.network;
        let joins = Continuations::find(network);
        let needs = RequiredSetbacks::new(network, &streets.outlines.kept, |ix| joins.joined(ix));
        let lines = connection_lines(network, &needs, &[[0.0; 2]; 3], &[[false; 2]; 3], |_| None);
        let weave = LaneStitching::new(single_lanes(network, &lines.kept));
        let ends = weave.iter().flat_map(|(id, lane)| LaneEnd::BOTH.map(|end| (id, end, lane)));
        let joined = ends.filter(|(id, end, _)| matches!(weave.meeting(*id, *end), Some(Meeting::Joined(_))));
        let mut count = 0;
        for (id, end, lane) in joined {
            for bound in lane.bounds() {
                let tip = if end == LaneEnd::Start { bound[0] } else { bound[bound.len() - 1] };
                let least = joins.meetings.iter().map(|m| (m.place - tip).norm()).fold(f64::INFINITY, f64::min);
                assert!(least < 1e-6, "lane {id:?} ends {least} m from where the roads meet");
                count += 1;
            }
        }
        // Four lanes, at two nodes, from both sides, with two bounds.
        assert_eq!(count, 4 * 2 * 2 * 2);
        assert_eq!(joins.meetings.len(), 2 * 5);
    }
}
