//! Heights of the nodes of roads: given ones, and heights interpolated between them along the roads.

use std::hash::Hash;

use geo::{Distance, Haversine, Point};
use rustc_hash::FxHashMap;

use crate::projection::LonLat;

use super::interpolation::interpolate;

/// A node of a road, by its number among them, and its place.
type Placed = (usize, LonLat);

/// The heights of all nodes of roads, metres; empty if no height is known. Between known heights they change evenly along the
/// roads, at any distance. A node that no road connects to a known height gets the mean of the known heights. `place` of a
/// missing node is `None`. The same roads in the same order give the same heights.
pub fn road_heights<N: Copy + Eq + Hash>(
    roads: impl IntoIterator<Item: IntoIterator<Item = N>>,
    place: impl Fn(N) -> Option<LonLat>,
    known: impl Fn(N) -> Option<f64>,
) -> FxHashMap<N, f64> {
    let mut numbers: FxHashMap<N, usize> = FxHashMap::default();
    let mut heights: Vec<Option<f64>> = Vec::new();
    let mut number = |node: N| {
        *numbers.entry(node).or_insert_with(|| {
            heights.push(known(node));
            heights.len() - 1
        })
    };
    let placed = |node: N| Some((node, place(node)?));
    let roads: Vec<Vec<Placed>> = roads
        .into_iter()
        .map(|road| road.into_iter().filter_map(placed).map(|(node, place)| (number(node), place)).collect())
        .collect();
    let (sum, count) = heights.iter().flatten().fold((0.0, 0), |(sum, count), height| (sum + height, count + 1));
    if count == 0 {
        return FxHashMap::default();
    }
    let mean = sum / f64::from(count);
    let is_knot = knots(&roads, &heights);
    let pieces = || roads.iter().flat_map(|road| pieces(road, &is_knot));
    let mut near = vec![Vec::new(); heights.len()];
    for piece in pieces() {
        let [a, b] = ends(piece);
        let length = stations(piece).last().copied().unwrap_or_default();
        near[a].push((b, length));
        near[b].push((a, length));
    }
    interpolate(&mut heights, &near);
    for piece in pieces() {
        let [from, to] = ends(piece).map(|end| heights[end].unwrap_or(mean));
        let stations = stations(piece);
        let length = stations.last().copied().unwrap_or_default().max(f64::MIN_POSITIVE);
        for ((node, _), station) in piece.iter().zip(stations) {
            heights[*node].get_or_insert(from + (to - from) * (station / length));
        }
    }
    numbers.into_iter().map(|(node, number)| (node, heights[number].unwrap_or(mean))).collect()
}

/// Whether each node ends a piece of road along which heights change evenly: nodes of known height, ends of roads, and nodes
/// where roads meet.
fn knots(roads: &[Vec<Placed>], heights: &[Option<f64>]) -> Vec<bool> {
    let mut is_knot: Vec<bool> = heights.iter().map(Option::is_some).collect();
    let mut is_met = vec![false; heights.len()];
    for road in roads {
        for (node, _) in road {
            is_knot[*node] |= std::mem::replace(&mut is_met[*node], true);
        }
        for (node, _) in [road.first(), road.last()].into_iter().flatten() {
            is_knot[*node] = true;
        }
    }
    is_knot
}

/// The pieces of a road from one knot to the next, both among their nodes.
fn pieces<'a>(road: &'a [Placed], is_knot: &[bool]) -> Vec<&'a [Placed]> {
    let knots: Vec<usize> = (0..road.len()).filter(|at| is_knot[road[*at].0]).collect();
    knots.windows(2).map(|pair| &road[pair[0]..=pair[1]]).collect()
}

/// The first and the last node of a piece, which has both.
fn ends(piece: &[Placed]) -> [usize; 2] {
    [piece[0].0, piece[piece.len() - 1].0]
}

/// How far each node of a piece lies from its beginning, metres.
fn stations(piece: &[Placed]) -> Vec<f64> {
    let point = |place: &LonLat| Point::new(place.lon, place.lat);
    let steps = piece.windows(2).map(|pair| Haversine.distance(point(&pair[0].1), point(&pair[1].1)));
    let far = steps.scan(0.0, |far, step| {
        *far += step;
        Some(*far)
    });
    std::iter::once(0.0).chain(far).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places along the equator, a node each thousandth of a degree.
    fn place(node: i64) -> Option<LonLat> {
        (node < 100).then_some(LonLat { lon: node as f64 * 1e-3, lat: 0.0 })
    }

    #[test]
    fn heights_change_evenly_along_roads_whatever_nodes_they_have() {
        let roads = [vec![0, 1, 2, 100, 4], vec![4, 6, 8], vec![20, 21]];
        let known =
            |node: i64| [(0, 10.0), (8, 50.0)].into_iter().find(|(one, _)| *one == node).map(|(_, height)| height);
        let heights = road_heights(roads.clone(), place, known);
        for (node, height) in [(0, 10.0), (1, 15.0), (2, 20.0), (4, 30.0), (6, 40.0), (8, 50.0), (20, 30.0), (21, 30.0)]
        {
            assert!((heights[&node] - height).abs() < 1e-3, "{node}: {}", heights[&node]);
        }
        assert!(!heights.contains_key(&100), "it has no place");
        // Who knows all of them finds no other.
        let again = road_heights(roads, place, |node| heights.get(&node).copied());
        assert_eq!(again, heights);
        assert!(road_heights([[0, 1]], place, |_| None).is_empty());
    }
}
