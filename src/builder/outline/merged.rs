//! The outline of an intersection that was merged from several nodes.
//!
//! The general method needs one node that all roads share; here they meet in several. What the roads cover is known
//! all the same: the inner roads, and each arm up to its cut. The outline is the rim of that ground. Arms are cut
//! where they collide with the arms and inner roads of their own node, and further until the cut is clear of every
//! inner road; their order around the rim is the order of the contour, so no angle can twist it.

use geo::{ConvexHull, Coord, MultiPoint, MultiPolygon, Polygon, unary_union};

use crate::builder::road_network::{Intersection, RoadEnd, RoadNetwork};
use crate::geometry::{Point, Polyline, polygon};

use super::collide::collisions;
use super::thicken::{Arm, Side};
use super::{Cut, OutlineOptions};

/// How far apart, metres, the cuts are that are tried until one is clear of the inner roads.
const STEP: f64 = 0.5;
/// The rim comes back from the union of the ground moved by less than this, metres.
const SNAP: f64 = 1e-3;
/// Arms push each other's cuts outwards at most so many times.
const ROUNDS: usize = 10;

/// What the roads of a merged intersection cover.
pub struct Ground {
    arms: Vec<Spoke>,
    inner: Vec<Spoke>,
    paved: Vec<Polygon<f64>>,
}

/// A line that ends at one of the merged nodes.
struct Spoke {
    node: i64,
    arm: Arm,
}

impl Ground {
    /// The ground of `intersection`; `None` if nothing was merged into it.
    pub fn new(network: &RoadNetwork, intersection: &Intersection) -> Option<Self> {
        let arms: Vec<Spoke> = intersection
            .arms
            .iter()
            .map(|at| Spoke { node: network.road(at.road).node(at.end), arm: Arm::new(network, *at) })
            .collect();
        let inner = inner_spokes(intersection, arms.first()?.arm.at);
        let mut paved: Vec<Polygon<f64>> = inner.iter().filter_map(|s| ribbon(&s.arm, 0.0, s.arm.length)).collect();
        paved.extend(node_grounds(&arms, &inner));
        (!inner.is_empty()).then_some(Self { arms, inner, paved })
    }

    /// Distance from each arm's end to its cut, metres: beyond its farthest collision at its own node, clear of every
    /// inner road, and clear of the other arms up to their cuts.
    pub fn trims(&self, options: &OutlineOptions) -> Vec<f64> {
        let mut trims: Vec<f64> = self
            .arms
            .iter()
            .map(|spoke| {
                let own = |other: &&Spoke| other.node == spoke.node && !std::ptr::eq(*other, spoke);
                let others = self.arms.iter().chain(&self.inner).filter(own);
                let collisions = others.flat_map(|other| collisions(&spoke.arm, &other.arm));
                let farthest = collisions.map(|c| c.stations[0]).fold(0.0, f64::max);
                let first = (farthest + options.margin).max(options.least_trim);
                clear(&spoke.arm, first, &self.paved)
            })
            .collect();
        for _ in 0..ROUNDS {
            let before = trims.clone();
            for i in 0..trims.len() {
                let stubs: Vec<Polygon<f64>> = (0..trims.len())
                    .filter(|j| *j != i)
                    .filter_map(|j| ribbon(&self.arms[j].arm, 0.0, trims[j]))
                    .collect();
                trims[i] = clear(&self.arms[i].arm, trims[i], &stubs);
            }
            if trims == before {
                break;
            }
        }
        trims
    }

    /// The rim of the ground between these cuts: `corners[i]` runs clockwise from cut `i` to the next, both ends
    /// included. `None` if the ground lies in pieces, or a cut does not lie on its rim.
    pub fn corners(&self, trims: &[f64], cuts: &[Cut]) -> Option<Vec<Vec<Point>>> {
        let stubs = self.arms.iter().zip(trims).filter_map(|(s, t)| ribbon(&s.arm, 0.0, *t));
        let ground: Vec<Polygon<f64>> = self.paved.iter().cloned().chain(stubs).collect();
        corners(&rim(&unary_union(&ground))?, cuts)
    }
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

/// The first station from `station` on whose cut is clear of all `ground`, held to the arm's length.
fn clear(arm: &Arm, mut station: f64, ground: &[Polygon<f64>]) -> f64 {
    while station < arm.length && covered(arm, station, ground) {
        station += STEP;
    }
    station.min(arm.length)
}

/// Whether a cut at this station touches any of the ground.
fn covered(arm: &Arm, station: f64, ground: &[Polygon<f64>]) -> bool {
    use geo::Intersects;
    let [a, b] = [Side::Left, Side::Right].map(|side| arm.corner(station, side));
    let line = geo::Line::new(Coord { x: a.x, y: a.y }, Coord { x: b.x, y: b.y });
    ground.iter().any(|p| p.intersects(&line))
}

/// The ground of an arm between two stations.
fn ribbon(arm: &Arm, from: f64, to: f64) -> Option<Polygon<f64>> {
    let line = arm.line.cut(from, to)?;
    let limit = super::thicken::MITER_LIMIT;
    let left = line.offset(arm.half, limit)?;
    let right = line.offset(-arm.half, limit)?;
    // Counter-clockwise, as the union wants it.
    let ring: Vec<Point> = right.points().iter().chain(left.points().iter().rev()).copied().collect();
    Some(polygon::to_geo(&ring))
}

/// The ground at each node: `placement` and uneven widths may set the roads' ends apart there.
fn node_grounds(arms: &[Spoke], inner: &[Spoke]) -> Vec<Polygon<f64>> {
    let mut ends: Vec<(i64, Coord<f64>)> = Vec::new();
    for spoke in arms.iter().chain(inner) {
        for side in [Side::Left, Side::Right] {
            let p = spoke.arm.corner(0.0, side);
            ends.push((spoke.node, Coord { x: p.x, y: p.y }));
        }
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
        let line = Polyline::new([cut.right, cut.left])?;
        let steps = (left + n - right) % n;
        // Nothing of the ground lies beyond the cut: what stands between its ends on the rim stands on it.
        if (1..steps).any(|s| line.distance(rim[(right + s) % n]) > SNAP) {
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
        walked += steps + (places[i].1 + n - places[i].0) % n;
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
