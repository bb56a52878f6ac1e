//! Gores: carriageways that leave an intersection side by side are cut level and share the node between them.
//!
//! Where a road parts into carriageways, these lie on the ground with almost no gap, and so do the lanelets that lead into
//! them. If one were cut farther out than the other, or each had a corner of its own, they could share no bound.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::builder::ids::Key;
use crate::builder::network::road_end::{from_cut, lanes_at, leads_in, leads_out, on_cut};
use crate::builder::network::{End, Intersection, RoadEnd, RoadNetwork, Stations};
use crate::builder::streets::heights::Ground;
use crate::geometry::{Point, Vector, left_of};
use crate::parallel::InSmallParts;

use super::road_cut::{ConnectionLines, RoadCut};

/// Corners up to this distance, metres, are one: no island and no kerb is so narrow.
const GAP: f64 = 0.3;
/// Cosine of the largest angle between two roads that leave side by side: 45 degrees.
const ABREAST: f64 = 0.707;
/// Cosine of the largest angle between two roads that are cut level: 15 degrees, as for lanes that go straight on.
const PARALLEL: f64 = 0.966;
/// Cuts that differ by less than this, metres, are level.
const LEVEL: f64 = 0.05;
/// Roads that differ in height by more than this, metres, share no corner. There is no room for a wall within [`GAP`];
/// smaller steps come from ramps of different lengths, whose grades are not well known.
const HEIGHT_STEP: f64 = 0.5;
/// The largest change of a setback, metres, by which a road is cut level with its neighbour ...
const LEVEL_MOST: f64 = 12.0;
/// ... and with one across a median, as the other carriageway of one street: its stop line goes on to where this road is cut ...
const LEVEL_ACROSS: f64 = 1.0;
/// ... of at most this width, metres.
const MEDIAN: f64 = 20.0;

/// An edge of a road's cross-section at one end of the road.
pub type EdgeAt = (RoadEnd, usize);

/// The corner that two neighbouring roads share: the nose of the gore between them.
#[derive(Clone, Copy, Debug)]
pub struct GoreCorner {
    /// The edges that end there.
    pub edges: [EdgeAt; 2],
    /// Key of the node.
    pub key: Key,
    /// Its place: midway.
    pub place: Point,
}

/// The edge of a road that faces its neighbour on the right or on the left, as seen from the intersection.
fn facing_edge(network: &RoadNetwork, at: RoadEnd, right: bool) -> EdgeAt {
    let (left_edge, right_edge) = network.road(at.road).section.carriageway();
    // Seen from the intersection, a line that ends there has its left on the right.
    (at, if right == (at.end == End::Start) { right_edge } else { left_edge })
}

/// Neighbours around an intersection, clockwise, whose directions have a cosine above this, each with the edge that faces
/// the other. `inward` gives the direction of a road end into the intersection.
fn neighbours<'a>(
    network: &'a RoadNetwork,
    intersection: &'a Intersection,
    inward: impl Fn(RoadEnd) -> Vector + 'a,
    cosine: f64,
) -> impl Iterator<Item = [EdgeAt; 2]> + 'a {
    let arms = &intersection.arms;
    let pairs = arms.iter().zip(arms.iter().cycle().skip(1)).filter(|(a, b)| a.road != b.road);
    let pairs = pairs.filter(move |(a, b)| inward(**a).dot(&inward(**b)) > cosine);
    pairs.map(|(a, b)| [facing_edge(network, *a, true), facing_edge(network, *b, false)])
}

/// Where an edge of a road meets the cut.
fn corner(network: &RoadNetwork, kept: Stations, (at, edge): EdgeAt) -> Point {
    let road = network.road(at.road);
    on_cut(road, at.end, kept[at.end], road.section.edge(edge))
}

