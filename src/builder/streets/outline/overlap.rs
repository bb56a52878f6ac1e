//! Finds roads and intersections of the final layout that overlap.
//!
//! The corners of an intersection give way to roads that run past it. Roads on one level that cross without a common node, or are
//! closer together than their lanes are wide, overlap for good: they get a finding, and the map is built all the same.

use std::borrow::Cow;
use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork, Stations};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::polyline::within;
use crate::geometry::spatial_hash::{Bounds, SpatialHash, touch};
use crate::geometry::{Point, Polyline, Vector, polygon, segment_crossing};
use crate::parallel::InSmallParts;

use super::Outlines;
use super::collide::{boxes_touch, crossings};
use super::merged_outline::ribbon;

/// Cell size of the search and most length of a road's part, metres.
const CELL: f64 = 32.0;
/// Least area of an overlap, square metres.
const LEAST: f64 = 0.1;

/// Every two roads on one level that overlap, by index. `kept` has the stations between which each road remains.
pub fn overlapping(network: &RoadNetwork, kept: &[Stations]) -> Vec<[usize; 2]> {
    let grounds = road_grounds(network, kept);
    of_pairs(network, &grounds, |a, b| {
        let roads = [a.road()?, b.road()?];
        common(a, b).map(|_| roads)
    })
}

/// Whether two roads overlap.
pub fn overlap(network: &RoadNetwork, kept: &[Stations], roads: [usize; 2]) -> bool {
    let ground = |road: usize| road_ground(network, road, kept[road]);
    let [Some(a), Some(b)] = roads.map(ground) else { return false };
    let [parts, others] = [a.parts(0), b.parts(1)];
    let meet = |part: &Part| others.iter().any(|other| touch(&part.bounds, &other.bounds) && part.meets(other));
    parts.iter().any(meet) && common(&a, &b).is_some()
}

/// Leaves out of the corners of intersections what other roads cover, and makes a finding for every two roads or intersections on one
/// level that still overlap and are not attached to each other.
pub fn resolve_overlaps(network: &RoadNetwork, outlines: &mut Outlines) -> Vec<Finding> {
    let pairs = {
        let mut grounds = road_grounds(network, &outlines.kept);
        let intersections = (0..outlines.intersections.len()).map(Owner::Intersection);
        grounds.extend(intersections.filter_map(|owner| ground(network, outlines, owner)));
        of_pairs(network, &grounds, |a, b| {
            let apart = !attached(network, a.owner, b.owner);
            (apart && common(a, b).is_some()).then_some([a.owner, b.owner])
        })
    };
    clear_corners(network, outlines, &pairs);
    let left = pairs.into_iter().filter_map(|owners| {
        let [a, b] = [ground(network, outlines, owners[0])?, ground(network, outlines, owners[1])?];
        Some(finding(network, owners, meeting(&a, &b), common(&a, &b)?))
    });
    left.collect()
}

/// So many others at most are left out of the corners of an intersection; what still overlaps is told.
const MOST_IN_CORNERS: usize = 60;

/// Leaves out of the corners of each intersection what the others of its pairs cover, or some of them where a cut lies on one.
fn clear_corners(network: &RoadNetwork, outlines: &mut Outlines, pairs: &[[Owner; 2]]) {
    let mut others: BTreeMap<usize, Vec<Owner>> = BTreeMap::new();
    for [a, b] in pairs {
        for (owner, other) in [(a, b), (b, a)] {
            if let Owner::Intersection(i) = owner {
                others.entry(*i).or_default().push(*other);
            }
        }
    }
    for (i, others) in others {
        // A crossing of streets overlaps a few others.
        let rings = others
            .into_iter()
            .take(MOST_IN_CORNERS)
            .filter_map(|other| ground(network, outlines, other)?.ring().map(Cow::into_owned));
        let rings: Vec<Vec<Point>> = rings.collect();
        let outline = &mut outlines.intersections[i];
        if let Some(clear) = outline.without(&rings) {
            *outline = clear;
            continue;
        }
        for ring in rings.chunks(1) {
            if let Some(clear) = outline.without(ring) {
                *outline = clear;
            }
        }
    }
}

/// The owner of a ground, by index.
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

/// The shape of a ground.
enum Shape<'a> {
    /// A line with this width to either side, metres.
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

    /// Its parts; those of a road are at most about as long as a cell.
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
    /// The centre line of a road and half its width, metres; empty for an intersection.
    line: &'a [Point],
    half: f64,
}

impl Part<'_> {
    /// Whether the two may overlap.
    fn meets(&self, other: &Self) -> bool {
        self.line.is_empty() || other.line.is_empty() || closer(self.line, other.line, self.half + other.half)
    }
}

/// The ground of an owner; `None` if it has none.
fn ground<'a>(network: &RoadNetwork, outlines: &'a Outlines, owner: Owner) -> Option<Ground<'a>> {
    match owner {
        Owner::Road(road) => road_ground(network, road, outlines.kept[road]),
        Owner::Intersection(i) => {
            let ring = &outlines.intersections[i].ring;
            (!ring.is_empty()).then_some(Ground { owner, shape: Shape::Area(ring) })
        }
    }
}

