//! Which movements of an intersection conflict.

use crate::builder::tags::cross_section::StripKind;
use crate::geometry::polygon::Strips;
use crate::geometry::strip_index::StripIndex;
use crate::geometry::{Point, polygon};

use super::turning_lanelets::TurningLanelet;

/// Two lanelets conflict if they share this part of one of them ...
const PART: f64 = 0.01;
/// ... or this area, square metres.
const AREA: f64 = 0.25;
/// From this overlap on, square metres, Autoware takes two lanelets for conflicting.
const RAW: f64 = 1e-4;

/// Conflicts among the lanelets of one intersection, by index. Lanelets from one lane never conflict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conflicts {
    /// Per lanelet: those that conflict with it, ascending.
    pub real: Vec<Vec<usize>>,
    /// Pairs with so small an overlap that only Autoware takes them for conflicting.
    pub slivers: Vec<(usize, usize)>,
}

impl Conflicts {
    /// The lanelets that have a sliver of overlap with this one.
    pub fn touching(&self, path: usize) -> impl Iterator<Item = usize> + '_ {
        self.slivers.iter().filter_map(move |&(a, b)| match path {
            _ if path == a => Some(b),
            _ if path == b => Some(a),
            _ => None,
        })
    }
}

/// The outlines of lanelets, to be compared with each other and with those of [`strips_beside`].
pub fn strip_indices(paths: &[TurningLanelet]) -> Vec<Option<StripIndex>> {
    let base = paths.first().and_then(|path| path.outline.first());
    paths.iter().map(|path| StripIndex::new(&path.outline, *base?)).collect()
}

/// A ring, to be compared with the outlines of lanelets.
pub fn strips_beside(paths: &[TurningLanelet], ring: &[Point]) -> Option<Strips> {
    Strips::new(ring, *paths.first()?.outline.first()?)
}

/// Finds the conflicts. `indices` are the outlines of the lanelets.
pub fn conflicts(paths: &[TurningLanelet], indices: &[Option<StripIndex>]) -> Conflicts {
    let areas: Vec<f64> = paths.iter().map(|p| polygon::signed_area(&p.outline).abs()).collect();
    let mut found = Conflicts { real: vec![Vec::new(); paths.len()], slivers: Vec::new() };
    for (i, path) in paths.iter().enumerate() {
        for j in (i + 1..paths.len()).filter(|&j| !siblings(path, &paths[j]) && !adjacent(path, &paths[j])) {
            let both = indices[i].as_ref().zip(indices[j].as_ref());
            let least = AREA.min(PART * areas[i].min(areas[j]));
            let overlap = both.map_or(0.0, |(a, b)| a.common_area(b, least));
            if overlap >= least {
                found.real[i].push(j);
                found.real[j].push(i);
            } else if overlap > RAW {
                found.slivers.push((i, j));
            }
        }
    }
    found.real.iter_mut().for_each(|others| others.sort_unstable());
    found
}

/// Whether two lanelets begin on the same lane.
pub fn siblings(a: &TurningLanelet, b: &TurningLanelet) -> bool {
    let lane = |path: &TurningLanelet| (path.movement.from, path.movement.in_lane, path.kind == StripKind::Bicycle);
    lane(a) == lane(b)
}

/// Whether two lanelets share a bound: Autoware takes them for neighbours, not for conflicting.
fn adjacent(a: &TurningLanelet, b: &TurningLanelet) -> bool {
    a.bounds.iter().any(|line| b.bounds.contains(line))
}
