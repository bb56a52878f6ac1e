//! Errors that existed before and are only reported now, because an intersection was marked or a lane became a road.

use rustc_hash::FxHashSet;

use super::fixes_by_place::{ByPlace, keys};
use super::proposal::Proposal;
use super::text_edits::{Key, key_of};
use crate::diagnostic::{Diagnostic, Edit, Subject};

/// Errors that let a vehicle go where it has to wait: a fix that brings one is not kept, whatever it reveals.
const UNSAFE: [&str; 4] =
    ["vm-03-10/yield-unsafe", "vm-03-11/yield-unsafe", "vm-03-11/priority-inverted", "vm-03-11/mutual"];

/// Requirements on areas and on the tags that go with them: an error of these is about what the fix has made.
const OF_THE_FIX: [&str; 3] = ["vm-03-01/", "vm-03-02/", "vm-03-08/"];

/// Errors about a lane that ends or begins at an intersection without connection: it did so before the intersection was marked.
const LOOSE_ENDS: [&str; 2] = ["vm-03-04/in-lane-dead-end", "vm-03-04/out-lane-unreached"];

/// Requirements on road lanelets only: a lane that becomes one had the fault before.
const OF_ROADS: [&str; 2] = ["vm-01-01/", "vm-01-09/"];

/// What the fixes of a batch make part of an intersection, or a road.
pub struct Marked {
    lanelets: FxHashSet<Key>,
    roads: FxHashSet<Key>,
    /// Elements made by fixes that draw no area.
    made: FxHashSet<Key>,
    /// Fixes that may change where lanes end.
    movers: ByPlace,
}

/// The lanelets that a fix makes part of an intersection.
pub fn marked_by(one: &Proposal) -> impl Iterator<Item = Key> + '_ {
    let lanelets = one.edits().filter_map(|edit| match edit {
        Edit::CreateArea { lanelets, .. } => Some(lanelets),
        _ => None,
    });
    lanelets.flatten().filter_map(|id| key_of(Subject::Lanelet(*id)))
}

/// Whether an error is about a lane that comes to an intersection and goes no further, or begins there.
pub fn is_loose_end(error: &Diagnostic) -> bool {
    LOOSE_ENDS.contains(&error.code.as_str())
}

impl Marked {
    /// Those of a batch.
    pub fn by(done: &[Proposal]) -> Self {
        let roads = done.iter().flat_map(Proposal::edits).filter_map(|edit| match edit {
            Edit::SetTag { on: Subject::Lanelet(id), key, value } => {
                let is_road = key.as_str() == "subtype" && value.as_str() == "road";
                key_of(Subject::Lanelet(*id)).filter(|_| is_road)
            }
            _ => None,
        });
        let made = done.iter().filter(|one| !one.draws_area()).flat_map(|one| one.creates.iter().copied());
        let movers: Vec<Proposal> = done.iter().filter(|one| !one.edits().all(leaves_ends)).cloned().collect();
        Self {
            lanelets: done.iter().flat_map(marked_by).collect(),
            roads: roads.collect(),
            made: made.collect(),
            movers: ByPlace::of(&movers),
        }
    }

    /// Whether an error existed before and is only reported now, because the rule judges only roads or lanes of intersections.
    /// Such an error is about the shape of a lane, and not about the area, the tags or the elements that the fixes have made.
    pub fn reveals(&self, error: &Diagnostic) -> bool {
        let is_of = |rules: &[&str]| rules.iter().any(|rule| error.code.starts_with(rule));
        if self.lanelets.is_empty() && self.roads.is_empty() {
            return false;
        }
        if is_loose_end(error) && !self.lanelets.is_empty() && !self.movers.has_caused(error) {
            return true;
        }
        if is_of(&OF_ROADS) && key_of(error.finding.subject).is_some_and(|key| self.roads.contains(&key)) {
            return true;
        }
        let is_of_the_fix = is_of(&OF_THE_FIX)
            || UNSAFE.contains(&error.code.as_str())
            || key_of(error.finding.subject).is_some_and(|key| self.made.contains(&key));
        !is_of_the_fix && keys(error).any(|key| self.lanelets.contains(&key))
    }
}

/// Whether an edit leaves the ends of lanes as they are.
fn leaves_ends(edit: &Edit) -> bool {
    use Edit::{AddMember, CreateArea, CreateMarking, CreateRegulatoryElement, CreateStopLine, SetTag};
    let is_made = matches!(edit, CreateArea { .. } | CreateRegulatoryElement { .. });
    let is_line = matches!(edit, CreateStopLine { .. } | CreateMarking { .. });
    is_made || is_line || matches!(edit, SetTag { .. } | AddMember { .. })
}
