//! The lane ends on each node.

use rustc_hash::FxHashMap;

use super::lane::{Lane, LaneEnd, LaneId, Node};

/// The lane ends on each node, sorted.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    of_node: FxHashMap<Node, Vec<(LaneId, LaneEnd)>>,
}

impl Ends {
    pub fn add(&mut self, id: LaneId, lane: &Lane) {
        for end in LaneEnd::BOTH {
            let ends = self.of_node.entry(lane.node(end)).or_default();
            if let Err(i) = ends.binary_search(&(id, end)) {
                ends.insert(i, (id, end));
            }
        }
    }

    pub fn remove(&mut self, id: LaneId, lane: &Lane) {
        for end in LaneEnd::BOTH {
            let node = lane.node(end);
            let Some(ends) = self.of_node.get_mut(&node) else { continue };
            if let Ok(i) = ends.binary_search(&(id, end)) {
                ends.remove(i);
            }
            if ends.is_empty() {
                self.of_node.remove(&node);
            }
        }
    }

    /// The ends on a node, except those of an excluded lane.
    pub fn at(&self, node: Node, excluded: Option<LaneId>) -> impl Iterator<Item = (LaneId, LaneEnd)> + '_ {
        let ends = self.of_node.get(&node).map_or(&[][..], Vec::as_slice);
        ends.iter().copied().filter(move |(id, _)| Some(*id) != excluded)
    }

    /// The two ends on a node, if it has exactly two, except those of an excluded lane.
    pub fn pair_at(&self, node: Node, excluded: Option<LaneId>) -> Option<[(LaneId, LaneEnd); 2]> {
        let mut ends = self.at(node, excluded);
        let pair = [ends.next()?, ends.next()?];
        ends.next().is_none().then_some(pair)
    }
}
