//! Which lanelets overlap, and by how much.

use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use rustc_hash::FxHashMap;

use super::lane::drivable_by_vehicle;
use super::thresholds;
use super::types::{Conflict, Intersection, LaneTree, MapIndex};
use super::{Edge, Lane};
use crate::geometry::{Point, Polyline, polygon};
use crate::lanelet::{Bound, Cursor, Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Point as MapPoint};
use crate::parallel::InSmallParts;

/// For every lane its conflicts, by the other's position. Neighbours over a shared way and lanes that follow each
/// other do not conflict; lanes that start together (siblings) are left out as well.
pub(super) fn conflicts(map: &LaneletMap, lanes: &[Lane], tree: &LaneTree) -> Vec<Vec<Conflict>> {
    let pairs: Vec<(usize, usize, f64, Point, bool)> = lanes
        .par_iter()
        .in_small_parts()
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
                let (area, place) = polygon::common_part(&lane.outline, &other.outline)?;
                (area > thresholds::RAW_CONFLICT)
                    .then(|| (x, y, area, place, gap(map, lane, other, place) > thresholds::GRADE_SEPARATION))
            })
        })
        .collect();
    let mut found = vec![Vec::new(); lanes.len()];
    for (x, y, area, place, grade_separated) in pairs {
        for (one, other) in [(x, y), (y, x)] {
            let large = area / lanes[one].area >= thresholds::REAL_SHARE || area >= thresholds::REAL_AREA;
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

/// The extent of a line or a lanelet.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Its bounding box: the lowest and the highest corner.
    pub extent: [Point; 2],
    /// Its lowest and its highest point, metres.
    pub heights: [f64; 2],
    /// The distance from its first point to its last, metres; of a lanelet it has no meaning.
    pub length: f64,
}

/// The extent of each line of a map, by its position in the map; `None` for a line without points.
pub fn reaches(map: &LaneletMap) -> Vec<Option<Reach>> {
    /// Lines per thread at a time: neighbours in the list also have neighbouring points.
    const CHUNK: usize = 256;
    let of_each = |lines: &[LineString]| {
        let mut points = map.points.cursor();
        lines.iter().map(|line| Reach::of(&mut points, line)).collect::<Vec<_>>()
    };
    map.linestrings.as_slice().par_chunks(CHUNK).in_small_parts().flat_map_iter(of_each).collect()
}

impl Reach {
    fn of(points: &mut Cursor<'_, MapPoint>, line: &LineString) -> Option<Self> {
        let mut before: Option<Point> = None;
        let reaches = line.points.iter().filter_map(|id| points.get(*id)).map(|p| {
            let finite = p.position.x.is_finite() && p.position.y.is_finite();
            let length = before.replace(p.position).map_or(0.0, |before| (p.position - before).norm());
            finite.then_some(Self { extent: [p.position; 2], heights: [p.ele().unwrap_or(0.0); 2], length })
        });
        reaches.reduce(|one, other| Some(one?.with(&other?))).flatten()
    }

    fn with(&self, other: &Self) -> Self {
        let ([low, high], [other_low, other_high]) = (self.extent, other.extent);
        let heights = [self.heights[0].min(other.heights[0]), self.heights[1].max(other.heights[1])];
        Self { extent: [low.inf(&other_low), high.sup(&other_high)], heights, length: self.length + other.length }
    }
}

/// Pairs of lanelets for vehicles where one passes over the other, in the order of the map: those that an index of the whole map
/// calls grade separated, found without building one. Pairs where neither `counts` are left out. `lines` is from [`reaches`].
pub fn passing(
    map: &LaneletMap,
    lines: &[Option<Reach>],
    counts: impl Fn(&Lanelet) -> bool + Sync,
) -> Vec<[LaneletId; 2]> {
    let lanelets = map.lanelets.as_slice();
    let of_line = |bound: Bound| lines[map.linestrings.position(bound.line)?];
    let reaches: Vec<(usize, Reach)> = (lanelets.par_iter().in_small_parts().enumerate())
        .filter(|(_, lanelet)| drivable_by_vehicle(lanelet))
        .filter_map(|(at, lanelet)| Some((at, of_line(lanelet.left)?.with(&of_line(lanelet.right)?))))
        .collect();
    // At least one of the two must be off the usual height. Few are, so all lanelets are compared with those.
    let mut lowest: Vec<f64> = reaches.iter().map(|(_, reach)| reach.heights[0]).collect();
    let middle = lowest.len() / 2;
    let usual = if lowest.is_empty() { 0.0 } else { *lowest.select_nth_unstable_by(middle, f64::total_cmp).1 };
    let near = 0.49 * thresholds::GRADE_SEPARATION;
    let odd = reaches.iter().filter(|(_, reach)| reach.heights.iter().any(|height| (height - usual).abs() > near));
    let boxed = odd.map(|(at, reach)| {
        let [low, high] = reach.extent;
        GeomWithData::new(Rectangle::from_corners([low.x, low.y], [high.x, high.y]), (*at, reach.heights))
    });
    let tree = RTree::bulk_load(boxed.collect());
    let over = |(x, reach): &(usize, Reach)| -> Vec<[usize; 2]> {
        let ([low, high], x) = (reach.extent, *x);
        let near = tree.locate_in_envelope_intersecting(&AABB::from_corners([low.x, low.y], [high.x, high.y]));
        let apart = near.filter(|found| {
            let [low, high] = found.data.1;
            (high - reach.heights[0]).max(reach.heights[1] - low) > thresholds::GRADE_SEPARATION
        });
        let others = apart.map(|found| found.data.0).filter(|&y| y != x);
        let counted = others.filter(|&y| counts(&lanelets[x]) || counts(&lanelets[y]));
        counted.map(|y| [x.min(y), x.max(y)]).collect()
    };
    let mut pairs: Vec<[usize; 2]> = reaches.par_iter().in_small_parts().flat_map_iter(over).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut taking_part: Vec<usize> = pairs.iter().flatten().copied().collect();
    taking_part.sort_unstable();
    taking_part.dedup();
    let lane = |at: usize| Some((at, Lane::new(map, &lanelets[at])?));
    let lanes: FxHashMap<usize, Lane> = taking_part.into_par_iter().in_small_parts().filter_map(lane).collect();
    let apart = |&[x, y]: &[usize; 2]| {
        let (x, y) = (lanes.get(&x)?, lanes.get(&y)?);
        let sound = [x, y].into_iter().all(|lane| lane.simple && lane.is_drivable()) && !related(x, y);
        let (area, place) = sound.then(|| polygon::common_part(&x.outline, &y.outline))??;
        let apart = area > thresholds::RAW_CONFLICT && gap(map, x, y, place) > thresholds::GRADE_SEPARATION;
        apart.then_some([x.id, y.id])
    };
    pairs.par_iter().in_small_parts().filter_map(apart).collect()
}

/// Vertical distance of the two lanes at a place, metres.
fn gap(map: &LaneletMap, x: &Lane, y: &Lane, place: Point) -> f64 {
    // Most maps are flat: the height ranges bound the distance.
    let most = (x.heights[1] - y.heights[0]).max(y.heights[1] - x.heights[0]);
    if most <= 0.0 {
        return 0.0;
    }
    match (height(map, x, place), height(map, y, place)) {
        (Some(a), Some(b)) => (a - b).abs(),
        _ => 0.0,
    }
}

impl MapIndex<'_> {
    /// Height of a lane abreast of a place, metres: the mean of its two bounds.
    pub fn height(&self, lane: usize, place: Point) -> Option<f64> {
        height(self.map, &self.lanes[lane], place)
    }

    /// Whether an end of a lane lies on the level of an intersection; `true` if its height is unknown.
    pub fn is_on_level_of(&self, edge: &Edge, intersection: &Intersection) -> bool {
        let height = self.edge_height(edge);
        height.is_none_or(|height| (height - intersection.height).abs() <= thresholds::GRADE_SEPARATION)
    }

    /// Whether two ends of lanes lie on one level, so that one can continue the other; `true` if a height is unknown.
    pub fn are_ends_level(&self, one: &Edge, other: &Edge) -> bool {
        let heights = self.edge_height(one).zip(self.edge_height(other));
        heights.is_none_or(|(a, b)| (a - b).abs() <= thresholds::GRADE_SEPARATION)
    }

    /// Height of an end of a lane, metres: that of its left point.
    fn edge_height(&self, edge: &Edge) -> Option<f64> {
        self.map.points.get(edge.ids[0])?.ele()
    }

    /// Whether a lane and a line lie on one level at a place; `true` if a height is unknown.
    pub fn is_level_with(&self, lane: usize, line: LineStringId, place: Point) -> bool {
        let line = height_of(self.map, Bound { line, inverted: false }, place);
        self.height(lane, place).zip(line).is_none_or(|(a, b)| (a - b).abs() <= thresholds::GRADE_SEPARATION)
    }

    /// The same of two lanes.
    pub fn are_level(&self, one: usize, other: usize, place: Point) -> bool {
        gap(self.map, &self.lanes[one], &self.lanes[other], place) <= thresholds::GRADE_SEPARATION
    }
}

/// See [`MapIndex::height`].
fn height(map: &LaneletMap, lane: &Lane, place: Point) -> Option<f64> {
    let [left, right] = [lane.lanelet.left, lane.lanelet.right].map(|bound| height_of(map, bound, place));
    Some((left? + right?) / 2.0)
}

fn height_of(map: &LaneletMap, bound: Bound, place: Point) -> Option<f64> {
    let points: Vec<_> = map.bound_points(bound).collect();
    let nearest = points.windows(2).filter_map(|pair| {
        let along = pair[1].position - pair[0].position;
        let length = along.norm();
        (length > Polyline::MERGE).then(|| {
            let t = ((place - pair[0].position).dot(&along) / (length * length)).clamp(0.0, 1.0);
            let [low, high] = [pair[0], pair[1]].map(|p| p.ele().unwrap_or(0.0));
            ((pair[0].position + along * t - place).norm(), low + (high - low) * t)
        })
    });
    nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, height)| height)
}
