//! Lanes of a network under the indices of their roads in a network that followed from it.

use crate::builder::network::RoadIx;
use crate::builder::network::network_diff::NetworkDiff;

use super::types::Lanes;

impl Lanes {
    /// The lanes of the roads that remain, under their present indices.
    #[must_use]
    pub fn reindexed(mut self, origins: &NetworkDiff) -> Self {
        let gone: Vec<(RoadIx, usize)> = origins.gone().map(|road| (road, self.range_of(road).len())).collect();
        let (mut gone, mut removed) = (gone.into_iter().peekable(), 0);
        let mut roads = (0..).map(RoadIx);
        self.arms.retain_mut(|arms| {
            let Some(before) = roads.next() else { return false };
            removed += gone.next_if(|(road, _)| *road == before).map_or(0, |(_, lanes)| lanes);
            let Some(road) = origins.now(before) else { return false };
            for arm in arms {
                arm.at.road = road;
                arm.into.iter_mut().chain(&mut arm.out).for_each(|end| end.lane -= removed);
            }
            true
        });
        let mut stays = (0..).map(|road| origins.now(RoadIx(road)).is_some());
        self.pieces.retain(|_| stays.next().unwrap_or_default());
        self.lanes.retain_mut(|lane| {
            let road = origins.now(lane.road);
            lane.road = road.unwrap_or(lane.road);
            road.is_some()
        });
        self
    }
}
