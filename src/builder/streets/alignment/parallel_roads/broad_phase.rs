//! Finds the roads that may lie side by side with others, by oriented boxes around parts of them. Most roads have nothing beside
//! them, and are not sampled.

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork, Stations};
use crate::geometry::spatial_hash::{Bounds, SpatialHash, touch};
use crate::geometry::{Point, Polyline, Vector, left_of};
use crate::parallel::InSmallParts;

use super::overlap_search::{PARALLEL, legs_apart};
use super::recheck::sort_unique;
use super::shifted_road::{GAP_BETWEEN, PLACE_STEP, SHORTEST, TOLERANCE};

/// Most length of a box between the cuts, metres.
const LONGEST: f64 = 48.0;
/// Cell size of the search, metres.
const CELL: f64 = 64.0;
/// Allowance for rounding of lengths, metres, and angles, radians.
const SLACK: f64 = 1e-3;

/// An oriented box around a part of a road, which holds the road's places and the pieces between them.
struct RoadBox {
    road: usize,
    /// Whether it lies between the cuts.
    kept: bool,
    /// Half the width of the road, metres.
    half: f64,
    /// Where the part begins, its direction, and the extent of the box from there ahead and to the left, metres.
    origin: Point,
    axis: Vector,
    ahead: [f64; 2],
    left: [f64; 2],
    /// The largest deviation from that direction on and beside the part, radians, and its sine.
    spread: f64,
    sine: f64,
    /// The axis-parallel bounding box.
    bounds: Bounds,
}

impl RoadBox {
    /// The part of a line between the stations `on`, with the deviation between the stations `around`.
    fn new(line: &Polyline, stations: &[f64], on: [f64; 2], around: [f64; 2]) -> Self {
        let points = line.points();
        let segment = |s: f64| stations.partition_point(|station| *station < s).clamp(1, points.len() - 1) - 1;
        let [first, last] = on.map(segment);
        let place = |s: f64, i: usize| {
            let part = (s - stations[i]) / (stations[i + 1] - stations[i]);
            points[i] + (points[i + 1] - points[i]) * part.clamp(0.0, 1.0)
        };
        let [origin, end] = [place(on[0], first), place(on[1], last)];
        let axis = (end - origin).try_normalize(Polyline::MERGE).unwrap_or_else(Vector::x);
        let mut part = Self {
            road: 0,
            kept: false,
            half: 0.0,
            origin,
            axis,
            ahead: [0.0; 2],
            left: [0.0; 2],
            spread: 0.0,
            sine: 0.0,
            bounds: [origin; 2],
        };
        for p in points[first + 1..=last].iter().chain([&end]) {
            let [ahead, left] = [axis, left_of(axis)].map(|axis| axis.dot(&(p - origin)));
            part.ahead = [part.ahead[0].min(ahead), part.ahead[1].max(ahead)];
            part.left = [part.left[0].min(left), part.left[1].max(left)];
            part.bounds = [part.bounds[0].inf(p), part.bounds[1].sup(p)];
        }
        let headings = (segment(around[0])..=segment(around[1])).map(|i| (points[i + 1] - points[i]).normalize());
        let least = headings.map(|heading| heading.dot(&axis)).fold(1.0, f64::min);
        // Pieces connect places of the road: if its segments all lead ahead, pieces deviate no more than they.
        if least > 0.0 {
            part.spread = least.acos();
            part.sine = part.spread.sin();
        } else {
            (part.spread, part.sine) = (std::f64::consts::PI, f64::INFINITY);
        }
        part
    }

    /// The axis-parallel bounding box, widened by `half` metres.
    fn widened(&self, half: f64) -> Bounds {
        let around = Vector::repeat(half + SLACK);
        [self.bounds[0] - around, self.bounds[1] + around]
    }

    /// The bounding box of the search: the legs of a hairpin lie at most so far apart.
    fn search_bounds(&self) -> Bounds {
        self.widened(legs_apart(self.half) - self.half + GAP_BETWEEN)
    }

    /// Whether its road may have to move because of the other box.
    fn is_near(&self, other: &Self) -> bool {
        self.kept && touch(&self.search_bounds(), &other.widened(other.half)) && self.may_lie_beside(other)
    }

