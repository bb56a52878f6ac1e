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
use crate::builder::tags::side_strips::{StripUse, strip_runs};
use crate::geometry::miter::miter;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, angle_between};
use crate::lanelet::PointId;

use super::gore::{EdgeAt, GoreCorner};

/// Roads meet face to face up to this change of direction, degrees; beyond, a curve joins them.
const ANGLE_MOST: f64 = 30.0;
/// Borders meet face to face up to this distance, metres; beyond, a taper joins them.
const STEP_MOST: f64 = 0.5;
/// Nodes at one place that are not shared lie this far apart, metres.
const APART: f64 = 0.06;

/// A node where edges of roads end.
#[derive(Clone, Debug, PartialEq)]
struct EdgeNode {
    key: Key,
    place: Point,
}

/// The nodes where roads meet face to face, and those that roads share side by side.
#[derive(Debug, Default)]
pub struct Continuations {
    /// Per intersection: whether its roads meet face to face.
    face_to_face: Vec<bool>,
    nodes: Vec<EdgeNode>,
    /// By index in `nodes`.
    of_edge: FxHashMap<(RoadEnd, usize), usize>,
    /// The points of the map, by index in `nodes`, once they are added.
    points: FxHashMap<usize, PointId>,
    /// The nodes of gores, by index in `nodes`.
    gores: FxHashMap<[EdgeAt; 2], usize>,
}

impl Continuations {
    /// Finds where roads of the network meet face to face.
    pub fn find(network: &RoadNetwork) -> Self {
        let mut found = Self::default();
        for (i, intersection) in network.intersections.iter().enumerate() {
            let pairs = match intersection.arms[..] {
                [a, b] if a.road != b.road => edge_pairs(network, a, b),
                _ => None,
            };
            found.face_to_face.push(pairs.is_some());
            let node = intersection.nodes.first().copied().unwrap_or(i as i64);
            pairs.into_iter().flatten().for_each(|pair| found.add_pair(network, node, &pair));
        }
        found
    }

    /// Adds the node of two edges, or one for each of them that lie [`APART`]; `id` is the OpenStreetMap node.
    fn add_pair(&mut self, network: &RoadNetwork, id: i64, &EdgePair { edges: [a, b], place, shared }: &EdgePair) {
        let key = Key::new("join").number(id).number(a.1 as i64);
        self.of_edge.insert(a, self.nodes.len());
        self.nodes.push(EdgeNode { key, place });
        if !shared {
            self.nodes
                .push(EdgeNode { key: key.word("beyond"), place: place - end_pose(network, b.0).heading * APART });
        }
        self.of_edge.insert(b, self.nodes.len() - 1);
    }

    /// Replaces the corners that roads share side by side. Gives the roads whose corners have changed.
    pub fn set_gore_corners(&mut self, corners: Vec<GoreCorner>) -> FxHashSet<RoadIx> {
        let mut new: FxHashMap<[EdgeAt; 2], Point> =
            corners.iter().map(|corner| (corner.edges, corner.place)).collect();
        let mut changed = FxHashSet::default();
        let Self { nodes, of_edge, points, gores, .. } = self;
        gores.retain(|edges, node| {
            let stays = new.get(edges).is_some_and(|place| *place == nodes[*node].place);
            if stays {
                new.remove(edges);
            } else {
                changed.extend(edges.iter().map(|(at, _)| at.road));
                edges.iter().for_each(|edge| _ = of_edge.remove(edge));
                points.remove(node);
            }
            stays
        });
        for GoreCorner { edges, key, place } in corners.into_iter().filter(|corner| new.contains_key(&corner.edges)) {
            changed.extend(edges.iter().map(|(at, _)| at.road));
            of_edge.extend(edges.map(|edge| (edge, nodes.len())));
            gores.insert(edges, nodes.len());
            nodes.push(EdgeNode { key, place });
        }
        changed
    }

    /// Takes over the points of nodes where the same edges ended in the network before. Gives the roads with ends on other
    /// nodes than before.
    pub fn take_over(&mut self, before: &Self, origins: &NetworkDiff) -> FxHashSet<RoadIx> {
        // How many edges of each earlier node end elsewhere now.
        let mut missing = vec![0_usize; before.nodes.len()];
        before.of_edge.values().for_each(|node| missing[*node] += 1);
        let mut earlier: Vec<Option<usize>> = vec![None; self.nodes.len()];
        let mut is_new = vec![false; self.nodes.len()];
        for (&(at, edge), &node) in &self.of_edge {
            let was = origins.of_end(at).and_then(|at| before.of_edge.get(&(at, edge)));
            match was.filter(|was| before.nodes[**was] == self.nodes[node]) {
                Some(&was) => {
                    missing[was] -= 1;
                    earlier[node] = Some(was);
                }
                None => is_new[node] = true,
            }
        }
        let mut changed = FxHashSet::default();
        for (&(at, _), &node) in &self.of_edge {
            let stays = earlier[node].filter(|was| !is_new[node] && missing[*was] == 0);
            match stays.and_then(|was| before.points.get(&was)) {
                Some(&point) => _ = self.points.insert(node, point),
                None => _ = changed.insert(at.road),
            }
        }
        let now = |&(at, edge): &EdgeAt| Some((RoadEnd { road: origins.now(at.road)?, ..at }, edge));
        let freed = before.of_edge.keys().filter_map(now).filter(|edge| !self.of_edge.contains_key(edge));
        changed.extend(freed.map(|(at, _)| at.road));
        changed
    }

