//! Turns traffic lights until their directions agree with their phases. TIER IV's validator takes two lights for green together if
//! they are about parallel, and for green at different times if they are not. Lights that face their arms contradict the phases where
//! arms lie side by side. Such a light is turned a little; vehicles still see it.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::lanes_seen::{Judged, LanesSeen};
use crate::geometry::{Point, Vector, angle_between};
use crate::lanelet::index::tier4_yields::{Ruled, SAME_TIMING, light, turns_before};
use crate::lanelet::index::view::View;
use crate::lanelet::{LaneletMap, LineStringId, PointId};
use crate::parallel::InSmallParts;

/// How far a light may be turned, degrees, and in which steps, the least first.
const TURNS: [f64; 9] = [0.0, 10.0, -10.0, 20.0, -20.0, 30.0, -30.0, 40.0, -40.0];
/// Directions are kept this far, degrees, from the angle at which the validator's answer changes.
const ANGLE_FROM_LIMIT: f64 = 2.0;
/// The weight of a lanelet that the validator takes for red though it has green, against the opposite mistake. A vehicle ignores the
/// former lanelet, and waits without need for the latter.
const GREEN_WEIGHS: f64 = 3.0;
/// The number of rounds: a light that is turned changes the best direction of its neighbours.
const ROUNDS: usize = 4;

/// A light and those with which it rules lanelets that meet.
struct Light {
    along: Vector,
    turned: f64,
    /// For each other light, how many pairs of lanelets have green together, and how many at different times.
    beside: BTreeMap<LineStringId, [usize; 2]>,
}

/// Turns the lights of a map.
pub fn turn_lights(map: &mut LaneletMap) {
    let mut lights = {
        let view = View::new(map);
        lights(&LanesSeen::new(&view))
    };
    for _ in 0..ROUNDS {
        let ids: Vec<LineStringId> = lights.keys().copied().collect();
        for id in ids {
            let best = best_turn(&lights, id);
            if let Some(light) = lights.get_mut(&id) {
                light.turned = best;
            }
        }
    }
    lights.retain(|_, light| light.turned != 0.0);
    rotate(map, &lights);
}

/// Two lights that rule lanelets that meet, and whether these have green at different times.
type Pair = ([(LineStringId, Vector); 2], bool);

fn lights(seen: &LanesSeen) -> BTreeMap<LineStringId, Light> {
    let lanelets = (0..seen.view.lanelets.len()).into_par_iter().in_small_parts();
    let pairs: Vec<Pair> = lanelets.flat_map_iter(|at| pairs_of(seen, at)).collect();
    let mut lights: BTreeMap<LineStringId, Light> = BTreeMap::new();
    for ([one, other], apart) in pairs {
        for ((id, along), (beside, _)) in [(one, other), (other, one)] {
            let light = lights.entry(id).or_insert_with(|| Light { along, turned: 0.0, beside: BTreeMap::new() });
            light.beside.entry(beside).or_default()[usize::from(apart)] += 1;
        }
    }
    lights
}

/// A turning lanelet's light, with those of the lanelets that it meets.
fn pairs_of(seen: &LanesSeen, at: usize) -> Vec<Pair> {
    let lanelet = &seen.view.lanelets[at];
    let own = light(seen.view, lanelet).filter(|_| seen.judged(at) == Judged::By(Ruled::ByLight));
    let Some(own) = own else { return Vec::new() };
    // Without an element nothing is compared.
    let Some(element) = seen.element(at) else { return Vec::new() };
    let listed = seen.listed(element);
    let met = seen.wanted(at, Ruled::ByNothing);
    let ignored = |other: usize| listed.binary_search(&other).is_ok();
    // If both turn onto the same road and have green together, no light decides who goes first: the other one need not be listed.
    // Where the lanelet may ignore nobody else, its list has to hold it, and the validator has to expect it there.
    let mut others = met.iter().filter(|&&other| ignored(other));
    let needed = others.all(|&other| seen.meets_oncoming_turn(at, other));
    let pair = |other: usize| {
        let beside = &seen.view.lanelets[other];
        let theirs = light(seen.view, beside).filter(|(id, _)| *id != own.0)?;
        let apart = ignored(other);
        let undecided = turns_before(lanelet, beside) || (apart && !needed && seen.meets_oncoming_turn(at, other));
        (!undecided).then_some(([own, theirs], apart))
    };
    met.into_iter().filter_map(pair).collect()
}

/// The least turn, degrees, with which a light contradicts the fewest rights of way.
fn best_turn(lights: &BTreeMap<LineStringId, Light>, id: LineStringId) -> f64 {
    let Some(own) = lights.get(&id) else { return 0.0 };
    let wrong = |turn: f64| -> f64 {
        let others = own.beside.iter().filter_map(|(id, pairs)| Some((lights.get(id)?, pairs)));
        let wrong = others.map(|(other, [together, apart])| {
            let angle = (angle_between(own.along, other.along).to_degrees() + other.turned - turn).rem_euclid(180.0);
            let angle = angle.min(180.0 - angle);
            let [along, across] =
                [angle - (SAME_TIMING - ANGLE_FROM_LIMIT), (SAME_TIMING + ANGLE_FROM_LIMIT) - angle].map(contradiction);
            GREEN_WEIGHS * *together as f64 * along + *apart as f64 * across
        });
        wrong.sum()
    };
    TURNS.into_iter().min_by(|a, b| wrong(*a).total_cmp(&wrong(*b))).unwrap_or(0.0)
}

/// The penalty for a direction that is wrong by an angle, degrees. It grows with the angle, so that two lights turn toward each other
/// where neither can be turned far enough alone.
fn contradiction(missed: f64) -> f64 {
    if missed > 0.0 { SAME_TIMING + missed } else { 0.0 }
}

/// Turns lights around their middle, with their bulbs.
fn rotate(map: &mut LaneletMap, lights: &BTreeMap<LineStringId, Light>) {
    let mut bodies: BTreeMap<LineStringId, FxHashSet<PointId>> = BTreeMap::new();
    for element in map.regulatory_elements.iter().filter(|element| element.subtype == "traffic_light") {
        let Some(light) = element.linestrings("refers").find(|id| lights.contains_key(id)) else { continue };
        let lines = [light].into_iter().chain(element.linestrings("light_bulbs"));
        let points = lines.filter_map(|line| map.linestrings.get(line)).flat_map(|line| &line.points);
        bodies.entry(light).or_default().extend(points);
    }
    for (id, points) in bodies {
        let (Some(light), Some(line)) = (lights.get(&id), map.linestrings.get(id)) else { continue };
        let ends: Vec<Point> = map.points.get_each(line.points.iter().copied()).map(|point| point.position).collect();
        let [Some(first), Some(last)] = [ends.first(), ends.last()] else { continue };
        let middle = nalgebra::center(first, last);
        let turn = nalgebra::Rotation2::new(light.turned.to_radians());
        for point in points {
            if let Some(point) = map.points.get_mut(point) {
                point.position = middle + turn * (point.position - middle);
            }
        }
    }
}

#[cfg(test)]
mod tests;
