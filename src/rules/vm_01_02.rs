//! vm-01-02: the line between two lanes of one direction says whether it may be crossed.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Attributes, Bound, LaneletId, LineStringId};

use super::Rule;

/// See `rules/vm-01-02.md`.
pub struct LaneChange;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Whether lines that are not painted have to say it, too.
    virtual_lines: bool,
}

impl Rule for LaneChange {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        let roads = || map.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road"));
        let side = |bound: Bound| (bound.line, bound.inverted);
        let lefts: FxHashSet<(LineStringId, bool)> = roads().map(|lanelet| side(lanelet.left)).collect();
        let between: BTreeMap<LineStringId, LaneletId> = roads()
            .filter(|lanelet| lefts.contains(&side(lanelet.right)))
            .map(|lanelet| (lanelet.right.line, lanelet.id))
            .collect();
        between.into_iter().filter_map(|(line, lanelet)| judge(map, params, line, lanelet)).collect()
    }
}

fn judge(map: &MapIndex, params: &Params, line: LineStringId, lanelet: LaneletId) -> Option<Finding> {
    let tags = &map.map.linestrings.get(line)?.attributes;
    let (fault, what) = match tags.get("lane_change") {
        Some("yes" | "no") => return None,
        None if tags.is("type", "virtual") && !params.virtual_lines => return None,
        None => ("lane-change-missing", "no lane_change".to_owned()),
        Some(value) => ("lane-change-invalid", format!("lane_change={value}")),
    };
    let on = Subject::LineString(line.0);
    let message = format!("Linestring {line} between two lanes of one direction has {what}; it must be yes or no.");
    let finding = Finding::new(fault, on, message).with(Subject::Lanelet(lanelet.0), "lane");
    // The value that Lanelet2 reads out of the paint, so that no route changes; a word that is there may mean something else.
    let (value, safe) = (if painted_for_change(tags) { "yes" } else { "no" }, fault == "lane-change-missing");
    let edits = vec![Edit::SetTag { on, key: "lane_change".into(), value: value.into() }];
    Some(finding.fixed_by(format!("set lane_change={value}, as its paint says"), safe, edits))
}

/// Whether the paint alone allows a lane change, as Lanelet2 reads it: a dashed line.
fn painted_for_change(tags: &Attributes) -> bool {
    matches!(tags.get("type"), Some("line_thin" | "line_thick")) && tags.is("subtype", "dashed")
}
