//! vm-02-03: of two stop lines one after the other, vehicles stop at the first.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::polygon;
use crate::lanelet::index::{MapIndex, StopLine};
use crate::lanelet::{LineStringId, RegulatoryElement, RoadType};

use super::stop_line_crossings;
use super::stop_line_crossings::StopLineCrossing;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    same: f64,
    reach: f64,
    extra: f64,
}

/// Elements that make vehicles stop at their `ref_line`.
const STOPPING: [&str; 2] = ["traffic_light", "traffic_sign"];

/// A stop line and where it crosses one lane.
type Crossed = (StopLine, StopLineCrossing);

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let uses = Uses::of(map);
    let mut by_lane: BTreeMap<usize, Vec<Crossed>> = BTreeMap::new();
    for line in stop_line_crossings::stop_lines(map) {
        for crossing in stop_line_crossings::crossings(map, &line, params.extra) {
            by_lane.entry(crossing.lane).or_default().push((line, crossing));
        }
    }
    // A pair across several lanes side by side is one finding, that of the first lane.
    let mut found: BTreeMap<[LineStringId; 2], Finding> = BTreeMap::new();
    for (lane, mut lines) in by_lane {
        lines.sort_by(|a, b| a.1.station.total_cmp(&b.1.station).then(a.0.way.cmp(&b.0.way)));
        for pair in lines.windows(2) {
            let [first, second] = [&pair[0], &pair[1]];
            if let Some(finding) = judge(map, params, &uses, lane, first, second) {
                found.entry([first.0.way, second.0.way]).or_insert(finding);
            }
        }
    }
    found.into_values().collect()
}

/// What stop lines are for.
struct Uses<'a> {
    /// The first light or sign that makes vehicles stop at a line.
    stopping: FxHashMap<LineStringId, &'a RegulatoryElement>,
    /// The lines that any element names.
    named: FxHashSet<LineStringId>,
}

impl<'a> Uses<'a> {
    fn of(map: &'a MapIndex) -> Self {
        let mut uses = Self { stopping: FxHashMap::default(), named: FxHashSet::default() };
        for element in &map.map.regulatory_elements {
            uses.named.extend(element.linestrings("refers").chain(element.linestrings("ref_line")));
            for line in element.linestrings("ref_line").filter(|_| STOPPING.contains(&element.subtype.as_str())) {
                uses.stopping.entry(line).or_insert(element);
            }
        }
        uses
    }
}

fn judge(
    map: &MapIndex,
    params: &Params,
    uses: &Uses,
    lane: usize,
    first: &Crossed,
    second: &Crossed,
) -> Option<Finding> {
    let gap = second.1.station - first.1.station;
    let id = map.lanes[lane].id;
    let [one, other] = [first.0.way, second.0.way];
    let finding = |fault, message: String| {
        Finding::new(fault, Subject::LineString(other.0), message)
            .with(Subject::LineString(one.0), "stop line before it")
            .with(Subject::Lanelet(id.0), "lanelet")
            .at(Place::Line(vec![first.1.place, second.1.place]))
    };
    if gap <= params.same {
        let message = format!("Stop lines {one} and {other} across lanelet {id} are one line, drawn twice.");
        return Some(merged(map, uses, finding("doubled", message).measured(gap, params.same, "m"), [one, other]));
    }
    // A line that an element names has a purpose of its own.
    let element = uses.stopping.get(&other).filter(|_| gap <= params.reach && !uses.named.contains(&one))?;
    if crosswalk_between(map, lane, first, second) {
        return None;
    }
    let message = format!(
        "Vehicles on lanelet {id} stop for {} at the second of two stop lines, {other}; {one} lies {gap:.1} m before it.",
        element.id
    );
    let found = finding("second-line", message).measured(gap, params.reach, "m");
    Some(found.with(Subject::RegulatoryElement(element.id.0), "element"))
}

/// Adds the edits that let every element name one of two lines, that at which vehicles stop already, and remove the other.
fn merged(map: &MapIndex, uses: &Uses, finding: Finding, lines: [LineStringId; 2]) -> Finding {
    let [a, b] = lines;
    let stops = |line: &LineStringId| (uses.stopping.contains_key(line), uses.named.contains(line));
    let [kept, gone] = if stops(&a) >= stops(&b) { [a, b] } else { [b, a] };
    let member = |line: LineStringId| Subject::LineString(line.0);
    let mut edits = Vec::new();
    for element in map.map.regulatory_elements.iter().filter(|_| uses.named.contains(&gone)) {
        let on = Subject::RegulatoryElement(element.id.0);
        for role in ["refers", "ref_line"] {
            if element.linestrings(role).any(|line| line == gone) && !element.linestrings(role).any(|line| line == kept)
            {
                edits.push(Edit::AddMember { on, role: role.into(), member: member(kept) });
            }
        }
    }
    edits.push(Edit::Remove { subject: member(gone) });
    finding.fixed_by(format!("use stop line {kept} in place of {gone}"), false, edits)
}

/// Whether people cross between two lines: then each has a purpose of its own.
fn crosswalk_between(map: &MapIndex, lane: usize, first: &Crossed, second: &Crossed) -> bool {
    let strip = [first.1.place, second.1.place];
    let [low, high] = crate::lanelet::index::extent(&strip);
    let near = map.lanes_near(low, high).into_iter().map(|other| &map.lanes[other]);
    let mut crosswalks = near.filter(|other| matches!(other.kind, RoadType::Crosswalk | RoadType::Walkway));
    let Some(center) = &map.lanes[lane].center else { return false };
    let steps = center.cut(first.1.station, second.1.station);
    crosswalks.any(|other| {
        steps.iter().any(|part| part.resampled(0.5).points().iter().any(|&p| polygon::contains(&other.outline, p)))
    })
}
