//! Intersections: their lanelets and their approaches.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rstar::AABB;
use rustc_hash::{FxHashMap, FxHashSet};

use super::Lane;
use super::lane::extent;
use super::road_leg::{Crossed, legs};
use super::thresholds;
use super::types::{Arm, ArmEdge, Conflict, Intersection, IntersectionMember, LaneTree};
use super::union_find::UnionFind;
use crate::geometry::{Point, Vector, polygon, simple_ring};
use crate::lanelet::right_of_way::opposites;
use crate::lanelet::{Lanelet, LaneletMap, PolygonId};
use crate::parallel::InSmallParts;

/// The sides of an intersection, clockwise from north.
pub(super) const COMPASS: [&str; 8] = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];

/// All intersections: one for each `intersection_area`, then the clusters without one.
pub(super) fn intersections(
    map: &LaneletMap,
    lanes: &[Lane],
    tree: &LaneTree,
    conflicts: &[Vec<Conflict>],
) -> Vec<Intersection> {
    let mut found: Vec<Intersection> = map
        .polygons
        .as_slice()
        .par_iter()
        .in_small_parts()
        .filter(|polygon| polygon.attributes.is("type", "intersection_area"))
        .map(|polygon| of_area(map, polygon, lanes, tree))
        .collect();
    add_far_members(lanes, &mut found);
    found.extend(clusters(lanes, conflicts, &found));
    for intersection in &mut found {
        intersection.members.sort_by_key(|member| member.lane);
        intersection.arms = arms(lanes, intersection);
    }
    found
}

/// The id that a lanelet's tag names, if it is a number.
pub fn declared_area(lane: &Lane) -> Option<PolygonId> {
    lane.lanelet.attributes.get("intersection_area")?.parse().ok().map(PolygonId)
}

fn of_area(map: &LaneletMap, area: &crate::lanelet::Polygon, lanes: &[Lane], tree: &LaneTree) -> Intersection {
    let points: Vec<_> = map.points.get_each(area.points.iter().copied()).collect();
    let closed = points.len() > 1 && points[0].id == points[points.len() - 1].id;
    let open = &points[..points.len() - usize::from(closed)];
    let outline: Vec<Point> = open.iter().map(|p| p.position).collect();
    let height = open.iter().map(|p| p.ele().unwrap_or(0.0)).sum::<f64>() / open.len().max(1) as f64;
    let [low, high] = extent(&outline);
    let mut near: Vec<usize> = if low.x <= high.x {
        let reach = AABB::from_corners([low.x, low.y], [high.x, high.y]);
        tree.locate_in_envelope_intersecting(&reach).map(|found| found.data).collect()
    } else {
        Vec::new()
    };
    near.sort_unstable();
    let simple = simple_ring::is_simple(&outline);
    let (mut members, mut touched) = (Vec::new(), Vec::new());
    for lane in near {
        let common = match lanes[lane].simple && lanes[lane].area > 0.0 {
            true if simple => polygon::common_area(&lanes[lane].outline, &outline),
            true => polygon::overlap(&lanes[lane].outline, &outline),
            false => 0.0,
        };
        // Lanes that end on the outline share less than this with it, by rounding.
        let cover = if common > thresholds::RAW_CONFLICT { common / lanes[lane].area } else { 0.0 };
        let declared = declared_area(&lanes[lane]) == Some(area.id);
        let middle = (lanes[lane].heights[0] + lanes[lane].heights[1]) / 2.0;
        let inside = cover >= thresholds::COVER
            && lanes[lane].area > thresholds::LEAST_AREA
            && (middle - height).abs() <= thresholds::GRADE_SEPARATION;
        if lanes[lane].is_drivable() && (declared || inside) {
            members.push(IntersectionMember { lane, declared, cover });
        } else if declared || cover > 0.0 {
            touched.push((lane, cover));
        }
    }
    let middle = if low.x <= high.x { nalgebra::center(&low, &high) } else { Point::origin() };
    Intersection { area: Some(area.id), middle, height, ring: outline, members, touched, arms: Vec::new() }
}

/// Lanelets that name an area which they do not even come near.
fn add_far_members(lanes: &[Lane], found: &mut [Intersection]) {
    let by_area: FxHashMap<PolygonId, usize> =
        found.iter().enumerate().filter_map(|(at, one)| Some((one.area?, at))).collect();
    let mut known = FxHashSet::default();
    for (intersection, one) in found.iter().enumerate() {
        known.extend(one.members.iter().map(|member| (intersection, member.lane)));
        known.extend(one.touched.iter().map(|&(lane, _)| (intersection, lane)));
    }
    for (at, lane) in lanes.iter().enumerate() {
        let Some(&intersection) = declared_area(lane).and_then(|area| by_area.get(&area)) else { continue };
        if known.contains(&(intersection, at)) {
            continue;
        }
        let one = &mut found[intersection];
        if lane.is_drivable() {
            one.members.push(IntersectionMember { lane: at, declared: true, cover: 0.0 });
        } else {
            one.touched.push((at, 0.0));
        }
    }
}

/// Whether it has a `turn_direction`. Some converters write an empty one on every lanelet.
fn says_where_it_turns(lanelet: &Lanelet) -> bool {
    lanelet.attributes.get("turn_direction").is_some_and(|value| !value.trim().is_empty())
}

