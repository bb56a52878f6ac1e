//! Lanes of a network under the indices that their roads have in another that followed from it.

use crate::builder::network::RoadIx;
use crate::builder::network::network_diff::NetworkDiff;

use super::types::Lanes;

impl Lanes {
    /// The lanes of the roads that are left of a network, by the indices that these have now.
    #[must_use]
    pub fn reindexed(mut self, origins: &NetworkDiff) -> Self {
        let mut gone =
            origins.gone().map(|was| (was, self.range_of(was).len())).collect::<Vec<_>>().into_iter().peekable();
        let (mut was, mut fewer) = ((0..).map(RoadIx), 0);
        self.arms.retain_mut(|arms| {
            let Some(was) = was.next() else { return false };
            if let Some((_, lanes)) = gone.next_if(|(gone, _)| *gone == was) {
                fewer += lanes;
            }
            let Some(road) = origins.now(was) else { return false };
            for arm in arms {
                arm.at.road = road;
                arm.into.iter_mut().chain(&mut arm.out).for_each(|end| end.lane -= fewer);
            }
            true
        });
        let mut stays = (0..).map(|was| origins.now(RoadIx(was)).is_some());
        self.pieces.retain(|_| stays.next().unwrap_or_default());
        self.lanes.retain_mut(|lane| {
            let road = origins.now(lane.road);
            lane.road = road.unwrap_or(lane.road);
            road.is_some()
        });
        self
    }
}
