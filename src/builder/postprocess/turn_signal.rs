//! Where two turns to different sides follow each other closely, says from where to blink for the second one.
//!
//! Autoware blinks from a distance that grows with speed, so that the blinker for a turn could start inside an opposite
//! turn before it. `turn_signal_distance` shortens it to the way between the two.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::lanelet::index::Reach;
use crate::lanelet::{Bound, Lanelet, LaneletMap, PointId, TurnDirection};
use crate::parallel::Finely;

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

/// Sets `turn_signal_distance` wherever the usual distance reaches back into an opposite turn. Each line of the map reaches
/// as far as its place among `reaches` says.
pub fn limit_turn_signals(map: &mut LaneletMap, reaches: &[Option<Reach>]) {
    let lanelets = map.lanelets.as_slice();
    let ways =
        TurnChains::new(lanelets.par_iter().finely().map(|lanelet| TurnChain::of(map, reaches, lanelet)).collect());
    let limit = |(at, lanelet): (usize, &Lanelet)| Some((at, ways.opposite_before(at, lanelet)?));
    let limits: Vec<(usize, f64)> = lanelets.par_iter().finely().enumerate().filter_map(limit).collect();
    let lanelets = map.lanelets.as_mut_slice();
    for (at, metres) in limits {
        // Less than the way by a hand's breadth and rounded down, so that the blinker surely starts behind the other turn.
        let distance = ((metres - CLEAR) * 10.0).floor().max(0.0) / 10.0;
        lanelets[at].attributes.set("turn_signal_distance", format!("{distance:.1}"));
    }
}

/// What a way back needs to know of a lanelet.
struct TurnChain {
    /// The points that it starts with: left, right.
    start: Option<[PointId; 2]>,
    /// The points that it ends with.
    end: Option<[PointId; 2]>,
    turn: Option<TurnDirection>,
    /// That of the shorter bound: never more than the way driven.
    length: u64,
}

impl TurnChain {
    fn of(map: &LaneletMap, reaches: &[Option<Reach>], lanelet: &Lanelet) -> Self {
        let lines = [lanelet.left, lanelet.right].map(|bound| map.linestrings.position(bound.line));
        let edge = |end: bool| {
            let point = |bound: Bound, line: Option<usize>| {
                let points = &map.linestrings.as_slice()[line?].points;
                if bound.inverted == end { points.first() } else { points.last() }.copied()
            };
            Some([point(lanelet.left, lines[0])?, point(lanelet.right, lines[1])?])
        };
        let [left, right] = lines.map(|line| reaches[line?].map(|reach| reach.length)).map(Option::unwrap_or_default);
        let turn = lanelet.attributes.get("turn_direction").and_then(TurnDirection::parse);
        Self { start: edge(false), end: edge(true), turn, length: (left.min(right) * PER_METRE) as u64 }
    }
}

/// The lanelets of a map, by position, as they follow each other.
struct TurnChains {
    ways: Vec<TurnChain>,
    /// The last that ends with these points.
    ending: FxHashMap<[PointId; 2], usize>,
    /// For each way the one before it that ends with the same points.
    beside: Vec<Option<usize>>,
}

impl TurnChains {
    fn new(ways: Vec<TurnChain>) -> Self {
        let mut ending = FxHashMap::default();
        ending.reserve(ways.len());
        let beside = ways.iter().enumerate().map(|(at, way)| ending.insert(way.end?, at)).collect();
        Self { ways, ending, beside }
    }

    /// How far behind the end of an opposite turn a lanelet starts, if that is nearer than the usual distance. Walks back,
    /// the nearest first.
    fn opposite_before(&self, at: usize, lanelet: &Lanelet) -> Option<f64> {
        let opposite = match self.ways[at].turn? {
            TurnDirection::Left => TurnDirection::Right,
            TurnDirection::Right => TurnDirection::Left,
            TurnDirection::Straight => return None,
        };
        let speed = lanelet.attributes.get("speed_limit").and_then(|v| v.parse().ok()).unwrap_or(USUAL_SPEED);
        let reach = ((DISTANCE + TIME * speed / 3.6) * PER_METRE) as u64;
        let mut seen = FxHashSet::from_iter([at]);
        let mut open = BinaryHeap::from([(Reverse(0_u64), at)]);
        while let Some((Reverse(gap), next)) = open.pop() {
            let Some(start) = self.ways[next].start else { continue };
            let mut before = self.ending.get(&start).copied();
            while let Some(at) = before {
                let way = &self.ways[at];
                before = self.beside[at];
                if !seen.insert(at) {
                    continue;
                }
                if way.turn == Some(opposite) {
                    return Some(gap as f64 / PER_METRE);
                }
                let farther = gap + way.length;
                if farther < reach {
                    open.push((Reverse(farther), at));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::ids::Key;
    use crate::builder::map::map_builder::MapBuilder;
    use crate::geometry::Point;
    use crate::lanelet::index::reaches;
    use crate::lanelet::{Attributes, LaneletId};

    use super::*;

    /// Three lanelets in a row, each of this length: a right turn, a plain lane, a left turn.
    fn row(length: f64) -> (LaneletMap, LaneletId) {
        let mut assembly = MapBuilder::default();
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
                line: assembly.line(key(word, n), vec![points[i][side], points[i + 1][side]], Attributes::of(&[])),
                inverted: false,
            };
            let (left, right) = (bound("left line", 0), bound("right line", 1));
            let mut attributes = Attributes::of(&[("speed_limit", "36")]);
            if let Some(turn) = turn {
                attributes.push("turn_direction", turn);
            }
            last = assembly.lanelet(key("lanelet", n), left, right, attributes);
        }
        (assembly.into_map(), last)
    }

    fn distance(length: f64) -> Option<String> {
        let (mut map, last) = row(length);
        let reaches = reaches(&map);
        limit_turn_signals(&mut map, &reaches);
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
