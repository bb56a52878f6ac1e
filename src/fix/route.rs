//! Steps of routes, and how two lists of them differ.

use rustc_hash::{FxHashMap, FxHashSet};

use super::text_edits::Key;
use crate::osm::ElementKind;

/// One step of a route: somebody may go from one lanelet to another, or use a lanelet, or one lies beside another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Route {
    /// Who goes.
    pub who: &'static str,
    /// How: on, by a lane change to the left.
    pub how: &'static str,
    /// Whether that is on, from the end of the one to the start of the other.
    pub is_on: bool,
    /// The one lanelet, and whether it is used against its direction.
    pub from: (i64, bool),
    /// The other one.
    pub to: (i64, bool),
}

impl Route {
    /// The lanelets.
    pub fn keys(&self) -> [Key; 2] {
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
