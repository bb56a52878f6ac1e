//! vm-03-09: lanelets of an intersection reach from their stop line to the prolonged stop line of the lane opposite.

use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::geometry::{Point, Vector, cross, polygon};
use crate::lanelet::index::{Arm, ArmEdge, Intersection, Lane, MapIndex, StopLine};
use crate::lanelet::{LaneletId, RoadType, TurnDirection};

use super::ends_at_stop_line;
use crate::lanelet::index::thresholds;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    offset: [f64; 2],
    angle: [f64; 2],
    extra: f64,
    band: f64,
    crosswalk_reach: f64,
}

/// The part of a stop line in a finding of lanelets that do not refer to it.
const LINE_NEARBY: &str = "stop line nearby";

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    let obeyed = obeyed_lines(map);
    for intersection in map.intersections.iter().filter(|one| one.area.is_some()) {
        for arm in &intersection.arms {
            let inward = arm.edges.iter().filter(|edge| edge.inward);
            for edge in inward.clone() {
                let mut starts: Vec<Finding> =
                    edge.lanes.iter().filter_map(|&lane| judge_start(map, params, lane)).collect();
                if edge.lanes.iter().all(|&lane| is_free(map, intersection, arm, lane)) {
                    // A line that lies there was drawn for them; on private ground the next junction is near, and may have drawn it.
                    let is_of_others = |finding: &Finding| {
                        is_within_private_ground(map, intersection)
                            && finding.related.iter().any(|it| it.part == LINE_NEARBY && obeyed.contains(&it.subject))
                    };
                    let stays = |finding: &Finding| finding.fix.is_some() && !is_of_others(finding);
                    starts.retain(|finding| finding.fault != "no-stop-line" || stays(finding));
                }
                findings.extend(one_for_the_entrance(map, starts));
            }
            // A line on which its own lanes do not start tells nothing about the exits.
            let aligned = |edge: &ArmEdge| {
                let lane = *edge.lanes.first()?;
                let misfit = |line: &StopLine| line.misfit(&map.lanes[lane], params.extra);
                map.stop_line_of(lane).filter(|line| misfit(line).distance <= params.offset[0])
            };
            let lines: Vec<StopLine> = inward.clone().filter_map(aligned).collect();
            let outward = arm.edges.iter().filter(|edge| !edge.inward);
            findings.extend(outward.filter_map(|edge| judge_end(map, params, arm, edge, &lines)));
            findings.extend(inward.flat_map(|edge| crosswalks_outside(map, params, intersection, edge)));
        }
    }
    findings
}

/// The lines that regulatory elements of lanelets name.
fn obeyed_lines(map: &MapIndex) -> FxHashSet<Subject> {
    let elements = map.map.regulatory_elements.iter().filter(|element| !map.referrers(element.id).is_empty());
    let lines = elements.flat_map(|element| element.linestrings("refers").chain(element.linestrings("ref_line")));
    lines.map(|line| Subject::LineString(line.0)).collect()
}

