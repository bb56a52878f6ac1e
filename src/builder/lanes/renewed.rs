//! Lanes of a network under the indices that their roads have in another that followed from it.

use crate::builder::origins::Origins;
use crate::builder::road_network::RoadIx;

use super::{Lane, Lanes};

impl Lanes {
    /// The lanes of the roads that are left of a network, by the indices that these have now.
    #[must_use]
    pub fn renamed(self, origins: &Origins) -> Self {
        let mut left = Self::default();
        let mut lanes = self.lanes.into_iter().peekable();
        let mut first = 0;
        for (was, (mut arms, pieces)) in (0..).map(RoadIx).zip(self.arms.into_iter().zip(self.pieces)) {
            let begin = left.lanes.len();
            let own = std::iter::from_fn(|| lanes.next_if(|lane| lane.road == was));
            let Some(road) = origins.now(was) else {
                first += own.count();
                continue;
            };
            left.lanes.extend(own.map(|lane| Lane { road, ..lane }));
            for arm in &mut arms {
                arm.at.road = road;
                arm.into.iter_mut().chain(&mut arm.out).for_each(|end| end.lane = end.lane - first + begin);
            }
            first += left.lanes.len() - begin;
            left.arms.push(arms);
            left.pieces.push(pieces);
        }
        left
    }
}
