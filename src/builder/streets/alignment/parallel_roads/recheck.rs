//! Updates which roads lie beside which others after some have moved.

use std::sync::atomic::AtomicUsize;

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork};
use crate::builder::streets::alignment::side_order::SideHints;
use crate::geometry::Vector;
use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::parallel::InSmallParts;

use super::overlap_search::{Adjacency, OverlapSearch};
use super::shifted_road::{FARTHEST, ShiftedRoads};

/// Cell size of the search, metres: cells hold whole roads.
const CELL: f64 = 128.0;

/// Which roads may ever touch which others, as no road moves farther than [`FARTHEST`].
pub struct Surroundings {
    cells: SpatialHash,
    boxes: Vec<Bounds>,
}

impl Surroundings {
    /// Of the roads as they are drawn.
    pub fn new(network: &RoadNetwork) -> Self {
        let bounds = |road: &Road| {
            let ([low, high], reach) = (road.line.bounds(), Vector::repeat(road.half_width() + FARTHEST));
            [low - reach, high + reach]
        };
        let boxes: Vec<Bounds> = network.roads.par_iter().in_small_parts().map(bounds).collect();
        Self { cells: SpatialHash::new(boxes.clone(), CELL), boxes }
    }

    /// The roads that may touch one of these, ascending.
    fn of(&self, roads: &[usize]) -> Vec<usize> {
        let mut found = Vec::new();
        for &road in roads {
            self.cells.touching(self.boxes[road], |other| found.push(other));
        }
        sort_unique(&mut found);
        found
    }

    /// Updates `adjacency`, which holds the neighbours of the `active` roads, after some roads moved. Returns the roads that are
    /// active next: those beside others, and those that moved. A road that others have come to is active at once, whatever happens
    /// to it elsewhere.
    pub fn update(
        &self,
        adjacency: &mut Adjacency,
        roads: &mut ShiftedRoads,
        (hints, crowded): (&SideHints, &AtomicUsize),
        active: &[usize],
        moved: &[usize],
    ) -> Vec<usize> {
        let has = |list: &[usize], road: usize| list.binary_search(&road).is_ok();
        let mut next: Vec<usize> = adjacency.keys().flat_map(|(a, b)| [*a, *b]).chain(moved.iter().copied()).collect();
        sort_unique(&mut next);
        let (fresh, known): (Vec<usize>, Vec<usize>) =
            next.iter().partition(|road| has(moved, **road) || !has(active, **road));
        adjacency.retain(|(a, b), _| !has(&fresh, *a) && !has(moved, *b));
        let around = self.of(&fresh);
        let known: Vec<usize> = known.into_iter().filter(|road| has(&around, *road)).collect();
        roads.make(&around);
        let search = OverlapSearch { roads: &roads.made, hints, crowded };
        adjacency.extend(search.find(&fresh, &around));
        adjacency.extend(search.find(&known, moved));
        let mut reached: Vec<usize> = adjacency.keys().map(|(_, b)| *b).filter(|road| !has(&next, *road)).collect();
        sort_unique(&mut reached);
        let around = self.of(&reached);
        roads.make(&around);
        adjacency.extend(OverlapSearch { roads: &roads.made, hints, crowded }.find(&reached, &around));
        next.extend(reached);
        sort_unique(&mut next);
        next
    }
}

/// Sorts roads and removes repetitions.
pub fn sort_unique(roads: &mut Vec<usize>) {
    roads.sort_unstable();
    roads.dedup();
}
