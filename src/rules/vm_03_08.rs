//! vm-03-08: the outline of an intersection area runs along the road borders and the ends of the lanes, over the very
//! same points.

use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::geometry::simple_ring::RingFault;
use crate::geometry::{Point, Polyline, Vector, polygon, simple_ring};
use crate::lanelet::index::{Arm, Edge, Intersection, MapIndex, extent, is_road_border};
use crate::lanelet::{LaneletId, PointId, Polygon};

use super::redrawn_area::RedrawnAreas;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    spike: f64,
    coincident: f64,
    insert: f64,
    cut: f64,
    island: f64,
}

/// More places than this in one broken outline tell nothing new.
const MOST_PLACES: usize = 10;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let allowed = AllowedPoints::of(map);
    let islands = islands(map);
    let redrawn = RedrawnAreas::new(map);
    let mut findings = Vec::new();
    for intersection in &map.intersections {
        let Some(area) = intersection.area.and_then(|id| map.map.polygons.get(id)) else { continue };
        findings.extend(judge_ring(map, params, area, intersection, &redrawn));
        findings.extend(judge_vertices(map, params, area, intersection, &allowed));
        findings.extend(judge_lane_ends(map, params, area, intersection));
        findings.extend(intersection.arms.iter().filter_map(|arm| judge_cut(params, area, arm)));
        findings.extend(judge_islands(params, area, intersection, &islands));
    }
    findings
}

/// The points an outline may run over.
struct AllowedPoints {
    ids: FxHashSet<PointId>,
    tree: rstar::RTree<rstar::primitives::GeomWithData<[f64; 2], PointId>>,
}

impl AllowedPoints {
    /// Points of road borders and of the ends of lanes.
    fn of(map: &MapIndex) -> Self {
        let borders = map.map.linestrings.iter().filter(|line| is_road_border(line));
        let mut known: FxHashSet<PointId> = borders.flat_map(|line| line.points.iter().copied()).collect();
        let lanes = map.lanes.iter().filter(|lane| lane.is_drivable() || lane.is_for_buses());
        known.extend(lanes.flat_map(|lane| [lane.start.ids, lane.end.ids]).flatten());
        let mut ids: Vec<PointId> = known.iter().copied().collect();
        ids.sort_unstable();
        let places = ids.into_iter().filter_map(|id| {
            let p = map.map.points.get(id)?.position;
            (p.x.is_finite() && p.y.is_finite()).then(|| rstar::primitives::GeomWithData::new([p.x, p.y], id))
        });
        Self { tree: rstar::RTree::bulk_load(places.collect()), ids: known }
    }
}

fn judge_ring(
    map: &MapIndex,
    params: &Params,
    area: &Polygon,
    intersection: &Intersection,
    redrawn: &RedrawnAreas,
) -> Vec<Finding> {
    let subject = Subject::Polygon(area.id.0);
    let mut findings = Vec::new();
    let last = area.points.len().saturating_sub(1);
    let closed = last > 0 && area.points[0] == area.points[last];
    if closed {
        let message = format!("Outline of area {} repeats its first node {} at its end.", area.id, area.points[0]);
        let edits = vec![Edit::RemoveVertex { way: subject, position: last }];
        let finding = Finding::new("closed", subject, message).with(Subject::Point(area.points[0].0), "node");
        findings.push(finding.fixed_by("remove the repeated last node", true, edits));
    }
    let open = &area.points[..area.points.len() - usize::from(closed)];
    let mut seen = FxHashSet::default();
    for (position, &id) in open.iter().enumerate() {
        if seen.insert(id) {
            continue;
        }
        let message = format!("Outline of area {}: it runs over node {id} twice.", area.id);
        let finding = Finding::new("invalid", subject, message).with(Subject::Point(id.0), "node");
        let finding = place_of(map, id).map_or(finding.clone(), |p| finding.at(Place::Point(p)));
        // Twice in a row is a slip of the hand; anything else needs review.
        let edits = vec![Edit::RemoveVertex { way: subject, position }];
        let twice = position > 0 && open[position - 1] == id;
        findings.push(match twice {
            true => finding.fixed_by("remove the repeated node", true, edits),
            false => redrawn.mend(finding, intersection),
        });
    }
    if !findings.iter().any(|finding| finding.fault == "invalid") {
        let faults = simple_ring::faults(&intersection.ring, params.spike, MOST_PLACES);
        findings.extend(
            faults.into_iter().map(|fault| redrawn.mend(broken_ring(area, &intersection.ring, fault), intersection)),
        );
    }
    findings
}

