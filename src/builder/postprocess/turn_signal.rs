//! Sets `turn_signal_distance` where a turn follows closely behind a turn to the other side.
//!
//! Autoware starts the turn signal at a distance that grows with speed. It could start inside the opposite turn before;
//! `turn_signal_distance` shortens it to the distance between both turns.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::lanelet::index::Reach;
use crate::lanelet::{Bound, Lanelet, LaneletMap, PointId, TurnDirection};
use crate::parallel::InSmallParts;

/// Autoware starts the turn signal this distance before a turn, metres, ...
const DISTANCE: f64 = 30.0;
/// ... plus the distance driven in this time at the speed limit, seconds.
const TIME: f64 = 3.0;
/// The speed limit of a lanelet without one, km/h.
const DEFAULT_SPEED: f64 = 50.0;
/// The distance, metres, from the end of the opposite turn to the start of the signal.
const CLEARANCE: f64 = 0.1;
/// The least part of the length of the shorter bound that a centre line has: it is shorter than both where they bend at different
/// places.
const OF_BOUND: f64 = 0.98;
/// Lengths are whole millimetres, which have a total order.
const PER_METRE: f64 = 1e3;

/// Sets `turn_signal_distance` where Autoware's own distance reaches back into an opposite turn. `reaches` holds the extent of
/// each linestring of the map.
pub fn limit_turn_signals(map: &mut LaneletMap, reaches: &[Option<Reach>]) {
    let lanelets = map.lanelets.as_slice();
    let links = lanelets.par_iter().in_small_parts().map(|lanelet| Link::new(map, reaches, lanelet)).collect();
    let chains = LaneletChains::new(links);
    let limit = |(i, lanelet): (usize, &Lanelet)| Some((i, chains.distance_to_opposite_turn(i, lanelet)?));
    let limits: Vec<(usize, f64)> = lanelets.par_iter().in_small_parts().enumerate().filter_map(limit).collect();
    let lanelets = map.lanelets.as_mut_slice();
    for (i, metres) in limits {
        // Rounded down, so that the signal starts behind the other turn.
        let distance = ((metres - CLEARANCE) * 10.0).floor().max(0.0) / 10.0;
        lanelets[i].attributes.set("turn_signal_distance", format!("{distance:.1}"));
    }
}

/// A lanelet as part of a chain.
struct Link {
    /// The points at which it starts: left, right.
    start: Option<[PointId; 2]>,
    /// The points at which it ends.
    end: Option<[PointId; 2]>,
    turn: Option<TurnDirection>,
    /// The least length of its centre line, millimetres.
    length: u64,
}

impl Link {
    fn new(map: &LaneletMap, reaches: &[Option<Reach>], lanelet: &Lanelet) -> Self {
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
        let [start, end] = [false, true].map(edge);
        let middle = |ids: [PointId; 2]| {
            let [left, right] = ids.map(|id| map.points.get(id).map(|point| point.position));
            Some(nalgebra::center(&left?, &right?))
        };
        let chord = start.and_then(middle).zip(end.and_then(middle)).map_or(0.0, |(from, to)| (to - from).norm());
        let length = chord.max(OF_BOUND * left.min(right)).min(left.max(right));
        Self { start, end, turn, length: (length * PER_METRE) as u64 }
    }
}

/// The lanelets of a map, by index, and which of them follow each other.
struct LaneletChains {
    links: Vec<Link>,
    /// The last lanelet that ends at these points.
    last_ending: FxHashMap<[PointId; 2], usize>,
    /// For each lanelet, the one before it that ends at the same points.
    next_ending: Vec<Option<usize>>,
}

impl LaneletChains {
    fn new(links: Vec<Link>) -> Self {
        let mut last_ending = FxHashMap::default();
        last_ending.reserve(links.len());
        let next_ending = links.iter().enumerate().map(|(i, link)| last_ending.insert(link.end?, i)).collect();
        Self { links, last_ending, next_ending }
    }

