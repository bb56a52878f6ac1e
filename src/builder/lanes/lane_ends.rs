//! Connection lines: where the lanes of a road end before an intersection, so that its stop line lies there, and where those of the
//! intersection begin.
//!
//! The outline gives the least setback of a road. Crosswalks, stop lines and turns add to it: the crosswalk lies inside the
//! intersection with the stop line before it, and a car can take the near turn.

mod crossings;
mod mapped_stop_line;
mod required_setback;
#[cfg(test)]
mod tests;
mod turn_setback;

use crate::builder::network::road_end::{at_depth, from_cut, inward, outward};
use crate::builder::network::signal_assignment::arrives;
use crate::builder::network::{End, FeatureKind, Intersection, Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::builder::tags::cross_section::SIDEWALK;
use crate::geometry::{angle_between, cross};
use crate::lanelet::index::HEADING_REACH;
use crate::parallel::InSmallParts;

use super::gore::level_cuts;
use super::road_cut::{
    CROSSWALK_BREADTH, ConnectionLines, ROAD_LEFT, RoadCrossing, RoadCut, STOP_GAP, STOP_GAP_LEAST, STOP_GAP_MOST,
    SetbackDemand, SqueezedRoads, VEHICLE, least_left,
};
use crossings::{behind_stop_line, crossings_once, move_between};
use mapped_stop_line::{bend, mapped_stop_lines, move_to_stop_lines};
use turn_setback::add_comfort;

use rayon::prelude::*;
use std::ops::RangeInclusive;

pub use required_setback::RequiredSetbacks;

/// From the corner of the crossing road to the crosswalk, metres.
const CORNER_GAP: f64 = 0.5;
/// From the edge of the crossing road to the crosswalk, metres, where the corner is rounded farther than that.
const LANE_GAP: f64 = 2.5;
/// Speed limits, km/h, up to which and from which on stop lines lie nearer to crosswalks and farther from them.
const SLOW: f64 = 30.0;
const FAST: f64 = 60.0;
/// From the stop line to the crosswalk on fast roads, metres.
const STOP_GAP_FAST: f64 = 3.5;
/// Roads cross where the sine of the angle between them is larger than this: 30 degrees.
const CROSSES: f64 = 0.5;
/// Distance from the intersection at which the direction of a road is taken, metres.
const LOOK: f64 = 10.0;
/// A crossing belongs to the intersection up to this distance, metres, from the outline.
const CROSSING_REACH: f64 = 12.0;
/// The same where lights hold those who arrive, if nobody crosses nearer: they wait before the crosswalk, not behind it.
const LIT_CROSSING_REACH: f64 = 18.0;
/// Between a cut and the middle of a crosswalk with lights that is no farther than this, metres, no vehicle can wait.
const NO_ROOM_TO_WAIT: f64 = CROSSWALK_BREADTH / 2.0 + STOP_GAP + VEHICLE;
/// No cut moves before a sidewalk around a bend of more than this, degrees: lanelets would begin in a wrong direction.
const SIDEWALK_BEND: f64 = 45.0;

/// Cuts every road for crosswalks, stop lines and turns. `least_setbacks` are per road, metres behind its outline; `stops` says
/// at which ends it is cut where a stop line is mapped; `squeezed` as in [`least_left`]. `known` gives earlier cuts of roads at
/// whose ends nothing else has changed.
pub fn connection_lines<'a>(
    network: &RoadNetwork,
    required: &RequiredSetbacks,
    least_setbacks: &[[f64; 2]],
    (stops, squeezed): (&[[bool; 2]], &SqueezedRoads),
    known: impl Fn(RoadIx) -> Option<&'a RoadCut> + Sync,
) -> ConnectionLines {
    let least = &required.least;
    let mut setbacks = least_setbacks.to_vec();
    let mut comfort = vec![[0.0_f64; 2]; setbacks.len()];
    let mut weaving = vec![[0.0_f64; 2]; setbacks.len()];
    required.raise(&mut setbacks, &mut weaving, &mut comfort);
    let cut = |i: usize, setbacks: [f64; 2]| {
        let ix = RoadIx::new(i);
        let (firm, comfort, joined) = (least_setbacks[i], comfort[i], required.joined[i]);
        let (left, weaving) = (least_left(network, squeezed, network.road(ix)), weaving[i]);
        let demand = SetbackDemand { left, least: least[i], setbacks, firm, weaving, comfort, stops: stops[i], joined };
        let known = known(ix).filter(|known| known.demand == demand);
        known.map_or_else(|| cut_road(network, ix, demand), |known| known.of(ix))
    };
    let mut cuts: Vec<RoadCut> =
        setbacks.par_iter().in_small_parts().enumerate().map(|(i, setbacks)| cut(i, *setbacks)).collect();
    // Where a road is too short to be cut back, its neighbour is cut back less.
    for lower_to in [None, None, Some(least_setbacks)] {
        for road in level_cuts(network, least, &cuts, &mut setbacks, lower_to) {
            cuts[road] = cut(road, setbacks[road]);
        }
    }
    ConnectionLines {
        kept: cuts.iter().map(|cut| cut.kept).collect(),
        inward: cuts.iter().map(|cut| cut.inward).collect(),
        least: least.clone(),
        crossings: crossings_once(network, &cuts),
        cuts,
    }
}

