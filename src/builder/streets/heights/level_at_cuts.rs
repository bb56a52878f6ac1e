//! Heights held once more where lanes have been cut: the roads of an intersection end there without a step between them.
//!
//! Heights are worked out for the cuts that the outlines ask for. Ways that swing out cut the lanes back farther, each road on a
//! ramp of its own, so that two may end side by side at unlike heights. What remains of the step is spread over the roads
//! around, as gently as the grades allow; where there is none, nothing changes.

use rayon::prelude::*;

use crate::builder::network::road_end::on_cut;
use crate::builder::network::{Intersection, Road, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::geometry::{Point, Polyline};
use crate::parallel::Finely;

use super::crossings::overpasses;
use super::grade_limit::{Sampled, Ties, Web};
use super::options::{STEP, TOLERANCE};
use super::terrain_profile::TerrainProfile;
use super::{HeightOptions, fewest, lay};

/// Stations closer than this, metres, are one.
const SAME: f64 = 1.0;
/// Ends that touch may differ by this much, metres, which no wheel feels.
const LEAST: f64 = 0.02;

/// Changes the heights of roads that are cut at the stations `kept`, so that between their ends at an intersection there is no
/// more to climb than on a ramp. Gives the roads that changed.
pub fn level_at_cuts(network: &mut RoadNetwork, kept: &[Stations], options: &HeightOptions) -> Vec<RoadIx> {
    if network.roads.iter().all(|road| road.heights.is_empty()) {
        return Vec::new();
    }
    let before: Vec<TerrainProfile> = network.roads.par_iter().finely().map(TerrainProfile::under).collect();
    let climb = |a: RoadEnd, b: RoadEnd| climb(network, kept, options, [a, b]);
    let stepped = |at: &Intersection| {
        let height = |at: &RoadEnd| before[at.road].at(kept[at.road][at.end]);
        let heights: Vec<f64> = at.arms.iter().map(height).collect();
        let step = |i: usize, j: usize| (heights[i] - heights[j]).abs();
        let pairs = (0..heights.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        // Most are level.
        pairs.filter(|&(i, j)| step(i, j) > LEAST).any(|(i, j)| step(i, j) > climb(at.arms[i], at.arms[j]))
    };
    if !network.intersections.par_iter().finely().any(stepped) {
        return Vec::new();
    }
    let roads = network.roads.par_iter().finely().zip(kept).zip(&before);
    let sampled: Vec<Sampled> = roads.map(|((road, kept), before)| sampled(road, *kept, before, options)).collect();
    let crossings = overpasses(network, kept);
    let mut web = Web::new(network, &sampled, &crossings, options.storey);
    web.give_way();
    web.tie(Ties { kept, climb: &climb, least: LEAST });
    let heights = web.heights();
    let roads = network.roads.par_iter_mut().finely().enumerate().zip(&before);
    let changed =
        roads.zip(sampled.par_iter().finely().zip(&heights)).filter_map(|(((i, road), before), (sampled, heights))| {
            let change = || sampled.wanted.iter().zip(heights).map(|(before, height)| height - before);
            if change().all(|by| by.abs() < TOLERANCE) {
                return None;
            }
            let change = fewest(&sampled.stations.iter().copied().zip(change()).collect::<Vec<_>>());
            if change.iter().all(|(_, by)| by.abs() < TOLERANCE) {
                return None;
            }
            let mut stations: Vec<f64> = road.line.stations().into_iter().chain(change.iter().map(|at| at.0)).collect();
            stations.sort_by(f64::total_cmp);
            stations.dedup();
            let change: TerrainProfile = change.into_iter().collect();
            let profile: Vec<(f64, f64)> = stations.into_iter().map(|s| (s, before.at(s) + change.at(s))).collect();
            lay(road, &profile);
            Some(RoadIx::new(i))
        });
    changed.collect()
}

/// The most that one of two roads that end at one intersection may lie above the other there, metres.
fn climb(network: &RoadNetwork, kept: &[Stations], options: &HeightOptions, ends: [RoadEnd; 2]) -> f64 {
    let [one, other] = ends.map(|at| cut(network, kept, at));
    let apart = match (Polyline::new(one), Polyline::new(other)) {
        (Some(line), Some(beside)) => {
            let to = |line: &Polyline, ends: [Point; 2]| line.distance(ends[0]).min(line.distance(ends[1]));
            to(&line, other).min(to(&beside, one))
        }
        _ => (one[0] - other[0]).norm(),
    };
    let [a, b] = ends.map(|at| options.grade_of(network.road(at.road)));
    (a.max(b) * apart).max(LEAST)
}

/// The ends of the cut across the carriageway of a road.
fn cut(network: &RoadNetwork, kept: &[Stations], RoadEnd { road: ix, end }: RoadEnd) -> [Point; 2] {
    let road = network.road(ix);
    let (left, right) = road.section.carriageway();
    [left, right].map(|edge| on_cut(road, end, kept[ix][end], road.section.edge(edge)))
}

/// Heights as they are, at even stations of a road and where it is cut. Where it is steep, it may stay so.
fn sampled(road: &Road, kept: Stations, before: &TerrainProfile, options: &HeightOptions) -> Sampled {
    let length = road.line.length();
    let pieces = (length / STEP).ceil().max(1.0) as usize;
    let cuts: Vec<f64> = kept.into_iter().filter(|cut| (SAME..=length - SAME).contains(cut)).collect();
    let even = (0..=pieces).map(|i| length * i as f64 / pieces as f64);
    let inner = |s: &f64| *s == 0.0 || *s == length || cuts.iter().all(|cut| (cut - s).abs() > SAME);
    let mut stations: Vec<f64> = even.filter(inner).chain(cuts.iter().copied()).collect();
    stations.sort_by(f64::total_cmp);
    stations.dedup();
    let wanted: Vec<f64> = stations.iter().map(|station| before.at(*station)).collect();
    let grade = options.grade_of(road);
    let climb = |(pair, heights): (&[f64], &[f64])| (grade * (pair[1] - pair[0])).max((heights[1] - heights[0]).abs());
    let climbs = stations.windows(2).zip(wanted.windows(2)).map(climb).collect();
    Sampled { stations, wanted, climbs }
}
