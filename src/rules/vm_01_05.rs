//! vm-01-05: the two bounds of a lanelet have no point in common.

use rustc_hash::FxHashSet;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::PointId;
use crate::lanelet::index::MapIndex;

use super::NoParams;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = Vec::new();
    for lanelet in &map.map.lanelets {
        // Bounds without a point are told when they are read.
        let is_drawn = map.map.bound_points(lanelet.left).next().is_some();
        if lanelet.left.line == lanelet.right.line && is_drawn {
            let (id, way) = (lanelet.id, lanelet.left.line);
            let message = format!("Way {way} is both the left and the right bound of lanelet {id}.");
            let finding = Finding::new("shared-point", Subject::Lanelet(id.0), message);
            findings.push(finding.with(Subject::LineString(way.0), "left and right"));
            continue;
        }
        let left: FxHashSet<PointId> = map.map.bound_points(lanelet.left).map(|point| point.id).collect();
        let mut right = map.map.bound_points(lanelet.right).map(|point| point.id);
        if let Some(common) = right.find(|id| left.contains(id)) {
            let id = lanelet.id;
            let message = format!("The left and the right bound of lanelet {id} share point {common}.");
            let finding = Finding::new("shared-point", Subject::Lanelet(id.0), message);
            findings.push(finding.with(Subject::Point(common.0), "common point"));
        }
    }
    findings
}
