//! Crosswalks: each is drawn if vehicles drive over it, and announced to the lanes that it crosses.

use rustc_hash::FxHashMap;

use crate::builder::control::crosswalk::{announce, crosswalk};
use crate::builder::control::pedestrian_signals::pedestrian_signals;
use crate::builder::lanes::road_cut::{ConnectionLines, RoadCrossing};
use crate::builder::lanes::types::Lanes;
use crate::builder::layout::map_layout::IntersectionLanelets;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::{Intersection, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::streets::heights::Ground;
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::lanelet::{LaneletId, PointId};

/// The crosswalks of a map, found by road.
#[derive(Default)]
pub(super) struct Crossings {
    of_road: FxHashMap<RoadIx, Vec<(RoadCrossing, LaneletId)>>,
}

/// What lies under a crosswalk.
enum Under<'a> {
    /// A road, between its cuts.
    Road,
    /// An intersection in which two roads meet face to face, lane by lane.
    Continuation(&'a Intersection),
    /// An intersection; the crosswalk is announced to its lanelets when they are finished.
    Intersection(&'a Intersection),
}

impl Crossings {
    /// Adds the crosswalks over which vehicles drive and announces them to the lanes of roads; also gives a note for each other
    /// crosswalk.
    pub(super) fn add(
        assembly: &mut MapBuilder,
        network: &RoadNetwork,
        lines: &ConnectionLines,
        lanes: &Lanes,
        turning: &[Option<Box<IntersectionLanelets>>],
    ) -> (Self, Vec<Finding>) {
        let (mut all, mut left_out) = (Self::default(), Vec::new());
        for crossing in lines.crossings.iter().filter(|crossing| crossing.lights_only.is_none()) {
            let Some(under) = under(crossing, network, turning) else {
                left_out.push(idle(crossing, network));
                continue;
            };
            let id = draw(assembly, network, lanes, crossing, &under);
            let over: Vec<RoadIx> = match under {
                Under::Road => vec![crossing.road],
                Under::Continuation(at) => at.arms.iter().map(|arm| arm.road).collect(),
                Under::Intersection(_) => Vec::new(),
            };
            let over = over.into_iter().flat_map(|road| lanes.of_road(road)).map(|lane| lane.lanelet);
            announce_to(assembly, id, over);
            all.of_road.entry(crossing.road).or_default().push((crossing.clone(), id));
        }
        assembly.set_ground(Ground::default());
        (all, left_out)
    }

    /// The crosswalks over the end of a road at an intersection.
    pub(super) fn at(&self, arm: RoadEnd) -> impl Iterator<Item = LaneletId> {
        let of_road = self.of_road.get(&arm.road).into_iter().flatten();
        of_road.filter(move |(crossing, _)| crossing.arm == Some(arm.end)).map(|(_, id)| *id)
    }
}

/// What a crosswalk lies over; `None` if no vehicle drives there.
fn under<'a>(
    crossing: &RoadCrossing,
    network: &'a RoadNetwork,
    turning: &[Option<Box<IntersectionLanelets>>],
) -> Option<Under<'a>> {
    let Some(end) = crossing.arm else { return Some(Under::Road) };
    let ix = network.road(crossing.road).intersection(end);
    let at = network.intersection(ix);
    let Some(turning) = &turning[ix] else { return Some(Under::Continuation(at)) };
    let arm = RoadEnd { road: crossing.road, end };
    turning.lead_over(at, arm, network.beside.bicycle_lanes).then_some(Under::Intersection(at))
}

/// Draws a crosswalk with its lights.
fn draw(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lanes: &Lanes,
    crossing: &RoadCrossing,
    under: &Under,
) -> LaneletId {
    let road = network.road(crossing.road);
    assembly.set_ground(match under {
        Under::Road => Ground::under(road),
        Under::Continuation(at) | Under::Intersection(at) => lanes.ground_of(at, assembly),
    });
    let cuts: Vec<PointId> = lanes.arms[crossing.road].iter().flat_map(|arm| &arm.cut).copied().collect();
    let id = crosswalk(assembly, road, crossing, &cuts);
    pedestrian_signals(assembly, road, crossing, id);
    id
}

/// Announces a crosswalk to those of these lanelets that it crosses.
pub(super) fn announce_to(assembly: &mut MapBuilder, crosswalk: LaneletId, lanelets: impl Iterator<Item = LaneletId>) {
    let over: Vec<_> = lanelets.map(|lanelet| (lanelet, assembly.outline(lanelet))).collect();
    announce(assembly, crosswalk, over.iter().map(|(id, outline)| (*id, &outline[..])));
}

/// The note that no vehicle drives over a crosswalk at the end of a road.
fn idle(crossing: &RoadCrossing, network: &RoadNetwork) -> Finding {
    let road = network.road(crossing.road);
    let (node, way) = (crossing.node, road.key.way);
    let message = format!("Nobody drives over the crosswalk at node {node} of way {way}: it is left out.");
    let finding = Finding::new("crosswalk-idle", Subject::Node(node), message).graded(Severity::Info);
    finding.with(Subject::Way(way), "road").at(Place::Point(road.line.at(crossing.station)))
}
