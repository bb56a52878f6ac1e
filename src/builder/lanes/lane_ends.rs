//! Connection lines: where the lanes of a road end and those of an intersection begin.
//!
//! The outline says how far a road must be cut back at least. Here it is cut back further, along its own line, so that
//! the crosswalk lies inside the intersection with the stop line before it, and so that a car can take the near turn.

mod dead_end;
mod mapped_stop_line;
mod required_setback;
mod setback;
#[cfg(test)]
mod tests;

use crate::builder::network::road_end::{at_depth, from_cut, inward};
use crate::builder::network::{End, FeatureKind, Road, RoadIx, RoadNetwork, Stations};
use crate::builder::tags::cross_section::SIDEWALK;
use crate::geometry::angle_between;
use crate::parallel::Finely;

use super::gore::level_cuts;
use super::road_cut::{
    CROSSWALK_BREADTH, ConnectionLines, ROAD_LEFT, RoadCrossing, RoadCut, STOP_GAP, STOP_GAP_LEAST, STOP_GAP_MOST,
    SetbackDemand, VEHICLE, has_lights,
};
use mapped_stop_line::{bend, drawn_back, mapped};
use setback::eased;

use rayon::prelude::*;
use rustc_hash::FxHashSet;

pub use required_setback::RequiredSetbacks;

/// From the corner of the crossing road to the crosswalk, metres.
const CORNER_GAP: f64 = 0.5;
/// A crossing belongs to the intersection if it lies at most this far, metres, up the road from the outline.
const CROSSING_REACH: f64 = 12.0;
/// A crossing with lights whose middle lies no farther, metres, from where the road is cut leaves a vehicle no room to wait.
const HELD_BEFORE: f64 = CROSSWALK_BREADTH / 2.0 + STOP_GAP + VEHICLE;
/// No cut moves before a sidewalk that lies around a bend of more than this, degrees: ways would begin as if they came from
/// elsewhere.
const SIDEWALK_BEND: f64 = 45.0;

/// Cuts every road for crosswalks, stop lines and turns. `back` says how far each end is cut back at least, metres behind
/// its outline, `stops` whether it is cut where the map says that vehicles stop. `known` gives for roads at whose ends nothing
/// else has changed how they were cut before.
pub fn connection_lines<'a>(
    network: &RoadNetwork,
    needs: &RequiredSetbacks,
    back: &[[f64; 2]],
    stops: &[[bool; 2]],
    known: impl Fn(RoadIx) -> Option<&'a RoadCut> + Sync,
) -> ConnectionLines {
    let least = &needs.least;
    let mut setbacks = back.to_vec();
    let mut wishes = vec![[0.0_f64; 2]; back.len()];
    needs.raise(&mut setbacks, &mut wishes);
    let cut = |i: usize, setbacks: [f64; 2]| {
        let (ix, asked) =
            (RoadIx::new(i), SetbackDemand { least: least[i], setbacks, wishes: wishes[i], stops: stops[i] });
        known(ix).filter(|known| known.asked == asked).map_or_else(|| cut(network, ix, asked), |known| known.of(ix))
    };
    let mut cuts: Vec<RoadCut> =
        setbacks.par_iter().finely().enumerate().map(|(i, setbacks)| cut(i, *setbacks)).collect();
    // Where a road is too short to be cut back, its neighbour gives.
    for give in [None, None, Some(back)] {
        for road in level_cuts(network, least, &cuts, &mut setbacks, give) {
            cuts[road] = cut(road, setbacks[road]);
        }
    }
    let mut placed: FxHashSet<i64> = FxHashSet::default();
    // What lies between intersections crosses the lanes once where the way is cut in two.
    let once = |crossing: &&RoadCrossing| crossing.arm.is_some() || placed.insert(crossing.node);
    ConnectionLines {
        kept: cuts.iter().map(|cut| cut.kept).collect(),
        inward: cuts.iter().map(|cut| cut.inward).collect(),
        least: least.clone(),
        crossings: cuts.iter().flat_map(|cut| &cut.crossings).filter(once).cloned().collect(),
        cuts,
    }
}

