//! Where two turns to different sides follow each other closely, says from where to blink for the second one.
//!
//! Autoware blinks from a distance that grows with speed, so that the blinker for a turn could start inside an opposite
//! turn before it. `turn_signal_distance` shortens it to the way between the two.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::OnceLock;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::geometry::Point;
use crate::lanelet::{Bound, Lanelet, LaneletId, LaneletMap, PointId, TurnDirection};

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
    let lanelets = map.lanelets.as_slice();
    let mut ways = Ways { map, ending: FxHashMap::default(), lengths: Vec::new() };
    ways.lengths.resize_with(lanelets.len(), OnceLock::new);
    for (at, lanelet) in lanelets.iter().enumerate() {
        if let Some(edge) = edge(map, lanelet, true) {
            ways.ending.entry(edge).or_default().push(at);
        }
    }
    let limit = |(at, lanelet): (usize, &Lanelet)| Some((lanelet.id, ways.opposite_before(at)?));
    let limits: Vec<(LaneletId, f64)> = lanelets.par_iter().enumerate().filter_map(limit).collect();
    for (id, metres) in limits {
        if let Some(lanelet) = map.lanelets.get_mut(id) {
            // Less than the way by a hand's breadth and rounded down, so that the blinker surely starts behind the other turn.
            let distance = ((metres - CLEAR) * 10.0).floor().max(0.0) / 10.0;
            lanelet.attributes.set("turn_signal_distance", format!("{distance:.1}"));
        }
    }
}

/// The lanelets of a map, by position, as they follow each other.
struct Ways<'m> {
    map: &'m LaneletMap,
    ending: FxHashMap<[PointId; 2], Vec<usize>>,
    /// Many ways back pass the same lanelets.
    lengths: Vec<OnceLock<f64>>,
}

impl Ways<'_> {
    /// How far behind the end of an opposite turn a lanelet starts, if that is nearer than the usual distance. Walks back,
    /// the nearest first.
    fn opposite_before(&self, at: usize) -> Option<f64> {
        let lanelets = self.map.lanelets.as_slice();
        let lanelet = &lanelets[at];
        let opposite = match turn(lanelet)? {
            TurnDirection::Left => TurnDirection::Right,
            TurnDirection::Right => TurnDirection::Left,
            TurnDirection::Straight => return None,
        };
        let speed = lanelet.attributes.get("speed_limit").and_then(|v| v.parse().ok()).unwrap_or(USUAL_SPEED);
        let reach = ((DISTANCE + TIME * speed / 3.6) * PER_METRE) as u64;
        let mut seen = FxHashSet::from_iter([at]);
        let mut open = BinaryHeap::from([(Reverse(0_u64), lanelet.id, at)]);
        while let Some((Reverse(gap), _, next)) = open.pop() {
            let Some(start) = edge(self.map, &lanelets[next], false) else { continue };
            for &at in self.ending.get(&start).into_iter().flatten() {
                let before = &lanelets[at];
                if !seen.insert(at) {
                    continue;
                }
                if turn(before) == Some(opposite) {
                    return Some(gap as f64 / PER_METRE);
                }
                let length = *self.lengths[at].get_or_init(|| length(self.map, before));
                let farther = gap + (length * PER_METRE) as u64;
                if farther < reach {
                    open.push((Reverse(farther), before.id, at));
                }
            }
        }
        None
    }
}

fn turn(lanelet: &Lanelet) -> Option<TurnDirection> {
    lanelet.attributes.get("turn_direction").and_then(TurnDirection::parse)
}

/// The points that a lanelet starts or ends with: left, right.
fn edge(map: &LaneletMap, lanelet: &Lanelet, end: bool) -> Option<[PointId; 2]> {
    let point = |bound: Bound| {
        let points = &map.linestrings.get(bound.line)?.points;
        if bound.inverted == end { points.first() } else { points.last() }.copied()
    };
    Some([point(lanelet.left)?, point(lanelet.right)?])
}

/// Length of the shorter bound: never more than the way driven.
fn length(map: &LaneletMap, lanelet: &Lanelet) -> f64 {
    let along = |bound: Bound| {
        let Some(line) = map.linestrings.get(bound.line) else { return 0.0 };
        let mut before: Option<Point> = None;
        let places = map.points.get_each(line.points.iter().copied()).map(|point| point.position);
        places.map(|at| before.replace(at).map_or(0.0, |before| (at - before).norm())).sum::<f64>()
    };
    along(lanelet.left).min(along(lanelet.right))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::assembly::{Assembly, tags};
    use crate::builder::ids::Key;

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
