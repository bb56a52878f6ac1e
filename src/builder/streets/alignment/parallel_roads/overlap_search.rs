//! Finds the places of roads beside which other roads run, in the same or the opposite direction.

use std::collections::hash_map::Entry;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::streets::alignment::side_order::SideHints;
use crate::builder::streets::alignment::{INNER_RADIUS, TIGHTEST};
use crate::geometry::spatial_hash::{Bounds, SpatialHash, touch};
use crate::geometry::{Point, Vector, cross};
use crate::parallel::InSmallParts;

use super::shifted_road::{GAP_BETWEEN, ShiftedRoad, TOLERANCE};

/// Cosine of the largest angle between roads that run side by side: 40 degrees.
pub const PARALLEL: f64 = 0.77;
/// Cell size of the search, metres: some pieces of a road and half its width to either side.
const CELL: f64 = 64.0;

/// A stretch of a road of [`PIECES`] pieces is held against at most this number of stretches beside it; on 20 extracts of real streets
/// there are 18 at most.
pub const MOST_BESIDE: usize = 60;
/// Most pieces in a group.
const PIECES: usize = 8;

/// A place of a road beside another road.
pub struct AdjacentPlace {
    /// Its index among the places of its road.
    pub index: usize,
    /// The index of the first of the two places of the other road between which it lies.
    pub beside: usize,
    /// Signed distance of the other road, metres, left positive.
    pub offset: f64,
    /// Whether both roads run in the same direction.
    pub same_direction: bool,
}

impl AdjacentPlace {
    /// Whether its road is nearer than another, or as near on the other side: then the left one counts.
    fn is_nearer(&self, other: &Self) -> bool {
        let (distance, least) = (self.offset.abs(), other.offset.abs());
        distance < least || (distance == least && self.offset > other.offset)
    }
}

/// The places of the first road that lie beside the second, by ordered pair of roads.
pub type Adjacency = FxHashMap<(usize, usize), Vec<AdjacentPlace>>;

/// The segment of a road between two neighbouring places.
struct LinePiece {
    road: usize,
    /// The first of the places.
    first: usize,
    ends: [Point; 2],
    /// Unit vector; `None` if the ends coincide.
    direction: Option<Vector>,
    /// The bounding box of what the road covers there.
    covered: Bounds,
}

impl LinePiece {
    /// The bounding box, widened by `half` metres.
    fn bounds(&self, half: f64) -> Bounds {
        widened(self.ends, half)
    }
}

/// The bounding box of two points, widened by `half` metres.
fn widened([p, q]: [Point; 2], half: f64) -> Bounds {
    let m = Vector::repeat(half);
    [p.inf(&q) - m, p.sup(&q) + m]
}

/// A place of a road with the direction of the road there.
#[derive(Clone, Copy)]
struct PlacePose {
    index: usize,
    point: Point,
    direction: Vector,
}

impl PlacePose {
    fn new(road: &ShiftedRoad, index: usize) -> Option<Self> {
        let (before, after) = (road.place(index.saturating_sub(1)), road.place((index + 1).min(road.base.len() - 1)));
        Some(Self { index, point: road.place(index), direction: (after - before).try_normalize(0.0)? })
    }
}

/// Neighbouring pieces of one road.
struct PieceGroup<'a> {
    pieces: &'a [LinePiece],
    bounds: Bounds,
    /// Mean direction, and the largest deviation from it on and beside the pieces, radians.
    axis: Vector,
    spread: f64,
}

impl<'a> PieceGroup<'a> {
    /// The pieces of one road in groups, with bounding boxes widened by `half` metres.
    fn of_road(road: &'a [LinePiece], half: f64) -> impl Iterator<Item = Self> + 'a {
        road.chunks(PIECES).enumerate().filter_map(move |(i, pieces)| {
            let bounds = pieces.iter().map(|piece| piece.bounds(half));
            let bounds = bounds.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])])?;
            let start = i * PIECES;
            let around = &road[start.saturating_sub(1)..(start + pieces.len() + 1).min(road.len())];
            let directions = || around.iter().filter_map(|piece| piece.direction);
            let axis = directions().sum::<Vector>().try_normalize(f64::EPSILON).unwrap_or_else(Vector::x);
            let least = directions().map(|direction| direction.dot(&axis)).fold(1.0, f64::min);
            Some(Self { pieces, bounds, axis, spread: least.max(-1.0).acos() })
        })
    }

    /// Whether no piece of one group is parallel to a piece of the other, by [`PARALLEL`].
    fn crosses(&self, other: &Self) -> bool {
        let between = self.axis.dot(&other.axis).abs().min(1.0).acos();
        between - self.spread - other.spread > PARALLEL.acos()
    }
}

