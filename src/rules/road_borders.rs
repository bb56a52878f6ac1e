//! The road borders of a map, by place.

use std::cell::OnceCell;

use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};

use crate::geometry::{Point, Polyline, Vector, segment_crossing};
use crate::lanelet::index::{MapIndex, is_road_border};
use crate::lanelet::{LaneletMap, LineStringId};

/// Segments of road borders.
type Segments = RTree<GeomWithData<Line<[f64; 2]>, LineStringId>>;

/// The road borders of a map. They are looked through when something is asked of them first.
pub struct Borders<'m> {
    map: &'m LaneletMap,
    segments: OnceCell<Segments>,
}

/// The segments of all road borders.
fn segments(map: &LaneletMap) -> Segments {
    let borders = map.linestrings.iter().filter(|line| is_road_border(line));
    let segments = borders.flat_map(|line| {
        let places = map.points.get_each(line.points.iter().copied()).map(|point| point.position);
        let places: Vec<Point> = places.filter(|p| p.x.is_finite() && p.y.is_finite()).collect();
        let pairs: Vec<_> = places.windows(2).map(|pair| (line.id, [pair[0], pair[1]])).collect();
        pairs
    });
    let lines = segments.map(|(id, [a, b])| GeomWithData::new(Line::new([a.x, a.y], [b.x, b.y]), id));
    RTree::bulk_load(lines.collect())
}

impl<'m> Borders<'m> {
    /// All of a map.
    pub fn of(map: &MapIndex<'m>) -> Self {
        Self { map: map.map, segments: OnceCell::new() }
    }

    /// Where a line first crosses one of the borders that are on its level there, and which.
    pub fn crossed(
        &self,
        line: &Polyline,
        on_level: impl Fn(&(LineStringId, Point)) -> bool,
    ) -> Option<(LineStringId, Point)> {
        line.segments().find_map(|(a, b)| self.hits(a, b).into_iter().filter(&on_level).min_by_key(|hit| hit.0))
    }

    /// The nearest border that one meets on the way from a place, and how far it is, metres.
    pub fn toward(&self, from: Point, step: Vector) -> Option<(LineStringId, f64)> {
        let hits = self.hits(from, from + step).into_iter();
        let far = hits.map(|(id, place)| (id, (place - from).norm()));
        far.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
    }

    fn hits(&self, a: Point, b: Point) -> Vec<(LineStringId, Point)> {
        let reach = AABB::from_corners([a.x, a.y], [b.x, b.y]);
        let segments = self.segments.get_or_init(|| segments(self.map));
        let near = segments.locate_in_envelope_intersecting(&reach);
        near.filter_map(|found| {
            let [c, d] = [found.geom().from, found.geom().to].map(Point::from);
            segment_crossing(a, b, c, d).map(|(_, _, place)| (found.data, place))
        })
        .collect()
    }
}
