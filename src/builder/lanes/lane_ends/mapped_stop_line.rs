//! Mapped stop lines: the cut moves back to them where geometry and crosswalks allow it.

use crate::builder::network::road_end::{at_depth, from_cut, inward};
use crate::builder::network::{End, Feature, FeatureKind, Road, Stations};
use crate::geometry::angle_between;

use super::turn_setback::{COMFORT_BEND, COMFORT_LEFT};

/// A stop line lies at most this far, metres, from the corner of the crossing road: behind a crosswalk, and a box for bicycles.
/// Farther out it is the place of a sign, or it stops vehicles for something else.
const STOP_LINE_FROM_CUT: f64 = 15.0;

/// Depths, metres up the road from the outline's cut, of the stop lines that are mapped before either end of a road.
pub fn mapped_stop_lines(road: &Road, least: Stations, is_approach: impl Fn(End) -> bool) -> [Option<f64>; 2] {
    let length = road.line.length();
    End::BOTH.map(|end| {
        // A stop line on the node where roads meet is for those who arrive there, not for those who leave it.
        let is_stop_line = |feature: &&Feature| {
            feature.kind == FeatureKind::StopLine(end.inbound()) && feature.station > 0.0 && feature.station < length
        };
        let lines = road.features.iter().filter(|_| is_approach(end)).filter(is_stop_line);
        let depths = lines.map(|feature| from_cut(least, end, feature.station));
        // Of two lines one behind the other the first is for cars; bicycles wait at the other.
        let first = depths.filter(|depth| *depth > 0.0 && *depth <= STOP_LINE_FROM_CUT).max_by(f64::total_cmp);
        // No lane is cut around a bend.
        first.filter(|depth| bend(road, least, end, *depth) <= COMFORT_BEND)
    })
}

/// How much a road bends, degrees, between the outline's cut and a place at this depth, metres up the road from it.
pub fn bend(road: &Road, least: Stations, end: End, depth: f64) -> f64 {
    let heading = |depth: f64| inward(road, end, at_depth(least, end, depth));
    angle_between(heading(0.0), heading(depth)).abs().to_degrees()
}

/// The setbacks of a road, metres, moved back to its stop lines where enough of it remains; and which of them moved.
pub fn move_to_stop_lines(
    least: Stations,
    mut setbacks: [f64; 2],
    stop_lines: [Option<f64>; 2],
) -> ([f64; 2], [bool; 2]) {
    let mut moved = [false; 2];
    for end in [0, 1] {
        let Some(depth) = stop_lines[end].filter(|depth| *depth >= setbacks[end]) else { continue };
        if least[1] - least[0] - setbacks[1 - end] - depth >= COMFORT_LEFT {
            (setbacks[end], moved[end]) = (depth, true);
        }
    }
    (setbacks, moved)
}
