//! The segments of a line by place: how far many points are from a line of many points.

use rstar::primitives::{GeomWithData, Line};
use rstar::{PointDistance, RTree};
use rustc_hash::FxHashSet;

use super::polyline::distance_to_segment;
use super::{Point, Polyline};

/// A line of which the nearest segment is found without a look at all.
pub struct LineIndex<'a> {
    line: &'a Polyline,
    tree: RTree<GeomWithData<Line<[f64; 2]>, usize>>,
}

impl<'a> LineIndex<'a> {
    /// The index of a line.
    pub fn new(line: &'a Polyline) -> Self {
        // A line that runs to and fro between the same points has many segments at one place: one of them is enough.
        let mut seen = FxHashSet::default();
        let bits = |p: Point| [p.x.to_bits(), p.y.to_bits()];
        let segments = line.segments().enumerate().filter(|(_, (a, b))| seen.insert([bits(*a), bits(*b)]));
        let segments = segments.map(|(at, (a, b))| GeomWithData::new(Line::new([a.x, a.y], [b.x, b.y]), at));
        Self { line, tree: RTree::bulk_load(segments.collect()) }
    }

    /// [`Polyline::distance`], metres.
    pub fn distance(&self, p: Point) -> f64 {
        let place = [p.x, p.y];
        let Some(nearest) = self.tree.nearest_neighbor(&place) else { return self.line.distance(p) };
        // The tree reckons a little differently: of those that it finds as near, ours decides.
        let square = nearest.distance_2(&place) * (1.0 + 1e-9) + Polyline::MERGE * Polyline::MERGE;
        let points = self.line.points();
        let near = self.tree.locate_within_distance(place, square).map(|found| found.data);
        near.map(|at| distance_to_segment(p, points[at], points[at + 1])).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_the_distance_from_the_line(
            line in prop::collection::vec((-50.0..50.0, -50.0..50.0), 2..60),
            (x, y) in (-90.0..90.0, -90.0..90.0),
        ) {
            let Some(line) = Polyline::new(line.into_iter().map(|(x, y)| Point::new(x, y))) else { return Ok(()) };
            for p in [Point::new(x, y), line.first()] {
                prop_assert_eq!(LineIndex::new(&line).distance(p), line.distance(p));
            }
        }
    }
}
