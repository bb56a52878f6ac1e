//! Lanelets without length, that cross themselves, that lean over; bounds that say a point twice.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::simple_ring::RingFault;
use crate::geometry::{Point, Polyline, simple_ring};
use crate::lanelet::index::{Edge, Lane, MapIndex};
use crate::lanelet::{LineStringId, PointId};
use crate::rules::disordered_bound::{fold, with_points_in_order};

use super::params::{Params, subject};

/// From this gap on, metres, two bounds surely belong to two lanes; a sharp bend may have less.
const LEAST_GAP: f64 = 5.0;

pub fn judge(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = repeated(map);
    for at in 0..map.lanes.len() {
        let lane = &map.lanes[at];
        match lane.length() < params.short_length {
            true => findings.push(too_short(map, params, at)),
            false => findings.extend(crossing(map, at).or_else(|| running_back(map, at))),
        }
        findings.extend(apart(map, at));
        findings.extend(tilted(map, params, at));
    }
    findings
}

fn too_short(map: &MapIndex, params: &Params, at: usize) -> Finding {
    let lane = &map.lanes[at];
    let message = format!("Lanelet {} is {:.3} m long.", lane.id, lane.length());
    let (fault, least) = match lane.length() < params.least_length {
        true => ("zero-length", params.least_length),
        false => ("very-short", params.short_length),
    };
    Finding::new(fault, subject(map, at), message)
        .measured(lane.length(), least, "m")
        .at(Place::Point(lane.start.middle()))
}

/// A lanelet of which the outline crosses itself. Bounds with a point in common are another rule's business.
fn crossing(map: &MapIndex, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    // What follows itself closes its outline on itself, too.
    if lane.simple || lane.start.ids == lane.end.ids || share_a_point(map, lane) {
        return None;
    }
    let fault = *simple_ring::faults(&lane.outline, 0.0, 1).first()?;
    let place = match fault {
        RingFault::Crossing(_, _, place) => place,
        RingFault::TooFew(at) | RingFault::NotFinite(at) | RingFault::Spike(at) => *lane.outline.get(at)?,
    };
    // The outline runs along the left bound, and back along the right one.
    let bound = |edge: usize| match (edge + 1).cmp(&lane.left.len()) {
        Ordering::Less => Some(lane.bounds[0]),
        Ordering::Equal => None,
        Ordering::Greater => (edge + 1 < lane.outline.len()).then_some(lane.bounds[1]),
    };
    let sides = match fault {
        RingFault::Crossing(a, b, _) => [bound(a), bound(b)],
        _ => [None; 2],
    };
    let message = match sides {
        [Some(one), Some(other)] if one == other => format!("Bound {one} of lanelet {} crosses itself.", lane.id),
        [Some(one), None] | [None, Some(one)] => format!("Bound {one} of lanelet {} runs over an end of it.", lane.id),
        _ => format!("The outline of lanelet {} crosses itself.", lane.id),
    };
    let finding = Finding::new("self-crossing", subject(map, at), message).at(Place::Point(place));
    let [left, right] = lane.bounds;
    let finding = finding.with(Subject::LineString(left.0), "left").with(Subject::LineString(right.0), "right");
    Some(match sides {
        [Some(one), Some(other)] if one == other => with_points_in_order(map, finding, one),
        _ => finding,
    })
}

/// A lanelet with a bound that runs back over itself so exactly that it does not cross itself.
fn running_back(map: &MapIndex, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let (bound, place) = lane.bounds.into_iter().find_map(|bound| Some((bound, fold(map, bound)?)))?;
    let message = format!("Bound {bound} of lanelet {} runs back over itself.", lane.id);
    let finding = Finding::new("self-crossing", subject(map, at), message).with(Subject::LineString(bound.0), "bound");
    Some(with_points_in_order(map, finding.at(Place::Point(place)), bound))
}

/// A lanelet of which one bound begins behind the end of the other: the bounds of two lanes in a row.
fn apart(map: &MapIndex, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let along = (lane.left.last()? - lane.left.first()?).try_normalize(Polyline::MERGE)?;
    let reach = |points: &[Point]| {
        let stations = points.iter().map(|point| point.coords.dot(&along));
        stations.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let [left, right] = [reach(&lane.left), reach(&lane.right)];
    let gap = (right[0] - left[1]).max(left[0] - right[1]);
    if gap < LEAST_GAP {
        return None;
    }
    let [first, second] = lane.bounds;
    let message = format!("Bounds {first} and {second} of lanelet {} lie {gap:.1} m behind each other.", lane.id);
    let finding = Finding::new("bounds-apart", subject(map, at), message).measured(gap, LEAST_GAP, "m");
    Some(finding.with(Subject::LineString(first.0), "left").with(Subject::LineString(second.0), "right"))
}

fn share_a_point(map: &MapIndex, lane: &Lane) -> bool {
    let points = |line: LineStringId| map.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
    let left: BTreeSet<PointId> = points(lane.bounds[0]).iter().copied().collect();
    points(lane.bounds[1]).iter().any(|point| left.contains(point))
}

/// A lanelet with one bound far above the other.
fn tilted(map: &MapIndex, params: &Params, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let leaning = |edge: &Edge| {
        let [left, right] = edge.ids.map(|id| map.map.points.get(id).and_then(|point| point.ele()));
        let step = (left? - right?).abs();
        let limit = (params.tilt * edge.across().norm()).max(params.least_tilt);
        (step > limit).then_some((step, limit))
    };
    let (edge, (step, limit)) = [lane.start, lane.end].into_iter().find_map(|edge| Some((edge, leaning(&edge)?)))?;
    let message = format!(
        "Lanelet {} leans over: points {} and {} across it differ by {step:.2} m in height.",
        lane.id, edge.ids[0], edge.ids[1]
    );
    let finding = Finding::new("tilt", subject(map, at), message).measured(step, limit, "m");
    let [left, right] = edge.ids.map(|id| Subject::Point(id.0));
    Some(finding.with(left, "left").with(right, "right").at(Place::Line(edge.points.to_vec())))
}

/// Points that follow themselves on a bound.
fn repeated(map: &MapIndex) -> Vec<Finding> {
    let mut findings = Vec::new();
    for line in map.map.linestrings.iter().filter(|line| !map.users_of(line.id).is_empty()) {
        let subject = Subject::LineString(line.id.0);
        // A bound of one point has no length, which is told of; it would have none with the point named once.
        if line.points.iter().all(|id| Some(id) == line.points.first()) {
            continue;
        }
        for (before, pair) in line.points.windows(2).enumerate() {
            if pair[0] != pair[1] {
                continue;
            }
            let id = pair[0];
            let message = format!("Bound {} names point {id} twice in a row.", line.id);
            let finding = Finding::new("repeated-point", subject, message).with(Subject::Point(id.0), "point");
            let edits = vec![Edit::RemoveVertex { way: subject, position: before + 1 }];
            let place = map.map.points.get(id).map_or(Place::Unknown, |point| Place::Point(point.position));
            findings.push(finding.at(place).fixed_by(format!("name point {id} once"), true, edits));
        }
    }
    findings
}
