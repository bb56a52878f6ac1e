//! Which ends of lanes hang on one node, and with that which lanes depend on each other.

use rustc_hash::FxHashMap;

use super::lane::{Lane, LaneEnd, LaneId, Node};

/// The ends on every node, ordered.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    of_node: FxHashMap<Node, Vec<(LaneId, LaneEnd)>>,
}

impl Ends {
    pub fn add(&mut self, id: LaneId, lane: &Lane) {
        for end in LaneEnd::BOTH {
            let ends = self.of_node.entry(lane.node(end)).or_default();
            if let Err(at) = ends.binary_search(&(id, end)) {
                ends.insert(at, (id, end));
            }
        }
    }

    pub fn remove(&mut self, id: LaneId, lane: &Lane) {
        for end in LaneEnd::BOTH {
            let node = lane.node(end);
            let Some(ends) = self.of_node.get_mut(&node) else { continue };
            if let Ok(at) = ends.binary_search(&(id, end)) {
                ends.remove(at);
            }
            if ends.is_empty() {
                self.of_node.remove(&node);
            }
        }
    }

    /// The ends on a node, but for those of a lane that is left out.
    pub fn at(&self, node: Node, without: Option<LaneId>) -> impl Iterator<Item = (LaneId, LaneEnd)> + '_ {
        let ends = self.of_node.get(&node).map_or(&[][..], Vec::as_slice);
        ends.iter().copied().filter(move |(id, _)| Some(*id) != without)
    }

    /// The two ends on a node that are all there are, but for those of a lane that is left out.
    pub fn pair_at(&self, node: Node, without: Option<LaneId>) -> Option<[(LaneId, LaneEnd); 2]> {
        let mut ends = self.at(node, without);
        let pair = [ends.next()?, ends.next()?];
        ends.next().is_none().then_some(pair)
    }
}
