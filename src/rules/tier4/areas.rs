//! Intersection areas and the lanelets in them, as the existing validator judges them (vm-03-01, 02, 05, 08).

use rustc_hash::FxHashSet;

use crate::diagnostic::Subject;
use crate::geometry::{Point as Place, polygon, simple_ring};
use crate::lanelet::index::extent;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::{Seen, View, boxes_meet, covered_by};
use crate::lanelet::number::leading_integer;
use crate::lanelet::{LaneletId, PointId, Polygon, PolygonId};

use super::{Issue, Params, issue};

/// Share of a lanelet that an area has to cover for the lanelet to lie in it.
const COVER: f64 = 0.99;
/// A corner sharper than this (deg) is a spike; the tool asks for exactly none.
const SPIKE: f64 = 1e-6;

fn lanelet(id: LaneletId) -> Subject {
    Subject::Lanelet(id.0)
}

/// The intersection areas with their outlines, which may have two points only.
fn areas<'a>(view: &'a View<'_>) -> Vec<(&'a Polygon, Vec<Place>)> {
    view.polygons("intersection_area").map(|area| (area, view.ring(area))).collect()
}

/// `intersection_area_dangling_reference`: asks turning lanelets only, and reads the id into 32 bits, 0 if it cannot.
pub fn dangling_reference(view: &View, _: &Params) -> Vec<Issue> {
    let known: FxHashSet<PolygonId> = view.polygons("intersection_area").map(|area| area.id).collect();
    let tagged = view.lanelets.iter().filter(|seen| seen.tag("turn_direction").is_some_and(|turn| turn != "none"));
    let named = tagged.filter_map(|seen| Some((seen.id(), seen.tag("intersection_area")?)));
    let dangling = named.filter(|(_, value)| {
        let id = leading_integer(value).and_then(|id| i32::try_from(id).ok()).unwrap_or_default();
        !known.contains(&PolygonId(i64::from(id)))
    });
    dangling
        .map(|(id, value)| {
            issue(1, lanelet(id), format!("Lanelet {id} names intersection_area {value}, which does not exist."))
        })
        .collect()
}

/// `intersection_area_tagging`.
pub fn tagging(view: &View, _: &Params) -> Vec<Issue> {
    let areas = areas(view);
    let mut issues = Vec::new();
    for seen in &view.lanelets {
        let (id, tag) = (seen.id(), seen.area_tag());
        for (area, outline) in &areas {
            issues.extend(coverage(seen, tag, area.id, outline));
        }
        if tag.is_none() && is_turning(seen) {
            issues.push(issue(
                4,
                lanelet(id),
                format!("Lanelet {id} has a turn_direction but no intersection_area tag."),
            ));
        }
    }
    issues
}

fn is_turning(seen: &Seen) -> bool {
    seen.tag("turn_direction").is_some_and(|turn| !turn.is_empty())
}

/// How a lanelet and its tag relate to one area.
fn coverage(seen: &Seen, tag: Option<i64>, area: PolygonId, outline: &[Place]) -> Option<Issue> {
    let id = seen.id();
    let own = tag == Some(area.0);
    let candidate = seen.is("road") && boxes_meet(seen.extent, extent(outline));
    if !own && !candidate {
        return None;
    }
    let share = seen.share(outline);
    // A lanelet without an area has no share, and neither lies in an area nor outside.
    let (number, message) = match (share >= COVER, tag) {
        (true, None) => (1, format!("Lanelet {id} lies in intersection_area {area} but is not tagged with it.")),
        (true, Some(other)) if !own => {
            (2, format!("Lanelet {id} lies in intersection_area {area} but is tagged with {other}."))
        }
        (false, Some(_)) if own && share < COVER => {
            (3, format!("Lanelet {id} is tagged with intersection_area {area} but does not lie in it."))
        }
        _ => return None,
    };
    Some(issue(number, lanelet(id), message))
}

