//! The outline of an intersection that was merged from several nodes.
//!
//! The general method needs one node that all roads share; here they meet in several. What the roads cover is known
//! all the same: the inner roads, and each arm up to its cut. The outline is the rim of that ground. Arms are cut
//! where they collide with the arms and inner roads of their own node, and further until the cut is clear of every
//! inner road; their order around the rim is the order of the contour, so no angle can twist it.

use geo::{BooleanOps, ConvexHull, Coord, MultiPoint, MultiPolygon, Polygon, unary_union};

use crate::builder::road_network::{End, Intersection, RoadEnd, RoadNetwork};
use crate::geometry::{Point, polygon};

use super::Cut;
use super::collide::collisions;
use super::thicken::{Arm, Side};
use super::walk::cut;

/// How far apart, metres, the cuts are that are tried until one is clear of the inner roads.
const STEP: f64 = 0.5;
/// The rim comes back from the union of the ground moved by less than this, metres.
const SNAP: f64 = 1e-3;
/// A cut this much (metres) beyond the last collision, so that it lies on the rim and not in a corner.
const CLEAR: f64 = 0.05;

/// Cuts and corners of a merged intersection, in the order of its arms.
pub struct Merged {
    /// Distance from each arm's end to its cut, metres.
    pub trims: Vec<f64>,
    /// The cuts.
    pub cuts: Vec<Cut>,
    /// `corners[i]` runs clockwise from cut `i` to the next, both ends included.
    pub corners: Vec<Vec<Point>>,
}

/// A line that ends at one of the merged nodes.
struct Spoke {
    node: i64,
    arm: Arm,
}

/// The outline of `intersection`; `None` if its ground falls apart or a cut does not lie on its rim.
pub fn merged(network: &RoadNetwork, intersection: &Intersection) -> Option<Merged> {
    let arms: Vec<Spoke> = intersection
        .arms
        .iter()
        .map(|at| Spoke { node: network.road(at.road).node(at.end), arm: Arm::new(network, *at) })
        .collect();
    let inner = inner_spokes(intersection, arms.first()?.arm.at);
    let paved: Vec<Polygon<f64>> = inner.iter().filter_map(|s| ribbon(&s.arm, 0.0, s.arm.length)).collect();
    let trims: Vec<f64> = arms.iter().map(|spoke| trim(spoke, &arms, &inner, &paved)).collect();
    let stubs = arms.iter().zip(&trims).filter_map(|(s, t)| ribbon(&s.arm, 0.0, *t));
    let ground: Vec<Polygon<f64>> =
        paved.iter().cloned().chain(stubs).chain(node_grounds(&arms, &inner, &trims)).collect();
    let rim = rim(&unary_union(&ground))?;
    let cuts: Vec<Cut> = arms.iter().zip(&trims).map(|(s, t)| cut(&s.arm, *t)).collect();
    let corners = corners(&rim, &cuts)?;
    Some(Merged { trims, cuts, corners })
}

/// Each inner road as seen from either of its ends.
fn inner_spokes(intersection: &Intersection, any: RoadEnd) -> Vec<Spoke> {
    intersection
        .inner
        .iter()
        .flat_map(|road| {
            let half = road.section.width() / 2.0;
            let there = Spoke { node: road.key.first, arm: Arm::from_line(any, road.line.clone(), half) };
            let back = Spoke { node: road.key.last, arm: Arm::from_line(any, road.line.reversed(), half) };
            [there, back]
        })
        .collect()
}

/// Where an arm is cut: beyond its farthest collision at its own node, and clear of every inner road.
fn trim(spoke: &Spoke, arms: &[Spoke], inner: &[Spoke], paved: &[Polygon<f64>]) -> f64 {
    let own = |other: &&Spoke| other.node == spoke.node && !std::ptr::eq(*other, spoke);
    let farthest = arms
        .iter()
        .chain(inner)
        .filter(own)
        .flat_map(|other| collisions(&spoke.arm, &other.arm))
        .map(|c| c.stations[0])
        .fold(0.0, f64::max);
    let mut station = farthest + CLEAR;
    while station < spoke.arm.length && covered(&spoke.arm, station, paved) {
        station += STEP;
    }
    station.min(spoke.arm.length)
}

