//! Roads and intersections that still cover each other when all is laid out: nothing of their tags can lie where they
//! are drawn.
//!
//! Roads on one level that cross without a common node, and roads drawn closer together than their lanes are wide, have
//! nowhere to go. The map is built all the same; the user hears of the place.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::builder::network::{Intersection, Road, RoadNetwork, Stations};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::polyline::within;
use crate::geometry::spatial_hash::{Bounds, SpatialHash, touch};
use crate::geometry::{Point, Polyline, Vector, polygon, segment_crossing};
use crate::parallel::Finely;

use super::Outlines;
use super::collide::{boxes_touch, crossings};
use super::merged::ribbon;

/// Boxes are sought in cells of this side, metres; roads are looked at in pieces no longer.
const CELL: f64 = 32.0;
/// Common ground below this, square metres, is no fault of the map.
const LEAST: f64 = 0.1;

/// Every two roads on one level of which parts lie on the same ground, by their indices. `kept` gives the stations
/// between which each road remains.
pub fn overlapping(network: &RoadNetwork, kept: &[Stations]) -> Vec<[usize; 2]> {
    let grounds = of_roads(network, kept);
    of_pairs(network, &grounds, |a, b| {
        let roads = [a.road()?, b.road()?];
        common(a, b).map(|_| roads)
    })
}

/// Whether two roads cover some ground both.
pub fn overlap(network: &RoadNetwork, kept: &[Stations], roads: [usize; 2]) -> bool {
    let ground = |road: usize| of_road(network, road, kept[road]);
    let [Some(a), Some(b)] = roads.map(ground) else { return false };
    let [parts, others] = [a.parts(0), b.parts(1)];
    let meet = |part: &Part| others.iter().any(|other| touch(&part.bounds, &other.bounds) && part.meets(other));
    parts.iter().any(meet) && common(&a, &b).is_some()
}

/// A finding for every two roads or intersections on one level that lie on the same ground and do not belong together.
pub fn overlaps(network: &RoadNetwork, outlines: &Outlines) -> Vec<Finding> {
    let mut grounds = of_roads(network, &outlines.kept);
    let rings = outlines.intersections.iter().map(|outline| &outline.ring[..]).enumerate();
    let rings = rings.filter(|(_, ring)| !ring.is_empty());
    grounds.extend(rings.map(|(i, ring)| Ground { owner: Owner::Intersection(i), shape: Shape::Area(ring) }));
    of_pairs(network, &grounds, |a, b| {
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
struct Ground<'a> {
    owner: Owner,
    shape: Shape<'a>,
}

/// What a ground covers.
enum Shape<'a> {
    /// So much, metres, to either side of a line.
    Strip(Polyline, f64),
    /// The inside of a ring.
    Area(&'a [Point]),
}

impl Ground<'_> {
    fn road(&self) -> Option<usize> {
        match self.owner {
            Owner::Road(road) => Some(road),
            Owner::Intersection(_) => None,
        }
    }

    fn ring(&self) -> Option<Cow<'_, [Point]>> {
        match &self.shape {
            Shape::Strip(line, half) => ribbon(line, *half).map(Cow::Owned),
            Shape::Area(ring) => Some(Cow::Borrowed(*ring)),
        }
    }

    /// Parts that cover it: of a road each about as long as a cell.
    fn parts(&self, owner: usize) -> Vec<Part<'_>> {
        let (line, half) = match &self.shape {
            Shape::Strip(line, half) => (line, *half),
            Shape::Area(ring) => {
                return polygon::bounds(ring)
                    .map(|bounds| Part { owner, bounds, line: &[], half: 0.0 })
                    .into_iter()
                    .collect();
            }
        };
        let (points, around) = (line.points(), Vector::repeat(half));
        let mut parts: Vec<Part> = Vec::new();
        let mut first = 0;
        for (i, (p, q)) in line.segments().enumerate() {
            let count = ((q - p).norm() / CELL).ceil().clamp(1.0, Polyline::MOST_PIECES) as usize;
            for k in 0..count {
                let [p, q] = [k, k + 1].map(|k| p + (q - p) * (k as f64 / count as f64));
                let [low, high] = [p.inf(&q) - around, p.sup(&q) + around];
                match parts.last_mut() {
                    Some(Part { bounds: [l, h], line, .. })
                        if (h.sup(&high) - l.inf(&low)).max() <= CELL + 2.0 * half =>
                    {
                        (*l, *h) = (l.inf(&low), h.sup(&high));
                        *line = &points[first..i + 2];
                    }
                    _ => {
                        first = i;
                        parts.push(Part { owner, bounds: [low, high], line: &points[i..i + 2], half });
                    }
                }
            }
        }
        parts
    }
}

/// A part of a ground, by the ground's index.
struct Part<'a> {
    owner: usize,
    bounds: Bounds,
    /// The middle of a road, and half its width; nothing for what is no road.
    line: &'a [Point],
    half: f64,
}

