//! Which way traffic lights hang, as the existing validator judges it (vm-04-02): from the lanelet that it finds first.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::{Issue, Params, issue, layer};
use crate::diagnostic::Subject;
use crate::lanelet::index::view::{Seen, Spot, View, spot};
use crate::lanelet::vocabulary::THREE_LAMPS;
use crate::lanelet::{LineString, LineStringId};

/// Least cosine between the edges of two lanelets that obey one light.
const TOGETHER: f64 = 0.707;

/// `correct_facing`.
pub fn facing(view: &View, _: &Params) -> Vec<Issue> {
    let ranks = layer::ranks(view);
    let mut issues = Vec::new();
    // For every light whether it hangs right for each element that names it.
    let mut right: BTreeMap<LineStringId, Vec<bool>> = BTreeMap::new();
    for light in view.elements("traffic_light") {
        let stop_line = view.lines(light, "ref_line").next();
        let Some([start, end]) = stop_line.and_then(|line| ends(view, line)) else { continue };
        // Of the lanelets that refer to an element, the one noted last is found first.
        let mut referrers = view.referrers(light.id).to_vec();
        referrers.sort_by_key(|&at| std::cmp::Reverse(ranks[at]));
        let edges: Vec<_> = referrers.iter().filter_map(|&at| edge(&view.lanelets[at], start, end)).collect();
        let Some((first, others)) = edges.split_first() else { continue };
        let kind = |line: &&LineString| {
            line.attributes.is("type", "traffic_light") && line.attributes.is("subtype", THREE_LAMPS)
        };
        for body in view.lines(light, "refers").filter(kind) {
            let Some([a, b]) = ends(view, body) else { continue };
            let id = body.id;
            for _ in others.iter().filter(|other| cosine(*first, **other) < TOGETHER) {
                let message =
                    format!("Traffic light {id} of {} rules lanelets that start in different directions.", light.id);
                issues.push(issue(1, Subject::LineString(id.0), message));
            }
            // No angle, where a line has no length, is a wrong one.
            right.entry(id).or_default().push(cosine(*first, b - a) > 0.0);
        }
    }
    for (id, right) in right {
        let (number, how) = match (right.contains(&true), right.contains(&false)) {
            (false, _) => (2, "right to left for those who obey it"),
            (true, true) => (3, "left to right for some who obey it, right to left for others"),
            (true, false) => continue,
        };
        issues.push(issue(number, Subject::LineString(id.0), format!("Traffic light {id} hangs {how}.")));
    }
    issues
}

fn cosine(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    a.dot(&b) / (a.norm() * b.norm())
}

fn ends(view: &View, line: &LineString) -> Option<[Spot; 2]> {
    let points = view.points(line);
    Some([spot(points.first()?), spot(points.last()?)])
}

/// The end of a lanelet that lies nearer to a stop line, whichever way that runs, from left to right.
fn edge(seen: &Seen, start: Spot, end: Spot) -> Option<Vector3<f64>> {
    let [front, back] = seen.ends()?.map(|edge| edge.map(spot));
    let far = |[a, b]: [Spot; 2]| {
        let sum = |a: Spot, b: Spot| (a - start).norm() + (b - end).norm();
        sum(a, b).min(sum(b, a))
    };
    let [left, right] = if far(front) <= far(back) { front } else { back };
    Some(right - left)
}