fn road_grounds<'a>(network: &RoadNetwork, kept: &[Stations]) -> Vec<Ground<'a>> {
    kept.par_iter().in_small_parts().enumerate().filter_map(|(road, kept)| road_ground(network, road, *kept)).collect()
}

fn road_ground<'a>(network: &RoadNetwork, index: usize, [from, to]: Stations) -> Option<Ground<'a>> {
    let road = &network.roads[index];
    Some(Ground { owner: Owner::Road(index), shape: Shape::Strip(road.line.cut(from, to)?, road.half_width()) })
}

/// What `result` gives for each pair of grounds on one level that may overlap, in order.
fn of_pairs<T: Send>(
    network: &RoadNetwork,
    grounds: &[Ground],
    result: impl Fn(&Ground, &Ground) -> Option<T> + Sync,
) -> Vec<T> {
    let parts: Vec<Part> =
        grounds.par_iter().in_small_parts().enumerate().flat_map_iter(|(i, ground)| ground.parts(i)).collect();
    let cells = SpatialHash::new(parts.iter().map(|part| part.bounds).collect(), CELL);
    let mut pairs: Vec<[usize; 2]> = cells.pairs(|i, j| {
        let [a, b] = [&parts[i], &parts[j]];
        let owners = [a, b].map(|part| grounds[part.owner].owner);
        (a.owner != b.owner && on_one_level(network, owners) && a.meets(b))
            .then(|| [a.owner.min(b.owner), a.owner.max(b.owner)])
    });
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs.into_par_iter().in_small_parts().filter_map(|[a, b]| result(&grounds[a], &grounds[b])).collect()
}

/// Whether both lie on a common level.
fn on_one_level(network: &RoadNetwork, [a, b]: [Owner; 2]) -> bool {
    let any = |owner: Owner, fits: &dyn Fn(f64) -> bool| match owner {
        Owner::Road(road) => fits(network.roads[road].level),
        Owner::Intersection(i) => network.intersections[i].arms.iter().any(|arm| fits(network.road(arm.road).level)),
    };
    any(a, &|level| any(b, &|other| other == level))
}

/// Whether a road ends at an intersection.
fn attached(network: &RoadNetwork, a: Owner, b: Owner) -> bool {
    match (a, b) {
        (Owner::Road(road), Owner::Intersection(i)) | (Owner::Intersection(i), Owner::Road(road)) => {
            let Road { from, to, .. } = network.roads[road];
            [from, to].iter().any(|end| end.position() == i)
        }
        _ => false,
    }
}

/// The area of an overlap, square metres, if it is at least [`LEAST`].
fn common(a: &Ground, b: &Ground) -> Option<f64> {
    let area = polygon::overlap(&a.ring()?, &b.ring()?);
    (area > LEAST).then_some(area)
}

/// A point near the overlap.
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

/// Whether two lines cross, or come within `distance` metres of each other.
fn closer(a: &[Point], b: &[Point], distance: f64) -> bool {
    let cross =
        |p: Point, q: Point, r: Point, s: Point| boxes_touch(p, q, r, s) && segment_crossing(p, q, r, s).is_some();
    vertices_within(a, b, distance)
        || vertices_within(b, a, distance)
        || a.windows(2).any(|v| b.windows(2).any(|w| cross(v[0], v[1], w[0], w[1])))
}

/// Whether a vertex of `a` lies within `distance` metres of `b`.
fn vertices_within(a: &[Point], b: &[Point], distance: f64) -> bool {
    let is_near = |p: Point, ends: &[Point]| within((ends[0], ends[1]), p, distance).is_some_and(|d| d < distance);
    a.iter().any(|p| b.windows(2).any(|ends| is_near(*p, ends)))
}

/// The point where two lines are closest.
fn nearest(a: &Polyline, b: &Polyline) -> Point {
    if let Some((_, _, p)) = crossings(a, b).first() {
        return *p;
    }
    let distances =
        a.points().iter().map(|p| (b.distance(*p), *p)).chain(b.points().iter().map(|p| (a.distance(*p), *p)));
    distances.min_by(|p, q| p.0.total_cmp(&q.0)).map_or_else(|| a.first(), |(_, p)| p)
}

fn finding(network: &RoadNetwork, owners: [Owner; 2], place: Point, area: f64) -> Finding {
    let subject = |owner: Owner| match owner {
        Owner::Road(road) => Subject::Way(network.roads[road].key.way),
        Owner::Intersection(i) => Subject::Node(network.intersections[i].first_node()),
    };
    let name = |owner: Owner| match owner {
        Owner::Road(road) => format!("way {}", network.roads[road].key.way),
        Owner::Intersection(i) => format!("the intersection at node {}", network.intersections[i].first_node()),
    };
    let [a, b] = owners.map(name);
    let message = format!(
        "{a} and {b} cover {area:.1} m2 of the same ground: they cross without a common node, lack a layer, or are \
         narrower than their tags say"
    );
    Finding::new("roads-overlap", subject(owners[0]), message)
        .at(Place::Point(place))
        .with(subject(owners[1]), "overlaps")
        .graded(Severity::Warning)
}
