//! How high roads lie: the ground as far as it is known, and ramps to what lies on another level.
//!
//! The ground comes from a terrain model, else from nodes with `ele`, else it is level. On top of it a road on a bridge or
//! in a tunnel lies as many storeys higher or lower as its `layer` says, on its whole length; the roads at its ends climb
//! there as steeply as their class allows. Roads that meet do so at one height.

mod base;
mod ground;
mod ramp;
mod spots;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, Polyline};

use super::road_network::{Road, RoadClass, RoadNetwork};

pub use ground::Ground;
pub use spots::{Spots, spots};

/// Height from one level to the next, metres: 4.5 m of clearance, as most countries ask for, and the deck.
pub const STOREY: f64 = 6.0;
/// Distance, metres, between the places of a road at which its height is worked out.
const STEP: f64 = 5.0;
/// Heights are averaged over this distance, metres, to either side, so that the grade does not change at once.
const ROUNDED: f64 = 15.0;
/// A road's line gets no vertex for what changes its height by less than this, metres.
const TOLERANCE: f64 = 0.02;
/// A grade is told of where it is so many times as steep as it should be.
const TOO_STEEP: f64 = 1.1;

/// Heights at places of the plane, metres; `None` where nothing is known.
pub type Surface = dyn Fn(&[Point]) -> Vec<Option<f64>> + Send + Sync;

/// What heights are made from.
#[derive(Clone)]
pub struct HeightOptions {
    /// Height of the ground where nothing is known of it, metres.
    pub ground: f64,
    /// Height from one level to the next, metres.
    pub storey: f64,
    /// Steepest ramp, metres per metre; by the class of the road where absent.
    pub grade: Option<f64>,
    /// Heights that the input's nodes give.
    pub spots: Spots,
    /// The ground by a terrain model.
    pub terrain: Option<Arc<Surface>>,
}

impl Default for HeightOptions {
    fn default() -> Self {
        Self { ground: 0.0, storey: STOREY, grade: None, spots: Spots::default(), terrain: None }
    }
}

impl std::fmt::Debug for HeightOptions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HeightOptions")
            .field("ground", &self.ground)
            .field("storey", &self.storey)
            .field("grade", &self.grade)
            .field("terrain", &self.terrain.is_some())
            .finish_non_exhaustive()
    }
}

impl HeightOptions {
    /// Steepest ramp on a road, metres per metre: what design manuals allow for the class.
    fn grade_of(&self, road: &Road) -> f64 {
        let usual = match road.class {
            RoadClass::Motorway | RoadClass::Trunk if !road.link => 0.05,
            RoadClass::Motorway | RoadClass::Trunk | RoadClass::Primary => 0.07,
            RoadClass::Secondary | RoadClass::Tertiary => 0.08,
            _ => 0.12,
        };
        self.grade.unwrap_or(usual)
    }
}

/// The network with a height at every vertex of every road, and a finding for each ramp that is too steep. `kept` gives the
/// stations between which each road remains: within the intersections no ramp rises.
#[must_use]
pub fn raised(mut network: RoadNetwork, kept: &[[f64; 2]], options: &HeightOptions) -> (RoadNetwork, Vec<Finding>) {
    let level = network.roads.iter().all(|road| road.level == 0.0);
    if level && options.terrain.is_none() && options.spots.is_empty() {
        if options.ground != 0.0 {
            network.roads.iter_mut().for_each(|road| road.heights = vec![options.ground; road.line.points().len()]);
        }
        return (network, Vec::new());
    }
    let base = base::bases(&network, options);
    let ramps = ramp::ramps(&network, kept, options);
    let mut findings = Vec::new();
    for ((road, base), ramp) in network.roads.iter_mut().zip(&base).zip(&ramps) {
        let profile = profile(road, |station| base.at(station) + ramp.at(station));
        lay(road, &profile);
        findings.extend(steep(road, options.grade_of(road)));
    }
    (network, findings)
}

/// Heights by station, as few as tell the height everywhere.
fn profile(road: &Road, height: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let length = road.line.length();
    let pieces = (length / STEP).ceil().max(1.0) as usize;
    let stations: Vec<f64> = (0..=pieces).map(|i| length * i as f64 / pieces as f64).collect();
    let heights: Vec<f64> = stations.iter().map(|s| height(*s)).collect();
    let reach = (ROUNDED / STEP).round() as usize;
    // As far to the one side as to the other, so that the ends stay and a steady grade does, too.
    let mean = |i: usize| {
        let reach = reach.min(i).min(pieces - i);
        heights[i - reach..=i + reach].iter().sum::<f64>() / (2 * reach + 1) as f64
    };
    let all: Vec<(f64, f64)> = stations.iter().copied().zip((0..=pieces).map(mean)).collect();
    fewest(&all)
}

/// The corners of a profile that differ from the line through the others.
fn fewest(all: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut keep = vec![false; all.len()];
    let mut open = vec![(0, all.len() - 1)];
    while let Some((a, b)) = open.pop() {
        (keep[a], keep[b]) = (true, true);
        let slope = (all[b].1 - all[a].1) / (all[b].0 - all[a].0).max(f64::EPSILON);
        let off = |i: usize| (all[i].1 - all[a].1 - slope * (all[i].0 - all[a].0)).abs();
        let farthest = (a + 1..b).max_by(|i, j| off(*i).total_cmp(&off(*j)));
        if let Some(i) = farthest.filter(|i| off(*i) > TOLERANCE) {
            open.extend([(a, i), (i, b)]);
        }
    }
    all.iter().zip(keep).filter_map(|(at, keep)| keep.then_some(*at)).collect()
}

/// Gives a road its profile; its line gets a vertex wherever the grade changes.
fn lay(road: &mut Road, profile: &[(f64, f64)]) {
    /// Vertices closer than this, metres, are one.
    const SAME: f64 = 0.5;
    let mut stations = road.line.stations();
    let own = stations.clone();
    let inner = profile.iter().map(|at| at.0).filter(|s| own.iter().all(|own| (own - s).abs() > SAME));
    stations.extend(inner);
    stations.sort_by(f64::total_cmp);
    if let Some(line) = Polyline::new(road.line.at_each(stations.iter().copied()))
        && line.points().len() == stations.len()
    {
        road.line = line;
    } else {
        stations = own;
    }
    let mut heights = Vec::with_capacity(stations.len());
    let mut i = 0;
    for station in stations {
        while i + 2 < profile.len() && profile[i + 1].0 < station {
            i += 1;
        }
        let [(from, low), (to, high)] = [profile[i], profile[(i + 1).min(profile.len() - 1)]];
        let part = if to > from { ((station - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        heights.push(low + (high - low) * part);
    }
    road.heights = heights;
}

/// A finding where a road climbs more than it may.
fn steep(road: &Road, most: f64) -> Option<Finding> {
    let stations = road.line.stations();
    let grade = |i: usize| {
        let run = stations[i + 1] - stations[i];
        if run < STEP / 2.0 { 0.0 } else { (road.heights[i + 1] - road.heights[i]).abs() / run }
    };
    let worst = (0..stations.len() - 1).max_by(|a, b| grade(*a).total_cmp(&grade(*b)))?;
    let percent = |grade: f64| (grade * 100.0).round();
    (grade(worst) > most * TOO_STEEP).then(|| {
        let message = format!(
            "way {} climbs {} %, more than the {} % of its class: there is no room for a longer ramp",
            road.key.way,
            percent(grade(worst)),
            percent(most)
        );
        Finding::new("grade-steep", Subject::Way(road.key.way), message)
            .at(Place::Point(road.line.points()[worst]))
            .graded(Severity::Info)
    })
}
