//! vm-03-02: lanelets of an intersection say where they turn, and their bounds are not painted.

use std::collections::{BTreeSet, BinaryHeap};

use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::lanelet::index::{Intersection, Lane, MapIndex, Unmarked, allows_lane_change};
use crate::lanelet::{Attributes, LineString, LineStringId, TurnDirection};

use super::routing_moves::RoutingMoves;

/// Outside of areas a lane that bends by more than this, degrees, at an intersection does not go straight on.
const CERTAIN_TURN: f64 = 60.0;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    straight: f64,
    surely_straight: f64,
    surely_turning: f64,
    u_turn: f64,
    blinker_distance: f64,
    blinker_time: f64,
    default_speed: f64,
}

/// A label is forgotten where this many lanelets have one for each that has none.
const FEW_OF: usize = 3;
/// A lane that turns by this, degrees, or more to one side does not turn off to the other one.
const MOST_OUT_OF_A_BEND: f64 = 75.0;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for lanelet in &map.map.lanelets {
        let subject = Subject::Lanelet(lanelet.id.0);
        if let Some(value) = lanelet.attributes.get("turn_direction")
            && TurnDirection::parse(value).is_none()
        {
            let message = format!("turn_direction={value} of lanelet {} is not left, right or straight.", lanelet.id);
            let finding = Finding::new("turn-invalid", subject, message);
            findings.push(match map.lane(lanelet.id) {
                Some(lane) => worded(map, params, lane, value, finding),
                // Of a lanelet that is not judged: a tag that says nothing says nothing there, too.
                None if value.trim().is_empty() => without_label(finding, true),
                None => finding,
            });
        }
        if let Some(value) = lanelet.attributes.get("turn_signal_distance")
            && turn_signal_distance(&lanelet.attributes).is_none()
        {
            let message =
                format!("turn_signal_distance={value} of lanelet {} is not a number of metres, 0 or more.", lanelet.id);
            findings.push(Finding::new("turn-signal-distance", subject, message));
        }
    }
    let moves = RoutingMoves::new(map);
    for lane in 0..map.lanes.len() {
        if !map.intersections_of(lane).is_empty() {
            findings.extend(judge_label(map, params, lane));
            if map.has_area(lane) {
                findings.extend(judge_bounds(map, &moves, &map.lanes[lane]));
            }
            findings.extend(judge_blinker(map, params, lane));
        }
    }
    findings.extend(map.intersections.iter().filter_map(|one| painted_bounds(map, one)));
    findings.extend(map.unmarked_intersections().iter().flat_map(|one| forgotten_labels(map, params, one)));
    findings
}

/// Adds what mends a label that is no word: the label that fits, or none where no lanes meet. That a label was there may tell that an
/// intersection was to be drawn, unless it is empty.
fn worded(map: &MapIndex, params: &Params, at: usize, value: &str, finding: Finding) -> Finding {
    let is_empty = value.trim().is_empty();
    let is_inside = !map.intersections_of(at).is_empty() || map.meets_others(at) && !is_empty;
    if is_inside {
        return relabelled(map, params, at, finding);
    }
    without_label(finding, is_empty)
}

/// Adds the fix that takes the label from a lanelet.
fn without_label(finding: Finding, is_safe: bool) -> Finding {
    let edits = vec![Edit::RemoveTag { on: finding.subject, key: "turn_direction".into() }];
    finding.fixed_by("remove the tag turn_direction", is_safe, edits)
}