    /// Whether a place of it may lie beside a parallel piece of the other.
    fn may_lie_beside(&self, other: &Self) -> bool {
        let own = self.road == other.road;
        let reach = if own { legs_apart(self.half) } else { self.half + other.half } + GAP_BETWEEN + SLACK;
        let from = self.origin - other.origin;
        // Whether the boxes come within `margin` along an axis (separating axis theorem).
        let close = |axis: Vector, [low, high]: [f64; 2], margin: f64| {
            let middle = from.dot(&axis);
            let sides = [(self.axis, self.ahead), (left_of(self.axis), self.left)];
            let spans = sides.map(|(side, span)| span.map(|by| by * side.dot(&axis)));
            let least = spans.iter().map(|[a, b]| a.min(*b)).sum::<f64>() + middle;
            let most = spans.iter().map(|[a, b]| a.max(*b)).sum::<f64>() + middle;
            least <= high + margin && low <= most + margin
        };
        // A place beside a piece lies perpendicular to it, and pieces deviate from the box by at most the spread.
        if !close(other.axis, other.ahead, TOLERANCE + reach * other.sine + SLACK)
            || !close(left_of(other.axis), other.left, reach)
        {
            return false;
        }
        let along = self.axis.dot(&other.axis);
        let between = if own { -along } else { along.abs() }.clamp(-1.0, 1.0).acos();
        between - self.spread - other.spread <= PARALLEL.acos() + SLACK
    }
}

/// The stations of a road's cuts and its length, metres.
struct Span {
    from: f64,
    to: f64,
    length: f64,
}

impl Span {
    /// The least station of the place before this station.
    fn before(&self, station: f64) -> f64 {
        if station - PLACE_STEP < self.from { 0.0 } else { station - PLACE_STEP }
    }

    /// The largest station of the place after this station.
    fn after(&self, station: f64) -> f64 {
        if station + PLACE_STEP > self.to { self.length } else { station + PLACE_STEP }
    }
}

/// The boxes of a road: those between its cuts and one for each part beyond them.
fn boxes(index: usize, road: &Road, kept: Stations) -> Vec<RoadBox> {
    let stations = road.line.stations();
    let length = stations[stations.len() - 1];
    let [from, to] = kept.map(|station| station.clamp(0.0, length));
    if to - from <= SHORTEST {
        return Vec::new();
    }
    let span = Span { from, to, length };
    let half = road.half_width();
    let part = |kept: bool, on: [f64; 2], around: [f64; 2]| RoadBox {
        road: index,
        kept,
        half,
        ..RoadBox::new(&road.line, &stations, on, around)
    };
    let count = ((to - from) / LONGEST).ceil().min(Polyline::MOST_PIECES) as usize;
    let mark = |i: usize| from + (to - from) * i as f64 / count as f64;
    let between = (0..count).map(|i| [mark(i), mark(i + 1)]);
    let mut all: Vec<RoadBox> = between
        .map(|[a, b]| part(true, [a, (b + PLACE_STEP).min(to)], [span.before(a), span.after(span.after(b))]))
        .collect();
    if from > 0.0 {
        all.push(part(false, [0.0, from], [0.0, span.after(from)]));
    }
    if to < length {
        all.push(part(false, [to, length], [span.before(to), length]));
    }
    all
}

/// All roads that may lie beside another road or another leg of the same one, and those others, ascending.
pub fn candidates(network: &RoadNetwork, kept: &[Stations]) -> Vec<usize> {
    /// Roads that one thread takes at a time.
    const CHUNK: usize = 64;
    let of_chunk = |(chunk, (roads, kept)): (usize, (&[Road], &[Stations]))| -> Vec<RoadBox> {
        let roads = roads.iter().zip(kept).zip(chunk * CHUNK..);
        roads.flat_map(|((road, kept), i)| boxes(i, road, *kept)).collect()
    };
    let roads =
        network.roads.par_chunks(CHUNK).in_small_parts().zip(kept.par_chunks(CHUNK).in_small_parts()).enumerate();
    let chunks: Vec<Vec<RoadBox>> = roads.map(of_chunk).collect();
    let all: Vec<&RoadBox> = chunks.iter().flatten().collect();
    let cells = SpatialHash::new(all.iter().map(|part| part.search_bounds()).collect(), CELL);
    let pairs = cells.pairs(|i, j| {
        let [a, b] = [all[i], all[j]];
        (may_overlap(network, a.road, b.road) && (a.is_near(b) || b.is_near(a))).then_some([a.road, b.road])
    });
    let bent = all.par_iter().in_small_parts().filter(|part| part.is_near(part)).map(|part| part.road);
    let mut likely: Vec<usize> = pairs.into_iter().flatten().collect();
    likely.par_extend(bent);
    sort_unique(&mut likely);
    likely
}

/// Whether two roads are on one level or share an intersection.
fn may_overlap(network: &RoadNetwork, a: usize, b: usize) -> bool {
    let [a, b] = [a, b].map(|road| &network.roads[road]);
    a.level == b.level || [a.from, a.to].iter().any(|end| [b.from, b.to].contains(end))
}
