//! Heights of roads: the ground, and ramps to roads on other levels.
//!
//! The ground comes from nodes with `ele`, else from a terrain model, else it is level. A road on a bridge or in a tunnel lies
//! `layer` storeys above or below the ground on its whole length; the roads at its ends climb to it as steeply as their class
//! allows. Roads that meet have the same height there. At the end the grades are limited: a place that is too steep is spread
//! over the roads around it.

mod crossings;
mod elevation_tags;
mod grade_limit;
mod interpolation;
mod level_at_cuts;
mod options;
mod ramps;
mod road_heights;
mod surface;
mod terrain_profile;
#[cfg(test)]
mod tests;

pub use options::HeightOptions;

use crate::builder::network::{Road, RoadNetwork, Stations};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::Polyline;
use crate::parallel::InSmallParts;

use crossings::{Overpass, Overpasses, overpasses};
use grade_limit::{HeightGraph, SampledHeights};
use options::{ROUNDED_SAMPLES, SAMPLE_STEP, TOLERANCE};
use ramps::Ramp;
use terrain_profile::TerrainProfile;

use rayon::prelude::*;

pub use elevation_tags::{ElevationTags, elevation, elevation_tags};
pub use level_at_cuts::level_at_cuts;
pub use road_heights::road_heights;
pub use surface::{Ground, rounded};

/// Least difference from the height by ground and level that gets a finding, metres.
const DISPLACED: f64 = 0.5;
/// Least lack of clearance that gets a finding, metres.
const LACKING: f64 = 0.5;

/// The network with a height at every vertex of every road, and findings for roads away from the height by ground and level, and
/// for crossings with too little clearance. `kept` has the stations between which each road remains: intersections have no ramps.
#[must_use]
pub fn with_heights(
    mut network: RoadNetwork,
    kept: &[Stations],
    options: &HeightOptions,
) -> (RoadNetwork, Vec<Finding>) {
    let level = network.roads.iter().all(|road| road.level == 0.0);
    if level && options.terrain.is_none() && options.spots.is_empty() {
        if options.ground != 0.0 {
            network.roads.iter_mut().for_each(|road| road.heights = vec![options.ground; road.line.points().len()]);
        }
        return (network, Vec::new());
    }
    let bases = terrain_profile::terrain_profiles(&network, options);
    let Overpasses { places: crossings, too_many } = overpasses(&network, kept);
    let ramps = ramps::ramps(&network, kept, &bases, &crossings, options);
    let roads = network.roads.par_iter().in_small_parts().zip(kept).zip(bases.par_iter().in_small_parts().zip(&ramps));
    let sample = |((road, kept), (base, ramp)): ((&Road, &Stations), _)| sampled(road, *kept, base, ramp, options);
    let sampled: Vec<SampledHeights> = roads.map(sample).collect();
    let heights = HeightGraph::new(&network, &sampled, &crossings, options.storey).heights();
    let roads =
        network.roads.par_iter_mut().in_small_parts().zip(sampled.into_par_iter().in_small_parts().zip(heights));
    let laid = roads.map(|(road, (sampled, heights))| {
        let displaced = displaced(road, &sampled, &heights);
        set_heights(road, &profile(&sampled.stations, &heights));
        displaced
    });
    let mut findings: Vec<Finding> = laid.flatten_iter().collect();
    findings.extend(short_clearances(&network, &crossings, options.storey));
    findings.extend(too_many.into_iter().map(|(road, counts)| too_many_crossings(&network.roads[road], counts)));
    (network, findings)
}

/// Wanted heights at even stations of a road, and how much it may climb between them.
fn sampled(road: &Road, kept: Stations, base: &TerrainProfile, ramp: &Ramp, options: &HeightOptions) -> SampledHeights {
    let length = road.line.length();
    let pieces = (length / SAMPLE_STEP).ceil().max(1.0) as usize;
    let step = length / pieces as f64;
    let stations: Vec<f64> = (0..=pieces).map(|i| step * i as f64).collect();
    let ground: Vec<f64> = stations.iter().map(|station| base.at(*station)).collect();
    let wanted = stations.iter().zip(&ground).map(|(station, ground)| ground + ramp.at(*station)).collect();
    let [usual, most] = [options.grade_of(road), options.steepest_of(road)];
    let climb = |(pair, ground): (&[f64], &[f64])| {
        let (length, middle) = (pair[1] - pair[0], (pair[0] + pair[1]) / 2.0);
        // Between intersections a road may climb like the ground; in them only like a ramp.
        let steep = if (kept[0]..=kept[1]).contains(&middle) { (ground[1] - ground[0]).abs() } else { 0.0 };
        steep.min(most * length).max(usual * length)
    };
    let climbs = stations.windows(2).zip(ground.windows(2)).map(climb).collect();
    SampledHeights { stations, wanted, climbs }
}

