//! Long rows of intersections without room between them, such as those of streets a few metres apart. If a row were merged from
//! its begin on, the result at one place would depend on where the row begins. So a grid over the whole plane divides long rows
//! first.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::network::{RoadIx, RoadNetwork};
use crate::geometry::Point;
use crate::lanelet::index::UnionFind;

/// A row is divided at a road only if it reaches farther than this from the road, metres east, west, north or south. No row in
/// the tested towns does.
const LONG: f64 = 150.0;
/// The sides of the grid's squares, metres.
const SQUARE: f64 = 200.0;

/// The roads that divide a long row: those that lead from one square of the grid into another. The intersections at their ends
/// are kept apart, so that merging at one place depends only on roads within the row or the square.
pub fn dividing_roads(network: &RoadNetwork, roads: &[RoadIx]) -> FxHashSet<RoadIx> {
    let mut joined = UnionFind::new(network.intersections.len());
    for road in roads.iter().map(|road| network.road(*road)) {
        joined.join(road.from.position(), road.to.position());
    }
    let ends = |road: RoadIx| {
        let line = &network.road(road).line;
        [line.first(), line.last()]
    };
    let rows: Vec<usize> = roads.iter().map(|road| joined.root(network.road(*road).from.position())).collect();
    let mut boxes: FxHashMap<usize, [Point; 2]> = FxHashMap::default();
    for (road, row) in roads.iter().zip(&rows) {
        let [from, to] = ends(*road);
        let [low, high] = boxes.entry(*row).or_insert([from; 2]);
        (*low, *high) = (low.inf(&from).inf(&to), high.sup(&from).sup(&to));
    }
    let is_long =
        |row: &usize, at: Point| boxes.get(row).is_some_and(|[low, high]| (at - low).sup(&(high - at)).max() > LONG);
    let divides = |(road, row): &(&RoadIx, &usize)| {
        let [from, to] = ends(**road);
        square(from) != square(to) && is_long(row, from)
    };
    roads.iter().zip(&rows).filter(divides).map(|(road, _)| *road).collect()
}

fn square(point: Point) -> [i64; 2] {
    [point.x, point.y].map(|metres| (metres / SQUARE).floor() as i64)
}