/// Cuts a road at its setbacks, and farther out where people cross.
fn cut_road(network: &RoadNetwork, ix: RoadIx, demand: SetbackDemand) -> RoadCut {
    let mut plan = CutPlan::new(network, ix, demand);
    let mut crossings = plan.crossings();
    crossings.iter().for_each(|crossing| plan.make_room_for_crosswalk(crossing));
    plan.make_room_for_sidewalks(&crossings);
    let (kept, at_stop_line) = plan.stations(plan.stop_lines);
    crossings.iter_mut().for_each(|crossing| plan.move_to_cut(crossing, kept, at_stop_line));
    // A crossing between intersections lies on the road's own lanes.
    crossings.retain_mut(|crossing| crossing.arm.is_some() || move_between(plan.road, crossing, kept));
    crossings.sort_by(|a, b| a.station.total_cmp(&b.station));
    let straight = End::BOTH.map(|end| {
        let crossed = crossings.iter().any(|crossing| crossing.arm == Some(end));
        let without = demand.setbacks[end].max(demand.comfort[end]);
        if crossed { (from_cut(demand.least, end, kept[end]) - without).max(0.0) } else { 0.0 }
    });
    RoadCut { demand, kept, inward: End::BOTH.map(|end| inward(plan.road, end, kept[end])), straight, crossings }
}

/// The setbacks of a road while they are raised. Depths are metres up the road from the outline's cut.
struct CutPlan<'a> {
    network: &'a RoadNetwork,
    road: &'a Road,
    ix: RoadIx,
    /// Where the outline cuts the road.
    least: Stations,
    setbacks: [f64; 2],
    /// The part of each setback that has another reason than the room of turns.
    firm: [f64; 2],
    comfort: [f64; 2],
    /// The part of each setback without which lanelets would weave.
    weaving: [f64; 2],
    /// How much of the road setbacks leave: the needed ones, and those that only make turns easier; crosswalks leave less.
    left: [f64; 2],
    /// The part of each setback that makes room for a crosswalk or a sidewalk.
    crossed: [f64; 2],
    /// Where it meets another road face to face.
    joined: [bool; 2],
    /// Depths of the mapped stop lines.
    stop_lines: [Option<f64>; 2],
}

impl<'a> CutPlan<'a> {
    fn new(network: &'a RoadNetwork, ix: RoadIx, demand: SetbackDemand) -> Self {
        let SetbackDemand { left, least, setbacks, firm, weaving, comfort, stops, joined } = demand;
        // A third road that is left out may have asked for more.
        let [setbacks, firm, weaving, comfort] =
            [setbacks, firm, weaving, comfort].map(|by| End::BOTH.map(|end| if joined[end] { 0.0 } else { by[end] }));
        let (road, stop_lines, crossed) = (network.road(ix), [None; 2], [0.0; 2]);
        let mut plan =
            Self { network, road, ix, least, setbacks, firm, weaving, comfort, left, crossed, joined, stop_lines };
        plan.stop_lines = mapped_stop_lines(plan.road, least, |end| stops[end] && plan.is_approach(end));
        plan
    }

