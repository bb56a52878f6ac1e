//! Which movements of an intersection get into each other's way.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::geometry::{Point, polygon};

use super::paths::Path;

/// Two lanelets conflict if they share this part of one of them ...
const PART: f64 = 0.01;
/// ... or this area, square metres.
const AREA: f64 = 0.25;
/// Autoware takes two lanelets for conflicting from this overlap on, square metres.
const RAW: f64 = 1e-4;

/// Conflicts among the paths of one intersection, by index; siblings (which start at the same nodes) never conflict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conflicts {
    /// Per path the others that really overlap it, ascending.
    pub real: Vec<Vec<usize>>,
    /// Pairs that overlap by so little that it is not a conflict but for Autoware.
    pub slivers: Vec<(usize, usize)>,
}

impl Conflicts {
    /// The paths that overlap this one by too little to be in its way.
    pub fn touching(&self, path: usize) -> impl Iterator<Item = usize> + '_ {
        self.slivers.iter().filter_map(move |&(a, b)| match path {
            _ if path == a => Some(b),
            _ if path == b => Some(a),
            _ => None,
        })
    }
}

/// Finds the conflicts.
pub fn conflicts(paths: &[Path]) -> Conflicts {
    let boxes = paths.iter().enumerate().map(|(i, p)| GeomWithData::new(bounding_box(&p.outline), i)).collect();
    let tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>> = RTree::bulk_load(boxes);
    let areas: Vec<f64> = paths.iter().map(|p| polygon::signed_area(&p.outline).abs()).collect();
    let mut found = Conflicts { real: vec![Vec::new(); paths.len()], slivers: Vec::new() };
    for (i, path) in paths.iter().enumerate() {
        let reach = bounding_box(&path.outline);
        let reach = AABB::from_corners(reach.lower(), reach.upper());
        let mut others: Vec<usize> = tree.locate_in_envelope_intersecting(&reach).map(|g| g.data).collect();
        others.retain(|&j| j > i && !siblings(path, &paths[j]) && !adjacent(path, &paths[j]));
        others.sort_unstable();
        for j in others {
            let overlap = polygon::common_area(&path.outline, &paths[j].outline);
            if overlap >= AREA || overlap >= PART * areas[i].min(areas[j]) {
                found.real[i].push(j);
                found.real[j].push(i);
            } else if overlap > RAW {
                found.slivers.push((i, j));
            }
        }
    }
    for list in &mut found.real {
        list.sort_unstable();
    }
    found
}

/// Whether two paths begin on the same lane.
pub fn siblings(a: &Path, b: &Path) -> bool {
    (a.movement.from, a.movement.in_lane) == (b.movement.from, b.movement.in_lane)
}

/// Whether two paths share a bound: then Autoware takes them for neighbours, and not for conflicting.
fn adjacent(a: &Path, b: &Path) -> bool {
    a.bounds.iter().any(|line| b.bounds.contains(line))
}

fn bounding_box(ring: &[Point]) -> Rectangle<[f64; 2]> {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for p in ring {
        for (i, v) in [p.x, p.y].into_iter().enumerate() {
            low[i] = low[i].min(v);
            high[i] = high[i].max(v);
        }
    }
    Rectangle::from_corners(low, high)
}
