//! The borders of the lanes for vehicles, found by place. No shoulder is drawn along such a border of another road.

use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::RoadIx;
use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::geometry::{Point, Polyline, Vector};
use crate::lanelet::index::extent;

use super::types::Lanes;

/// Two borders are one line if they are closer to each other than this, metres, which no strip is, ...
const APART: f64 = 0.35;
/// ... along this share of the shorter one.
const SHARE: f64 = 0.7;
/// The distance between measurements along a border, metres.
const MEASURED_EVERY: f64 = 1.0;
/// The side of the cells by which borders are found, metres.
const CELL: f64 = 50.0;

/// The borders of all lanes for vehicles, each with its road; those of lanelets in intersections have none.
pub struct DrivenBorders {
    borders: Vec<(Option<RoadIx>, Polyline)>,
    cells: SpatialHash,
}

impl DrivenBorders {
    /// Collects the borders of all lanes, and the bounds of the lanelets in intersections.
    pub fn new(assembly: &MapBuilder, lanes: &Lanes, turning: Vec<Vec<Point>>) -> Self {
        let of_roads = lanes.lanes.iter().flat_map(|lane| [lane.left, lane.right].map(|bound| (lane.road, bound)));
        let of_roads = of_roads.map(|(road, bound)| (Some(road), assembly.bound_line(bound)));
        let all = of_roads.chain(turning.into_iter().map(|bound| (None, bound)));
        let borders: Vec<_> = all.filter_map(|(road, line)| Some((road, Polyline::new(line)?))).collect();
        let cells = SpatialHash::new(borders.iter().map(|(_, line)| extent(line.points())).collect(), CELL);
        Self { borders, cells }
    }

    /// Whether a line at the side of a road runs along the border of a lane of another road, or of a lanelet in an intersection, because
    /// the two overlap.
    pub fn run_along(&self, road: RoadIx, line: &[Point]) -> bool {
        let Some(line) = Polyline::new(line.iter().copied()) else { return false };
        let ([low, high], margin) = (extent(line.points()), Vector::repeat(APART));
        let around: Bounds = [low - margin, high + margin];
        let mut found = false;
        self.cells.touching(around, |i| {
            let (other, border) = &self.borders[i];
            found = found || *other != Some(road) && are_one_line(&line, border);
        });
        found
    }
}

/// Whether most of the shorter of two lines lies along the other.
fn are_one_line(a: &Polyline, b: &Polyline) -> bool {
    let [short, long] = if a.length() <= b.length() { [a, b] } else { [b, a] };
    let (places, mut hint) = (short.places(MEASURED_EVERY), 0);
    let count = places.len();
    let close = places.filter(|place| long.reaches(*place, APART, &mut hint)).count();
    close as f64 >= SHARE * count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_of_the_shorter_line_lies_along_the_other() {
        let line = |places: &[[f64; 2]]| Polyline::new(places.iter().map(|[x, y]| Point::new(*x, *y))).unwrap();
        let border = line(&[[0.0, 0.0], [100.0, 0.0]]);
        for (shoulder, is_one) in [
            (line(&[[20.0, 0.3], [60.0, -0.3]]), true),
            (line(&[[20.0, 0.5], [60.0, 0.5]]), false),
            (line(&[[20.0, 0.0], [50.0, 0.0], [60.0, 8.0]]), true),
            (line(&[[20.0, 0.0], [40.0, 0.0], [60.0, 8.0]]), false),
        ] {
            assert_eq!(are_one_line(&shoulder, &border), is_one, "{shoulder:?}");
            assert_eq!(are_one_line(&border, &shoulder), is_one, "{shoulder:?}, the other way around");
        }
    }
}
