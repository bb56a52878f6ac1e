//! vm-01-02: the line between two lanes of one direction says whether it may be crossed.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Attributes, Bound, Lanelet, LaneletId, LineStringId};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Whether lines that are not painted have to say it, too.
    virtual_lines: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let roads = || map.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road"));
    let side = |bound: Bound| (bound.line, bound.inverted);
    let lefts: FxHashSet<(LineStringId, bool)> = roads().map(|lanelet| side(lanelet.left)).collect();
    let between: BTreeMap<LineStringId, LaneletId> = roads()
        .filter(|lanelet| lefts.contains(&side(lanelet.right)))
        .map(|lanelet| (lanelet.right.line, lanelet.id))
        .collect();
    let beside = map
        .map
        .lanelets
        .iter()
        .filter(|lanelet| is_for_wheels(lanelet))
        .flat_map(|lanelet| [lanelet.left, lanelet.right].map(|bound| (bound.line, lanelet.id)));
    let others: BTreeMap<LineStringId, LaneletId> = beside.filter(|(line, _)| !between.contains_key(line)).collect();
    let between = between.into_iter().filter_map(|(line, lanelet)| match may_be_silent(map, params, line) {
        true => judge_other(map, line, lanelet),
        false => judge(map, line, lanelet),
    });
    let others = others.into_iter().filter_map(|(line, lanelet)| judge_other(map, line, lanelet));
    between.chain(others).collect()
}

/// Whether a line between lanes of one direction is not painted, and need not say whether it may be crossed.
fn may_be_silent(map: &MapIndex, params: &Params, line: LineStringId) -> bool {
    let is_virtual = |tags: &Attributes| tags.is("type", "virtual") && tags.get("lane_change").is_none();
    !params.virtual_lines && map.map.linestrings.get(line).is_some_and(|line| is_virtual(&line.attributes))
}

/// Whether wheels drive on a lanelet; nobody changes lanes on a walkway.
fn is_for_wheels(lanelet: &Lanelet) -> bool {
    matches!(
        lanelet.attributes.get("subtype"),
        Some("road" | "highway" | "bus_lane" | "bicycle_lane" | "road_shoulder")
    )
}

/// Reports a line that is not shared by two lanes of one direction and lets only its paint say whether it may be crossed.
fn judge_other(map: &MapIndex, line: LineStringId, lanelet: LaneletId) -> Option<Finding> {
    let tags = &map.map.linestrings.get(line)?.attributes;
    let is_open = match tags.get("type") {
        Some("line_thin" | "line_thick" | "virtual") => true,
        // Nobody changes lanes over the edge of the road, but possibly over the line between a lane and a bicycle lane.
        Some("road_border") => parts_bicycles(map, line),
        _ => false,
    };
    if !is_open || tags.get("lane_change").is_some() {
        return None;
    }
    let on = Subject::LineString(line.0);
    let message =
        format!("Linestring {line} at the side of a lane does not say whether it may be crossed; its paint decides.");
    let finding = Finding::new("lane-change-implied", on, message).with(Subject::Lanelet(lanelet.0), "lane");
    let value = value_of_paint(tags);
    let edits = vec![Edit::SetTag { on, key: "lane_change".into(), value: value.into() }];
    Some(finding.fixed_by(format!("set lane_change={value}, as its paint says"), true, edits))
}

/// Whether a line parts a lane for cars from one for bicycles.
fn parts_bicycles(map: &MapIndex, line: LineStringId) -> bool {
    let users = map.users_of(line).iter().map(|&user| map.lanes[user].bicycle);
    let [bicycles, others] =
        users.fold([0, 0], |[a, b], bicycle| [a + usize::from(bicycle), b + usize::from(!bicycle)]);
    bicycles > 0 && others > 0
}

fn judge(map: &MapIndex, line: LineStringId, lanelet: LaneletId) -> Option<Finding> {
    let tags = &map.map.linestrings.get(line)?.attributes;
    let (fault, what) = match tags.get("lane_change") {
        Some("yes" | "no") => return None,
        None => ("lane-change-missing", "no lane_change".to_owned()),
        Some(value) => ("lane-change-invalid", format!("lane_change={value}")),
    };
    let on = Subject::LineString(line.0);
    let message = format!("Linestring {line} between two lanes of one direction has {what}; it must be yes or no.");
    let finding = Finding::new(fault, on, message).with(Subject::Lanelet(lanelet.0), "lane");
    // The value that Lanelet2 reads from the paint, so that no route changes. An existing value may have another meaning.
    let (value, safe) = (value_of_paint(tags), fault == "lane-change-missing");
    let edits = vec![Edit::SetTag { on, key: "lane_change".into(), value: value.into() }];
    Some(finding.fixed_by(format!("set lane_change={value}, as its paint says"), safe, edits))
}

/// The `lane_change` that Lanelet2 reads from the paint: `yes` over a dashed line.
pub fn value_of_paint(tags: &Attributes) -> &'static str {
    let dashed = matches!(tags.get("type"), Some("line_thin" | "line_thick")) && tags.is("subtype", "dashed");
    if dashed { "yes" } else { "no" }
}
