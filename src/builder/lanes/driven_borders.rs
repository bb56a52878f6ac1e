//! The borders of the lanes for vehicles, by place: along those of other roads no shoulder is laid.

use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::RoadIx;
use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::geometry::{Point, Polyline, Vector};
use crate::lanelet::index::extent;

use super::types::Lanes;

/// Borders closer than this, metres, are one line: no strip is as narrow ...
const APART: f64 = 0.35;
/// ... if this share of the shorter one is so close.
const SHARE: f64 = 0.7;
/// Distance between measurements along a border, metres.
const STEP: f64 = 1.0;
/// Side of the cells by which borders are found, metres.
const CELL: f64 = 50.0;

/// The borders of all lanes for vehicles.
pub struct DrivenBorders {
    borders: Vec<(RoadIx, Polyline)>,
    cells: SpatialHash,
}

impl DrivenBorders {
    /// Of all lanes.
    pub fn new(assembly: &MapBuilder, lanes: &Lanes) -> Self {
        let borders = lanes.lanes.iter().flat_map(|lane| [lane.left, lane.right].map(|bound| (lane.road, bound)));
        let placed = borders.filter_map(|(road, bound)| Some((road, Polyline::new(assembly.bound_line(bound))?)));
        let borders: Vec<(RoadIx, Polyline)> = placed.collect();
        let cells = SpatialHash::new(borders.iter().map(|(_, line)| extent(line.points())).collect(), CELL);
        Self { borders, cells }
    }

    /// Whether a line at the side of a road runs along a border of a lane of another road: the roads lie over each other there.
    pub fn run_along(&self, road: RoadIx, line: &[Point]) -> bool {
        let Some(line) = Polyline::new(line.iter().copied()) else { return false };
        let ([low, high], margin) = (extent(line.points()), Vector::repeat(APART));
        let around: Bounds = [low - margin, high + margin];
        let mut found = false;
        self.cells.touching(around, |i| {
            let (other, border) = &self.borders[i];
            found = found || *other != road && are_one_line(&line, border);
        });
        found
    }
}

/// Whether most of the shorter of two lines lies along the other.
fn are_one_line(a: &Polyline, b: &Polyline) -> bool {
    let [short, long] = if a.length() <= b.length() { [a, b] } else { [b, a] };
    let (places, mut hint) = (short.places(STEP), 0);
    let count = places.len();
    let close = places.filter(|place| long.reaches(*place, APART, &mut hint)).count();
    close as f64 >= SHARE * count as f64
}
