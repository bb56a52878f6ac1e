//! Where roads of different levels pass over each other.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork, Stations};
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, segment_crossing};
use crate::parallel::Finely;

/// Cells of this side, metres, hold the pieces of roads.
const CELL: f64 = 32.0;
/// Two lines that cross so close to where they meet, metres, do not pass over each other.
const MEETING: f64 = 1.0;

/// One road above another.
#[derive(Clone, Copy, Debug)]
pub struct Overpass {
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
struct LevelPiece {
    road: usize,
    segment: usize,
    ends: [Point; 2],
    station: f64,
}

impl LevelPiece {
    /// Which piece of which road it is.
    fn place(&self) -> (usize, usize) {
        (self.road, self.segment)
    }

    fn bounds(&self) -> [Point; 2] {
        let [a, b] = &self.ends;
        [a.inf(b), a.sup(b)]
    }
}

/// All places where one road passes over another, of which `kept` gives the stations between the intersections. Roads of
/// different levels that meet at an intersection do not cross within it.
pub fn overpasses(network: &RoadNetwork, kept: &[Stations]) -> Vec<Overpass> {
    let of_road = |road: usize| pieces(road, &network.roads[road]);
    let level = |piece: &LevelPiece| network.roads[piece.road].level;
    // Of two roads on unlike levels one at least is off the ground, and these are few.
    let off_ground = (0..network.roads.len()).filter(|road| network.roads[*road].level != 0.0);
    let off_ground: Vec<LevelPiece> = off_ground.flat_map(of_road).collect();
    if off_ground.is_empty() {
        return Vec::new();
    }
    let cells = SpatialHash::new(off_ground.iter().map(LevelPiece::bounds).collect(), CELL);
    let crossing = |upper: &LevelPiece, lower: &LevelPiece| {
        let [[a, b], [c, d]] = [upper.ends, lower.ends];
        let (_, _, place) = segment_crossing(a, b, c, d)?;
        let at = |piece: &LevelPiece| (piece.road, piece.station + (place - piece.ends[0]).norm());
        let levels = level(upper) - level(lower);
        let crossing = Overpass { upper: at(upper), lower: at(lower), levels, place };
        (!meets(network, kept, &crossing)).then_some(crossing)
    };
    let of_piece = |piece: &LevelPiece, found: &mut Vec<_>| {
        cells.touching(piece.bounds(), |i| {
            let other = &off_ground[i];
            let pair = match level(piece).total_cmp(&level(other)) {
                Ordering::Greater => Some((piece, other)),
                // Each pair of roads off the ground is seen from above only.
                Ordering::Less if level(piece) == 0.0 => Some((other, piece)),
                _ => None,
            };
            let Some((upper, lower)) = pair else { return };
            found.extend(crossing(upper, lower).map(|crossing| ([upper.place(), lower.place()], crossing)));
        });
    };
    let of_road = |road: usize| {
        let mut found = Vec::new();
        of_road(road).for_each(|piece| of_piece(&piece, &mut found));
        found
    };
    let mut found: Vec<_> = (0..network.roads.len()).into_par_iter().finely().flat_map_iter(of_road).collect();
    found.sort_unstable_by_key(|(places, _)| *places);
    found.dedup_by_key(|(places, _)| *places);
    found.into_iter().map(|(_, crossing)| crossing).collect()
}

fn pieces(i: usize, road: &Road) -> impl Iterator<Item = LevelPiece> + '_ {
    let mut station = 0.0;
    road.line.segments().enumerate().map(move |(segment, (a, b))| {
        let piece = LevelPiece { road: i, segment, ends: [a, b], station };
        station += (b - a).norm();
        piece
    })
}

/// Whether two roads join at an intersection where they seem to cross.
fn meets(network: &RoadNetwork, kept: &[Stations], crossing: &Overpass) -> bool {
    let ends = [crossing.upper, crossing.lower].map(|(road, station)| {
        let [from, to] = kept[road];
        let (road, length) = (&network.roads[road], network.roads[road].line.length());
        let near = [station < from.max(MEETING), station > to.min(length - MEETING)];
        [near[0].then_some(road.from), near[1].then_some(road.to)]
    });
    ends[0].iter().flatten().any(|at| ends[1].contains(&Some(*at)))
}
