//! Carriageways that leave an intersection side by side: they begin level with each other and share the node between.
//!
//! Where a road parts into carriageways, those lie on the ground with next to nothing between them, and so do the ways
//! that lead into them. Were one cut farther out than the other, or each given a corner of its own, no bound could be
//! shared on either side of the cut.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::builder::ids::Key;
use crate::builder::network::road_end::{from_cut, lanes_at, on_cut};
use crate::builder::network::{End, Intersection, RoadEnd, RoadNetwork, Stations};
use crate::builder::streets::heights::Ground;
use crate::geometry::{Point, Vector, left_of};
use crate::parallel::Finely;

use super::road_cut::{ConnectionLines, RoadCut};

/// Corners no farther apart than this, metres, are one: so narrow no island and no kerb is.
const GAP: f64 = 0.3;
/// Cosine of the angle between two roads up to which they leave side by side: 45 degrees.
const ABREAST: f64 = 0.707;
/// Cosine of the angle up to which one is cut level with the other: 15 degrees, as for lanes that go straight on.
const PARALLEL: f64 = 0.966;
/// Cuts closer to level than this, metres, are.
const TOUCH: f64 = 0.05;
/// Roads that differ in height by more than this, metres, have no corner in common. Within [`GAP`] there is room for no
/// wall; what is less comes of ramps of unlike length, whose slopes are not known so well.
const STEP: f64 = 0.5;
/// No road is cut back further than this, metres, to be level with the one beside it.
const LEVEL_MOST: f64 = 12.0;

/// An edge of a road's cross-section at one end of the road.
pub type EdgeAt = (RoadEnd, usize);

/// The corner that two neighbouring roads share.
#[derive(Clone, Copy, Debug)]
pub struct GoreCorner {
    /// The edges that end there.
    pub edges: [EdgeAt; 2],
    /// Key of the node.
    pub key: Key,
    /// Its place: midway.
    pub place: Point,
}

/// Neighbours around an intersection clockwise that leave it at an angle with a cosine above this, each with the edge
/// that faces the other. `inward` gives for either end of a road its direction into the intersection there.
fn neighbours<'a>(
    network: &'a RoadNetwork,
    intersection: &'a Intersection,
    inward: impl Fn(RoadEnd) -> Vector + Copy + 'a,
    together: f64,
) -> impl Iterator<Item = [EdgeAt; 2]> + 'a {
    let facing = move |at: RoadEnd, right: bool| {
        let (left_edge, right_edge) = network.road(at.road).section.carriageway();
        // Seen from the intersection, a line that ends there has its left on the right.
        let edge = if right == (at.end == End::Start) { right_edge } else { left_edge };
        (at, edge)
    };
    let arms = &intersection.arms;
    let next = arms.iter().cycle().skip(1);
    let pairs = arms.iter().zip(next).filter(|(a, b)| a.road != b.road);
    let pairs = pairs.filter(move |(a, b)| inward(**a).dot(&inward(**b)) > together);
    pairs.map(move |(a, b)| [facing(*a, true), facing(*b, false)])
}

/// Where an edge of a road meets the cut.
fn corner(network: &RoadNetwork, kept: Stations, (at, edge): EdgeAt) -> Point {
    let road = network.road(at.road);
    on_cut(road, at.end, kept[at.end], road.section.edge(edge))
}

/// How far behind its own cut, metres, a road should be cut to be level with the corner of its neighbour; `None` if it
/// does not lie beside that corner.
fn behind(network: &RoadNetwork, cuts: &[RoadCut], (at, edge): EdgeAt, neighbour: EdgeAt) -> Option<f64> {
    let kept = |at: RoadEnd| cuts[at.road].kept;
    let (road, place) = (network.road(at.road), corner(network, kept(neighbour.0), neighbour));
    let foot = road.line.project(place);
    let beside = foot.point + left_of(road.line.direction(foot.station)) * road.section.edge(edge);
    let behind = from_cut(kept(at), at.end, foot.station);
    ((beside - place).norm() <= GAP && behind.abs() > TOUCH && behind.abs() <= LEVEL_MOST).then_some(behind)
}

/// Changes the setbacks, metres behind `least`, so that of two roads side by side neither is cut farther out than the
/// other: the one is cut back, or, if `give` are the setbacks that must stay, the other less far. `cuts` tell where the
/// roads' lanes run so far. Gives the roads whose setbacks have changed.
pub fn level_cuts(
    network: &RoadNetwork,
    least: &[Stations],
    cuts: &[RoadCut],
    setbacks: &mut [[f64; 2]],
    give: Option<&[[f64; 2]]>,
) -> BTreeSet<usize> {
    let inward = |at: RoadEnd| cuts[at.road].inward[at.end];
    let depth = |(one, other): (EdgeAt, EdgeAt)| {
        let behind = behind(network, cuts, one, other)?;
        let (road, side) = (one.0.road.position(), one.0.end.index());
        Some((road, side, from_cut(least[road], one.0.end, cuts[road].kept[side]) + behind))
    };
    let beside = |at| neighbours(network, at, inward, PARALLEL).flat_map(|[a, b]| [(a, b), (b, a)]);
    let depths = network.intersections.par_iter().finely().flat_map_iter(|at| beside(at).filter_map(depth));
    let depths: Vec<(usize, usize, f64)> = depths.collect();
    let mut changed = BTreeSet::new();
    for (road, side, depth) in depths {
        let back = &mut setbacks[road][side];
        let wanted = match give {
            None => back.max(depth),
            Some(stay) => back.min(depth.max(stay[road][side])),
        };
        if wanted != *back {
            *back = wanted;
            changed.insert(road);
        }
    }
    changed
}

