//! What lies on another level, and the ramps there: metres above the ground along every road.
//!
//! A road with a level lies as high as the level says from end to end, and so do the nodes at its ends. From there the
//! height falls off along the roads on the ground, the steepest first as it must be undone soonest: each place is as high as
//! the highest of its nearby bridges asks of it, less the grade times the way there.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::builder::network::{Road, RoadEnd, RoadNetwork, Stations};

use super::HeightOptions;
use super::crossings::Overpass;
use super::terrain_profile::TerrainProfile;

/// Heights are kept as whole tenths of a millimetre, which have an order.
const PER_METRE: f64 = 1e4;
/// So far from an intersection, metres, a road stays as high as that: lanes wait there, and cross the kerb beside others.
const BESIDE: f64 = 6.0;

/// Metres above the ground along one road.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// Where it may begin to rise, metres.
    from: f64,
    /// How long it may rise from there, metres.
    length: f64,
    grade: f64,
    /// What the level asks for; 0 on the ground.
    target: f64,
    /// At both ends what lifts and what lowers them.
    ends: [[f64; 2]; 2],
}

impl Ramp {
    /// Height above the ground at a station.
    pub fn at(&self, station: f64) -> f64 {
        let station = (station - self.from).clamp(0.0, self.length);
        let ways = [station, self.length - station];
        let heights = self.ends.map(|[up, down]| up - down);
        let steep = (heights[0] - heights[1]).abs() > self.grade * self.length;
        if steep && self.length > 0.0 {
            return heights[0] + (heights[1] - heights[0]) * station / self.length;
        }
        if self.target == 0.0 {
            let falling =
                |sign: usize| (0..2).map(|end| self.ends[end][sign] - self.grade * ways[end]).fold(0.0, f64::max);
            return falling(0) - falling(1);
        }
        let reach = |end: usize| self.grade * ways[end];
        let low = (0..2).map(|end| heights[end] - reach(end)).fold(f64::NEG_INFINITY, f64::max);
        let high = (0..2).map(|end| heights[end] + reach(end)).fold(f64::INFINITY, f64::min);
        self.target.clamp(low.min(high), high.max(low))
    }
}

/// The stations between which a ramp may rise: not within the intersections and where lanes wait before them.
fn free(road: &Road, kept: Stations) -> [f64; 2] {
    let length = road.line.length();
    let [from, to] = kept.map(|station| station.clamp(0.0, length));
    let left = to - from;
    if left <= 0.0 {
        // Nothing is left of it, but it joins what lies at its ends.
        return [0.0, length];
    }
    let beside = BESIDE.min(left / 4.0);
    [from + beside, to - beside]
}

/// The ramps of all roads, of which `kept` gives the stations between the intersections, over the ground of `bases`.
pub fn ramps(
    network: &RoadNetwork,
    kept: &[Stations],
    bases: &[TerrainProfile],
    crossings: &[Overpass],
    options: &HeightOptions,
) -> Vec<Ramp> {
    let free: Vec<Stations> = network.roads.iter().zip(kept).map(|(road, kept)| free(road, *kept)).collect();
    // A terrain model holds most of it already, embankments and the valleys under bridges: with one only what is missing
    // between roads that cross counts.
    let targets = match options.terrain {
        Some(_) => missing(network, bases, crossings, options.storey),
        None => network.roads.iter().map(|road| road.level * options.storey).collect(),
    };
    let asked: Vec<Option<f64>> = network.intersections.iter().map(|at| asked(&at.arms, &targets)).collect();
    let lifted = fallen(network, options, &free, &targets, &asked, 1.0);
    let lowered = fallen(network, options, &free, &targets, &asked, -1.0);
    let at = |node: u32| [lifted[node as usize], lowered[node as usize]];
    let ramp = |((road, target), [from, to]): ((&Road, &f64), &[f64; 2])| Ramp {
        from: *from,
        length: to - from,
        grade: options.grade_of(road),
        target: *target,
        ends: [at(road.from.0), at(road.to.0)],
    };
    network.roads.iter().zip(&targets).zip(&free).map(ramp).collect()
}

/// Per road how much its level lacks where it crosses a road of another level, with the ground as it is.
fn missing(network: &RoadNetwork, bases: &[TerrainProfile], crossings: &[Overpass], storey: f64) -> Vec<f64> {
    let mut missing = vec![0.0_f64; network.roads.len()];
    for crossing in crossings {
        let [(upper, above), (lower, below)] = [crossing.upper, crossing.lower];
        let wanted = crossing.levels * storey;
        let lack = (wanted - bases[upper].at(above) + bases[lower].at(below)).clamp(0.0, wanted);
        let [high, low] = [upper, lower].map(|road| network.roads[road].level.abs());
        // The road nearer to the ground stays there.
        let moved = [(high >= low).then_some((upper, lack)), (low >= high).then_some((lower, -lack))];
        for (road, lack) in moved.into_iter().flatten() {
            if lack.abs() > missing[road].abs() {
                missing[road] = lack;
            }
        }
    }
    missing
}

/// The height above the ground at which roads with a level meet: the farthest from the ground that one asks for.
fn asked(arms: &[RoadEnd], targets: &[f64]) -> Option<f64> {
    let targets = arms.iter().map(|arm| targets[arm.road]).filter(|target| *target != 0.0);
    targets.max_by(|a, b| a.abs().total_cmp(&b.abs()).then(a.total_cmp(b)))
}

/// How far every node is lifted (`sign` 1) or lowered (-1): as asked, or what is left of it after the way there.
fn fallen(
    network: &RoadNetwork,
    options: &HeightOptions,
    free: &[Stations],
    targets: &[f64],
    asked: &[Option<f64>],
    sign: f64,
) -> Vec<f64> {
    let units = |metres: f64| (metres * PER_METRE).round() as i64;
    let mut heights: Vec<i64> = asked.iter().map(|asked| units(asked.unwrap_or(0.0) * sign).max(0)).collect();
    let mut open: BinaryHeap<(i64, Reverse<usize>)> = heights
        .iter()
        .enumerate()
        .filter(|(_, height)| **height > 0)
        .map(|(i, height)| (*height, Reverse(i)))
        .collect();
    while let Some((height, Reverse(at))) = open.pop() {
        if heights[at] != height {
            continue;
        }
        for arm in network.intersections[at].arms.iter().filter(|arm| targets[arm.road] == 0.0) {
            let road = network.road(arm.road);
            let next = road.intersection(arm.end.other()).0 as usize;
            let [from, to] = free[arm.road];
            let left = height - units(options.grade_of(road) * (to - from));
            if asked[next].is_none() && left > heights[next] {
                heights[next] = left;
                open.push((left, Reverse(next)));
            }
        }
    }
    heights.into_iter().map(|height| height as f64 / PER_METRE).collect()
}
