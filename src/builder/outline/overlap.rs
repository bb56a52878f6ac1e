//! Roads that still cover each other when all is laid out: no road of their tags can lie where they are drawn.
//!
//! Roads on one level that cross without a common node, and roads drawn closer together than their lanes are wide, have
//! nowhere to go. The map is built all the same; the user hears of the place.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::builder::road_network::{Road, RoadNetwork};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, Polyline, polygon};

use super::merged::ribbon;

/// Common ground below this, square metres, is no fault of the map.
const LEAST: f64 = 0.1;

/// What remains of one road.
struct Strip {
    line: Polyline,
    ring: Vec<Point>,
}

/// A finding for every two roads on one level of which parts lie on the same ground. `kept` gives what remains of each
/// road between its cuts.
pub fn overlaps(network: &RoadNetwork, kept: &[[f64; 2]]) -> Vec<Finding> {
    let strips: Vec<Option<Strip>> = network.roads.iter().zip(kept).map(|(road, kept)| strip(road, *kept)).collect();
    let pieces: Vec<GeomWithData<Rectangle<[f64; 2]>, usize>> = strips
        .iter()
        .enumerate()
        .filter_map(|(i, strip)| Some((i, strip.as_ref()?)))
        .flat_map(|(i, strip)| {
            let half = network.roads[i].half_width();
            strip.line.segments().map(move |(p, q)| {
                let (low, high) = (p.inf(&q), p.sup(&q));
                let corners = ([low.x - half, low.y - half], [high.x + half, high.y + half]);
                GeomWithData::new(Rectangle::from_corners(corners.0, corners.1), i)
            })
        })
        .collect();
    let tree = RTree::bulk_load(pieces.clone());
    let mut pairs: Vec<(usize, usize)> = pieces
        .iter()
        .flat_map(|piece| {
            let envelope = AABB::from_corners(piece.geom().lower(), piece.geom().upper());
            tree.locate_in_envelope_intersecting(&envelope).map(|other| (piece.data, other.data))
        })
        .filter(|(a, b)| a < b && network.roads[*a].level == network.roads[*b].level)
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let overlap = |(a, b): (usize, usize)| {
        let (s, t) = (strips[a].as_ref()?, strips[b].as_ref()?);
        let reach = network.roads[a].half_width() + network.roads[b].half_width();
        if !near(&s.line, &t.line, reach) {
            return None;
        }
        let area = polygon::overlap(&s.ring, &t.ring);
        (area > LEAST).then(|| finding([&network.roads[a], &network.roads[b]], nearest(&s.line, &t.line), area))
    };
    pairs.into_iter().filter_map(overlap).collect()
}

fn strip(road: &Road, [from, to]: [f64; 2]) -> Option<Strip> {
    let line = road.line.cut(from, to)?;
    let ring = ribbon(&line, road.half_width())?;
    Some(Strip { line, ring })
}

/// Whether two lines cross, or a point of one lies closer to the other than `reach`.
fn near(a: &Polyline, b: &Polyline, reach: f64) -> bool {
    a.points().iter().any(|p| b.distance(*p) < reach)
        || b.points().iter().any(|p| a.distance(*p) < reach)
        || !super::collide::crossings(a, b).is_empty()
}

/// A place where two lines are close.
fn nearest(a: &Polyline, b: &Polyline) -> Point {
    if let Some((_, _, point)) = super::collide::crossings(a, b).first() {
        return *point;
    }
    let distance = |p: &&Point| b.distance(**p);
    a.points().iter().min_by(|p, q| distance(p).total_cmp(&distance(q))).copied().unwrap_or_else(|| a.first())
}

fn finding(roads: [&Road; 2], at: Point, area: f64) -> Finding {
    let [a, b] = roads.map(|road| road.key.way);
    let message = format!(
        "ways {a} and {b} cover {area:.1} m2 of the same ground: they cross without a common node, lack a layer, or are \
         narrower than their tags say"
    );
    Finding::new("roads-overlap", Subject::Way(a), message)
        .at(Place::Point(at))
        .with(Subject::Way(b), "overlaps")
        .graded(Severity::Warning)
}