/// How far behind its own cut, metres, the corner of its neighbour lies beside a road; `None` if it does not lie beside it, if
/// both are level, or too far from it.
fn depth_of_neighbour(network: &RoadNetwork, cuts: &[RoadCut], (at, edge): EdgeAt, neighbour: EdgeAt) -> Option<f64> {
    let road = network.road(at.road);
    let place = corner(network, cuts[neighbour.0.road].kept, neighbour);
    let foot = road.line.project(place);
    let beside = foot.point + left_of(road.line.direction(foot.station)) * road.section.edge(edge);
    let (depth, most) = match (beside - place).norm() {
        gap if gap <= GAP => (from_cut(cuts[at.road].kept, at.end, foot.station), LEVEL_MOST),
        gap if gap <= MEDIAN => {
            let depth = depth_across_median(network, cuts, [at, neighbour.0]);
            (depth.unwrap_or_else(|| from_cut(cuts[at.road].kept, at.end, foot.station)), LEVEL_ACROSS)
        }
        _ => return None,
    };
    (depth.abs() > LEVEL && depth.abs() <= most).then_some(depth)
}

/// The same for the two carriageways of a street, of which one leads in and the other out: how far behind the cut of the first of these
/// roads the other one is cut. They are level if the stop line of the approach goes on to the middle of the cut across the exit: where
/// they lie at an angle, neither side of the exit is far from it.
fn depth_across_median(network: &RoadNetwork, cuts: &[RoadCut], roads: [RoadEnd; 2]) -> Option<f64> {
    let leads_in_only = roads.map(|at| leads_in(network, at) && !leads_out(network, at));
    let leads_out_only = roads.map(|at| leads_out(network, at) && !leads_in(network, at));
    let (sign, approach, exit) = match (leads_in_only, leads_out_only) {
        ([true, false], [false, true]) => (-1.0, roads[0], roads[1]),
        ([false, true], [true, false]) => (1.0, roads[1], roads[0]),
        _ => return None,
    };
    let cut = |at: RoadEnd| {
        let section = &network.road(at.road).section;
        let (left, right) = section.carriageway();
        let middle = f64::midpoint(section.edge(left), section.edge(right));
        let cut = &cuts[at.road];
        (on_cut(network.road(at.road), at.end, cut.kept[at.end], middle), cut.inward[at.end])
    };
    let ((stop, inward), (middle, along)) = (cut(approach), cut(exit));
    // How far up the exit the stop line crosses its middle.
    Some(sign * (middle - stop).dot(&inward) / along.dot(&inward))
}

/// Changes the setbacks, metres behind `least`, so that of two roads side by side neither is cut farther out than the other.
/// The one is set back; or, if `lower_to` gives the least setbacks, the other is set back less. `cuts` say where the roads'
/// lanes end so far. Gives the positions of the roads whose setbacks have changed.
pub fn level_cuts(
    network: &RoadNetwork,
    least: &[Stations],
    cuts: &[RoadCut],
    setbacks: &mut [[f64; 2]],
    lower_to: Option<&[[f64; 2]]>,
) -> BTreeSet<usize> {
    let inward = |at: RoadEnd| cuts[at.road].inward[at.end];
    let level_setback = |(one, other): (EdgeAt, EdgeAt)| {
        let at = one.0;
        let own = from_cut(least[at.road], at.end, cuts[at.road].kept[at.end]);
        Some((at, own + depth_of_neighbour(network, cuts, one, other)?))
    };
    let level_setbacks = network.intersections.par_iter().in_small_parts().flat_map_iter(|intersection| {
        let both = neighbours(network, intersection, inward, PARALLEL).flat_map(|[a, b]| [(a, b), (b, a)]);
        both.filter_map(level_setback)
    });
    let level_setbacks: Vec<(RoadEnd, f64)> = level_setbacks.collect();
    let mut changed = BTreeSet::new();
    for (at, level) in level_setbacks {
        let setback = &mut setbacks[at.road][at.end];
        let new = lower_to.map_or(setback.max(level), |to| setback.min(level.max(to[at.road][at.end])));
        if new != *setback {
            *setback = new;
            changed.insert(at.road.position());
        }
    }
    changed
}

/// Whether lanes on both sides of a gore lead into an intersection where they do not simply go on side by side: they are
/// approaches of their own, whose movements may cross.
fn are_separate_approaches(network: &RoadNetwork, edges: [EdgeAt; 2]) -> bool {
    let leads_in = |(at, edge): EdgeAt| {
        let lanes = lanes_at(&network.road(at.road).section, at.end);
        lanes.iter().any(|lane| lane.into && (lane.strip == edge || lane.strip + 1 == edge))
    };
    if !edges.into_iter().all(leads_in) {
        return false;
    }
    let (at, _) = edges[0];
    let arms = &network.intersection(network.road(at.road).intersection(at.end)).arms;
    let count = |at: &RoadEnd, into: bool| {
        lanes_at(&network.road(at.road).section, at.end).iter().filter(|lane| lane.into == into).count()
    };
    let mut exits = arms.iter().filter(|at| leads_out(network, **at));
    let (Some(exit), None) = (exits.next(), exits.next()) else { return true };
    arms.iter().filter(|at| *at != exit).map(|at| count(at, true)).sum::<usize>() > count(exit, false)
}

