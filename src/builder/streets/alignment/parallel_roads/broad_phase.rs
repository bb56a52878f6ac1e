//! Which roads may lie abreast of others, seen from their own segments. Most have nothing beside them lengthwise, and need no
//! places to be compared.

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork, Stations};
use crate::builder::streets::alignment::TIGHTEST;
use crate::geometry::spatial_hash::{Bounds, SpatialHash, touch};
use crate::geometry::{Point, Polyline, Vector, left_of};
use crate::parallel::Finely;

use super::carriageway_edges::{CLEAR, SHORTEST, STEP, TOLERANCE};
use super::overlap_search::PARALLEL;
use super::recheck::sorted;

/// A stretch between the cuts is no longer than this, metres.
const LONGEST: f64 = 48.0;
/// Cells of this side, metres, hold the stretches.
const CELL: f64 = 64.0;
/// What rounding may take from a length, metres, or an angle, radians.
const SLACK: f64 = 1e-3;

/// Part of a road: the slim box along it that holds all of the road's places and the pieces between them there.
struct Stretch {
    road: usize,
    /// Whether it lies between the cuts.
    kept: bool,
    half: f64,
    /// Where the road begins and heads, and how far the box reaches from there ahead and to the left.
    origin: Point,
    axis: Vector,
    ahead: [f64; 2],
    left: [f64; 2],
    /// By how much, radians, pieces on and beside the stretch deviate from that heading, and the sine of it.
    spread: f64,
    sine: f64,
    /// The upright box around it.
    bounds: Bounds,
}

impl Stretch {
    /// The part of a line between two stations, with what heads elsewhere between two others.
    fn new(line: &Polyline, stations: &[f64], on: [f64; 2], around: [f64; 2]) -> Self {
        let points = line.points();
        let segment = |s: f64| stations.partition_point(|at| *at < s).clamp(1, points.len() - 1) - 1;
        let [first, last] = on.map(segment);
        let place = |s: f64, i: usize| {
            let part = (s - stations[i]) / (stations[i + 1] - stations[i]);
            points[i] + (points[i + 1] - points[i]) * part.clamp(0.0, 1.0)
        };
        let [origin, end] = [place(on[0], first), place(on[1], last)];
        let axis = (end - origin).try_normalize(Polyline::MERGE).unwrap_or_else(Vector::x);
        let mut stretch = Self {
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
            stretch.ahead = [stretch.ahead[0].min(ahead), stretch.ahead[1].max(ahead)];
            stretch.left = [stretch.left[0].min(left), stretch.left[1].max(left)];
            stretch.bounds = [stretch.bounds[0].inf(p), stretch.bounds[1].sup(p)];
        }
        let headings = (segment(around[0])..=segment(around[1])).map(|i| (points[i + 1] - points[i]).normalize());
        let least = headings.map(|heading| heading.dot(&axis)).fold(1.0, f64::min);
        // Pieces lie between places of the road: they head between its segments where these head one way on the whole.
        if least > 0.0 {
            stretch.spread = least.acos();
            stretch.sine = stretch.spread.sin();
        } else {
            (stretch.spread, stretch.sine) = (std::f64::consts::PI, f64::INFINITY);
        }
        stretch
    }

    /// The upright box around it, this wide on either side.
    fn reach(&self, half: f64) -> Bounds {
        let around = Vector::repeat(half + SLACK);
        [self.bounds[0] - around, self.bounds[1] + around]
    }

