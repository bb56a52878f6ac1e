//! Movements through an intersection, and the arms that they may lead to.

use crate::builder::lanes::types::Arm;
use crate::builder::network::turn_angle::TURNS_BACK;

/// One movement of an intersection. Arms and lanes are indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Movement {
    /// Arm where it starts, in the arms of the intersection.
    pub from: usize,
    /// Arm where it ends.
    pub to: usize,
    /// Lane of [`Arm::into`].
    pub in_lane: usize,
    /// Lane of [`Arm::out`].
    pub out_lane: usize,
}

/// The movements of one intersection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Movements {
    /// Sorted.
    pub all: Vec<Movement>,
    /// Pairs of arms with lanes from the first and to the second, between which there must be none.
    pub prohibited: Vec<(usize, usize)>,
    /// Pairs of arms between which there are U-turns, if there is room.
    pub u_turns: Vec<(usize, usize)>,
    /// How many more there are: too many to draw.
    pub left_out: usize,
}

/// An arm to which lanes of another may lead, as seen from that other.
#[derive(Clone, Copy)]
pub struct TurnTarget<'a> {
    /// The arm, by index.
    pub to: usize,
    /// That arm.
    pub arm: &'a Arm,
    /// Change of direction between the cuts, degrees, left positive.
    pub turn: f64,
    /// Change of direction for arrows, degrees, left positive: between the directions in which the roads' lines meet.
    pub arrow_turn: f64,
}

impl TurnTarget<'_> {
    /// Whether the movement there is a U-turn.
    pub fn turns_back(&self) -> bool {
        self.turn.abs() > TURNS_BACK
    }
}
