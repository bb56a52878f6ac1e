//! vm-06-01: a buffer zone is drawn from the points of the lanes beside it.

use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Finding, Subject};
use crate::geometry::{Point as Place, overlay, polygon, simple_ring};
use crate::lanelet::index::view::View;
use crate::lanelet::index::{MapIndex, extent};
use crate::lanelet::{PointId, Polygon};

/// A corner sharper than this (deg) turns back on itself.
const SPIKE: f64 = 1e-6;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Share of the zone.
    overlap: f64,
    /// Whether overlaps of counter-clockwise zones are passed over.
    clockwise_only: bool,
    /// Whether lanelets of intersections count, into which zones reach.
    everywhere: bool,
    /// Whether zones that are no valid polygons are judged further.
    invalid_too: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let view = map.view();
    view.polygons("hatched_road_markings").flat_map(|zone| judge(map, view, params, zone)).collect()
}

fn judge(map: &MapIndex, view: &View, params: &Params, zone: &Polygon) -> Vec<Finding> {
    let (id, subject) = (zone.id, Subject::Polygon(zone.id.0));
    let outline = view.ring(zone);
    let near: Vec<usize> = if outline.is_empty() { Vec::new() } else { view.near(extent(&outline), 0.0) };
    let lanes = || near.iter().map(|&at| &view.lanelets[at]);
    let bounds: FxHashSet<PointId> =
        lanes().flat_map(|seen| seen.left.iter().chain(&seen.right).map(|point| point.id)).collect();
    let mut findings = Vec::new();
    let own: Vec<String> = zone.points.iter().filter(|id| !bounds.contains(id)).map(ToString::to_string).collect();
    if !own.is_empty() {
        let message = format!("Points of buffer zone {id} belong to no lanelet's bound: {}.", own.join(", "));
        findings.push(Finding::new("not-shared", subject, message));
    }
    if !simple_ring::faults(&outline, SPIKE, 1).is_empty() {
        findings.push(Finding::new("invalid", subject, format!("Buffer zone {id} is no valid polygon.")));
        if !params.invalid_too {
            return findings;
        }
    }
    if params.clockwise_only && polygon::signed_area(&outline) > 0.0 {
        return findings;
    }
    let area = polygon::signed_area(&outline).abs();
    let counts = |id| params.everywhere || !map.lane(id).is_some_and(|lane| map.has_area(lane));
    for road in lanes().filter(|seen| seen.is("road") && counts(seen.id())) {
        let share = covered(&outline, &road.outline, params.invalid_too) / area;
        if share > params.overlap {
            let message = format!("{:.1} % of buffer zone {id} lies on road lanelet {}.", 100.0 * share, road.id());
            let finding = Finding::new("overlap", subject, message).with(Subject::Lanelet(road.id().0), "road");
            findings.push(finding.measured(100.0 * share, 100.0 * params.overlap, "%"));
        }
    }
    findings
}

/// Square metres of a zone that a lanelet covers; with `crossed`, as the existing validator takes outlines that cross themselves.
fn covered(outline: &[Place], road: &[Place], crossed: bool) -> f64 {
    if crossed && [outline, road].into_iter().any(simple_ring::crosses_itself) {
        overlay::common_area_turned(outline, road)
    } else {
        polygon::overlap(outline, road)
    }
}
