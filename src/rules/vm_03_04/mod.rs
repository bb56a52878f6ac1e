//! vm-03-04: every lanelet of an intersection exists, is connected, and is linked to its signal.

mod connection;
mod params;
mod signal;

use std::collections::BTreeMap;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, Polyline, Vector, angle_between, polygon};
use crate::lanelet::index::{Arm, Edge, Intersection, MapIndex, Traffic, U_TURN};
use crate::lanelet::{PointId, RoadType};

use super::crowd;
use connection::NearContinuations;
use params::Params;
use rustc_hash::FxHashSet;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let misses = connection::near_misses(map, params);
    let mut findings = connection::dangling(map, params, &misses);
    findings.extend(misses.into_findings());
    let near = NearContinuations::new(map, params);
    let mut ends_told = EndsTold::default();
    for (intersection, traffic) in map.intersections.iter().zip(&map.traffic) {
        findings.extend(ends_told.first(loose_ends(map, params, &near, (intersection, traffic))));
        findings.extend(movements_missing(map, intersection, traffic));
    }
    findings.extend(ends_told.too_many());
    findings.extend(signal::judge(map, params));
    findings
}

/// How often it is told of each lane that it ends, or starts, where nothing goes on: areas may lie over each other.
#[derive(Default)]
struct EndsTold(BTreeMap<(Subject, &'static str), usize>);

impl EndsTold {
    /// Those of the findings that are among the first of their lane.
    fn first(&mut self, findings: Vec<Finding>) -> impl Iterator<Item = Finding> {
        findings.into_iter().filter(|finding| {
            let told = self.0.entry((finding.subject, finding.fault)).or_default();
            *told += 1;
            *told <= crowd::MOST
        })
    }

    /// A finding for each lane of which only the first were told.
    fn too_many(self) -> impl Iterator<Item = Finding> {
        self.0.into_iter().filter(|(_, told)| *told > crowd::MOST).map(|((lane, fault), told)| {
            let many = crowd::too_many(told, "intersection areas lie over its end or start");
            let message = format!("Lane {}: {many}", lane.id().unwrap_or_default());
            Finding::new(fault, lane, message)
        })
    }
}

/// The outline of an intersection area.
struct Outline<'a> {
    ring: &'a [Point],
    line: Polyline,
    /// How close to it an edge lies on it, metres.
    reach: f64,
}

impl<'a> Outline<'a> {
    fn of(ring: &'a [Point], reach: f64) -> Option<Self> {
        Some(Self { ring, line: Polyline::new(ring.iter().chain(ring.first()).copied())?, reach })
    }

    /// Whether a lane with its other end at `far` leads in over an edge on the outline. A lane that passes by touches the
    /// outline along its side, not with an end that looks inward.
    fn is_entered(&self, edge: &Edge, far: Option<Point>, heading: Option<Vector>) -> bool {
        let middle = edge.middle();
        (polygon::contains(self.ring, middle) || self.line.distance(middle) <= self.reach)
            && far.is_some_and(|p| !polygon::contains(self.ring, p))
            && heading.is_some_and(|heading| polygon::contains(self.ring, middle + heading * (2.0 * self.reach)))
    }
}

/// Lanes that end or start on the border of an area where nothing goes on.
fn loose_ends(
    map: &MapIndex,
    params: &Params,
    near: &NearContinuations,
    (intersection, traffic): (&Intersection, &Traffic),
) -> Vec<Finding> {
    let Some(area) = intersection.area else { return Vec::new() };
    let Some(outline) = Outline::of(&intersection.ring, params.border) else { return Vec::new() };
    let [low, high] = crate::lanelet::index::extent(outline.ring);
    let reach = Vector::repeat(params.border);
    let members: FxHashSet<usize> = intersection.members.iter().map(|member| member.lane).collect();
    let mut findings = Vec::new();
    for at in map.lanes_near(low - reach, high + reach) {
        let lane = &map.lanes[at];
        if members.contains(&at) || !lane.vehicle || lane.kind != RoadType::Road {
            continue;
        }
        let center = lane.center.as_ref();
        let ends_here = outline.is_entered(&lane.end, center.map(Polyline::first), lane.heading_out());
        let back = lane.heading_in().map(|heading| -heading);
        let starts_here = outline.is_entered(&lane.start, center.map(Polyline::last), back);
        let missed = |edge: &Edge, lists: &[usize], inward: bool| {
            lists.is_empty()
                && map.is_on_level_of(edge, intersection)
                && !near.has(at, edge)
                && !is_closed(map, intersection, traffic, at, inward)
        };
        let ends = [
            (
                "in-lane-dead-end",
                ends_here && missed(&lane.end, map.followers(at), true),
                format!("Lane {} enters intersection {area} but no lanelet continues it.", lane.id),
                (&lane.end, &map.settings.loose_ends.ends),
            ),
            (
                "out-lane-unreached",
                starts_here && missed(&lane.start, map.predecessors(at), false),
                format!("No lanelet of intersection {area} leads to lane {}.", lane.id),
                (&lane.start, &map.settings.loose_ends.starts),
            ),
        ];
        for (fault, _, message, (edge, known)) in ends.into_iter().filter(|(_, broken, ..)| *broken) {
            let finding = Finding::new(fault, Subject::Lanelet(lane.id.0), message);
            let finding = finding.with(Subject::Polygon(area.0), "intersection area");
            let finding = finding.at(Place::Line(edge.points.to_vec()));
            let is_known = known.contains(&lane.id.0);
            findings.push(if is_known { finding.graded(Severity::Info) } else { finding });
        }
    }
    findings
}

/// Whether a lane of a road for both directions can have no movement: no other road leads on from there (`inward`) or leads
/// there, or the user prohibits every movement. This happens if the road is one-way behind the intersection: on this side, only
/// vehicles that turned on the road itself drive against it.
fn is_closed(map: &MapIndex, intersection: &Intersection, traffic: &Traffic, at: usize, inward: bool) -> bool {
    let arms = &intersection.arms;
    let row = lanes_abreast(map, at);
    let edge = |lane: usize| if inward { &map.lanes[lane].end } else { &map.lanes[lane].start };
    // A lane of the other direction, with the line between the two, or on the same ground.
    let is_beside = |other: &Edge, [left, right]: [PointId; 2]| {
        other.ids[0] == left || other.ids[1] == right || other.ids == [right, left]
    };
    let beside = |arm: &Arm| {
        let mut edges = arm.edges.iter().filter(|other| other.inward != inward);
        edges.any(|other| row.iter().any(|&lane| is_beside(&other.edge, edge(lane).ids)))
    };
    let Some(own) = arms.iter().position(beside) else { return false };
    let leads = |arm: &Arm| {
        let mut edges = arm.edges.iter().filter(|other| other.inward != inward);
        edges.any(|other| other.lanes.iter().any(|&lane| map.lanes[lane].is_for_cars()))
    };
    let mut others = (0..arms.len()).filter(|&arm| arm != own && leads(&arms[arm]));
    let pair = |other: usize| if inward { [own, other] } else { [other, own] };
    others.all(|other| traffic.prohibited.contains(&pair(other)))
}

/// A lane and those of its direction that lie side by side with it.
fn lanes_abreast(map: &MapIndex, at: usize) -> Vec<usize> {
    let mut row = vec![at];
    for side in [0, 1] {
        let mut last = at;
        let is_next = |lane: usize, next: usize| {
            next != lane && map.lanes[next].bounds[1 - side] == map.lanes[lane].bounds[side] && map.lanes[next].vehicle
        };
        while let Some(&next) =
            map.users_of(map.lanes[last].bounds[side]).iter().find(|&&next| is_next(last, next) && !row.contains(&next))
        {
            row.push(next);
            last = next;
        }
    }
    row
}

/// The lanelets of an intersection to which an approach leads. A movement in two pieces is one all the same: that is
/// vm-03-05's.
fn reached(map: &MapIndex, intersection: &Intersection, from: usize) -> FxHashSet<usize> {
    let inward = intersection.arms[from].edges.iter().filter(|edge| edge.inward);
    let mut open: Vec<usize> = inward.flat_map(|edge| edge.lanes.iter().copied()).collect();
    let mut reached: FxHashSet<usize> = open.iter().copied().collect();
    let members: FxHashSet<usize> = intersection.members.iter().map(|member| member.lane).collect();
    while let Some(lane) = open.pop() {
        open.extend(map.followers(lane).iter().filter(|next| members.contains(next) && reached.insert(**next)));
    }
    reached
}

/// Whether a traffic sign other than a stop or give-way sign hangs on the lanes of an approach.
fn has_other_sign(map: &MapIndex, arm: &Arm) -> bool {
    let inner = arm.edges.iter().filter(|edge| edge.inward).flat_map(|edge| edge.lanes.iter().copied());
    let mut lanes = inner.flat_map(|lane| map.predecessors(lane).iter().copied().chain([lane]));
    lanes.any(|lane| map.elements(map.lanes[lane].id, "traffic_sign").any(|sign| !map.ranks(sign)))
}

/// Whether a vehicle would turn around to leave by an approach: the two are the carriageways of one road.
fn leads_back(map: &MapIndex, from: &Arm, to: &Arm) -> bool {
    let mut out = to.edges.iter().filter(|edge| !edge.inward).flat_map(|edge| &edge.lanes);
    let out = out.find_map(|&lane| map.lanes[lane].heading_out());
    let turn = from.heading_in.zip(out).map(|(before, behind)| angle_between(before, behind));
    turn.is_some_and(|turn| turn.abs().to_degrees() > U_TURN)
}

/// Every approach with lanes in must lead to every other with lanes out, unless the user says there is no such movement, or the
/// vehicle would turn around.
fn movements_missing(map: &MapIndex, intersection: &Intersection, traffic: &Traffic) -> Vec<Finding> {
    let Some(area) = intersection.area else { return Vec::new() };
    let arms = &intersection.arms;
    let leads = |arm: usize, inward: bool| {
        let mut edges = arms[arm].edges.iter().filter(|edge| edge.inward == inward);
        edges.any(|edge| edge.lanes.iter().any(|&lane| map.lanes[lane].is_for_cars()))
    };
    let mut findings = Vec::new();
    for from in (0..arms.len()).filter(|&arm| leads(arm, true)) {
        let reached = reached(map, intersection, from);
        let leads_to = |to: usize| {
            let mut outward = arms[to].edges.iter().filter(|edge| !edge.inward);
            outward.any(|edge| edge.lanes.iter().any(|lane| reached.contains(lane)))
        };
        // A sign that is no stop sign may be why there is only one way to go.
        let signed = (0..arms.len()).filter(|&to| leads_to(to)).count() <= 1 && has_other_sign(map, &arms[from]);
        for to in (0..arms.len()).filter(|&arm| arm != from && leads(arm, false)) {
            let is_settled = leads_to(to) || traffic.movements.is_empty() || traffic.prohibited.contains(&[from, to]);
            if is_settled || leads_back(map, &arms[from], &arms[to]) {
                continue;
            }
            let [a, b] = [(from, true), (to, false)].map(|(arm, inward)| map.approach_name(intersection, arm, inward));
            let message = format!("No lanelet from the {a} to the {b} of intersection {area}.");
            let mut finding = Finding::new("movement-missing", Subject::Polygon(area.0), message);
            for (arm, inward, part) in [(from, true, "from"), (to, false, "to")] {
                let edges = arms[arm].edges.iter().filter(|edge| edge.inward == inward);
                for lane in edges.filter_map(|edge| edge.lanes.first().copied()) {
                    let outside = if inward { map.predecessors(lane) } else { map.followers(lane) };
                    for &outer in outside {
                        finding = finding.with(Subject::Lanelet(map.lanes[outer].id.0), part);
                    }
                }
            }
            let middle = |arm: usize, inward: bool| {
                let mut edges = arms[arm].edges.iter().filter(move |edge| edge.inward == inward);
                edges.next().map(|edge| edge.edge.middle())
            };
            let finding = if signed { finding.graded(Severity::Info) } else { finding };
            findings.push(match (middle(from, true), middle(to, false)) {
                (Some(a), Some(b)) => finding.at(Place::Line(vec![a, intersection.middle, b])),
                _ => finding,
            });
        }
    }
    findings
}