/// Lanelets with `turn_direction` outside every area, together where they conflict, start or end together. A lanelet
/// that conflicts with none is no intersection: it only sets the blinker where a lane branches off.
fn clusters(lanes: &[Lane], conflicts: &[Vec<Conflict>], known: &[Intersection]) -> Vec<Intersection> {
    let mut taken = vec![false; lanes.len()];
    for member in known.iter().flat_map(|intersection| &intersection.members) {
        taken[member.lane] = true;
    }
    let free: Vec<usize> = (0..lanes.len())
        .filter(|&at| !taken[at] && lanes[at].is_drivable())
        .filter(|&at| says_where_it_turns(lanes[at].lanelet))
        .collect();
    let mut groups = UnionFind::new(lanes.len());
    let mut at_edge = FxHashMap::default();
    for &at in &free {
        for key in [(true, lanes[at].start.ids), (false, lanes[at].end.ids)] {
            let first = *at_edge.entry(key).or_insert(at);
            groups.join(first, at);
        }
    }
    let is_free: FxHashSet<usize> = free.iter().copied().collect();
    let mut conflicting = FxHashSet::default();
    for &at in &free {
        for conflict in conflicts[at].iter().filter(|c| c.real && is_free.contains(&c.other)) {
            groups.join(at, conflict.other);
            conflicting.insert(at);
        }
    }
    let mut order: Vec<usize> = Vec::new();
    let mut by_root: FxHashMap<usize, Vec<usize>> = FxHashMap::default();
    for &at in &free {
        let root = groups.root(at);
        let list = by_root.entry(root).or_default();
        if list.is_empty() {
            order.push(root);
        }
        list.push(at);
    }
    let clusters = order.into_iter().filter_map(|root| by_root.remove(&root));
    clusters
        .filter(|cluster| cluster.iter().any(|at| conflicting.contains(at)))
        .map(|cluster| {
            let points: Vec<Point> = cluster.iter().flat_map(|&at| lanes[at].extent).collect();
            let [low, high] = extent(&points);
            Intersection {
                area: None,
                ring: Vec::new(),
                middle: nalgebra::center(&low, &high),
                height: 0.0,
                members: cluster
                    .into_iter()
                    .map(|lane| IntersectionMember { lane, declared: false, cover: 1.0 })
                    .collect(),
                touched: Vec::new(),
                arms: Vec::new(),
            }
        })
        .collect()
}

/// The edges across which vehicles come and go, leg by leg. Where one lanelet of the intersection goes on behind another
/// there is no leg.
fn arms(lanes: &[Lane], intersection: &Intersection) -> Vec<Arm> {
    let mut edges: Vec<ArmEdge> = Vec::new();
    let mut by_ids = FxHashMap::default();
    let members: Vec<&IntersectionMember> = intersection.members.iter().filter(|member| member.is_inside()).collect();
    let starts: FxHashSet<_> = members.iter().map(|member| lanes[member.lane].start.ids).collect();
    let ends: FxHashSet<_> = members.iter().map(|member| lanes[member.lane].end.ids).collect();
    for member in members {
        let lane = &lanes[member.lane];
        let outer = [(lane.start, true), (lane.end, false)].into_iter().filter(|(edge, inward)| match inward {
            true => !ends.contains(&edge.ids),
            false => !starts.contains(&edge.ids),
        });
        for (edge, inward) in outer {
            let at = *by_ids.entry((edge.ids, inward)).or_insert_with(|| {
                edges.push(ArmEdge { edge, inward, lanes: Vec::new() });
                edges.len() - 1
            });
            edges[at].lanes.push(member.lane);
        }
    }
    let for_cars = |edge: &ArmEdge| edge.lanes.iter().any(|&lane| lanes[lane].is_for_cars());
    let crossed: Vec<Crossed> =
        edges.iter().map(|e| Crossed { edge: e.edge, inward: e.inward, for_cars: for_cars(e) }).collect();
    let mut by_leg: BTreeMap<usize, Vec<ArmEdge>> = BTreeMap::new();
    for (edge, leg) in edges.into_iter().zip(legs(&crossed)) {
        by_leg.entry(leg).or_default().push(edge);
    }
    let mut arms: Vec<(f64, Arm)> = by_leg.into_values().map(|edges| arm(lanes, intersection.middle, edges)).collect();
    arms.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut arms: Vec<Arm> = arms.into_iter().map(|(_, arm)| arm).collect();
    let headings: Vec<Option<Vector>> = arms.iter().map(|arm| arm.heading_in).collect();
    let opposites = opposites(&headings, thresholds::OPPOSITE);
    for (arm, opposite) in arms.iter_mut().zip(opposites) {
        arm.opposite = opposite;
    }
    arms
}

/// An approach, with its bearing (degrees clockwise from north) as seen from the middle.
fn arm(lanes: &[Lane], middle: Point, edges: Vec<ArmEdge>) -> (f64, Arm) {
    let sum = edges.iter().map(|e| e.edge.middle().coords).sum::<Vector>() / edges.len().max(1) as f64;
    let away = Point::from(sum) - middle;
    let bearing = away.x.atan2(away.y).to_degrees().rem_euclid(360.0);
    // Lights are opposite by the directions of cars: a bicycle lane may leave the road earlier, and lead where no car comes from.
    let inward = edges.iter().filter(|e| e.inward).flat_map(|e| &e.lanes).map(|&lane| &lanes[lane]);
    let headings = inward.filter(|lane| lane.is_for_cars()).filter_map(Lane::heading_in);
    let heading_in = headings.sum::<Vector>().try_normalize(1e-9);
    let outward =
        edges.iter().filter(|e| !e.inward).flat_map(|e| &e.lanes).filter_map(|&lane| lanes[lane].heading_out());
    // The direction of the road tells better than its place: carriageways of one road lie apart.
    let road = heading_in.map(|inward| -inward).or_else(|| outward.sum::<Vector>().try_normalize(1e-9));
    let side = road.map_or(bearing, |road| road.x.atan2(road.y).to_degrees().rem_euclid(360.0));
    let compass = COMPASS[((side / 45.0).round() as usize) % COMPASS.len()];
    (bearing, Arm { edges, heading_in, compass, bearing: side, opposite: None })
}
