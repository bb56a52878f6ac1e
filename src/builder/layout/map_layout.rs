//! The lanes of a network and the lanelets through its intersections, as they are drawn and redrawn.
//!
//! The outlines tell where each road is cut, but how far a turn swings out is known only when it is drawn. A road whose cut lies
//! under a turn is cut back behind the turn and drawn again, so that lanes end where the intersection begins, and their end nodes lie
//! on its outline.

mod intersection_lanelets;
mod lane_end_overlap;
mod reuse;

use crate::builder::intersection::movement::most_movements;
use crate::builder::lanes::gore::gore_corners;
use crate::builder::lanes::lane_ends::{RequiredSetbacks, connection_lines};
use crate::builder::lanes::road_continuation::Continuations;
use crate::builder::lanes::road_cut::{ConnectionLines, ROAD_LEFT, Squeeze, SqueezedRoads, least_left};
use crate::builder::lanes::road_lanes::{lanes, redraw};
use crate::builder::lanes::types::Lanes;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::road_end::from_cut;
use crate::builder::network::{IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::diagnostic::Finding;
use crate::parallel::InSmallParts;

use lane_end_overlap::{BACK_MOST, TOUCH};

pub use intersection_lanelets::{IntersectionLanelets, Site};

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// A cut moves by this much, metres, each time that the outline does not lead along it, more where more than [`FEW_ARMS`] roads meet ...
const CLEARING: f64 = 1.0;
/// ... until it lies this far, metres, behind the outline of the streets.
const CLEARING_MOST: f64 = 30.0;
/// Where more roads meet, the outline is larger, and drawing it takes longer: fewer rounds are made.
const FEW_ARMS: usize = 8;
/// Lengths of roads that differ by less than this, metres, are the same.
const SAME_LENGTH: f64 = 0.05;
/// A cut lies this far, metres, behind the lanelet that would run over it.
const BEHIND_LANELET: f64 = 0.2;

/// What is drawn at one end of a road longer than this, metres, does not depend on where its other end is cut.
const SHORT: f64 = 50.0;

/// A network with its lanes and turning lanelets, before rights of way are decided.
pub struct Layout {
    /// The network.
    pub network: RoadNetwork,
    /// Its turn restrictions.
    pub restrictions: ResolvedRestrictions,
    /// Where roads meet face to face.
    pub joins: Continuations,
    /// Where roads are cut.
    pub lines: ConnectionLines,
    /// Lanes, as primitives.
    pub assembly: MapBuilder<'static>,
    /// Lanes and arms.
    pub lanes: Lanes,
    /// Per intersection its movements and their lanelets; `None` where roads meet face to face or end.
    pub turning: Vec<Option<Box<IntersectionLanelets>>>,
    /// How far each end of a road is cut back at least, metres behind its outline.
    pub(super) back: Vec<[f64; 2]>,
    /// Whether each end of a road is cut where the map says that vehicles stop.
    pub(super) stops: Vec<[bool; 2]>,
    /// Roads between intersections that do not keep room for a waiting vehicle: turns need it.
    pub(super) squeezed: SqueezedRoads,
    /// How far the turns at each end of a road want it cut back.
    needs: RequiredSetbacks,
    /// How much was drawn so far: for each intersection each time, the pairs of its lanelets, which are held against each other.
    pub(super) drawn: u64,
}

impl Layout {
    /// Draws a network with its roads cut at `kept`, the stations between which the outlines leave them. Also gives the
    /// restrictions that cannot be expressed.
    pub fn new(network: RoadNetwork, kept: &[Stations], contested: BTreeSet<i64>) -> (Self, Vec<Finding>) {
        let (restrictions, notes) = ResolvedRestrictions::new(&network);
        let mut joins = Continuations::find(&network);
        let needs = RequiredSetbacks::new(&network, kept, |ix| joins.joined(ix));
        let (back, stops) = (vec![[0.0; 2]; network.roads.len()], vec![[false; 2]; network.roads.len()]);
        let squeezed = SqueezedRoads::default();
        let lines = connection_lines(&network, &needs, &back, (&stops, &squeezed), |_| None);
        joins.set_gore_corners(gore_corners(&network, &lines));
        let mut assembly = MapBuilder::new(contested);
        let lanes = lanes(&mut assembly, &network, &lines, &mut joins);
        let turning = network.intersections.iter().map(|_| None).collect();
        let mut layout = Self {
            network,
            restrictions,
            joins,
            lines,
            assembly,
            lanes,
            turning,
            back,
            stops,
            squeezed,
            needs,
            drawn: 0,
        };
        layout.draw_lanelets();
        (layout, notes)
    }

    /// The connection lines for the present setbacks and stop lines.
    pub(super) fn wanted_lines(&self) -> ConnectionLines {
        let ends = (&self.stops[..], &self.squeezed);
        connection_lines(&self.network, &self.needs, &self.back, ends, |road| Some(self.lines.cut(road)))
    }

    /// Draws the roads whose cuts have moved and those in `anew`, which are in order of their indices, and the lanelets at their ends.
    pub(super) fn redraw(&mut self, anew: &[RoadIx]) {
        let lines = self.wanted_lines();
        let Self { network, joins, assembly, lanes, .. } = self;
        let mut redrawn = joins.set_gore_corners(gore_corners(network, &lines));
        redrawn.extend(anew);
        let before = std::mem::replace(&mut self.lines, lines);
        let lines = &self.lines;
        let moved = |road: &RoadIx| before.kept[*road] != lines.kept[*road] || redrawn.contains(road);
        let moved: Vec<RoadIx> = (0..lines.kept.len()).map(RoadIx::new).filter(moved).collect();
        redraw(assembly, network, lines, joins, lanes, &moved);
        self.drop_lanelets(&before, &redrawn, &moved);
        self.draw_lanelets();
    }

    /// Drops the lanelets of intersections where a cut has moved or a road is redrawn, and those that depend on far cuts of `moved`
    /// roads, which are in order.
    fn drop_lanelets(&mut self, before: &ConnectionLines, redrawn: &FxHashSet<RoadIx>, moved: &[RoadIx]) {
        let kept = &self.lines.kept;
        for (slot, at) in self.turning.iter_mut().zip(&self.network.intersections) {
            let stays = |arm: &RoadEnd| {
                before.kept[arm.road][arm.end] == kept[arm.road][arm.end] && !redrawn.contains(&arm.road)
            };
            let far_cut_moved = || at.arms.iter().any(|arm| moved.binary_search(&arm.road).is_ok());
            match slot {
                Some(turning) if at.arms.iter().all(stays) && !(turning.depends_on_far_cuts && far_cut_moved()) => {
                    turning.unchanged = true
                }
                _ => *slot = None,
            }
        }
    }

    /// Draws the lanelets that are not drawn yet. An intersection gets its outline, too, unless a lanelet runs over a cut: then its
    /// lanelets are drawn again.
    fn draw_lanelets(&mut self) {
        let Self { network, restrictions, joins, lines, assembly, lanes, turning, drawn, .. } = self;
        let (roundabouts, most_movements) = (network.whole_roundabouts(), most_movements(network));
        let more = AtomicU64::new(0);
        turning.par_iter_mut().in_small_parts().enumerate().filter(|(_, turning)| turning.is_none()).for_each(
            |(i, slot)| {
                let at = &network.intersections[i];
                if at.arms.len() < 2 || joins.joined(IntersectionIx::new(i)) {
                    return;
                }
                let site = Site {
                    network,
                    roundabouts: &roundabouts,
                    restrictions,
                    lanes,
                    intersection: at,
                    below: assembly,
                    most_movements,
                };
                let mut turning = IntersectionLanelets::draw(site);
                more.fetch_add((turning.drawn.paths.len() as u64).pow(2), Ordering::Relaxed);
                if at.arms.len() > 2 {
                    turning.overlapped_ends =
                        lane_end_overlap::depths(network, lines, lanes, assembly, at, &turning.drawn.paths);
                }
                if turning.overlapped_ends.is_empty() {
                    turning = turning.outlined(site);
                }
                *slot = Some(Box::new(turning));
            },
        );
        *drawn += more.into_inner();
    }

    /// Draws the outlines that are not drawn yet.
    pub(super) fn outline(&mut self) {
        let Self { network, restrictions, assembly, lanes, turning, .. } = self;
        let (roundabouts, most_movements) = (network.whole_roundabouts(), most_movements(network));
        let bare = |turning: &Option<Box<IntersectionLanelets>>| {
            turning.as_ref().is_some_and(|turning| turning.conflicts.is_none())
        };
        let bare =
            turning.par_iter_mut().in_small_parts().zip(&network.intersections).filter(|(turning, _)| bare(turning));
        bare.for_each(|(slot, at)| {
            let site = Site {
                network,
                roundabouts: &roundabouts,
                restrictions,
                lanes,
                intersection: at,
                below: assembly,
                most_movements,
            };
            *slot = slot.take().map(|turning| Box::new(turning.outlined(site)));
        });
        // From now on an outline stays when its roads are cut at their other ends.
        turning.iter_mut().flatten().for_each(|turning| turning.depends_on_far_cuts = false);
    }

    /// Draws roads again at their new heights, and removes what earlier rounds have drawn and nothing uses.
    pub(super) fn lift(&mut self, roads: &[RoadIx]) {
        if !roads.is_empty() {
            self.joins.forget_points(roads);
            self.redraw(roads);
            self.outline();
        }
        self.remove_replaced();
    }

    /// Removes what earlier rounds have drawn of roads that were drawn again.
    fn remove_replaced(&mut self) {
        let Self { lanes, joins, assembly, .. } = self;
        let lines = lanes.pieces.iter().flatten().flat_map(|piece| piece.borders.iter().flatten());
        let lines = lines.map(|bound| bound.line).collect();
        let lanelets = lanes.lanes.iter().map(|lane| lane.lanelet).collect();
        assembly.retain(&lines, &lanelets, joins.points());
    }

    /// The ends of roads whose lanes do not end on the outline around the lanelets there: some lanelet runs over them.
    pub fn overrun(&self) -> impl Iterator<Item = RoadEnd> {
        self.network.intersections.iter().zip(&self.turning).flat_map(|(at, turning)| {
            let area = turning.as_ref().and_then(|turning| turning.area.as_ref());
            area.into_iter().flat_map(|area| area.overrun.iter().map(|&arm| at.arms[arm]))
        })
    }

    /// What is left of a road between its cuts, metres.
    pub fn left(&self, road: RoadIx) -> f64 {
        let [from, to] = self.lines.kept[road];
        to - from
    }

    /// How much of a road needed setbacks leave, metres.
    pub(super) fn least_left(&self, road: RoadIx) -> f64 {
        least_left(&self.network, &self.squeezed, self.network.road(road))[0]
    }

    /// Whether a road cannot be cut back farther.
    pub(super) fn is_spent(&self, road: RoadIx) -> bool {
        self.left(road) < self.least_left(road) + SAME_LENGTH
    }

    /// Whether a road can give more to turns: it keeps room for a waiting vehicle, or some that would make turns easier.
    pub(super) fn keeps_room(&self, road: RoadIx) -> bool {
        match self.squeezed.get(&self.network.road(road).key) {
            None => self.is_spent(road) && self.least_left(road) > ROAD_LEFT,
            Some(squeeze) => *squeeze != Squeeze::Easy,
        }
    }

    /// What takes the room of a waiting vehicle on a road; `None` if nothing does.
    pub(super) fn squeeze_of(&self, road: RoadIx) -> Option<Squeeze> {
        self.squeezed.get(&self.network.road(road).key).copied()
    }

    /// Lets turns take a little more of these roads than they do. The turns at their ends are asked again how much room they want.
    pub(super) fn squeeze(&mut self, roads: &[RoadIx]) {
        for road in roads {
            let road = self.network.road(*road);
            let squeeze = match self.squeezed.get(&road.key) {
                None => Squeeze::Least,
                Some(Squeeze::Least) => Squeeze::Needed,
                Some(Squeeze::Needed | Squeeze::Easy) => Squeeze::Easy,
            };
            self.squeezed.insert(road.key, squeeze);
            for at in [road.from, road.to] {
                if let Some(turning) = self.turning.get_mut(at.position()).and_then(Option::as_mut) {
                    turning.turns_asked = false;
                }
            }
        }
    }

    /// Whether the roads of an intersection are two that meet face to face.
    pub(super) fn meet_face_to_face(&self, at: IntersectionIx) -> bool {
        self.joins.joined(at)
    }

    /// How far behind its outline a road is cut, metres.
    pub(super) fn setback(&self, at: RoadEnd) -> f64 {
        from_cut(self.lines.least[at.road], at.end, self.lines.kept[at.road][at.end])
    }

    /// Moves cuts behind the lanelets that run over them; `false` if none moves.
    pub(super) fn set_back_overlapped_cuts(&mut self) -> bool {
        let over = self
            .turning
            .iter()
            .flatten()
            .filter(|turning| !turning.unchanged)
            .flat_map(|turning| &turning.overlapped_ends);
        let behind = |(at, depth): &(RoadEnd, f64)| (*at, (self.setback(*at) + depth + BEHIND_LANELET).min(BACK_MOST));
        let wanted: Vec<(RoadEnd, f64)> = over.map(behind).collect();
        self.set_back(wanted, TOUCH)
    }

    /// Moves cuts farther back along which the outline does not lead, if their roads have room; `false` if none moves.
    pub(super) fn set_back_overrun_cuts(&mut self) -> bool {
        let roomy = |at: &RoadEnd| !self.is_spent(at.road);
        let step = |at: RoadEnd| {
            let arms = self.network.intersection(self.network.intersection_at(at)).arms.len();
            CLEARING * arms.max(FEW_ARMS) as f64 / FEW_ARMS as f64
        };
        let farther = |at: RoadEnd| (at, (self.setback(at) + step(at)).min(CLEARING_MOST));
        let wanted: Vec<(RoadEnd, f64)> = self.overrun().filter(roomy).map(farther).collect();
        self.set_back(wanted, 0.0)
    }

    /// Ignores the stop lines of the roads up to this number of `roads` away from an intersection, and gives these roads the setbacks
    /// of `back` again; `false` if that changes nothing. The search ends at long roads: what is drawn at one end of them does not
    /// depend on the cut at the other.
    pub(super) fn ignore_stop_lines_around(&mut self, at: IntersectionIx, roads: usize, back: &[[f64; 2]]) -> bool {
        let mut changed = false;
        for road in self.network.roads_around(at, roads, SHORT) {
            let (stops, own) = (&mut self.stops[road], &mut self.back[road]);
            changed |= *stops != [false; 2] || *own != back[road];
            (*stops, *own) = ([false; 2], back[road]);
        }
        changed
    }

    /// Raises the setbacks of road ends to the `wanted` ones, metres, where these are larger by more than `least`; `false` if none is.
    pub(super) fn set_back(&mut self, wanted: Vec<(RoadEnd, f64)>, least: f64) -> bool {
        let mut changed = false;
        for (at, by) in wanted {
            let back = &mut self.back[at.road][at.end];
            if by > *back + least {
                *back = by;
                changed = true;
            }
        }
        changed
    }
}
