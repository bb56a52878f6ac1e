//! The edges of a carriageway as they are compared with those of others.

use crate::builder::network::{End, Road, RoadEnd, RoadNetwork, Stations};
use crate::geometry::{Point, Polyline, Vector, left_of};
use crate::parallel::Finely;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Metres sideways per metre along the road at which it gives way.
pub(super) const SLOPE: f64 = 0.12;

/// Distance between the places, metres, at which a road is compared with others.
pub(super) const STEP: f64 = 4.0;
/// Gap, metres, that is left between two roads laid side by side.
pub(super) const CLEAR: f64 = 0.05;
/// An overlap below this, metres, is left as it is.
pub(super) const TOLERANCE: f64 = 0.03;
/// A road is never moved further than this, metres: beyond, the map is wrong, or the widths are.
pub(super) const FARTHEST: f64 = 7.0;
/// A part of a road shorter than this between its cuts, metres, need not be laid abreast.
pub(super) const SHORTEST: f64 = 2.0;

/// The tracks of the roads that may move or lie near others that do; all others stay as they are drawn.
pub(super) struct Tracks<'a> {
    pub(super) network: &'a RoadNetwork,
    pub(super) kept: &'a [Stations],
    pub(super) made: FxHashMap<usize, CarriagewayEdges>,
}

impl Tracks<'_> {
    /// The track of a road.
    pub(super) fn of(&mut self, road: usize) -> &mut CarriagewayEdges {
        self.made.entry(road).or_insert_with(|| CarriagewayEdges::new(&self.network.roads[road], self.kept[road]))
    }

    /// Makes the tracks of many roads.
    pub(super) fn make(&mut self, roads: &[usize]) {
        let new = roads.par_iter().finely().filter(|road| !self.made.contains_key(road));
        let new: Vec<_> =
            new.map(|&road| (road, CarriagewayEdges::new(&self.network.roads[road], self.kept[road]))).collect();
        self.made.extend(new);
    }

    /// How far an end of a road has moved.
    pub(super) fn shift(&self, at: RoadEnd) -> f64 {
        let track = self.made.get(&(at.road.position()));
        track.and_then(|track| track.shift.get(track.end(at.end))).copied().unwrap_or_default()
    }
}

/// One road as a list of places that can move sideways.
pub(super) struct CarriagewayEdges {
    pub(super) stations: Vec<f64>,
    pub(super) base: Vec<Point>,
    pub(super) normals: Vec<Vector>,
    /// Signed, left positive, metres.
    pub(super) shift: Vec<f64>,
    /// First and last place between the cuts; `None` if nothing worth moving remains.
    pub(super) kept: Option<[usize; 2]>,
    pub(super) half: f64,
    pub(super) level: f64,
    pub(super) mobility: f64,
}

impl CarriagewayEdges {
    pub(super) fn new(road: &Road, kept: Stations) -> Self {
        let length = road.line.length();
        let [from, to] = [kept[0].clamp(0.0, length), kept[1].clamp(0.0, length)];
        let mut stations = vec![0.0];
        if to - from > SHORTEST {
            let pieces = ((to - from) / STEP).ceil() as usize;
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
        Self { stations, base, normals, shift, kept, half: width / 2.0, level: road.level, mobility }
    }

    /// The place at one end.
    pub(super) fn end(&self, end: End) -> usize {
        match end {
            End::Start => 0,
            End::End => self.shift.len() - 1,
        }
    }

    pub(super) fn place(&self, i: usize) -> Point {
        self.base[i] + self.normals[i] * self.shift[i]
    }

    pub(super) fn is_kept(&self, i: usize) -> bool {
        self.kept.is_some_and(|[a, b]| (a..=b).contains(&i))
    }

    /// Station with the parts beyond the cuts folded into them: a road keeps its shift up to its end.
    pub(super) fn folded(&self, i: usize) -> f64 {
        match self.kept {
            Some([a, b]) => self.stations[i.clamp(a, b)],
            None => self.stations[i],
        }
    }

    /// Raises the shift to at least `target` on its own side everywhere, with gentle slopes around.
    pub(super) fn take(&mut self, target: &[f64]) {
        let mut high: Vec<f64> = self.shift.iter().zip(target).map(|(s, t)| s.max(*t).max(0.0)).collect();
        let mut low: Vec<f64> = self.shift.iter().zip(target).map(|(s, t)| (-s).max(-*t).max(0.0)).collect();
        for i in 0..target.len() {
            // A target between the old shift and zero lets the road come back.
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
