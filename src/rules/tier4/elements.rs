//! Single elements as the existing validator judges them: road markings, the parts of virtual traffic lights (vm-03-14,
//! 16), and blinkers that overlap (vm-03-02).

use std::collections::{BTreeSet, VecDeque};

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Issue, Params, issue, layer};
use crate::diagnostic::Subject;
use crate::lanelet::index::drawn_centerline::length;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::View;
use crate::lanelet::{LaneletId, LineString, Point, RegulatoryElement};
use crate::rules::element_size::diagonal_of_lines;

fn element(found: &RegulatoryElement) -> Subject {
    Subject::RegulatoryElement(found.id.0)
}

fn line(found: &LineString) -> Subject {
    Subject::LineString(found.id.0)
}

/// `road_markings`.
pub fn road_markings(view: &View, _: &Params) -> Vec<Issue> {
    let mut issues = Vec::new();
    for marking in view.elements("road_marking") {
        let id = marking.id;
        let refers: Vec<&LineString> = view.lines(marking, "refers").collect();
        if refers.len() != 1 || view.lines(marking, "ref_line").next().is_some() {
            issues.push(issue(1, element(marking), format!("road_marking {id} must have one refers and no ref_line.")));
        }
        for other in refers.into_iter().filter(|other| !other.attributes.is("type", "stop_line")) {
            issues.push(issue(
                2,
                line(other),
                format!("Linestring {} of road_marking {id} is no stop_line.", other.id),
            ));
        }
    }
    issues
}

/// `regulatory_element_details_for_virtual_traffic_lights`: each part by itself.
pub fn virtual_traffic_lights(view: &View, params: &Params) -> Vec<Issue> {
    view.elements("virtual_traffic_light").flat_map(|light| parts(view, light, params)).collect()
}

fn parts(view: &View, light: &RegulatoryElement, params: &Params) -> Vec<Issue> {
    let id = light.id;
    let supported = params.words("supported_refers_type");
    let supported: Vec<&str> = supported.iter().map(String::as_str).collect();
    let mut issues = Vec::new();
    let typed = |number, role: &str, types: &[&str]| -> Vec<Issue> {
        let wrong = view
            .lines(light, role)
            .filter(|found| !found.attributes.get("type").is_some_and(|kind| types.contains(&kind)));
        let types = types.join(" or ");
        wrong
            .map(|found| {
                let message = format!("{role} {} of virtual_traffic_light {id} must be of type {types}.", found.id);
                issue(number, line(found), message)
            })
            .collect()
    };
    issues.extend(typed(1, "start_line", &["virtual"]));
    let stop_lines = view.lines(light, "ref_line").count();
    if stop_lines != 1 {
        let message = format!("virtual_traffic_light {id} must have one ref_line, not {stop_lines}.");
        issues.push(issue(2, element(light), message));
    }
    issues.extend(typed(3, "ref_line", &["stop_line"]));
    issues.extend(typed(4, "end_line", &["virtual"]));
    if view.lines(light, "refers").next().is_none() {
        issues.push(issue(5, element(light), format!("virtual_traffic_light {id} has no refers.")));
    }
    issues.extend(typed(6, "refers", &supported));
    let limit = params.number("max_bounding_box_size");
    let diagonal = diagonal_of_lines(view, light, &["start_line", "ref_line", "end_line", "refers"]);
    if let Some(diagonal) = diagonal.filter(|diagonal| *diagonal > limit) {
        let message =
            format!("virtual_traffic_light {id} and its lanelets spread over {diagonal:.0} m, more than {limit} m.");
        issues.push(issue(7, element(light), message));
    }
    issues
}

/// `turn_signal_distance_overlap`: searches back along the lanes for an opposite turn whose far end is near enough.
pub fn turn_signal(view: &View, params: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::Car);
    let mut lengths: FxHashMap<usize, f64> = FxHashMap::default();
    let mut issues = Vec::new();
    for (at, seen) in view.lanelets.iter().enumerate() {
        let opposite = match seen.tag("turn_direction") {
            Some("left") => "right",
            Some("right") => "left",
            _ => continue,
        };
        let own = seen.tag("turn_signal_distance").and_then(|value| value.trim().parse().ok());
        let limit = own.unwrap_or_else(|| params.number("default_turn_signal_distance"));
        let mut found = BTreeSet::new();
        let mut before = |here: usize, behind: f64| -> Vec<(usize, f64)> {
            let mut length = |before| *lengths.entry(before).or_insert_with(|| length(view, &view.lanelets[before]));
            graph.previous(here).into_iter().map(|before| (before, behind + length(before))).collect()
        };
        let mut open = VecDeque::from(before(at, 0.0));
        // A lanelet counts once, with the length of the way there over the fewest lanelets.
        let mut visited = FxHashSet::default();
        while let Some((here, length)) = open.pop_front() {
            if length > limit || !visited.insert(here) {
                continue;
            }
            if view.lanelets[here].tag("turn_direction") == Some(opposite) {
                found.insert(view.lanelets[here].id());
            }
            open.extend(before(here, length));
        }
        if !found.is_empty() {
            let id = seen.id();
            let others: Vec<String> = found.iter().map(LaneletId::to_string).collect();
            let message =
                format!("Blinker for {id} starts {limit} m ahead, before the opposite turn {}.", others.join(","));
            issues.push(issue(1, Subject::Lanelet(id.0), message));
        }
    }
    issues
}

/// `local_coordinates_declaration`: once a point has local coordinates, all points must have both; the first such point is not
/// judged.
pub fn local_coordinates(view: &View, _: &Params) -> Vec<Issue> {
    let points = || view.map.points.iter();
    if !points().any(|point| point.local().contains(&true)) {
        return Vec::new();
    }
    if points().all(|point| matches!(point.local(), [true, true] | [false, false])) {
        return points().filter(|point| point.local() == [false, false]).map(|point| lacks(point, 1)).collect();
    }
    let first = layer::first_point(view, |point| point.local().contains(&true)).map(|point| point.id);
    let lacking = points().filter(|point| Some(point.id) != first).filter_map(|point| {
        Some(match point.local() {
            [false, false] => lacks(point, 1),
            [true, false] => lacks(point, 2),
            [false, true] => lacks(point, 3),
            [true, true] => return None,
        })
    });
    lacking.collect()
}

fn lacks(point: &Point, number: u16) -> Issue {
    let what = match number {
        1 => "neither local_x nor local_y",
        2 => "local_x but no local_y",
        _ => "local_y but no local_x",
    };
    let id = point.id;
    issue(number, Subject::Point(id.0), format!("Point {id} has {what}; others have local coordinates."))
}
