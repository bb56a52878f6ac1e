//! vm-03-07: lanelets that start side by side stay side by side, and share the border between them.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::geometry::{Polyline, cross};
use crate::lanelet::index::{Arm, Intersection, Lane, MapIndex, Movement, Traffic};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    overlap: [f64; 2],
    merge: f64,
}

/// Degrees by which the turns of two lanes that lead to different approaches may be in the wrong order: drawn by hand,
/// two lanes straight on are not quite parallel.
const TURN_NOISE: f64 = 5.0;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    let all = map.intersections.iter().zip(&map.traffic);
    for (intersection, traffic) in all.filter(|(intersection, _)| intersection.area.is_some()) {
        for arm in &intersection.arms {
            for (left, right) in neighbours(map, traffic, arm) {
                findings.extend(judge(map, params, intersection, left, right));
            }
        }
    }
    findings
}

/// Movements of an approach from lanes next to each other: left lane, right lane.
fn neighbours<'a>(map: &MapIndex, traffic: &'a Traffic, arm: &Arm) -> Vec<(&'a Movement, &'a Movement)> {
    let mut pairs = Vec::new();
    let inward: Vec<_> = arm.edges.iter().filter(|edge| edge.inward).collect();
    for left in &inward {
        for right in inward.iter().filter(|right| right.edge.ids[0] == left.edge.ids[1]) {
            let movements = |lanes: &[usize]| -> Vec<&'a Movement> {
                // Near turns cross the bicycle lane beside them: vm-03-15 says how.
                let vehicles = lanes.iter().filter(|&&lane| map.lanes[lane].is_for_cars());
                vehicles.filter_map(|&lane| traffic.movements.get(traffic.of_lane(lane)?)).collect()
            };
            for a in movements(&left.lanes) {
                pairs.extend(movements(&right.lanes).into_iter().map(|b| (a, b)));
            }
        }
    }
    pairs
}

fn judge(
    map: &MapIndex,
    params: &Params,
    intersection: &Intersection,
    left: &Movement,
    right: &Movement,
) -> Option<Finding> {
    let (a, b) = (&map.lanes[left.lane], &map.lanes[right.lane]);
    let merge = a.end.ids == b.end.ids;
    let area = map.conflicts[left.lane].iter().find(|conflict| conflict.other == right.lane);
    let place = area.map_or(Place::Unknown, |conflict| Place::Point(conflict.place));
    // The same one speaks where people drive on the other side.
    let (first, second) = (a.id.min(b.id), a.id.max(b.id));
    let about = |fault, message: String| {
        Finding::new(fault, Subject::Lanelet(first.0), message).with(Subject::Lanelet(second.0), "neighbour")
    };
    // Those that lead to two approaches cross only on ground that both cover: one may turn off to its own side and bend back.
    if !merge && (area.is_some() || left.to == right.to) && swapped(left, right, a, b) {
        let message = format!("Lanelets {first},{second} from neighbouring lanes swap sides.");
        return Some(about("crossing", message).at(place));
    }
    let overlap = area.map_or(0.0, |conflict| conflict.area);
    if overlap > params.overlap[0] {
        let message = format!("Neighbouring lanelets {first},{second} overlap {overlap:.2} m2.");
        // Two lanes that become one must overlap where they do.
        let severe = overlap > params.overlap[1] && !merge;
        let finding = about("overlap", message).measured(overlap, params.overlap[0], "m2").at(place);
        return Some(finding.graded(if severe { Severity::Error } else { Severity::Warning }));
    }
    let beside = a.end.ids[1] == b.end.ids[0] && left.to == right.to && left.ranked.turn == right.ranked.turn;
    if !beside || a.bounds[1] == b.bounds[0] {
        return None;
    }
    let border = |id| if id == a.id { a.bounds[1] } else { b.bounds[0] };
    let (v, w) = (border(first), border(second));
    let message = format!("Neighbouring lanelets {first},{second} use different ways {v},{w} as common border.");
    let finding = about("not-shared", message)
        .with(Subject::LineString(v.0), "border of the first")
        .with(Subject::LineString(w.0), "border of the second");
    let finding = match intersection.area {
        Some(area) => finding.with(Subject::Polygon(area.0), "intersection area"),
        None => finding,
    };
    if apart(a, b).is_none_or(|apart| apart > params.merge) {
        return Some(finding);
    }
    let edits = vec![Edit::ReplaceWay { lanelet: second.0, from: w.0, to: v.0 }];
    Some(finding.fixed_by(format!("use way {v} for both"), true, edits))
}

/// Whether the right one of two lanes ends left of the other: side by side on one approach, by their turns on two.
fn swapped(left: &Movement, right: &Movement, a: &Lane, b: &Lane) -> bool {
    if left.to != right.to {
        return a.turn() < b.turn() - TURN_NOISE;
    }
    let across = b.end.middle() - a.end.middle();
    a.heading_out().is_some_and(|heading| cross(heading, across) > 0.0)
}

/// Largest distance between the borders that face each other, metres.
fn apart(a: &Lane, b: &Lane) -> Option<f64> {
    let (v, w) = (a.border(1)?, b.border(0)?);
    let from = |x: &Polyline, y: &Polyline| x.points().iter().map(|&p| y.distance(p)).fold(0.0, f64::max);
    Some(from(&v, &w).max(from(&w, &v)))
}
