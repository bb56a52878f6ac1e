//! Merges the nodes and short roads of one physical intersection (A/B Street's consolidation).
//!
//! OpenStreetMap draws the crossing of two dual carriageways as four nodes, a dogleg as two, a channelised turn as several.
//! Vehicles do not stop between them, so Autoware needs one intersection. Each round decides which roads lie inside an
//! intersection (`decide`) and contracts them (`contract_edges`). A merged intersection cuts its neighbours back further, so
//! rounds follow until nothing changes.

mod contract_edges;
mod crowded_accesses;
mod dual_carriageway;
pub(crate) mod inner_routes;
mod island;
mod join_roads;
mod long_rows;
mod merge_decision;
pub(super) mod network_edit;
mod reasons;
mod renames;
#[cfg(test)]
mod tests;
mod types;
mod user_overrides;

pub use crowded_accesses::{crowded_accesses, crowds};
pub use types::{ConsolidateOptions, MergeNote, MergeReason, MergeVerdict};

use crate::builder::network::{RoadIx, RoadNetwork, Stations};
use crate::diagnostic::Finding;

pub use user_overrides::{MergeOverride, OverrideTarget};

/// Joins pieces of one road that continue each other without a change, and carriageways around an island.
#[must_use]
pub fn join_continuations(network: RoadNetwork) -> RoadNetwork {
    join_roads::join_alike(dual_carriageway::join_around_islands(join_roads::join_alike(network)))
}

/// Merges the intersections at the ends of roads that turning lanelets run over. `left` is the remaining length of a road,
/// metres. Also returns whether any were merged.
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

/// The network without these roads, and without intersections that have no other.
#[must_use]
pub fn without_roads(network: RoadNetwork, roads: &[RoadIx]) -> RoadNetwork {
    let mut edit = network_edit::NetworkEdit::new(network);
    roads.iter().for_each(|road| edit.remove(*road));
    edit.finish()
}

/// Merges intersections until nothing changes, but leaves out the short dead ends of a row that would all become one. `kept` gives
/// the stations between which each road of a network remains ([`super::outline::Outlines::kept`]). Also gives a note for each merge,
/// and a finding for each road that is left out.
pub fn consolidate(
    mut network: RoadNetwork,
    options: &ConsolidateOptions,
    mut kept: impl FnMut(&RoadNetwork) -> Vec<Stations>,
) -> (RoadNetwork, Vec<MergeNote>, Vec<Finding>) {
    let mut notes: Vec<MergeNote> = Vec::new();
    let mut left_out: Vec<Finding> = Vec::new();
    for _ in 0..options.rounds {
        let kept = kept(&network);
        let verdicts = merge_decision::decide(&network, &kept, options);
        let short = verdicts.iter().filter(|verdict| verdict.merge && verdict.reason == MergeReason::Short);
        let crowding = crowded_accesses(&network, &short.map(|verdict| verdict.road).collect::<Vec<_>>());
        if !crowding.is_empty() {
            left_out.extend(crowding.iter().map(|road| crowds(network.road(*road))));
            network = join_continuations(without_roads(network, &crowding));
            continue;
        }
        let (next, merged, round) = contract_edges::contract(network, &verdicts, options);
        network = next;
        let changed = round.iter().any(|note| note.merged);
        // A road kept by the user may be gone because other roads merged its ends: its note stays.
        let gone = |note: &MergeNote| !round.iter().any(|later| later.key == note.key);
        notes.retain(|note| note.merged || (note.wish.is_some() && gone(note)));
        notes.extend(round);
        if !(merged && changed) {
            break;
        }
    }
    notes.sort_by_key(|note| note.key);
    (network, notes, left_out)
}
