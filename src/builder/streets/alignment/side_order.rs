//! On which side of each other two roads lie that part or join at a small angle.
//!
//! Where they are drawn nearly on top of each other the drawn lines do not tell it reliably; the order of the arms
//! around the intersection does, and it holds along the roads as far as they continue without another fork.

use std::f64::consts::{PI, TAU};

use rustc_hash::FxHashMap;

use crate::builder::network::{End, Intersection, RoadEnd, RoadNetwork};
use crate::geometry::{Vector, angle_between};

/// The order of the arms tells the side so far from the intersection, metres.
const REACH: f64 = 80.0;
/// Distance, metres, over which the direction of an arm is taken.
const LOOK: f64 = 8.0;
/// Arms whose directions differ by less than this, radians, run abreast at first: 45 degrees.
const ABREAST: f64 = PI / 4.0;

/// What an intersection tells of one road beside another.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// Stations of the road between which it holds.
    range: [f64; 2],
    /// 1: the other lies to the left of the road's line, -1: to the right.
    pub side: f64,
    /// The end at which both roads meet, if they do: there they are at one level whatever their tags say.
    pub meets: Option<End>,
}

impl Told {
    /// Whether it holds at this station.
    pub fn at(&self, station: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&station)
    }
}

/// What is told of every ordered pair of roads.
pub type Sides = FxHashMap<(usize, usize), Vec<Told>>;

/// Reads the sides from the order of the arms at every intersection of three and more.
pub fn sides(network: &RoadNetwork) -> Sides {
    let mut sides = Sides::default();
    for intersection in network.intersections.iter().filter(|i| i.arms.len() > 2) {
        let arms = from_the_widest_gap(network, intersection);
        for (i, a) in arms.iter().enumerate() {
            for b in arms.iter().skip(i + 1).filter(|b| angle_between(a.1, b.1).abs() < ABREAST) {
                tell(network, a.0, b.0, &mut sides);
            }
        }
    }
    sides
}

/// The arms clockwise, each with its direction, beginning behind the widest gap between two of them.
fn from_the_widest_gap(network: &RoadNetwork, intersection: &Intersection) -> Vec<(RoadEnd, Vector)> {
    let mut arms: Vec<(RoadEnd, Vector)> = intersection.arms.iter().map(|a| (*a, direction(network, *a))).collect();
    let n = arms.len();
    let gap = |i: usize| (-angle_between(arms[i].1, arms[(i + 1) % n].1)).rem_euclid(TAU);
    // More than one turn in all: neighbours lean over each other, and what looks like their gap is none.
    let turns = (0..n).map(gap).sum::<f64>() / TAU;
    let gap = |i: usize| if turns > 1.5 && gap(i) > TAU - ABREAST { 0.0 } else { gap(i) };
    if let Some(widest) = (0..n).max_by(|i, j| gap(*i).total_cmp(&gap(*j)).then(j.cmp(i))) {
        arms.rotate_left((widest + 1) % n);
    }
    arms
}

/// The direction in which an arm leaves.
fn direction(network: &RoadNetwork, arm: RoadEnd) -> Vector {
    let line = &network.road(arm.road).line;
    let look = LOOK.min(line.length());
    match arm.end {
        End::Start => line.at(look) - line.first(),
        End::End => line.at(line.length() - look) - line.last(),
    }
}

/// `b` lies to the right of `a`, seen from the intersection outwards; so do the roads that continue them.
fn tell(network: &RoadNetwork, a: RoadEnd, b: RoadEnd, sides: &mut Sides) {
    let (left, right) = (chain(network, a), chain(network, b));
    for (i, l) in left.iter().enumerate() {
        for (j, r) in right.iter().enumerate().filter(|(_, r)| r.arm.road != l.arm.road) {
            let meets = i == 0 && j == 0;
            for (of, other, outward) in [(l, r, -1.0), (r, l, 1.0)] {
                let (length, end) = (network.road(of.arm.road).line.length(), of.arm.end);
                let (range, side) = match end {
                    End::Start => ([0.0, REACH - of.from], outward),
                    End::End => ([length - (REACH - of.from), length], -outward),
                };
                let told = Told { range, side, meets: meets.then_some(end) };
                sides.entry((of.arm.road.position(), other.arm.road.position())).or_default().push(told);
            }
        }
    }
}

/// A road of a chain, entered at one end so far from the intersection.
struct Link {
    arm: RoadEnd,
    from: f64,
}

/// The arm and the roads that continue it, as far as its side reaches.
fn chain(network: &RoadNetwork, arm: RoadEnd) -> Vec<Link> {
    let mut links = vec![Link { arm, from: 0.0 }];
    while let Some(last) = links.last() {
        let road = network.road(last.arm.road);
        let from = last.from + road.line.length();
        let far = RoadEnd { road: last.arm.road, end: last.arm.end.other() };
        let &[x, y] = network.intersection(road.intersection(far.end)).arms.as_slice() else { break };
        let next = if x == far { y } else { x };
        if from >= REACH || links.iter().any(|link| link.arm.road == next.road) {
            break;
        }
        links.push(Link { arm: next, from });
    }
    links
}
