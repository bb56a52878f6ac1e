//! A road as a row of places that move sideways.

use crate::builder::network::{End, Road, RoadEnd, RoadNetwork, Stations};
use crate::geometry::{Point, Polyline, Vector, left_of};
use crate::parallel::InSmallParts;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Most change of the shift per metre along the road, metres.
pub(super) const SLOPE: f64 = 0.12;

/// Distance between the places of a road, metres.
pub(super) const PLACE_STEP: f64 = 4.0;
/// Gap left between two roads side by side, metres.
pub(super) const GAP_BETWEEN: f64 = 0.05;
/// A smaller overlap, metres, stays.
pub(super) const TOLERANCE: f64 = 0.03;
/// No road moves further than this, metres: beyond, the map or the widths are wrong.
pub(super) const FARTHEST: f64 = 7.0;
/// How far later rounds pass on what they move, metres.
const PASSED_ON: f64 = 10.0;
/// A road shorter than this between its cuts, metres, does not move.
pub(super) const SHORTEST: f64 = 2.0;

/// The roads that may move or lie near others that do; all others stay as they are drawn.
pub(super) struct ShiftedRoads<'a> {
    pub(super) network: &'a RoadNetwork,
    pub(super) kept: &'a [Stations],
    pub(super) made: FxHashMap<usize, ShiftedRoad>,
}

impl ShiftedRoads<'_> {
    pub(super) fn of(&mut self, road: usize) -> &mut ShiftedRoad {
        self.made.entry(road).or_insert_with(|| drawn(self.network, self.kept, road))
    }

    /// Adds the roads that are not yet there.
    pub(super) fn make(&mut self, roads: &[usize]) {
        let new = roads.par_iter().in_small_parts().filter(|road| !self.made.contains_key(road));
        let new: Vec<_> = new.map(|&road| (road, drawn(self.network, self.kept, road))).collect();
        self.made.extend(new);
    }

    /// How far an end of a road has moved to the left of its line, metres.
    pub(super) fn shift(&self, arm: RoadEnd) -> f64 {
        self.made.get(&arm.road.position()).map_or(0.0, |road| road.shift[road.end(arm.end)])
    }
}

/// A road as it is drawn.
fn drawn(network: &RoadNetwork, kept: &[Stations], index: usize) -> ShiftedRoad {
    let road = &network.roads[index];
    let continued = [road.from, road.to].map(|end| network.intersection(end).arms.len() == 2);
    ShiftedRoad::new(road, kept[index], continued)
}

/// A road as places along its line that move sideways.
pub(super) struct ShiftedRoad {
    pub(super) stations: Vec<f64>,
    pub(super) base: Vec<Point>,
    pub(super) normals: Vec<Vector>,
    /// By place, metres, left positive.
    pub(super) shift: Vec<f64>,
    /// First and last place between the cuts; `None` if the road is too short to move.
    pub(super) kept: Option<[usize; 2]>,
    /// Half the width, metres.
    pub(super) half: f64,
    pub(super) level: f64,
    /// Whether one other road continues it, at its start and at its end.
    pub(super) continued: [bool; 2],
    /// How much of an overlap it yields, compared with that of its neighbour.
    pub(super) mobility: f64,
}

impl ShiftedRoad {
    pub(super) fn new(road: &Road, kept: Stations, continued: [bool; 2]) -> Self {
        let length = road.line.length();
        let [from, to] = [kept[0].clamp(0.0, length), kept[1].clamp(0.0, length)];
        let mut stations = vec![0.0];
        if to - from > SHORTEST {
            let pieces = ((to - from) / PLACE_STEP).ceil() as usize;
            let inner = (0..=pieces).map(|i| from + (to - from) * i as f64 / pieces as f64);
            stations.extend(inner.filter(|s| *s > Polyline::MERGE && *s < length - Polyline::MERGE));
        }
        stations.push(length);
        let base: Vec<Point> = places(&road.line, &stations);
        let normals = normals(&base);
        let index = |station: f64| stations.iter().position(|s| *s >= station - Polyline::MERGE);
        let kept = if to - from > SHORTEST { index(from).zip(index(to)).map(|(a, b)| [a, b]) } else { None };
        let width = road.section.width();
        let mobility = if road.link { 3.0 } else { 1.0 } / (width * width).max(1.0);
        let shift = vec![0.0; base.len()];
        let half = width / 2.0;
        Self { stations, base, normals, shift, kept, half, level: road.level, continued, mobility }
    }

