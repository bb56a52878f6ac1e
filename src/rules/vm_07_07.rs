//! vm-07-07: a bus stop lies on the lanelets that tell of it, at the kerb, and holds a bus.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::Point;
use crate::lanelet::index::view::View;
use crate::lanelet::index::{DrivingSide, MapIndex};

use super::area_element;
use super::routing_moves::RoutingMoves;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    length: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let view = map.view();
    let mut findings = area_element::apart(view, "bus_stop_area", &["road", "road_shoulder"]);
    findings.extend(view.polygons("bus_stop_area").filter_map(|polygon| {
        let ring = view.ring(polygon);
        let length = diameter(&ring);
        (ring.len() > 2 && length < params.length).then(|| {
            let message = format!("Bus stop area {} is {length:.1} m long.", polygon.id);
            Finding::new("too-small", Subject::Polygon(polygon.id.0), message)
                .measured(length, params.length, "m")
                .at(Place::Polygon(ring))
        })
    }));
    findings.extend(mid_road(map, view));
    findings
}

/// The greatest distance between two corners, metres.
fn diameter(ring: &[Point]) -> f64 {
    let distances = ring.iter().flat_map(|a| ring.iter().map(move |b| (a - b).norm()));
    distances.fold(0.0, f64::max)
}

/// Bus stops on a lane that has another one between itself and its kerb.
fn mid_road(map: &MapIndex, view: &View) -> Vec<Finding> {
    let Some(side) = map.side.side else { return Vec::new() };
    let moves = RoutingMoves::new(map);
    let mut findings = Vec::new();
    for element in view.elements("bus_stop_area") {
        let lanes = map.referrers(element.id).iter().filter_map(|&id| map.lane(id));
        for at in lanes.filter(|&at| map.lanes[at].is_for_cars()) {
            let near = match side {
                DrivingSide::Left => moves.on_the_left(at),
                DrivingSide::Right => moves.on_the_right(at),
            };
            let (id, lane) = (element.id, map.lanes[at].id);
            let Some(other) = near.into_iter().find(|&other| map.lanes[other].is_for_cars()) else { continue };
            let message =
                format!("Bus stop {id} lies on lane {lane}, which has lane {} at its kerb.", map.lanes[other].id);
            findings.push(
                Finding::new("mid-road", Subject::RegulatoryElement(id.0), message)
                    .with(Subject::Lanelet(lane.0), "lane")
                    .with(Subject::Lanelet(map.lanes[other].id.0), "lane at the kerb"),
            );
        }
    }
    findings
}
