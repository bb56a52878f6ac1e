//! Two lanelets of which one watches the other for nothing, or neither waits, or each for the other.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, angle_between};
use crate::lanelet::index::{Conflict, Rank, Traffic};
use crate::lanelet::right_of_way::{OPPOSITE, Relation, Turn};
use crate::parallel::InSmallParts;
use crate::rules::right_of_way_element::ruled_by_signal;
use crate::rules::virtual_light::is_coordinated;

use super::watching::Watching;

/// Two lanelets of which something is to be said, by their positions, and the place where they overlap.
struct Pair {
    fault: &'static str,
    lanelets: [usize; 2],
    place: Point,
}

/// What is to be said of pairs of lanelets. Of those of one intersection that wait for each other there is one finding.
pub fn judge(all: &Watching) -> Vec<Finding> {
    let pairs: Vec<Pair> =
        all.turns.as_slice().par_iter().in_small_parts().flat_map_iter(|&at| of_lanelet(all, at)).collect();
    let (waiting, others): (Vec<Pair>, Vec<Pair>) = pairs.into_iter().partition(|pair| pair.fault == "both-wait");
    let mut findings: Vec<Finding> = others.iter().map(|pair| found(all, pair, 0)).collect();
    let mut by_intersection: BTreeMap<Option<usize>, Vec<Pair>> = BTreeMap::new();
    for pair in waiting {
        let of = all.lane(pair.lanelets[0]).and_then(|lane| all.map.intersections_of(lane).first().copied());
        by_intersection.entry(of).or_default().push(pair);
    }
    findings.extend(by_intersection.values().filter_map(|pairs| {
        let worse = pairs.iter().find(|pair| !are_equals_by_law(all, pair.lanelets));
        let finding = found(all, worse.or(pairs.first())?, pairs.len() - 1);
        Some(if worse.is_some() { finding } else { finding.graded(Severity::Info) })
    }));
    findings
}

/// Whether two lanelets from opposite approaches both turn across the oncoming traffic, or neither does: those meet on a road so narrow
/// that one lane serves both directions. By law neither goes first, and drivers settle it among themselves: nothing in the map is wrong.
fn are_equals_by_law(all: &Watching, [at, other]: [usize; 2]) -> bool {
    let Some(lanes) = all.lane(at).zip(all.lane(other)).map(|(x, y)| [x, y]) else { return false };
    let Some((traffic, x, y)) = movements(all, lanes) else { return false };
    let [one, two] = [x, y].map(|at| traffic.movements[at].ranked);
    let alike = (one.turn == Turn::Far) == (two.turn == Turn::Far) && one.priority == two.priority;
    let [a, b] = lanes.map(|lane| all.map.lanes[lane].heading_in());
    alike && a.zip(b).is_some_and(|(x, y)| angle_between(x, y).abs().to_degrees() > 180.0 - OPPOSITE)
}

/// The pairs of a lanelet and those that conflict with it. What holds for both is said once, of the first.
fn of_lanelet(all: &Watching, at: usize) -> Vec<Pair> {
    let Some((lane, attention)) = all.lane(at).zip(all.attention[at].as_ref()) else { return Vec::new() };
    let mut pairs = Vec::new();
    for &other in &attention.conflicting {
        let Some(conflict) = all.conflict(at, other) else { continue };
        // Virtual lights are vm-03-17's.
        if [at, other].iter().any(|&one| is_coordinated(all.map, all.id(one))) {
            continue;
        }
        let turns = all.attention[other].is_some();
        let once = at < other || !turns;
        let lanes = [lane, conflict.other];
        let fault = match (all.watches(at, other), all.watches(other, at)) {
            _ if all.are_neighbours(at, other) => continue,
            (false, false) if once && turns && !is_separated(all, lanes) && meet(all, at, other) => "nobody-waits",
            (true, _) if in_vain(all, at, other, conflict) && !(other < at && in_vain(all, other, at, conflict)) => {
                "never-meets"
            }
            (true, true) if once && nobody_goes(all, lanes) && meet(all, at, other) => "both-wait",
            _ => continue,
        };
        pairs.push(Pair { fault, lanelets: [at, other], place: conflict.place });
    }
    pairs
}

