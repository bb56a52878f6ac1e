//! vm-05-04: fences beside crosswalks stand where nobody walks.

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Polyline, segment_crossing};
use crate::lanelet::RoadType;
use crate::lanelet::index::MapIndex;

use super::{NoParams, barrier};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = Vec::new();
    for barrier in barrier::all(map) {
        for at in barrier.lanes_near(map) {
            let lane = &map.lanes[at];
            if lane.kind != RoadType::Crosswalk {
                continue;
            }
            let Some(place) = lane.center.as_ref().and_then(|center| crossing(&barrier.line, center)) else {
                continue;
            };
            let message = format!("The {} {} runs across crosswalk {}.", barrier.kind, barrier.id, lane.id);
            findings.push(
                Finding::new("across", Subject::LineString(barrier.id.0), message)
                    .with(Subject::Lanelet(lane.id.0), "crosswalk")
                    .at(Place::Point(place)),
            );
        }
    }
    findings
}

/// Where a line cuts the middle of a crosswalk, along which people walk.
fn crossing(line: &Polyline, middle: &Polyline) -> Option<Point> {
    let mut pairs = line.segments().flat_map(|(a, b)| middle.segments().map(move |(c, d)| (a, b, c, d)));
    pairs.find_map(|(a, b, c, d)| segment_crossing(a, b, c, d).map(|(_, _, place)| place))
}