fn broken_ring(area: &Polygon, ring: &[Point], fault: RingFault) -> Finding {
    let node = |at: usize| area.points.get(at).copied().unwrap_or(PointId(0));
    let (reason, place) = match fault {
        RingFault::TooFew(count) => (format!("it has {count} distinct vertices; three are the least"), None),
        RingFault::NotFinite(at) => (format!("node {} has no place", node(at)), None),
        RingFault::Spike(at) => (format!("it turns back on itself at node {}", node(at)), ring.get(at).copied()),
        RingFault::Crossing(a, b, place) => {
            (format!("its edges behind nodes {} and {} cross", node(a), node(b)), Some(place))
        }
    };
    let message = format!("Outline of area {}: {reason}.", area.id);
    let finding = Finding::new("invalid", Subject::Polygon(area.id.0), message);
    match place {
        Some(place) => finding.at(Place::Point(place)),
        None => finding,
    }
}

/// Every vertex must be a point of a road border or of the end of a lane, by id. One that lies on such a point is told by itself,
/// the others of an area together.
fn judge_vertices(
    map: &MapIndex,
    params: &Params,
    area: &Polygon,
    intersection: &Intersection,
    allowed: &AllowedPoints,
) -> Vec<Finding> {
    let mut seen = FxHashSet::default();
    let strays = area.points.iter().filter(|id| !allowed.ids.contains(id) && seen.insert(**id));
    let (mut findings, mut free) = (Vec::new(), Vec::new());
    for &id in strays {
        match place_of(map, id).and_then(|place| on_top(params, area, id, place, allowed)) {
            Some(finding) => findings.push(finding),
            None => free.push(id),
        }
    }
    findings.extend(free_vertices(map, area, intersection, &free));
    findings
}

/// A vertex that lies on a node of a border without being it.
fn on_top(params: &Params, area: &Polygon, id: PointId, place: Point, allowed: &AllowedPoints) -> Option<Finding> {
    let near = allowed.tree.nearest_neighbor(&[place.x, place.y])?;
    let distance = (Point::from(*near.geom()) - place).norm();
    if distance > params.coincident {
        return None;
    }
    let PointId(to) = near.data;
    let message = format!(
        "Vertex {id} of area {} lies {distance:.2} m from node {to} of a road border or lane edge but is not the same node.",
        area.id
    );
    let finding = Finding::new("edge-not-border", Subject::Polygon(area.id.0), message)
        .with(Subject::Point(id.0), "vertex")
        .with(Subject::Point(to), "node of the border")
        .at(Place::Point(place))
        .measured(distance, params.coincident, "m")
        .graded(Severity::Warning);
    let edits = vec![Edit::MergePoints { from: id.0, to }];
    Some(finding.fixed_by(format!("use node {to} instead of {id}"), true, edits))
}

/// Vertices on no border: harmless where they are nodes of the outermost bounds of the area's own lanes, beyond which the map
/// knows nothing.
fn free_vertices(map: &MapIndex, area: &Polygon, intersection: &Intersection, free: &[PointId]) -> Option<Finding> {
    let [first, rest @ ..] = free else { return None };
    let bounds = intersection.members.iter().flat_map(|member| map.lanes[member.lane].bounds);
    let outermost = bounds.filter(|way| map.users_of(*way).len() == 1);
    let lines = outermost.filter_map(|way| map.map.linestrings.get(way));
    let edge: FxHashSet<PointId> = lines.flat_map(|line| line.points.iter().copied()).collect();
    let on_edge = free.iter().all(|id| edge.contains(id));
    let where_ = if on_edge {
        "on the outer bounds of its lanes, which are no road borders"
    } else {
        "on no road border and no lane edge"
    };
    let message = match rest.len() {
        0 => format!("Vertex {first} of area {} is {where_}.", area.id),
        _ => format!("{} vertices of area {}, among them {first}, are {where_}.", free.len(), area.id),
    };
    let finding = Finding::new("edge-not-border", Subject::Polygon(area.id.0), message);
    let finding = free.iter().fold(finding, |finding, id| finding.with(Subject::Point(id.0), "vertex"));
    let finding = if on_edge { finding.graded(Severity::Warning) } else { finding };
    Some(match place_of(map, *first) {
        Some(place) => finding.at(Place::Point(place)),
        None => finding,
    })
}