/// Whether nobody waits before a lanelet, and no light is there: no other lane meets it but those from the same arm, those that give way,
/// those of driveways, those that come from where its road goes on, and bicycle lanes beside it; nor where all
/// ground around is private. Before a crosswalk vehicles stop at the line of its own element.
fn is_free(map: &MapIndex, intersection: &Intersection, arm: &Arm, lane: usize) -> bool {
    let is_ruled = |subtype| map.elements(map.lanes[lane].id, subtype).next().is_some();
    let meets = |other: usize| map.in_same_intersection(lane, other).is_some() && !leads_in(arm, other);
    let is_private = |at: &usize| map.lanes[*at].lanelet.attributes.is("location", "private");
    let from_private = |at: usize| map.predecessors(at).iter().any(is_private);
    let of_driveway = |at: usize| is_private(&at) || from_private(at) || map.followers(at).iter().any(is_private);
    let gives_way = |other: usize| {
        let ignored = [(lane, other), (other, lane)].map(|(one, of)| map.ignored(one).binary_search(&of).is_ok());
        match ignored {
            [true, false] => true,
            [false, false] => is_straight(map, lane) && !is_straight(map, other) && joins(intersection, lane, other),
            _ => false,
        }
    };
    // Who turns across oncoming traffic waits inside, and who turns out of the stem of a T-junction waits for all on the road that leads
    // through, at a line: where it has none, none was drawn for anybody.
    let has_line = |other: &Arm| {
        let mut lanes = other.edges.iter().filter(|edge| edge.inward).flat_map(|edge| &edge.lanes);
        lanes.any(|&lane| map.stop_line_of(lane).is_some())
    };
    let on = where_it_goes_on(map, intersection, arm);
    let from_stem = |other: &Arm| {
        !on.is_empty()
            && intersection.arms.len() == 3
            && where_it_goes_on(map, intersection, other).is_empty()
            && has_line(other)
    };
    let is_met_inside = |other: usize| {
        let from = intersection.arms.iter().find(|one| leads_in(one, other));
        // Unless the map says that it goes first, though this one does not turn.
        !(is_straight(map, lane) && map.ignored(other).binary_search(&lane).is_ok())
            && from.is_some_and(|from| from_stem(from) || on.iter().any(|&on| std::ptr::eq(on, from)))
    };
    let waits_for = |other: usize| {
        let counts = !map.lanes[other].bicycle && meets(other) && !of_driveway(other);
        counts && !gives_way(other) && !is_met_inside(other)
    };
    let waits = || map.conflicts[lane].iter().any(|one| one.real && waits_for(one.other));
    (!from_private(lane) || is_within_private_ground(map, intersection))
        && (of_driveway(lane) || !waits())
        && !["traffic_light", "traffic_sign"].into_iter().any(is_ruled)
}

/// Whether all roads of an intersection are private.
fn is_within_private_ground(map: &MapIndex, intersection: &Intersection) -> bool {
    let ends = |lane: usize| map.predecessors(lane).iter().chain(map.followers(lane));
    let mut all = intersection.members.iter().flat_map(|member| ends(member.lane));
    all.all(|&at| map.lanes[at].lanelet.attributes.is("location", "private"))
}

fn is_straight(map: &MapIndex, lane: usize) -> bool {
    map.turn_direction(lane) == Some(TurnDirection::Straight)
}

fn leads_in(arm: &Arm, lane: usize) -> bool {
    arm.edges.iter().any(|edge| edge.inward && edge.lanes.contains(&lane))
}

fn leads_out(arm: &Arm, lane: usize) -> bool {
    arm.edges.iter().any(|edge| !edge.inward && edge.lanes.contains(&lane))
}

/// Whether two lanes leave an intersection on one arm.
fn joins(intersection: &Intersection, lane: usize, other: usize) -> bool {
    intersection.arms.iter().any(|arm| leads_out(arm, lane) && leads_out(arm, other))
}

/// The other arms to which, or from which, lanes lead straight on from this one.
fn where_it_goes_on<'i>(map: &MapIndex, intersection: &'i Intersection, arm: &Arm) -> Vec<&'i Arm> {
    let members = intersection.members.iter().map(|member| member.lane).filter(|&lane| is_straight(map, lane));
    let ahead = members.filter_map(|lane| match (leads_in(arm, lane), leads_out(arm, lane)) {
        (true, false) => intersection.arms.iter().find(|one| leads_out(one, lane)),
        (false, true) => intersection.arms.iter().find(|one| leads_in(one, lane)),
        _ => None,
    });
    ahead.filter(|one| !std::ptr::eq(*one, arm)).collect()
}

/// The findings of lanelets that start at one place, those without any stop line there as one.
fn one_for_the_entrance(map: &MapIndex, starts: Vec<Finding>) -> Vec<Finding> {
    let is_bare = |finding: &Finding| finding.fault == "no-stop-line" && finding.fix.is_none();
    let (bare, mut findings): (Vec<Finding>, Vec<Finding>) = starts.into_iter().partition(is_bare);
    let mut bare = bare.into_iter();
    if let Some(first) = bare.next() {
        let ids = |finding: &Finding| finding.subject.id().map(LaneletId);
        let lanelets: Vec<LaneletId> = ids(&first).into_iter().chain(bare.as_slice().iter().filter_map(ids)).collect();
        let finding = bare.fold(first, |all, one| all.with(one.subject, "starts there, too"));
        findings.push(with_line_drawn(map, finding, &lanelets));
    }
    findings
}

