//! The grid on which streets lie: what is written with nine decimals of a degree is read back as the very same metres.

use rayon::prelude::*;

use crate::builder::network::RoadNetwork;
use crate::geometry::{Point, Polyline};
use crate::parallel::Finely;

use super::outline::Outlines;

/// Lines of the grid in one metre. Nine decimals of a degree are 0.08 mm at most from the place they stand for, less
/// than half the distance of two lines (0.24 mm); as a power of two it is exact in binary numbers.
const LINES_PER_METRE: f64 = 4096.0;

/// The place of the grid nearest to this one.
pub fn snap(p: Point) -> Point {
    Point::new((p.x * LINES_PER_METRE).round() / LINES_PER_METRE, (p.y * LINES_PER_METRE).round() / LINES_PER_METRE)
}

fn line(line: &mut Polyline) {
    // What is smaller than the grid stays as it is.
    if let Some(snapped) = Polyline::new(line.points().iter().copied().map(snap)) {
        *line = snapped;
    }
}

/// Stations, widths and speeds have six decimals: as many as any reader takes up without rounding.
const STEPS: f64 = 1e6;

fn short(number: &mut f64) {
    *number = (*number * STEPS).round() / STEPS;
}

/// The network with every place on the grid, and no number longer than it is written.
#[must_use]
pub fn snap_network(mut network: RoadNetwork) -> RoadNetwork {
    network.roads.par_iter_mut().finely().for_each(|road| {
        line(&mut road.line);
        road.heights.iter_mut().for_each(short);
        let stations = road.features.iter_mut().map(|feature| &mut feature.station);
        let widths = road.section.strips.iter_mut().map(|strip| &mut strip.width);
        stations.chain(widths).chain(&mut road.speed).for_each(short);
    });
    for intersection in &mut network.intersections {
        intersection.position = snap(intersection.position);
        intersection.islands.iter_mut().flat_map(|island| &mut island.ring).for_each(|p| *p = snap(*p));
        for inner in &mut intersection.inner {
            line(&mut inner.line);
            inner.section.strips.iter_mut().for_each(|strip| short(&mut strip.width));
        }
    }
    network
}

/// The outlines with every place on the grid.
#[must_use]
pub fn snap_outlines(mut outlines: Outlines) -> Outlines {
    outlines.kept.iter_mut().flatten().for_each(short);
    outlines.intersections.par_iter_mut().finely().for_each(|outline| {
        let cuts = outline.cuts.iter_mut().flat_map(|cut| [&mut cut.left, &mut cut.right]);
        for p in cuts.chain(outline.corners.iter_mut().flatten()).chain(&mut outline.ring) {
            *p = snap(*p);
        }
    });
    outlines
}
