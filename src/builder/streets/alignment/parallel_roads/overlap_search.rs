//! Which places of roads lie beside which other roads, that run as they do or against them.

use std::collections::hash_map::Entry;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::streets::alignment::TIGHTEST;
use crate::builder::streets::alignment::side_order::Sides;
use crate::geometry::spatial_hash::{Bounds, SpatialHash, touch};
use crate::geometry::{Point, Vector, cross};
use crate::parallel::Finely;

use super::carriageway_edges::{CLEAR, CarriagewayEdges, TOLERANCE};

/// Roads whose directions differ by more than this cosine tells cross each other; they do not run abreast. 40 degrees.
pub const PARALLEL: f64 = 0.77;
/// Cells of this side, metres, hold stretches of roads: some pieces and half their width to either side.
const CELL: f64 = 64.0;
/// One place of a road beside another road.
pub struct OverlapSearch {
    pub place: usize,
    /// Signed distance of the other road, left positive.
    pub offset: f64,
    /// Whether both run the same way.
    pub along: bool,
}

/// A piece of a road between two neighbouring places.
struct Piece {
    road: usize,
    /// The first of the places.
    first: usize,
    ends: [Point; 2],
    /// Unit direction; `None` where the ends are one.
    along: Option<Vector>,
}

impl Piece {
    /// The box around the piece, this wide on either side.
    fn reach(&self, half: f64) -> Bounds {
        let [p, q] = self.ends;
        let m = Vector::repeat(half);
        [p.inf(&q) - m, p.sup(&q) + m]
    }
}

/// The pieces of a road.
fn pieces(tracks: &FxHashMap<usize, CarriagewayEdges>, road: usize) -> impl Iterator<Item = Piece> + '_ {
    let track = &tracks[&road];
    let mut end = track.place(0);
    (0..track.base.len() - 1).map(move |first| {
        let ends = [end, track.place(first + 1)];
        end = ends[1];
        Piece { road, first, ends, along: (ends[1] - ends[0]).try_normalize(0.0) }
    })
}

/// Where a road is, and where it heads, at one of its places.
struct Spot {
    place: usize,
    point: Point,
    along: Vector,
}

impl Spot {
    fn new(track: &CarriagewayEdges, place: usize) -> Option<Self> {
        let (before, after) =
            (track.place(place.saturating_sub(1)), track.place((place + 1).min(track.base.len() - 1)));
        Some(Self { place, point: track.place(place), along: (after - before).try_normalize(0.0)? })
    }
}

/// How far around a road its neighbours are looked for: the legs of a hairpin of its own may lie farther apart.
fn searched(track: &CarriagewayEdges) -> f64 {
    track.half * 2.0 * (TIGHTEST - 1.0) + CLEAR
}

/// Neighbouring pieces of one road, which are sought together.
struct Stretch<'a> {
    pieces: &'a [Piece],
    /// The box around them and half their road's width.
    reach: Bounds,
    /// Where they head, and by how much, radians, the road deviates from that on and beside them.
    axis: Vector,
    spread: f64,
}

impl<'a> Stretch<'a> {
    /// The stretches of the pieces of one road, this wide on either side.
    fn of_road(road: &'a [Piece], half: f64) -> impl Iterator<Item = Self> + 'a {
        /// Pieces of a stretch at most.
        const PIECES: usize = 8;
        road.chunks(PIECES).enumerate().filter_map(move |(i, pieces)| {
            let reaches = pieces.iter().map(|piece| piece.reach(half));
            let reach = reaches.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])])?;
            let start = i * PIECES;
            let headings = || {
                let around = &road[start.saturating_sub(1)..(start + pieces.len() + 1).min(road.len())];
                around.iter().filter_map(|piece| piece.along)
            };
            let axis = headings().sum::<Vector>().try_normalize(f64::EPSILON).unwrap_or_else(Vector::x);
            let least = headings().map(|along| along.dot(&axis)).fold(1.0, f64::min);
            Some(Self { pieces, reach, axis, spread: least.max(-1.0).acos() })
        })
    }

    /// Whether no place of one can run as a piece of the other does, or against it, by [`PARALLEL`].
    fn crosses(&self, other: &Self) -> bool {
        let between = self.axis.dot(&other.axis).abs().min(1.0).acos();
        between - self.spread - other.spread > PARALLEL.acos()
    }
}

/// For each ordered pair of roads that overlap lengthwise: the places of the first that lie beside the second.
/// Only roads of `hot` are compared, with all of `near`.
pub fn find(
    tracks: &FxHashMap<usize, CarriagewayEdges>,
    sides: &Sides,
    hot: &[usize],
    near: &[usize],
) -> FxHashMap<(usize, usize), Vec<OverlapSearch>> {
    /// Roads that one thread takes at a time.
    const CHUNK: usize = 16;
    let worth = |road: &&usize| tracks[*road].kept.is_some();
    let of_chunk =
        |roads: &[usize]| roads.iter().filter(worth).flat_map(|&road| pieces(tracks, road)).collect::<Vec<Piece>>();
    let chunks: Vec<Vec<Piece>> = near.par_chunks(CHUNK).finely().map(of_chunk).collect();
    let roads = chunks.par_iter().finely().flat_map_iter(|chunk| chunk.chunk_by(|a, b| a.road == b.road));
    let near: Vec<Stretch> = roads.flat_map_iter(|road| Stretch::of_road(road, tracks[&road[0].road].half)).collect();
    let cells = SpatialHash::new(near.iter().map(|stretch| stretch.reach).collect(), CELL);
    let found: Vec<_> =
        hot.par_chunks(CHUNK).finely().map(|hot| find_in(tracks, sides, &of_chunk(hot), &near, &cells)).collect();
    found.into_iter().flatten().collect()
}

