//! Lanes for bicycles through an intersection: where a bicycle lane ends and another begins on the same side of the traffic,
//! straight ahead or around the corner beside it, a lanelet joins the two. Who turns across the traffic does so on foot, or
//! among it.

#[cfg(test)]
mod tests;

use crate::builder::lanes::side_lanes::{attributes, bounds};
use crate::builder::lanes::types::{ArmLane, Lanes};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::turn::{STRAIGHT, turn};
use crate::builder::network::turn_restrictions::ResolvedRestrictions;
use crate::builder::network::{End, Intersection, RoadEnd, RoadNetwork};
use crate::builder::tags::cross_section::{Arrows, CrossSection, StripKind};
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::side_strips::{StripRun, StripUse, strip_runs};
use crate::geometry::pose::Pose;
use crate::lanelet::{Attributes, Bound, PointId};
use crate::settings::BicycleLanes;

use super::movement_types::Movement;
use super::turn_centerline::{MovementEnds, turn_centerlines};
use super::turning_lanelets::{DrawnMovements, LaneletTags, TurningLanelet, intersection_key};

/// A turn up to this change of direction, degrees, leads around a corner; beyond, back.
const CORNER_MOST: f64 = 150.0;

/// A bicycle lane where it meets an intersection.
#[derive(Clone, Debug)]
struct BicycleLaneEnd {
    /// The arm, by index.
    arm: usize,
    /// Its end, in its direction of travel.
    end: ArmLane,
    /// On which edge of its road it lies, as who rides there sees it; `None` between lanes for cars.
    edge: Option<Edge>,
    /// The strips it is made of.
    run: StripRun,
}

/// An edge of a road.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Edge {
    Left,
    Right,
}

/// The bicycle lanes that lead into an intersection and out of it.
#[derive(Clone, Debug, Default)]
pub struct BicycleLaneEnds {
    into: Vec<BicycleLaneEnd>,
    out: Vec<BicycleLaneEnd>,
}

/// The bicycle lanes of an intersection, and the ways between them.
#[derive(Clone, Debug, Default)]
pub struct BicycleMovements {
    /// Where bicycle lanes end and begin.
    pub ends: BicycleLaneEnds,
    /// The ways, whose lanes are counted among those ends.
    pub paths: Vec<TurningLanelet>,
}

/// Whether roads with bicycle lanes meet; never where the settings leave those out.
pub fn has_bicycle_lanes(network: &RoadNetwork, intersection: &Intersection) -> bool {
    let ridden =
        |at: &RoadEnd| strip_runs(&network.road(at.road).section).iter().any(|run| run.used == StripUse::Bicycle);
    network.beside.bicycle_lanes != BicycleLanes::None && intersection.arms.iter().any(ridden)
}

impl BicycleLaneEnds {
    /// Finds them where an intersection is [`has_bicycle_lanes`].
    pub fn find(assembly: &MapBuilder, network: &RoadNetwork, lanes: &Lanes, intersection: &Intersection) -> Self {
        let mut found = Self::default();
        for (arm, &at) in intersection.arms.iter().enumerate() {
            let road = network.road(at.road);
            for run in strip_runs(&road.section) {
                for &backward in run.directions().iter().filter(|_| run.used == StripUse::Bicycle) {
                    let sides = bounds(assembly, road, lanes.borders_at(at), (&run, backward));
                    let into = backward == (at.end == End::Start);
                    let Some(end) = sides.and_then(|sides| end(assembly, lanes, at, sides, into)) else { continue };
                    let list = if into { &mut found.into } else { &mut found.out };
                    list.push(BicycleLaneEnd { arm, end, edge: edge(&road.section, &run, backward), run: run.clone() });
                }
            }
        }
        found
    }

    /// Whether none leads through.
    pub fn is_empty(&self) -> bool {
        self.into.is_empty() || self.out.is_empty()
    }

    /// The ends that lead in over an arm, with their index among all of them.
    pub fn into_of(&self, arm: usize) -> impl Iterator<Item = (usize, &ArmLane)> {
        self.into.iter().enumerate().filter(move |(_, cycle)| cycle.arm == arm).map(|(i, cycle)| (i, &cycle.end))
    }

