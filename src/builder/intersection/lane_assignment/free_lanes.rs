//! Lanes that go straight on move over to lanes out that are free, where others turn into theirs: else a lane would fork to reach both.

use crate::builder::intersection::movement_types::Movement;
use crate::builder::lanes::types::Arm;
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::builder::tags::cross_section::StripKind;
use crate::geometry::angle_between;

/// Approaches whose directions differ by less than this, degrees, lie side by side: neither comes from the left or right of the other.
const ASIDE: f64 = 25.0;

/// Moves lanes that go straight on by one lane each, to the lane out beside their own that no movement reaches: the block between that lane
/// and the first one into which somebody else turns from the far side. Mapped connections stay as they are.
pub fn use_free_lanes(restrictions: &ResolvedRestrictions, arms: &[&Arm], all: &mut [Movement]) {
    for to in 0..arms.len() {
        let count = arms[to].out.len();
        // Each block that moves leaves one free lane less.
        for _ in 0..count {
            let is_free = |out: usize| all.iter().all(|m| (m.to, m.out_lane) != (to, out));
            let free = (0..count).filter(|&out| arms[to].out[out].kind == StripKind::Drive && is_free(out));
            let mut blocks = free.flat_map(|out| [(out, true), (out, false)]);
            let Some((block, rightward)) =
                blocks.find_map(|(out, right)| Some((block_beside(restrictions, arms, all, (to, out), right)?, right)))
            else {
                break;
            };
            for at in block {
                all[at].out_lane = if rightward { all[at].out_lane - 1 } else { all[at].out_lane + 1 };
            }
        }
    }
}

/// The movements of one approach to the lanes out on the right of a free one (`rightward`), or on its left, up to the first lane out that is
/// reached without them; `None` where there is no such block.
fn block_beside(
    restrictions: &ResolvedRestrictions,
    arms: &[&Arm],
    all: &[Movement],
    (to, free): (usize, usize),
    rightward: bool,
) -> Option<Vec<usize>> {
    let turn = |from: usize| angle_between(arms[from].inward, -arms[to].inward).to_degrees();
    let is_mapped = |from: usize| restrictions.lanes(arms[from].at, arms[to].at).is_some();
    let beyond = |out: usize| if rightward { Some(out + 1) } else { out.checked_sub(1) };
    let is_for_cars = |m: &Movement| {
        let lanes = [arms[m.from].into[m.in_lane].kind, arms[to].out[m.out_lane].kind];
        lanes == [StripKind::Drive; 2]
    };
    let into = |out: usize| all.iter().enumerate().filter(move |(_, m)| (m.to, m.out_lane) == (to, out));
    let mut out = beyond(free)?;
    let straight = into(out).filter(|(_, m)| turn(m.from).abs() <= STRAIGHT_ON && is_for_cars(m) && !is_mapped(m.from));
    let (first, movement) = straight.min_by(|(_, a), (_, b)| turn(a.from).abs().total_cmp(&turn(b.from).abs()))?;
    let mut lane = movement.in_lane;
    let mut block = vec![first];
    loop {
        let from = movement.from;
        // Vehicles that turn right come from the right.
        let from_far_side = |other: &Movement| {
            let aside = turn(from) - turn(other.from);
            if rightward { aside > ASIDE } else { aside < -ASIDE }
        };
        let mut others = into(out).filter(|(_, other)| other.from != from).peekable();
        if others.peek().is_some() {
            return others.all(|(_, other)| from_far_side(other)).then_some(block);
        }
        out = beyond(out)?;
        let next = if rightward { lane + 1 } else { lane.checked_sub(1)? };
        let (at, one) = into(out).find(|(_, m)| m.from == from && m.in_lane == next && is_for_cars(m))?;
        lane = one.in_lane;
        block.push(at);
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::lanes::types::ArmLane;
    use crate::builder::network::{End, RoadEnd, RoadIx};
    use crate::geometry::Vector;

    use super::*;

    fn arm(road: usize, inward: [f64; 2], lanes: [usize; 2]) -> Arm {
        let [into, out] = lanes.map(|count| vec![ArmLane::plain(); count]);
        let inward = Vector::new(inward[0], inward[1]);
        Arm { at: RoadEnd { road: RoadIx::new(road), end: End::End }, inward, aim: inward, into, out, cut: Vec::new() }
    }

    fn movement([from, in_lane, to, out_lane]: [usize; 4]) -> Movement {
        Movement { from, to, in_lane, out_lane }
    }

    /// From the west, north and south into a road of three lanes to the east.
    fn moved(into: usize, movements: &[[usize; 4]]) -> Vec<Movement> {
        let arms = [
            arm(0, [1.0, 0.0], [into, 0]),
            arm(1, [0.0, -1.0], [1, 0]),
            arm(2, [0.0, 1.0], [1, 0]),
            arm(3, [-1.0, 0.0], [0, 3]),
        ];
        let mut all: Vec<Movement> = movements.iter().copied().map(movement).collect();
        use_free_lanes(&ResolvedRestrictions::default(), &arms.each_ref(), &mut all);
        all
    }

    #[test]
    fn who_goes_straight_on_leaves_the_lane_into_which_others_turn() {
        let turns = [[1, 0, 3, 0], [2, 0, 3, 2]];
        let moved_to =
            |straight: &[[usize; 4]]| moved(straight.len(), &[straight, &turns].concat())[..straight.len()].to_vec();
        assert_eq!(moved_to(&[[0, 0, 3, 2]]), [movement([0, 0, 3, 1])]);
        assert_eq!(moved_to(&[[0, 0, 3, 0]]), [movement([0, 0, 3, 1])]);
        assert_eq!(moved_to(&[[0, 0, 3, 1]]), [movement([0, 0, 3, 1])], "nothing is free");
    }

    #[test]
    fn lanes_side_by_side_move_together_and_nobody_moves_across_others() {
        // Nobody turns in from the north.
        let right = [2, 0, 3, 2];
        assert_eq!(
            moved(2, &[[0, 0, 3, 1], [0, 1, 3, 2], right]),
            [movement([0, 0, 3, 0]), movement([0, 1, 3, 1]), movement(right)]
        );
        // The lane on the left is free, but who turns in comes from there.
        let left = [1, 0, 3, 1];
        assert_eq!(moved(1, &[[0, 0, 3, 1], left, right]), [movement([0, 0, 3, 1]), movement(left), movement(right)]);
    }
}
