//! vm-07-08: outside intersections lanes do not lie on each other.

use rayon::prelude::*;
use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, angle_between, polygon};
use crate::lanelet::RoadType;
use crate::lanelet::index::{Conflict, Lane, MapIndex};
use crate::parallel::InSmallParts;

use super::crowd;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    area: f64,
    stacked: f64,
    along: f64,
}

/// Lanes whose directions differ by more (deg) run against each other.
const OPPOSITE: f64 = 150.0;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let (mut findings, mut pairs) = (Vec::new(), Vec::new());
    let street = |at: usize| {
        let lane = &map.lanes[at];
        lane.kind == RoadType::Road
            && lane.is_for_cars()
            && map.movement(at).is_none()
            && map.intersections_touching(at).next().is_none()
            && map.turn_direction(at).is_none()
    };
    // Each is asked for by every lane that lies on it.
    let streets: Vec<bool> = (0..map.lanes.len()).into_par_iter().in_small_parts().map(street).collect();
    let street = |at: usize| streets[at];
    for at in (0..map.lanes.len()).filter(|&at| street(at)) {
        let behind = map.conflicts[at].iter().filter(|one| one.other > at && one.real && one.area > params.area);
        let on_it: Vec<&Conflict> = behind.filter(|one| street(one.other)).collect();
        if on_it.len() > crowd::MOST {
            let id = map.lanes[at].id;
            let message = format!("Lane {id}: {}", crowd::too_many(on_it.len(), "lanes lie on it"));
            findings.push(Finding::new("overlap", Subject::Lanelet(id.0), message));
        }
        for conflict in on_it.into_iter().take(crowd::MOST) {
            let (lane, other) = (&map.lanes[at], &map.lanes[conflict.other]);
            let by_roundabout = || map.share_roundabout_element(at, conflict.other);
            if joined(map, at, conflict) || shuttle(params, lane, other, conflict.area) || by_roundabout() {
                continue;
            }
            let finding = finding(map, params, at, conflict);
            // Around an island of several lanes they cross by design.
            let is_at_roundabout = || [at, conflict.other].into_iter().all(|lane| map.is_at_roundabout(lane));
            if finding.fault != "crossing" || !is_at_roundabout() {
                pairs.push(([at, conflict.other], finding));
            }
        }
    }
    // Of an intersection without an area, vm-03-01 tells with all its lanelets; on private ground it only remarks on it.
    if !pairs.is_empty() {
        pairs.retain(|([a, b], _)| map.shared_unmarked(*a, *b).is_none_or(|one| one.private));
    }
    findings.extend(pairs.into_iter().map(|(_, finding)| finding));
    findings
}

fn finding(map: &MapIndex, params: &Params, at: usize, conflict: &Conflict) -> Finding {
    let (lane, other) = (&map.lanes[at], &map.lanes[conflict.other]);
    let finding = |fault, what| {
        let message = format!("Lanes {} and {} {what} over {:.1} m2.", lane.id, other.id, conflict.area);
        Finding::new(fault, Subject::Lanelet(lane.id.0), message)
            .with(Subject::Lanelet(other.id.0), "other lane")
            .measured(conflict.area, params.area, "m2")
            .at(Place::Point(conflict.place))
    };
    let along = angle(lane, other, conflict.place).is_none_or(|angle| angle <= params.along);
    let finding = match along {
        true => finding("overlap", "lie on each other"),
        false => finding("crossing", "cross each other outside an intersection"),
    };
    // If everything is drawn at one height, the map does not show whether one lane passes over the other.
    let [low, high] = lane.heights;
    let flat = low == high && [low, high] == other.heights;
    if flat { finding.graded(Severity::Info) } else { finding }
}

/// The angle between two lanes at a place, degrees, whichever way they run.
fn angle(a: &Lane, b: &Lane, place: Point) -> Option<f64> {
    let direction = |lane: &Lane| lane.center.as_ref().map(|line| line.direction(line.project(place).station));
    let angle = angle_between(direction(a)?, direction(b)?).abs().to_degrees();
    Some(angle.min(180.0 - angle))
}

/// Whether two lanes merge or branch: they start or end together, or a lane that one follows is beside the other.
fn joined(map: &MapIndex, x: usize, conflict: &Conflict) -> bool {
    let y = conflict.other;
    let (a, b) = (&map.lanes[x], &map.lanes[y]);
    let touch = a.start.touches(&b.start) || a.end.touches(&b.end);
    let common = |one: &[usize], other: &[usize]| one.iter().any(|lane| other.contains(lane));
    touch
        || map.branched_before(x, conflict)
        || common(map.followers(x), map.followers(y))
        || common(map.predecessors(x), map.predecessors(y))
}

/// A road so narrow that both directions use all of it: two opposite lanes on each other (vm-01-14).
fn shuttle(params: &Params, a: &Lane, b: &Lane, area: f64) -> bool {
    let headings = a.heading_in().zip(b.heading_in());
    let opposite = headings.is_some_and(|(x, y)| angle_between(x, y).abs().to_degrees() > OPPOSITE);
    let both = || a.area + b.area - polygon::overlap(&a.outline, &b.outline);
    opposite && area / both().max(f64::MIN_POSITIVE) > params.stacked
}
