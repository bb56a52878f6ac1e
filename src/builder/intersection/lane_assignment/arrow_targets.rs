//! The arms to which the arrows of a lane lead.

use crate::builder::intersection::movement_types::TurnTarget;
use crate::builder::lanes::types::ArmLane;
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::builder::tags::cross_section::Arrows;

/// The largest difference, degrees, between the direction of an arrow and that of an arm to which it leads.
const ARROW_REACH: f64 = 70.0;
/// An arrow leads to a further arm only if their directions differ by no more than this, degrees.
const ARROW_NEAR: f64 = 50.0;

/// Whether no arrow of a lane leads to any of the targets: it has none, or they belong to another intersection.
pub(super) fn is_untold(lane: &ArmLane, targets: &[TurnTarget]) -> bool {
    arrow_goals(lane.arrows, targets).is_empty()
}

/// The directions that arrows show, degrees, left positive.
const DIRECTIONS: [(Arrows, f64); 7] = [
    (Arrows::SHARP_LEFT, 135.0),
    (Arrows::LEFT, 90.0),
    (Arrows::SLIGHT_LEFT, 40.0),
    (Arrows::THROUGH, 0.0),
    (Arrows::SLIGHT_RIGHT, -40.0),
    (Arrows::RIGHT, -90.0),
    (Arrows::SHARP_RIGHT, -135.0),
];

/// Whether an arrow shows a turn in nearly the direction of an arm: where two streets leave on one side, it is for both.
pub(super) fn turns_towards(arrows: Arrows, target: &TurnTarget) -> bool {
    let shown = DIRECTIONS.iter().filter(|(arrow, degrees)| arrows.has(*arrow) && *degrees != 0.0);
    let mut angles = shown.map(|(_, degrees)| (target.arrow_turn - degrees).abs());
    target.turn.abs() > STRAIGHT_ON && angles.any(|angle| angle <= ARROW_NEAR)
}

/// The targets to which a lane's arrows lead.
pub(super) fn arrow_goals(arrows: Arrows, targets: &[TurnTarget]) -> Vec<usize> {
    let nearest = |degrees: f64| {
        let difference = |(_, target): &(usize, &TurnTarget)| (target.arrow_turn - degrees).abs();
        let best = targets.iter().enumerate().min_by(|a, b| difference(a).total_cmp(&difference(b)));
        best.filter(|best| difference(best) <= ARROW_REACH).map(|(t, _)| t)
    };
    let shown = DIRECTIONS.iter().filter(|(arrow, _)| arrows.has(*arrow));
    let u_turns = (0..targets.len()).filter(|&t| arrows.has(Arrows::REVERSE) && targets[t].turns_back());
    let mut goals: Vec<usize> = shown.filter_map(|(_, degrees)| nearest(*degrees)).chain(u_turns).collect();
    goals.sort_unstable();
    goals.dedup();
    goals
}