    /// Whether the roads of this intersection meet face to face.
    pub fn joined(&self, ix: IntersectionIx) -> bool {
        self.face_to_face.get(ix.position()).copied().unwrap_or(false)
    }

    /// Adds the points of the nodes that have none yet.
    pub fn add_points(&mut self, assembly: &mut MapBuilder, network: &RoadNetwork) {
        let new = self.of_edge.iter().filter(|(_, node)| !self.points.contains_key(node));
        let new: BTreeSet<(usize, RoadIx)> = new.map(|((at, _), node)| (*node, at.road)).collect();
        for (node, road) in new {
            if !self.points.contains_key(&node) {
                assembly.set_ground(Ground::under(network.road(road)));
                let EdgeNode { key, place } = self.nodes[node].clone();
                self.points.insert(node, assembly.point(key, place, 0.0));
            }
        }
        assembly.set_ground(Ground::default());
    }

    /// Forgets the points on which these roads, in order of their indices, end, so that they are added anew.
    pub fn forget_points(&mut self, roads: &[RoadIx]) {
        let of_roads = self.of_edge.iter().filter(|((at, _), _)| roads.binary_search(&at.road).is_ok());
        let nodes: FxHashSet<usize> = of_roads.map(|(_, node)| *node).collect();
        self.points.retain(|node, _| !nodes.contains(node));
    }

    /// All points on which two roads end.
    pub fn points(&self) -> FxHashSet<PointId> {
        self.points.values().copied().collect()
    }

    /// The point on which an edge of a road's cross-section and that of another road end; `None` if it has one of its own.
    pub fn point(&self, at: RoadEnd, edge: usize) -> Option<PointId> {
        self.points.get(self.of_edge.get(&(at, edge))?).copied()
    }
}

/// A lane at the end of a road, for the comparison of two roads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuedLane {
    kind: StripKind,
    /// Whether it runs from the first road to the second.
    pub onward: bool,
    /// Index of its strip.
    pub strip: usize,
    /// Its left and its right edge, as seen from the first road to the second.
    edges: [usize; 2],
}

/// The lanes at an end, from left to right as seen from the first road to the second.
fn lanes_onward(network: &RoadNetwork, at: RoadEnd, first: bool) -> Vec<ContinuedLane> {
    let section = &network.road(at.road).section;
    let mut lanes = lanes_at(section, at.end);
    if !first {
        lanes.reverse();
    }
    let flipped = (at.end == End::End) != first;
    let lane = |LaneAt { strip, into }| {
        let edges = if flipped { [strip + 1, strip] } else { [strip, strip + 1] };
        ContinuedLane { kind: section.strips[strip].kind, onward: into == first, strip, edges }
    };
    lanes.into_iter().map(lane).collect()
}

/// The lanes of two roads that continue each other; `None` if not all do.
pub fn continued(network: &RoadNetwork, a: RoadEnd, b: RoadEnd) -> Option<Vec<[ContinuedLane; 2]>> {
    let (of_a, of_b) = (lanes_onward(network, a, true), lanes_onward(network, b, false));
    let pairs: Vec<[ContinuedLane; 2]> = of_a.iter().zip(&of_b).map(|(x, y)| [*x, *y]).collect();
    let alike = pairs.iter().all(|[x, y]| x.kind == y.kind && x.onward == y.onward);
    (!of_a.is_empty() && of_a.len() == of_b.len() && alike).then_some(pairs)
}

/// Edges of two roads that meet.
struct EdgePair {
    edges: [EdgeAt; 2],
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
    let [(first_a, last_a), (first_b, last_b)] = [a, b].map(|at| network.road(at.road).section.carriageway());
    let kerbs = if a.end == b.end { [last_b, first_b] } else { [first_b, last_b] };
    pairs.extend([first_a, last_a].into_iter().zip(kerbs));
    pairs.sort_unstable();
    pairs.dedup();
    // An edge must meet one edge only, on both sides.
    let mut others: Vec<usize> = pairs.iter().map(|p| p.1).collect();
    others.sort_unstable();
    if pairs.windows(2).any(|w| w[0].0 == w[1].0) || others.windows(2).any(|w| w[0] == w[1]) {
        return None;
    }
    let pair = |(i, j)| {
        let edges = [(a, i), (b, j)];
        Some(EdgePair { edges, place: meeting(network, edges)?, shared: have_one_use(network, edges) })
    };
    let mut pairs: Vec<EdgePair> = pairs.into_iter().map(pair).collect::<Option<_>>()?;
    for side in side_lane_pairs(network, a, b) {
        if !pairs.iter().any(|pair| pair.edges[0] == side.edges[0] || pair.edges[1] == side.edges[1]) {
            pairs.push(side);
        }
    }
    Some(pairs)
}

