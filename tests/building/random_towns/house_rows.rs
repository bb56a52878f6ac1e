//! Streets of a suburb with a driveway to nearly every house: several on the length of a car.

use super::dice::Dice;
use super::plan::{Place, Plan, angle, heading, plus};

/// Two bent streets that cross, with driveways, some of which fork.
pub fn house_rows(dice: &mut Dice) -> Plan {
    let mut plan = Plan::default();
    let crossing = plan.node([0.0, 0.0], "");
    let streets = [0.0, dice.between(1.2, 1.9)].map(|toward| {
        let tags = dice.pick(&["highway=residential", "highway=residential sidewalk=both", "highway=tertiary lanes=3"]);
        let arms = [toward, toward + std::f64::consts::PI].map(|toward| bent(&mut plan, dice, toward));
        let [before, behind] = arms;
        plan.way(before.into_iter().rev().chain([crossing]).chain(behind).collect(), tags)
    });
    streets.into_iter().for_each(|street| driveways(&mut plan, dice, street));
    plan
}

/// The nodes of a street from the crossing on, but for the crossing.
fn bent(plan: &mut Plan, dice: &mut Dice, mut toward: f64) -> Vec<usize> {
    let mut place: Place = [0.0, 0.0];
    let mut next = || {
        place = plus(place, heading(toward), dice.between(25.0, 50.0));
        toward += dice.between(-0.2, 0.2);
        plan.node(place, "")
    };
    (0..4).map(|_| next()).collect()
}

/// Driveways along a street, to either side, but none over another.
fn driveways(plan: &mut Plan, dice: &mut Dice, street: usize) {
    let apart = dice.between(3.0, 14.0);
    let tags = dice.pick(&["highway=service service=driveway", "highway=service", "highway=service access=private"]);
    let length = plan.length(street);
    let mut far = dice.between(5.0, 20.0);
    while far < length - 5.0 {
        let before = plan.ways.len();
        let at = plan.along(street, far);
        let nodes = &plan.ways[street].nodes;
        let (node, beside) = (nodes[at], nodes[if at == 0 { 1 } else { at - 1 }]);
        let along = angle(plan.place(beside), plan.place(node));
        let side = if dice.chance(0.5) { 1.0 } else { -1.0 };
        let toward = along + side * std::f64::consts::FRAC_PI_2 + dice.between(-0.3, 0.3);
        let end = plus(plan.place(node), heading(toward), dice.between(6.0, 28.0));
        plan.path(node, &[end], None, tags);
        if dice.chance(0.1) {
            let fork = plan.nodes.len() - 1;
            for turn in [-0.6, 0.6] {
                plan.path(fork, &[plus(end, heading(toward + turn), 9.0)], None, tags);
            }
        }
        plan.keep_apart(before);
        far += dice.between(1.5, 2.0 * apart);
    }
}