    fn intersection(&self, end: End) -> &'a Intersection {
        self.network.intersection(self.road.intersection(end))
    }

    fn continues(&self, end: End) -> bool {
        self.intersection(end).arms.len() == 2
    }

    /// Whether vehicles may have to stop at this end: other roads meet it there, or lights hold vehicles before a crosswalk.
    fn is_approach(&self, end: End) -> bool {
        let intersection = self.intersection(end);
        (intersection.arms.len() >= 3 || self.continues(end) && intersection.signals) && !self.road.roundabout
    }

    /// Where the road is cut with these stop lines, and at which ends it is cut at one.
    fn stations(&self, stop_lines: [Option<f64>; 2]) -> (Stations, [bool; 2]) {
        let (setbacks, moved) = move_to_stop_lines(self.least, self.setbacks, stop_lines);
        let beyond_crosswalks = self.least[1] - self.least[0] - self.crossed.iter().sum::<f64>();
        let [left, easy_left] = self.left.map(|left| beyond_crosswalks.clamp(ROAD_LEFT, left));
        let firm = [0, 1].map(|end| if moved[end] { setbacks[end] } else { self.firm[end].min(setbacks[end]) });
        let length = self.road.line.length();
        // What lanelets need comes before the room of a waiting vehicle, what makes turns easier behind it.
        let needed = if left < easy_left {
            [0, 1].map(|end| firm[end].max(self.weaving[end]).min(setbacks[end]))
        } else {
            setbacks
        };
        let kept = cut_back(self.least, needed, (length, left));
        let kept = cut_back(kept, [0, 1].map(|end| setbacks[end] - needed[end]), (length, easy_left));
        let more = [0, 1].map(|end| if moved[end] { 0.0 } else { (self.comfort[end] - setbacks[end]).max(0.0) });
        let cut = straighten(self.road, add_comfort(self.road, kept, more));
        let clear = clear_of_bends(self.road, (self.least, firm, left), cut);
        (End::BOTH.map(|end| if self.joined[end] { cut[end] } else { clear[end] }), moved)
    }

    /// Whether a crossing at a station belongs to the intersection at an end. One with lights before an intersection without
    /// is a crossing of its own if a vehicle can wait between.
    fn belongs(&self, end: End, station: f64, lights: bool) -> bool {
        if lights && !self.intersection(end).signals {
            return from_cut(self.stations([None; 2]).0, end, station) <= NO_ROOM_TO_WAIT;
        }
        let reach = if self.is_first_before_lights(end, station) { LIT_CROSSING_REACH } else { CROSSING_REACH };
        from_cut(self.least, end, station) <= self.stop_lines[end].unwrap_or_default().max(reach)
    }

    /// Whether lights hold those who arrive at an end, and nobody crosses between it and a station.
    fn is_first_before_lights(&self, end: End, station: f64) -> bool {
        let depth = |station: f64| from_cut(self.least, end, station);
        let nearer = self.road.features.iter().filter(|feature| depth(feature.station) < depth(station));
        let mut nearer = nearer.filter(|feature| matches!(feature.kind, FeatureKind::Crossing { .. }));
        self.intersection(end).signals && arrives(self.road, end) && nearer.next().is_none()
    }

    /// The crossings of the road, and the lights between intersections; at most one crossing belongs to each arm.
    fn crossings(&self) -> Vec<RoadCrossing> {
        let (half, cut) = (CROSSWALK_BREADTH / 2.0, self.least);
        let mut found: Vec<RoadCrossing> = Vec::new();
        for feature in &self.road.features {
            let (lights, lights_only) = match feature.kind {
                FeatureKind::Crossing { signals, .. } => (signals, None),
                FeatureKind::MidBlockSignals(travel) => (true, Some(travel)),
                _ => continue,
            };
            let depth = |end: End| from_cut(cut, end, feature.station);
            let near = if depth(End::End) < depth(End::Start) { End::End } else { End::Start };
            let belongs =
                lights_only.is_none() && self.is_approach(near) && self.belongs(near, feature.station, lights);
            let arm = belongs.then_some(near);
            let between = feature.station + lights_only.map_or(0.0, behind_stop_line);
            let station = arm.map_or(between, |end| {
                let least = (half + CORNER_GAP).min(self.edge_of_crossing_road(end) + half + LANE_GAP);
                at_depth(cut, end, from_cut(cut, end, feature.station).max(least))
            });
            let free = arm.is_none_or(|end| !found.iter().any(|crossing| crossing.arm == Some(end)));
            let inside = station > cut[0] + half && station < cut[1] - half;
            if free && (inside || arm.is_some() || self.continues(near)) {
                found.push(RoadCrossing { node: feature.node, road: self.ix, station, arm, lights_only });
            }
        }
        found
    }

    /// The depth at which the roads that cross this one at an end leave its carriageway free; infinite where no road crosses it or
    /// the intersection was merged.
    fn edge_of_crossing_road(&self, end: End) -> f64 {
        let (road, length) = (self.road, self.road.line.length());
        let intersection = self.intersection(end);
        let ahead = outward(road, end, LOOK).normalize();
        let from_node = |arm: &RoadEnd| {
            let other = self.network.road(arm.road);
            let direction = outward(other, arm.end, LOOK).normalize();
            let (sine, cosine) = (cross(ahead, direction).abs(), ahead.dot(&direction).abs());
            (sine > CROSSES).then(|| (half_carriageway(other) + half_carriageway(road) * cosine) / sine)
        };
        let others = intersection.arms.iter().filter(|arm| arm.road != self.ix);
        let widest = others.filter_map(from_node).fold(f64::NEG_INFINITY, f64::max);
        if intersection.nodes.len() > 1 || widest < 0.0 {
            return f64::INFINITY;
        }
        from_cut(self.least, end, at_depth([0.0, length], end, widest))
    }

    /// Sets the cut back behind a crosswalk of the intersection, to the stop line before it.
    fn make_room_for_crosswalk(&mut self, crossing: &RoadCrossing) {
        let Some(end) = crossing.arm else { return };
        let behind = from_cut(self.least, end, crossing.station) + CROSSWALK_BREADTH / 2.0;
        let stop = &mut self.stop_lines[end];
        *stop = stop.filter(|stop| *stop > behind).map(|stop| stop.max(behind + STOP_GAP_LEAST));
        let setback = stop.unwrap_or(f64::INFINITY).min(behind + self.stop_gap(end));
        self.set_back(end, setback);
    }

    fn set_back(&mut self, end: End, setback: f64) {
        self.setbacks[end] = self.setbacks[end].max(setback);
        self.firm[end] = self.firm[end].max(setback);
        self.crossed[end] = self.crossed[end].max(setback);
    }

    /// From the stop line to the crosswalk, metres: on slow streets it is shorter, on fast roads longer.
    fn stop_gap(&self, end: End) -> f64 {
        match self.road.speed[end.other()] {
            speed if speed <= SLOW => STOP_GAP_LEAST,
            speed if speed >= FAST => STOP_GAP_FAST,
            _ => STOP_GAP,
        }
    }

    /// Sets the cuts of a private road back before a mapped sidewalk where the road has no crosswalk.
    fn make_room_for_sidewalks(&mut self, crossings: &[RoadCrossing]) {
        for end in End::BOTH {
            let crossed = crossings.iter().any(|crossing| crossing.arm == Some(end));
            if !crossed && self.is_approach(end) && self.leads_to_public_road(end) {
                let needed = before_sidewalk(self.road, end, self.least, self.setbacks[end.other()]);
                self.set_back(end, needed.unwrap_or_default());
            }
        }
    }

    fn leads_to_public_road(&self, end: End) -> bool {
        !self.road.public && self.intersection(end).arms.iter().any(|arm| self.network.road(arm.road).public)
    }

    /// Moves a crosswalk of the intersection to where the road is cut: toward the middle of the intersection where the road is
    /// too short, up the road where it is cut far back.
    fn move_to_cut(&self, crossing: &mut RoadCrossing, kept: Stations, at_stop_line: [bool; 2]) {
        let Some(end) = crossing.arm else { return };
        let middle = from_cut(self.least, end, kept[end]) - CROSSWALK_BREADTH / 2.0;
        let depth = from_cut(self.least, end, crossing.station);
        let depth = if at_stop_line[end] { depth } else { depth.max(middle - STOP_GAP_MOST) };
        crossing.station = at_depth(self.least, end, depth.min(middle - STOP_GAP_LEAST));
    }
}

