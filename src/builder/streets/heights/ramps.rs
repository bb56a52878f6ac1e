//! Ramps between levels: metres above the ground along every road.
//!
//! A road with a level has the height of that level from end to end, and so have the nodes at its ends. From there the height
//! decreases along the roads on the ground by their grades; each place has the largest height that results.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::builder::network::{IntersectionIx, Road, RoadEnd, RoadNetwork, Stations};

use super::HeightOptions;
use super::crossings::Overpass;
use super::terrain_profile::TerrainProfile;

/// Heights are integers of a tenth of a millimetre, which have an order.
const UNITS_PER_METRE: f64 = 1e4;
/// Length beside an intersection, metres, on which a road keeps its height: vehicles wait there.
const LEVEL_BESIDE: f64 = 6.0;

/// Metres above the ground along one road.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// The station at which it may begin to rise, metres.
    from: f64,
    /// The length on which it may rise from there, metres.
    length: f64,
    /// Metres per metre.
    grade: f64,
    /// The height by level, metres; 0 on the ground.
    target: f64,
    /// How far each end is raised and lowered, metres.
    ends: [[f64; 2]; 2],
}

impl Ramp {
    /// The height above the ground at a station, metres.
    pub fn at(&self, station: f64) -> f64 {
        let station = (station - self.from).clamp(0.0, self.length);
        let distances = [station, self.length - station];
        let heights = self.ends.map(|[up, down]| up - down);
        let steep = (heights[0] - heights[1]).abs() > self.grade * self.length;
        if steep && self.length > 0.0 {
            return heights[0] + (heights[1] - heights[0]) * station / self.length;
        }
        if self.target == 0.0 {
            let rest =
                |sign: usize| (0..2).map(|end| self.ends[end][sign] - self.grade * distances[end]).fold(0.0, f64::max);
            return rest(0) - rest(1);
        }
        let reach = |end: usize| self.grade * distances[end];
        let low = (0..2).map(|end| heights[end] - reach(end)).fold(f64::NEG_INFINITY, f64::max);
        let high = (0..2).map(|end| heights[end] + reach(end)).fold(f64::INFINITY, f64::min);
        self.target.clamp(low.min(high), high.max(low))
    }
}

/// The stations between which a ramp may rise: not in intersections or where vehicles wait before them.
fn ramp_stations(road: &Road, kept: Stations) -> Stations {
    let length = road.line.length();
    let [from, to] = kept.map(|station| station.clamp(0.0, length));
    let left = to - from;
    if left <= 0.0 {
        // Nothing remains of it, but it connects its ends.
        return [0.0, length];
    }
    let level = LEVEL_BESIDE.min(left / 4.0);
    [from + level, to - level]
}

/// The ramps of all roads above the ground of `bases`. `kept` has the stations between the intersections.
pub fn ramps(
    network: &RoadNetwork,
    kept: &[Stations],
    bases: &[TerrainProfile],
    crossings: &[Overpass],
    options: &HeightOptions,
) -> Vec<Ramp> {
    let stations: Vec<Stations> =
        network.roads.iter().zip(kept).map(|(road, kept)| ramp_stations(road, *kept)).collect();
    // A terrain model has embankments and valleys under bridges: only the missing clearance is added.
    let targets = match options.terrain {
        Some(_) => missing_heights(network, bases, crossings, options.storey),
        None => network.roads.iter().map(|road| road.level * options.storey).collect(),
    };
    let fixed: Vec<Option<f64>> = network.intersections.iter().map(|i| fixed_height(&i.arms, &targets)).collect();
    let slopes = Slopes { network, options, stations: &stations, targets: &targets, fixed: &fixed };
    let [raised, lowered] = [1.0, -1.0].map(|sign| slopes.heights(sign));
    let end = |ix: IntersectionIx| [raised[ix], lowered[ix]];
    let ramp = |((road, target), [from, to]): ((&Road, &f64), &Stations)| Ramp {
        from: *from,
        length: to - from,
        grade: options.grade_of(road),
        target: *target,
        ends: [end(road.from), end(road.to)],
    };
    network.roads.iter().zip(&targets).zip(&stations).map(ramp).collect()
}

/// Per road the height that it lacks where it crosses a road of another level, metres, negative for the lower road.
fn missing_heights(network: &RoadNetwork, bases: &[TerrainProfile], crossings: &[Overpass], storey: f64) -> Vec<f64> {
    let mut missing = vec![0.0_f64; network.roads.len()];
    for crossing in crossings {
        let [(upper, above), (lower, below)] = [crossing.upper, crossing.lower];
        let wanted = crossing.levels * storey;
        let lack = (wanted - bases[upper].at(above) + bases[lower].at(below)).clamp(0.0, wanted);
        let [high, low] = [upper, lower].map(|road| network.roads[road].level.abs());
        // Only the road with the larger level moves.
        let moved = [(high >= low).then_some((upper, lack)), (low >= high).then_some((lower, -lack))];
        for (road, lack) in moved.into_iter().flatten() {
            if lack.abs() > missing[road].abs() {
                missing[road] = lack;
            }
        }
    }
    missing
}

/// The height above the ground of an intersection of roads with a level, metres: the largest of their targets by amount.
fn fixed_height(arms: &[RoadEnd], targets: &[f64]) -> Option<f64> {
    let targets = arms.iter().map(|arm| targets[arm.road]).filter(|target| *target != 0.0);
    targets.max_by(|a, b| a.abs().total_cmp(&b.abs()).then(a.total_cmp(b)))
}

/// The roads on the ground along which heights decrease from the intersections with a `fixed` height.
struct Slopes<'a> {
    network: &'a RoadNetwork,
    options: &'a HeightOptions,
    stations: &'a [Stations],
    targets: &'a [f64],
    fixed: &'a [Option<f64>],
}

impl Slopes<'_> {
    /// How far every intersection is raised (`sign` 1) or lowered (-1), metres.
    fn heights(&self, sign: f64) -> Vec<f64> {
        let units = |metres: f64| (metres * UNITS_PER_METRE).round() as i64;
        let mut heights: Vec<i64> = self.fixed.iter().map(|fixed| units(fixed.unwrap_or(0.0) * sign).max(0)).collect();
        let positive = (0..heights.len()).filter(|i| heights[*i] > 0);
        let mut open: BinaryHeap<_> = positive.map(|i| (heights[i], Reverse(IntersectionIx::new(i)))).collect();
        while let Some((height, Reverse(ix))) = open.pop() {
            if heights[ix] != height {
                continue;
            }
            let on_ground = self.network.intersection(ix).arms.iter().filter(|arm| self.targets[arm.road] == 0.0);
            for arm in on_ground {
                let road = self.network.road(arm.road);
                let next = road.intersection(arm.end.other());
                let [from, to] = self.stations[arm.road];
                let rest = height - units(self.options.grade_of(road) * (to - from));
                if self.fixed[next].is_none() && rest > heights[next] {
                    heights[next] = rest;
                    open.push((rest, Reverse(next)));
                }
            }
        }
        heights.into_iter().map(|height| height as f64 / UNITS_PER_METRE).collect()
    }
}
