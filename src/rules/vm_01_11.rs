//! vm-01-11: a centre line goes on where the one before it ends.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::lanelet::index::MapIndex;

use super::centerline_ends::{End, OwnCenterline, bend, lane_bend};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    pub(super) gap: f64,
    edge: f64,
    bend: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let own: Vec<Option<OwnCenterline>> =
        (0..map.lanes.len()).map(|lane| OwnCenterline::of(map, lane, params.edge)).collect();
    let mut findings = Vec::new();
    for (lane, line) in own.iter().enumerate() {
        let Some(line) = line else { continue };
        for &next in map.followers(lane) {
            let Some(other) = &own[next] else { continue };
            findings.extend(judge(map, params, [lane, next], [line, other]));
        }
    }
    findings
}

fn judge(map: &MapIndex, params: &Params, lanes: [usize; 2], [line, next]: [&OwnCenterline; 2]) -> Option<Finding> {
    let [id, follower] = lanes.map(|lane| map.lanes[lane].id);
    let (end, start) = (line.place(End::Stop), next.place(End::Start));
    let finding = |fault, message: String| {
        Finding::new(fault, Subject::LineString(line.way.0), message)
            .with(Subject::LineString(next.way.0), "next centre line")
            .with(Subject::Lanelet(id.0), "lanelet")
            .with(Subject::Lanelet(follower.0), "next lanelet")
            .at(Place::Line(vec![end, start]))
    };
    let gap = (end - start).norm();
    if gap > params.gap {
        let message = format!(
            "Centre line {} of lanelet {id} ends {gap:.2} m from where {} of lanelet {follower} begins.",
            line.way, next.way
        );
        let found = finding("gap", message).measured(gap, params.gap, "m");
        let edits = vec![Edit::MergePoints { from: next.ends[0].0, to: line.ends[1].0 }];
        return Some(found.fixed_by("let both lines use one point there", false, edits));
    }
    let limit = params.bend + lane_bend(map, lanes[0], lanes[1]);
    let turn = bend(line.heading(End::Stop), next.heading(End::Start)).filter(|&turn| turn > limit)?;
    let message = format!("Centre lines {} and {} meet at an angle of {turn:.0} degrees.", line.way, next.way);
    Some(finding("joint", message).measured(turn, limit, "deg"))
}
