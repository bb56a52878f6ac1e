//! Long rows of intersections without room between them, such as those of streets a few metres apart. Merged one after another, what
//! becomes of each would depend on where the row begins; so they are divided first, by a grid that lies over the whole plane.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::network::{RoadIx, RoadNetwork};
use crate::geometry::Point;
use crate::lanelet::index::UnionFind;

/// Rows that reach no farther than this from a road, metres east, west, north and south, are not divided there. No town that was looked
/// at has a longer one.
const LONG: f64 = 150.0;
/// The sides of the grid's squares, metres.
const SQUARE: f64 = 200.0;

/// Those of these roads on which intersections are kept apart: with the others they would join intersections into a long row, and they
/// lead from one square of the grid into another. What is merged at one place then depends on no road farther away than the row or the
/// square reaches.
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
