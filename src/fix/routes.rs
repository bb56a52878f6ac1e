//! Holds safe fixes to their promise: none changes who may go from where to where, unless its finding is about that.

use rustc_hash::FxHashMap;

use super::fixes_by_place::ByPlace;
use super::proposal::{Attempt, Proposal};
use super::route::{Change, Route};
use crate::diagnostic::Edit;

/// Whether a batch may change a route at all.
pub fn may_change(done: &[Proposal]) -> bool {
    done.iter().flat_map(Proposal::edits).any(|edit| match edit {
        Edit::SetTag { key, .. } | Edit::RemoveTag { key, .. } => {
            let key = key.as_str();
            let starts = ["lane_change", "one_way", "participant"];
            matches!(key, "type" | "subtype" | "area") || starts.iter().any(|start| key.starts_with(start))
        }
        Edit::AddMember { .. }
        | Edit::CreateArea { .. }
        | Edit::CreateRegulatoryElement { .. }
        | Edit::CreateStopLine { .. } => false,
        _ => true,
    })
}

/// The safe fixes that change a route that no finding of the batch is about, each with the reason.
pub fn unasked(attempt: &Attempt) -> Vec<(usize, String)> {
    let mut refused: FxHashMap<usize, String> = FxHashMap::default();
    if attempt.routes.is_empty() {
        return Vec::new();
    }
    let fixes = ByPlace::of(&attempt.done);
    for Change { route, is_won } in &attempt.routes {
        let keys = route.keys();
        let touching: Vec<usize> = fixes.about_any(&keys);
        let one_of = |at: &usize| attempt.done.get(*at);
        let is_asked = |one: &Proposal| !one.fix.safe || keys.iter().all(|key| one.about.contains(key));
        if touching.iter().filter_map(one_of).any(is_asked) {
            continue;
        }
        for at in touching {
            let Route { who, how, from, to } = route;
            let now = if *is_won { "now" } else { "no longer" };
            let reason =
                || format!("it changes a route: for {who}, {how} from lanelet {} to {} is {now} there", from.0, to.0);
            refused.entry(at).or_insert_with(reason);
        }
    }
    let mut refused: Vec<(usize, String)> = refused.into_iter().collect();
    refused.sort_unstable();
    refused
}
