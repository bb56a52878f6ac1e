//! Which lanelets intersect, and by how much.

use geo::{Area, BooleanOps, Centroid};
use rayon::prelude::*;
use rstar::AABB;

use super::{Lane, LaneTree, Thresholds};
use crate::geometry::{Point, Polyline, polygon};
use crate::lanelet::{Bound, LaneletMap};

/// Another lanelet whose outline overlaps that of this one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conflict {
    /// The other, by its position in `MapIndex::lanes`.
    pub other: usize,
    /// Area of the overlap, square metres.
    pub area: f64,
    /// Middle of the overlap.
    pub place: Point,
    /// Whether it is large enough for the rules, and on one level. Autoware, which knows neither, reacts in any case.
    pub real: bool,
    /// Whether one passes over the other.
    pub grade_separated: bool,
}

/// For every lane its conflicts, by the other's position. Neighbours over a shared way and lanes that follow each
/// other do not conflict; lanes that start together (siblings) are left out as well.
pub(super) fn conflicts(
    map: &LaneletMap,
    lanes: &[Lane],
    tree: &LaneTree,
    thresholds: &Thresholds,
) -> Vec<Vec<Conflict>> {
    let pairs: Vec<(usize, usize, f64, Point, bool)> = lanes
        .par_iter()
        .enumerate()
        .filter(|(_, lane)| lane.simple && lane.is_drivable())
        .flat_map_iter(|(x, lane)| {
            let [low, high] = lane.extent;
            let mut others: Vec<usize> = tree
                .locate_in_envelope_intersecting(&AABB::from_corners([low.x, low.y], [high.x, high.y]))
                .map(|found| found.data)
                .filter(|&y| y > x && lanes[y].simple && lanes[y].is_drivable())
                .collect();
            others.sort_unstable();
            others.into_iter().filter_map(move |y| {
                let other = &lanes[y];
                if related(lane, other) {
                    return None;
                }
                let (area, place) = overlap(lane, other)?;
                (area > thresholds.raw_conflict)
                    .then(|| (x, y, area, place, gap(map, lane, other, place) > thresholds.grade_separation))
            })
        })
        .collect();
    let mut found = vec![Vec::new(); lanes.len()];
    for (x, y, area, place, grade_separated) in pairs {
        for (one, other) in [(x, y), (y, x)] {
            let large = area / lanes[one].area >= thresholds.real_share || area >= thresholds.real_area;
            found[one].push(Conflict { other, area, place, real: large && !grade_separated, grade_separated });
        }
    }
    for list in &mut found {
        list.sort_by_key(|conflict| conflict.other);
    }
    found
}

/// Whether two lanes are neighbours over a way, follow each other or start together.
fn related(x: &Lane, y: &Lane) -> bool {
    x.bounds.iter().any(|way| y.bounds.contains(way))
        || x.end.ids == y.start.ids
        || y.end.ids == x.start.ids
        || x.start.ids == y.start.ids
}

/// Area and middle of the overlap.
fn overlap(x: &Lane, y: &Lane) -> Option<(f64, Point)> {
    let common = polygon::to_geo(&x.outline).intersection(&polygon::to_geo(&y.outline));
    let middle = common.centroid()?;
    Some((common.unsigned_area(), Point::new(middle.x(), middle.y())))
}

/// Vertical distance of the two lanes at a place, metres.
fn gap(map: &LaneletMap, x: &Lane, y: &Lane, place: Point) -> f64 {
    // Most maps are flat: what the extremes allow is all there can be.
    let most = (x.heights[1] - y.heights[0]).max(y.heights[1] - x.heights[0]);
    if most <= 0.0 {
        return 0.0;
    }
    match (height(map, x, place), height(map, y, place)) {
        (Some(a), Some(b)) => (a - b).abs(),
        _ => 0.0,
    }
}

/// Height of a lane abreast of a place: the mean of its two bounds.
fn height(map: &LaneletMap, lane: &Lane, place: Point) -> Option<f64> {
    let lanelet = map.lanelets.get(lane.id)?;
    let [left, right] = [lanelet.left, lanelet.right].map(|bound| height_of(map, bound, place));
    Some((left? + right?) / 2.0)
}

fn height_of(map: &LaneletMap, bound: Bound, place: Point) -> Option<f64> {
    let points: Vec<_> = map.bound_points(bound).collect();
    let nearest = points.windows(2).filter_map(|pair| {
        let along = pair[1].position - pair[0].position;
        let length = along.norm();
        (length > Polyline::MERGE).then(|| {
            let t = ((place - pair[0].position).dot(&along) / (length * length)).clamp(0.0, 1.0);
            let [low, high] = [pair[0], pair[1]].map(|p| p.ele.unwrap_or(0.0));
            ((pair[0].position + along * t - place).norm(), low + (high - low) * t)
        })
    });
    nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, height)| height)
}