fn judge_label(map: &MapIndex, params: &Params, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let subject = Subject::Lanelet(lane.id.0);
    let turn = lane.turn();
    let attributes = &lane.lanelet.attributes;
    if !attributes.has("turn_direction") {
        if map.begins_in_a_point(at) {
            return None;
        }
        let message = format!("Intersection lanelet {} has no turn_direction (it turns {}).", lane.id, degrees(turn));
        return Some(relabelled(map, params, at, Finding::new("turn-missing", subject, message)));
    }
    let label = map.turn_direction(at)?;
    let is_far = map.side.side.is_none_or(|side| side.far_turn() == label);
    if turn.abs() > params.u_turn && is_far && label != TurnDirection::Straight {
        return None;
    }
    let toward = match label {
        TurnDirection::Left => turn,
        TurnDirection::Straight => -turn.abs(),
        TurnDirection::Right => -turn,
    };
    let severity = match label {
        TurnDirection::Straight => (toward < -params.surely_turning).then_some(Severity::Warning),
        // Out of a ring that bends the other way, beside a lane that goes on in it.
        _ if toward < -params.surely_turning && leaves_a_bend(map, params, at, label) => None,
        _ if toward < -params.surely_turning => Some(Severity::Error),
        _ => (turn.abs() < params.surely_straight).then_some(Severity::Warning),
    }?;
    // Outside every area a label without a bend may be there for the blinker alone, where lanes branch or join; and a bend of a road
    // without turns is no turn.
    let is_turn = label == TurnDirection::Straight && turn.abs() > CERTAIN_TURN && map.turns_at_unmarked(at);
    if severity == Severity::Warning && !map.has_area(at) && !is_turn {
        return None;
    }
    let message = format!("turn_direction={}, but lanelet {} turns {}.", label.as_str(), lane.id, degrees(turn));
    let limit = if turn.abs() < params.surely_straight { params.surely_straight } else { params.surely_turning };
    let finding = Finding::new("turn-mismatch", subject, message).measured(turn, limit, "deg").graded(severity);
    Some(relabelled(map, params, at, finding))
}

/// The lanelets that alone do not say where they turn at an intersection without an area.
fn forgotten_labels(map: &MapIndex, params: &Params, intersection: &Unmarked) -> Vec<Finding> {
    let says = |lane: &usize| map.turn_direction(*lane).is_some();
    let labelled = intersection.lanes.iter().filter(|lane| says(lane)).count();
    let is_missing =
        |lane: &usize| !map.lanes[*lane].lanelet.attributes.has("turn_direction") && map.lanes[*lane].is_for_cars();
    let missing: Vec<usize> = intersection.lanes.iter().copied().filter(is_missing).collect();
    // Where most say nothing, nobody meant them to: vm-03-01 tells of the intersection.
    if missing.len() * FEW_OF > labelled {
        return Vec::new();
    }
    let takes_part = |lane: &usize| map.meets_others(*lane) && !map.begins_in_a_point(*lane);
    let told = missing.into_iter().filter(takes_part).map(|lane| {
        let id = map.lanes[lane].id;
        // The second piece of one movement: nothing else leads from the one to anywhere, or to the other.
        let behind = match map.predecessors(lane) {
            &[before] if says(&before) && map.followers(before).len() == 1 => {
                format!("; it goes on with the movement {}: merge them", map.lanes[before].id)
            }
            _ => String::new(),
        };
        let message = format!(
            "Lanelet {id} has no turn_direction, as {labelled} others have that cross or join there (it turns {}){behind}.",
            degrees(map.lanes[lane].turn())
        );
        // Who turns across others without watching them does most harm.
        let turn = map.lanes[lane].turn();
        let crosses = intersection.crossed && turn.abs() > params.surely_turning;
        let is_far =
            map.side.side.is_none_or(|side| side.far_turn() == map.label_for(turn, params.straight, params.u_turn));
        let severity = if crosses && is_far { Severity::Error } else { Severity::Warning };
        let finding = Finding::new("turn-forgotten", Subject::Lanelet(id.0), message).graded(severity);
        match &map.lanes[lane].center {
            Some(center) => finding.at(Place::Line(center.points().to_vec())),
            None => finding,
        }
    });
    told.collect()
}

/// Whether a lane bends less to the other side than one that begins on the same nodes: so it turns off from that one.
fn leaves_a_bend(map: &MapIndex, params: &Params, at: usize, label: TurnDirection) -> bool {
    let turn = map.lanes[at].turn();
    turn.abs() < MOST_OUT_OF_A_BEND
        && map.siblings(at).any(|other| {
            let off = turn - map.lanes[other].turn();
            let toward = if label == TurnDirection::Left { off } else { -off };
            toward > params.surely_straight
        })
}

/// A turn in whole degrees, with its side: positive ones are to the left.
fn degrees(turn: f64) -> String {
    match turn.round() as i64 {
        0 => "0 deg".to_owned(),
        left if left > 0 => format!("{left} deg to the left"),
        right => format!("{} deg to the right", -right),
    }
}

