//! Lanes that the streets leave without a way on: the notes of them, and their lanelets for the settings beside the map.

use crate::builder::intersection::movement::ending_centre_lanes;
use crate::builder::intersection::movement_types::Movement;
use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::network::Intersection;
use crate::diagnostic::{Finding, Place, Subject};
use crate::settings::LooseEnds;

use super::map_context::MapContext;

/// Lanes without a way on at some intersections.
#[derive(Default)]
pub(super) struct LooseLanes {
    pub(super) notes: Vec<Finding>,
    pub(super) lanelets: LooseEnds,
}

impl LooseLanes {
    /// Those at the dead ends of one-way streets, and where the data end. Where a street has both directions, vehicles turn.
    pub(super) fn of_dead_ends(context: &MapContext) -> Self {
        let mut loose = Self::default();
        for dead_end in context.network.intersections.iter().filter(|it| it.arms.len() == 1) {
            let arm = context.lanes.arm(dead_end.arms[0]);
            let lanes = if arm.out.is_empty() { &arm.into } else { &arm.out };
            if arm.into.is_empty() || arm.out.is_empty() {
                lanes.iter().for_each(|lane| loose.add(context, dead_end, (arm, lane), arm.out.is_empty()));
            }
        }
        loose
    }

    /// The lanes that no movement leaves or reaches, but for lanes for turns in the middle of a road.
    pub(super) fn of_intersection(
        context: &MapContext,
        intersection: &Intersection,
        arms: &[&Arm],
        movements: &[Movement],
    ) -> Self {
        let mut loose = Self::default();
        let centre_lanes = ending_centre_lanes(arms);
        for (i, arm) in arms.iter().enumerate() {
            let [ending_in, beginning_out] = &centre_lanes[i];
            let led_on = |lane: usize| movements.iter().any(|m| (m.from, m.in_lane) == (i, lane));
            let led_to = |lane: usize| movements.iter().any(|m| (m.to, m.out_lane) == (i, lane));
            let ends = arm.into.iter().enumerate().filter(|(lane, _)| !led_on(*lane) && !ending_in.contains(lane));
            ends.for_each(|(_, lane)| loose.add(context, intersection, (arm, lane), true));
            let begins = arm.out.iter().enumerate().filter(|(lane, _)| !led_to(*lane) && !beginning_out.contains(lane));
            begins.for_each(|(_, lane)| loose.add(context, intersection, (arm, lane), false));
        }
        loose
    }

    fn add(&mut self, context: &MapContext, at: &Intersection, (arm, lane): (&Arm, &ArmLane), ends: bool) {
        let lanelets = if ends { &mut self.lanelets.ends } else { &mut self.lanelets.starts };
        lanelets.insert(context.lanes.lanes[lane.lane].lanelet.0);
        if at.map_edge {
            return;
        }
        let (way, node) = (context.network.road(arm.at.road).key.way, at.first_node());
        let whither = if ends { "on from" } else { "to" };
        let message = format!("No road leads {whither} a lane of way {way} at node {node}: is a one-way missing?");
        let finding = Finding::new("lane-closed", Subject::Way(way), message);
        self.notes.push(finding.with(Subject::Node(node), "there").at(Place::Point(at.position)));
    }
}
