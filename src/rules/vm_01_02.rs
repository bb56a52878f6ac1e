//! vm-01-02: the line between two lanes of one direction says whether it may be crossed.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::lane_change::{LaneChange, Participant, SIDES, is_said_by_side};
use crate::lanelet::{Attributes, Bound, Lanelet, LaneletId, LineStringId};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Whether lines that are not painted have to say it, too.
    virtual_lines: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let between = lines_between_lanes(map);
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

/// The lines between two road lanelets of one direction, each with the lanelet to its left.
pub fn lines_between_lanes(map: &MapIndex) -> BTreeMap<LineStringId, LaneletId> {
    let roads = || map.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road"));
    let side = |bound: Bound| (bound.line, bound.inverted);
    let lefts: FxHashSet<(LineStringId, bool)> = roads().map(|lanelet| side(lanelet.left)).collect();
    let shared = roads().filter(|lanelet| lefts.contains(&side(lanelet.right)));
    shared.map(|lanelet| (lanelet.right.line, lanelet.id)).collect()
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
    if !is_open || tags.has("lane_change") || is_said_by_side(tags) {
        return None;
    }
    let on = Subject::LineString(line.0);
    let message =
        format!("Linestring {line} at the side of a lane does not say whether it may be crossed; its paint decides.");
    let finding = Finding::new("lane-change-implied", on, message).with(Subject::Lanelet(lanelet.0), "lane");
    // Within an intersection nobody changes lanes, whatever is painted.
    let is_in_intersection = map.users_of(line).iter().any(|&user| map.has_area(user));
    Some(match as_painted(line, tags).filter(|_| !is_in_intersection) {
        Some((title, edit)) => finding.fixed_by(title, true, vec![edit]),
        None => finding,
    })
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
    let on = Subject::LineString(line.0);
    let found = |fault, message: String| Finding::new(fault, on, message).with(Subject::Lanelet(lanelet.0), "lane");
    let (fault, what) = match tags.get("lane_change") {
        Some("yes" | "no") => {
            return hidden_sides(tags).map(|what| found("lane-change-hidden", format!("On linestring {line} {what}")));
        }
        None if is_said_by_side(tags) => {
            return half_said(tags).map(|(what, severity)| {
                found("lane-change-half", format!("On linestring {line} {what}")).graded(severity)
            });
        }
        None => ("lane-change-missing", "no lane_change".to_owned()),
        Some(value) => ("lane-change-invalid", format!("lane_change={value}")),
    };
    let message = format!("Linestring {line} between two lanes of one direction has {what}; it must be yes or no.");
    // The value that Lanelet2 reads from the paint, so that no route changes. An existing value may have another meaning.
    let safe = fault == "lane-change-missing";
    let (title, edit) = as_painted(line, tags).unwrap_or_else(|| {
        let edit = Edit::RemoveTag { on, key: "lane_change".into() };
        ("remove lane_change: its paint says from which side it may be crossed".to_owned(), edit)
    });
    Some(found(fault, message).fixed_by(title, safe, vec![edit]))
}

/// What is wrong with tags of the sides beside `lane_change`, which Lanelet2 does not read there; `None` if they say the same.
fn hidden_sides(tags: &Attributes) -> Option<String> {
    let value = tags.get("lane_change")?;
    let other = SIDES.iter().find_map(|key| Some((key, tags.get(key).filter(|said| *said != value)?)));
    other.map(|(key, said)| format!("{key}={said} does not count beside lane_change={value}."))
}

/// What is wrong with a tag of one side alone, where the paint says otherwise, and how bad that is: the side that is not named is closed,
/// and `lane_change:left=no` is not read.
fn half_said(tags: &Attributes) -> Option<(String, Severity)> {
    let paint = LaneChange::of_paint(tags, Participant::Vehicle);
    let [left, right] = SIDES;
    match SIDES.map(|key| tags.get(key)) {
        [Some("no" | "false" | "0"), None] if paint.to_left => {
            let message =
                format!("{left}=no is not read without {right}: the line is crossed to the left, as its paint says.");
            Some((message, Severity::Warning))
        }
        [Some("yes" | "true" | "1"), None] if paint.to_right => {
            Some((format!("a missing {right} beside {left} means no, though the paint is open."), Severity::Info))
        }
        [None, Some(_)] if paint.to_left => {
            Some((format!("a missing {left} beside {right} means no, though the paint is open."), Severity::Info))
        }
        _ => None,
    }
}

/// The edit that says what the paint says, and its title; `None` for paint that is open to one side.
fn as_painted(line: LineStringId, tags: &Attributes) -> Option<(String, Edit)> {
    let value = LaneChange::of_paint(tags, Participant::Vehicle).as_value()?;
    let edit = Edit::SetTag { on: Subject::LineString(line.0), key: "lane_change".into(), value: value.into() };
    // Of a line without paint, what Lanelet2 takes it for.
    let reason = if tags.has("type") { "as its paint says" } else { "as a line without a type is read" };
    Some((format!("set lane_change={value}, {reason}"), edit))
}

/// The edit by which a line that says nothing of lane changes says what its paint says; `None` if it says it, by side or for both.
pub fn said_as_painted(line: LineStringId, tags: &Attributes) -> Option<Edit> {
    let is_said = matches!(tags.get("lane_change"), Some("yes" | "no")) || is_said_by_side(tags);
    as_painted(line, tags).filter(|_| !is_said).map(|(_, edit)| edit)
}