/// The search for roads that run side by side.
pub struct OverlapSearch<'a> {
    pub roads: &'a FxHashMap<usize, ShiftedRoad>,
    pub hints: &'a SideHints,
    /// The first road that lies beside more others than are held against it; `usize::MAX` if none does.
    pub crowded: &'a AtomicUsize,
}

impl OverlapSearch<'_> {
    /// The places of the `active` roads that lie beside roads in `nearby`.
    pub fn find(&self, active: &[usize], nearby: &[usize]) -> Adjacency {
        /// Roads that one thread takes at a time.
        const CHUNK: usize = 16;
        let chunks: Vec<Vec<LinePiece>> =
            nearby.par_chunks(CHUNK).in_small_parts().map(|roads| self.pieces_of(roads)).collect();
        let roads = chunks.par_iter().in_small_parts().flat_map_iter(|chunk| chunk.chunk_by(|a, b| a.road == b.road));
        let groups: Vec<PieceGroup> =
            roads.flat_map_iter(|road| PieceGroup::of_road(road, self.roads[&road[0].road].half)).collect();
        let cells = SpatialHash::new(groups.iter().map(|group| group.bounds).collect(), CELL);
        let active = active
            .par_chunks(CHUNK)
            .in_small_parts()
            .map(|roads| self.find_in(&self.pieces_of(roads), &groups, &cells));
        active.collect::<Vec<_>>().into_iter().flatten().collect()
    }

    /// The pieces of the roads that may move.
    fn pieces_of(&self, roads: &[usize]) -> Vec<LinePiece> {
        roads.iter().filter(|road| self.roads[*road].kept.is_some()).flat_map(|road| self.pieces(*road)).collect()
    }

    fn pieces(&self, index: usize) -> impl Iterator<Item = LinePiece> {
        let road = &self.roads[&index];
        let mut end = road.place(0);
        (0..road.base.len() - 1).map(move |first| {
            let ends = [end, road.place(first + 1)];
            end = ends[1];
            let direction = (ends[1] - ends[0]).try_normalize(0.0);
            LinePiece { road: index, first, ends, direction, covered: widened(ends, road.half) }
        })
    }

    fn find_in(&self, active: &[LinePiece], groups: &[PieceGroup], cells: &SpatialHash) -> Adjacency {
        let mut nearest = FxHashMap::default();
        for pieces in active.chunk_by(|a, b| a.road == b.road) {
            let bends = bends(pieces);
            let road = &self.roads[&pieces[0].road];
            for group in PieceGroup::of_road(pieces, road.half + search_margin(road)) {
                let mut beside = 0;
                cells.touching(group.bounds, |other| {
                    let other = &groups[other];
                    let is_own = other.pieces.first().is_some_and(|other| other.road == pieces[0].road);
                    if (is_own && !bends) || group.crosses(other) {
                        return;
                    }
                    beside += 1;
                    if beside <= MOST_BESIDE {
                        self.compare_groups(group.pieces, other.pieces, &mut nearest);
                    } else {
                        self.crowded.fetch_min(pieces[0].road, Ordering::Relaxed);
                    }
                });
            }
        }
        let mut adjacency = Adjacency::default();
        for ((a, b, _), place) in nearest {
            adjacency.entry((a, b)).or_default().push(place);
        }
        adjacency.values_mut().for_each(|places| places.sort_by_key(|place| place.index));
        adjacency
    }

    /// Keeps for each place of the first group the nearest piece of the second.
    fn compare_groups(
        &self,
        pieces: &[LinePiece],
        others: &[LinePiece],
        nearest: &mut FxHashMap<(usize, usize, usize), AdjacentPlace>,
    ) {
        let [Some(a), Some(b)] = [pieces, others].map(|pieces| pieces.first().map(|piece| piece.road)) else { return };
        let (road, neighbour) = (&self.roads[&a], &self.roads[&b]);
        if neighbour.level != road.level && !self.meet(a, b) {
            return;
        }
        for (pose, other, direction) in candidates(road, pieces, neighbour, others) {
            let Some(found) = compare(road, &pose, neighbour, other, direction) else { continue };
            match nearest.entry((a, b, pose.index)) {
                Entry::Occupied(best) if !found.is_nearer(best.get()) => {}
                entry => drop(entry.insert_entry(found)),
            }
        }
    }

    /// Whether two roads share an intersection where they run side by side.
    fn meet(&self, a: usize, b: usize) -> bool {
        self.hints.get(&(a, b)).is_some_and(|hints| hints.iter().any(|hint| hint.meets.is_some()))
    }
}

