//! vm-01-12: a centre line ends in the middle of the lane where its neighbour has none, and is smooth.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::angle_between;
use crate::lanelet::index::MapIndex;

use super::centerline_ends::{End, OwnCenterline, bend, centred, heading, lane_bend};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    off: f64,
    edge: f64,
    bend: f64,
    kink: f64,
    step: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    for lane in 0..map.lanes.len() {
        let Some(own) = OwnCenterline::of(map, lane, params.edge) else { continue };
        findings.extend(kink(map, params, lane, &own));
        for (end, neighbours) in [(End::Start, map.predecessors(lane)), (End::Stop, map.followers(lane))] {
            // Where one of them has a line of its own, vm-01-11 says where both have to end.
            let bare: Vec<usize> = neighbours.iter().copied().filter(|&next| !has_line(map, next)).collect();
            if let ([first, ..], true) = (&bare[..], bare.len() == neighbours.len()) {
                findings.extend(judge(map, params, lane, &own, end, *first));
            }
        }
    }
    findings
}

fn has_line(map: &MapIndex, lane: usize) -> bool {
    map.lanes[lane].lanelet.centerline.is_some()
}

fn judge(map: &MapIndex, params: &Params, lane: usize, own: &OwnCenterline, end: End, next: usize) -> Option<Finding> {
    let (at, neighbour) = (&map.lanes[lane], &map.lanes[next]);
    let edge = if end == End::Start { &at.start } else { &at.end };
    let place = own.place(end);
    let finding = |fault, message: String| {
        Finding::new(fault, Subject::LineString(own.way.0), message)
            .with(Subject::Lanelet(at.id.0), "lanelet")
            .with(Subject::Lanelet(neighbour.id.0), "neighbour without centre line")
            .at(Place::Point(place))
    };
    let word = if end == End::Start { "begins" } else { "ends" };
    let off = (place - edge.middle()).norm();
    if off > params.off {
        let message = format!(
            "Centre line {} of lanelet {} {word} {off:.2} m beside the middle; lanelet {} has none and is driven there.",
            own.way, at.id, neighbour.id
        );
        let moved = centred(map.map, own.way, own.ends[usize::from(end == End::Stop)], edge.ids);
        let finding = finding("off-middle", message).measured(off, params.off, "m");
        let title = format!("let it {} in the middle", if end == End::Start { "begin" } else { "end" });
        return Some(match moved {
            Some(edit) => finding.fixed_by(title, false, vec![edit]),
            None => finding,
        });
    }
    let middle = neighbour.center.as_ref()?;
    let (turn, unavoidable) = match end {
        End::Start => (bend(heading(middle, End::Stop), own.heading(End::Start)), lane_bend(map, next, lane)),
        End::Stop => (bend(own.heading(End::Stop), heading(middle, End::Start)), lane_bend(map, lane, next)),
    };
    let limit = params.bend + unavoidable;
    let turn = turn.filter(|&turn| turn > limit)?;
    let message = format!(
        "Centre line {} meets the middle of lanelet {} at an angle of {turn:.0} degrees.",
        own.way, neighbour.id
    );
    Some(finding("joint", message).measured(turn, limit, "deg"))
}

/// The sharpest bend of a centre line over one step on either side of a vertex.
fn kink(map: &MapIndex, params: &Params, lane: usize, own: &OwnCenterline) -> Option<Finding> {
    let stations = own.line.stations();
    let inner = stations.get(1..stations.len() - 1).unwrap_or_default();
    let bends = inner.iter().map(|&station| {
        let [before, at, behind] = [-params.step, 0.0, params.step].map(|by| own.line.at(station + by));
        (angle_between(at - before, behind - at).abs().to_degrees(), at)
    });
    let (turn, place) = bends.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(turn, _)| *turn > params.kink)?;
    let id = map.lanes[lane].id;
    let message = format!("Centre line {} of lanelet {id} bends by {turn:.0} degrees at one place.", own.way);
    let finding = Finding::new("kink", Subject::LineString(own.way.0), message).with(Subject::Lanelet(id.0), "lanelet");
    Some(finding.measured(turn, params.kink, "deg").at(Place::Point(place)))
}