    /// Whether a place of it may lie beside a piece of the other that runs as it does, or against it.
    fn may_lie_beside(&self, other: &Self) -> bool {
        let own = self.road == other.road;
        let reach = (self.half + other.half) * if own { TIGHTEST } else { 1.0 } + CLEAR + SLACK;
        let from = self.origin - other.origin;
        // Whether the boxes come so close along an axis.
        let close = |axis: Vector, [low, high]: [f64; 2], margin: f64| {
            let middle = from.dot(&axis);
            let sides = [(self.axis, self.ahead), (left_of(self.axis), self.left)];
            let spans = sides.map(|(side, span)| span.map(|by| by * side.dot(&axis)));
            let least = spans.iter().map(|[a, b]| a.min(*b)).sum::<f64>() + middle;
            let most = spans.iter().map(|[a, b]| a.max(*b)).sum::<f64>() + middle;
            least <= high + margin && low <= most + margin
        };
        // What lies beside a piece lies straight to its left or right; pieces head elsewhere by no more than the spread.
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

/// The stretches of a road: what each intersection cuts off, and those between.
fn stretches(index: usize, road: &Road, kept: Stations) -> Vec<Stretch> {
    let stations = road.line.stations();
    let length = stations[stations.len() - 1];
    let [from, to] = kept.map(|station| station.clamp(0.0, length));
    if to - from <= SHORTEST {
        return Vec::new();
    }
    // Where the place before or behind may be.
    let before = |s: f64| if s - STEP < from { 0.0 } else { s - STEP };
    let behind = |s: f64| if s + STEP > to { length } else { s + STEP };
    let half = road.half_width();
    let stretch = |kept: bool, on: [f64; 2], around: [f64; 2]| Stretch {
        road: index,
        kept,
        half,
        ..Stretch::new(&road.line, &stations, on, around)
    };
    let count = ((to - from) / LONGEST).ceil().min(Polyline::MOST_PIECES) as usize;
    let mark = |i: usize| from + (to - from) * i as f64 / count as f64;
    let between = (0..count).map(|i| [mark(i), mark(i + 1)]);
    let mut all: Vec<Stretch> =
        between.map(|[a, b]| stretch(true, [a, (b + STEP).min(to)], [before(a), behind(behind(b))])).collect();
    if from > 0.0 {
        all.push(stretch(false, [0.0, from], [0.0, behind(from)]));
    }
    if to < length {
        all.push(stretch(false, [to, length], [before(to), length]));
    }
    all
}

/// All roads of which some place may lie beside another road or another leg of the same one, and those others, ascending.
pub fn candidates(network: &RoadNetwork, kept: &[Stations]) -> Vec<usize> {
    /// Roads that one thread takes at a time.
    const CHUNK: usize = 64;
    let of_chunk = |(chunk, (roads, kept)): (usize, (&[Road], &[[f64; 2]]))| -> Vec<Stretch> {
        let roads = roads.iter().zip(kept).zip(chunk * CHUNK..);
        roads.flat_map(|((road, kept), i)| stretches(i, road, *kept)).collect()
    };
    let roads = network.roads.par_chunks(CHUNK).finely().zip(kept.par_chunks(CHUNK).finely()).enumerate();
    let chunks: Vec<Vec<Stretch>> = roads.map(of_chunk).collect();
    let all: Vec<&Stretch> = chunks.iter().flatten().collect();
    // As far as a hairpin's legs may lie apart.
    let around = |stretch: &Stretch| stretch.reach(stretch.half * (2.0 * TIGHTEST - 1.0) + CLEAR);
    let cells = SpatialHash::new(all.iter().map(|stretch| around(stretch)).collect(), CELL);
    let levelled = |a: &Stretch, b: &Stretch| {
        let [a, b] = [a, b].map(|stretch| &network.roads[stretch.road]);
        a.level == b.level || [a.from, a.to].iter().any(|end| [b.from, b.to].contains(end))
    };
    let near = |a: &Stretch, b: &Stretch| a.kept && touch(&around(a), &b.reach(b.half)) && a.may_lie_beside(b);
    let pairs = cells.pairs(|i, j| {
        let [a, b] = [all[i], all[j]];
        (levelled(a, b) && (near(a, b) || near(b, a))).then_some([a.road, b.road])
    });
    let bent = all.par_iter().finely().filter(|stretch| near(stretch, stretch)).map(|stretch| stretch.road);
    let mut likely: Vec<usize> = pairs.into_iter().flatten().collect();
    likely.par_extend(bent);
    sorted(&mut likely);
    likely
}
