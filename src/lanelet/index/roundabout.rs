//! Roundabouts, told by the lanes alone: rings around an island, and which lanes join and leave them.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::types::{DrivingSide, MapIndex};
use crate::geometry::{Point, Polyline, Vector, angle_between, polygon};
use crate::lanelet::TurnDirection;

/// A ring of lanes no longer than this (m) is a roundabout if it turns by at least `LEAST_TURN` on each twelfth of its length ...
const LONGEST_RING: f64 = 800.0;
/// ... (deg). A circle turns by 30; a block of houses does not turn at all between its corners.
const LEAST_TURN: f64 = 8.0;
/// A shorter ring (m), which others only join and leave, may be drawn over few corners, if it encloses this share of what a circle of its
/// length does ...
const SHORT_RING: f64 = 200.0;
const ROUND: f64 = 0.9;
/// ... or it may be an oval or pinched in the middle, if it turns by no more than this (deg) on any twelfth of its length. The aisles around a
/// block of stands are neither: they turn at their corners alone.
const MOST_TURN: f64 = 70.0;
/// A longer ring over few corners encloses this share: an octagon does.
const ROUND_LONG: f64 = 0.93;

impl MapIndex<'_> {
    /// Whether the rules of a roundabout say who goes first where two lanes meet, so that this is no intersection: both are part of it,
    /// join it or leave it. But who joins where another leaves crosses the other's way, unless a roundabout element names both: then
    /// Autoware waits at the entry for all lanes that cross it.
    pub(super) fn is_ruled_by_roundabout(&self, x: usize, y: usize) -> bool {
        if self.share_roundabout_element(x, y) {
            return true;
        }
        let [a, b] = [x, y].map(|lane| self.ends_on_roundabout(lane));
        // Who circulates stops for nobody: where there is a stop line, other rules hold.
        let stops = |lane: usize, ends: [bool; 2]| ends == [true; 2] && self.starts_at_stop_line(lane);
        let one_joins_where_other_leaves = a[0] != a[1] && b == [a[1], a[0]];
        let are_part = a.contains(&true) && b.contains(&true);
        are_part && !one_joins_where_other_leaves && !stops(x, a) && !stops(y, b)
    }

    /// Whether one roundabout element names both lanes.
    pub fn share_roundabout_element(&self, x: usize, y: usize) -> bool {
        let of = |lane: usize| self.elements_naming(self.lanes[lane].id).filter(|it| it.subtype == "roundabout");
        of(x).any(|element| of(y).any(|other| other.id == element.id))
    }

    /// Whether a lane is part of a roundabout, leaves it or joins it.
    pub fn is_at_roundabout(&self, lane: usize) -> bool {
        self.ends_on_roundabout(lane) != [false; 2]
    }

    /// Whether a lane starts on a roundabout and whether it ends there. A lane beside one that leads around the island is part of the
    /// roundabout, too, though it may lead only to the next exit.
    fn ends_on_roundabout(&self, lane: usize) -> [bool; 2] {
        *self.ends_on_roundabout[lane].get_or_init(|| self.look_for_roundabout(lane))
    }

    fn look_for_roundabout(&self, lane: usize) -> [bool; 2] {
        let leads_around = |lane: usize| *self.on_roundabout[lane].get_or_init(|| self.leads_around_island(lane));
        let circulates = |&lane: &usize| self.carriageway(&[lane]).into_iter().any(leads_around);
        if circulates(&lane) {
            return [true; 2];
        }
        let joined = self.ending.get(&self.lanes[lane].end.ids).into_iter().flatten();
        [
            self.predecessors(lane).iter().any(circulates) || self.siblings(lane).any(|other| circulates(&other)),
            self.followers(lane).iter().chain(joined).any(circulates),
        ]
    }

    /// Whether the shortest way from a lane back to itself is a roundabout.
    fn leads_around_island(&self, lane: usize) -> bool {
        let mut before: FxHashMap<usize, usize> = FxHashMap::default();
        let mut open = BTreeSet::from([(0, lane)]);
        while let Some((metres, at)) = open.pop_first() {
            for &next in self.followers(at) {
                if next == lane {
                    return self.goes_around(&ring(lane, at, &before));
                }
                let reached = metres + self.lanes[next].length().ceil() as u64;
                if reached as f64 <= LONGEST_RING && !before.contains_key(&next) {
                    before.insert(next, at);
                    open.insert((reached, next));
                }
            }
        }
        false
    }

    /// Whether a ring of lanes runs around an island as roundabouts do.
    fn goes_around(&self, ring: &[usize]) -> bool {
        let turn: f64 = ring.iter().map(|&lane| self.lanes[lane].turn()).sum();
        let far = match self.side.side.map(DrivingSide::far_turn) {
            Some(TurnDirection::Right) => turn < 0.0,
            Some(_) => turn > 0.0,
            None => true,
        };
        let is_two_way = ring.iter().any(|&lane| self.has_oncoming_inside(lane, turn > 0.0));
        let Some(line) = self.middle_of(ring).filter(|_| far && !is_two_way) else { return false };
        match RingShape::of(&line) {
            RingShape::Round => true,
            RingShape::Open => !ring.iter().any(|&lane| self.is_crossed(lane)),
            RingShape::Other => false,
        }
    }

    /// Whether cars come the other way beside a lane, on its left or on its right: around a small block, and never inside a roundabout.
    fn has_oncoming_inside(&self, lane: usize, is_left: bool) -> bool {
        let side = usize::from(!is_left);
        let inner = self.lanes[lane].bounds[side];
        self.users_of(inner).iter().any(|&other| other != lane && self.lanes[other].bounds[side] == inner)
    }

    /// The closed line along the middle of a ring of lanes.
    fn middle_of(&self, ring: &[usize]) -> Option<Polyline> {
        let centers = ring.iter().filter_map(|&lane| self.lanes[lane].center.as_ref());
        let mut places: Vec<Point> = centers.flat_map(|center| center.points().iter().copied()).collect();
        places.extend(places.first().copied());
        Polyline::new(places)
    }
}