    /// The shifts, metres, without those that are small where all beside them are.
    pub(super) fn noticed(&self) -> Vec<f64> {
        let is_large = |i: usize| self.shift.get(i).is_some_and(|shift| shift.abs() > TOLERANCE);
        let noticed = |i: usize| is_large(i) || is_large(i + 1) || i.checked_sub(1).is_some_and(is_large);
        self.shift.iter().enumerate().map(|(i, shift)| if noticed(i) { *shift } else { 0.0 }).collect()
    }

    /// The place at one end.
    pub(super) fn end(&self, end: End) -> usize {
        match end {
            End::Start => 0,
            End::End => self.shift.len() - 1,
        }
    }

    /// The moved place.
    pub(super) fn place(&self, i: usize) -> Point {
        self.base[i] + self.normals[i] * self.shift[i]
    }

    pub(super) fn is_kept(&self, i: usize) -> bool {
        self.kept.is_some_and(|[a, b]| (a..=b).contains(&i))
    }

    /// The station of a place, metres; beyond a cut that of the cut, so that the shift is constant there.
    pub(super) fn folded(&self, i: usize) -> f64 {
        match self.kept {
            Some([a, b]) => self.stations[i.clamp(a, b)],
            None => self.stations[i],
        }
    }

    /// Limits a `target`, metres, so that [`ShiftedRoad::shift_to`] moves no place that lies [`PASSED_ON`] or farther from one that is
    /// pushed, and no end at which one road continues another.
    pub(super) fn keep_near(&self, target: &mut [f64]) {
        let last = target.len() - 1;
        for (i, target) in target.iter_mut().enumerate() {
            let far = |j: &usize| (self.folded(i) - self.folded(*j)).abs() >= PASSED_ON;
            let before = (0..=i).rev().find(far).or(self.continued[0].then_some(0));
            let after = (i..=last).find(far).or(self.continued[1].then_some(last));
            for fixed in [before, after].into_iter().flatten() {
                let room = SLOPE * (self.folded(i) - self.folded(fixed)).abs();
                *target = target.clamp(self.shift[fixed] - room, self.shift[fixed] + room);
            }
        }
    }

    /// Shifts every place at least to its `target`, metres, with slopes of at most [`SLOPE`] around.
    pub(super) fn shift_to(&mut self, target: &[f64]) {
        let mut high: Vec<f64> = self.shift.iter().zip(target).map(|(s, t)| s.max(*t).max(0.0)).collect();
        let mut low: Vec<f64> = self.shift.iter().zip(target).map(|(s, t)| (-s).max(-*t).max(0.0)).collect();
        for i in 0..target.len() {
            // A target between the old shift and zero moves the road back.
            if target[i] >= 0.0 && self.shift[i] > target[i] {
                high[i] = target[i];
            }
            if target[i] <= 0.0 && self.shift[i] < target[i] {
                low[i] = -target[i];
            }
        }
        for side in [&mut high, &mut low] {
            for i in 1..side.len() {
                side[i] = side[i].max(side[i - 1] - SLOPE * (self.folded(i) - self.folded(i - 1)));
            }
            for i in (1..side.len()).rev() {
                side[i - 1] = side[i - 1].max(side[i] - SLOPE * (self.folded(i) - self.folded(i - 1)));
            }
        }
        for (i, shift) in self.shift.iter_mut().enumerate() {
            *shift = (high[i] - low[i]).clamp(-FARTHEST, FARTHEST);
        }
    }
}

/// The points of a line at ascending stations.
pub(super) fn places(line: &Polyline, stations: &[f64]) -> Vec<Point> {
    let marks = line.stations();
    let points = line.points();
    let mut segment = 0;
    stations
        .iter()
        .map(|s| {
            while segment + 2 < marks.len() && marks[segment + 1] < *s {
                segment += 1;
            }
            let t = ((s - marks[segment]) / (marks[segment + 1] - marks[segment])).clamp(0.0, 1.0);
            points[segment] + (points[segment + 1] - points[segment]) * t
        })
        .collect()
}

/// Unit normals to the left at each of two or more points.
pub(super) fn normals(points: &[Point]) -> Vec<Vector> {
    (0..points.len())
        .map(|i| {
            let (a, b) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
            left_of((b - a).try_normalize(0.0).unwrap_or_else(Vector::x))
        })
        .collect()
}
