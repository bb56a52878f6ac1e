//! The loop that draws a network until every lane ends on the outline of its intersection.
//!
//! How much of a road the turns at its ends take is known only when they are drawn. A layout then makes demands: some cuts must move
//! farther back, some roads must be merged or left out, some roads must be cut at their stop lines. Each round meets the demands of
//! one kind and draws again what that changes.
//!
//! A road between two intersections keeps room for a waiting vehicle, unless lanelets run over its ends or a car could not take a turn.
//! It can then be too short to be cut back behind a lanelet that runs over its end, or to be cut back for a turn that a car can take.
//! No vehicle can wait on such a road: it lies inside an intersection, and the intersections at its ends are merged if that helps. A
//! dead end or a loop of that kind is left out. A longer road that no turn joins ends before the intersection.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::lanes::road_cut::VEHICLE;
use crate::builder::network::network_diff::{NetworkDiff, NetworkSnapshot};
use crate::builder::network::unreachable_lanes::{direct_half_served, end_road_without_turns};
use crate::builder::network::{IntersectionIx, Road, RoadEnd, RoadIx, RoadKey, RoadNetwork, Stations};
use crate::builder::streets::consolidate::{ConsolidateOptions, absorb_roads, crowded_accesses, crowds, without_roads};
use crate::builder::streets::heights::{HeightOptions, level_at_cuts};
use crate::builder::streets::lane_drop::{LaneDrop, with_lane_drops};
use crate::builder::streets::lane_opening::{LaneOpening, with_lane_openings};
use crate::diagnostic::Finding;

use super::close_intersections::{Pair, RoadMiddles, is_well_merged, roads_without_room};
use super::lane_drops::{added_lanes, lane_drops};
use super::lane_openings::{closed_lanes, lane_openings};
use super::last_resorts::last_resorts;
use super::map_layout::Layout;
use super::roads_inside::{
    crowded_intersections, ended_early, ends_without_turns, half_served_ends, left_out, left_out_movements,
    road_inside, roads_inside, roads_to_cut_farther, roads_to_leave_out, too_many_roads,
};
use super::short_links::{SETBACK_LEAST, room_for_turns};

/// The largest number of rounds. No layout needs that number: each round cuts more off roads, merges some or leaves some out, so the
/// loop ends by itself.
const ROUNDS: usize = 200;
/// Stop lines that get into the way of a lanelet are ignored at its intersection, and then in each round one short road farther away,
/// up to this number of roads.
const FARTHEST_STOP_LINES: usize = 6;

/// What is drawn in all rounds is at most so many times what was drawn in the first one, or [`LEAST_EFFORT`]: where dozens of roads lie
/// over each other, everything is drawn again and again.
const MOST_EFFORT: u64 = 4;
/// The same for maps with little to draw, in pairs of lanelets: all rounds of Monaco draw a thirtieth of it, and those of no extract of
/// real streets that draws more take twice what the first one does.
const LEAST_EFFORT: u64 = 400_000;

/// Lays out a network. `kept` are the stations between which the outlines leave each road; roads in `apart` are never merged. At the
/// end, the heights of the roads are fitted to their cuts. The findings tell which restrictions could not be expressed, and which
/// roads were merged or left out.
pub fn lay_out(
    network: RoadNetwork,
    kept: Vec<Stations>,
    apart: &FxHashSet<RoadKey>,
    heights: &HeightOptions,
    contested: BTreeSet<i64>,
) -> (Layout, Vec<Finding>) {
    let crowded = crowded_intersections(&network);
    let (layout, notes) = Layout::new(network, &kept, contested);
    let most_effort = (MOST_EFFORT * layout.drawn).max(LEAST_EFFORT);
    let begun = LayoutLoop {
        layout,
        most_effort,
        kept,
        apart,
        refused: apart.clone(),
        unmerged: None,
        merged: Vec::new(),
        closed_up: FxHashMap::default(),
        settled: FxHashSet::default(),
        stop_lines: StopLines::Untried,
        notes,
        road_notes: crowded.iter().map(|(node, counts)| too_many_roads(*node, *counts)).collect(),
    };
    let (ControlFlow::Continue(rounds) | ControlFlow::Break(rounds)) =
        (0..ROUNDS).try_fold(begun, |rounds, _| rounds.meet_demand());
    rounds.finished(heights)
}

