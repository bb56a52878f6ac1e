//! vm-03-14: stop lines in the middle of an intersection hang on the lanelets that cross them.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Point, segment_crossing};
use crate::lanelet::index::{Lane, MapIndex, StopLine};
use crate::lanelet::{LineStringId, RegulatoryElement, Target};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    start: f64,
    extra: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    let markings = map.map.regulatory_elements.iter().filter(|element| element.subtype == "road_marking");
    for marking in markings {
        match shape(map, marking) {
            Err(finding) => findings.push(*finding),
            Ok(line) => findings.extend(judge_lanelets(map, params, marking, line)),
        }
    }
    findings.extend(unreferenced(map, params));
    findings
}

/// Exactly one `refers`, of type stop_line, and no `ref_line`. An element with another number of `refers` does not load.
fn shape(map: &MapIndex, marking: &RegulatoryElement) -> Result<LineStringId, Box<Finding>> {
    let lines: Vec<LineStringId> = marking.linestrings("refers").collect();
    let stray: Vec<Target> = marking.role("ref_line").collect();
    let is_stop =
        |id: LineStringId| map.map.linestrings.get(id).is_some_and(|line| line.attributes.is("type", "stop_line"));
    if let ([line], true) = (&lines[..], stray.is_empty())
        && is_stop(*line)
    {
        return Ok(*line);
    }
    let message =
        format!("road_marking {} must have exactly one refers of type stop_line and no ref_line.", marking.id);
    let on = Subject::RegulatoryElement(marking.id.0);
    let finding = Finding::new("shape", on, message);
    let finding = lines.iter().fold(finding, |finding, line| finding.with(Subject::LineString(line.0), "refers"));
    Err(Box::new(match (&lines[..], &stray[..]) {
        ([line], [_, ..]) if is_stop(*line) => {
            let members = stray.iter().filter_map(|target| match target {
                Target::LineString(id) => Some(Subject::LineString(id.0)),
                _ => None,
            });
            let edits = members.map(|member| Edit::RemoveMember { on, role: "ref_line".into(), member }).collect();
            finding.fixed_by("drop the ref_line", false, edits)
        }
        ([line], []) => {
            let edits =
                vec![Edit::SetTag { on: Subject::LineString(line.0), key: "type".into(), value: "stop_line".into() }];
            finding.fixed_by(format!("set type=stop_line on {line}"), false, edits)
        }
        _ => finding,
    }))
}

/// Where a stop line, as long as both bounds ask, crosses the centre line; at its start counts.
fn crossing(params: &Params, line: &StopLine, lane: &Lane) -> Option<Point> {
    let center = lane.center.as_ref()?;
    let misfit = line.misfit(lane, params.extra);
    if misfit.distance <= params.start {
        return Some(lane.start.middle());
    }
    let along = (line.ends[1] - line.ends[0]).normalize() * params.extra;
    let [a, b] = [line.ends[0] - along, line.ends[1] + along];
    center.segments().find_map(|(c, d)| segment_crossing(a, b, c, d).map(|(_, _, place)| place))
}

