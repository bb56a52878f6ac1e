//! vm-03-15: bicycle lanes run beside the lanes for cars, share their border, and are not entered from them.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::geometry::{Point, Polyline, angle_between};
use crate::lanelet::index::{DrivingSide, Lane, MapIndex, allows_lane_change, is_road_border};
use crate::lanelet::right_of_way::{Relation, Turn};
use crate::lanelet::{LineStringId, RoadType};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    pub(super) gap: f64,
    along: f64,
}

/// Lanes whose directions differ by more (deg) do not run beside each other.
const BESIDE: f64 = 30.0;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for at in 0..map.lanes.len() {
        findings.extend(invisible(map, at));
        if map.lanes[at].bicycle {
            findings.extend(beside(map, params, at));
            findings.extend(followers(map, at));
            findings.extend(yields(map, at));
        }
    }
    findings
}

fn subject(map: &MapIndex, lane: usize) -> Subject {
    Subject::Lanelet(map.lanes[lane].id.0)
}

/// A road for bicycles only: no lane beside it leads a search there.
fn invisible(map: &MapIndex, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let attributes = &lane.lanelet.attributes;
    if lane.kind != RoadType::Road || lane.vehicle || !attributes.is("participant:bicycle", "yes") {
        return None;
    }
    let message = format!(
        "Bicycle lane {} is a road for bicycles only; Autoware finds it neither as road nor as bicycle lane.",
        lane.id
    );
    let edits = vec![Edit::SetTag { on: subject(map, at), key: "subtype".into(), value: "bicycle_lane".into() }];
    Some(Finding::new("invisible", subject(map, at), message).fixed_by("set subtype=bicycle_lane", false, edits))
}

/// What is wrong with the borders to the lanes beside.
fn beside(map: &MapIndex, params: &Params, at: usize) -> Vec<Finding> {
    let lane = &map.lanes[at];
    let reach = nalgebra::Vector2::repeat(params.gap);
    let mut findings = Vec::new();
    for other in map.lanes_near(lane.extent[0] - reach, lane.extent[1] + reach) {
        let road = &map.lanes[other];
        let parallel = lane.heading_in().zip(road.heading_in());
        let parallel = parallel.is_some_and(|(a, b)| angle_between(a, b).abs().to_degrees() <= BESIDE);
        if other == at || road.kind != RoadType::Road || !road.vehicle || road.bicycle || !parallel {
            continue;
        }
        // The bicycle lane's left border is the road's right one, or the other way round.
        for side in 0..2 {
            let (own, theirs) = (lane.bounds[side], road.bounds[1 - side]);
            if own == theirs {
                findings.extend(shared_border(map, at, other, own, side));
            } else if !lane.bounds.iter().any(|way| road.bounds.contains(way))
                && runs_along(params, lane, road, side)
                && [&lane.start, &lane.end].into_iter().any(|end| map.are_level(at, other, end.middle()))
                && !behind_kerbs(map, at, [own, theirs])
            {
                let message = format!("Bicycle lane {} does not share its border with road lane {}.", lane.id, road.id);
                let finding = Finding::new("not-shared", subject(map, at), message)
                    .with(subject(map, other), "road lane")
                    .with(Subject::LineString(own.0), "border of the bicycle lane")
                    .with(Subject::LineString(theirs.0), "border of the road lane");
                let edits = vec![Edit::ReplaceWay { lanelet: lane.id.0, from: own.0, to: theirs.0 }];
                findings.push(finding.fixed_by(format!("use way {theirs} for both"), false, edits));
            }
        }
    }
    findings
}

/// Whether both borders are kerbs, and the bicycle lane belongs to the road on its other side.
fn behind_kerbs(map: &MapIndex, at: usize, facing: [LineStringId; 2]) -> bool {
    let kerb = |way: &LineStringId| map.map.linestrings.get(*way).is_some_and(is_road_border);
    let [low, high] = map.lanes[at].extent;
    let own = |other: &usize| map.lanes[*other].bounds.iter().any(|way| map.lanes[at].bounds.contains(way));
    let of_a_road = |other: usize| map.lanes[other].is_for_cars() && map.lanes[other].kind == RoadType::Road;
    facing.iter().all(kerb) && map.lanes_near(low, high).into_iter().filter(own).any(of_a_road)
}

/// Whether the borders that face each other lie together over most of their length.
fn runs_along(params: &Params, lane: &Lane, road: &Lane, side: usize) -> bool {
    let bound = |lane: &Lane, side: usize| -> Option<Polyline> {
        let points: &[Point] = if side == 0 { &lane.left } else { &lane.right };
        Polyline::new(points.iter().copied())
    };
    let (Some(own), Some(theirs)) = (bound(lane, side), bound(road, 1 - side)) else { return false };
    let samples = own.resampled(crate::lanelet::index::HEADING_STEP);
    let close = samples.points().iter().filter(|&&p| theirs.distance(p) < params.gap).count();
    close as f64 > params.along * samples.points().len() as f64
}