/// Adds the centre line and the label that fits.
fn relabelled(map: &MapIndex, params: &Params, at: usize, finding: Finding) -> Finding {
    let lane = &map.lanes[at];
    let label = map.label_for(lane.turn(), params.straight, params.u_turn).as_str();
    let on = Subject::Lanelet(lane.id.0);
    let edits = vec![Edit::SetTag { on, key: "turn_direction".into(), value: label.into() }];
    let finding = match &lane.center {
        Some(center) => finding.at(Place::Line(center.points().to_vec())),
        None => finding,
    };
    finding.fixed_by(format!("set turn_direction={label}"), true, edits)
}

fn judge_bounds(map: &MapIndex, moves: &RoutingMoves, lane: &Lane) -> Vec<Finding> {
    let mut findings = Vec::new();
    let sides = [("left", &lane.left), ("right", &lane.right)];
    for (way, (side, points)) in lane.bounds.into_iter().zip(sides) {
        let Some(line) = map.map.linestrings.get(way) else { continue };
        let subject = Subject::Lanelet(lane.id.0);
        let found = |fault, message: String| {
            Finding::new(fault, subject, message).with(Subject::LineString(way.0), side).at(Place::Line(points.clone()))
        };
        if let Some(kind) = unwanted_type(line) {
            let message = format!(
                "{side} bound {way} of intersection lanelet {} has {kind}; expected type virtual or road_border.",
                lane.id
            );
            // Painted bounds are told of by intersection.
            if !is_painted(line) {
                findings.push(retyped(found("bound-type", message), Subject::LineString(way.0)));
            }
        }
        if allows_lane_change(line) {
            let message = format!("{side} bound {way} of intersection lanelet {} allows a lane change.", lane.id);
            findings.push(closed(map, moves, found("lane-change-in-ia", message), lane, way));
        }
    }
    findings
}

/// Adds the edit that forbids lane changes over a bound. Where vehicles change lanes there now, it needs review; where that is the only way
/// into a lane or out of it, or they change between these lanes behind it no more, there is none.
fn closed(map: &MapIndex, moves: &RoutingMoves, finding: Finding, lane: &Lane, way: LineStringId) -> Finding {
    let Some(at) = map.lane(lane.id) else { return finding };
    let over = moves.beside(at).into_iter().filter(|other| map.lanes[other.lane].bounds.contains(&way));
    let others: Vec<usize> = over.filter(|other| other.may_leave || other.may_enter).map(|other| other.lane).collect();
    let needs = |lane: usize| map.predecessors(lane).is_empty() || map.followers(lane).is_empty();
    // Behind the intersection vehicles may change between the same lanes, too.
    let change = |a: usize, b: usize| {
        moves.beside(a).iter().any(|other| other.lane == b && (other.may_leave || other.may_enter))
    };
    let change_behind =
        |other: usize| map.followers(at).iter().any(|&a| map.followers(other).iter().any(|&b| change(a, b)));
    let is_needed = !others.is_empty()
        && (others.iter().chain([&at]).any(|&lane| needs(lane)) || !others.iter().all(|&other| change_behind(other)));
    let finding = others
        .iter()
        .fold(finding, |finding, &other| finding.with(Subject::Lanelet(map.lanes[other].id.0), "lane beside"));
    if is_needed {
        return finding;
    }
    let on = Subject::LineString(way.0);
    let edits = vec![Edit::SetTag { on, key: "lane_change".into(), value: "no".into() }];
    finding.fixed_by("set lane_change=no", others.is_empty(), edits)
}

/// The painted bounds of the lanelets of one area, told of once.
fn painted_bounds(map: &MapIndex, intersection: &Intersection) -> Option<Finding> {
    let area = intersection.area?;
    let painted = |way: &LineStringId| {
        let line = map.map.linestrings.get(*way);
        line.is_some_and(|line| unwanted_type(line).is_some() && is_painted(line))
    };
    let ways: BTreeSet<LineStringId> =
        intersection.members.iter().flat_map(|member| map.lanes[member.lane].bounds).filter(painted).collect();
    let first = *ways.first()?;
    let kind = map.map.linestrings.get(first).and_then(unwanted_type).unwrap_or_default();
    let message = match ways.len() {
        1 => format!("Bound {first} in intersection area {area} has {kind}; expected type virtual or road_border."),
        count => format!(
            "{count} bounds of lanelets in intersection area {area} are painted, {first} the first with {kind}; expected type \
             virtual or road_border."
        ),
    };
    let finding = Finding::new("bound-type", Subject::Polygon(area.0), message);
    Some(ways.iter().fold(finding, |finding, way| finding.with(Subject::LineString(way.0), "painted bound")))
}

