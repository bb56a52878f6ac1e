//! vm-01-02: the line between two lanes of one direction says whether it may be crossed.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use serde::Deserialize;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Bound, LaneletId, LineStringId};

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
    let message = format!("Linestring {line} between two lanes of one direction has {what}; it must be yes or no.");
    Some(Finding::new(fault, Subject::LineString(line.0), message).with(Subject::Lanelet(lanelet.0), "lane"))
}
