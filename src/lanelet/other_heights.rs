//! Heights that stand under a key which Lanelet2 does not read, such as `elevation`.

use rustc_hash::FxHashSet;

use super::number::number;
use super::vocabulary::{self, On};
use super::{Point, PointId, PrimitiveLayer};

/// The heights, metres, that these points have by keys that mean `ele`; points without such a key are left out.
pub fn heights_by_other_names(points: &PrimitiveLayer<Point>, asked: &FxHashSet<PointId>) -> Vec<(PointId, f64)> {
    let asked = || points.iter().filter(|point| asked.contains(&point.id));
    let names = vocabulary::other_names(On::Point, "ele", asked().map(Point::attributes));
    if names.is_empty() {
        return Vec::new();
    }
    let height = |point: &Point| {
        let mut said = point.attributes().iter().filter(|(key, _)| names.contains(key));
        said.find_map(|(_, value)| number(value))
    };
    asked().filter_map(|point| Some((point.id, height(point)?))).collect()
}