/// What the side lane at an edge is for; `None` without one, and where a lane for cars lies there.
fn side_lane_use(network: &RoadNetwork, (at, edge): EdgeAt) -> Option<StripUse> {
    let section = &network.road(at.road).section;
    let driven = section.driven().any(|(strip, _)| strip == edge || strip + 1 == edge);
    let run = strip_runs(section).into_iter().find(|run| run.strips.start == edge || run.strips.end == edge);
    run.filter(|_| !driven).map(|run| run.used)
}

/// Whether the side lanes at both edges are for one use: a bicycle lane does not continue a shoulder.
fn have_one_use(network: &RoadNetwork, edges: [EdgeAt; 2]) -> bool {
    let [one, other] = edges.map(|edge| side_lane_use(network, edge));
    one.zip(other).is_none_or(|(one, other)| one == other)
}

/// The edges of side lanes of both roads for the same use that meet.
fn side_lane_pairs(network: &RoadNetwork, a: RoadEnd, b: RoadEnd) -> Vec<EdgePair> {
    let [runs_a, runs_b] = [a, b].map(|at| strip_runs(&network.road(at.road).section));
    let mut pairs = Vec::new();
    for (run, other) in runs_a.iter().flat_map(|run| runs_b.iter().map(move |other| (run, other))) {
        let (from, to) = (other.strips.start, other.strips.end);
        let ends = if a.end == b.end { [to, from] } else { [from, to] };
        let edges = [run.strips.start, run.strips.end].into_iter().zip(ends).map(|(i, j)| [(a, i), (b, j)]);
        let pair = |edges| Some(EdgePair { edges, place: meeting(network, edges)?, shared: true });
        let meet: Option<Vec<EdgePair>> = edges.map(pair).collect();
        pairs.extend(meet.filter(|_| run.used == other.used).into_iter().flatten());
    }
    pairs
}

/// Where a road's line ends, and the direction into the intersection there.
fn end_pose(network: &RoadNetwork, at: RoadEnd) -> Pose {
    let road = network.road(at.road);
    let station = if at.end == End::Start { 0.0 } else { road.line.length() };
    Pose { point: road.line.at(station), heading: inward(road, at.end, station) }
}

/// The mitred meeting of two edges; `None` if they miss each other by too much.
fn meeting(network: &RoadNetwork, [(a, i), (b, j)]: [EdgeAt; 2]) -> Option<Point> {
    let (from, to) = (end_pose(network, a), end_pose(network, b));
    let out = -to.heading;
    // Offsets to the left as seen from a to b.
    let offset = |at: RoadEnd, edge: usize, along: End| {
        let offset = network.road(at.road).section.edge(edge);
        if at.end == along { offset } else { -offset }
    };
    let (own, other) = (offset(a, i, End::End), offset(b, j, End::Start));
    let meet = angle_between(from.heading, out).abs() <= ANGLE_MOST.to_radians()
        && (own - other).abs() <= STEP_MOST
        && (from.point - to.point).norm() <= STEP_MOST;
    let middle = nalgebra::center(&from.point, &to.point);
    meet.then(|| miter(middle, [from.heading, out], (own + other) / 2.0))
}

#[cfg(test)]
mod tests {
    use crate::builder::lane_export::single_lanes;
    use crate::builder::lanes::lane_ends::{RequiredSetbacks, connection_lines};
    use crate::builder::lanes::road_cut::SqueezedRoads;
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
    fn roads_meet_where_their_stitched_lanes_do() {
        let streets = plan(street(), &BuildOptions::default()).unwrap().streets;
        let network = &streets.network;
        let joins = Continuations::find(network);
        let required = RequiredSetbacks::new(network, &streets.outlines.kept, |ix| joins.joined(ix));
        let lines =
            connection_lines(network, &required, &[[0.0; 2]; 3], (&[[false; 2]; 3], &SqueezedRoads::default()), |_| {
                None
            });
        let stitching = LaneStitching::new(single_lanes(network, &lines.kept));
        let ends = stitching.iter().flat_map(|(id, lane)| LaneEnd::BOTH.map(|end| (id, end, lane)));
        let joined = ends.filter(|(id, end, _)| matches!(stitching.meeting(*id, *end), Some(Meeting::Joined(_))));
        let mut count = 0;
        for (id, end, lane) in joined {
            for bound in lane.bounds() {
                let tip = if end == LaneEnd::Start { bound[0] } else { bound[bound.len() - 1] };
                let least = joins.nodes.iter().map(|m| (m.place - tip).norm()).fold(f64::INFINITY, f64::min);
                assert!(least < 1e-6, "lane {id:?} ends {least} m from where the roads meet");
                count += 1;
            }
        }
        // Four lanes, at two nodes, from both sides, with two bounds.
        assert_eq!(count, 4 * 2 * 2 * 2);
        assert_eq!(joins.nodes.len(), 2 * 5);
    }
}
