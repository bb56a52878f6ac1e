//! Rights of way at an intersection: what controls its arms, which vehicles go first, and which lanelets each lanelet may ignore.

use crate::builder::control::priority_road::{PriorityArm, give_way};
use crate::builder::ids::Key;
use crate::builder::intersection::conflict::Conflicts;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::approach_control::{Control, sign_at};
use crate::builder::network::turn_angle::STRAIGHT;
use crate::builder::network::{Intersection, Road, RoadNetwork};
use crate::builder::tags::cross_section::StripKind;
use crate::builder::tags::road_class::{DrivingSide, is_priority_road};
use crate::geometry::{Vector, angle_between};
use crate::lanelet::index::{Crossed, Edge, legs};
use crate::lanelet::right_of_way::{Mover, OPPOSITE, Relation, Turn, opposites, yields};
use crate::lanelet::{PointId, Target};

use super::intersection::IntersectionAssembly;

/// The approaches of an intersection.
struct Approaches<'a> {
    network: &'a RoadNetwork,
    arms: &'a [&'a Arm],
    /// What controls each arm.
    controls: &'a [Control],
    /// For each arm the first one of its leg.
    legs: &'a [usize],
}

impl Approaches<'_> {
    /// Per arm, whether its vehicles go first; `None` if the vehicles of no arm do, or those of all arms.
    fn priorities(&self) -> Option<Vec<bool>> {
        let arms = 0..self.arms.len();
        let on_priority_road = give_way(&arms.clone().map(|arm| self.priority_arm(arm)).collect::<Vec<_>>());
        // If some arms have lights, the others give way to them.
        let lights = self.controls.contains(&Control::Signals);
        let first = |arm: usize| {
            let unlit = lights && self.controls[arm] != Control::Signals;
            let crosses_priority = on_priority_road.as_ref().is_some_and(|gives_way| gives_way[arm]);
            let from_private = self.is_private(arm) && !self.is_beside_street(arm);
            !(self.is_signed(arm) || from_private || crosses_priority || unlit)
        };
        let first: Vec<bool> = arms.map(first).collect();
        let mut leading_in = first.iter().zip(self.arms).filter(|(_, arm)| !arm.into.is_empty());
        let (some, other) = (leading_in.clone().any(|(first, _)| *first), leading_in.any(|(first, _)| !first));
        (some && other).then_some(first)
    }

    fn priority_arm(&self, arm: usize) -> PriorityArm {
        PriorityArm {
            leg: self.legs[arm],
            priority_road: is_priority_road(&self.road(arm).tags),
            leads_in: !self.arms[arm].into.is_empty(),
            signed: self.is_signed(arm),
        }
    }

    /// Whether a street leads in side by side with a driveway, as part of the same leg.
    fn is_beside_street(&self, arm: usize) -> bool {
        let mut beside = (0..self.arms.len()).filter(|other| self.legs[*other] == self.legs[arm]);
        beside.any(|other| !self.is_private(other) && !self.is_signed(other))
    }

    fn is_signed(&self, arm: usize) -> bool {
        matches!(self.controls[arm], Control::Stop | Control::GiveWay)
    }

    fn is_private(&self, arm: usize) -> bool {
        !self.road(arm).public
    }

    fn road(&self, arm: usize) -> &Road {
        self.network.road(self.arms[arm].at.road)
    }
}

impl IntersectionAssembly<'_> {
    pub(super) fn controls(&self, intersection: &Intersection, arms: &[&Arm]) -> Vec<Control> {
        arms.iter()
            .map(|arm| match (intersection.signals, intersection.all_way_stop) {
                (true, _) => Control::Signals,
                _ if self.context.guarded.binary_search(&arm.at).is_ok() => Control::Signals,
                (false, true) => Control::Stop,
                (false, false) => sign_at(self.context.network.road(arm.at.road), arm.at.end),
            })
            .collect()
    }

    pub(super) fn movers(
        &self,
        arms: &[&Arm],
        paths: &[TurningLanelet],
        controls: &[Control],
        legs: &[usize],
    ) -> Vec<Mover> {
        let ranks = Approaches { network: self.context.network, arms, controls, legs }.priorities();
        let near = if self.context.network.side == DrivingSide::Left { 1.0 } else { -1.0 };
        paths
            .iter()
            .map(|path| {
                let arm = path.movement.from;
                let turn = match path.turn * near {
                    t if t.abs() <= STRAIGHT => Turn::Straight,
                    t if t > 0.0 => Turn::Near,
                    _ => Turn::Far,
                };
                let signalised = controls[arm] == Control::Signals;
                let bicycle = path.kind == StripKind::Bicycle;
                let priority = ranks.as_ref().map(|ranks| ranks[arm]);
                // Where some arms have lights, those without give way to them.
                Mover { arm, turn, signalised, controlled: true, priority, bicycle }
            })
            .collect()
    }
}

