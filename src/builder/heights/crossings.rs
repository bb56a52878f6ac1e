//! Where roads of different levels pass over each other.

use rayon::prelude::*;

use crate::builder::road_network::{Road, RoadNetwork};
use crate::geometry::cells::Cells;
use crate::geometry::{Point, segment_crossing};

/// Cells of this side, metres, hold the pieces of roads.
const CELL: f64 = 32.0;
/// Two lines that cross so close to where they meet, metres, do not pass over each other.
const MEETING: f64 = 1.0;

/// One road above another.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// The upper road, by its place in the network, and the station there.
    pub upper: (usize, f64),
    /// The lower road, and the station there.
    pub lower: (usize, f64),
    /// How many levels lie between them.
    pub levels: f64,
    /// Where.
    pub place: Point,
}

/// One straight piece of a road, from a station on.
struct Piece {
    road: usize,
    ends: [Point; 2],
    station: f64,
}

impl Piece {
    fn bounds(&self) -> [Point; 2] {
        let [a, b] = &self.ends;
        [a.inf(b), a.sup(b)]
    }
}

/// All places where one road passes over another, of which `kept` gives the stations between the intersections. Roads of
/// different levels that meet at an intersection do not cross within it.
pub fn crossings(network: &RoadNetwork, kept: &[[f64; 2]]) -> Vec<Crossing> {
    if network.roads.iter().all(|road| road.level == 0.0) {
        return Vec::new();
    }
    let pieces: Vec<Piece> = network.roads.iter().enumerate().flat_map(|(i, road)| pieces(i, road)).collect();
    let cells = Cells::new(pieces.iter().map(Piece::bounds).collect(), CELL);
    let level = |piece: &Piece| network.roads[piece.road].level;
    let lowest = network.roads.iter().map(|road| road.level).fold(f64::INFINITY, f64::min);
    let crossing = |upper: &Piece, lower: &Piece| {
        let levels = level(upper) - level(lower);
        // One of two roads on the ground is never the upper one, and each pair is seen from above only.
        if levels <= 0.0 {
            return None;
        }
        let [[a, b], [c, d]] = [upper.ends, lower.ends];
        let (_, _, place) = segment_crossing(a, b, c, d)?;
        let at = |piece: &Piece| (piece.road, piece.station + (place - piece.ends[0]).norm());
        let crossing = Crossing { upper: at(upper), lower: at(lower), levels, place };
        (!meets(network, kept, &crossing)).then_some(crossing)
    };
    let above_others = pieces.par_iter().filter(|piece| level(piece) > lowest);
    let found = above_others.flat_map_iter(|upper| {
        let mut below: Vec<usize> = Vec::new();
        cells.touching(upper.bounds(), |i| below.push(i));
        below.sort_unstable();
        below.dedup();
        below.into_iter().filter_map(|i| crossing(upper, &pieces[i])).collect::<Vec<_>>()
    });
    found.collect()
}

fn pieces(i: usize, road: &Road) -> impl Iterator<Item = Piece> + '_ {
    let segments = road.line.segments().zip(road.line.stations());
    segments.map(move |((a, b), station)| Piece { road: i, ends: [a, b], station })
}

/// Whether two roads join at an intersection where they seem to cross.
fn meets(network: &RoadNetwork, kept: &[[f64; 2]], crossing: &Crossing) -> bool {
    let ends = [crossing.upper, crossing.lower].map(|(road, station)| {
        let [from, to] = kept[road];
        let (road, length) = (&network.roads[road], network.roads[road].line.length());
        let near = [station < from.max(MEETING), station > to.min(length - MEETING)];
        [near[0].then_some(road.from), near[1].then_some(road.to)]
    });
    ends[0].iter().flatten().any(|at| ends[1].contains(&Some(*at)))
}
