//! Which roads lie beside which others once some have moved: only what these touch is compared again.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::{Road, RoadNetwork};
use crate::builder::streets::alignment::side_order::Sides;
use crate::geometry::Vector;
use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::parallel::Finely;

use super::carriageway_edges::{FARTHEST, Tracks};
use super::overlap_search::{OverlapSearch, find};

/// Cells of this side, metres, hold whole roads.
const CELL: f64 = 128.0;

/// Which roads may ever come to touch which others, as no road moves farther than [`FARTHEST`].
pub struct Surroundings {
    cells: SpatialHash,
    boxes: Vec<Bounds>,
    /// The roads around those that moved first: all later rounds stay among them.
    near: Vec<usize>,
}

impl Surroundings {
    /// The surroundings of the roads that moved first.
    pub fn new(network: &RoadNetwork, moved: &[usize]) -> Self {
        let reach = |road: &Road| {
            let ([low, high], reach) = (road.line.bounds(), Vector::repeat(road.half_width() + FARTHEST));
            [low - reach, high + reach]
        };
        let boxes: Vec<Bounds> = network.roads.par_iter().finely().map(reach).collect();
        let mut all = Self { cells: SpatialHash::new(boxes.clone(), CELL), boxes, near: Vec::new() };
        all.near = all.of(moved);
        all
    }

    /// The roads that may come to touch one of these, ascending.
    fn of(&self, roads: &[usize]) -> Vec<usize> {
        let mut found = Vec::new();
        for &road in roads {
            self.cells.touching(self.boxes[road], |other| found.push(other));
        }
        sorted(&mut found);
        found
    }

    /// Brings what lies beside what up to date with the roads that moved. `hot` are the roads whose neighbours it holds; of
    /// those the ones beside others are looked at again, with those that moved. Returns them.
    pub fn find_again(
        &self,
        beside: &mut FxHashMap<(usize, usize), Vec<OverlapSearch>>,
        tracks: &mut Tracks,
        sides: &Sides,
        hot: &[usize],
        moved: &[usize],
    ) -> Vec<usize> {
        let has = |list: &[usize], road: usize| list.binary_search(&road).is_ok();
        let mut next: Vec<usize> = beside.keys().flat_map(|(a, b)| [*a, *b]).chain(moved.iter().copied()).collect();
        sorted(&mut next);
        let (fresh, known): (Vec<usize>, Vec<usize>) =
            next.iter().partition(|road| has(moved, **road) || !has(hot, **road));
        beside.retain(|(a, b), _| !has(&fresh, *a) && !has(moved, *b) && has(&self.near, *b));
        let around: Vec<usize> = self.of(&fresh).into_iter().filter(|road| has(&self.near, *road)).collect();
        let known: Vec<usize> = known.into_iter().filter(|road| has(&around, *road)).collect();
        let moved: Vec<usize> = moved.iter().copied().filter(|road| has(&self.near, *road)).collect();
        tracks.make(&around);
        beside.extend(find(&tracks.made, sides, &fresh, &around));
        beside.extend(find(&tracks.made, sides, &known, &moved));
        next
    }
}

/// Sorts roads, each named once.
pub fn sorted(roads: &mut Vec<usize>) {
    roads.sort_unstable();
    roads.dedup();
}
