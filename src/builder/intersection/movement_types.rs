//! One movement through an intersection, and the arm that it may turn into.

use crate::builder::lanes::types::Arm;
use crate::builder::network::turn::TURNS_BACK;

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
}

/// An arm that one may turn into, seen from the arm where one comes from.
#[derive(Clone, Copy)]
pub struct TurnTarget<'a> {
    /// The arm, by its position.
    pub to: usize,
    /// That arm.
    pub arm: &'a Arm,
    /// Change of direction in degrees, left positive.
    pub turn: f64,
    /// The same as arrows mean it: between the directions in which the roads meet, wherever they are cut off.
    pub shown: f64,
}

impl TurnTarget<'_> {
    /// Whether it leads back to where one comes from.
    pub fn turns_back(&self) -> bool {
        self.turn.abs() > TURNS_BACK
    }
}
