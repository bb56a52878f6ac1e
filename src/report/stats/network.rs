//! How the vehicle lanes hang together: by following each other, and by lane changes where the paint allows them.

use std::fmt::Write;

use serde::Serialize;

use crate::lanelet::index::MapIndex;
use crate::lanelet::lane_change::{LaneChange, Participant};

/// More ids than this are counted, not listed, on a terminal.
const MOST_LISTED: usize = 20;

/// The road network as a graph of vehicle lanes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Network {
    /// Vehicle lanes.
    pub lanes: usize,
    /// Parts that hang together in any direction, by number of lanes, largest first.
    pub weakly_connected: Vec<usize>,
    /// Parts in which every lane can be reached from every other, by driving on or by changing lanes there and back, by
    /// number of lanes, largest first; lanes that are a part of their own are left out.
    pub strongly_connected: Vec<usize>,
    /// Lanelets that no lane leads into.
    pub starts: Vec<i64>,
    /// Lanelets that lead nowhere.
    pub dead_ends: Vec<i64>,
    /// Lanelets that do not hang together with the largest component: no route from there reaches them.
    pub unreachable: Vec<i64>,
}

impl Network {
    /// Of a map.
    pub fn of(index: &MapIndex<'_>) -> Self {
        let edges = edges(index);
        let vehicle: Vec<usize> = (0..index.lanes.len()).filter(|&lane| index.lanes[lane].vehicle).collect();
        let ids = |keep: &dyn Fn(usize) -> bool| -> Vec<i64> {
            vehicle.iter().filter(|&&lane| keep(lane)).map(|&lane| index.lanes[lane].id.0).collect()
        };
        let weak = weak(&edges);
        let mut sizes = vec![0_usize; edges.len()];
        for &lane in &vehicle {
            sizes[weak[lane]] += 1;
        }
        // The first of the largest, so that the answer does not depend on how a sort breaks ties.
        let main = (0..sizes.len()).rev().max_by_key(|&root| sizes[root]);
        let mut entered = vec![false; edges.len()];
        edges.iter().flatten().for_each(|&to| entered[to] = true);
        let strong = strong(&edges).into_iter().filter(|&size| size > 1);
        Self {
            lanes: vehicle.len(),
            weakly_connected: sorted(sizes.iter().copied().filter(|&size| size > 0)),
            strongly_connected: sorted(strong),
            starts: ids(&|lane| !entered[lane]),
            dead_ends: ids(&|lane| edges[lane].is_empty()),
            unreachable: ids(&|lane| Some(weak[lane]) != main),
        }
    }

    /// As a chapter of a page.
    pub fn text(&self) -> String {
        let mut out = String::from("Network of vehicle lanes\n");
        // Writing to a string cannot fail.
        let _ = writeln!(out, "  {:<28}{:>8}", "lanes", self.lanes);
        let _ = writeln!(
            out,
            "  {:<28}{:>8}   {}",
            "weakly connected parts",
            self.weakly_connected.len(),
            list(&self.weakly_connected)
        );
        let _ = writeln!(
            out,
            "  {:<28}{:>8}   {}",
            "strongly connected parts",
            self.strongly_connected.len(),
            list(&self.strongly_connected)
        );
        for (name, ids) in
            [("starts", &self.starts), ("dead ends", &self.dead_ends), ("unreachable", &self.unreachable)]
        {
            let _ = writeln!(out, "  {name:<28}{:>8}   {}", ids.len(), list(ids));
        }
        out
    }
}

fn list<T: ToString>(all: &[T]) -> String {
    let shown: Vec<String> = all.iter().take(MOST_LISTED).map(T::to_string).collect();
    let more = if all.len() > MOST_LISTED { " …" } else { "" };
    shown.join(" ") + more
}

