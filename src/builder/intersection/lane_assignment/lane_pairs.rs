//! Pairs of lanes: which lane of an approach leads to which lane of the road ahead.

use crate::builder::intersection::movement_types::TurnTarget;
use crate::builder::lanes::types::ArmLane;
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::geometry::cross;

/// How far, metres, the end of a lane lies beside the line of another.
pub fn sideways(from: &ArmLane, to: &ArmLane) -> f64 {
    cross(from.pose.heading, to.pose.point - from.pose.point).abs()
}

/// Pairs lanes with lanes in order, so that the fewest pairs `crosses` something; straight on, those that lie least sideways from each
/// other. Where there are more lanes in than out, some become one.
pub fn pair_up(
    (ins, outs): (&[usize], &[usize]),
    lanes: &[(usize, &ArmLane)],
    target: &TurnTarget,
    crosses: impl Fn(&(usize, usize)) -> bool,
) -> Vec<(usize, usize)> {
    let (k, n) = (ins.len(), outs.len());
    let pairs = |out_of: &dyn Fn(usize) -> usize| -> Vec<(usize, usize)> {
        ins.iter().enumerate().map(|(j, &i)| (i, outs[out_of(j)])).collect()
    };
    if n == 0 {
        return Vec::new();
    }
    let mut choices: Vec<Vec<(usize, usize)>> = if k > n {
        // Evenly, or only at one side, or at both.
        let at_sides = (0..=k - n).map(|first| pairs(&|j| j.saturating_sub(first).min(n - 1)));
        std::iter::once(pairs(&|j| j * n / k)).chain(at_sides).collect()
    } else {
        (0..=n - k).map(|shift| pairs(&|j| j + shift)).collect()
    };
    let crossings = |pairs: &[(usize, usize)]| pairs.iter().filter(|pair| crosses(pair)).count();
    let fewest = choices.iter().map(|pairs| crossings(pairs)).min();
    choices.retain(|pairs| Some(crossings(pairs)) == fewest);
    let sideways = |pairs: &[(usize, usize)]| -> f64 {
        pairs.iter().map(|&(i, o)| sideways(lanes[i].1, &target.arm.out[o])).sum()
    };
    let chosen = match target.turn {
        turn if turn.abs() <= STRAIGHT_ON => choices.into_iter().min_by(|a, b| sideways(a).total_cmp(&sideways(b))),
        turn if turn > 0.0 || k > n => choices.into_iter().next(),
        _ => choices.into_iter().next_back(),
    };
    chosen.unwrap_or_default()
}
