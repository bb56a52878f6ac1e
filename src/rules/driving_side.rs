//! side: people drive on one side of the road, everywhere in a map.

use serde::Deserialize;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::{DrivingSide, MapIndex};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    share: f64,
}

/// The number of differing places that the message names; more would not fit a line.
const MOST_NAMED: usize = 5;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let votes = &map.side;
    let share = votes.left.min(votes.right) as f64 / (votes.left + votes.right).max(1) as f64;
    if share <= params.share {
        return Vec::new();
    }
    let message = format!("{} places drive on the left, {} on the right.", votes.left, votes.right);
    let rare = if votes.left < votes.right { DrivingSide::Left } else { DrivingSide::Right };
    let finding =
        Finding::new("inconsistent", Subject::Map, message).measured(100.0 * share, 100.0 * params.share, "%");
    let odd = votes.places.iter().filter(|(_, side)| *side == rare).take(MOST_NAMED);
    vec![odd.fold(finding, |finding, (lane, _)| finding.with(Subject::Lanelet(lane.0), "other side"))]
}
