//! Values at the places of a graph, between those where they are known.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Rounds of averaging (Gauss-Seidel) between known values.
const SWEEPS: usize = 60;
/// Lengths are integers of a millimetre, which have an order.
const PER_METRE: f64 = 1e3;
/// Places closer to each other than this, metres, count as this far apart.
const LEAST_LENGTH: f64 = 1.0;

/// Gives a value to every place that is connected to a known one: first that of the nearest known place along the edges
/// (Dijkstra), then an average of its neighbours, weighted by nearness, so that values change evenly between known places. `near`
/// has the neighbours of each place with the lengths of the edges, metres. Places without a connection to a known one stay
/// unknown.
pub fn interpolate(values: &mut [Option<f64>], near: &[Vec<(usize, f64)>]) {
    let fixed: Vec<bool> = values.iter().map(Option::is_some).collect();
    let mut open: BinaryHeap<(Reverse<u64>, Reverse<usize>)> =
        (0..fixed.len()).filter(|i| fixed[*i]).map(|i| (Reverse(0), Reverse(i))).collect();
    let mut nearest: Vec<Option<u64>> = fixed.iter().map(|fixed| fixed.then_some(0)).collect();
    while let Some((Reverse(far), Reverse(place))) = open.pop() {
        if nearest[place] != Some(far) {
            continue;
        }
        for &(next, length) in &near[place] {
            let farther = far + (length * PER_METRE).round() as u64;
            if nearest[next].is_none_or(|known| farther < known) {
                nearest[next] = Some(farther);
                values[next] = values[place];
                open.push((Reverse(farther), Reverse(next)));
            }
        }
    }
    let unknown: Vec<usize> = (0..fixed.len()).filter(|i| !fixed[*i] && nearest[*i].is_some()).collect();
    for _ in 0..SWEEPS {
        for &place in &unknown {
            let (mut weight, mut sum) = (0.0, 0.0);
            for &(next, length) in &near[place] {
                if let Some(value) = values[next] {
                    let by = 1.0 / length.max(LEAST_LENGTH);
                    (weight, sum) = (weight + by, sum + by * value);
                }
            }
            if weight > 0.0 {
                values[place] = Some(sum / weight);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_change_evenly_between_known_ones_and_end_where_no_edge_leads() {
        // 0 - 1 - 2 - 3 in a row, 4 beside 1, 5 and 6 apart.
        let edges = [(0, 1, 100.0), (1, 2, 200.0), (2, 3, 100.0), (1, 4, 50.0), (5, 6, 10.0)];
        let mut near = vec![Vec::new(); 7];
        for (a, b, length) in edges {
            near[a].push((b, length));
            near[b].push((a, length));
        }
        let mut values = [Some(0.0), None, None, Some(40.0), None, None, None];
        interpolate(&mut values, &near);
        let value = |place: usize| values[place].unwrap();
        assert!((value(1) - 10.0).abs() < 1e-3 && (value(2) - 30.0).abs() < 1e-3, "{values:?}");
        assert!((value(4) - value(1)).abs() < 1e-3, "a dead end is level");
        assert_eq!(values[5..], [None, None]);
    }
}
