//! Roads and intersections that still cover each other when all is laid out: nothing of their tags can lie where they
//! are drawn.
//!
//! Roads on one level that cross without a common node, and roads drawn closer together than their lanes are wide, have
//! nowhere to go. The map is built all the same; the user hears of the place.

use rayon::prelude::*;

use crate::builder::road_network::{Intersection, Road, RoadNetwork};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::cells::{Bounds, Cells};
use crate::geometry::{Point, Polyline, Vector, polygon};

use super::Outlines;
use super::merged::ribbon;

/// Boxes are sought in cells of this side, metres; roads are looked at in pieces no longer.
const CELL: f64 = 32.0;
/// Common ground below this, square metres, is no fault of the map.
const LEAST: f64 = 0.1;

/// Every two roads on one level of which parts lie on the same ground, by their indices. `kept` gives the stations
/// between which each road remains.
pub fn overlapping(network: &RoadNetwork, kept: &[[f64; 2]]) -> Vec<[usize; 2]> {
    let grounds = of_roads(network, kept);
    of_pairs(&grounds, |a, b| {
        let roads = [a.road()?, b.road()?];
        common(a, b).map(|_| roads)
    })
}

/// Whether two roads cover some ground both.
pub fn overlap(network: &RoadNetwork, kept: &[[f64; 2]], roads: [usize; 2]) -> bool {
    let ground = |road: usize| of_road(network, road, kept[road]);
    let [Some(a), Some(b)] = roads.map(ground) else { return false };
    common(&a, &b).is_some()
}

/// A finding for every two roads or intersections on one level that lie on the same ground and do not belong together.
pub fn overlaps(network: &RoadNetwork, outlines: &Outlines) -> Vec<Finding> {
    let mut grounds = of_roads(network, &outlines.kept);
    let rings = network.intersections.iter().zip(&outlines.intersections).zip(0..);
    grounds.extend(rings.filter(|((_, outline), _)| !outline.ring.is_empty()).map(|((at, outline), i)| {
        let levels = at.arms.iter().map(|arm| network.road(arm.road).level).collect();
        Ground { owner: Owner::Intersection(i), ring: outline.ring.clone(), line: None, half: 0.0, levels }
    }));
    of_pairs(&grounds, |a, b| {
        if attached(network, a.owner, b.owner) {
            return None;
        }
        let area = common(a, b)?;
        Some(finding(network, [a.owner, b.owner], meeting(a, b), area))
    })
}

/// What lies somewhere.
#[derive(Clone, Copy)]
enum Owner {
    Road(usize),
    Intersection(usize),
}

/// The ground of one road between its cuts, or of one intersection.
struct Ground {
    owner: Owner,
    ring: Vec<Point>,
    /// The middle of a road, and half its width.
    line: Option<Polyline>,
    half: f64,
    levels: Vec<f64>,
}

impl Ground {
    fn road(&self) -> Option<usize> {
        match self.owner {
            Owner::Road(road) => Some(road),
            Owner::Intersection(_) => None,
        }
    }

    /// Boxes that cover it: one for each piece of a road.
    fn boxes(&self) -> Vec<Bounds> {
        let Some(line) = &self.line else { return polygon::bounds(&self.ring).into_iter().collect() };
        let around = Vector::repeat(self.half);
        let pieces = line.segments().flat_map(|(p, q)| {
            let count = ((q - p).norm() / CELL).ceil().clamp(1.0, Polyline::MOST_PIECES) as usize;
            let at = move |i: usize| p + (q - p) * (i as f64 / count as f64);
            (0..count).map(move |i| [at(i), at(i + 1)])
        });
        pieces.map(|[p, q]| [p.inf(&q) - around, p.sup(&q) + around]).collect()
    }
}

fn of_roads(network: &RoadNetwork, kept: &[[f64; 2]]) -> Vec<Ground> {
    kept.par_iter().enumerate().filter_map(|(road, kept)| of_road(network, road, *kept)).collect()
}

fn of_road(network: &RoadNetwork, index: usize, [from, to]: [f64; 2]) -> Option<Ground> {
    let road = &network.roads[index];
    let line = road.line.cut(from, to)?;
    let (half, levels) = (road.half_width(), vec![road.level]);
    Some(Ground { owner: Owner::Road(index), ring: ribbon(&line, half)?, line: Some(line), half, levels })
}