/// Cuts a road at its setbacks, and farther out where people cross.
fn cut(network: &RoadNetwork, ix: RoadIx, asked: SetbackDemand) -> RoadCut {
    let SetbackDemand { least, mut setbacks, wishes, stops: stopped } = asked;
    let road = network.road(ix);
    let at = |end| network.intersection(road.intersection(end));
    let continued = |end| at(end).arms.len() == 2;
    // Lights hold vehicles before the crosswalk, too, where a road only goes on.
    let room = |end| (at(end).arms.len() >= 3 || continued(end) && at(end).signals) && !road.roundabout;
    let mut stops = mapped(road, least, |end| room(end) && stopped[end]);
    let drawn = |setbacks: [f64; 2], stops: [Option<f64>; 2]| {
        let (back, mapped) = drawn_back(least, setbacks, stops);
        let kept = apply(least, back, road.line.length());
        let more = |end: usize| if mapped[end] { 0.0 } else { (wishes[end] - back[end]).max(0.0) };
        (untwisted(road, eased(road, kept, [0, 1].map(more))), mapped)
    };
    let begun = || drawn(setbacks, [None; 2]).0;
    let reach = |end: End| stops[end].unwrap_or_default().max(CROSSING_REACH);
    let belongs = |end, station, lights| match lights && !at(end).signals {
        // What holds nobody before the intersection is a crossing of its own, if a vehicle can wait behind.
        true => from_cut(begun(), end, station) <= HELD_BEFORE,
        false => from_cut(least, end, station) <= reach(end),
    };
    let mut crossings = crossings_of(road, ix, least, [&room, &continued], belongs);
    for crossing in &crossings {
        let Some(end) = crossing.arm else { continue };
        let behind = from_cut(least, end, crossing.station) + CROSSWALK_BREADTH / 2.0;
        let stop = &mut stops[end];
        *stop = stop.filter(|stop| *stop > behind).map(|stop| stop.max(behind + STOP_GAP_LEAST));
        let back = &mut setbacks[end];
        *back = back.max(stop.unwrap_or(f64::INFINITY).min(behind + STOP_GAP));
    }
    for end in End::BOTH.into_iter().filter(|&end| room(end) && leads_out(network, road, end)) {
        if crossings.iter().all(|crossing| crossing.arm != Some(end)) {
            let needed = before_sidewalk(road, end, least, setbacks[end.other().index()]);
            let back = &mut setbacks[end];
            *back = back.max(needed.unwrap_or_default());
        }
    }
    let (kept, mapped) = drawn(setbacks, stops);
    for crossing in &mut crossings {
        let Some(end) = crossing.arm else { continue };
        // Where the road is too short the crosswalk moves toward the middle of the intersection with the cut; where it
        // is cut far back, up the road.
        let middle = from_cut(least, end, kept[end]) - CROSSWALK_BREADTH / 2.0;
        let depth = from_cut(least, end, crossing.station);
        let far = if mapped[end] { depth } else { depth.max(middle - STOP_GAP_MOST) };
        let held = far.min(middle - STOP_GAP_LEAST);
        crossing.station = at_depth(least, end, held);
    }
    // What lies between intersections crosses the road's own lanes.
    crossings.retain_mut(|crossing| crossing.arm.is_some() || between(road, crossing, kept));
    RoadCut { asked, kept, inward: End::BOTH.map(|end| inward(road, end, kept[end])), crossings }
}

/// How far behind the outline, metres, who leaves private ground stops before a sidewalk that is mapped as a way of its
/// own; `None` without one near the end, and where the road has no room behind it or bends too much before it.
fn before_sidewalk(road: &Road, end: End, least: Stations, other: f64) -> Option<f64> {
    let behind = from_cut(least, end, sidewalk(road, end)?) + SIDEWALK / 2.0;
    let needed = behind + STOP_GAP;
    let left = least[1] - least[0] - other - needed;
    let fits = behind <= CROSSING_REACH && left >= ROAD_LEFT && bend(road, least, end, needed) <= SIDEWALK_BEND;
    fits.then_some(needed)
}

