//! vm-03-05: a movement through an intersection is one lanelet, not two.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Polyline, polygon};
use crate::lanelet::index::{Intersection, MapIndex};
use crate::lanelet::{Bound, Lanelet, LineStringId, PolygonId, Target};

use super::Rule;

/// See `rules/vm-03-05.md`.
pub struct NoDivision;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    depth: f64,
}

impl Rule for NoDivision {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        let mut findings = Vec::new();
        for lane in 0..map.lanes.len() {
            for &follower in map.followers(lane) {
                if follower != lane
                    && let Some(area) = divided(map, params, lane, follower)
                {
                    findings.push(finding(map, lane, follower, area));
                }
            }
        }
        findings
    }
}

/// The area inside which the first lane ends and the second goes on. `Some(None)` is an intersection without one.
fn divided(map: &MapIndex, params: &Params, lane: usize, follower: usize) -> Option<Option<PolygonId>> {
    if let Some(intersection) = map.in_same_intersection(lane, follower) {
        return Some(intersection.area);
    }
    if !map.lanes[lane].is_drivable() || !map.lanes[follower].is_drivable() {
        return None;
    }
    let both = [lane, follower];
    let near = both.iter().flat_map(|&at| map.intersections_touching(at));
    let mut inside = near.filter(|intersection| ends_inside(map, params, lane, intersection));
    inside.next().map(|intersection| intersection.area)
}

/// Whether a lane ends deep inside an area, on its level.
fn ends_inside(map: &MapIndex, params: &Params, lane: usize, intersection: &Intersection) -> bool {
    let lane = &map.lanes[lane];
    let end = lane.end.middle();
    let ring = &intersection.ring;
    let Some(border) = Polyline::new(ring.iter().chain(ring.first()).copied()) else { return false };
    polygon::contains(ring, end)
        && border.distance(end) > params.depth
        && (lane.heights[0] - intersection.height).abs() <= map.thresholds.grade_separation
}

fn finding(map: &MapIndex, lane: usize, follower: usize, area: Option<PolygonId>) -> Finding {
    let (first, second) = (&map.lanes[lane], &map.lanes[follower]);
    let area_name = area.map_or("the intersection".to_owned(), |area| format!("area {area}"));
    let message = format!("Lanelets {} and {} form one movement of {area_name}; merge them.", first.id, second.id);
    let finding = Finding::new("divided", Subject::Lanelet(first.id.0), message)
        .with(Subject::Lanelet(second.id.0), "second piece")
        .at(Place::Line(first.end.points.to_vec()));
    let finding = match area {
        Some(area) => finding.with(Subject::Polygon(area.0), "intersection area"),
        None => finding,
    };
    match merge(map, lane, follower) {
        Some(edits) => finding.fixed_by(format!("merge lanelet {} into {}", second.id, first.id), false, edits),
        None => finding,
    }
}

/// The edits that make one lanelet of two: only where each is the other's only neighbour and no other lanelet shares
/// a bound, else somebody has to decide.
fn merge(map: &MapIndex, lane: usize, follower: usize) -> Option<Vec<Edit>> {
    if map.followers(lane).len() != 1 || map.predecessors(follower).len() != 1 {
        return None;
    }
    let first = map.map.lanelets.get(map.lanes[lane].id)?;
    let second = map.map.lanelets.get(map.lanes[follower].id)?;
    let mut edits = Vec::new();
    for (into, from) in [(first.left, second.left), (first.right, second.right)] {
        if map.users_of(into.line).len() != 1 || map.users_of(from.line).len() != 1 {
            return None;
        }
        edits.extend(append(map, into, from)?);
    }
    edits.extend(inherit(map, first, second));
    edits.push(Edit::Remove { subject: Subject::Lanelet(second.id.0) });
    for LineStringId(way) in [second.left.line, second.right.line] {
        edits.push(Edit::Remove { subject: Subject::LineString(way) });
    }
    Some(edits)
}

/// Puts the points of the second bound behind those of the first, in the direction of travel; the common one once.
fn append(map: &MapIndex, into: Bound, from: Bound) -> Option<Vec<Edit>> {
    let count = map.map.linestrings.get(into.line)?.points.len();
    let way = Subject::LineString(into.line.0);
    let points = map.map.bound_points(from).skip(1).enumerate();
    let edits = points.map(|(i, point)| {
        // A way that runs against the lanelet grows at its front.
        let position = if into.inverted { 0 } else { count + i };
        Edit::InsertVertex { way, position, point: point.id.0 }
    });
    Some(edits.collect())
}

/// The first lanelet takes over the elements of the second, and its parts in the elements of others.
fn inherit(map: &MapIndex, first: &Lanelet, second: &Lanelet) -> Vec<Edit> {
    let (one, other) = (Subject::Lanelet(first.id.0), Subject::Lanelet(second.id.0));
    let own = second.regulatory_elements.iter().filter(|element| !first.regulatory_elements.contains(element));
    let mut edits: Vec<Edit> = own
        .map(|element| Edit::AddMember {
            on: one,
            role: "regulatory_element".into(),
            member: Subject::RegulatoryElement(element.0),
        })
        .collect();
    for element in &map.map.regulatory_elements {
        let on = Subject::RegulatoryElement(element.id.0);
        for member in element.members.iter().filter(|member| member.target == Target::Lanelet(second.id)) {
            edits.push(Edit::RemoveMember { on, role: member.role.clone(), member: other });
            if !element.lanelets(&member.role).any(|lanelet| lanelet == first.id) {
                edits.push(Edit::AddMember { on, role: member.role.clone(), member: one });
            }
        }
    }
    edits
}