/// What is to be said of the pairs of grounds on one level whose boxes touch, in their order.
fn of_pairs<T: Send>(grounds: &[Ground], say: impl Fn(&Ground, &Ground) -> Option<T> + Sync) -> Vec<T> {
    let boxes: Vec<Vec<Bounds>> = grounds.par_iter().map(Ground::boxes).collect();
    let owners: Vec<usize> = boxes.iter().enumerate().flat_map(|(i, of)| std::iter::repeat_n(i, of.len())).collect();
    let cells = Cells::new(boxes.concat(), CELL);
    let said = |(i, boxes): (usize, &Vec<Bounds>)| {
        let mut others: Vec<usize> = Vec::new();
        for reach in boxes {
            cells.touching(*reach, |at| others.extend(Some(owners[at]).filter(|&other| other > i)));
        }
        others.sort_unstable();
        others.dedup();
        let level = |&other: &usize| grounds[i].levels.iter().any(|level| grounds[other].levels.contains(level));
        others.into_iter().filter(level).filter_map(|other| say(&grounds[i], &grounds[other])).collect::<Vec<T>>()
    };
    let found: Vec<Vec<T>> = boxes.par_iter().enumerate().map(said).collect();
    found.into_iter().flatten().collect()
}

/// Whether a road ends at an intersection.
fn attached(network: &RoadNetwork, a: Owner, b: Owner) -> bool {
    match (a, b) {
        (Owner::Road(road), Owner::Intersection(at)) | (Owner::Intersection(at), Owner::Road(road)) => {
            let Road { from, to, .. } = network.roads[road];
            [from, to].iter().any(|end| end.0 as usize == at)
        }
        _ => false,
    }
}

/// Square metres that both cover, if they are worth a word.
fn common(a: &Ground, b: &Ground) -> Option<f64> {
    if let (Some(s), Some(t)) = (&a.line, &b.line)
        && nearest(s, t).distance >= a.half + b.half
    {
        return None;
    }
    let area = polygon::overlap(&a.ring, &b.ring);
    (area > LEAST).then_some(area)
}

/// A place on both.
fn meeting(a: &Ground, b: &Ground) -> Point {
    match (&a.line, &b.line) {
        (Some(s), Some(t)) => nearest(s, t).at,
        (Some(line), None) => nearest_vertex(line, &b.ring),
        (None, Some(line)) => nearest_vertex(line, &a.ring),
        (None, None) => a.ring.first().copied().unwrap_or_else(Point::origin),
    }
}

fn nearest_vertex(line: &Polyline, ring: &[Point]) -> Point {
    let distance = |p: &&Point| line.distance(**p);
    ring.iter().min_by(|p, q| distance(p).total_cmp(&distance(q))).copied().unwrap_or_else(|| line.first())
}

/// Where two lines come closest.
struct Nearest {
    /// Metres; zero where they cross.
    distance: f64,
    at: Point,
}

fn nearest(a: &Polyline, b: &Polyline) -> Nearest {
    if let Some((_, _, at)) = super::collide::crossings(a, b).first() {
        return Nearest { distance: 0.0, at: *at };
    }
    let from = |a: &Polyline, b: &Polyline| {
        let distances = a.points().iter().map(|at| Nearest { distance: b.distance(*at), at: *at });
        distances.min_by(|p, q| p.distance.total_cmp(&q.distance))
    };
    let both = [from(a, b), from(b, a)].into_iter().flatten();
    let unknown = Nearest { distance: f64::INFINITY, at: a.first() };
    both.min_by(|p, q| p.distance.total_cmp(&q.distance)).unwrap_or(unknown)
}

fn finding(network: &RoadNetwork, owners: [Owner; 2], at: Point, area: f64) -> Finding {
    let subject = |owner: Owner| match owner {
        Owner::Road(road) => Subject::Way(network.roads[road].key.way),
        Owner::Intersection(at) => Subject::Node(node(&network.intersections[at])),
    };
    let named = |owner: Owner| match owner {
        Owner::Road(road) => format!("way {}", network.roads[road].key.way),
        Owner::Intersection(at) => format!("the intersection at node {}", node(&network.intersections[at])),
    };
    let [a, b] = owners.map(named);
    let message = format!(
        "{a} and {b} cover {area:.1} m2 of the same ground: they cross without a common node, lack a layer, or are \
         narrower than their tags say"
    );
    Finding::new("roads-overlap", subject(owners[0]), message)
        .at(Place::Point(at))
        .with(subject(owners[1]), "overlaps")
        .graded(Severity::Warning)
}

fn node(at: &Intersection) -> i64 {
    at.nodes.first().copied().unwrap_or_default()
}