/// Whether lanes on both sides of a seam lead into an intersection where they do not simply go on side by side: they
/// are approaches of their own, whose movements may cross.
fn approaches_apart(network: &RoadNetwork, edges: [EdgeAt; 2]) -> bool {
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
    let mut exits = arms.iter().filter(|at| count(at, false) > 0);
    let (Some(exit), None) = (exits.next(), exits.next()) else { return true };
    arms.iter().filter(|at| *at != exit).map(|at| count(at, true)).sum::<usize>() > count(exit, false)
}

/// Whether two roads are as high as each other at a place.
fn on_one_level(network: &RoadNetwork, edges: [EdgeAt; 2], place: Point) -> bool {
    let [a, b] = edges.map(|(at, _)| Ground::under(network.road(at.road)).at(place));
    (a - b).abs() <= STEP
}

/// The corners that neighbouring roads share.
pub fn gore_corners(network: &RoadNetwork, lines: &ConnectionLines) -> Vec<GoreCorner> {
    let inward = |at: RoadEnd| lines.inward[at.road][at.end];
    let abreast = |at| neighbours(network, at, inward, ABREAST).filter(|pair| !approaches_apart(network, *pair));
    let seam = |edges: [EdgeAt; 2]| {
        let [a, b] = edges.map(|edge| corner(network, lines.kept[edge.0.road], edge));
        let (at, edge) = edges[0];
        let key = network.road(at.road).key_of("seam").number(at.end.index() as i64).number(edge as i64);
        let place = nalgebra::center(&a, &b);
        ((a - b).norm() <= GAP && on_one_level(network, edges, place)).then_some(GoreCorner { edges, key, place })
    };
    network.intersections.par_iter().finely().flat_map_iter(|at| abreast(at).filter_map(seam)).collect()
}

#[cfg(test)]
mod tests {
    use crate::builder::{BuildOptions, Built, build};
    use crate::osm::{OsmData, read_bytes};

    /// A road that parts into two carriageways, 100 m farther each this far, metres, from its line.
    fn parted(apart: f64) -> Built {
        let nodes = [(1, 0.0, 0.0), (2, 100.0, 0.0), (3, 200.0, -apart), (4, 200.0, apart)];
        let ways = [(10, "1 2", "no", "2"), (11, "2 3", "yes", "1"), (12, "4 2", "yes", "1")];
        let mut text = String::from("<osm version='0.6'>");
        for (id, x, y) in nodes {
            let (lat, lon) = (49.0 + y / 111_200.0, 8.5 + x / 73_000.0);
            text += &format!("<node id='{id}' lat='{lat:.9}' lon='{lon:.9}'/>");
        }
        for (id, refs, oneway, lanes) in ways {
            text += &format!("<way id='{id}'>");
            refs.split(' ').for_each(|node| text += &format!("<nd ref='{node}'/>"));
            for (k, v) in [("highway", "secondary"), ("oneway", oneway), ("lanes", lanes), ("sidewalk", "no")] {
                text += &format!("<tag k='{k}' v='{v}'/>");
            }
            text += "</way>";
        }
        text += "</osm>";
        let mut osm = OsmData::default();
        read_bytes(&mut osm, "test", text.into_bytes()).unwrap();
        build(&osm, &BuildOptions::default()).unwrap()
    }

    /// How many lanelets have a bound in common with one that runs against them, outside the road that parts.
    fn opposed(built: &Built) -> usize {
        let map = &built.map;
        let inside = |l: &&crate::lanelet::Lanelet| {
            let line = map.linestrings.get(l.left.line);
            line.is_some_and(|line| line.attributes.is("type", "virtual"))
        };
        let ways: Vec<_> = map.lanelets.iter().filter(inside).map(|l| l.left.line).collect();
        ways.iter().filter(|way| ways.iter().filter(|other| other == way).count() == 2).count()
    }

    #[test]
    fn ways_into_carriageways_side_by_side_share_their_bound() {
        for apart in [3.0, 6.0, 9.0] {
            assert_eq!(opposed(&parted(apart)), 2, "{apart}");
        }
    }

    #[test]
    fn carriageways_side_by_side_are_cut_level() {
        let map = parted(5.0).map;
        let kerbs = map.linestrings.iter().filter(|line| line.attributes.is("type", "road_border"));
        let mut ends: Vec<_> = kerbs.flat_map(|line| [line.points[0], line.points[line.points.len() - 1]]).collect();
        ends.sort_unstable();
        // Each kerb ends by itself but for the one corner where the two carriageways part.
        assert_eq!(ends.windows(2).filter(|pair| pair[0] == pair[1]).count(), 1);
    }
}
