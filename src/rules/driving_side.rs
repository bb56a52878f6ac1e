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
    let of_side = |side| votes.places.iter().filter(|vote| vote.side == side).collect::<Vec<_>>();
    let [left, right] = [DrivingSide::Left, DrivingSide::Right].map(of_side);
    // The ways in and out of a car park may lie either way around; one such pair of one-way roads is no sign of an error.
    if [&left, &right].iter().any(|of_side| matches!(of_side[..], [vote] if !vote.on_one_road)) {
        return Vec::new();
    }
    let odd = if votes.left < votes.right { left } else { right };
    let message = format!("{} places drive on the left, {} on the right.", votes.left, votes.right);
    let finding =
        Finding::new("inconsistent", Subject::Map, message).measured(100.0 * share, 100.0 * params.share, "%");
    let named = odd.iter().take(MOST_NAMED);
    vec![named.fold(finding, |finding, vote| finding.with(Subject::Lanelet(vote.lane.0), "other side"))]
}