/// How a one-way ring of streets looks to those who come to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RingShape {
    /// It turns all the way around: a roundabout.
    Round,
    /// With few corners, or short and an oval or pinched in the middle: a roundabout if others only join and leave it.
    Open,
    /// Long and with straight sides, as around a block of houses.
    Other,
}

impl RingShape {
    /// The shape of a closed line.
    pub fn of(closed: &Polyline) -> Self {
        let line = closed.resampled_to(24);
        let [least, most] = bends(&line);
        if closed.length() <= LONGEST_RING && (least >= LEAST_TURN || most <= -LEAST_TURN) {
            return Self::Round;
        }
        let has_no_corner = least.abs().max(most.abs()) <= MOST_TURN;
        let circle = line.length().powi(2) / (4.0 * std::f64::consts::PI);
        let share = polygon::signed_area(line.points()).abs() / circle;
        match closed.length() {
            length if length <= SHORT_RING && (has_no_corner || share >= ROUND) => Self::Open,
            length if length <= LONGEST_RING && share >= ROUND_LONG => Self::Open,
            _ => Self::Other,
        }
    }
}

/// The least and the largest turn (deg, left positive) of a closed line of 24 pieces on a twelfth of its length.
fn bends(line: &Polyline) -> [f64; 2] {
    let chords: Vec<Vector> = line.segments().map(|(from, to)| to - from).collect();
    let turns = (0..chords.len()).map(|at| angle_between(chords[at], chords[(at + 2) % chords.len()]).to_degrees());
    turns.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], turn| [low.min(turn), high.max(turn)])
}

/// The lanes from one to another, each the follower of the one `before` it.
fn ring(first: usize, last: usize, before: &FxHashMap<usize, usize>) -> Vec<usize> {
    let mut ring: Vec<usize> = vec![last];
    while let Some(&previous) = ring.last().and_then(|at| before.get(at)) {
        ring.push(previous);
    }
    if last != first && ring.last() != Some(&first) {
        ring.push(first);
    }
    ring.reverse();
    ring
}
