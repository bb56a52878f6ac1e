//! The ground along every road, without ramps.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork};
use crate::geometry::Point;
use crate::parallel::Finely;

use super::HeightOptions;

/// The ground is taken from a terrain model every so many metres along a road.
const SAMPLED: f64 = 20.0;
/// A known place so close to the end of a road, metres, is that of its node.
const AT_END: f64 = 1.0;
/// A known place farther from a road's line than this, metres, is not on it.
const ASIDE: f64 = 10.0;
/// So often what lies between known heights is brought nearer to the mean of its neighbours.
const SWEEPS: usize = 60;
/// Lengths are kept as whole millimetres, which have an order.
const PER_METRE: f64 = 1e3;

/// The ground along one road: stations and heights, linear between them.
pub struct TerrainProfile {
    stations: Vec<f64>,
    heights: Vec<f64>,
}

impl FromIterator<(f64, f64)> for TerrainProfile {
    /// From stations, in order, and the heights there.
    fn from_iter<T: IntoIterator<Item = (f64, f64)>>(profile: T) -> Self {
        let (stations, heights) = profile.into_iter().unzip();
        Self { stations, heights }
    }
}

impl TerrainProfile {
    /// What a road lies on.
    pub fn under(road: &Road) -> Self {
        let heights = road.heights.iter().copied().chain(std::iter::repeat(0.0));
        road.line.stations().into_iter().zip(heights).collect()
    }

    /// Height at a station.
    pub fn at(&self, station: f64) -> f64 {
        let i = self.stations.partition_point(|s| *s < station).clamp(1, self.stations.len() - 1);
        let [from, to] = [self.stations[i - 1], self.stations[i]];
        let part = if to > from { ((station - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        self.heights[i - 1] + (self.heights[i] - self.heights[i - 1]) * part
    }
}

/// Places whose height is known or sought: the intersections first, then those along the roads.
struct Web {
    heights: Vec<Option<f64>>,
    /// Per place its neighbours, with the distance in metres.
    near: Vec<Vec<(usize, f64)>>,
    /// Per road: stations and places, from end to end.
    chains: Vec<Vec<(f64, usize)>>,
}

/// The ground along all roads.
pub fn terrain_profiles(network: &RoadNetwork, options: &HeightOptions) -> Vec<TerrainProfile> {
    if options.terrain.is_none() && options.spots.is_empty() {
        let level =
            |road: &Road| [0.0, road.line.length()].map(|station| (station, options.ground)).into_iter().collect();
        return network.roads.par_iter().finely().map(level).collect();
    }
    let mut web = web(network, options);
    fill(&mut web, options.ground);
    let height = |place: usize| web.heights[place].unwrap_or(options.ground);
    let base = |chain: &Vec<(f64, usize)>| chain.iter().map(|(station, place)| (*station, height(*place))).collect();
    web.chains.iter().map(base).collect()
}

fn web(network: &RoadNetwork, options: &HeightOptions) -> Web {
    let on_ground =
        |arms: &[crate::builder::network::RoadEnd]| arms.iter().any(|arm| network.road(arm.road).level == 0.0);
    let places: Vec<Point> = network.intersections.iter().map(|at| at.position).collect();
    let terrain = options.terrain.as_ref();
    let below = terrain.map_or_else(|| vec![None; places.len()], |terrain| terrain(&places));
    let of_nodes = |nodes: &[i64]| nodes.iter().find_map(|node| options.spots.of_node.get(node).copied());
    let heights = network.intersections.iter().zip(below);
    let heights = heights.map(|(at, below)| of_nodes(&at.nodes).or(below.filter(|_| on_ground(&at.arms)))).collect();
    let mut web = Web { heights, near: vec![Vec::new(); places.len()], chains: Vec::new() };
    for road in &network.roads {
        let mut chain = vec![(0.0, road.from.position())];
        for (station, height) in known(road, options) {
            chain.push((station, web.heights.len()));
            web.heights.push(Some(height));
            web.near.push(Vec::new());
        }
        chain.push((road.line.length(), road.to.position()));
        for pair in chain.windows(2) {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            web.near[a].push((b, to - from));
            web.near[b].push((a, to - from));
        }
        web.chains.push(chain);
    }
    web
}

/// Stations of a road between its ends whose height is known.
fn known(road: &Road, options: &HeightOptions) -> Vec<(f64, f64)> {
    let length = road.line.length();
    let spots = road.ways.iter().filter_map(|way| options.spots.of_way.get(way)).flatten();
    let mut known: Vec<(f64, f64)> = spots
        .filter_map(|(place, height)| {
            let foot = road.line.project(*place);
            ((foot.point - place).norm() < ASIDE).then_some((foot.station, *height))
        })
        .collect();
    // What lies below a bridge or above a tunnel is not the road's ground.
    if let Some(terrain) = options.terrain.as_ref().filter(|_| road.level == 0.0 && known.is_empty()) {
        let pieces = (length / SAMPLED).ceil() as usize;
        let stations: Vec<f64> = (1..pieces).map(|i| length * i as f64 / pieces as f64).collect();
        let found = terrain(&road.line.at_each(stations.iter().copied()));
        known.extend(stations.into_iter().zip(found).filter_map(|(station, height)| Some((station, height?))));
    }
    known.retain(|(station, _)| (AT_END..=length - AT_END).contains(station));
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    known.dedup_by(|b, a| b.0 - a.0 < AT_END);
    known
}

/// Gives every place a height: at first that of the nearest known one along the roads, then evened out between them.
fn fill(web: &mut Web, ground: f64) {
    let fixed: Vec<bool> = web.heights.iter().map(Option::is_some).collect();
    let mut open: BinaryHeap<(Reverse<u64>, Reverse<usize>)> =
        (0..fixed.len()).filter(|i| fixed[*i]).map(|i| (Reverse(0), Reverse(i))).collect();
    let mut nearest: Vec<Option<u64>> = fixed.iter().map(|fixed| fixed.then_some(0)).collect();
    while let Some((Reverse(far), Reverse(at))) = open.pop() {
        if nearest[at] != Some(far) {
            continue;
        }
        for (next, length) in web.near[at].clone() {
            let farther = far + (length * PER_METRE).round() as u64;
            if nearest[next].is_none_or(|known| farther < known) {
                nearest[next] = Some(farther);
                web.heights[next] = web.heights[at];
                open.push((Reverse(farther), Reverse(next)));
            }
        }
    }
    let loose: Vec<usize> = (0..fixed.len()).filter(|i| !fixed[*i] && nearest[*i].is_some()).collect();
    for _ in 0..SWEEPS {
        for &at in &loose {
            let weights = web.near[at].iter().map(|(next, length)| (1.0 / length.max(AT_END), web.heights[*next]));
            let (weight, sum) =
                weights.fold((0.0, 0.0), |(w, s), (by, height)| (w + by, s + by * height.unwrap_or(ground)));
            if weight > 0.0 {
                web.heights[at] = Some(sum / weight);
            }
        }
    }
}