    /// Which leads to which: of several on one arm the one least far sideways.
    fn joined(
        &self,
        side: DrivingSide,
        restricted: &ResolvedRestrictions,
        intersection: &Intersection,
        wanted: BicycleTurns,
    ) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for (i, from) in self.into.iter().enumerate() {
            for to in 0..intersection.arms.len() {
                let arms = [intersection.arms[from.arm], intersection.arms[to]];
                let leads = |o: &usize| {
                    let to = &self.out[*o];
                    let turn = turn(side, from.end.pose.heading, to.end.pose.heading);
                    let own = match from.edge {
                        Some(Edge::Left) => turn,
                        Some(Edge::Right) => -turn,
                        None => f64::NAN,
                    };
                    let corner = wanted == BicycleTurns::All && (STRAIGHT..=CORNER_MOST).contains(&own);
                    (turn.abs() <= STRAIGHT || corner) && from.keeps_to(to)
                };
                let sideways = |o: &usize| {
                    let way = self.out[*o].end.pose.point - from.end.pose.point;
                    crate::geometry::cross(from.end.pose.heading, way).abs()
                };
                let outs = (0..self.out.len()).filter(|&o| to != from.arm && self.out[o].arm == to).filter(leads);
                let best = outs.min_by(|a, b| sideways(a).total_cmp(&sideways(b)));
                pairs.extend(
                    best.filter(|_| restricted.permit_bicycles(intersection, arms[0], arms[1])).map(|o| (i, o)),
                );
            }
        }
        pairs
    }

    /// Adds the lanelets between them to those of an intersection.
    pub fn draw(
        &self,
        assembly: &mut MapBuilder,
        network: &RoadNetwork,
        restricted: &ResolvedRestrictions,
        intersection: &Intersection,
        wanted: BicycleTurns,
        beside: &DrawnMovements,
    ) -> DrawnMovements {
        let mut drawn = DrawnMovements { bounds: beside.bounds.clone(), ..DrawnMovements::default() };
        let movement =
            |i: usize, o: usize| Movement { from: self.into[i].arm, to: self.out[o].arm, in_lane: i, out_lane: o };
        let pairs = self.joined(network.side, restricted, intersection, wanted);
        let ends: Vec<MovementEnds> =
            pairs.iter().map(|&(i, o)| (movement(i, o), &self.into[i].end, &self.out[o].end)).collect();
        let passed = intersection.arms.len() > 2;
        let bound = |_: &MapBuilder, _: &ArmLane, _: usize| match passed {
            true => Attributes::of(&[("type", "virtual")]),
            false => Attributes::of(&[("type", "line_thin"), ("subtype", "solid"), ("lane_change", "no")]),
        };
        let lanelet = |_: &MapBuilder, (movement, _, _): &MovementEnds, _: StripKind| -> Attributes {
            let BicycleLaneEnd { arm, run, .. } = &self.into[movement.in_lane];
            attributes(network.road(intersection.arms[*arm].road), run, &network.beside)
        };
        let key = intersection_key("cycle path", intersection);
        let courses = ends.iter().copied().zip(turn_centerlines(&ends)).collect();
        drawn.add(assembly, network.side, key, courses, &LaneletTags { bound: &bound, lanelet: &lanelet });
        drawn
    }
}

impl BicycleLaneEnd {
    /// Whether nobody crosses the lanes for cars who goes on here.
    fn keeps_to(&self, to: &Self) -> bool {
        self.edge.zip(to.edge).is_none_or(|(from, to)| from == to)
    }
}

/// The edge of a road on which a run lies, seen in its own direction.
fn edge(section: &CrossSection, run: &StripRun, backward: bool) -> Option<Edge> {
    let left = section.driven().all(|(driven, _)| driven >= run.strips.end);
    let right = section.driven().all(|(driven, _)| driven < run.strips.start);
    (left != right).then_some(if left != backward { Edge::Left } else { Edge::Right })
}

/// Which ways through an intersection are drawn for bicycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BicycleTurns {
    /// Straight on, and around the corner beside them.
    All,
    /// Straight on.
    Straight,
}

/// The end of a bicycle lane between two bounds, in its direction of travel.
fn end(assembly: &MapBuilder, lanes: &Lanes, at: RoadEnd, sides: [Bound; 2], into: bool) -> Option<ArmLane> {
    let node = |bound: Bound| -> Option<PointId> {
        let ids = assembly.bound_ids(bound);
        if into { ids.last().copied() } else { ids.first().copied() }
    };
    let nodes = [node(sides[0])?, node(sides[1])?];
    let [left, right] = nodes.map(|id| assembly.position(id));
    let arm = lanes.arm(at);
    let heading = if into { arm.inward } else { -arm.inward };
    // The lane beside it stands for its road.
    let lane = arm.into.iter().chain(&arm.out).map(|lane| lane.lane).next()?;
    Some(ArmLane {
        lane,
        nodes,
        places: [left, right],
        pose: Pose { point: nalgebra::center(&left, &right), heading },
        width: (left - right).norm(),
        kind: StripKind::Bicycle,
        arrows: Arrows::NONE,
    })
}