/// Adds the edit that draws a stop line where these lanelets start: the requirement wants one also where none is painted. A light without a
/// stop line needs one of its own.
fn with_line_drawn(map: &MapIndex, finding: Finding, lanelets: &[LaneletId]) -> Finding {
    let Some(&first) = lanelets.first().and_then(|id| map.lane_of(*id)).as_ref() else { return finding };
    let has_light = |id: &LaneletId| map.elements(*id, "traffic_light").next().is_some();
    if lanelets.iter().any(has_light) || first.start.ids[0] == first.start.ids[1] {
        return finding;
    }
    let points = first.start.ids.map(|id| id.0).to_vec();
    let edit = Edit::CreateMarking { points, lanelets: lanelets.iter().map(|id| id.0).collect() };
    finding.fixed_by("draw a stop line where its lanelets start, with a road_marking element", false, vec![edit])
}

/// The start must lie on the stop line.
fn judge_start(map: &MapIndex, params: &Params, at: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    // A piece inside the box is vm-03-05's.
    if !lane.is_for_cars() || map.predecessors(at).iter().any(|&before| map.in_same_intersection(before, at).is_some())
    {
        return None;
    }
    let subject = Subject::Lanelet(lane.id.0);
    let line = map.stop_line_of(at);
    if map.named_stop_line(at).is_none() && map.turn_direction(at).is_none() {
        // Not finished; what follows shows when it is.
        return None;
    }
    let Some(line) = line.filter(|_| map.named_stop_line(at).is_some()) else {
        return Some(no_stop_line(map, at, line));
    };
    let misfit = line.misfit(lane, params.extra);
    if misfit.distance <= params.offset[0] && misfit.angle <= params.angle[0] {
        return None;
    }
    let severe = misfit.distance > params.offset[1] || misfit.angle > params.angle[1];
    let message = format!(
        "Lanelet {} starts {:.2} m {} stop line {} (angle {:.0} deg).",
        lane.id,
        misfit.distance,
        if misfit.behind { "behind" } else { "before" },
        line.way,
        misfit.angle
    );
    let finding = Finding::new("start-misaligned", subject, message)
        .with(Subject::LineString(line.way.0), "stop line")
        .at(Place::Line(lane.start.points.to_vec()))
        .graded(if severe { Severity::Error } else { Severity::Warning });
    let finding = match misfit.distance > params.offset[0] {
        true => finding.measured(misfit.distance, params.offset[0], "m"),
        false => finding.measured(misfit.angle, params.angle[0], "deg"),
    };
    Some(match ends_at_stop_line::onto(map, at, &line) {
        Some(edits) => finding.fixed_by("move the ends of the lanes onto the stop line", false, edits),
        None => finding,
    })
}

/// No element of the lanelet names a stop line where it starts, though one may lie there.
fn no_stop_line(map: &MapIndex, at: usize, near: Option<StopLine>) -> Finding {
    let lane = &map.lanes[at];
    let subject = Subject::Lanelet(lane.id.0);
    let finding = |message: String| {
        let finding = Finding::new("no-stop-line", subject, message).at(Place::Line(lane.start.points.to_vec()));
        let before = map.predecessors(at).iter().map(|&before| Subject::Lanelet(map.lanes[before].id.0));
        before.fold(finding, |finding, before| finding.with(before, "approach"))
    };
    let Some(line) = near else {
        return finding(format!("Lanelet {} has no stop line where it enters the intersection.", lane.id));
    };
    let way = Subject::LineString(line.way.0);
    let edit = Edit::CreateRegulatoryElement {
        subtype: "road_marking".into(),
        members: vec![("refers".into(), way)],
        referrers: vec![lane.id.0],
    };
    finding(format!(
        "Lanelet {} has no stop line: no light, road marking or stop sign of it refers to {}, which lies there.",
        lane.id, line.way
    ))
    .with(way, LINE_NEARBY)
    .fixed_by(format!("refer to stop line {} as road marking", line.way), true, vec![edit])
}

