//! Crossings of roads: each of them once, and on the lanes between the cuts.

use rustc_hash::FxHashSet;

use crate::builder::lanes::road_cut::{CROSSWALK_BREADTH, RoadCrossing, RoadCut, STOP_GAP, has_lights};
use crate::builder::network::{End, Road, RoadNetwork, Stations};
use crate::builder::tags::cross_section::Travel;

/// The crossings of all roads. One between intersections can lie on the node where two roads meet: one of them has it, rather that on
/// which vehicles arrive, so that they stop before the place where lanes begin or end.
pub(super) fn crossings_once(network: &RoadNetwork, cuts: &[RoadCut]) -> Vec<RoadCrossing> {
    let all = || cuts.iter().flat_map(|cut| &cut.crossings);
    let leads_there = |crossing: &RoadCrossing| {
        let road = network.road(crossing.road);
        let last = End::BOTH.into_iter().find(|end| road.one_way() == Some(end.inbound()));
        crossing.arm.is_none() && last.is_some_and(|end| road.node(end) == crossing.node)
    };
    let before: FxHashSet<i64> = all().filter(|it| leads_there(it)).map(|it| it.node).collect();
    let mut placed: FxHashSet<i64> = FxHashSet::default();
    let once = |crossing: &&RoadCrossing| {
        let is_elsewhere = before.contains(&crossing.node) && !leads_there(crossing);
        crossing.arm.is_some() || !is_elsewhere && placed.insert(crossing.node)
    };
    let mut found: Vec<RoadCrossing> = all().filter(once).cloned().collect();
    found.dedup_by(|later, earlier| {
        later.road == earlier.road && lie_on_each_other(network.road(later.road), later, earlier)
    });
    found
}

/// From lights for one direction of travel, where vehicles stop, to the middle of the place that they keep clear, metres along the
/// road's line.
pub(super) fn behind_stop_line(travel: Travel) -> f64 {
    let behind = CROSSWALK_BREADTH / 2.0 + STOP_GAP;
    match travel {
        Travel::Forward => behind,
        Travel::Backward => -behind,
        Travel::Both => 0.0,
    }
}

/// Whether two crosswalks of a road lie on each other, as where both were moved from a short piece of it. `earlier` becomes the one to
/// keep: that of an intersection, or else one with lights.
fn lie_on_each_other(road: &Road, later: &mut RoadCrossing, earlier: &mut RoadCrossing) -> bool {
    let apart = later.station - earlier.station >= CROSSWALK_BREADTH;
    if apart || [&*later, &*earlier].iter().any(|crossing| crossing.lights_only.is_some()) {
        return false;
    }
    let rank = |crossing: &RoadCrossing| (crossing.arm.is_some(), has_lights(road, crossing));
    if rank(later) > rank(earlier) {
        std::mem::swap(later, earlier);
    }
    true
}

/// Moves a crossing between intersections onto the lanes between the cuts, with its stop lines where it has lights; `false` if
/// they are too short.
pub(super) fn move_between(road: &Road, crossing: &mut RoadCrossing, [start, end]: Stations) -> bool {
    let half = CROSSWALK_BREADTH / 2.0;
    let stopping = half + STOP_GAP;
    let need = if has_lights(road, crossing) && end - start > 2.0 * stopping { stopping } else { half };
    let fits = end - start > 2.0 * need;
    if fits {
        crossing.station = crossing.station.clamp(start + need, end - need);
    }
    fits
}
