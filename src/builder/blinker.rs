//! Where two turns to different sides follow each other closely, says from where to blink for the second one.
//!
//! Autoware blinks from a distance that grows with speed, so that the blinker for a turn could start inside an opposite
//! turn before it. `turn_signal_distance` shortens it to the way between the two.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::geometry::Point;
use crate::lanelet::{Lanelet, LaneletId, LaneletMap, PointId, TurnDirection};

/// Autoware blinks from this distance before a turn, metres, ...
const DISTANCE: f64 = 30.0;
/// ... and the way driven in this time at the speed limit, seconds.
const TIME: f64 = 3.0;
/// Speed limit where a lanelet has none, km/h.
const USUAL_SPEED: f64 = 50.0;
/// The blinker starts this far, metres, behind the end of the turn before.
const CLEAR: f64 = 0.1;
/// Lengths are kept as whole millimetres, which have an order.
const PER_METRE: f64 = 1e3;

/// Sets `turn_signal_distance` wherever the usual distance reaches back into an opposite turn.
pub fn limit(map: &mut LaneletMap) {
    let mut ending: FxHashMap<[PointId; 2], Vec<LaneletId>> = FxHashMap::default();
    for lanelet in &map.lanelets {
        if let Some(edge) = edge(map, lanelet, true) {
            ending.entry(edge).or_default().push(lanelet.id);
        }
    }
    let limit = |lanelet: &Lanelet| Some((lanelet.id, opposite_before(map, &ending, lanelet)?));
    let limits: Vec<(LaneletId, f64)> = map.lanelets.as_slice().par_iter().filter_map(limit).collect();
    for (id, metres) in limits {
        if let Some(lanelet) = map.lanelets.get_mut(id) {
            // Less than the way by a hand's breadth and rounded down, so that the blinker surely starts behind the other turn.
            let distance = ((metres - CLEAR) * 10.0).floor().max(0.0) / 10.0;
            lanelet.attributes.set("turn_signal_distance", format!("{distance:.1}"));
        }
    }
}

/// How far behind the end of an opposite turn this one starts, if that is nearer than the usual distance. Walks back,
/// the nearest first.
fn opposite_before(
    map: &LaneletMap,
    ending: &FxHashMap<[PointId; 2], Vec<LaneletId>>,
    lanelet: &Lanelet,
) -> Option<f64> {
    let opposite = match turn(lanelet)? {
        TurnDirection::Left => TurnDirection::Right,
        TurnDirection::Right => TurnDirection::Left,
        TurnDirection::Straight => return None,
    };
    let speed = lanelet.attributes.get("speed_limit").and_then(|v| v.parse().ok()).unwrap_or(USUAL_SPEED);
    let reach = ((DISTANCE + TIME * speed / 3.6) * PER_METRE) as u64;
    let mut seen = FxHashSet::from_iter([lanelet.id]);
    let mut open = BinaryHeap::from([(Reverse(0_u64), lanelet.id)]);
    while let Some((Reverse(gap), next)) = open.pop() {
        let Some(start) = map.lanelets.get(next).and_then(|l| edge(map, l, false)) else { continue };
        for before in ending.get(&start).into_iter().flatten().filter_map(|&id| map.lanelets.get(id)) {
            if !seen.insert(before.id) {
                continue;
            }
            if turn(before) == Some(opposite) {
                return Some(gap as f64 / PER_METRE);
            }
            let farther = gap + (length(map, before) * PER_METRE) as u64;
            if farther < reach {
                open.push((Reverse(farther), before.id));
            }
        }
    }
    None
}

fn turn(lanelet: &Lanelet) -> Option<TurnDirection> {
    lanelet.attributes.get("turn_direction").and_then(TurnDirection::parse)
}

/// The points that a lanelet starts or ends with: left, right.
fn edge(map: &LaneletMap, lanelet: &Lanelet, end: bool) -> Option<[PointId; 2]> {
    let point = |bound| {
        let mut points = map.bound_points(bound);
        if end { points.next_back() } else { points.next() }.map(|p| p.id)
    };
    Some([point(lanelet.left)?, point(lanelet.right)?])
}

/// Length of the shorter bound: never more than the way driven.
fn length(map: &LaneletMap, lanelet: &Lanelet) -> f64 {
    let along = |line: Vec<Point>| line.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>();
    along(map.bound_line(lanelet.left)).min(along(map.bound_line(lanelet.right)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::assembly::{Assembly, tags};
    use crate::builder::ids::Key;
    use crate::lanelet::Bound;

    /// Three lanelets in a row, each of this length: a right turn, a plain lane, a left turn.
    fn row(length: f64) -> (LaneletMap, LaneletId) {
        let mut assembly = Assembly::default();
        let key = |word: &'static str, i: i64| Key::new("row").word(word).number(i);
        let points: Vec<[PointId; 2]> = (0..4)
            .map(|i| {
                let y = length * i as f64;
                [
                    assembly.point(key("left", i), Point::new(0.0, y), 0.0),
                    assembly.point(key("right", i), Point::new(3.0, y), 0.0),
                ]
            })
            .collect();
        let mut last = LaneletId(0);
        for (i, turn) in [Some("right"), None, Some("left")].into_iter().enumerate() {
            let n = i as i64;
            let mut bound = |word, side: usize| Bound {
                line: assembly.line(key(word, n), vec![points[i][side], points[i + 1][side]], tags(&[])),
                inverted: false,
            };
            let (left, right) = (bound("left line", 0), bound("right line", 1));
            let mut attributes = tags(&[("speed_limit", "36")]);
            if let Some(turn) = turn {
                attributes.push("turn_direction", turn);
            }
            last = assembly.lanelet(key("lanelet", n), left, right, attributes);
        }
        (assembly.into_map(), last)
    }

    fn distance(length: f64) -> Option<String> {
        let (mut map, last) = row(length);
        limit(&mut map);
        map.lanelets.get(last)?.attributes.get("turn_signal_distance").map(str::to_owned)
    }

    #[test]
    fn a_near_opposite_turn_limits_the_blinker() {
        assert_eq!(distance(25.0).as_deref(), Some("24.9"));
    }

    #[test]
    fn a_far_one_does_not() {
        // 30 m and three seconds at 10 m/s.
        assert_eq!(distance(61.0), None);
    }
}
