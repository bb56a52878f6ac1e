//! Edits of stitched lanes: only the lanes that meet the ends of the edited lanes are stitched and painted again.

use std::collections::{BTreeMap, BTreeSet};

use super::joint::Pull;
use super::lane::Node;
use super::{Lane, LaneEnd, LaneId, LaneStitching, Meeting};

/// The new lane of each id; `None` removes it.
type Edits = BTreeMap<LaneId, Option<Lane>>;

impl LaneStitching {
    /// Adds or replaces a lane. Returns the lanes that were drawn again.
    pub fn set(&mut self, id: LaneId, lane: Lane) -> Vec<LaneId> {
        self.edit(Edits::from([(id, Some(lane))]))
    }

    /// Removes a lane. Returns the lanes that were drawn again, and the removed one.
    pub fn remove(&mut self, id: LaneId) -> Vec<LaneId> {
        self.edit(Edits::from([(id, None)]))
    }

    /// Replaces all lanes of a road by these lanes, numbered from 0. Returns the lanes that were drawn again, and the removed
    /// ones.
    pub fn set_road(&mut self, road: i64, lanes: impl IntoIterator<Item = Lane>) -> Vec<LaneId> {
        let id = |lane: u32| LaneId { road, lane };
        let mut edits: Edits = self.lanes.range(id(0)..=id(u32::MAX)).map(|(id, _)| (*id, None)).collect();
        edits.extend((0..).map(id).zip(lanes.into_iter().map(Some)));
        self.edit(edits)
    }

    /// Excludes a lane from all joints while it is dragged, so that lanes which it passes do not jump; `None` ends this. The
    /// other lanes are stitched as if it did not exist. Returns the lanes that were drawn again.
    pub fn exclude(&mut self, id: Option<LaneId>) -> Vec<LaneId> {
        let concerned = self.excluded.into_iter().chain(id);
        let nodes = concerned.filter_map(|id| self.lane(id)).flat_map(nodes).collect();
        self.change(&nodes, BTreeSet::new(), |stitching| stitching.excluded = id)
    }

    /// The excluded lane.
    pub fn excluded(&self) -> Option<LaneId> {
        self.excluded
    }

    fn edit(&mut self, edits: Edits) -> Vec<LaneId> {
        let before = edits.keys().filter_map(|id| self.lane(*id));
        let nodes = before.chain(edits.values().flatten()).flat_map(nodes).collect();
        let edited = edits.iter().filter(|(id, lane)| lane.is_some() || self.lanes.contains_key(id));
        let edited = edited.map(|(id, _)| *id).collect();
        self.change(&nodes, edited, |stitching| {
            for (id, lane) in edits {
                stitching.take(id);
                if let Some(lane) = lane {
                    stitching.put(id, lane);
                }
            }
        })
    }

    /// Changes some lanes and how the ends on some nodes meet. A joint depends only on the two lanes that it joins, before
    /// stitching, so that only the lanes joined on those nodes, before or after, can change.
    fn change(
        &mut self,
        nodes: &BTreeSet<Node>,
        edited: BTreeSet<LaneId>,
        change: impl FnOnce(&mut Self),
    ) -> Vec<LaneId> {
        let mut concerned: BTreeSet<LaneId> = self.joined_on(nodes).collect();
        change(self);
        concerned.extend(self.joined_on(nodes));
        concerned.extend(&edited);
        let mut drawn = Vec::new();
        for id in concerned {
            let Some(entry) = self.lanes.get(&id) else {
                drawn.push(id);
                continue;
            };
            let pulls = LaneEnd::BOTH.map(|end| {
                if nodes.contains(&entry.lane.node(end)) { self.pull(id, end) } else { entry.pulls[end.index()] }
            });
            if edited.contains(&id) || entry.pulls.map(bits) != pulls.map(bits) {
                self.draw(id, pulls);
                drawn.push(id);
            }
        }
        drawn
    }

    /// The lanes that are joined to another lane on one of these nodes.
    fn joined_on(&self, nodes: &BTreeSet<Node>) -> impl Iterator<Item = LaneId> {
        let ends = nodes.iter().filter_map(|node| self.ends.pair_at(*node, self.excluded)).flatten();
        ends.filter(|(id, end)| matches!(self.meeting(*id, *end), Some(Meeting::Joined(_)))).map(|(id, _)| id)
    }
}

fn nodes(lane: &Lane) -> [Node; 2] {
    LaneEnd::BOTH.map(|end| lane.node(end))
}

/// The bits of pulls: 0 and -0 differ.
fn bits(pulls: Option<[Pull; 2]>) -> Option<[(u64, u64, usize); 2]> {
    pulls.map(|sides| sides.map(|Pull { place, lost }| (place.x.to_bits(), place.y.to_bits(), lost)))
}
