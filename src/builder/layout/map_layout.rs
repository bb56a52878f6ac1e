//! Lanes and the ways through the intersections, drawn until no way runs over the end of a lane.
//!
//! Where each road is cut follows from the outlines, but how far a turn swings out shows only when it is drawn. A road
//! whose cut lies under a turn is cut back behind it, and everything is drawn again: lanes end where the intersection
//! begins, and their end nodes lie on its outline.

mod intersection_lanelets;
mod lane_end_overlap;
mod reindex;

use crate::builder::lanes::gore::gore_corners;
use crate::builder::lanes::lane_ends::{RequiredSetbacks, connection_lines};
use crate::builder::lanes::road_continuation::Continuations;
use crate::builder::lanes::road_cut::{ConnectionLines, ROAD_LEFT};
use crate::builder::lanes::road_lanes::{lanes, redraw};
use crate::builder::lanes::types::Lanes;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::road_end::from_cut;
use crate::builder::network::turn_restrictions::ResolvedRestrictions;
use crate::builder::network::{IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::parallel::Finely;

use lane_end_overlap::{BACK_MOST, TOUCH};

pub use intersection_lanelets::IntersectionLanelets;

use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Each round settles what the round before moved; ways grow by less than they give.
const ROUNDS: usize = 4;
/// Where the outline shows that more is needed, so many rounds more,
const ROUNDS_OUTLINED: usize = 8;
/// by so many metres each.
const CLEARING: f64 = 1.0;
/// Stop lines that get into the way of something are left out in so many rounds, then all.
const ROUNDS_STOPPED: usize = 3;
/// A cut lies this far, metres, behind the way that would run over it.
const CLEAR: f64 = 0.2;

/// What is drawn of a map before it is known what rules its intersections.
pub struct MapLayout {
    /// Where roads meet face to face.
    pub joins: Continuations,
    /// Where roads are cut.
    pub lines: ConnectionLines,
    /// Lanes, as primitives.
    pub assembly: MapBuilder<'static>,
    /// Lanes and arms.
    pub lanes: Lanes,
    /// Per intersection which lane leads to which, and the ways; `None` where roads meet face to face or end.
    pub ways: Vec<Option<Box<IntersectionLanelets>>>,
    /// How far each end of a road is cut back at least, metres behind its outline.
    back: Vec<[f64; 2]>,
    /// Whether each end of a road is cut where the map says that vehicles stop.
    stops: Vec<[bool; 2]>,
    /// What the ends of roads need, however far they are cut back.
    needs: RequiredSetbacks,
}

impl MapLayout {
    /// Draws until no way runs over the end of a lane, as far as the roads have room. `kept` are the stations between
    /// which the outlines leave each road.
    pub fn new(network: &RoadNetwork, kept: &[Stations], restricted: &ResolvedRestrictions) -> Self {
        Self::begun(network, kept, restricted).cleared(network, restricted)
    }

    /// Cuts roads where the map says that vehicles stop. Around an intersection where more ways would run over the ends of
    /// lanes then, all stays as it is.
    #[must_use]
    pub fn with_stops(self, network: &RoadNetwork, restricted: &ResolvedRestrictions) -> Self {
        let mut stops = vec![[true; 2]; network.roads.len()];
        if connection_lines(network, &self.needs, &self.back, &stops, |road| Some(self.lines.cut(road)))
            .agree(&self.lines)
        {
            return self;
        }
        let (back, overrun) = (self.back.clone(), self.overrun(network).collect::<FxHashSet<RoadEnd>>());
        let mut draft = self;
        for round in 0..=ROUNDS_STOPPED {
            if round == ROUNDS_STOPPED {
                stops.fill([false; 2]);
            }
            draft.back.clone_from(&back);
            draft.stops.clone_from(&stops);
            draft = draft.redrawn(network, restricted, &[]).cleared(network, restricted);
            let more: Vec<RoadEnd> = draft.overrun(network).filter(|at| !overrun.contains(at)).collect();
            if more.is_empty() {
                break;
            }
            // What is drawn at both ends of a road depends on where either is cut.
            let around = |at: RoadEnd| network.intersection(network.road(at.road).intersection(at.end)).arms.iter();
            let roads: Vec<RoadIx> = more.into_iter().flat_map(around).map(|arm| arm.road).collect();
            roads.into_iter().for_each(|road| stops[road] = [false; 2]);
        }
        draft
    }

    /// Cuts roads back and draws again until no way runs over the end of a lane, as far as the roads have room.
    fn cleared(self, network: &RoadNetwork, restricted: &ResolvedRestrictions) -> Self {
        let mut draft = self;
        for _ in 0..ROUNDS {
            if !draft.cut_back() {
                break;
            }
            draft = draft.redrawn(network, restricted, &[]);
        }
        draft = draft.outlined(network, restricted);
        for _ in 0..ROUNDS_OUTLINED {
            if !draft.cut_clear(network) {
                break;
            }
            draft = draft.redrawn(network, restricted, &[]).outlined(network, restricted);
        }
        draft
    }

    /// Draws what changes where these roads have been laid at another height, and clears away all that was drawn and is not
    /// any more.
    #[must_use]
    pub fn relaid(self, network: &RoadNetwork, restricted: &ResolvedRestrictions, roads: &[RoadIx]) -> Self {
        let mut draft = self;
        if !roads.is_empty() {
            draft.joins.forget_points(roads);
            draft = draft.redrawn(network, restricted, roads).outlined(network, restricted);
        }
        draft.assembly.remove_released();
        draft
    }

    /// Draws everything, with the roads cut where their outlines ask for.
    fn begun(network: &RoadNetwork, kept: &[Stations], restricted: &ResolvedRestrictions) -> Self {
        let mut joins = Continuations::find(network);
        let needs = RequiredSetbacks::new(network, kept, |ix| joins.joined(ix));
        let (back, stops) = (vec![[0.0; 2]; network.roads.len()], vec![[false; 2]; network.roads.len()]);
        let lines = connection_lines(network, &needs, &back, &stops, |_| None);
        joins.set_gore_corners(gore_corners(network, &lines));
        let mut assembly = MapBuilder::default();
        let lanes = lanes(&mut assembly, network, &lines, &mut joins);
        let mut ways: Vec<Option<Box<IntersectionLanelets>>> = Vec::new();
        ways.resize_with(network.intersections.len(), || None);
        Self { joins, lines, assembly, lanes, ways, back, stops, needs }.complete(network, restricted)
    }

    /// Draws the roads whose cuts have moved, those that are to be drawn anew in any case, by their indices in order, and
    /// the ways that end there.
    fn redrawn(self, network: &RoadNetwork, restricted: &ResolvedRestrictions, anew: &[RoadIx]) -> Self {
        let Self { mut joins, lines: before, mut assembly, mut lanes, mut ways, back, stops, needs } = self;
        let lines = connection_lines(network, &needs, &back, &stops, |road| Some(before.cut(road)));
        let beside = joins.set_gore_corners(gore_corners(network, &lines));
        let redrawn = |road: &RoadIx| beside.contains(road) || anew.binary_search(road).is_ok();
        let moved = |road: &RoadIx| before.kept[*road] != lines.kept[*road] || redrawn(road);
        let moved: Vec<RoadIx> = (0..lines.kept.len()).map(RoadIx::new).filter(moved).collect();
        redraw(&mut assembly, network, &lines, &mut joins, &mut lanes, &moved);
        let cut = |lines: &ConnectionLines, at: &RoadEnd| lines.kept[at.road][at.end];
        for (slot, at) in ways.iter_mut().zip(&network.intersections) {
            let stays = at.arms.iter().all(|at| cut(&before, at) == cut(&lines, at) && !redrawn(&at.road));
            let elsewhere = || at.arms.iter().any(|at| moved.binary_search(&at.road).is_ok());
            match slot {
                Some(ways) if stays && !(ways.leans && elsewhere()) => ways.stood = true,
                _ => *slot = None,
            }
        }
        Self { joins, lines, assembly, lanes, ways, back, stops, needs }.complete(network, restricted)
    }

    /// Draws the ways that are not drawn yet, and their outlines where no way runs over a cut: else they are drawn again.
    fn complete(mut self, network: &RoadNetwork, restricted: &ResolvedRestrictions) -> Self {
        let Self { joins, lines, assembly, lanes, ways, .. } = &mut self;
        ways.par_iter_mut().finely().enumerate().filter(|(_, ways)| ways.is_none()).for_each(|(i, slot)| {
            let at = &network.intersections[i];
            if at.arms.len() < 2 || joins.joined(IntersectionIx::new(i)) {
                return;
            }
            let mut ways = IntersectionLanelets::draw(network, restricted, lanes, at, assembly);
            if at.arms.len() > 2 {
                ways.over = lane_end_overlap::depths(network, lines, lanes, assembly, at, &ways.drawn.paths);
            }
            if ways.over.is_empty() {
                ways = ways.outlined(network, restricted, lanes, at, assembly);
            }
            *slot = Some(Box::new(ways));
        });
        self
    }

    /// Outlines the ways that are not outlined yet.
    fn outlined(mut self, network: &RoadNetwork, restricted: &ResolvedRestrictions) -> Self {
        let Self { assembly, lanes, ways, .. } = &mut self;
        let bare =
            |ways: &Option<Box<IntersectionLanelets>>| ways.as_ref().is_some_and(|ways| ways.conflicts.is_none());
        let bare = ways.par_iter_mut().finely().zip(&network.intersections).filter(|(ways, _)| bare(ways));
        bare.for_each(|(slot, at)| {
            *slot = slot.take().map(|ways| Box::new(ways.outlined(network, restricted, lanes, at, assembly)));
        });
        // From here on outlines stay though roads are cut at their other ends.
        ways.iter_mut().flatten().for_each(|ways| ways.leans = false);
        self
    }

    /// The ends of roads whose lanes do not end on the outline around the ways there: some way runs over them.
    pub fn overrun<'a>(&'a self, network: &'a RoadNetwork) -> impl Iterator<Item = RoadEnd> + 'a {
        network.intersections.iter().zip(&self.ways).flat_map(|(at, ways)| {
            let area = ways.as_ref().and_then(|ways| ways.area.as_ref());
            area.into_iter().flat_map(|area| area.overrun.iter().map(|&arm| at.arms[arm]))
        })
    }

    /// What is left of a road between its cuts, metres.
    pub fn left(&self, road: RoadIx) -> f64 {
        let [from, to] = self.lines.kept[road];
        to - from
    }

    /// Cuts the ends of roads further back that ways run over; `false` if no road has room.
    fn cut_clear(&mut self, network: &RoadNetwork) -> bool {
        let overrun: Vec<RoadEnd> = self.overrun(network).collect();
        let mut raised = false;
        for at in overrun {
            let (road, side) = (at.road.position(), at.end.index());
            if self.left(at.road) >= ROAD_LEFT + CLEARING {
                let now = from_cut(self.lines.least[road], at.end, self.lines.kept[road][side]);
                self.back[road][side] = now + CLEARING;
                raised = true;
            }
        }
        raised
    }

    /// Cuts roads back so that every cut lies behind the ways that run over it; `false` if all do.
    fn cut_back(&mut self) -> bool {
        let mut raised = false;
        for (at, depth) in self.ways.iter().flatten().filter(|ways| !ways.stood).flat_map(|ways| &ways.over) {
            let (road, side) = (at.road.position(), at.end.index());
            let now = from_cut(self.lines.least[road], at.end, self.lines.kept[road][side]);
            let wanted = (now + depth + CLEAR).min(BACK_MOST);
            let back = &mut self.back[road][side];
            if wanted > *back + TOUCH {
                *back = wanted;
                raised = true;
            }
        }
        raised
    }
}
