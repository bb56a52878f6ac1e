//! One physical intersection, drawn as several nodes and short roads, becomes one.
//!
//! OpenStreetMap draws the crossing of two dual carriageways as four nodes, a dogleg as two, a channelised turn as a
//! handful. Vehicles do not stop between them, so Autoware wants one intersection. A round decides for every road
//! whether it lies inside an intersection (`decide`), contracts what it found (`contract`), and looks again, for
//! a merged intersection cuts its neighbours back further; the rounds end when nothing changes.

mod contract_edges;
mod decide;
mod dual_carriageway;
mod island;
mod join_roads;
mod network_edit;
pub(crate) mod passages;
mod reasons;
#[cfg(test)]
mod tests;
mod types;
mod user_overrides;

pub use types::{ConsolidateOptions, MergeNote, MergeReason, MergeVerdict};

use crate::builder::network::{RoadIx, RoadNetwork};

pub use user_overrides::{MergeOverride, OverrideTarget};

/// Joins what is one road: pieces that continue each other without any change, and carriageways around an island.
#[must_use]
pub fn join_continuations(network: RoadNetwork) -> RoadNetwork {
    join_roads::join_alike(dual_carriageway::join_around_islands(join_roads::join_alike(network)))
}

/// Takes roads into the intersections at their ends, whose lanes run over them. `left` says how much remains of each,
/// metres. Gives whether any may be taken in, too.
pub fn absorb_roads(
    network: RoadNetwork,
    roads: &[RoadIx],
    left: impl Fn(RoadIx) -> f64,
    options: &ConsolidateOptions,
) -> (RoadNetwork, bool, Vec<MergeNote>) {
    let verdict =
        |&road| MergeVerdict { road, merge: true, reason: MergeReason::Overrun, left: left(road), wish: None };
    let verdicts: Vec<MergeVerdict> = roads.iter().map(verdict).collect();
    contract_edges::contract(network, &verdicts, options)
}

/// Takes roads away, and the intersections that no road is left of.
#[must_use]
pub fn without_roads(network: RoadNetwork, roads: &[RoadIx]) -> RoadNetwork {
    let mut edit = network_edit::NetworkEdit::new(network);
    roads.iter().for_each(|road| edit.remove(*road));
    edit.finish()
}

/// Merges until nothing changes. `kept` gives, for a network, the stations between which each road remains after the
/// intersections' outlines are cut off ([`super::outline::Outlines::kept`]).
pub fn consolidate(
    mut network: RoadNetwork,
    options: &ConsolidateOptions,
    mut kept: impl FnMut(&RoadNetwork) -> Vec<[f64; 2]>,
) -> (RoadNetwork, Vec<MergeNote>) {
    let mut notes: Vec<MergeNote> = Vec::new();
    for _ in 0..options.rounds {
        let kept = kept(&network);
        let verdicts = decide::decide(&network, &kept, options);
        let (next, merged, round) = contract_edges::contract(network, &verdicts, options);
        network = next;
        let changed = round.iter().any(|note| note.merged);
        // A road that the user keeps apart is gone where other roads merge its ends: that is told.
        let gone = |note: &MergeNote| !round.iter().any(|later| later.key == note.key);
        notes.retain(|note| note.merged || (note.wish.is_some() && gone(note)));
        notes.extend(round);
        if !(merged && changed) {
            break;
        }
    }
    notes.sort_by_key(|note| note.key);
    (network, notes)
}