/// The smoothed profile of heights at even steps, with as few stations as possible.
fn profile(stations: &[f64], heights: &[f64]) -> TerrainProfile {
    if heights.iter().all(|height| *height == heights[0]) {
        return [0, heights.len() - 1].map(|i| (stations[i], heights[i])).into_iter().collect();
    }
    // Symmetric, so that the ends and a steady grade stay.
    let mean = |i: usize| {
        let reach = ROUNDED_SAMPLES.min(i).min(heights.len() - 1 - i);
        heights[i - reach..=i + reach].iter().sum::<f64>() / (2 * reach + 1) as f64
    };
    let all: Vec<(f64, f64)> = stations.iter().copied().zip((0..heights.len()).map(mean)).collect();
    simplified(&all).into_iter().collect()
}

/// A profile of stations and heights, metres, without points near the line through the others (Douglas-Peucker).
fn simplified(all: &[(f64, f64)]) -> Vec<(f64, f64)> {
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
    all.iter().zip(keep).filter_map(|(point, keep)| keep.then_some(*point)).collect()
}

/// Sets the heights of a road; its line gets a vertex wherever the grade changes.
fn set_heights(road: &mut Road, profile: &TerrainProfile) {
    /// Vertices closer than this, metres, are one.
    const SAME_VERTEX: f64 = 0.5;
    let mut stations = road.line.stations();
    let is_new = |s: &f64| {
        let next = stations.partition_point(|own| own < s);
        stations[next.saturating_sub(1)..].iter().take(2).all(|own| (own - s).abs() > SAME_VERTEX)
    };
    let inner: Vec<f64> = profile.stations().iter().copied().filter(is_new).collect();
    if !inner.is_empty() {
        let mut all = [&stations[..], &inner].concat();
        all.sort_by(f64::total_cmp);
        if let Some(line) = Polyline::new(road.line.at_each(all.iter().copied()))
            && line.points().len() == all.len()
        {
            road.line = line;
            stations = all;
        }
    }
    road.heights = stations.into_iter().map(|station| profile.at(station)).collect();
}

/// A finding if a road lies away from the height by ground and level, because of its grade or a clearance.
fn displaced(road: &Road, sampled: &SampledHeights, heights: &[f64]) -> Option<Finding> {
    let off = |i: usize| heights[i] - sampled.wanted[i];
    let worst = (0..heights.len()).max_by(|a, b| off(*a).abs().total_cmp(&off(*b).abs()))?;
    (off(worst).abs() > DISPLACED).then(|| {
        let message = format!(
            "way {} lies up to {:.1} m {} than ground and layer ask, so that no road climbs more than it may",
            road.key.way,
            off(worst).abs(),
            if off(worst) > 0.0 { "higher" } else { "lower" },
        );
        Finding::new("grade-held", Subject::Way(road.key.way), message)
            .at(Place::Point(road.line.at(sampled.stations[worst])))
            .graded(Severity::Info)
    })
}

/// A finding for each two roads that lie over each other with less clearance than by their levels, where it lacks most.
fn short_clearances(network: &RoadNetwork, crossings: &[Overpass], storey: f64) -> Vec<Finding> {
    let lacking = |crossing: &Overpass| {
        let roads = [crossing.upper, crossing.lower];
        let [above, below] = roads.map(|(road, _)| Ground::under(&network.roads[road]).at(crossing.place));
        let (room, wanted) = (above - below, crossing.levels * storey);
        (room < wanted - LACKING).then_some((room, wanted))
    };
    let found = crossings.iter().filter_map(|crossing| Some((crossing, lacking(crossing)?)));
    // Crossings of two roads follow each other.
    let mut worst: Vec<(&Overpass, (f64, f64))> = Vec::new();
    for (crossing, (room, wanted)) in found {
        let roads = |crossing: &Overpass| [crossing.upper.0, crossing.lower.0];
        match worst.last_mut().filter(|(last, _)| roads(last) == roads(crossing)) {
            Some((last, lack)) if wanted - room > lack.1 - lack.0 => (*last, *lack) = (crossing, (room, wanted)),
            Some(_) => {}
            None => worst.push((crossing, (room, wanted))),
        }
    }
    worst.into_iter().map(|(crossing, (room, wanted))| short_clearance(network, crossing, room, wanted)).collect()
}

fn too_many_crossings(road: &Road, [count, most]: [usize; 2]) -> Finding {
    let message = format!(
        "way {} lies over or under other ways at {count} places: too many; at the first {most} there is room between them; remove \
         what is drawn twice, or build a smaller part",
        road.key.way
    );
    Finding::new("too-many-overpasses", Subject::Way(road.key.way), message)
        .at(Place::Line(road.line.points().to_vec()))
        .graded(Severity::Warning)
}

fn short_clearance(network: &RoadNetwork, crossing: &Overpass, room: f64, wanted: f64) -> Finding {
    let [upper, lower] = [crossing.upper, crossing.lower].map(|(road, _)| network.roads[road].key.way);
    let message = format!(
        "way {upper} passes over way {lower} with {room:.1} m between them, not {wanted:.1} m: \
         the roads around are too short to climb there"
    );
    Finding::new("clearance-short", Subject::Way(upper), message)
        .with(Subject::Way(lower), "below")
        .at(Place::Point(crossing.place))
        .graded(Severity::Info)
}
