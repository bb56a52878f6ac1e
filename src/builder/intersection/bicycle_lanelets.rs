//! Bicycle lanelets through an intersection. They join bicycle lanes on the same side of the traffic, straight on or around the
//! corner beside them. Bicycles turn across the traffic on foot, or among the cars.

#[cfg(test)]
mod tests;

use crate::builder::lanes::side_lanes::{attributes, bounds};
use crate::builder::lanes::types::{ArmLane, Lanes};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::turn_angle::{STRAIGHT_ON, turn};
use crate::builder::network::{End, Intersection, RoadEnd, RoadNetwork};
use crate::builder::tags::cross_section::{CrossSection, StripKind};
use crate::builder::tags::marking::unpainted;
use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::side_strips::{StripRun, StripUse, strip_runs};
use crate::geometry::{Point, Polyline, cross};
use crate::lanelet::index::center_line;
use crate::lanelet::{Attributes, Bound, PointId};
use crate::settings::BicycleLanes;

use super::movement_types::Movement;
use super::turn_centerline::{MovementEnds, turn_centerlines};
use super::turning_lanelets::{DrawnMovements, TurningLanelet, TurningTags, intersection_key};

/// A turn up to this change of direction, degrees, leads around a corner; beyond, it leads back.
const CORNER_MOST: f64 = 150.0;
/// The width of a bicycle lanelet differs from a linear change between its ends by at most this part of its median: one that is
/// squeezed by the lanelets beside it, or fills a gap between them, is no lane.
const UNEVEN_MOST: f64 = 0.5;
/// The distance between the places at which the width is measured, metres.
const WIDTH_EVERY: f64 = 1.0;

/// The end of a bicycle lane at an intersection.
#[derive(Clone, Debug)]
struct BicycleLaneEnd {
    /// The arm, by index.
    arm: usize,
    /// In its direction of travel.
    end: ArmLane,
    /// The edge of the road on which it lies, seen in its direction; `None` between lanes for cars.
    edge: Option<Edge>,
    /// Its strips.
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

/// The bicycle lanes of an intersection, and the lanelets between them.
#[derive(Clone, Debug, Default)]
pub struct BicycleMovements {
    /// Where bicycle lanes end and begin.
    pub ends: BicycleLaneEnds,
    /// The lanelets; their movements have the indices of those ends.
    pub paths: Vec<TurningLanelet>,
}

/// Whether roads with bicycle lanes meet; `false` if the settings leave those out.
pub fn has_bicycle_lanes(network: &RoadNetwork, intersection: &Intersection) -> bool {
    let mut runs = intersection.arms.iter().flat_map(|at| strip_runs(&network.road(at.road).section));
    network.beside.bicycle_lanes != BicycleLanes::None && runs.any(|run| run.used == StripUse::Bicycle)
}

impl BicycleLaneEnds {
    /// Finds them where an intersection [`has_bicycle_lanes`].
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

    /// Whether none lead in, or none lead out.
    pub fn is_empty(&self) -> bool {
        self.into.is_empty() || self.out.is_empty()
    }

    /// The ends that lead in over an arm, with their index among all of them.
    pub fn leading_in(&self, arm: usize) -> impl Iterator<Item = (usize, &ArmLane)> {
        self.into.iter().enumerate().filter(move |(_, lane)| lane.arm == arm).map(|(i, lane)| (i, &lane.end))
    }

    /// Those on an arm, in either direction.
    pub fn of_arm(&self, arm: usize) -> impl Iterator<Item = &ArmLane> {
        self.into.iter().chain(&self.out).filter(move |lane| lane.arm == arm).map(|lane| &lane.end)
    }

    /// The movements between them: to every other arm over the lane that lies least sideways.
    pub fn movements(
        &self,
        side: DrivingSide,
        restrictions: &ResolvedRestrictions,
        intersection: &Intersection,
        turns: BicycleTurns,
    ) -> Vec<Movement> {
        let arms = &intersection.arms;
        let mut movements = Vec::new();
        for (in_lane, from) in self.into.iter().enumerate() {
            let sideways = |(_, to): &(usize, &BicycleLaneEnd)| {
                cross(from.end.pose.heading, to.end.pose.point - from.end.pose.point).abs()
            };
            for to in (0..arms.len()).filter(|&to| to != from.arm) {
                let outs = self.out.iter().enumerate().filter(|(_, out)| out.arm == to);
                let outs = outs.filter(|(_, out)| from.leads_to(side, out, turns));
                let best = outs.min_by(|a, b| sideways(a).total_cmp(&sideways(b)));
                let best = best.filter(|_| restrictions.permit_bicycles(intersection, arms[from.arm], arms[to]));
                movements.extend(best.map(|(out_lane, _)| Movement { from: from.arm, to, in_lane, out_lane }));
            }
        }
        movements
    }