impl Part<'_> {
    /// Whether the two may have ground in common.
    fn meets(&self, other: &Self) -> bool {
        self.line.is_empty() || other.line.is_empty() || closer(self.line, other.line, self.half + other.half)
    }
}

fn of_roads<'a>(network: &RoadNetwork, kept: &[Stations]) -> Vec<Ground<'a>> {
    kept.par_iter().finely().enumerate().filter_map(|(road, kept)| of_road(network, road, *kept)).collect()
}

fn of_road<'a>(network: &RoadNetwork, index: usize, [from, to]: [f64; 2]) -> Option<Ground<'a>> {
    let road = &network.roads[index];
    Some(Ground { owner: Owner::Road(index), shape: Shape::Strip(road.line.cut(from, to)?, road.half_width()) })
}

/// What is to be said of the pairs of grounds on one level whose boxes touch, in their order.
fn of_pairs<T: Send>(
    network: &RoadNetwork,
    grounds: &[Ground],
    say: impl Fn(&Ground, &Ground) -> Option<T> + Sync,
) -> Vec<T> {
    let parts: Vec<Part> =
        grounds.par_iter().finely().enumerate().flat_map_iter(|(i, ground)| ground.parts(i)).collect();
    let cells = SpatialHash::new(parts.iter().map(|part| part.bounds).collect(), CELL);
    let mut pairs: Vec<[usize; 2]> = cells.pairs(|i, j| {
        let [a, b] = [&parts[i], &parts[j]];
        let owners = [a, b].map(|part| grounds[part.owner].owner);
        (a.owner != b.owner && on_one_level(network, owners) && a.meets(b))
            .then(|| [a.owner.min(b.owner), a.owner.max(b.owner)])
    });
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs.into_par_iter().finely().filter_map(|[a, b]| say(&grounds[a], &grounds[b])).collect()
}

/// Whether there is a level on which both lie.
fn on_one_level(network: &RoadNetwork, [a, b]: [Owner; 2]) -> bool {
    let lies = |owner: Owner, on: &dyn Fn(f64) -> bool| match owner {
        Owner::Road(road) => on(network.roads[road].level),
        Owner::Intersection(at) => network.intersections[at].arms.iter().any(|arm| on(network.road(arm.road).level)),
    };
    lies(a, &|level| lies(b, &|other| other == level))
}

/// Whether a road ends at an intersection.
fn attached(network: &RoadNetwork, a: Owner, b: Owner) -> bool {
    match (a, b) {
        (Owner::Road(road), Owner::Intersection(at)) | (Owner::Intersection(at), Owner::Road(road)) => {
            let Road { from, to, .. } = network.roads[road];
            [from, to].iter().any(|end| end.position() == at)
        }
        _ => false,
    }
}

/// Square metres that both cover, if they are worth a word.
fn common(a: &Ground, b: &Ground) -> Option<f64> {
    let area = polygon::overlap(&a.ring()?, &b.ring()?);
    (area > LEAST).then_some(area)
}

/// A place on both.
fn meeting(a: &Ground, b: &Ground) -> Point {
    match (&a.shape, &b.shape) {
        (Shape::Strip(s, _), Shape::Strip(t, _)) => nearest(s, t),
        (Shape::Strip(line, _), Shape::Area(ring)) | (Shape::Area(ring), Shape::Strip(line, _)) => {
            nearest_vertex(line, ring)
        }
        (Shape::Area(ring), Shape::Area(_)) => ring.first().copied().unwrap_or_else(Point::origin),
    }
}

fn nearest_vertex(line: &Polyline, ring: &[Point]) -> Point {
    let distance = |p: &&Point| line.distance(**p);
    ring.iter().min_by(|p, q| distance(p).total_cmp(&distance(q))).copied().unwrap_or_else(|| line.first())
}

/// Whether two lines cross, or come closer to each other than so many metres.
fn closer(a: &[Point], b: &[Point], distance: f64) -> bool {
    let close = |ends: &[Point], p: Point| within((ends[0], ends[1]), p, distance).is_some_and(|from| from < distance);
    let reaches = |a: &[Point], b: &[Point]| a.iter().any(|p| b.windows(2).any(|ends| close(ends, *p)));
    let cross =
        |p: Point, q: Point, r: Point, s: Point| boxes_touch(p, q, r, s) && segment_crossing(p, q, r, s).is_some();
    reaches(a, b) || reaches(b, a) || a.windows(2).any(|v| b.windows(2).any(|w| cross(v[0], v[1], w[0], w[1])))
}

/// Where two lines come closest.
fn nearest(a: &Polyline, b: &Polyline) -> Point {
    if let Some((_, _, at)) = crossings(a, b).first() {
        return *at;
    }
    let from = |a: &Polyline, b: &Polyline| a.points().iter().map(|at| (b.distance(*at), *at)).collect::<Vec<_>>();
    let both = [from(a, b), from(b, a)].concat().into_iter();
    both.min_by(|p, q| p.0.total_cmp(&q.0)).map_or_else(|| a.first(), |(_, at)| at)
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
