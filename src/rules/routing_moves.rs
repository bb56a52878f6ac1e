//! Where a vehicle can go from a lane: straight on, or over a border that it may cross.

use rustc_hash::FxHashMap;

use crate::lanelet::Bound;
use crate::lanelet::index::{MapIndex, allows_lane_change};

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

    fn across(&self, bound: Bound, lanes: &FxHashMap<Bound, Vec<usize>>) -> Vec<(usize, bool)> {
        let open = self.map.map.linestrings.get(bound.line).is_some_and(allows_lane_change);
        lanes.get(&bound).into_iter().flatten().map(|&other| (other, open)).collect()
    }

    /// Lanes beside one, and whether their common border may be crossed.
    pub fn beside(&self, at: usize) -> Vec<(usize, bool)> {
        let lanelet = self.map.lanes[at].lanelet;
        let mut found = self.across(lanelet.left, &self.by_right);
        found.extend(self.across(lanelet.right, &self.by_left));
        found.retain(|(other, _)| *other != at);
        found
    }

    /// Lanes beside one on its left, whatever their border.
    pub fn on_the_left(&self, at: usize) -> Vec<usize> {
        self.across(self.map.lanes[at].lanelet.left, &self.by_right).into_iter().map(|(other, _)| other).collect()
    }

    /// Lanes beside one on its right, whatever their border.
    pub fn on_the_right(&self, at: usize) -> Vec<usize> {
        self.across(self.map.lanes[at].lanelet.right, &self.by_left).into_iter().map(|(other, _)| other).collect()
    }

    /// Whether a vehicle can drive on from the end of a lane, or of one that it can change into.
    pub fn leads_on(&self, at: usize) -> bool {
        self.reaches(at, |lane| !self.map.followers(lane).is_empty())
    }

    /// Whether a vehicle can reach a lane from another one.
    pub fn is_led_to(&self, at: usize) -> bool {
        self.reaches(at, |lane| !self.map.predecessors(lane).is_empty())
    }

    /// Whether this holds of a lane, or of any lane connected with it by lane changes.
    fn reaches(&self, at: usize, holds: impl Fn(usize) -> bool) -> bool {
        let mut seen = vec![at];
        let mut next = 0;
        while let Some(&lane) = seen.get(next) {
            if holds(lane) {
                return true;
            }
            for (other, open) in self.beside(lane) {
                if open && !seen.contains(&other) {
                    seen.push(other);
                }
            }
            next += 1;
        }
        false
    }
}
