//! Which of two roads that diverge or merge at a small angle lies to the left of the other.
//!
//! If they are drawn nearly on top of each other, their lines do not show it reliably. The order of the arms around the
//! intersection does, and it holds along the roads until the next fork.

use std::f64::consts::{PI, TAU};

use rustc_hash::FxHashMap;

use crate::builder::network::road_end::{other_end, outward};
use crate::builder::network::{End, Intersection, RoadEnd, RoadNetwork};
use crate::geometry::{Vector, angle_between};

/// Distance from the intersection up to which the order of its arms counts, metres.
const ORDER_WITHIN: f64 = 80.0;
/// The additional distance up to which it counts where roads run beside each other, metres.
const BEYOND: f64 = 120.0;
/// Distance over which the direction of an arm is taken, metres.
const LOOK: f64 = 8.0;
/// Largest angle between arms that run side by side at first, radians: 45 degrees.
const PARALLEL: f64 = PI / 4.0;

/// On which side of a road another lies, by the order of arms at an intersection.
#[derive(Clone, Copy, Debug)]
pub struct SideHint {
    /// Stations of the road between which it holds, metres.
    range: [f64; 2],
    /// 1 if the other road lies to the left of the road's line, -1 if to the right.
    pub side: f64,
    /// The end at which both roads meet, if they do: there they are on one level whatever their tags.
    pub meets: Option<End>,
}

impl SideHint {
    /// Whether it holds at this station, or so near that roads still lie as they began.
    pub fn holds_at(&self, station: f64) -> bool {
        (self.range[0] - BEYOND..=self.range[1] + BEYOND).contains(&station)
    }
}

/// The hints for every ordered pair of roads.
pub type SideHints = FxHashMap<(usize, usize), Vec<SideHint>>;

/// The hints of every intersection with three or more arms.
pub fn side_hints(network: &RoadNetwork) -> SideHints {
    let mut hints = SideHints::default();
    for intersection in network.intersections.iter().filter(|i| i.arms.len() > 2) {
        let arms = from_the_widest_gap(network, intersection);
        for (i, a) in arms.iter().enumerate() {
            for b in arms.iter().skip(i + 1).filter(|b| angle_between(a.1, b.1).abs() < PARALLEL) {
                add_hints(network, a.0, b.0, &mut hints);
            }
        }
    }
    hints
}

/// The arms clockwise, with their directions, beginning after the widest gap.
fn from_the_widest_gap(network: &RoadNetwork, intersection: &Intersection) -> Vec<(RoadEnd, Vector)> {
    let mut arms: Vec<(RoadEnd, Vector)> = intersection.arms.iter().map(|a| (*a, direction(network, *a))).collect();
    let n = arms.len();
    let gap = |i: usize| (-angle_between(arms[i].1, arms[(i + 1) % n].1)).rem_euclid(TAU);
    // If the gaps add up to more than one turn, neighbours overlap: their gap of nearly a full turn is none.
    let turns = (0..n).map(gap).sum::<f64>() / TAU;
    let gap = |i: usize| if turns > 1.5 && gap(i) > TAU - PARALLEL { 0.0 } else { gap(i) };
    if let Some(widest) = (0..n).max_by(|i, j| gap(*i).total_cmp(&gap(*j)).then(j.cmp(i))) {
        arms.rotate_left((widest + 1) % n);
    }
    arms
}

fn direction(network: &RoadNetwork, arm: RoadEnd) -> Vector {
    let road = network.road(arm.road);
    outward(road, arm.end, LOOK.min(road.line.length()))
}

/// Adds that `b` lies to the right of `a`, looking out of the intersection, and so do the roads that continue them.
fn add_hints(network: &RoadNetwork, a: RoadEnd, b: RoadEnd, hints: &mut SideHints) {
    let (left, right) = (chain(network, a), chain(network, b));
    for (i, l) in left.iter().enumerate() {
        for (j, r) in right.iter().enumerate().filter(|(_, r)| r.arm.road != l.arm.road) {
            let meets = i == 0 && j == 0;
            for (of, other, outward) in [(l, r, -1.0), (r, l, 1.0)] {
                let (length, end) = (network.road(of.arm.road).line.length(), of.arm.end);
                let (range, side) = match end {
                    End::Start => ([0.0, ORDER_WITHIN - of.from], outward),
                    End::End => ([length - (ORDER_WITHIN - of.from), length], -outward),
                };
                let hint = SideHint { range, side, meets: meets.then_some(end) };
                hints.entry((of.arm.road.position(), other.arm.road.position())).or_default().push(hint);
            }
        }
    }
}

/// A road of a chain, entered at one end `from` metres from the intersection.
struct Link {
    arm: RoadEnd,
    from: f64,
}

/// The arm and the roads that continue it within [`ORDER_WITHIN`].
fn chain(network: &RoadNetwork, arm: RoadEnd) -> Vec<Link> {
    let mut links = vec![Link { arm, from: 0.0 }];
    while let Some(last) = links.last() {
        let road = network.road(last.arm.road);
        let from = last.from + road.line.length();
        let far = other_end(last.arm);
        let &[x, y] = network.intersection(network.intersection_at(far)).arms.as_slice() else { break };
        let next = if x == far { y } else { x };
        if from >= ORDER_WITHIN || links.iter().any(|link| link.arm.road == next.road) {
            break;
        }
        links.push(Link { arm: next, from });
    }
    links
}