/// As [`find`], with the pieces of some hot roads and those of all roads of `near` in cells.
fn find_in(
    tracks: &FxHashMap<usize, CarriagewayEdges>,
    sides: &Sides,
    hot: &[Piece],
    near: &[Stretch],
    cells: &SpatialHash,
) -> FxHashMap<(usize, usize), Vec<OverlapSearch>> {
    let mut nearest: FxHashMap<(usize, usize, usize), (f64, OverlapSearch)> = FxHashMap::default();
    for road in hot.chunk_by(|a, b| a.road == b.road) {
        let bends = bends(road);
        let track = &tracks[&road[0].road];
        for stretch in Stretch::of_road(road, track.half + searched(track)) {
            cells.touching(stretch.reach, |at| {
                let others = near[at].pieces;
                let own = others.first().is_some_and(|other| other.road == road[0].road);
                if (!own || bends) && !stretch.crosses(&near[at]) {
                    compare_all(tracks, sides, stretch.pieces, others, &mut nearest);
                }
            });
        }
    }
    let mut pairs: FxHashMap<(usize, usize), Vec<OverlapSearch>> = FxHashMap::default();
    for ((a, b, _), (_, beside)) in nearest {
        pairs.entry((a, b)).or_default().push(beside);
    }
    pairs.values_mut().for_each(|list| list.sort_by_key(|beside| beside.place));
    pairs
}

/// Whether some pieces of a road may run against others. Where none deviates from the first by 69 degrees, no two do by
/// the 140 of [`PARALLEL`].
fn bends(road: &[Piece]) -> bool {
    const DEVIATION: f64 = 0.36;
    let mut along = road.iter().filter_map(|piece| piece.along);
    along.next().is_some_and(|first| along.any(|along| along.dot(&first) < DEVIATION))
}

/// Compares pieces of one road with pieces of another; of each place, what lies nearest is kept.
fn compare_all(
    tracks: &FxHashMap<usize, CarriagewayEdges>,
    sides: &Sides,
    pieces: &[Piece],
    others: &[Piece],
    nearest: &mut FxHashMap<(usize, usize, usize), (f64, OverlapSearch)>,
) {
    let [Some(a), Some(b)] = [pieces, others].map(|pieces| pieces.first().map(|piece| piece.road)) else { return };
    let (track, neighbour) = (&tracks[&a], &tracks[&b]);
    if neighbour.level != track.level && !meet(sides, a, b) {
        return;
    }
    for piece in pieces {
        let reach = piece.reach(track.half + searched(track));
        let spots = [piece.first, piece.first + 1].map(|k| Spot::new(track, k).filter(|_| track.is_kept(k)));
        if spots.iter().all(Option::is_none) {
            continue;
        }
        for other in others.iter().filter(|other| touch(&other.reach(neighbour.half), &reach)) {
            let Some(along) = other.along else { continue };
            // Most that lies near is the road itself, or crosses it.
            let abreast = |spot: &&Spot| {
                let same = spot.along.dot(&along);
                same <= -PARALLEL || (same >= PARALLEL && a != b)
            };
            for spot in spots.iter().flatten().filter(abreast) {
                let Some((distance, beside)) = compare(track, spot, neighbour, other, along) else { continue };
                match nearest.entry((a, b, spot.place)) {
                    Entry::Occupied(mut e) => {
                        let closer =
                            distance < e.get().0 || (distance == e.get().0 && beside.offset > e.get().1.offset);
                        if closer {
                            e.insert((distance, beside));
                        }
                    }
                    Entry::Vacant(e) => {
                        e.insert((distance, beside));
                    }
                }
            }
        }
    }
}

/// How far apart the lines of two roads must lie, or those of the legs of one hairpin, which turns between them.
pub fn apart(a: &CarriagewayEdges, b: &CarriagewayEdges) -> f64 {
    let turn = if std::ptr::eq(a, b) { TIGHTEST } else { 1.0 };
    (a.half + b.half) * turn + CLEAR
}

/// A place of one road against a piece of another that runs `along` as it does, or against it: the distance, if they
/// overlap there.
fn compare(
    a: &CarriagewayEdges,
    spot: &Spot,
    b: &CarriagewayEdges,
    piece: &Piece,
    along: Vector,
) -> Option<(f64, OverlapSearch)> {
    let (p, j) = (spot.point, piece.first);
    let [q, r] = piece.ends;
    let length = (r - q).norm();
    let t = (p - q).dot(&along);
    // Beyond its end a road is nowhere beside; and what lies beyond the end of a piece is beside its vertex only if it
    // does not lie beside, or beyond, the piece behind the vertex.
    if t < -TOLERANCE && (j == 0 || (p - b.place(j)).dot(&(b.place(j) - b.place(j - 1))) < 0.0) {
        return None;
    }
    if t > length + TOLERANCE && (j + 2 == b.base.len() || (p - r).dot(&(b.place(j + 2) - r)) > 0.0) {
        return None;
    }
    let foot = q + along * t.clamp(0.0, length);
    let distance = (p - foot).norm();
    if distance >= apart(a, b) {
        return None;
    }
    let offset = if cross(spot.along, foot - p) < 0.0 { -distance } else { distance };
    Some((distance, OverlapSearch { place: spot.place, offset, along: spot.along.dot(&along) > 0.0 }))
}

/// Whether two roads share an intersection where they run abreast.
fn meet(sides: &Sides, a: usize, b: usize) -> bool {
    sides.get(&(a, b)).is_some_and(|told| told.iter().any(|t| t.meets.is_some()))
}
