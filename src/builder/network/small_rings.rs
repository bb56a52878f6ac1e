//! Widens roundabouts that are drawn too small for lanes to part and join on them.
//!
//! Mappers draw small rings along the kerb of the island rather than along the middle of the lane. The smallest roundabouts that are
//! built measure 13 m from outer kerb to outer kerb (FHWA, *Mini-Roundabouts Technical Summary*, 2010: 45 to 90 ft; FGSV, *Merkblatt
//! für die Anlage von Kreisverkehren*, 2006: 13 to 22 m).

use geo::Centroid;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::polyline::distance_to_segment;
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, Vector, polygon};

use super::access::Drivable;
use super::frame::level;

/// The least radius of the middle of a ring's lane, metres: the lanelets between four entries and exits at right angles are 3 m long.
const LEAST: f64 = 6.75;
/// The nodes of a ring lie this far from its middle, as shares of its mean radius, or it is none.
const ROUND: [f64; 2] = [0.7, 1.3];
/// A ring with fewer roads is no roundabout but a place to turn.
const ARMS: usize = 3;
/// What is left of a road between the ring and its first bend, metres, at least.
const ARM_LEFT: f64 = 1.0;
/// A road beside the ring has its middle at least this far, metres, from that of the ring's lane.
const BESIDE: f64 = 3.5;
/// The sides of the cells of the search, metres.
const CELL: f64 = 32.0;

/// A ring that is too small.
struct SmallRing {
    way: i64,
    nodes: FxHashSet<i64>,
    middle: Point,
    radius: f64,
    level: f64,
}

impl SmallRing {
    /// The box that the widened ring and what lies beside it need.
    fn bounds(&self) -> [Point; 2] {
        let around = Vector::repeat(LEAST + BESIDE);
        [self.middle - around, self.middle + around]
    }

    /// Whether a segment of a road that is no part of the ring leaves it room to become wider.
    fn has_room_beside(&self, [from, to]: [(i64, Point); 2]) -> bool {
        let away = |place: Point| (place - self.middle).norm();
        match [from, to].map(|(node, _)| self.nodes.contains(&node)) {
            [true, true] => false,
            [true, false] => away(to.1) >= LEAST + ARM_LEFT,
            [false, true] => away(from.1) >= LEAST + ARM_LEFT,
            [false, false] => distance_to_segment(self.middle, from.1, to.1) >= LEAST + BESIDE,
        }
    }
}

