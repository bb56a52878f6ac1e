//! Holds safe fixes to their promise: none changes who may go from where to where, unless its finding is about that.

use rustc_hash::{FxHashMap, FxHashSet};

use super::fixes_by_place::ByPlace;
use super::proposal::{Attempt, Proposal};
use super::text_edits::Key;
use crate::diagnostic::Edit;
use crate::osm::ElementKind;

/// One step of a route: somebody may go from one lanelet to another, or use a lanelet, or one lies beside another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Route {
    /// Who goes.
    pub who: &'static str,
    /// How: on, by a lane change to the left.
    pub how: &'static str,
    /// The one lanelet, and whether it is used against its direction.
    pub from: (i64, bool),
    /// The other one.
    pub to: (i64, bool),
}

impl Route {
    fn keys(&self) -> [Key; 2] {
        [self.from.0, self.to.0].map(|id| (ElementKind::Relation, id))
    }

    /// With the new ids of elements that have one.
    fn renumbered(self, fresh: &FxHashMap<Key, i64>) -> Self {
        let [from, to] = self.keys().map(|key| fresh.get(&key).copied().unwrap_or(key.1));
        Self { from: (from, self.from.1), to: (to, self.to.1), ..self }
    }
}

/// A route that was lost or won.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Change {
    pub route: Route,
    pub is_won: bool,
}

/// The routes that one list has and the other has not, sorted. `fresh` are the new ids of elements of the first.
pub fn changes(before: Vec<Route>, after: Vec<Route>, fresh: &FxHashMap<Key, i64>) -> Vec<Change> {
    let before: FxHashSet<Route> = before.into_iter().map(|route| route.renumbered(fresh)).collect();
    let after: FxHashSet<Route> = after.into_iter().collect();
    let lost = before.difference(&after).map(|&route| Change { route, is_won: false });
    let won = after.difference(&before).map(|&route| Change { route, is_won: true });
    let mut changes: Vec<Change> = lost.chain(won).collect();
    changes.sort_unstable();
    changes
}

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
