//! Which junctions are intersections with an area of their own.

use crate::builder::intersection::conflict::Conflicts;
use crate::builder::intersection::movement_types::Movement;
use crate::builder::intersection::turn_direction::turn_direction;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::network::approach_control::Control;
use crate::geometry::angle_between;
use crate::lanelet::TurnDirection;
use crate::lanelet::index::JOINING;

use super::junctions::Site;
use super::scene::Piece;

/// Types of lanes on which vehicles leave a fast road or join it.
const RAMPS: [&str; 8] = ["entry", "exit", "onRamp", "offRamp", "connectingRamp", "slipLane", "mwyEntry", "mwyExit"];

impl Site<'_> {
    /// Whether vehicles cross, or turn off while others go on. Where ramps leave or join a road, only crossing counts.
    pub fn needs_area(&self, found: &Conflicts, controls: &[Control]) -> bool {
        let ruled = controls.iter().any(|control| *control != Control::None);
        if !ruled && self.has_ramps() {
            let apart = |a: Movement, b: Movement| {
                (a.from, a.in_lane) != (b.from, b.in_lane) && (a.to, a.out_lane) != (b.to, b.out_lane)
            };
            let crosses = |at: usize, other: usize| apart(self.paths[at].movement, self.paths[other].movement);
            return (0..self.paths.len()).any(|at| found.real[at].iter().any(|&other| crosses(at, other)));
        }
        self.paths.iter().enumerate().any(|(at, path)| {
            let turns = turn_direction(path) != TurnDirection::Straight;
            let goes_on =
                |it: &TurningLanelet| it.movement.from == path.movement.from && it.movement.to != path.movement.to;
            let joins = |it: &TurningLanelet| {
                (it.movement.to, it.movement.out_lane) == (path.movement.to, path.movement.out_lane)
                    && angle_between(path.heading, it.heading).abs().to_degrees() <= JOINING
            };
            turns && self.paths.iter().any(goes_on)
                || found.real[at].iter().any(|&other| ruled || !joins(&self.paths[other]))
        })
    }

    /// Whether a ramp leads through the junction, or a motorway.
    fn has_ramps(&self) -> bool {
        let around = self.arms.iter().flat_map(|arm| arm.into.iter().chain(&arm.out)).map(|lane| lane.lane);
        around.chain(self.members.iter().copied()).any(|lane| {
            let lane = &self.drawn.lanes[lane];
            let Piece { stretch, lane: id } = self.scene.middle_piece(lane);
            let kind = self.scene.section(stretch).lane(id).map(|lane| lane.kind.as_str());
            self.scene.road(stretch).kind == "motorway" || kind.is_some_and(|kind| RAMPS.contains(&kind))
        })
    }
}
