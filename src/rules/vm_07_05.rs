//! vm-07-05: painted marks that guide bicycles make no lane of their own.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Vector, angle_between};
use crate::lanelet::RoadType;
use crate::lanelet::index::{Lane, MapIndex};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    share: f64,
    along: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    let outside = |at: usize| map.movement(at).is_none();
    for at in (0..map.lanes.len()).filter(|&at| map.lanes[at].bicycle && outside(at)) {
        let lane = &map.lanes[at];
        for conflict in map.conflicts[at].iter().filter(|one| !one.grade_separated && outside(one.other)) {
            let road = &map.lanes[conflict.other];
            let turned = turned(lane, road);
            let share = conflict.area / lane.area;
            if road.kind != RoadType::Road || road.bicycle || turned > params.along || share <= params.share {
                continue;
            }
            let percent = 100.0 * share;
            let message = format!("{percent:.0} % of bicycle lane {} lie on road lane {}.", lane.id, road.id);
            findings.push(
                Finding::new("on-road", Subject::Lanelet(lane.id.0), message)
                    .with(Subject::Lanelet(road.id.0), "road lane")
                    .measured(percent, 100.0 * params.share, "%")
                    .at(Place::Point(conflict.place)),
            );
        }
    }
    findings
}

/// The largest angle between a bicycle lane and the road lane at its two ends, degrees: a road lane that turns off leads across it.
fn turned(lane: &Lane, road: &Lane) -> f64 {
    let apart = |heading: Option<Vector>, place: Point| {
        let there = road.center.as_ref().map(|line| line.direction(line.project(place).station));
        heading.zip(there).map_or(180.0, |(a, b)| angle_between(a, b).abs().to_degrees())
    };
    apart(lane.heading_in(), lane.start.middle()).max(apart(lane.heading_out(), lane.end.middle()))
}