    /// The distance, metres, from the end of an opposite turn to the start of a lanelet, if it is less than that at which
    /// Autoware starts the signal: Dijkstra's search against the direction of travel.
    fn distance_to_opposite_turn(&self, index: usize, lanelet: &Lanelet) -> Option<f64> {
        let opposite = match self.links[index].turn? {
            TurnDirection::Left => TurnDirection::Right,
            TurnDirection::Right => TurnDirection::Left,
            TurnDirection::Straight => return None,
        };
        let speed = lanelet.attributes.get("speed_limit").and_then(|v| v.parse().ok()).unwrap_or(DEFAULT_SPEED);
        let reach = ((DISTANCE + TIME * speed / 3.6) * PER_METRE) as u64;
        let mut seen = FxHashSet::from_iter([index]);
        let mut open = BinaryHeap::from([(Reverse(0_u64), index)]);
        while let Some((Reverse(distance), next)) = open.pop() {
            let Some(start) = self.links[next].start else { continue };
            let predecessors =
                std::iter::successors(self.last_ending.get(&start).copied(), |&before| self.next_ending[before]);
            for before in predecessors.filter(|before| seen.insert(*before)) {
                let link = &self.links[before];
                if link.turn == Some(opposite) {
                    return Some(distance as f64 / PER_METRE);
                }
                let farther = distance + link.length;
                if farther < reach {
                    open.push((Reverse(farther), before));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::ids::Key;
    use crate::builder::map::map_builder::{MapBuilder, MapPart};
    use crate::geometry::Point;
    use crate::lanelet::index::{center_line, reaches};
    use crate::lanelet::{Attributes, LaneletId};

    use super::*;

    /// Three lanelets in a row, each of this length, metres: a right turn, a straight lane, a left turn. The bounds of each bend outward
    /// by `bend`, metres: the left one in its first half, the right one in its second half.
    fn row(length: f64, bend: f64) -> (LaneletMap, LaneletId) {
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
            let mut bound = |word, side: usize| {
                let [x, part] = [[-bend, 0.25], [3.0 + bend, 0.75]][side];
                let y = length * (i as f64 + part);
                let middle = assembly.point(key(word, n).word("middle"), Point::new(x, y), 0.0);
                let nodes = vec![points[i][side], middle, points[i + 1][side]];
                Bound { line: assembly.line(key(word, n), nodes, Attributes::of(&[])), inverted: false }
            };
            let (left, right) = (bound("left line", 0), bound("right line", 1));
            let mut attributes = Attributes::of(&[("speed_limit", "36")]);
            if let Some(turn) = turn {
                attributes.push("turn_direction", turn);
            }
            last = assembly.lanelet(key("lanelet", n), left, right, attributes);
        }
        (assembly.finish(MapPart::default()), last)
    }

    fn distance(length: f64, bend: f64) -> Option<String> {
        let (mut map, last) = row(length, bend);
        let reaches = reaches(&map);
        limit_turn_signals(&mut map, &reaches);
        map.lanelets.get(last)?.attributes.get("turn_signal_distance").map(str::to_owned)
    }

    #[test]
    fn a_near_opposite_turn_limits_the_distance() {
        assert_eq!(distance(25.0, 0.0).as_deref(), Some("24.9"));
    }

    #[test]
    fn the_distance_is_no_longer_than_a_centre_line_that_is_shorter_than_both_bounds() {
        let (map, _) = row(25.0, 2.0);
        let lane = map.lanelets.as_slice().iter().find(|lanelet| !lanelet.attributes.has("turn_direction")).unwrap();
        let center = center_line(&map.bound_line(lane.left), &map.bound_line(lane.right)).unwrap().length();
        let signal: f64 = distance(25.0, 2.0).unwrap().parse().unwrap();
        assert!((24.5..center).contains(&signal), "{signal} m, the centre line has {center} m");
    }

    #[test]
    fn a_far_opposite_turn_does_not() {
        // 30 m and three seconds at 10 m/s.
        assert_eq!(distance(61.0, 0.0), None);
    }
}