    /// Adds the lanelets of these movements to those of an intersection for vehicles.
    pub fn draw(
        &self,
        assembly: &mut MapBuilder,
        network: &RoadNetwork,
        intersection: &Intersection,
        movements: &[Movement],
        vehicles: &DrawnMovements,
    ) -> DrawnMovements {
        let mut drawn = DrawnMovements { bounds: vehicles.bounds.clone(), ..DrawnMovements::default() };
        let ends: Vec<MovementEnds> =
            movements.iter().map(|&m| (m, &self.into[m.in_lane].end, &self.out[m.out_lane].end)).collect();
        let key = intersection_key("cycle path", intersection);
        let centerlines = ends.iter().copied().zip(turn_centerlines(&ends, |_, _| None)).collect();
        drawn.add(assembly, network.side, key, centerlines, &BicycleTags { network, intersection, ends: self });
        drawn
    }

    /// The drawn movements whose lanelets do not keep their width.
    pub fn uneven(&self, drawn: &DrawnMovements) -> Vec<Movement> {
        let is_uneven = |movement: &Movement| {
            let [from, to] = [&self.into[movement.in_lane].end, &self.out[movement.out_lane].end].map(|end| end.nodes);
            let places = |side: usize| drawn.bounds.line(from[side], to[side]).map(|line| line.places(from[side]));
            places(0).zip(places(1)).is_some_and(|(left, right)| !is_even([&left, &right]))
        };
        drawn.paths.iter().map(|path| path.movement).filter(is_uneven).collect()
    }
}

/// Whether a lanelet between two bounds keeps the widths of its ends. It is true of a lanelet without length.
fn is_even([left, right]: [&[Point]; 2]) -> bool {
    let Some(center) = center_line(left, right) else { return true };
    let places = center.resampled(WIDTH_EVERY);
    let lines = [left, right].map(|bound| Polyline::new(bound.iter().copied()));
    let width = |place: &Point| lines.iter().flatten().map(|line| line.distance(*place)).sum::<f64>();
    let widths: Vec<f64> = places.points().iter().map(width).collect();
    let [Some(first), Some(last)] = [widths.first(), widths.last()] else { return true };
    let mut sorted = widths.clone();
    sorted.sort_by(f64::total_cmp);
    let (most, pieces) = (UNEVEN_MOST * sorted[sorted.len() / 2], (widths.len() - 1).max(1) as f64);
    widths.iter().zip(0..).all(|(width, i)| (width - first - (last - first) * f64::from(i) / pieces).abs() <= most)
}

/// The tags of turning lanelets for bicycles.
struct BicycleTags<'a> {
    network: &'a RoadNetwork,
    intersection: &'a Intersection,
    ends: &'a BicycleLaneEnds,
}

impl TurningTags for BicycleTags<'_> {
    fn bound(&self, _: &MapBuilder, _: &MovementEnds, _: usize) -> Attributes {
        match self.intersection.arms.len() > 2 {
            true => unpainted(),
            false => Attributes::of(&[("type", "line_thin"), ("subtype", "solid"), ("lane_change", "no")]),
        }
    }

    fn lanelet(&self, _: &MapBuilder, (movement, ..): &MovementEnds, _: StripKind) -> Attributes {
        let BicycleLaneEnd { arm, run, .. } = &self.ends.into[movement.in_lane];
        attributes(self.network.road(self.intersection.arms[*arm].road), run, &self.network.beside)
    }
}

impl BicycleLaneEnd {
    /// Whether the way to another end crosses no lane for cars, and leads straight on or, if `turns` has them, around the corner
    /// on the side of its edge.
    fn leads_to(&self, side: DrivingSide, to: &Self, turns: BicycleTurns) -> bool {
        let turn = turn(side, self.end.pose.heading, to.end.pose.heading);
        let toward_edge = match self.edge {
            Some(Edge::Left) => turn,
            Some(Edge::Right) => -turn,
            None => f64::NAN,
        };
        let corner = turns == BicycleTurns::All && (STRAIGHT_ON..=CORNER_MOST).contains(&toward_edge);
        (turn.abs() <= STRAIGHT_ON || corner) && self.edge.zip(to.edge).is_none_or(|(from, to)| from == to)
    }
}

/// The edge of a road on which a run lies, seen in the direction of its lanelet.
fn edge(section: &CrossSection, run: &StripRun, backward: bool) -> Option<Edge> {
    let left = section.driven().all(|(driven, _)| driven >= run.strips.end);
    let right = section.driven().all(|(driven, _)| driven < run.strips.start);
    (left != right).then_some(if left != backward { Edge::Left } else { Edge::Right })
}

/// Which movements bicycles have through an intersection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BicycleTurns {
    /// Straight on, and around the corner beside them.
    All,
    /// Straight on.
    Straight,
}

/// The end of a bicycle lane between two bounds, in its direction of travel.
fn end(assembly: &MapBuilder, lanes: &Lanes, at: RoadEnd, [left, right]: [Bound; 2], into: bool) -> Option<ArmLane> {
    let node = |bound: Bound| -> Option<PointId> {
        let ids = assembly.bound_ids(bound);
        if into { ids.last().copied() } else { ids.first().copied() }
    };
    let arm = lanes.arm(at);
    // A lane for cars stands for its road.
    let ArmLane { lane, straight, .. } = *arm.into.iter().chain(&arm.out).next()?;
    let heading = if into { arm.inward } else { -arm.inward };
    let end = ArmLane::new(assembly, lane, [node(left)?, node(right)?], heading, StripKind::Bicycle);
    Some(ArmLane { straight, ..end })
}