/// The setback, metres, by which those who leave private ground stop before a mapped sidewalk; `None` without one near the
/// end, and where the road is too short or bends too much before it. `other` is the setback at its other end.
fn before_sidewalk(road: &Road, end: End, least: Stations, other: f64) -> Option<f64> {
    let behind = from_cut(least, end, sidewalk(road, end)?) + SIDEWALK / 2.0;
    let needed = behind + STOP_GAP;
    let left = least[1] - least[0] - other - needed;
    let fits = behind <= CROSSING_REACH && left >= ROAD_LEFT && bend(road, least, end, needed) <= SIDEWALK_BEND;
    fits.then_some(needed)
}

/// The station, metres, where a sidewalk that is mapped as a way of its own crosses a road nearest to this end.
pub fn sidewalk(road: &Road, end: End) -> Option<f64> {
    let length = road.line.length();
    let depth = |station: f64| from_cut([0.0, length], end, station);
    let sidewalks = road.features.iter().filter(|feature| feature.kind == FeatureKind::Sidewalk);
    let near = sidewalks.map(|feature| feature.station).filter(|station| depth(*station) <= length / 2.0);
    near.min_by(|a, b| depth(*a).total_cmp(&depth(*b)))
}

/// From the line of a road to the farther edge of its carriageway, metres.
fn half_carriageway(road: &Road) -> f64 {
    let (left, right) = road.section.carriageway();
    road.section.edge(left).abs().max(road.section.edge(right).abs())
}

