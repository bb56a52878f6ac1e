//! Finds where the edges of two arms cross.

use crate::geometry::spatial_hash::{Bounds, touch};
use crate::geometry::{Point, Polyline, segment_crossing};

use super::thicken::{Side, ThickenedArm};

/// Step of the search for a gap between two roads, metres.
const SEARCH_STEP: f64 = 2.0;
/// Collisions closer together than this, metres, belong to one overlap.
const ONE_OVERLAP: f64 = 4.0;

/// A place where an edge of one arm crosses an edge of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// Where.
    pub point: Point,
    /// Edge of the first arm.
    pub a: Side,
    /// Edge of the second arm.
    pub b: Side,
    /// Its projections onto both centre lines, metres from the intersection.
    pub stations: [f64; 2],
    /// Distances along both edges, metres from the intersection.
    pub along: [f64; 2],
}

/// The collisions of two arms in their overlap at the intersection, sorted outwards. Collisions beyond a gap, where the roads
/// meet again, are left out.
pub fn collisions(a: &ThickenedArm, b: &ThickenedArm) -> Vec<Collision> {
    let mut found = all_collisions(a, b);
    found.sort_by(|p, q| (p.stations[0] + p.stations[1]).total_cmp(&(q.stations[0] + q.stations[1])));
    let connected = (0..found.len())
        .take_while(|&i| {
            let before = if i == 0 { [0.0, 0.0] } else { found[i - 1].stations };
            !has_gap(a, b, before[0], found[i].stations[0]) && !has_gap(b, a, before[1], found[i].stations[1])
        })
        .count();
    found.truncate(connected);
    found
}

/// The collisions of two arms within `reach` metres, also those beyond a gap.
pub fn collisions_within(a: &ThickenedArm, b: &ThickenedArm, reach: f64) -> Vec<Collision> {
    let mut found = all_collisions(a, b);
    found.retain(|c| c.stations.iter().all(|s| *s <= reach));
    found
}

/// All collisions, with the same rounding in either order of the arms.
fn all_collisions(a: &ThickenedArm, b: &ThickenedArm) -> Vec<Collision> {
    if comes_first(a, b) {
        return edge_crossings(a, b);
    }
    let swapped = |c: Collision| Collision {
        a: c.b,
        b: c.a,
        stations: [c.stations[1], c.stations[0]],
        along: [c.along[1], c.along[0]],
        ..c
    };
    edge_crossings(b, a).into_iter().map(swapped).collect()
}

/// An order of arms by their geometry, not by their indices.
fn comes_first(a: &ThickenedArm, b: &ThickenedArm) -> bool {
    let place = |arm: &ThickenedArm| (arm.line.last(), arm.line.first(), arm.half);
    let ((p, q, wide), (r, s, other)) = (place(a), place(b));
    let by_place = |p: Point, q: Point| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y));
    by_place(p, r).then(by_place(q, s)).then(wide.total_cmp(&other)).is_le()
}

/// Edges of two roads cross this often at most; those of real roads do so once or twice.
const MOST_CROSSINGS: usize = 100;

fn edge_crossings(a: &ThickenedArm, b: &ThickenedArm) -> Vec<Collision> {
    let mut found = Vec::new();
    for sa in [Side::Left, Side::Right] {
        for sb in [Side::Left, Side::Right] {
            if !touch(&a.bounds(sa), &b.bounds(sb)) {
                continue;
            }
            let mut crossed = crossings_within(a.edge(sa), b.edge(sb), b.bounds(sb));
            // Spirals cross each other thousands of times; only what is joined to the intersection counts.
            if crossed.len() > MOST_CROSSINGS {
                crossed.sort_by(|one, other| (one.0 + one.1).total_cmp(&(other.0 + other.1)));
                crossed.truncate(MOST_CROSSINGS);
            }
            for (along_a, along_b, point) in crossed {
                let stations = [a, b].map(|arm| arm.line.project(point).station);
                found.push(Collision { point, a: sa, b: sb, stations, along: [along_a, along_b] });
            }
        }
    }
    found
}

/// Whether the roads are clear of each other somewhere between two stations of `a`, metres.
fn has_gap(a: &ThickenedArm, b: &ThickenedArm, from: f64, to: f64) -> bool {
    if to - from < ONE_OVERLAP {
        return false;
    }
    let steps = ((to - from) / SEARCH_STEP).ceil() as usize;
    let mut near = 0;
    (1..steps).any(|i| {
        let p = a.line.at(from + (to - from) * i as f64 / steps as f64);
        !b.line.reaches(p, a.half + b.half, &mut near)
    })
}

/// Where two lines cross: distances along both, metres, and the point.
pub fn crossings(a: &Polyline, b: &Polyline) -> Vec<(f64, f64, Point)> {
    crossings_within(a, b, b.bounds())
}

/// As [`crossings`], with the bounding box of the second line.
fn crossings_within(a: &Polyline, b: &Polyline, [low, high]: Bounds) -> Vec<(f64, f64, Point)> {
    let mut found = Vec::new();
    let (mut before_a, mut before_b) = (None, None);
    for (i, (p, q)) in a.segments().enumerate().filter(|(_, (p, q))| boxes_touch(*p, *q, low, high)) {
        for (j, (r, s)) in b.segments().enumerate() {
            if boxes_touch(p, q, r, s)
                && let Some((t, u, point)) = segment_crossing(p, q, r, s)
            {
                let along_a = before_a.get_or_insert_with(|| a.stations())[i] + t * (q - p).norm();
                let along_b = before_b.get_or_insert_with(|| b.stations())[j] + u * (s - r).norm();
                found.push((along_a, along_b, point));
            }
        }
    }
    found
}

/// Whether the bounding boxes of two segments touch.
pub fn boxes_touch(p: Point, q: Point, r: Point, s: Point) -> bool {
    p.x.min(q.x) <= r.x.max(s.x)
        && r.x.min(s.x) <= p.x.max(q.x)
        && p.y.min(q.y) <= r.y.max(s.y)
        && r.y.min(s.y) <= p.y.max(q.y)
}