/// The corner between two neighbours, if their edges meet on one level.
fn gore_corner(network: &RoadNetwork, lines: &ConnectionLines, edges: [EdgeAt; 2]) -> Option<GoreCorner> {
    let [a, b] = edges.map(|edge| corner(network, lines.kept[edge.0.road], edge));
    let place = nalgebra::center(&a, &b);
    let level = || {
        let [a, b] = edges.map(|(at, _)| Ground::under(network.road(at.road)).at(place));
        (a - b).abs() <= HEIGHT_STEP
    };
    let (at, edge) = edges[0];
    let key = network.road(at.road).key_of("seam").number(at.end.index() as i64).number(edge as i64);
    ((a - b).norm() <= GAP && level()).then_some(GoreCorner { edges, key, place })
}

/// The corners that neighbouring roads share.
pub fn gore_corners(network: &RoadNetwork, lines: &ConnectionLines) -> Vec<GoreCorner> {
    let inward = |at: RoadEnd| lines.inward[at.road][at.end];
    let corners = network.intersections.par_iter().in_small_parts().flat_map_iter(|intersection| {
        let pairs = neighbours(network, intersection, inward, ABREAST);
        let pairs = pairs.filter(|pair| !are_separate_approaches(network, *pair));
        pairs.filter_map(|pair| gore_corner(network, lines, pair))
    });
    corners.collect()
}

#[cfg(test)]
mod tests {
    use crate::builder::tests::{Asked, built_as};
    use crate::builder::{BuildOptions, Built};
    use crate::lanelet::{Lanelet, LineString};

    /// A road that parts into two carriageways, each this far, metres, from its line after another 100 m.
    fn fork(apart: f64) -> Built {
        let nodes = [(1, 0.0, 0.0, ""), (2, 100.0, 0.0, ""), (3, 200.0, -apart, ""), (4, 200.0, apart, "")];
        let one_way = "highway=secondary oneway=yes lanes=1 sidewalk=no";
        let ways: [(i64, &[i64], &str); 3] = [
            (10, &[1, 2], "highway=secondary oneway=no lanes=2 sidewalk=no"),
            (11, &[2, 3], one_way),
            (12, &[4, 2], one_way),
        ];
        built_as(&Asked { nodes: &nodes, ways: &ways, options: BuildOptions::default() })
    }

    /// How many lanelets of the intersection share a bound with one of the opposite direction.
    fn opposed(built: &Built) -> usize {
        let map = &built.map;
        let is_virtual = |lanelet: &&Lanelet| {
            map.linestrings.get(lanelet.left.line).is_some_and(|line| line.attributes.is("type", "virtual"))
        };
        let lines: Vec<_> = map.lanelets.iter().filter(is_virtual).map(|lanelet| lanelet.left.line).collect();
        lines.iter().filter(|line| lines.iter().filter(|other| other == line).count() == 2).count()
    }

    #[test]
    fn lanelets_into_carriageways_side_by_side_share_their_bound() {
        for apart in [3.0, 6.0, 9.0] {
            assert_eq!(opposed(&fork(apart)), 2, "{apart}");
        }
    }

    #[test]
    fn carriageways_side_by_side_are_cut_level() {
        let map = fork(5.0).map;
        let bounds: Vec<_> = map.lanelets.iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]).collect();
        let is_kerb = |line: &&LineString| line.attributes.is("type", "road_border") && bounds.contains(&line.id);
        let kerbs = map.linestrings.iter().filter(is_kerb);
        let mut ends: Vec<_> = kerbs.flat_map(|line| [line.points[0], line.points[line.points.len() - 1]]).collect();
        ends.sort_unstable();
        // All kerbs end at points of their own but for the gore nose, which two share.
        assert_eq!(ends.windows(2).filter(|pair| pair[0] == pair[1]).count(), 1);
    }
}