fn retyped(finding: Finding, on: Subject) -> Finding {
    let edits = vec![Edit::SetTag { on, key: "type".into(), value: "virtual".into() }];
    finding.fixed_by("set type=virtual", false, edits)
}

/// What is written instead of `virtual` or `road_border`; `None` if it is one of them.
fn unwanted_type(line: &LineString) -> Option<String> {
    match line.attributes.get("type") {
        Some("virtual" | "road_border") => None,
        Some(_) if line.attributes.is("subtype", "road_border") => Some("road_border as subtype".to_owned()),
        Some(kind) => Some(format!("type {kind}")),
        None => Some("no type".to_owned()),
    }
}

fn is_painted(line: &LineString) -> bool {
    matches!(line.attributes.get("type"), Some("line_thin" | "line_thick" | "pedestrian_marking" | "bike_marking"))
}

/// Whether the blinker for a turn would start inside a turn to the other side: walks back over the predecessors, the
/// nearest first.
fn judge_blinker(map: &MapIndex, params: &Params, at: usize) -> Option<Finding> {
    let turn = map.turn_direction(at)?;
    let opposite = match turn {
        TurnDirection::Left => TurnDirection::Right,
        TurnDirection::Right => TurnDirection::Left,
        TurnDirection::Straight => return None,
    };
    let lane = &map.lanes[at];
    let attributes = &lane.lanelet.attributes;
    let reach = turn_signal_distance(attributes).unwrap_or_else(|| {
        let speed = speed_limit(attributes).unwrap_or(params.default_speed) / 3.6;
        params.blinker_distance + params.blinker_time * speed
    });
    let mut seen = FxHashSet::from_iter([at]);
    let mut open = BinaryHeap::from([(std::cmp::Reverse(Metres(0.0)), at)]);
    while let Some((std::cmp::Reverse(Metres(gap)), next)) = open.pop() {
        if gap >= reach {
            break;
        }
        for &before in map.predecessors(next) {
            if !seen.insert(before) {
                continue;
            }
            if map.turn_direction(before) == Some(opposite) && !map.intersections_of(before).is_empty() {
                let other = map.lanes[before].id;
                let message = format!(
                    "The blinker for lanelet {} starts {reach:.0} m ahead, inside the opposite turn {other} that ends {gap:.1} m before it.",
                    lane.id
                );
                let value = format!("{:.1}", (gap * 10.0).floor() / 10.0);
                let on = Subject::Lanelet(lane.id.0);
                let edits = vec![Edit::SetTag { on, key: "turn_signal_distance".into(), value: value.as_str().into() }];
                let finding = Finding::new("turn-signal-overlap", on, message)
                    .with(Subject::Lanelet(other.0), "opposite turn")
                    .measured(gap, reach, "m");
                return Some(finding.fixed_by(format!("set turn_signal_distance={value}"), true, edits));
            }
            let farther = gap + map.lanes[before].length();
            if farther < reach {
                open.push((std::cmp::Reverse(Metres(farther)), before));
            }
        }
    }
    None
}

/// The tag's value in metres, if it is a number and not negative.
fn turn_signal_distance(attributes: &Attributes) -> Option<f64> {
    attributes.get("turn_signal_distance")?.trim().parse().ok().filter(|d: &f64| d.is_finite() && *d >= 0.0)
}

/// The tag's value in km/h, with or without its unit.
fn speed_limit(attributes: &Attributes) -> Option<f64> {
    let value = attributes.get("speed_limit")?.trim();
    let end = value.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(value.len());
    value[..end].parse().ok().filter(|speed: &f64| speed.is_finite())
}

/// A distance that can be ordered.
#[derive(Clone, Copy, PartialEq)]
struct Metres(f64);

impl Eq for Metres {}

impl PartialOrd for Metres {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Metres {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