/// A layout, and what is known of its demands.
struct LayoutLoop<'a> {
    layout: Layout,
    /// How much is drawn at most, as [`Layout::drawn`].
    most_effort: u64,
    /// The stations between which the outlines leave each road.
    kept: Vec<Stations>,
    /// Roads that the user keeps apart.
    apart: &'a FxHashSet<RoadKey>,
    /// These, and roads that could not be merged.
    refused: FxHashSet<RoadKey>,
    /// The state before the first roads were merged.
    unmerged: Option<Unmerged>,
    /// The roads that were merged since.
    merged: Vec<RoadKey>,
    /// Roads that need not be merged, but leave little room; and the intersections at their ends as they were before.
    closed_up: FxHashMap<RoadKey, Pair>,
    /// The nodes at which such roads were merged before lanes were added or closed: these merges are never taken back.
    settled: FxHashSet<i64>,
    stop_lines: StopLines,
    /// The restrictions of the present network that cannot be expressed.
    notes: Vec<Finding>,
    /// Which roads were merged or left out.
    road_notes: Vec<Finding>,
}

/// What the loop begins with again when merges are taken back.
#[derive(Clone)]
struct Unmerged {
    network: RoadNetwork,
    kept: Vec<Stations>,
    /// How far each end of a road is cut back at least, metres.
    back: Vec<[f64; 2]>,
    road_notes: Vec<Finding>,
    /// Roads that are not merged: the user keeps them apart, or a merge did not help.
    refused: FxHashSet<RoadKey>,
}

/// Whether roads have been cut at the stop lines of the map.
enum StopLines {
    Untried,
    /// They have. `back` are the setbacks of the layout before, and `overrun` the ends of roads along which its outlines did not
    /// lead; `left_out` tells how many roads around an intersection ignore their stop lines.
    Tried {
        back: Vec<[f64; 2]>,
        overrun: FxHashSet<RoadEnd>,
        left_out: BTreeMap<IntersectionIx, usize>,
    },
    Done,
}