/// Every end point of the bounds of a lanelet for cars must be a vertex, by id: Autoware widens the way of cars alone.
fn judge_lane_ends(map: &MapIndex, params: &Params, area: &Polygon, intersection: &Intersection) -> Vec<Finding> {
    let vertices: FxHashSet<PointId> = area.points.iter().copied().collect();
    let mut findings = Vec::new();
    let is_member = |lane: &usize| intersection.members.iter().any(|member| member.lane == *lane);
    for member in intersection.members.iter().filter(|member| member.is_inside()) {
        let lane = &map.lanes[member.lane];
        if !lane.is_for_cars() {
            continue;
        }
        // The end of a piece inside the box is vm-03-05's.
        let [before, after] = [map.predecessors(member.lane), map.followers(member.lane)];
        let ends = [(lane.start, before), (lane.end, after)];
        for (Edge { ids, points }, beyond) in ends.into_iter().filter(|(_, beyond)| !beyond.iter().any(is_member)) {
            for (id, place) in ids.into_iter().zip(points).filter(|(id, _)| !vertices.contains(id)) {
                // A lane that begins or ends inside, with nothing beyond, is vm-03-04's: the outline cannot run there.
                let is_told = beyond.is_empty() && is_told_as_dangling(map, member.lane);
                if !is_told || !is_far_inside(params, intersection, place) {
                    findings.push(lane_node_missing(params, area, intersection, lane.id, id, place));
                }
            }
        }
    }
    findings
}

/// Whether vm-03-04 speaks of a lane that comes from nowhere or leads nowhere.
fn is_told_as_dangling(map: &MapIndex, lane: usize) -> bool {
    map.movement(lane).is_some() && map.turn_direction(lane).is_some()
}

/// Whether a place is inside an outline, and not so close to it that it can become a vertex.
fn is_far_inside(params: &Params, intersection: &Intersection, place: Point) -> bool {
    let ring = &intersection.ring;
    let border = Polyline::new(ring.iter().chain(ring.first()).copied());
    let is_off = border.is_some_and(|border| border.project(place).offset.abs() > params.insert);
    is_off && polygon::contains(ring, place)
}

fn lane_node_missing(
    params: &Params,
    area: &Polygon,
    intersection: &Intersection,
    lanelet: LaneletId,
    id: PointId,
    place: Point,
) -> Finding {
    let message = format!(
        "End node {id} of lanelet {lanelet} is not a vertex of area {}; avoidance cannot widen there.",
        area.id
    );
    let subject = Subject::Polygon(area.id.0);
    let finding = Finding::new("lane-node-missing", subject, message)
        .with(Subject::Lanelet(lanelet.0), "lanelet")
        .with(Subject::Point(id.0), "end node")
        .at(Place::Point(place));
    let ring = &intersection.ring;
    let Some(border) = Polyline::new(ring.iter().chain(ring.first()).copied()) else { return finding };
    let foot = border.project(place);
    if foot.offset.abs() > params.insert || border.points().len() != ring.len() + 1 {
        return finding;
    }
    let edits = vec![Edit::InsertVertex { way: subject, position: foot.segment + 1, point: id.0 }];
    finding.fixed_by(format!("insert node {id} into the outline"), true, edits)
}

