//! The lanes of one-way carriageways of main roads of which neither their own tags nor another way tells them.
//!
//! Most have two or more: of the tagged kilometres of such carriageways in 54 extracts of cities 88 % (primary) and 92 % (secondary).
//! Carriageways around an island of a two-way road have the lanes of that road. One lane is left where two have no room or lead nowhere:
//! beside a carriageway drawn close by, and along a street that ends in a roundabout with one lane.

use crate::builder::tags::cross_section::{Assumed, StripKind, Travel};
use crate::geometry::angle_between;

use super::End;
use super::way_cross_sections::{TAGS_FOLLOWED, WayGraph, WayLanes, directions, only, opposite};

/// The lanes of a carriageway of a main road.
const USUAL: usize = 2;
/// Carriageways no longer than this together, metres, that lead from a two-way road or to one pass an island of it.
const ISLAND: f64 = 150.0;
/// The most that a carriageway turns where it leaves the two-way road to pass an island, degrees.
const AROUND_ISLAND: f64 = 45.0;
/// Carriageways of two lanes lie at least this far apart from line to line, metres: four halves of lanes of 3 m, and a metre between.
const ROOM: f64 = 7.0;
/// How many ways are followed along a street.
const WAYS_MOST: usize = 16;

/// Where a street leads.
enum Goal {
    /// To a roundabout, or a ring drawn as one way, with one lane.
    NarrowRing,
    /// To a two-way road that has so many lanes in the direction of the street.
    TwoWay(usize),
    /// Elsewhere.
    Other,
}

impl WayGraph<'_> {
    /// The lanes of a one-way carriageway of a main road without any tags that tell them.
    pub(super) fn untold(&self, way: usize) -> Option<Assumed> {
        let own = self.ways.get(&way).filter(|own| !own.tagged)?;
        let (middle, direction) = own.carriageway?;
        let &(kind, travel) =
            own.lanes.first().filter(|_| own.lanes.iter().all(|(kind, _)| *kind == StripKind::Drive))?;
        let goals = End::BOTH.map(|end| self.goal(way, end, travel));
        let length: f64 = own.length + goals.iter().map(|(length, _)| length).sum::<f64>();
        let of_two_way = goals.iter().filter_map(|(_, goal)| match goal {
            Goal::TwoWay(lanes) => Some(*lanes),
            _ => None,
        });
        let is_narrow = || {
            let to_ring = goals.iter().any(|(_, goal)| matches!(goal, Goal::NarrowRing));
            to_ring || self.carriageways.opposite_within(ROOM, middle, direction)
        };
        let (lanes, like) = match of_two_way.min().filter(|_| length <= ISLAND) {
            Some(lanes) => (lanes, "the two-way road has in this direction"),
            None if is_narrow() => return None,
            None => (USUAL.max(own.lanes.len()), "most carriageways of main roads have"),
        };
        Some(Assumed { lanes: vec![(kind, travel); lanes], like: like.to_owned() })
    }

    /// How far the carriageways of a street lead on beyond an end, metres, and where they lead. `travel` is the direction along `way`.
    fn goal(&self, mut way: usize, mut end: End, mut travel: Travel) -> (f64, Goal) {
        let mut length = 0.0;
        for _ in 0..WAYS_MOST {
            if self.narrow_rings.contains(&self.ways[&way].nodes[end]) {
                return (length, Goal::NarrowRing);
            }
            // First the two-way road: where it begins, the other carriageway leads away from the same node.
            if let Some(lanes) = self.two_way_at(way, end, travel) {
                return (length, Goal::TwoWay(lanes));
            }
            let Some((next, entry)) = self.beyond(way, end) else { break };
            if entry == end {
                travel = opposite(travel);
            }
            length += self.ways[&next].length;
            (way, end) = (next, entry.other());
            if length > TAGS_FOLLOWED {
                break;
            }
        }
        (length, Goal::Other)
    }

    /// How many lanes the two-way road of the same class and name that continues a carriageway at an end has in the direction `travel` along
    /// the carriageway.
    fn two_way_at(&self, way: usize, end: End, travel: Travel) -> Option<usize> {
        let own = &self.ways[&way];
        let leads_on = |&(other, entry): &(usize, End)| {
            let WayLanes { kind, outward, lanes, .. } = &self.ways[&other];
            let turn = angle_between(own.outward[end], -outward[entry]).abs().to_degrees();
            other != way && directions(lanes) == [true; 2] && *kind == own.kind && turn <= AROUND_ISLAND
        };
        let (other, entry) = only(self.ends[&own.nodes[end]].iter().copied().filter(leads_on))?;
        let travel = if entry == end { opposite(travel) } else { travel };
        Some(self.ways[&other].lanes.iter().filter(|&&lane| lane == (StripKind::Drive, travel)).count().max(1))
    }
}
