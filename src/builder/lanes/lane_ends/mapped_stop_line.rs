//! Where vehicles stop before an intersection by the map: the cut is drawn back to there, if geometry and crosswalks let it.

use crate::builder::network::road_end::{at_depth, from_cut, inward};
use crate::builder::network::{End, FeatureKind, Road, Stations};
use crate::geometry::angle_between;

use super::setback::{EASE_BEND, EASE_LEFT};

/// No stop line lies further than this, metres, from the corner of the crossing road: behind a crosswalk, and a box for bicycles.
/// What stands further out is a sign, or stops vehicles for something else.
const REACH: f64 = 15.0;

/// How far behind the outline's cut, metres, vehicles stop before either end of a road, where the map tells it. Lanes that end
/// there would else be cut around a bend, or not at all.
pub fn mapped(road: &Road, least: Stations, crossed: impl Fn(End) -> bool) -> [Option<f64>; 2] {
    End::BOTH.map(|end| {
        let meant = |kind: FeatureKind| kind == FeatureKind::StopLine(end.inbound());
        // What stands where roads meet stops those who come to that place, not those who leave it.
        let between = |station: f64| station > 0.0 && station < road.line.length();
        let here = |kind: FeatureKind, station: f64| crossed(end) && meant(kind) && between(station);
        let lines = road.features.iter().filter(|feature| here(feature.kind, feature.station));
        let depths = lines.map(|feature| from_cut(least, end, feature.station));
        let near = depths.filter(|depth| *depth > 0.0 && *depth <= REACH);
        // Of two lines one behind the other the first is for cars; bicycles wait at the other.
        near.max_by(f64::total_cmp).filter(|depth| bend(road, least, end, *depth) <= EASE_BEND)
    })
}

/// By how much, degrees, a road bends on the way from a place so far, metres, behind the outline's cut to that cut.
pub fn bend(road: &Road, least: Stations, end: End, depth: f64) -> f64 {
    let heading = |depth: f64| inward(road, end, at_depth(least, end, depth));
    angle_between(heading(0.0), heading(depth)).abs().to_degrees()
}

/// The setbacks of a road, with those at mapped stop lines drawn back to them where enough of it remains; and whether they
/// were.
pub fn drawn_back(least: Stations, setbacks: [f64; 2], mapped: [Option<f64>; 2]) -> ([f64; 2], [bool; 2]) {
    let (mut drawn, mut moved) = (setbacks, [false; 2]);
    for end in End::BOTH.map(End::index) {
        let Some(depth) = mapped[end].filter(|depth| *depth >= setbacks[end]) else { continue };
        if least[1] - least[0] - drawn[1 - end] - depth >= EASE_LEFT {
            (drawn[end], moved[end]) = (depth, true);
        }
    }
    (drawn, moved)
}