/// The border that both use: nobody may change lanes over it, and the bicycle lane lies between the road lane and a kerb, which
/// on a one-way street can be on either side.
fn shared_border(map: &MapIndex, at: usize, road: usize, way: LineStringId, side: usize) -> Vec<Finding> {
    let (lane, road_lane) = (map.lanes[at].id, map.lanes[road].id);
    let mut findings = Vec::new();
    let about = |fault, message| {
        let finding = Finding::new(fault, subject(map, at), message).with(subject(map, road), "road lane");
        finding.with(Subject::LineString(way.0), "common border")
    };
    if map.map.linestrings.get(way).is_some_and(allows_lane_change) {
        let on = Subject::LineString(way.0);
        let edits = vec![Edit::SetTag { on, key: "lane_change".into(), value: "no".into() }];
        let message = format!("Bicycle lane {lane} may be entered from road lane {road_lane}.");
        findings.push(about("lane-change", message).fixed_by("set lane_change=no", false, edits));
    }
    // Its right border is common: it lies on the left of the road lane.
    let lies = if side == 1 { DrivingSide::Left } else { DrivingSide::Right };
    if map.side.side.is_some_and(|driven| driven != lies) && cars_beyond(map, at, road, side) {
        let message = format!("Bicycle lane {lane} is on the far side of road lane {road_lane}.");
        findings.push(about("wrong-side", message));
    }
    findings
}

/// Whether other cars drive against the road beyond the border of a bicycle lane that is not its common border with it, on this side.
/// A bicycle lane between lanes of one direction leads straight on beside those who turn off.
fn cars_beyond(map: &MapIndex, at: usize, road: usize, side: usize) -> bool {
    let lane = &map.lanes[at];
    let near = map.lanes_near(lane.extent[0], lane.extent[1]).into_iter().filter(|&other| other != at && other != road);
    let heading = map.lanes[road].heading_in();
    let against = |other: &Lane| {
        let headings = other.heading_in().zip(heading);
        headings.is_none_or(|(a, b)| angle_between(a, b).abs() > std::f64::consts::FRAC_PI_2)
    };
    near.map(|other| &map.lanes[other])
        .any(|other| other.is_for_cars() && other.bounds.contains(&lane.bounds[1 - side]) && against(other))
}

/// What comes before and behind it must be a bicycle lane, too.
fn followers(map: &MapIndex, at: usize) -> Vec<Finding> {
    let lane = &map.lanes[at];
    let both = map.predecessors(at).iter().chain(map.followers(at));
    let roads = both.copied().filter(|&other| map.lanes[other].vehicle && !map.lanes[other].bicycle);
    let findings = roads.map(|other| {
        let road = map.lanes[other].id;
        let (fault, message) = match lane.kind {
            RoadType::BicycleLane => {
                ("mixed-follow", format!("Bicycle lane {} is connected to road lane {road}.", lane.id))
            }
            _ => ("routable", format!("Cars reach bicycle lane {} along road lane {road}.", lane.id)),
        };
        Finding::new(fault, subject(map, at), message).with(subject(map, other), "road lane")
    });
    findings.collect()
}

/// Cyclists are the blind-spot module's: the near turn across them lists them as yield.
fn yields(map: &MapIndex, at: usize) -> Vec<Finding> {
    let Some((_, traffic, y)) = map.movement(at) else { return Vec::new() };
    let mut findings = Vec::new();
    for conflict in map.conflicts[at].iter().filter(|conflict| !conflict.grade_separated) {
        let Some(x) = traffic.of_lane(conflict.other) else { continue };
        let turn = traffic.movements[x];
        let real = map.conflicts[turn.lane].iter().any(|back| back.other == at && back.real);
        let crosses = turn.ranked.turn == Turn::Near && traffic.relation(x, y) == Relation::Same && real;
        if !crosses || !map.lanes[turn.lane].vehicle || map.ignored(turn.lane).binary_search(&at).is_ok() {
            continue;
        }
        let (bicycle, car) = (map.lanes[at].id, map.lanes[turn.lane].id);
        let message = format!("Near turn {car} crosses bicycle lanelet {bicycle} but does not list it as yield.");
        let seen = map.lanes[at].kind == RoadType::Road;
        let finding = Finding::new("yield", subject(map, turn.lane), message)
            .with(subject(map, at), "bicycle lane")
            .at(Place::Point(conflict.place))
            .graded(if seen { Severity::Warning } else { Severity::Info });
        let member = subject(map, at);
        findings.push(match map.rights_of_way(turn.lane).first() {
            // Autoware does not see a lane for bicycles alone: listing it would change nothing.
            Some(element) if seen => {
                let on = Subject::RegulatoryElement(element.id.0);
                let edits = vec![Edit::AddMember { on, role: "yield".into(), member }];
                finding.with(on, "right of way").fixed_by(format!("list {bicycle} as yield"), false, edits)
            }
            Some(element) => finding.with(Subject::RegulatoryElement(element.id.0), "right of way"),
            None => finding,
        });
    }
    findings
}