/// Whether a cut at this station touches ground that inner roads cover.
fn covered(arm: &Arm, station: f64, paved: &[Polygon<f64>]) -> bool {
    use geo::Intersects;
    let [a, b] = [Side::Left, Side::Right].map(|side| arm.corner(station, side));
    let line = geo::Line::new(Coord { x: a.x, y: a.y }, Coord { x: b.x, y: b.y });
    paved.iter().any(|p| p.intersects(&line))
}

/// The ground of an arm between two stations.
fn ribbon(arm: &Arm, from: f64, to: f64) -> Option<Polygon<f64>> {
    let line = arm.line.cut(from, to)?;
    let limit = super::thicken::MITER_LIMIT;
    let left = line.offset(arm.half, limit)?;
    let right = line.offset(-arm.half, limit)?;
    let ring: Vec<Point> = left.points().iter().chain(right.points().iter().rev()).copied().collect();
    Some(polygon::to_geo(&ring))
}

/// The ground at each node: `placement` and uneven widths may set the roads' ends apart there.
fn node_grounds(arms: &[Spoke], inner: &[Spoke], trims: &[f64]) -> Vec<Polygon<f64>> {
    let mut ends: Vec<(i64, Coord<f64>)> = Vec::new();
    let mut add = |spoke: &Spoke, station: f64| {
        for side in [Side::Left, Side::Right] {
            let p = spoke.arm.corner(station, side);
            ends.push((spoke.node, Coord { x: p.x, y: p.y }));
        }
    };
    for (spoke, trim) in arms.iter().zip(trims) {
        add(spoke, 0.0_f64.min(*trim));
    }
    for spoke in inner {
        add(spoke, 0.0);
    }
    ends.sort_by_key(|(node, _)| *node);
    ends.chunk_by(|a, b| a.0 == b.0)
        .map(|group| MultiPoint::from_iter(group.iter().map(|(_, c)| geo::Point::from(*c))).convex_hull())
        .collect()
}

/// The outer ring of the ground, clockwise; `None` if it lies in pieces.
fn rim(ground: &MultiPolygon<f64>) -> Option<Vec<Point>> {
    let [whole] = ground.0.as_slice() else { return None };
    let mut ring: Vec<Point> = whole.exterior().coords().map(|c| Point::new(c.x, c.y)).collect();
    ring.pop();
    if polygon::signed_area(&ring) > 0.0 {
        ring.reverse();
    }
    Some(ring)
}

/// The pieces of the rim between the cuts; `None` if a cut does not lie on it, in the cuts' order.
fn corners(rim: &[Point], cuts: &[Cut]) -> Option<Vec<Vec<Point>>> {
    let n = rim.len();
    let nearest = |p: Point| (0..n).find(|i| (rim[*i] - p).norm() < SNAP);
    let mut places = Vec::with_capacity(cuts.len());
    for cut in cuts {
        let (right, left) = (nearest(cut.right)?, nearest(cut.left)?);
        // The cut itself is an edge of the rim: nothing of the ground lies beyond it.
        if (right + 1) % n != left {
            return None;
        }
        places.push((right, left));
    }
    let mut corners = Vec::with_capacity(cuts.len());
    let mut walked = 0;
    for (i, cut) in cuts.iter().enumerate() {
        let next = (i + 1) % cuts.len();
        let (from, to) = (places[i].1, places[next].0);
        let steps = (to + n - from) % n;
        walked += steps + 1;
        let mut chain = vec![cut.left];
        chain.extend((1..steps).map(|s| rim[(from + s) % n]));
        if steps > 0 {
            chain.push(cuts[next].right);
        }
        corners.push(chain);
    }
    // Once around, and no more: the cuts follow each other as the arms do.
    (walked == n).then_some(corners)
}
