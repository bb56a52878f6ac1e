//! Which lanelets of an intersection belong to a whole roundabout: those that join it, leave it and go on around its island.

use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Lanes;
use crate::builder::network::{Intersection, WholeRoundabouts};
use crate::geometry::{Point, cross};

/// An intersection at which a roundabout may be joined or left.
#[derive(Clone, Copy)]
pub struct RingMovements<'a> {
    /// The roundabouts of the map.
    pub roundabouts: &'a WholeRoundabouts,
    /// The lanes of the map.
    pub lanes: &'a Lanes,
    /// The intersection.
    pub at: &'a Intersection,
    /// All its lanelets.
    pub paths: &'a [TurningLanelet],
}

/// What a lanelet does at a roundabout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RingMovement {
    /// The roundabout, by the least OpenStreetMap node of its ring.
    pub ring: i64,
    /// Whether it comes from a street.
    pub joins: bool,
    /// Whether it leads into a street.
    pub leaves: bool,
}

impl RingMovement {
    /// Whether it goes on around the island.
    pub fn circulates(self) -> bool {
        !self.joins && !self.leaves
    }
}

impl RingMovements<'_> {
    /// What a lanelet does at a roundabout; `None` if its vehicles do not obey the rules of one. A lanelet from street to street
    /// joins the ring and leaves it at once; if it runs against the vehicles on the ring, or over the island, it is a street of its
    /// own.
    pub fn of(&self, path: &TurningLanelet) -> Option<RingMovement> {
        match self.rings(path) {
            [Some(from), Some(to)] => (from == to).then_some(RingMovement { ring: from, joins: false, leaves: false }),
            [Some(ring), None] => Some(RingMovement { ring, joins: false, leaves: true }),
            [None, Some(ring)] => Some(RingMovement { ring, joins: true, leaves: false }),
            [None, None] => {
                let mut around = self.paths.iter().filter_map(|it| match self.rings(it) {
                    [Some(from), Some(to)] if from == to => Some((from, self.ends(it)?)),
                    _ => None,
                });
                let (ring, circulating) = around.next()?;
                let outside = self.ends(path).is_some_and(|ends| passes_outside(ends, circulating));
                let is_alone = around.all(|(other, _)| other == ring);
                (outside && is_alone).then_some(RingMovement { ring, joins: true, leaves: true })
            }
        }
    }

    /// The roundabouts of the roads from and to which a lanelet leads.
    fn rings(&self, path: &TurningLanelet) -> [Option<i64>; 2] {
        [path.movement.from, path.movement.to].map(|arm| self.roundabouts.ring_of(self.at.arms[arm].road))
    }

    /// Where a lanelet begins and ends.
    fn ends(&self, path: &TurningLanelet) -> Option<[Point; 2]> {
        let movement = path.movement;
        let [from, to] = [movement.from, movement.to].map(|arm| self.lanes.arm(self.at.arms[arm]));
        Some([from.into.get(movement.in_lane)?.pose.point, to.out.get(movement.out_lane)?.pose.point])
    }
}

/// Whether the way between two places leads along a ring, of which a lanelet runs between two others, and stays on one side of it.
fn passes_outside([from, to]: [Point; 2], [begin, end]: [Point; 2]) -> bool {
    let around = end - begin;
    let side = |place: Point| cross(around, place - begin);
    (to - from).dot(&around) > 0.0 && side(from) * side(to) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a lanelet between two places, metres, passes outside a ring that runs from the origin 10 m to the west; its island lies
    /// to the south.
    fn passes(from: [f64; 2], to: [f64; 2]) -> bool {
        passes_outside([from, to].map(Point::from), [[0.0, 0.0], [-10.0, 0.0]].map(Point::from))
    }

    #[test]
    fn a_street_leads_into_the_next_beside_the_ring() {
        assert!(passes([5.0, 5.0], [-8.0, 10.0]));
    }

    #[test]
    fn a_street_that_runs_against_the_ring_or_over_its_island_is_none_of_it() {
        assert!(!passes([-8.0, 10.0], [5.0, 5.0]));
        assert!(!passes([-4.0, 10.0], [-5.0, -10.0]));
    }
}
