//! Whom each lanelet of an intersection watches, found once for the whole rule.

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::lanelet::LaneletId;
use crate::lanelet::index::{Conflict, MapIndex};
use crate::parallel::InSmallParts;
use crate::planner::{Attention, EDGE, Params, RoadNetwork, Strip};

/// Whom each lanelet of an intersection watches. Lanelets go by their position in the view of the map.
pub struct Watching<'m> {
    /// The map.
    pub map: &'m MapIndex<'m>,
    /// Its lanelets as Autoware connects them.
    pub network: RoadNetwork<'m, 'm>,
    /// The parameters of Autoware.
    pub params: Params,
    /// Those with `turn_direction`, in file order.
    pub turns: Vec<usize>,
    /// Whom these watch; `None` for all others.
    pub attention: Vec<Option<Attention>>,
    strips: Vec<OnceLock<Option<Strip>>>,
}

impl<'m> Watching<'m> {
    /// Finds whom all watch.
    pub fn new(map: &'m MapIndex<'m>, params: Params) -> Self {
        let network = RoadNetwork::new(map.view());
        let all = 0..network.view.lanelets.len();
        let turns: Vec<usize> = all.filter(|&at| network.graph.passes(at) && network.turn(at).is_some()).collect();
        let mut attention: Vec<Option<Attention>> = network.view.lanelets.iter().map(|_| None).collect();
        // The index has the overlaps, but for those that nobody could draw.
        let conflicting = |at: usize| -> Vec<usize> {
            let conflicts =
                map.lane(network.view.lanelets[at].id()).map(|lane| &map.conflicts[lane]).into_iter().flatten();
            let others = conflicts.filter_map(|conflict| network.view.position(map.lanes[conflict.other].id));
            others.filter(|&other| network.graph.passes(other)).collect()
        };
        let found: Vec<Attention> = (turns.as_slice().par_iter().in_small_parts())
            .map(|&at| network.attention_among(at, conflicting(at), &params))
            .collect();
        for (&at, found) in turns.iter().zip(found) {
            attention[at] = Some(found);
        }
        let strips = attention.iter().map(|_| OnceLock::new()).collect();
        Self { map, network, params, turns, attention, strips }
    }

    /// Whether the first of two lanelets watches the second.
    pub fn watches(&self, at: usize, other: usize) -> bool {
        self.attention[at].as_ref().is_some_and(|attention| attention.watched.contains(&other))
    }

    /// Whether the path over a lanelet touches any that it watches; if none, the module does nothing there.
    pub fn meets_any(&self, at: usize) -> bool {
        let watched = self.attention[at].iter().flat_map(|attention| &attention.watched);
        self.strip(at).is_some_and(|strip| watched.into_iter().any(|&other| strip.meets(&self.network.surface(other))))
    }

    /// What vehicles sweep on a lanelet, with the inaccuracy of a real path.
    pub fn strip(&self, at: usize) -> Option<&Strip> {
        self.strips[at].get_or_init(|| self.network.strip(at, EDGE, &self.params)).as_ref()
    }

    /// A lanelet in the index; `None` if that leaves it out as broken.
    pub fn lane(&self, at: usize) -> Option<usize> {
        self.map.lane(self.id(at))
    }

    /// How two lanelets overlap; `None` for slivers and bridges, which are vm-03-12's.
    pub fn conflict(&self, at: usize, other: usize) -> Option<&Conflict> {
        let (x, y) = self.lane(at).zip(self.lane(other))?;
        self.map.conflicts[x].iter().find(|conflict| conflict.other == y && conflict.real)
    }

    /// Whether two lanelets start side by side: vm-03-07 tells that they overlap.
    pub fn are_neighbours(&self, at: usize, other: usize) -> bool {
        let starts =
            self.lane(at).zip(self.lane(other)).map(|(x, y)| [x, y].map(|lane| self.map.lanes[lane].start.ids));
        starts.is_some_and(|[a, b]| a.iter().any(|point| b.contains(point)))
    }

    /// Its id.
    pub fn id(&self, at: usize) -> LaneletId {
        self.network.view.lanelets[at].id()
    }
}
