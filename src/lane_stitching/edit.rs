//! Edits of a weave: what hangs on the ends of the edited lanes is stitched and painted anew, and nothing else.

use std::collections::{BTreeMap, BTreeSet};

use super::joint::Pull;
use super::lane::Node;
use super::{Lane, LaneEnd, LaneId, LaneStitching, Meeting};

/// Lanes to put in the place of those with their names; `None` takes away.
type Edits = BTreeMap<LaneId, Option<Lane>>;

impl LaneStitching {
    /// Adds a lane, or puts it in the place of the one with its name. Gives the lanes that were made anew.
    pub fn set(&mut self, id: LaneId, lane: Lane) -> Vec<LaneId> {
        self.edit(Edits::from([(id, Some(lane))]))
    }

    /// Takes a lane away. Gives the lanes that were made anew, and the one that is gone.
    pub fn remove(&mut self, id: LaneId) -> Vec<LaneId> {
        self.edit(Edits::from([(id, None)]))
    }

    /// Puts these lanes, numbered from 0 on, in the place of all lanes of a road; with none the road is taken away.
    /// Gives the lanes that were made anew, and those that are gone.
    pub fn set_road(&mut self, road: i64, lanes: impl IntoIterator<Item = Lane>) -> Vec<LaneId> {
        let named = |lane: u32| LaneId { road, lane };
        let known = self.lanes.range(named(0)..=named(u32::MAX)).map(|(id, _)| (*id, None));
        let mut edits: Edits = known.collect();
        edits.extend((0..).map(named).zip(lanes.into_iter().map(Some)));
        self.edit(edits)
    }

    /// Leaves a lane out of all joints, as while it is dragged, so that those that it passes by do not jump; with `None`
    /// no more. The others are stitched as if it were not there. Gives the lanes that were made anew.
    pub fn exclude(&mut self, id: Option<LaneId>) -> Vec<LaneId> {
        let concerned = self.excluded.into_iter().chain(id);
        let nodes = concerned.filter_map(|id| self.lane(id)).flat_map(nodes).collect();
        self.within(&nodes, BTreeSet::new(), |weave| weave.excluded = id)
    }

    /// The lane that is left out.
    pub fn excluded(&self) -> Option<LaneId> {
        self.excluded
    }

    fn edit(&mut self, edits: Edits) -> Vec<LaneId> {
        let before = edits.keys().filter_map(|id| self.lane(*id));
        let nodes = before.chain(edits.values().flatten()).flat_map(nodes).collect();
        let edited = edits.iter().filter(|(id, lane)| lane.is_some() || self.lanes.contains_key(id));
        let edited = edited.map(|(id, _)| *id).collect();
        self.within(&nodes, edited, |weave| {
            for (id, lane) in edits {
                weave.take(id);
                if let Some(lane) = lane {
                    weave.put(id, lane);
                }
            }
        })
    }

    /// Makes a change to some lanes and to how the ends on some nodes meet. A joint depends on no more than the two
    /// lanes that it joins, as they are before they are stitched: so only the lanes joined on those nodes, before or
    /// after, can become others.
    fn within(
        &mut self,
        nodes: &BTreeSet<Node>,
        edited: BTreeSet<LaneId>,
        change: impl FnOnce(&mut Self),
    ) -> Vec<LaneId> {
        let mut concerned: BTreeSet<LaneId> = self.joined_on(nodes).collect();
        change(self);
        concerned.extend(self.joined_on(nodes));
        concerned.extend(&edited);
        let mut anew = Vec::new();
        for id in concerned {
            let Some(entry) = self.lanes.get(&id) else {
                anew.push(id);
                continue;
            };
            let pulls = LaneEnd::BOTH.map(|end| {
                let known = entry.pulls[end.index()];
                if nodes.contains(&entry.lane.node(end)) { self.pull(id, end) } else { known }
            });
            if edited.contains(&id) || entry.pulls.map(bits) != pulls.map(bits) {
                self.draw(id, pulls);
                anew.push(id);
            }
        }
        anew
    }

    /// The lanes that are joined to another on some nodes.
    fn joined_on(&self, nodes: &BTreeSet<Node>) -> impl Iterator<Item = LaneId> {
        let ends = nodes.iter().filter_map(|node| self.ends.pair_at(*node, self.excluded)).flatten();
        ends.filter(|(id, end)| matches!(self.meeting(*id, *end), Some(Meeting::Joined(_)))).map(|(id, _)| id)
    }
}

fn nodes(lane: &Lane) -> [Node; 2] {
    LaneEnd::BOTH.map(|end| lane.node(end))
}

/// To the last bit, so that nought below nought is another.
fn bits(pulls: Option<[Pull; 2]>) -> Option<[(u64, u64, usize); 2]> {
    pulls.map(|sides| sides.map(|Pull { place, lost }| (place.x.to_bits(), place.y.to_bits(), lost)))
}
