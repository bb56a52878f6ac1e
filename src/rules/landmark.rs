//! landmark: whether the localization reads the landmarks of the map.

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::Polygon;
use crate::lanelet::index::MapIndex;
use crate::text::counted;

use super::NoParams;

/// The corners that a landmark has.
const CORNERS: usize = 4;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    map.view().polygons("pose_marker").flat_map(judge).collect()
}

fn judge(marker: &Polygon) -> Vec<Finding> {
    let (id, about) = (marker.id, Subject::Polygon(marker.id.0));
    let mut findings = Vec::new();
    if marker.points.len() != CORNERS {
        let message = format!("Landmark {id} has {}, not {CORNERS}.", counted(marker.points.len(), "corner"));
        findings.push(Finding::new("corners", about, message));
    }
    if !marker.attributes.has("marker_id") {
        findings.push(Finding::new("no-id", about, format!("Landmark {id} does not say which one it is.")));
    }
    findings
}