impl LayoutLoop<'_> {
    /// Meets the demands of the first kind that has some; breaks if there are no demands.
    fn meet_demand(mut self) -> ControlFlow<Self, Self> {
        if self.layout.drawn > self.most_effort {
            self.road_notes.extend(ended_early(&self.layout));
            return ControlFlow::Break(self);
        }
        if self.set_back_cuts() || self.cut_roads_farther() {
            self.layout.redraw(&[]);
            return ControlFlow::Continue(self);
        }
        if matches!(self.stop_lines, StopLines::Untried) {
            let before = NetworkSnapshot::of(&self.layout.network);
            if self.leave_out_crowded_accesses()
                || self.merge_roads()
                || self.leave_out_roads()
                || self.end_roads_without_turns()
            {
                return ControlFlow::Continue(self.followed(&before));
            }
            if let Some(anew) = self.without_useless_merges() {
                return ControlFlow::Continue(self.begun_anew(&before, anew));
            }
            let directed = self.direct_half_served_roads();
            if !directed.is_empty() {
                return ControlFlow::Continue(self.redirected(&before, &directed));
            }
            let drops = lane_drops(&self.layout);
            if !drops.is_empty() {
                return ControlFlow::Continue(self.with_lane_drops(&before, &drops));
            }
            let openings = lane_openings(&self.layout);
            if !openings.is_empty() {
                return ControlFlow::Continue(self.with_lane_openings(&before, &openings));
            }
        }
        if self.cut_at_stop_lines() {
            self.layout.redraw(&[]);
            return ControlFlow::Continue(self);
        }
        ControlFlow::Break(self)
    }

    /// Moves cuts behind the lanelets that run over them, and back to make room for turns; if none moves, back to the outlines. `false`
    /// if no cut moves.
    fn set_back_cuts(&mut self) -> bool {
        if self.layout.set_back_overlapped_cuts() {
            return true;
        }
        let wanted = room_for_turns(&mut self.layout);
        if self.layout.set_back(wanted, SETBACK_LEAST) {
            return true;
        }
        self.layout.outline();
        self.layout.set_back_overrun_cuts()
    }

    /// Lets turns take the room of a waiting vehicle on roads where they need it; `false` if there are none.
    fn cut_roads_farther(&mut self) -> bool {
        let roads = roads_to_cut_farther(&self.layout);
        self.layout.squeeze(&roads);
        !roads.is_empty()
    }

    /// Leaves out the short dead ends of a row that would all become one intersection; `false` if there are none.
    fn leave_out_crowded_accesses(&mut self) -> bool {
        let network = &self.layout.network;
        let mut roads = crowded_accesses(network, &roads_inside(&self.layout, &self.refused));
        roads.retain(|road| !self.apart.contains(&network.road(*road).key));
        self.leave_out(&roads, crowds)
    }

    /// Merges the intersections at the ends of roads that lie inside; `false` if there are none, or none can be merged.
    fn merge_roads(&mut self) -> bool {
        let mut roads = roads_inside(&self.layout, &self.refused);
        if roads.is_empty() {
            // Where nothing has to be merged, what should be is.
            let closed = self.closed_nodes();
            roads = roads_without_room(&self.layout, &self.refused, &closed);
            let layout = &self.layout;
            self.closed_up.extend(roads.iter().map(|road| (layout.network.road(*road).key, Pair::of(layout, *road))));
        }
        if roads.is_empty() {
            return false;
        }
        self.unmerged.get_or_insert_with(|| Unmerged {
            network: self.layout.network.clone(),
            kept: self.kept.clone(),
            back: self.layout.back.clone(),
            road_notes: self.road_notes.clone(),
            refused: self.apart.clone(),
        });
        let resorts = last_resorts(&self.layout, &roads);
        let network = std::mem::take(&mut self.layout.network);
        let left = |road| self.layout.left(road);
        let (mut network, mut changed, mut merges) =
            absorb_roads(network, &roads, left, &ConsolidateOptions::default());
        if changed {
            merges.retain(|note| note.merged || !resorts.iter().any(|resort| resort.may_help(note)));
        }
        for resort in resorts {
            if !changed && merges.iter().any(|note| resort.may_help(note)) {
                (network, changed, merges) = absorb_roads(network, &resort.roads, left, &resort.options);
            }
        }
        self.layout.network = network;
        self.refused.extend(merges.iter().filter(|note| !note.merged).map(|note| note.key));
        self.merged.extend(merges.iter().filter(|note| note.merged).map(|note| note.key));
        self.road_notes.extend(merges.iter().filter(|note| note.merged).map(road_inside));
        changed
    }

    /// The nodes at which roads were merged that did not have to be.
    fn closed_nodes(&self) -> FxHashSet<i64> {
        let closed = self.merged.iter().filter(|key| self.closed_up.contains_key(key));
        closed.flat_map(|key| [key.first, key.last]).chain(self.settled.iter().copied()).collect()
    }

    /// The state before roads were merged, if some merges must be taken back. Roads are merged so that no lanelet runs over their ends.
    /// Where lanelets still run over roads without room, the merge did not help: the intersection has only grown, perhaps from one
    /// road to the next.
    fn without_useless_merges(&mut self) -> Option<Unmerged> {
        let badly = self.badly_merged();
        let unmerged = self.unmerged.as_mut()?;
        let Layout { network, .. } = &self.layout;
        let crowded = self.layout.overrun().filter(|at| self.layout.left(at.road) < VEHICLE);
        let nodes = crowded.flat_map(|at| &network.intersection(network.intersection_at(at)).nodes);
        let nodes: FxHashSet<i64> = nodes.copied().collect();
        let is_useless = |key: &&RoadKey| [key.first, key.last].iter().any(|node| nodes.contains(node));
        let before = unmerged.refused.len();
        unmerged.refused.extend(self.merged.iter().filter(is_useless));
        unmerged.refused.extend(badly);
        (unmerged.refused.len() > before).then(|| unmerged.clone())
    }

    /// Of the roads that did not have to be merged, those that made no good intersection.
    fn badly_merged(&self) -> Vec<RoadKey> {
        let network = &self.layout.network;
        let closed_up = self.merged.iter().filter_map(|key| Some((*key, self.closed_up.get(key)?)));
        let by_node: FxHashMap<i64, (RoadKey, &Pair)> = closed_up.map(|one| (one.0.first, one)).collect();
        if by_node.is_empty() {
            return Vec::new();
        }
        let middles = RoadMiddles::of(network);
        let of_each = IntersectionIx::all(network.intersections.len()).flat_map(|ix| {
            let inside = network.intersection(ix).nodes.iter().filter_map(|node| by_node.get(node));
            inside.filter(|(_, before)| !is_well_merged(&self.layout, &middles, ix, before)).collect::<Vec<_>>()
        });
        of_each.map(|(key, _)| *key).collect()
    }

    /// Leaves out roads that lead nowhere; `false` if there are none.
    fn leave_out_roads(&mut self) -> bool {
        self.leave_out(&roads_to_leave_out(&self.layout, self.apart), left_out)
    }

    fn leave_out(&mut self, roads: &[RoadIx], note: impl Fn(&Road) -> Finding) -> bool {
        let network = std::mem::take(&mut self.layout.network);
        self.road_notes.extend(roads.iter().map(|road| note(network.road(*road))));
        self.layout.network = without_roads(network, roads);
        !roads.is_empty()
    }

    /// Ends roads before an intersection where no car can turn into them or out of them; `false` if there are none.
    fn end_roads_without_turns(&mut self) -> bool {
        let ends = ends_without_turns(&self.layout);
        let mut notes: Vec<Finding> = Vec::new();
        for at in ends {
            let Layout { network, restrictions, .. } = &mut self.layout;
            notes.extend(end_road_without_turns(network, restrictions, &mut self.kept, at));
        }
        let changed = !notes.is_empty();
        self.road_notes.append(&mut notes);
        changed
    }

    /// Takes the direction from roads that no lanelet serves at an end. Gives these roads.
    fn direct_half_served_roads(&mut self) -> BTreeSet<RoadIx> {
        let mut directed = BTreeSet::new();
        for (at, away) in half_served_ends(&self.layout) {
            let Layout { network, restrictions, .. } = &mut self.layout;
            if let Some(note) = direct_half_served(network, restrictions, at, away) {
                self.road_notes.push(note);
                directed.insert(at.road);
            }
        }
        directed
    }

    /// Draws roads again that have lost a direction. They may meet others face to face now.
    fn redirected(mut self, before: &NetworkSnapshot, directed: &BTreeSet<RoadIx>) -> Self {
        let network = std::mem::take(&mut self.layout.network);
        let diff = NetworkDiff::between(before, &network);
        let kept = std::mem::take(&mut self.kept);
        self.redrawn((before, &diff), (network, kept), directed)
    }

    /// Draws what has changed since the network was `before`: some roads are gone.
    fn followed(mut self, before: &NetworkSnapshot) -> Self {
        let network = std::mem::take(&mut self.layout.network);
        let diff = NetworkDiff::between(before, &network);
        let kept: Vec<Stations> = diff.roads().filter_map(|(_, old)| self.kept.get(old?.position()).copied()).collect();
        self.redrawn((before, &diff), (network, kept), &BTreeSet::new())
    }

    /// Gives roads more lanes at their beginnings, and draws what that changes. Merges of before stay.
    fn with_lane_drops(mut self, before: &NetworkSnapshot, drops: &[LaneDrop]) -> Self {
        let network = std::mem::take(&mut self.layout.network);
        self.road_notes.extend(drops.iter().map(|drop| added_lanes(&network, drop)));
        let changed = with_lane_drops(network, &self.kept, drops);
        self.with_other_ends(before, changed)
    }

    /// Closes lanes at the beginnings and ends of roads, and draws what that changes. Merges of before stay.
    fn with_lane_openings(mut self, before: &NetworkSnapshot, openings: &[LaneOpening]) -> Self {
        let network = std::mem::take(&mut self.layout.network);
        self.road_notes.extend(openings.iter().map(|opening| closed_lanes(&network, opening)));
        let changed = with_lane_openings(network, &self.kept, openings);
        self.with_other_ends(before, changed)
    }

    /// Draws what divided roads change.
    fn with_other_ends(mut self, before: &NetworkSnapshot, (network, kept): (RoadNetwork, Vec<Stations>)) -> Self {
        let diff = NetworkDiff::between(before, &network);
        self.settled = self.closed_nodes();
        (self.unmerged, self.merged) = (None, Vec::new());
        self.redrawn((before, &diff), (network, kept), &BTreeSet::new())
    }

    /// Draws what differs between the network `before` and a later one, and the roads in `directed`.
    fn redrawn(
        self,
        (before, diff): (&NetworkSnapshot, &NetworkDiff),
        (network, kept): (RoadNetwork, Vec<Stations>),
        directed: &BTreeSet<RoadIx>,
    ) -> Self {
        let back = self.layout.kept_setbacks(diff, &network);
        let (layout, notes) = self.layout.followed((before, diff), network, (&kept, back), directed);
        Self { layout, kept, notes, ..self }
    }

    /// Begins again with the network before the merges; `before` is the present one. Only lanes and lanelets that would be drawn the
    /// same are kept, so that a merge that did not help in one place decides nothing elsewhere.
    fn begun_anew(self, before: &NetworkSnapshot, unmerged: Unmerged) -> Self {
        let Unmerged { network, kept, back, road_notes, refused } = unmerged;
        let diff = NetworkDiff::between(before, &network);
        let (layout, notes) = self.layout.followed((before, &diff), network, (&kept, back), &BTreeSet::new());
        Self { layout, kept, notes, road_notes, refused, merged: Vec::new(), ..self }
    }

    /// Cuts roads at the stop lines of the map. Around an intersection where more lanelets would then run over the ends of lanes, the
    /// roads keep their cuts, and the rest of the map is not affected. `false` if nothing is left to try.
    fn cut_at_stop_lines(&mut self) -> bool {
        let layout = &mut self.layout;
        match &mut self.stop_lines {
            StopLines::Untried => {
                layout.stops.fill([true; 2]);
                let changed = !layout.wanted_lines().agree(&layout.lines);
                self.stop_lines = if changed {
                    let (back, overrun) = (layout.back.clone(), layout.overrun().collect());
                    StopLines::Tried { back, overrun, left_out: BTreeMap::new() }
                } else {
                    StopLines::Done
                };
                changed
            }
            StopLines::Tried { back, overrun, left_out } => {
                let more = layout.overrun().filter(|at| !overrun.contains(at));
                let more: BTreeSet<IntersectionIx> = more.map(|at| layout.network.intersection_at(at)).collect();
                let mut changed = false;
                while !changed && more.iter().any(|at| left_out.get(at).is_none_or(|far| *far < FARTHEST_STOP_LINES)) {
                    for at in &more {
                        let far = left_out.entry(*at).or_default();
                        *far = (*far + 1).min(FARTHEST_STOP_LINES);
                        changed |= layout.ignore_stop_lines_around(*at, *far, back);
                    }
                }
                if !changed {
                    self.stop_lines = StopLines::Done;
                }
                changed
            }
            StopLines::Done => false,
        }
    }

    /// The layout, with the heights of its roads fitted to their cuts, and all findings.
    fn finished(self, heights: &HeightOptions) -> (Layout, Vec<Finding>) {
        let Self { mut layout, mut notes, road_notes, .. } = self;
        layout.outline();
        let lifted = level_at_cuts(&mut layout.network, &layout.lines.kept, heights);
        layout.lift(&lifted);
        notes.extend(road_notes);
        notes.extend(left_out_movements(&layout));
        (layout, notes)
    }
}