/// `turn_direction_tagging`: a lanelet of which every point lies in an area, or on its outline, has to say where it turns.
pub fn turn_direction(view: &View, _: &Params) -> Vec<Issue> {
    let mut issues = Vec::new();
    for (area, outline) in areas(view).into_iter().filter(|(_, outline)| outline.len() > 2) {
        let ring = polygon::to_geo(&outline);
        for at in view.near(extent(&outline), 0.0) {
            let seen = &view.lanelets[at];
            if !seen.is("road") || !seen.outline.iter().all(|&p| covered_by(p, &ring)) {
                continue;
            }
            let (id, area) = (seen.id(), area.id);
            match seen.tag("turn_direction") {
                None => issues.push(issue(
                    1,
                    lanelet(id),
                    format!("Lanelet {id} lies in intersection_area {area} but has no turn_direction."),
                )),
                Some("straight" | "left" | "right") => {}
                Some(value) => issues.push(issue(
                    2,
                    lanelet(id),
                    format!("Lanelet {id} has turn_direction {value}; it must be straight, left or right."),
                )),
            }
        }
    }
    issues
}

/// `lanelet_border_type`.
pub fn border_type(view: &View, _: &Params) -> Vec<Issue> {
    let tagged = view.lanelets.iter().filter(|seen| seen.tag("intersection_area").is_some());
    let wrong = tagged.filter(|seen| {
        let bounds = [seen.lanelet.left.line, seen.lanelet.right.line];
        let kinds = bounds.map(|line| view.map.linestrings.get(line).and_then(|line| line.attributes.get("type")));
        !kinds.iter().all(|kind| matches!(kind, Some("virtual" | "road_border")))
    });
    wrong
        .map(|seen| {
            let id = seen.id();
            issue(1, lanelet(id), format!("A bound of intersection lanelet {id} is neither virtual nor a road_border."))
        })
        .collect()
}

/// `lanelet_division`.
pub fn division(view: &View, _: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::AnyLane);
    let mut issues = Vec::new();
    for (at, seen) in view.lanelets.iter().enumerate() {
        let Some(area) = seen.area_tag() else { continue };
        for next in graph.following(at).into_iter().map(|next| &view.lanelets[next]) {
            if next.area_tag() == Some(area) {
                let (id, next) = (seen.id(), next.id());
                let message = format!("Lanelets {id} and {next} divide a movement of intersection_area {area}.");
                issues.push(issue(1, lanelet(id), message));
            }
        }
    }
    issues
}

/// `intersection_area_validity`: a ring either way round; points that repeat at once count as one.
pub fn validity(view: &View, _: &Params) -> Vec<Issue> {
    let areas = view.polygons("intersection_area").map(|area| (area.id, view.ring(area)));
    let faults = areas.filter_map(|(id, outline)| Some((id, *simple_ring::faults(&outline, SPIKE, 1).first()?)));
    faults
        .map(|(id, fault)| {
            let reason = match fault {
                simple_ring::RingFault::TooFew(_) => "it has too few points",
                simple_ring::RingFault::NotFinite(_) => "a coordinate is no number",
                simple_ring::RingFault::Spike(_) => "it has a spike",
                simple_ring::RingFault::Crossing(..) => "it crosses itself",
            };
            issue(1, Subject::Polygon(id.0), format!("intersection_area {id} is no valid polygon: {reason}."))
        })
        .collect()
}

/// `intersection_area_segment_type`: every vertex is a point of a road border, or of the end of a road lanelet.
pub fn segment_type(view: &View, _: &Params) -> Vec<Issue> {
    let borders: Vec<_> = view
        .map
        .linestrings
        .iter()
        .filter(|line| line.attributes.is("type", "road_border"))
        .map(|line| (line, extent(&view.places(line))))
        .collect();
    let mut issues = Vec::new();
    for (area, outline) in areas(view) {
        let reach = extent(&outline);
        let near = borders.iter().filter(|(_, border)| boxes_meet(*border, reach));
        let mut known: FxHashSet<PointId> = near.flat_map(|(line, _)| line.points.iter().copied()).collect();
        let roads = view.near(reach, 0.0).into_iter().map(|at| &view.lanelets[at]).filter(|seen| seen.is("road"));
        for [left, right] in roads.filter_map(Seen::ends).flatten() {
            if boxes_meet([left.position; 2], reach) {
                known.extend([left.id, right.id]);
            }
        }
        let strange: Vec<String> =
            area.points.iter().filter(|id| !known.contains(id)).map(ToString::to_string).collect();
        if !strange.is_empty() {
            let (id, points) = (area.id, strange.join(", "));
            let message =
                format!("Points of intersection_area {id} lie on no road border and no lanelet's end: {points}.");
            issues.push(issue(1, Subject::Polygon(id.0), message));
        }
    }
    issues
}
