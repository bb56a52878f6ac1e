//! What decides who yields at an intersection: the control of each arm, and for each turning lanelet who drives it.

use super::intersection::IntersectionAssembly;
use crate::builder::control::priority_road::{PriorityArm, give_way};
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Arm;
use crate::builder::network::approach_control::{Control, sign_at};
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::builder::network::{Intersection, Road, RoadNetwork};
use crate::builder::tags::cross_section::StripKind;
use crate::builder::tags::road_class::{DrivingSide, is_priority_road};
use crate::lanelet::right_of_way::{RankedMovement, Turn};

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

    pub(super) fn ranked_movements(
        &self,
        arms: &[&Arm],
        paths: &[TurningLanelet],
        controls: &[Control],
        legs: &[usize],
    ) -> Vec<RankedMovement> {
        let ranks = Approaches { network: self.context.network, arms, controls, legs }.priorities();
        let near = if self.context.network.side == DrivingSide::Left { 1.0 } else { -1.0 };
        paths
            .iter()
            .map(|path| {
                let arm = path.movement.from;
                let turn = match path.turn * near {
                    t if t.abs() <= STRAIGHT_ON => Turn::Straight,
                    t if t > 0.0 => Turn::Near,
                    _ => Turn::Far,
                };
                let signalised = controls[arm] == Control::Signals;
                let bicycle = path.kind == StripKind::Bicycle;
                let priority = ranks.as_ref().map(|ranks| ranks[arm]);
                // Where some arms have lights, those without give way to them.
                RankedMovement { arm, turn, signalised, controlled: true, priority, bicycle }
            })
            .collect()
    }
}
