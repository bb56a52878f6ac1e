//! The ground along every road, without ramps.

use rayon::prelude::*;

use crate::builder::network::{Road, RoadEnd, RoadNetwork};
use crate::geometry::spatial_hash::touch;
use crate::geometry::{Point, Vector};
use crate::parallel::InSmallParts;

use super::HeightOptions;
use super::interpolation::interpolate;

/// Distance between samples of a terrain model along a road, metres.
const SAMPLED: f64 = 20.0;
/// A known height this close to the end of a road, metres, is that of its node.
const AT_END: f64 = 1.0;
/// A known height farther from a road's line, metres, is not on it.
const ASIDE: f64 = 10.0;

/// Heights along a road, linear between stations, metres.
#[derive(Clone, Debug)]
pub struct TerrainProfile {
    stations: Vec<f64>,
    heights: Vec<f64>,
}

impl FromIterator<(f64, f64)> for TerrainProfile {
    /// From two or more ascending stations and their heights.
    fn from_iter<T: IntoIterator<Item = (f64, f64)>>(profile: T) -> Self {
        let (stations, heights) = profile.into_iter().unzip();
        Self { stations, heights }
    }
}

impl TerrainProfile {
    /// The heights of a road.
    pub fn under(road: &Road) -> Self {
        let heights = road.heights.iter().copied().chain(std::iter::repeat(0.0));
        road.line.stations().into_iter().zip(heights).collect()
    }

    /// Its stations, metres.
    pub fn stations(&self) -> &[f64] {
        &self.stations
    }

    /// The height at a station, metres.
    pub fn at(&self, station: f64) -> f64 {
        let i = self.stations.partition_point(|s| *s < station).clamp(1, self.stations.len() - 1);
        let [from, to] = [self.stations[i - 1], self.stations[i]];
        let part = if to > from { ((station - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        self.heights[i - 1] + (self.heights[i] - self.heights[i - 1]) * part
    }
}

/// Places with known or unknown heights: the intersections first, then those along the roads.
struct GroundGraph {
    heights: Vec<Option<f64>>,
    /// The neighbours of each place, with the distances, metres.
    near: Vec<Vec<(usize, f64)>>,
    /// Stations and places of each road from end to end.
    chains: Vec<Vec<(f64, usize)>>,
}

/// The ground along all roads.
pub fn terrain_profiles(network: &RoadNetwork, options: &HeightOptions) -> Vec<TerrainProfile> {
    if options.terrain.is_none() && options.spots.is_empty() {
        let level =
            |road: &Road| [0.0, road.line.length()].map(|station| (station, options.ground)).into_iter().collect();
        return network.roads.par_iter().in_small_parts().map(level).collect();
    }
    let mut graph = ground_graph(network, options);
    interpolate(&mut graph.heights, &graph.near);
    let height = |place: usize| graph.heights[place].unwrap_or(options.ground);
    graph.chains.iter().map(|chain| chain.iter().map(|(station, place)| (*station, height(*place))).collect()).collect()
}

fn ground_graph(network: &RoadNetwork, options: &HeightOptions) -> GroundGraph {
    let on_ground = |arms: &[RoadEnd]| arms.iter().any(|arm| network.road(arm.road).level == 0.0);
    let places: Vec<Point> = network.intersections.iter().map(|i| i.position).collect();
    let terrain = options.terrain.as_ref();
    let below = terrain.map_or_else(|| vec![None; places.len()], |terrain| terrain(&places));
    let of_nodes = |nodes: &[i64]| nodes.iter().find_map(|node| options.spots.of_node.get(node).copied());
    let heights = network.intersections.iter().zip(below);
    let heights = heights.map(|(i, below)| of_nodes(&i.nodes).or(below.filter(|_| on_ground(&i.arms)))).collect();
    let mut graph = GroundGraph { heights, near: vec![Vec::new(); places.len()], chains: Vec::new() };
    for road in &network.roads {
        let mut chain = vec![(0.0, road.from.position())];
        for (station, height) in known(road, options) {
            chain.push((station, graph.heights.len()));
            graph.heights.push(Some(height));
            graph.near.push(Vec::new());
        }
        chain.push((road.line.length(), road.to.position()));
        for pair in chain.windows(2) {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            graph.near[a].push((b, to - from));
            graph.near[b].push((a, to - from));
        }
        graph.chains.push(chain);
    }
    graph
}

/// Stations of a road between its ends with known heights, metres.
fn known(road: &Road, options: &HeightOptions) -> Vec<(f64, f64)> {
    let (length, vertices) = (road.line.length(), road.line.stations());
    let [low, high] = road.line.bounds();
    let around = [low - Vector::repeat(ASIDE), high + Vector::repeat(ASIDE)];
    let spots = road.ways.iter().filter_map(|way| options.spots.of_way.get(way)).flatten();
    // Those of a way come in its order: each lies near the one before it.
    let mut hint = 0;
    let mut known: Vec<(f64, f64)> = spots
        .filter(|(place, _)| touch(&[*place; 2], &around))
        .filter_map(|(place, height)| {
            let (station, distance) = road.line.station_and_distance(*place, &vertices, &mut hint);
            (distance < ASIDE).then_some((station, *height))
        })
        .collect();
    // The terrain below a bridge or above a tunnel is not the ground of the road.
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
