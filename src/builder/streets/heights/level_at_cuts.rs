//! Removes steps between the roads of an intersection at their final cuts.
//!
//! Heights are made for the cuts of the outlines. Turns that swing out cut the lanes back farther, on ramps of their own, so that
//! two roads may end side by side at different heights. The step is spread over the roads around within the grades.

use rayon::prelude::*;

use crate::builder::network::road_end::on_cut;
use crate::builder::network::{Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::geometry::{Point, Polyline};
use crate::parallel::InSmallParts;

use super::crossings::overpasses;
use super::grade_limit::{EndTies, HeightGraph, SampledHeights};
use super::options::{SAMPLE_STEP, TOLERANCE};
use super::terrain_profile::TerrainProfile;
use super::{HeightOptions, set_heights, simplified};

/// Least distance between stations, metres.
const STATIONS_APART: f64 = 1.0;
/// Allowed step between ends that touch, metres.
const LEAST: f64 = 0.02;

/// Changes the heights of roads cut at the stations `kept`, so that their ends at an intersection differ by no more than a ramp
/// may climb between them. Returns the roads that changed.
pub fn level_at_cuts(network: &mut RoadNetwork, kept: &[Stations], options: &HeightOptions) -> Vec<RoadIx> {
    if network.roads.iter().all(|road| road.heights.is_empty()) {
        return Vec::new();
    }
    let before: Vec<TerrainProfile> = network.roads.par_iter().in_small_parts().map(TerrainProfile::under).collect();
    let climb = |a: RoadEnd, b: RoadEnd| climb(network, kept, options, [a, b]);
    let roads = network.roads.par_iter().in_small_parts().zip(kept).zip(&before);
    let sampled: Vec<SampledHeights> =
        roads.map(|((road, kept), before)| sampled(road, *kept, before, options)).collect();
    let crossings = overpasses(network, kept).places;
    let mut graph = HeightGraph::new(network, &sampled, &crossings, options.storey);
    graph.reduce_clearances();
    graph.tie(EndTies { kept, climb: &climb, least: LEAST });
    let heights = graph.heights();
    let roads = network.roads.par_iter_mut().in_small_parts().enumerate().zip(&before);
    let roads = roads.zip(sampled.par_iter().in_small_parts().zip(&heights));
    let changed = roads.filter_map(|(((i, road), before), (sampled, heights))| {
        change_heights(road, before, sampled, heights).then_some(RoadIx::new(i))
    });
    changed.collect()
}

/// Adds the changes of its samples to the heights of a road. Returns whether they are large enough to count.
fn change_heights(road: &mut Road, before: &TerrainProfile, sampled: &SampledHeights, heights: &[f64]) -> bool {
    let changes = sampled.wanted.iter().zip(heights).map(|(old, new)| new - old);
    let changes: Vec<(f64, f64)> = sampled.stations.iter().copied().zip(changes).collect();
    let changes = simplified(&changes);
    if changes.iter().all(|(_, change)| change.abs() < TOLERANCE) {
        return false;
    }
    let mut stations: Vec<f64> = road.line.stations().into_iter().chain(changes.iter().map(|(s, _)| *s)).collect();
    stations.sort_by(f64::total_cmp);
    stations.dedup();
    let changes: TerrainProfile = changes.into_iter().collect();
    set_heights(road, &stations.into_iter().map(|s| (s, before.at(s) + changes.at(s))).collect());
    true
}

/// The most that one of two road ends at an intersection may lie above the other, metres.
fn climb(network: &RoadNetwork, kept: &[Stations], options: &HeightOptions, ends: [RoadEnd; 2]) -> f64 {
    let [one, other] = ends.map(|arm| cut(network, kept, arm));
    let distance = match (Polyline::new(one), Polyline::new(other)) {
        (Some(line), Some(other_line)) => {
            let to = |line: &Polyline, ends: [Point; 2]| line.distance(ends[0]).min(line.distance(ends[1]));
            to(&line, other).min(to(&other_line, one))
        }
        _ => (one[0] - other[0]).norm(),
    };
    let [a, b] = ends.map(|arm| options.grade_of(network.road(arm.road)));
    (a.max(b) * distance).max(LEAST)
}

/// The ends of the cut across the carriageway of a road.
fn cut(network: &RoadNetwork, kept: &[Stations], RoadEnd { road: ix, end }: RoadEnd) -> [Point; 2] {
    let road = network.road(ix);
    let (left, right) = road.section.carriageway();
    [left, right].map(|edge| on_cut(road, end, kept[ix][end], road.section.edge(edge)))
}

/// The heights at even stations of a road and at its cuts. A steep road may stay as steep as it is.
fn sampled(road: &Road, kept: Stations, before: &TerrainProfile, options: &HeightOptions) -> SampledHeights {
    let length = road.line.length();
    let pieces = (length / SAMPLE_STEP).ceil().max(1.0) as usize;
    let cuts: Vec<f64> =
        kept.into_iter().filter(|cut| (STATIONS_APART..=length - STATIONS_APART).contains(cut)).collect();
    let even = (0..=pieces).map(|i| length * i as f64 / pieces as f64);
    let inner = |s: &f64| *s == 0.0 || *s == length || cuts.iter().all(|cut| (cut - s).abs() > STATIONS_APART);
    let mut stations: Vec<f64> = even.filter(inner).chain(cuts.iter().copied()).collect();
    stations.sort_by(f64::total_cmp);
    stations.dedup();
    let wanted: Vec<f64> = stations.iter().map(|station| before.at(*station)).collect();
    let grade = options.grade_of(road);
    let climb = |(pair, heights): (&[f64], &[f64])| (grade * (pair[1] - pair[0])).max((heights[1] - heights[0]).abs());
    let climbs = stations.windows(2).zip(wanted.windows(2)).map(climb).collect();
    SampledHeights { stations, wanted, climbs }
}
