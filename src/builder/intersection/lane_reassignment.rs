//! Other assignments of lanes, for an intersection where lanelets run into each other or begin in a corner.
//!
//! Lanes are assigned by the order of the arms around the intersection. Where it was merged from several, the lanelets to two arms can
//! lie in another order.

use crate::builder::lanes::types::{Arm, Lanes};
use crate::builder::network::Intersection;
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;

use super::lane_assignment::{lead_on, reach_all};
use super::movement_types::Movement;
use super::undrivable::UndrivableMovements;

/// Movements in place of `all`, each time with one change: two movements that run into each other exchange the lanes to which they
/// lead, or an undrivable movement makes way for those of the lanes beside its lanes. From each arm movements lead to the same arms
/// as before, from all lanes and to all lanes that had some.
pub fn reassignments(
    restrictions: &ResolvedRestrictions,
    lanes: &Lanes,
    intersection: &Intersection,
    all: &[Movement],
    undrivable: &UndrivableMovements,
) -> Vec<Vec<Movement>> {
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    // The map names the lanes that lead from one arm to the other.
    let is_mapped = |m: &Movement| restrictions.lanes(arms[m.from].at, arms[m.to].at).is_some();
    let UndrivableMovements { corners, pairs } = undrivable;
    let exchanged = pairs.iter().filter(|pair| !pair.iter().any(is_mapped)).map(|pair| exchanged(all, *pair));
    let mut singles: Vec<Movement> = corners.iter().chain(pairs.iter().flatten()).copied().collect();
    singles.sort_unstable();
    singles.dedup();
    let without = singles.iter().filter(|single| !is_mapped(single)).map(|single| without(&arms, all, single));
    exchanged.chain(without.flatten()).collect()
}

/// The movements, of which two from lanes side by side exchange the lanes to which they lead.
fn exchanged(all: &[Movement], [a, b]: [Movement; 2]) -> Vec<Movement> {
    let mut changed: Vec<Movement> = all.iter().filter(|m| ![a, b].contains(m)).copied().collect();
    changed.push(Movement { from: a.from, in_lane: a.in_lane, ..b });
    changed.push(Movement { from: b.from, in_lane: b.in_lane, ..a });
    changed.sort_unstable();
    changed.dedup();
    changed
}

/// The movements without one. If its lanes need another movement, they share one with the lanes beside them. `None` if they cannot, or
/// if no movement between its arms would be left.
fn without(arms: &[&Arm], all: &[Movement], gone: &Movement) -> Option<Vec<Movement>> {
    let mut changed: Vec<Movement> = all.iter().filter(|m| *m != gone).copied().collect();
    lead_on(arms, &mut changed, &[*gone]);
    reach_all(arms, &mut changed, &[*gone]);
    changed.sort_unstable();
    changed.dedup();
    let leads_on = changed.iter().any(|m| (m.from, m.in_lane) == (gone.from, gone.in_lane));
    let is_reached = changed.iter().any(|m| (m.to, m.out_lane) == (gone.to, gone.out_lane));
    let joins_arms = changed.iter().any(|m| (m.from, m.to) == (gone.from, gone.to));
    (leads_on && is_reached && joins_arms).then_some(changed)
}

#[cfg(test)]
mod tests {
    use crate::builder::lanes::types::ArmLane;
    use crate::builder::network::{End, RoadEnd, RoadIx};
    use crate::geometry::Vector;

    use super::*;

    /// An arm with so many lanes that lead in and out.
    fn arm(road: usize, [into, out]: [usize; 2]) -> Arm {
        let (at, ahead) = (RoadEnd { road: RoadIx::new(road), end: End::Start }, Vector::new(1.0, 0.0));
        Arm {
            at,
            inward: ahead,
            aim: ahead,
            into: vec![ArmLane::plain(); into],
            out: vec![ArmLane::plain(); out],
            cut: Vec::new(),
        }
    }

    fn movement([from, in_lane, to, out_lane]: [usize; 4]) -> Movement {
        Movement { from, to, in_lane, out_lane }
    }

    #[test]
    fn two_movements_exchange_the_lanes_to_which_they_lead() {
        let all = [[0, 0, 2, 0], [0, 1, 1, 0], [3, 0, 1, 0]].map(movement);
        let expected = [[0, 0, 1, 0], [0, 1, 2, 0], [3, 0, 1, 0]].map(movement);
        assert_eq!(exchanged(&all, [all[1], all[0]]), exchanged(&all, [all[0], all[1]]));
        let mut expected = expected.to_vec();
        expected.sort_unstable();
        assert_eq!(exchanged(&all, [all[0], all[1]]), expected);
    }

    #[test]
    fn lanes_share_the_movement_of_the_lanes_beside_them() {
        let roads = [arm(0, [2, 0]), arm(1, [0, 2]), arm(2, [1, 0])];
        let all = [[0, 0, 1, 0], [0, 1, 1, 1], [2, 0, 1, 1]].map(movement);
        // The left lane joins the right one; the other road fans out to the left lane.
        let expected = [[0, 0, 1, 1], [0, 1, 1, 1], [2, 0, 1, 0], [2, 0, 1, 1]].map(movement);
        let mut expected = expected.to_vec();
        expected.sort_unstable();
        assert_eq!(without(&roads.each_ref(), &all, &all[0]), Some(expected));
        // The only movement between two arms stays.
        let others = [arm(0, [2, 0]), arm(1, [0, 1]), arm(2, [0, 1])];
        assert_eq!(
            without(&others.each_ref(), &[[0, 0, 1, 0], [0, 1, 2, 0]].map(movement), &movement([0, 0, 1, 0])),
            None
        );
    }
}
