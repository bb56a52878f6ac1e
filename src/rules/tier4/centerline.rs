//! Centre lines as the existing validator judges them (vm-01-10): point by point, each end by itself.

use super::{Issue, Params, issue};
use crate::diagnostic::Subject;
use crate::geometry::polygon;
use crate::lanelet::Point;
use crate::lanelet::index::view::{Seen, Spot, View, covered_by, spot};
use crate::rules::vm_01_10::{distance, off_plane};

/// `centerline_geometry`.
pub fn geometry(view: &View, params: &Params) -> Vec<Issue> {
    view.lanelets.iter().flat_map(|seen| judge(view, params, seen)).collect()
}

fn judge(view: &View, params: &Params, seen: &Seen) -> Vec<Issue> {
    let line = seen.lanelet.centerline.and_then(|id| view.map.linestrings.get(id));
    let (Some(line), Some([start, end])) = (line, seen.ends()) else { return Vec::new() };
    let points = view.points(line);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    let (id, name, subject) = (line.id, seen.id(), Subject::LineString(line.id.0));
    let ring = polygon::to_geo(&seen.outline);
    let mut issues = Vec::new();
    let mut outside: Vec<String> = Vec::new();
    for point in &points {
        // An end is known by its id, wherever on the line it is; of a ring it is the start alone.
        let edge = match point.id {
            id if id == first.id => Some(start),
            id if id == last.id => Some(end),
            _ => None,
        };
        if let Some(edge) = edge {
            let far = distance(point, edge);
            if far > params.number("planar_threshold") {
                let message = format!("Centre line {id} of lanelet {name} ends {far:.2} m from the lanelet's edge.");
                issues.push(issue(1, subject, message));
            }
        } else if !covered_by(point.position, &ring) {
            outside.push(point.id.to_string());
        }
    }
    if !outside.is_empty() {
        let outside = outside.join(", ");
        issues.push(issue(2, subject, format!("Centre line {id} leaves lanelet {name} at points {outside}.")));
    }
    if params.word("dimension_mode") == "3D" {
        let spots: Vec<Spot> = seen.left.iter().chain(&seen.right).map(|point| spot(point)).collect();
        let away = |point: &&Point| off_plane(&spots, spot(point));
        let farthest = points.iter().filter_map(away).fold(0.0, f64::max);
        if farthest > params.number("height_threshold") {
            issues.push(issue(3, subject, format!("Centre line {id} lies {farthest:.2} m off lanelet {name}.")));
        }
    }
    issues
}
