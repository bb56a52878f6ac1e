//! Lanes of a network under the indices of their roads in a later state of it.

use crate::builder::network::RoadIx;
use crate::builder::network::network_diff::NetworkDiff;

use super::types::{Arm, Lanes};

impl Lanes {
    /// The lanes of the roads that remain, under their present indices; a new road has none yet.
    #[must_use]
    pub fn reindexed(self, origins: &NetworkDiff) -> Self {
        let mut reindexed = Self::default();
        let mut known = self.lanes.into_iter().peekable();
        let mut of_roads: Vec<_> = self.arms.into_iter().zip(self.pieces).map(Some).collect();
        let mut first = 0;
        for (now, old) in origins.roads() {
            let Some((old, (mut arms, pieces))) =
                old.and_then(|old| Some((old, of_roads.get_mut(old.position())?.take()?)))
            else {
                reindexed.arms.push(Arm::undrawn(now));
                reindexed.pieces.push(Vec::new());
                continue;
            };
            while known.next_if(|lane| lane.road < old).is_some() {
                first += 1;
            }
            for arm in &mut arms {
                arm.at.road = now;
                let begin = reindexed.lanes.len();
                arm.into.iter_mut().chain(&mut arm.out).for_each(|end| end.lane = begin + end.lane - first);
            }
            while let Some(mut lane) = known.next_if(|lane| lane.road == old) {
                first += 1;
                lane.road = now;
                reindexed.lanes.push(lane);
            }
            reindexed.arms.push(arms);
            reindexed.pieces.push(pieces);
        }
        reindexed
    }

    /// Makes the arms of the roads behind this one refer to their lanes after it got `now` lanes in place of `before`.
    pub(super) fn move_behind(&mut self, road: RoadIx, before: usize, now: usize) {
        if before != now {
            let behind = self.arms.iter_mut().skip(road.position() + 1).flatten();
            let ends = behind.flat_map(|arm| arm.into.iter_mut().chain(&mut arm.out));
            ends.for_each(|end| end.lane = end.lane + now - before);
        }
    }
}