/// What is said of a pair, and how many more of its intersection are like it.
fn found(all: &Watching, pair: &Pair, more: usize) -> Finding {
    let [x, y] = pair.lanelets.map(|at| all.id(at));
    let message = match (pair.fault, more) {
        ("never-meets", _) => format!("Lanelet {x} watches {y}, yet vehicles on both pass each other."),
        ("nobody-waits", _) => {
            format!("Lanelets {x} and {y} cross, neither waits for the other, and no light keeps them apart.")
        }
        (_, 0) => format!("Lanelets {x} and {y} each wait for the other."),
        (_, 1) => format!("Lanelets {x} and {y} each wait for the other, as do two more of the intersection."),
        _ => format!("Lanelets {x} and {y} each wait for the other, as do {more} more pairs of the intersection."),
    };
    let finding = Finding::new(pair.fault, Subject::Lanelet(x.0), message);
    let finding = finding.with(Subject::Lanelet(y.0), "conflicting lanelet").at(Place::Point(pair.place));
    let [at, other] = pair.lanelets;
    match pair.fault == "never-meets" && !comes_in(all, at, other) {
        true => finding.graded(Severity::Info),
        false => finding,
    }
}

/// Whether vehicles in the middle of two lanelets touch each other.
fn meet(all: &Watching, at: usize, other: usize) -> bool {
    all.strip(at).zip(all.strip(other)).is_some_and(|(one, other)| one.meets(other))
}

/// Whether a lanelet is waited for that is never met, even if vehicles on both are a little astray: who drives there touches this
/// lanelet, which is what the module looks for, and not the vehicle on it.
fn in_vain(all: &Watching, at: usize, other: usize, conflict: &Conflict) -> bool {
    let Some((mine, theirs)) = all.strip(at).zip(all.strip(other)).filter(|_| all.watches(at, other)) else {
        return false;
    };
    let sure = mine.holds(conflict.place) && theirs.holds(conflict.place);
    !sure && !mine.meets(theirs) && theirs.meets(&all.network.surface(at)) && all.meets_any(at)
}

/// Whether who drives in the very middle of one lanelet touches another.
fn comes_in(all: &Watching, at: usize, other: usize) -> bool {
    let middle = all.network.strip(other, 0.0, &all.params);
    middle.is_some_and(|middle| middle.meets(&all.network.surface(at)))
}

/// The traffic of two lanes with their places in it, where both are movements of one intersection.
fn movements<'m>(all: &'m Watching<'_>, [x, y]: [usize; 2]) -> Option<(&'m Traffic, usize, usize)> {
    let (_, traffic, at) = all.map.movement(x)?;
    Some((traffic, at, traffic.of_lane(y)?))
}

/// Whether lights keep two lanes apart that ignore each other, or vm-03-10 or vm-03-11 tells that they do.
fn is_separated(all: &Watching, lanes: [usize; 2]) -> bool {
    let Some((traffic, x, y)) = movements(all, lanes) else { return false };
    let [me, other] = [x, y].map(|at| traffic.movements[at].ranked);
    let lights = lanes.map(|lane| ruled_by_signal(all.map, all.map.lanes[lane].id));
    match traffic.relation(x, y) {
        Relation::Same => false,
        Relation::AntiPhase => true,
        Relation::InPhase => lights != [true; 2] || (me.turn == Turn::Far) != (other.turn == Turn::Far),
    }
}

/// Whether it is known who goes first in an intersection, and of two lanes that wait for each other neither does.
fn nobody_goes(all: &Watching, lanes: [usize; 2]) -> bool {
    let Some((traffic, x, y)) = movements(all, lanes) else { return false };
    let due = |x: usize, y: usize| traffic.yields(all.map, x).contains(&y);
    // Of two side roads without lights nothing tells which goes first.
    let told = traffic.relation(x, y) != Relation::AntiPhase
        || [x, y].iter().any(|&at| traffic.movements[at].ranked.signalised);
    traffic.rank == Rank::Known && told && !due(x, y) && !due(y, x)
}
