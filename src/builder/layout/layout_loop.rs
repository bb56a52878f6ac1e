//! Which roads are left when every lane ends on the outline of its intersection.
//!
//! How much of a road the lanes at its ends take shows only when they are drawn. Where a way through an intersection
//! runs over the end of a road that is too short to be cut back behind it, no vehicle can wait on that road: it lies
//! inside, and the intersections at its ends are one. So it is where a road is too short to be cut back for a turn that
//! a car can take. A dead end of that kind is no road at all. When all are found, the roads are laid at heights that suit the
//! cuts.

use rustc_hash::FxHashSet;

use crate::builder::lanes::road_cut::VEHICLE;
use crate::builder::network::network_diff::{NetworkDiff, NetworkSnapshot};
use crate::builder::network::turn_restrictions::ResolvedRestrictions;
use crate::builder::network::{Road, RoadEnd, RoadIx, RoadKey, RoadNetwork, Stations};
use crate::builder::streets::consolidate::{ConsolidateOptions, MergeNote, absorb_roads, without_roads};
use crate::builder::streets::heights::{HeightOptions, level_at_cuts};
use crate::diagnostic::{Finding, Severity, Subject};

use super::map_layout::MapLayout;
use super::short_links::short_links;

/// Each round takes in the roads that the round before laid bare.
const ROUNDS: usize = 8;

/// A network, and what is drawn of it.
pub struct Layout {
    /// Without the roads that lie inside intersections.
    pub network: RoadNetwork,
    /// Its turn restrictions.
    pub restricted: ResolvedRestrictions,
    /// Its lanes and the ways through its intersections.
    pub draft: MapLayout,
    /// What could not be expressed, and which roads were taken in.
    pub notes: Vec<Finding>,
}

/// Draws a network and takes roads into intersections until no way runs over the end of a road. `kept` are the stations
/// between which the outlines leave each road; the roads in `apart` are never taken in. Last the heights are held once more.
pub fn lay_out(
    mut network: RoadNetwork,
    mut kept: Vec<Stations>,
    apart: &FxHashSet<RoadKey>,
    heights: &HeightOptions,
) -> Layout {
    let mut taken: Vec<Finding> = Vec::new();
    let mut refused = apart.clone();
    let mut round = 0;
    let (mut restricted, mut notes) = ResolvedRestrictions::new(&network);
    let mut draft = MapLayout::new(&network, &kept, &restricted);
    loop {
        let inside = if round < ROUNDS { inside(&network, &draft, &refused) } else { Vec::new() };
        let mut before = (!inside.is_empty()).then(|| NetworkSnapshot::of(&network));
        let (next, changed, merges) =
            absorb_roads(network, &inside, |road| draft.left(road), &ConsolidateOptions::default());
        network = next;
        before = before.filter(|_| changed);
        refused.extend(merges.iter().filter(|note| !note.merged).map(|note| note.key));
        taken.extend(merges.iter().filter(|note| note.merged).map(note));
        if before.is_none() && round < ROUNDS {
            let stubs = stubs(&network, &draft, apart);
            taken.extend(stubs.iter().map(|stub| left_out(network.road(*stub))));
            if !stubs.is_empty() {
                before = Some(NetworkSnapshot::of(&network));
                network = without_roads(network, &stubs);
            }
        }
        let Some(before) = before else {
            notes.append(&mut taken);
            let draft = draft.with_stops(&network, &restricted);
            let relaid = level_at_cuts(&mut network, &draft.lines.kept, heights);
            let draft = draft.relaid(&network, &restricted, &relaid);
            return Layout { network, restricted, draft, notes };
        };
        let origins = NetworkDiff::between(&before, &network);
        kept = (0..network.roads.len()).map(|road| kept[origins.of(RoadIx::new(road)).0 as usize]).collect();
        let (ruled, more) = ResolvedRestrictions::new(&network);
        draft = draft.renewed(&origins, (&before, &restricted), &network, &kept, &ruled);
        (restricted, notes) = (ruled, more);
        round += 1;
    }
}

/// The roads that have no room behind the ways over their ends, or none for the turns there; in order.
fn inside(network: &RoadNetwork, draft: &MapLayout, refused: &FxHashSet<RoadKey>) -> Vec<RoadIx> {
    let no_room = |road: &RoadIx| {
        let Some(one) = network.roads.get(road.position()) else { return false };
        draft.left(*road) < VEHICLE && one.from != one.to && !refused.contains(&one.key)
    };
    let leads_on = |road: &RoadIx| !ends_here(network, network.road(*road));
    let cramped = short_links(draft, network).into_iter().filter(leads_on);
    let mut roads: Vec<RoadIx> = draft.overrun(network).map(|at| at.road).chain(cramped).filter(no_room).collect();
    roads.sort_unstable();
    roads.dedup();
    roads
}

/// Whether nothing goes on at one end of a road.
fn ends_here(network: &RoadNetwork, road: &Road) -> bool {
    [road.from, road.to].iter().any(|&at| network.intersection(at).arms.len() < 2)
}

/// Dead ends too short for a turn into them that a car can take, where two longer roads meet without them: where all are
/// short they are what there is.
fn stubs(network: &RoadNetwork, draft: &MapLayout, apart: &FxHashSet<RoadKey>) -> Vec<RoadIx> {
    let stub = |road: &RoadIx| {
        let one = network.road(*road);
        let length = one.line.length();
        let longer = |arm: &&RoadEnd| network.road(arm.road).line.length() > length;
        let through = |at| network.intersection(at).arms.iter().filter(longer).count() > 1;
        ends_here(network, one) && [one.from, one.to].into_iter().any(through) && !apart.contains(&one.key)
    };
    short_links(draft, network).into_iter().filter(stub).collect()
}

fn left_out(road: &Road) -> Finding {
    let RoadKey { way, first, last, .. } = road.key;
    let message = format!(
        "way {way} is not built between nodes {first} and {last}: too little is left of this dead end for a car to turn into it"
    );
    Finding::new("way-skipped", Subject::Way(way), message).graded(Severity::Info)
}

fn note(MergeNote { key, left, .. }: &MergeNote) -> Finding {
    let message = format!(
        "Of way {} between nodes {} and {} there are {left:.1} m left, too few for the ways at its ends: it lies inside an intersection.",
        key.way, key.first, key.last
    );
    Finding::new("road-inside", Subject::Way(key.way), message).graded(Severity::Info)
}