/// How far beyond its edges neighbours of a road are searched, metres: the legs of a hairpin may lie farther apart.
fn search_margin(road: &ShiftedRoad) -> f64 {
    legs_apart(road.half) - 2.0 * road.half + GAP_BETWEEN
}

/// Whether some pieces of a road may run against others. If none deviates by 69 degrees from the first, no two deviate by the
/// 140 degrees of [`PARALLEL`].
fn bends(road: &[LinePiece]) -> bool {
    const DEVIATION: f64 = 0.36;
    let mut directions = road.iter().filter_map(|piece| piece.direction);
    directions.next().is_some_and(|first| directions.any(|direction| direction.dot(&first) < DEVIATION))
}

/// The places of one road with the pieces of another that are near and parallel, and the directions of these. A road does not
/// run beside itself in the same direction.
fn candidates<'a>(
    road: &'a ShiftedRoad,
    pieces: &'a [LinePiece],
    neighbour: &'a ShiftedRoad,
    others: &'a [LinePiece],
) -> impl Iterator<Item = (PlacePose, &'a LinePiece, Vector)> {
    let is_own = std::ptr::eq(road, neighbour);
    pieces.iter().flat_map(move |piece| {
        let bounds = piece.bounds(road.half + search_margin(road));
        let near = others.iter().filter(move |other| touch(&other.covered, &bounds));
        let mut near = near.filter_map(|other| Some((other, other.direction?))).peekable();
        // Most pieces have none.
        let pose = |k: usize| PlacePose::new(road, k).filter(|_| road.is_kept(k));
        let poses = near.peek().map_or([None; 2], |_| [piece.first, piece.first + 1].map(pose));
        near.flat_map(move |(other, direction)| {
            let parallel = poses.into_iter().flatten().filter(move |pose| {
                let cosine = pose.direction.dot(&direction);
                cosine <= -PARALLEL || (cosine >= PARALLEL && !is_own)
            });
            parallel.map(move |pose| (pose, other, direction))
        })
    })
}

/// Least distance between the lines of two roads, metres; or between the legs of one hairpin, which turns between them.
pub fn least_distance(a: &ShiftedRoad, b: &ShiftedRoad) -> f64 {
    (if std::ptr::eq(a, b) { legs_apart(a.half) } else { a.half + b.half }) + GAP_BETWEEN
}

/// Least distance between the lines of the legs of a hairpin, metres, for a road of `half` metres to either side.
pub fn legs_apart(half: f64) -> f64 {
    2.0 * (half * TIGHTEST).max(half + INNER_RADIUS)
}

/// A place of road `a` beside a piece of road `b` with this direction; `None` if they do not overlap there.
fn compare(
    a: &ShiftedRoad,
    pose: &PlacePose,
    b: &ShiftedRoad,
    piece: &LinePiece,
    direction: Vector,
) -> Option<AdjacentPlace> {
    let (p, j) = (pose.point, piece.first);
    let [q, r] = piece.ends;
    let length = (r - q).norm();
    let t = (p - q).dot(&direction);
    // Beyond the end of a road nothing is beside it. A place beyond the end of a piece is beside the vertex there only if it is
    // neither beside nor beyond the next piece.
    if t < -TOLERANCE && (j == 0 || (p - b.place(j)).dot(&(b.place(j) - b.place(j - 1))) < 0.0) {
        return None;
    }
    if t > length + TOLERANCE && (j + 2 == b.base.len() || (p - r).dot(&(b.place(j + 2) - r)) > 0.0) {
        return None;
    }
    let foot = q + direction * t.clamp(0.0, length);
    let distance = (p - foot).norm();
    if distance >= least_distance(a, b) {
        return None;
    }
    let offset = if cross(pose.direction, foot - p) < 0.0 { -distance } else { distance };
    Some(AdjacentPlace { index: pose.index, beside: j, offset, same_direction: pose.direction.dot(&direction) > 0.0 })
}