fn judge_lanelets(map: &MapIndex, params: &Params, marking: &RegulatoryElement, line: LineStringId) -> Vec<Finding> {
    let Some(stop) = map.stop_line(line) else { return Vec::new() };
    let on = Subject::RegulatoryElement(marking.id.0);
    let referrers: Vec<usize> = map.referrers(marking.id).iter().filter_map(|&id| map.lane(id)).collect();
    let mut findings = Vec::new();
    for &lane in &referrers {
        let id = map.lanes[lane].id;
        if crossing(params, &stop, &map.lanes[lane]).is_none() {
            let message = format!("Stop line {line} of {} does not cross {id}.", marking.id);
            let finding = Finding::new("not-crossing", on, message).with(Subject::LineString(line.0), "stop line");
            findings.push(finding.with(Subject::Lanelet(id.0), "lanelet").at(Place::Line(stop.ends.to_vec())));
        }
    }
    let crossed = referrers.iter().filter(|&&lane| crossing(params, &stop, &map.lanes[lane]).is_some());
    let mut siblings: Vec<usize> = crossed.flat_map(|&lane| map.siblings(lane)).collect();
    siblings.sort_unstable();
    siblings.dedup();
    for &sibling in siblings.iter().filter(|sibling| !referrers.contains(sibling)) {
        let lane = &map.lanes[sibling];
        let named =
            map.elements(lane.id, "traffic_light").any(|light| light.linestrings("ref_line").any(|own| own == line));
        let known = named || has_own_line(map, params, &stop, lane);
        let Some(place) = crossing(params, &stop, lane).filter(|_| lane.vehicle && !known) else { continue };
        let message = format!("Stop line {line} of {} crosses {} too, which lacks the element.", marking.id, lane.id);
        let subject = Subject::Lanelet(lane.id.0);
        let edits = vec![Edit::AddMember { on: subject, role: "regulatory_element".into(), member: on }];
        let finding = Finding::new("sibling-missing", on, message)
            .with(Subject::LineString(line.0), "stop line")
            .with(subject, "lanelet")
            .at(Place::Point(place));
        findings.push(finding.fixed_by(format!("let lanelet {} refer to it", lane.id), true, edits));
    }
    findings
}

/// Whether a lane stops at a line of its own where another one of its kind lies: lanelets that fan out each have one in the
/// box, over their own bounds, and these lines overlap.
fn has_own_line(map: &MapIndex, params: &Params, other: &StopLine, lane: &Lane) -> bool {
    let at_start = |line: &StopLine| line.misfit(lane, params.extra).distance <= params.start;
    let markings = map.elements(lane.id, "road_marking").flat_map(|marking| marking.linestrings("refers"));
    let mut own = markings.filter_map(|way| map.stop_line(way));
    own.any(|line| at_start(&line) == at_start(other) && crossing(params, &line, lane).is_some())
}

/// Stop lines inside an area that cross its lanelets and hang on nothing.
fn unreferenced(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut used: Vec<LineStringId> = Vec::new();
    for element in &map.map.regulatory_elements {
        used.extend(element.linestrings("refers").chain(element.linestrings("ref_line")));
    }
    used.sort_unstable();
    let all = map.map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line"));
    let free = all.filter(|line| used.binary_search(&line.id).is_err()).filter_map(|line| StopLine::of(map, line));
    free.filter_map(|line| {
        let middle = nalgebra::center(&line.ends[0], &line.ends[1]);
        let near = map.lanes_near(middle, middle);
        let crossed: Vec<usize> = near
            .into_iter()
            .filter(|&lane| map.lanes[lane].vehicle && map.movement(lane).is_some_and(|(it, ..)| it.holds(middle)))
            // A line at the start is vm-03-09's.
            .filter(|&lane| line.misfit(&map.lanes[lane], params.extra).distance > params.start)
            .filter(|&lane| crossing(params, &line, &map.lanes[lane]).is_some())
            .collect();
        let ids: Vec<i64> = crossed.iter().map(|&lane| map.lanes[lane].id.0).collect();
        let first = ids.first()?;
        let message =
            format!("Stop line {} crosses {first} inside the intersection, but nothing refers to it.", line.way);
        let subject = Subject::LineString(line.way.0);
        let finding = Finding::new("unreferenced", subject, message).at(Place::Line(line.ends.to_vec()));
        let finding = ids.iter().fold(finding, |finding, &id| finding.with(Subject::Lanelet(id), "lanelet"));
        let members = vec![("refers".into(), subject)];
        let edit = Edit::CreateRegulatoryElement { subtype: "road_marking".into(), members, referrers: ids };
        Some(finding.fixed_by("create a road_marking element", false, vec![edit]))
    })
    .collect()
}
