//! Holds fixes to what they may do to routes: a safe one changes none, one that needs review takes no way on, unless the finding is
//! about that.

use rustc_hash::{FxHashMap, FxHashSet};

use super::fixes_by_place::ByPlace;
use super::harmful_fixes::{Suspected, united};
use super::proposal::{Attempt, Proposal};
use super::route::{Change, Route};
use crate::diagnostic::Edit;

/// Whether a fix may change a route at all.
pub fn may_change(one: &Proposal) -> bool {
    one.edits().any(|edit| match edit {
        Edit::SetTag { key, .. } | Edit::RemoveTag { key, .. } => {
            let key = key.as_str();
            let starts = ["lane_change", "one_way", "participant"];
            matches!(key, "type" | "subtype" | "area") || starts.iter().any(|start| key.starts_with(start))
        }
        Edit::AddMember { .. }
        | Edit::CreateArea { .. }
        | Edit::CreateRegulatoryElement { .. }
        | Edit::CreateStopLine { .. }
        | Edit::CreateMarking { .. }
        | Edit::SetFormatVersion { .. } => false,
        _ => true,
    })
}

/// A lanelet that was cut leads on through so many pieces at most.
const MOST_PIECES: usize = 4;

/// The fixes that may have changed a route that no finding of the batch is about, in groups with the reason. Of those that need review,
/// this is so only where somebody can no longer drive on, not even through lanelets that are new or longer now.
pub fn unasked(attempt: &Attempt) -> Vec<Suspected> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut reasons: FxHashMap<usize, String> = FxHashMap::default();
    if attempt.routes.is_empty() {
        return Vec::new();
    }
    let fixes = ByPlace::of(&attempt.done);
    let gone: FxHashSet<(&str, i64)> = lost_lanelets(&attempt.routes).collect();
    let is_blocked = |Change { route, is_won }: &Change| {
        let is_gone = [route.from.0, route.to.0].iter().any(|lanelet| gone.contains(&(route.who, *lanelet)));
        !is_won && route.is_on && !is_gone && !leads_around(&attempt.routes, route)
    };
    for change in &attempt.routes {
        let Change { route, is_won } = change;
        let keys = route.keys();
        let touching: Vec<usize> = fixes.about_any(&keys);
        let one_of = |at: &usize| attempt.done.get(*at);
        let is_about = |one: &Proposal| keys.iter().all(|key| one.about.contains(key));
        let blocked = is_blocked(change);
        let is_asked = |one: &Proposal| is_about(one) || !one.fix.safe && !blocked;
        if touching.iter().filter_map(one_of).any(is_asked) {
            continue;
        }
        let may_have = |at: &usize| one_of(at).is_some_and(may_change);
        let group: Vec<usize> = touching.into_iter().filter(may_have).collect();
        for &at in &group {
            let Route { who, how, from, to, .. } = route;
            let now = if *is_won { "now" } else { "no longer" };
            let reason =
                || format!("it changes a route: for {who}, {how} from lanelet {} to {} is {now} there", from.0, to.0);
            reasons.entry(at).or_insert_with(reason);
        }
        groups.push(group);
    }
    groups.retain(|group| !group.is_empty());
    let suspected = united(groups).into_iter().map(|fixes| {
        let reason = fixes.first().and_then(|at| reasons.get(at)).cloned().unwrap_or_default();
        Suspected { fixes, reason }
    });
    suspected.collect()
}

/// Who can no longer use which lanelet at all: it was merged into another, or closed.
fn lost_lanelets(changes: &[Change]) -> impl Iterator<Item = (&'static str, i64)> {
    let lost = changes.iter().filter(|change| !change.is_won && change.route.from == change.route.to);
    lost.map(|change| (change.route.who, change.route.from.0))
}

/// Whether new steps lead to where a lost one led.
fn leads_around(changes: &[Change], lost: &Route) -> bool {
    let steps = || changes.iter().filter(|one| one.is_won && one.route.who == lost.who && one.route.is_on);
    let mut reached = vec![lost.from];
    for _ in 0..MOST_PIECES {
        let next = steps().map(|one| one.route).filter(|step| reached.contains(&step.from)).map(|step| step.to);
        reached = next.collect();
        if reached.contains(&lost.to) {
            return true;
        }
    }
    false
}