/// The vertices where an approach is cut must lie on one line across the road.
fn judge_cut(params: &Params, area: &Polygon, arm: &Arm) -> Option<Finding> {
    let vertices: FxHashSet<PointId> = area.points.iter().copied().collect();
    let mut seen = FxHashSet::default();
    let ends = arm.edges.iter().flat_map(|edge| edge.edge.ids.into_iter().zip(edge.edge.points));
    let cut: Vec<(PointId, Point)> = ends.filter(|(id, _)| vertices.contains(id) && seen.insert(*id)).collect();
    let (id, off) = farthest_from_line(&cut)?;
    if off <= params.cut {
        return None;
    }
    let message = format!(
        "Cut across the {} approach of area {} deviates {off:.2} m from a line at node {id}.",
        arm.compass, area.id
    );
    let finding = Finding::new("cut-not-straight", Subject::Polygon(area.id.0), message)
        .with(Subject::Point(id.0), "node")
        .measured(off, params.cut, "m");
    Some(finding.at(Place::Line(cut.into_iter().map(|(_, p)| p).collect())))
}

/// The point farthest from the line that fits all of them best, and its distance.
fn farthest_from_line(points: &[(PointId, Point)]) -> Option<(PointId, f64)> {
    let count = points.len() as f64;
    let middle = points.iter().map(|(_, p)| p.coords).sum::<Vector>() / count.max(1.0);
    let mut spread = nalgebra::Matrix2::zeros();
    for (_, p) in points {
        let d = p.coords - middle;
        spread += d * d.transpose();
    }
    // Direction of the largest spread: the angle of the principal axis of a symmetric matrix.
    let angle = 0.5 * (2.0 * spread[(0, 1)]).atan2(spread[(0, 0)] - spread[(1, 1)]);
    let normal = Vector::new(-angle.sin(), angle.cos());
    let off = points.iter().map(|(id, p)| (*id, (p.coords - middle).dot(&normal).abs()));
    off.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
}

/// What cannot be driven over: a hatched marking or a kerbed island.
struct Island {
    subject: Subject,
    part: &'static str,
    ring: Vec<Point>,
    extent: [Point; 2],
}

fn islands(map: &MapIndex) -> Vec<Island> {
    let island = |subject, part, ids: &[PointId]| {
        let ring: Vec<Point> = ids.iter().filter_map(|&id| place_of(map, id)).collect();
        Island { subject, part, extent: extent(&ring), ring }
    };
    let hatched = map.map.polygons.iter().filter(|one| one.attributes.is("type", "hatched_road_markings"));
    let hatched = hatched.map(|one| island(Subject::Polygon(one.id.0), "hatched marking", &one.points));
    let closed = |points: &[PointId]| points.len() > 3 && points.first() == points.last();
    let kerbs = map.map.linestrings.iter().filter(|line| closed(&line.points) && is_road_border(line));
    let kerbs = kerbs.map(|line| island(Subject::LineString(line.id.0), "island", &line.points[1..]));
    hatched.chain(kerbs).filter(|island| simple_ring::is_simple(&island.ring)).collect()
}

/// The outline should run around what cannot be driven over.
fn judge_islands(params: &Params, area: &Polygon, intersection: &Intersection, islands: &[Island]) -> Vec<Finding> {
    let [low, high] = extent(&intersection.ring);
    let near = |island: &&Island| {
        let [l, h] = island.extent;
        l.x <= high.x && h.x >= low.x && l.y <= high.y && h.y >= low.y
    };
    let mut near = islands.iter().filter(near).peekable();
    if near.peek().is_none() || !intersection.is_simple() {
        return Vec::new();
    }
    near.filter_map(|Island { subject, part, ring, .. }| {
        let inside = polygon::overlap(ring, &intersection.ring);
        let message = format!("Area {} covers {inside:.1} m2 of {subject}, which cannot be driven over.", area.id);
        (inside > params.island).then(|| {
            Finding::new("not-drivable", Subject::Polygon(area.id.0), message)
                .with(*subject, part)
                .measured(inside, params.island, "m2")
                .at(Place::Polygon(ring.clone()))
        })
    })
    .collect()
}

/// Where a point lies, if its coordinates are numbers.
fn place_of(map: &MapIndex, id: PointId) -> Option<Point> {
    map.map.points.get(id).map(|point| point.position).filter(|p| p.x.is_finite() && p.y.is_finite())
}
