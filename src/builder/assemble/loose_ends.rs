//! Lanes that the streets leave without a way on: the notes of them, and their lanelets for the settings beside the map.

use crate::builder::intersection::movement::ending_centre_lanes;
use crate::builder::intersection::movement_types::Movement;
use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::network::{ClosedBy, Intersection};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::settings::LooseEnds;

use super::map_context::MapContext;

/// Lanes without a way on at some intersections.
#[derive(Default)]
pub(super) struct LooseLanes {
    pub(super) notes: Vec<Finding>,
    /// Those of them for which no road leads on.
    pub(super) lanelets: LooseEnds,
}

impl LooseLanes {
    /// Those at the dead ends of one-way streets, where the data end, and where restrictions forbid every turn. Where a street has both
    /// directions, vehicles turn.
    pub(super) fn of_dead_ends(context: &MapContext) -> Self {
        let mut loose = Self::default();
        for dead_end in context.network.intersections.iter().filter(|it| it.arms.len() == 1) {
            let arm = context.lanes.arm(dead_end.arms[0]);
            let (lanes, ends) = if arm.out.is_empty() { (&arm.into, true) } else { (&arm.out, false) };
            let by_input = !matches!(dead_end.closed_by, Some(ClosedBy::Angle | ClosedBy::Room));
            if !by_input || !arm.into.is_empty() && !arm.out.is_empty() {
                continue;
            }
            lanes.iter().for_each(|lane| loose.name(context, lane, ends));
            if !dead_end.map_edge && dead_end.closed_by.is_none() {
                loose.note_dead_end(context, dead_end, arm, ends);
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
            for (lanes, ending, ends) in [(&arm.into, ending_in, true), (&arm.out, beginning_out, false)] {
                let uses = |m: &Movement, lane: usize| {
                    let of_arm = if ends { (m.from, m.in_lane) } else { (m.to, m.out_lane) };
                    of_arm == (i, lane)
                };
                let is_loose = |lane: &usize| !ending.contains(lane) && !movements.iter().any(|m| uses(m, *lane));
                let mut others = (0..arms.len()).filter(|&other| other != i).map(|other| arms[other]);
                let leads_on = others.any(|other| !if ends { &other.out } else { &other.into }.is_empty());
                for lane in (0..lanes.len()).filter(is_loose) {
                    loose.note(context, intersection, arm, ends);
                    if !leads_on {
                        loose.name(context, &lanes[lane], ends);
                    }
                }
            }
        }
        loose
    }

    /// Names a lane's lanelet.
    fn name(&mut self, context: &MapContext, lane: &ArmLane, ends: bool) {
        let lanelets = if ends { &mut self.lanelets.ends } else { &mut self.lanelets.starts };
        lanelets.insert(context.lanes.lanes[lane.lane].lanelet.0);
    }

    /// Notes that a one-way road ends or begins where no other road is: at a barrier, its node is none of the input.
    fn note_dead_end(&mut self, context: &MapContext, at: &Intersection, arm: &Arm, ends: bool) {
        let way = context.network.road(arm.at.road).key.way;
        let message = match ends {
            true => format!("way {way} is one-way, and no road leads on where it ends"),
            false => format!("way {way} is one-way, and no road leads to where it begins"),
        };
        let finding = Finding::new("lane-closed", Subject::Way(way), message).graded(Severity::Info);
        self.notes.push(finding.at(Place::Point(at.position)));
    }

    /// Notes that a lane of a road ends or begins there.
    fn note(&mut self, context: &MapContext, at: &Intersection, arm: &Arm, ends: bool) {
        let (way, node) = (context.network.road(arm.at.road).key.way, at.first_node());
        let whither = if ends { "on from" } else { "to" };
        let message = format!("No road leads {whither} a lane of way {way} at node {node}: is a one-way missing?");
        let finding = Finding::new("lane-closed", Subject::Way(way), message);
        self.notes.push(finding.with(Subject::Node(node), "there").at(Place::Point(at.position)));
    }
}
