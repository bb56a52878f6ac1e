//! Where a vehicle can go from a lane: straight on, or over a border that it may cross.

use rustc_hash::FxHashMap;

use crate::lanelet::Bound;
use crate::lanelet::index::MapIndex;
use crate::lanelet::lane_change::{LaneChange, Participant};

/// A lane beside another one in the same direction.
pub struct Beside {
    /// Which one, as a position in `MapIndex::lanes`.
    pub lane: usize,
    /// Whether a vehicle may change into it.
    pub may_leave: bool,
    /// Whether a vehicle may change from it.
    pub may_enter: bool,
}

/// The lanes for vehicles and their neighbours in the same direction. Lanes are positions in `MapIndex::lanes`.
pub struct RoutingMoves<'m> {
    map: &'m MapIndex<'m>,
    by_left: FxHashMap<Bound, Vec<usize>>,
    by_right: FxHashMap<Bound, Vec<usize>>,
}

impl<'m> RoutingMoves<'m> {
    /// Looks at all lanes for vehicles.
    pub fn new(map: &'m MapIndex<'m>) -> Self {
        let mut moves = Self { map, by_left: FxHashMap::default(), by_right: FxHashMap::default() };
        for at in (0..map.lanes.len()).filter(|&at| map.lanes[at].vehicle) {
            let lanelet = map.lanes[at].lanelet;
            moves.by_left.entry(lanelet.left).or_default().push(at);
            moves.by_right.entry(lanelet.right).or_default().push(at);
        }
        moves
    }

    /// The lanes over a bound of a lane; `is_left` says which one.
    fn across(&self, bound: Bound, is_left: bool) -> Vec<Beside> {
        let over = LaneChange::over(self.map.map, bound, Participant::Vehicle);
        let [may_leave, may_enter] = match is_left {
            true => [over.to_left, over.to_right],
            false => [over.to_right, over.to_left],
        };
        let lanes = if is_left { &self.by_right } else { &self.by_left };
        lanes.get(&bound).into_iter().flatten().map(|&lane| Beside { lane, may_leave, may_enter }).collect()
    }

    /// Lanes beside one.
    pub fn beside(&self, at: usize) -> Vec<Beside> {
        let lanelet = self.map.lanes[at].lanelet;
        let mut found = self.across(lanelet.left, true);
        found.extend(self.across(lanelet.right, false));
        found.retain(|other| other.lane != at);
        found
    }

    /// Lanes beside one on its left, whatever their border.
    pub fn on_the_left(&self, at: usize) -> Vec<usize> {
        self.across(self.map.lanes[at].lanelet.left, true).into_iter().map(|other| other.lane).collect()
    }

    /// Lanes beside one on its right, whatever their border.
    pub fn on_the_right(&self, at: usize) -> Vec<usize> {
        self.across(self.map.lanes[at].lanelet.right, false).into_iter().map(|other| other.lane).collect()
    }

    /// Whether a vehicle can drive on from the end of a lane, or of one that it can change into.
    pub fn leads_on(&self, at: usize) -> bool {
        self.reaches(at, |other| other.may_leave, |lane| !self.map.followers(lane).is_empty())
    }

    /// Whether a vehicle can reach a lane from another one.
    pub fn is_led_to(&self, at: usize) -> bool {
        self.reaches(at, |other| other.may_enter, |lane| !self.map.predecessors(lane).is_empty())
    }

    /// Whether this holds of a lane, or of any that lane changes lead to, or from.
    fn reaches(&self, at: usize, is_open: fn(&Beside) -> bool, holds: impl Fn(usize) -> bool) -> bool {
        let mut seen = vec![at];
        let mut next = 0;
        while let Some(&lane) = seen.get(next) {
            if holds(lane) {
                return true;
            }
            for other in self.beside(lane).into_iter().filter(is_open) {
                if !seen.contains(&other.lane) {
                    seen.push(other.lane);
                }
            }
            next += 1;
        }
        false
    }
}
