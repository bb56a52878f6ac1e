//! Snaps streets to a grid, so that coordinates with nine decimals of a degree are read back as the same metres.

use rayon::prelude::*;

use crate::builder::network::RoadNetwork;
use crate::geometry::{Point, Polyline};
use crate::parallel::InSmallParts;

use super::outline::Outlines;

/// Grid lines per metre. Nine decimals of a degree are accurate to 0.08 mm, less than half the line spacing (0.24 mm). A power of
/// two is exact in binary numbers.
const LINES_PER_METRE: f64 = 4096.0;

/// The nearest grid point.
pub fn snap(p: Point) -> Point {
    Point::new((p.x * LINES_PER_METRE).round() / LINES_PER_METRE, (p.y * LINES_PER_METRE).round() / LINES_PER_METRE)
}

fn snap_line(line: &mut Polyline) {
    // A line smaller than the grid stays as it is.
    if let Some(snapped) = Polyline::new(line.points().iter().copied().map(snap)) {
        *line = snapped;
    }
}

/// Stations, widths, heights and speeds are rounded to six decimals.
const STEPS_PER_UNIT: f64 = 1e6;

fn round(number: &mut f64) {
    *number = (*number * STEPS_PER_UNIT).round() / STEPS_PER_UNIT;
}

/// The network with every point on the grid and every number rounded.
#[must_use]
pub fn snap_network(mut network: RoadNetwork) -> RoadNetwork {
    network.roads.par_iter_mut().in_small_parts().for_each(|road| {
        snap_line(&mut road.line);
        road.heights.iter_mut().for_each(round);
        let stations = road.features.iter_mut().map(|feature| &mut feature.station);
        let widths = road.section.strips.iter_mut().map(|strip| &mut strip.width);
        stations.chain(widths).chain(&mut road.speed).for_each(round);
    });
    for intersection in &mut network.intersections {
        intersection.position = snap(intersection.position);
        intersection.islands.iter_mut().flat_map(|island| &mut island.ring).for_each(|p| *p = snap(*p));
        for inner in &mut intersection.inner {
            snap_line(&mut inner.line);
            inner.section.strips.iter_mut().for_each(|strip| round(&mut strip.width));
        }
    }
    network
}

/// The outlines with every point on the grid.
#[must_use]
pub fn snap_outlines(mut outlines: Outlines) -> Outlines {
    outlines.kept.iter_mut().flatten().for_each(round);
    outlines.intersections.par_iter_mut().in_small_parts().for_each(|outline| {
        let cuts = outline.cuts.iter_mut().flat_map(|cut| [&mut cut.left, &mut cut.right]);
        for p in cuts.chain(outline.corners.iter_mut().flatten()).chain(&mut outline.ring) {
            *p = snap(*p);
        }
    });
    outlines
}
