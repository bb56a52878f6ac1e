//! Lanes outside intersections that are as wide as a road of several lanes.

use crate::diagnostic::{Finding, Place};
use crate::lanelet::RoadType;
use crate::lanelet::index::MapIndex;

use super::params::{Params, subject};

/// A lanelet that is no longer than this many times its width is no stretch of road, but a place: a yard, or a turning circle.
const LEAST_SLENDER: f64 = 1.5;

pub fn judge(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let found = |at: usize| {
        let lane = &map.lanes[at];
        let length = lane.length();
        let width = lane.area / length;
        // Autoware drives on a centre line that is drawn.
        let is_led = lane.lanelet.centerline.is_some();
        let is_stretch = !is_led && length > LEAST_SLENDER * width && map.intersections_of(at).is_empty();
        let is_wide = lane.kind == RoadType::Road && lane.is_for_cars() && lane.simple && width > params.most_width;
        (is_wide && is_stretch && !map.is_at_unmarked(at)).then(|| {
            let message = format!("Lane {} is {width:.1} m wide on average: as wide as several lanes.", lane.id);
            let finding = Finding::new("wide", subject(map, at), message).measured(width, params.most_width, "m");
            finding.at(Place::Polygon(lane.outline.clone()))
        })
    };
    (0..map.lanes.len()).filter_map(found).collect()
}