fn sorted(sizes: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut sizes: Vec<usize> = sizes.collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

/// For every lane the lanes into which a vehicle may go next; empty for lanes that are not for vehicles.
fn edges(index: &MapIndex<'_>) -> Vec<Vec<usize>> {
    let vehicle = |lane: &usize| index.lanes[*lane].vehicle;
    let mut edges = vec![Vec::new(); index.lanes.len()];
    for (at, lane) in index.lanes.iter().enumerate().filter(|(_, lane)| lane.vehicle) {
        edges[at].extend(index.followers(at).iter().copied().filter(vehicle));
        for (own, theirs) in [(0, 1), (1, 0)] {
            let way = lane.bounds[own];
            let over = |bound| LaneChange::over(index.map, bound, Participant::Vehicle);
            let is_open = if own == 0 { over(lane.lanelet.left).to_left } else { over(lane.lanelet.right).to_right };
            if is_open {
                // Who has the line on the other side drives the same way.
                let beside = index.users_of(way).iter().copied();
                edges[at].extend(beside.filter(vehicle).filter(|&b| b != at && index.lanes[b].bounds[theirs] == way));
            }
        }
    }
    edges
}

/// For every lane the number of its component, whatever the direction of the edges.
fn weak(edges: &[Vec<usize>]) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..edges.len()).collect();
    fn root(parent: &mut [usize], mut at: usize) -> usize {
        while parent[at] != at {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        at
    }
    for (from, targets) in edges.iter().enumerate() {
        for &to in targets {
            let (a, b) = (root(&mut parent, from), root(&mut parent, to));
            parent[a.max(b)] = a.min(b);
        }
    }
    (0..edges.len()).map(|at| root(&mut parent, at)).collect()
}

/// Sizes of the strongly connected components, by Tarjan's method without recursion: cities are deep.
fn strong(edges: &[Vec<usize>]) -> Vec<usize> {
    const UNSEEN: usize = usize::MAX;
    let (mut order, mut low) = (vec![UNSEEN; edges.len()], vec![0; edges.len()]);
    let (mut open, mut on_stack) = (Vec::new(), vec![false; edges.len()]);
    let (mut sizes, mut seen) = (Vec::new(), 0);
    for start in 0..edges.len() {
        if order[start] != UNSEEN {
            continue;
        }
        let mut path = vec![(start, 0)];
        while let Some((at, next)) = path.pop() {
            if next == 0 {
                (order[at], low[at]) = (seen, seen);
                seen += 1;
                open.push(at);
                on_stack[at] = true;
            }
            if let Some(&to) = edges[at].get(next) {
                path.push((at, next + 1));
                if order[to] == UNSEEN {
                    path.push((to, 0));
                } else if on_stack[to] {
                    low[at] = low[at].min(order[to]);
                }
                continue;
            }
            if low[at] == order[at] {
                let mut size = 0;
                while let Some(top) = open.pop() {
                    on_stack[top] = false;
                    size += 1;
                    if top == at {
                        break;
                    }
                }
                sizes.push(size);
            }
            if let Some(&(above, _)) = path.last() {
                low[above] = low[above].min(low[at]);
            }
        }
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_a_loop_with_a_spur() {
        // 0 -> 1 -> 2 -> 0, 2 -> 3; 4 -> 5.
        let edges = vec![vec![1], vec![2], vec![0, 3], vec![], vec![5], vec![]];
        assert_eq!(weak(&edges), [0, 0, 0, 0, 4, 4]);
        assert_eq!(sorted(strong(&edges).into_iter()), [3, 1, 1, 1]);
    }

    #[test]
    fn a_long_road_is_no_deep_recursion() {
        let edges: Vec<Vec<usize>> = (0..200_000).map(|i| vec![(i + 1) % 200_000]).collect();
        assert_eq!(strong(&edges), [200_000]);
    }

    #[test]
    fn two_loops_that_share_a_lane_are_one() {
        let edges = vec![vec![1, 2], vec![0], vec![0]];
        assert_eq!(strong(&edges), [3]);
    }
}