/// The positions of nodes, metres, with those of small rings moved outward where nothing is in the way. With a note for each ring.
pub(super) fn widened(
    ways: &[Drivable<'_>],
    mut positions: FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) -> FxHashMap<i64, Point> {
    let rings = small_rings(ways, &positions);
    if rings.is_empty() {
        return positions;
    }
    let cells = SpatialHash::new(rings.iter().map(SmallRing::bounds).collect(), CELL);
    let (mut arms, mut has_room) = (vec![0_usize; rings.len()], vec![true; rings.len()]);
    for way in ways.iter().filter(|way| !is_ring(way)) {
        let level = level(&way.way.tags);
        for pair in way.way.nodes.windows(2) {
            let place = |node: &i64| Some((*node, *positions.get(node)?));
            let (Some(from), Some(to)) = (place(&pair[0]), place(&pair[1])) else { continue };
            cells.touching([from.1.inf(&to.1), from.1.sup(&to.1)], |i| {
                let ring = &rings[i];
                let joins = [from, to].iter().filter(|(node, _)| ring.nodes.contains(node)).count();
                arms[i] += joins;
                has_room[i] &= joins == 0 && level != ring.level || ring.has_room_beside([from, to]);
            });
        }
    }
    for (ring, _) in rings.iter().zip(arms.iter().zip(&has_room)).filter(|(_, (arms, room))| **arms >= ARMS && **room) {
        let SmallRing { way, nodes, middle, radius, .. } = ring;
        for node in nodes {
            if let Some(place) = positions.get_mut(node) {
                *place = middle + (*place - middle) * (LEAST / radius);
            }
        }
        let message = format!(
            "the roundabout of way {way} is drawn with a radius of {radius:.1} m and built with {LEAST} m, the least on which lanes \
             part and join"
        );
        let note = Finding::new("ring-widened", Subject::Way(*way), message).measured(*radius, LEAST, "m");
        notes.push(note.graded(Severity::Info));
    }
    positions
}

fn is_ring(way: &Drivable<'_>) -> bool {
    ["roundabout", "circular"].iter().any(|kind| way.way.tags.is("junction", kind))
}

/// The rings that are too small, in the order of their ways: closed ways, and rows of ways that close.
fn small_rings(ways: &[Drivable<'_>], positions: &FxHashMap<i64, Point>) -> Vec<SmallRing> {
    let mut next: FxHashMap<i64, Vec<i64>> = FxHashMap::default();
    for way in ways.iter().filter(|way| is_ring(way)) {
        way.way.nodes.windows(2).filter(|pair| pair[0] != pair[1]).for_each(|pair| {
            next.entry(pair[0]).or_default().push(pair[1]);
        });
    }
    let mut passed: FxHashSet<i64> = FxHashSet::default();
    let mut rings = Vec::new();
    for way in ways.iter().filter(|way| is_ring(way)) {
        let Some(&first) = way.way.nodes.first().filter(|first| !passed.contains(first)) else { continue };
        let Some(ring) = around(first, &next, &mut passed) else { continue };
        let places: Option<Vec<Point>> = ring.iter().map(|node| positions.get(node).copied()).collect();
        let shape = places.and_then(|places| shape(&places));
        rings.extend(shape.filter(|(_, radius)| *radius < LEAST).map(|(middle, radius)| SmallRing {
            way: way.way.id,
            nodes: ring.into_iter().collect(),
            middle,
            radius,
            level: level(&way.way.tags),
        }));
    }
    rings
}

/// The nodes from one on until the way is back there; `None` if it does not come back, or parts.
fn around(first: i64, next: &FxHashMap<i64, Vec<i64>>, passed: &mut FxHashSet<i64>) -> Option<Vec<i64>> {
    let (mut ring, mut at) = (Vec::new(), first);
    while passed.insert(at) {
        ring.push(at);
        let [only] = next.get(&at)?[..] else { return None };
        at = only;
    }
    (at == first).then_some(ring)
}

/// The middle of a ring and its mean radius, metres; `None` if it is not round.
fn shape(places: &[Point]) -> Option<(Point, f64)> {
    let middle = polygon::to_geo(places).centroid()?;
    let middle = Point::new(middle.x(), middle.y());
    let away: Vec<f64> = places.iter().map(|place| (place - middle).norm()).collect();
    let radius = away.iter().sum::<f64>() / away.len() as f64;
    let is_round = away.iter().all(|away| (ROUND[0] * radius..=ROUND[1] * radius).contains(away));
    (places.len() > 3 && radius > 0.0 && is_round).then_some((middle, radius))
}

#[cfg(test)]
mod tests {
    use crate::builder::network::hand_drawn::{osm, plane};
    use crate::builder::network::{NetworkOptions, NetworkReading, road_network};
    use crate::builder::tags::road_class::DrivingSide;

    /// The least and the largest distance, metres, of the ring of four roads from its middle, and the notes.
    fn ring(radius: f64, bend: f64) -> ([f64; 2], Vec<String>) {
        let on_ring = |i: i64| {
            let angle = std::f64::consts::TAU * i as f64 / 8.0;
            (i + 1, radius * angle.cos(), radius * angle.sin(), "")
        };
        let mut nodes: Vec<_> = (0..8).map(on_ring).collect();
        nodes.extend([(21, 60.0, 0.0, ""), (22, 0.0, 60.0, ""), (23, -60.0, 0.0, ""), (24, 0.0, -60.0, "")]);
        nodes.push((25, bend, 0.0, ""));
        let ways = [
            (10, &[1, 2, 3, 4, 5, 6, 7, 8, 1][..], "highway=residential junction=roundabout"),
            (11, &[21, 25, 1], "highway=residential"),
            (12, &[22, 3], "highway=residential"),
            (13, &[23, 5], "highway=residential"),
            (14, &[24, 7], "highway=residential"),
        ];
        let options = NetworkOptions { driving_side: Some(DrivingSide::Right), ..NetworkOptions::default() };
        let NetworkReading { network, notes } = road_network(&osm(&nodes, &ways), &plane, &options).unwrap();
        let lines = network.roads.iter().filter(|road| road.roundabout).flat_map(|road| road.line.points());
        let away = lines.map(|place| place.coords.norm());
        let extent = away.fold([f64::INFINITY, 0.0], |[low, high], away| [low.min(away), f64::max(high, away)]);
        let notes = notes.into_iter().filter(|note| note.fault == "ring-widened").map(|note| note.message);
        (extent, notes.collect())
    }

    #[test]
    fn a_small_ring_is_widened_where_there_is_room() {
        let ([low, high], notes) = ring(4.0, 30.0);
        assert!((low - 6.75).abs() < 1e-6 && (high - 6.75).abs() < 1e-6, "{low} {high}");
        assert_eq!(notes.len(), 1, "{notes:?}");
        let ([low, high], notes) = ring(9.0, 30.0);
        assert!((low - 9.0).abs() < 1e-6 && (high - 9.0).abs() < 1e-6 && notes.is_empty(), "{low} {high} {notes:?}");
        let ([_, high], notes) = ring(4.0, 7.0);
        assert!(
            (high - 4.0).abs() < 1e-6 && notes.is_empty(),
            "a road bends where the ring would be: {high} {notes:?}"
        );
    }
}