/// Whether a road on private ground leads out of it at this end.
fn leads_out(network: &RoadNetwork, road: &Road, end: End) -> bool {
    let arms = &network.intersection(road.intersection(end)).arms;
    !road.public && arms.iter().any(|arm| network.road(arm.road).public)
}

/// Where a sidewalk that is mapped as a way of its own first leads across a road before its end: its station.
pub fn sidewalk(road: &Road, end: End) -> Option<f64> {
    let length = road.line.length();
    let depth = |station: f64| from_cut([0.0, length], end, station);
    let across = road.features.iter().filter(|feature| feature.kind == FeatureKind::Sidewalk);
    let own = across.map(|feature| feature.station).filter(|station| depth(*station) <= length / 2.0);
    own.min_by(|a, b| depth(*a).total_cmp(&depth(*b)))
}

/// Moves both cuts up the road; where it is too short for both, each gives in proportion.
fn apply([start, end]: [f64; 2], [a, b]: [f64; 2], length: f64) -> [f64; 2] {
    let room = (end - start - ROAD_LEFT.min(length / 2.0)).max(0.0);
    let share = if a + b > room { room / (a + b) } else { 1.0 };
    [start + a * share, end - b * share]
}

/// Where little remains of a road around a sharp bend, its two cuts would cross: then a part without a bend remains.
fn untwisted(road: &Road, [start, end]: [f64; 2]) -> [f64; 2] {
    /// Change of direction, degrees, that is safe between cuts as close as the road is wide.
    const BEND_MOST: f64 = 40.0;
    let directions = [road.line.direction(start), road.line.direction((end - 1e-3).max(0.0))];
    let bend = angle_between(directions[0], directions[1]).abs();
    if end - start > 2.0 * road.half_width() || bend <= BEND_MOST.to_radians() {
        return [start, end];
    }
    let stations = road.line.stations();
    let parts = stations.windows(2).map(|w| [w[0].max(start), w[1].min(end)]);
    parts.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0]))).filter(|p| p[1] > p[0]).unwrap_or([start, end])
}

/// The crossings of a road; those that belong to an intersection at its ends, at most one per arm.
fn crossings_of(
    road: &Road,
    ix: RoadIx,
    cut: [f64; 2],
    [room, continued]: [&dyn Fn(End) -> bool; 2],
    belongs: impl Fn(End, f64, bool) -> bool,
) -> Vec<RoadCrossing> {
    let half = CROSSWALK_BREADTH / 2.0;
    let mut found: Vec<RoadCrossing> = Vec::new();
    for feature in &road.features {
        let FeatureKind::Crossing { signals: lights, .. } = feature.kind else { continue };
        let near = End::BOTH
            .into_iter()
            .min_by(|&a, &b| from_cut(cut, a, feature.station).total_cmp(&from_cut(cut, b, feature.station)));
        let arm = near.filter(|&end| room(end) && belongs(end, feature.station, lights));
        let station = match arm {
            Some(end) => at_depth(cut, end, from_cut(cut, end, feature.station).max(half + CORNER_GAP)),
            None => feature.station,
        };
        let free = arm.is_none_or(|end| !found.iter().any(|c| c.arm == Some(end)));
        let inside = station > cut[0] + half && station < cut[1] - half;
        let inside = inside || arm.is_some() || near.is_some_and(&continued);
        if free && inside {
            found.push(RoadCrossing { node: feature.node, road: ix, station, arm });
        }
    }
    found
}

/// Moves a crossing so that it lies on the lanes between two cuts, with its stop lines where it has lights; `false` if they
/// are too short.
fn between(road: &Road, crossing: &mut RoadCrossing, [start, end]: [f64; 2]) -> bool {
    let half = CROSSWALK_BREADTH / 2.0;
    let stopping = half + STOP_GAP;
    let need = if has_lights(road, crossing) && end - start > 2.0 * stopping { stopping } else { half };
    let room = end - start > 2.0 * need;
    if room {
        crossing.station = crossing.station.clamp(start + need, end - need);
    }
    room
}