/// Moves both cuts up a road of this `length`, of which so much is `left`; where it is too short for both, in proportion.
fn cut_back([start, end]: Stations, [a, b]: [f64; 2], (length, left): (f64, f64)) -> Stations {
    let room = (end - start - left.min(length / 2.0)).max(0.0);
    let share = if a + b > room { room / (a + b) } else { 1.0 };
    [start + a * share, end - b * share]
}

/// Where little remains of a road around a sharp bend, its two cuts would cross: keeps its longest straight part.
fn straighten(road: &Road, [start, end]: Stations) -> Stations {
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

/// Moves each cut that lies in a bend, or where one begins, to the nearest place behind which the road goes on straight: in a
/// bend the lanes on the inside would change direction at the cut, and the turn would begin where the bend does not yet end. A cut
/// moves up the road, so that the bend becomes a part of the turn, or back toward the least cut, as far as the `firm` part of its
/// setback allows.
fn clear_of_bends(road: &Road, (least, firm, left): (Stations, [f64; 2], f64), mut kept: Stations) -> Stations {
    /// Behind a cut the road goes straight on for this length, metres, ...
    const STRAIGHT_BEHIND_CUT: f64 = HEADING_REACH;
    /// ... or bends by no more than this, degrees, where the cut moves up the road by this, metres. The first that some place keeps
    /// counts: a short way to a straight road is worth it, a longer one only where the bend is sharp.
    const BENDS_MOST: [(f64, RangeInclusive<f64>); 3] = [(5.0, 0.0..=3.0), (10.0, ANYWHERE), (20.0, ANYWHERE)];
    const ANYWHERE: RangeInclusive<f64> = f64::NEG_INFINITY..=f64::INFINITY;
    /// ... and over half its width by no more than this: beyond it nothing is left of the edge on the inside.
    const INNER_BEND_MOST: f64 = 40.0;
    /// A cut moves by at most this, metres, or out of a right angle as tight as the road can bend, ...
    const MOST: f64 = 6.0;
    /// ... in steps of this, metres.
    const ROOM_STEP: f64 = 0.5;
    let half = road.half_width();
    for end in End::BOTH {
        let room = (kept[1] - kept[0] - left).max(0.0);
        let back = (from_cut(least, end, kept[end]) - firm[end]).max(0.0);
        let bend = |[depth, behind]: [f64; 2]| {
            let headings = [depth, depth + behind].map(|depth| inward(road, end, at_depth(kept, end, depth)));
            angle_between(headings[0], headings[1]).abs().to_degrees()
        };
        let steps = (0..).map(|i| ROOM_STEP * f64::from(i)).take_while(|depth| *depth <= MOST.max(2.0 * half));
        let both_ways = steps.flat_map(|depth| [depth, -depth]).filter(|depth| *depth <= room && *depth >= -back);
        let is_clear = |depth: f64, most: f64| {
            bend([depth, STRAIGHT_BEHIND_CUT]) <= most && bend([depth, half]) <= INNER_BEND_MOST
        };
        let nearest = |(most, moves): &(f64, RangeInclusive<f64>)| {
            both_ways.clone().find(|depth| moves.contains(depth) && is_clear(*depth, *most))
        };
        // A ring bends everywhere.
        let clear = BENDS_MOST.iter().skip(usize::from(road.roundabout)).find_map(nearest);
        kept[end] = at_depth(kept, end, clear.unwrap_or(0.0));
    }
    kept
}
