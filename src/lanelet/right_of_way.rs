//! Which lanelets a `right_of_way` element lists as `yield`: those that the lanelet may ignore, because they give way to it or have red.
//!
//! A lanelet without such an element is taken to give way to everything that crosses it. The element lists what it may
//! ignore: lanes that stand at red while it drives, and lanes that must give way to it.

use crate::geometry::{Vector, angle_between};

/// Which way a movement goes, whatever the driving side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Toward the own kerb.
    Near,
    /// Neither.
    Straight,
    /// Across oncoming traffic; a turn around too.
    Far,
}

/// How the signals of two arms change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// One and the same arm.
    Same,
    /// Together: opposite arms, unless a user says otherwise.
    InPhase,
    /// Never together.
    AntiPhase,
}

/// What the algorithm needs to know of one movement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RankedMovement {
    /// The arm where it starts.
    pub arm: usize,
    /// Which way it goes.
    pub turn: Turn,
    /// Whether a traffic light rules it.
    pub signalised: bool,
    /// Whether something makes its vehicles wait: a light, a sign, or the way out of private ground.
    pub controlled: bool,
    /// Whether its arm has priority where no light rules; `None`: unknown.
    pub priority: Option<bool>,
    /// Whether it is a bicycle lane that is drawn as a road.
    pub bicycle: bool,
}

/// The movements that `x` may ignore, out of those that conflict with it (siblings excluded), in their order. `relation`
/// is asked of two movements, by their position.
pub fn yields(
    x: usize,
    ranked: &[RankedMovement],
    conflicts: &[usize],
    relation: impl Fn(usize, usize) -> Relation,
) -> Vec<usize> {
    let me = &ranked[x];
    conflicts
        .iter()
        .copied()
        .filter(|&y| {
            let other = &ranked[y];
            let relation = relation(x, y);
            if me.signalised { ignores_by_signal(me, other, relation) } else { ignores_by_rank(me, other, relation) }
        })
        .collect()
}

fn ignores_by_signal(me: &RankedMovement, other: &RankedMovement, relation: Relation) -> bool {
    match (me.turn, relation) {
        // Autoware watches nothing for a straight lanelet with a light.
        (Turn::Straight, _) => false,
        // Who has no light does not stand at red.
        (_, Relation::AntiPhase) => other.controlled,
        (Turn::Near, Relation::InPhase) => other.turn == Turn::Far,
        (Turn::Near, Relation::Same) => other.bicycle,
        (Turn::Far, _) => false,
    }
}

fn ignores_by_rank(me: &RankedMovement, other: &RankedMovement, relation: Relation) -> bool {
    let over_minor_road = me.priority == Some(true) && other.priority == Some(false);
    let over_far_turn = me.priority == other.priority
        && relation == Relation::InPhase
        && other.turn == Turn::Far
        && me.turn != Turn::Far;
    let over_bicycle = me.turn == Turn::Near && relation == Relation::Same && other.bicycle;
    over_minor_road || over_far_turn || over_bicycle
}

/// Largest deviation from straight, degrees, up to which two arms are opposite.
pub const OPPOSITE: f64 = 45.0;

/// For each arm its opposite one, from the directions into the intersection (`None` where nothing leads in): those two
/// whose directions come nearest to opposing each other, each the other's best, within `most` degrees.
pub fn opposites(inward: &[Option<Vector>], most: f64) -> Vec<Option<usize>> {
    let off = |a: usize, b: usize| -> Option<f64> {
        let bend = angle_between(inward[a]?, -inward[b]?).abs().to_degrees();
        Some(bend).filter(|bend| *bend <= most)
    };
    let best = |a: usize| {
        let others = (0..inward.len()).filter(|&b| b != a).filter_map(|b| Some((b, off(a, b)?)));
        others.min_by(|x, y| x.1.total_cmp(&y.1)).map(|(b, _)| b)
    };
    let bests: Vec<Option<usize>> = (0..inward.len()).map(best).collect();
    (0..inward.len()).map(|a| bests[a].filter(|&b| bests[b] == Some(a))).collect()
}

#[cfg(test)]
#[path = "yield_tables.rs"]
mod tables;