/// The end must lie on the prolonged stop lines of its approach, or between them where they are staggered.
fn judge_end(map: &MapIndex, params: &Params, arm: &Arm, edge: &ArmEdge, lines: &[StopLine]) -> Option<Finding> {
    let inward = arm.heading_in?;
    let lane = &map.lanes[*edge.lanes.first()?];
    let mut worst = 0.0_f64;
    for point in edge.edge.points {
        let offsets = lines.iter().map(|line| ahead(line, inward, point));
        let [low, high] = offsets.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], d| [l.min(d), h.max(d)]);
        worst = worst.max(low).max(-high);
    }
    if lines.is_empty() || worst <= params.band {
        return None;
    }
    let line = lines.first()?.way;
    let message =
        format!("Exit of {} is {worst:.2} m from the prolonged stop line of the {} approach.", lane.id, arm.compass);
    let finding = Finding::new("end-misaligned", Subject::Lanelet(lane.id.0), message)
        .with(Subject::LineString(line.0), "stop line")
        .measured(worst, params.band, "m")
        .at(Place::Line(edge.edge.points.to_vec()));
    Some(finding)
}

/// How far a point lies ahead of the prolonged stop line, seen by those who drive in.
fn ahead(line: &StopLine, inward: Vector, point: Point) -> f64 {
    let along = line.ends[1] - line.ends[0];
    let off = cross(along, point - line.ends[0]) / along.norm();
    if cross(along, inward) < 0.0 { -off } else { off }
}

/// Crosswalks that lie on the lane before the intersection, close to its end, instead of inside.
fn crosswalks_outside(map: &MapIndex, params: &Params, intersection: &Intersection, edge: &ArmEdge) -> Vec<Finding> {
    let mut findings = Vec::new();
    let before = edge.lanes.first().map_or(&[][..], |&lane| map.predecessors(lane));
    for &approach in before {
        let lane = &map.lanes[approach];
        let [low, high] = lane.extent;
        for at in map.lanes_near(low, high) {
            let crosswalk = &map.lanes[at];
            if crosswalk.kind != RoadType::Crosswalk || !crosswalk.simple || !lane.simple {
                continue;
            }
            let outside = polygon::overlap(&crosswalk.outline, &lane.outline);
            let of_edge =
                edge.lanes.iter().map(|&inner| polygon::overlap(&crosswalk.outline, &map.lanes[inner].outline));
            let near = crosswalk.outline.iter().any(|p| (p - edge.edge.middle()).norm() <= params.crosswalk_reach);
            if !near || outside <= thresholds::REAL_AREA || outside <= of_edge.fold(0.0, f64::max) {
                continue;
            }
            let where_to = where_on(map, edge, lane, crosswalk);
            let message = format!("Crosswalk {} lies on lane {} {where_to}.", crosswalk.id, lane.id);
            let finding = Finding::new("crosswalk-outside", Subject::Lanelet(crosswalk.id.0), message)
                .with(Subject::Lanelet(lane.id.0), "approach")
                .measured(outside, thresholds::REAL_AREA, "m2");
            findings.push(match intersection.area {
                Some(area) => finding.with(Subject::Polygon(area.0), "intersection area"),
                None => finding,
            });
        }
    }
    findings
}

/// Where a crosswalk lies on the lane before an intersection, in words.
fn where_on(map: &MapIndex, edge: &ArmEdge, lane: &Lane, crosswalk: &Lane) -> &'static str {
    let line = edge.lanes.iter().find_map(|&inner| map.stop_line_of(inner));
    let Some((line, center)) = line.zip(lane.center.as_ref()) else { return "before the intersection" };
    let station = |point: Point| center.project(point).station;
    let near = crosswalk.outline.iter().map(|&corner| station(corner)).fold(f64::INFINITY, f64::min);
    let stop = station(nalgebra::center(&line.ends[0], &line.ends[1]));
    if stop <= near { "behind the stop line, outside the intersection" } else { "before the stop line" }
}