/// For each arm, the first arm of its leg. Carriageways on both sides of a median, or side by side, are one leg.
pub(crate) fn legs_of(assembly: &MapBuilder, arms: &[&Arm]) -> Vec<usize> {
    let place = |ids: [PointId; 2]| Edge { ids, points: ids.map(|id| assembly.position(id)) };
    let mut edges: Vec<(usize, Crossed)> = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let lanes = arm.into.iter().map(|lane| (lane, true)).chain(arm.out.iter().map(|lane| (lane, false)));
        edges.extend(lanes.map(|(lane, inward)| {
            let for_cars = lane.kind == StripKind::Drive;
            (i, Crossed { edge: place(lane.nodes), inward, for_cars })
        }));
    }
    let crossed: Vec<Crossed> = edges.iter().map(|(_, edge)| *edge).collect();
    let mut first: Vec<usize> = (0..arms.len()).collect();
    for (&(arm, _), leg) in edges.iter().zip(legs(&crossed)) {
        first[arm] = first[arm].min(edges[leg].0);
    }
    first
}

/// Adds a `right_of_way` element for each lanelet that may ignore others.
pub(crate) fn rights_of_way(
    assembly: &mut MapBuilder,
    legs: &[usize],
    paths: &[TurningLanelet],
    movers: &[Mover],
    conflicts: &Conflicts,
) {
    let heading_of = headings(legs, paths);
    let opposite = opposites(&heading_of, OPPOSITE);
    let legs = legs_by_light(legs, paths, &heading_of);
    let relation = |x: usize, y: usize| match [x, y].map(|mover| legs[movers[mover].arm]) {
        [a, b] if a == b => Relation::Same,
        [a, b] if opposite[a] == Some(b) => Relation::InPhase,
        _ => Relation::AntiPhase,
    };
    for (x, path) in paths.iter().enumerate() {
        // Autoware's routing graph for cars has no bus lanes, so it does not watch them.
        let watched: Vec<usize> =
            conflicts.real[x].iter().copied().filter(|&y| paths[y].kind != StripKind::Bus).collect();
        let mut yields = yields(x, movers, &watched, relation);
        // Autoware would wait for lanelets that only touch this one.
        if !(movers[x].signalised && movers[x].turn == Turn::Straight) {
            yields.extend(conflicts.touching(x).filter(|&y| paths[y].kind != StripKind::Bus));
            yields.sort_unstable();
        }
        if yields.is_empty() {
            continue;
        }
        let mut members = vec![("right_of_way", Target::Lanelet(path.lanelet))];
        members.extend(yields.iter().map(|&y| ("yield", Target::Lanelet(paths[y].lanelet))));
        let key = Key::new("right of way").number(path.lanelet.0);
        assembly.element(key, "right_of_way", &members, &[path.lanelet]);
    }
}

/// For the first arm of each leg, the unit direction of the cars that arrive there; `None` if no car arrives, and for all
/// other arms. Two legs are opposite only if cars arrive on both: otherwise a bus road in the middle of a street would be
/// opposite to the street's own cars.
pub(crate) fn headings(legs: &[usize], paths: &[TurningLanelet]) -> Vec<Option<Vector>> {
    (0..legs.len()).map(|leg| heading(legs, paths, leg, StripKind::Drive)).collect()
}

/// The unit direction of the vehicles of one kind that arrive on a leg; `None` if none arrives.
fn heading(legs: &[usize], paths: &[TurningLanelet], leg: usize, kind: StripKind) -> Option<Vector> {
    let arriving = paths.iter().filter(|path| legs[path.movement.from] == leg && path.kind == kind);
    arriving.map(|path| path.heading).sum::<Vector>().try_normalize(f64::EPSILON)
}

/// For each arm, the leg whose lights its vehicles obey. Buses on a road of their own have green with the cars of the same
/// direction, so that neither ignores vehicles that may have green at the same time.
fn legs_by_light(legs: &[usize], paths: &[TurningLanelet], headings: &[Option<Vector>]) -> Vec<usize> {
    let with_cars = |leg: usize| -> usize {
        if headings[leg].is_some() {
            return leg;
        }
        let Some(buses) = heading(legs, paths, leg, StripKind::Bus) else { return leg };
        let off = |(at, cars): (usize, &Option<Vector>)| Some((angle_between(buses, (*cars)?).abs().to_degrees(), at));
        let nearest = headings.iter().enumerate().filter_map(off).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.filter(|(off, _)| *off <= OPPOSITE).map_or(leg, |(_, at)| at)
    };
    legs.iter().map(|&leg| with_cars(leg)).collect()
}
