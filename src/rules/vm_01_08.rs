//! vm-01-08: where no edge line is painted, the lane ends a little before the road does.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Polyline, left_of};
use crate::lanelet::LineStringId;
use crate::lanelet::index::MapIndex;

use super::road_borders::Borders;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    distance: [f64; 2],
    reach: f64,
}

/// A border this near to a bound, metres, is drawn along it.
const ON_BORDER: f64 = 0.05;
/// Steps along a bound between measurements, metres.
const MEASURED_EVERY: f64 = 5.0;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let borders = Borders::of(map);
    let lanes = (0..map.lanes.len()).filter(|&at| map.lanes[at].is_for_cars());
    // Where lanes branch or join, the kerb leads from road to road and not along a lane.
    let branches = |at: usize| map.siblings(at).next().is_some() || map.ending_at(map.lanes[at].end.ids).len() > 1;
    let outside = lanes.filter(|&at| map.intersections_of(at).is_empty() && !branches(at));
    outside.flat_map(|at| [0, 1].map(|side| judge(map, params, &borders, at, side))).flatten().collect()
}

/// Whether a bound is the unpainted edge of a lane: nobody else's, and of no colour.
fn unpainted_edge(map: &MapIndex, way: LineStringId) -> bool {
    let kind = map.map.linestrings.get(way).map(|line| line.attributes.get("type"));
    map.users_of(way).len() == 1 && matches!(kind, Some(None | Some("virtual")))
}

/// Whether a border is where the road ends, and not that of another lane, such as of the other carriageway.
fn kerb(map: &MapIndex, border: LineStringId) -> bool {
    !map.users_of(border).iter().any(|&lane| map.lanes[lane].is_for_cars())
}

fn judge(map: &MapIndex, params: &Params, borders: &Borders, at: usize, side: usize) -> Option<Finding> {
    let lane = &map.lanes[at];
    let way = lane.bounds[side];
    if !unpainted_edge(map, way) {
        return None;
    }
    let line = Polyline::new([&lane.left, &lane.right][side].iter().copied())?;
    let outward = if side == 0 { params.reach } else { -params.reach };
    let steps = line.resampled(MEASURED_EVERY);
    let mut hits: Vec<(f64, LineStringId, Point)> = steps
        .segments()
        .filter_map(|(a, b)| {
            let from = nalgebra::center(&a, &b);
            let across = left_of(b - a).try_normalize(Polyline::MERGE)?;
            let (border, far) = borders.toward(from, across * outward)?;
            kerb(map, border).then_some((far, border, from))
        })
        .collect();
    // A border that is abreast of a part of the lane only is not that of its road.
    if 2 * hits.len() <= steps.segments().len() {
        return None;
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (far, border, place) = hits[hits.len() / 2];
    let [low, high] = params.distance;
    // Where a border runs along the bound itself, it is that bound that ends the road.
    if (low..=high).contains(&far) || far < ON_BORDER {
        return None;
    }
    let limit = if far < low { low } else { high };
    let message = format!("Edge {way} of lanelet {} lies {far:.2} m inside road border {border}.", lane.id);
    let finding = Finding::new("edge-distance", Subject::LineString(way.0), message);
    let finding =
        finding.with(Subject::Lanelet(lane.id.0), "lanelet").with(Subject::LineString(border.0), "road border");
    Some(finding.measured(far, limit, "m").at(Place::Point(place)))
}
