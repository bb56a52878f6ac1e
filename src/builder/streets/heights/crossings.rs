//! Finds where roads of different levels cross.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::builder::network::{Road, RoadNetwork, Stations};
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, segment_crossing};
use crate::parallel::Finely;

/// Cell size of the search, metres.
const CELL: f64 = 32.0;
/// Lines that cross this close to a common end, metres, only meet there.
const MEETING: f64 = 1.0;

/// One road above another.
#[derive(Clone, Copy, Debug)]
pub struct Overpass {
    /// The index of the upper road, and the station there, metres.
    pub upper: (usize, f64),
    /// The index of the lower road, and the station there, metres.
    pub lower: (usize, f64),
    /// The difference of their levels.
    pub levels: f64,
    /// The point, local metres.
    pub place: Point,
}

/// A segment of a road.
struct LevelPiece {
    road: usize,
    level: f64,
    segment: usize,
    ends: [Point; 2],
    /// Of its first point, metres.
    station: f64,
}

impl LevelPiece {
    /// The indices of road and segment.
    fn place(&self) -> (usize, usize) {
        (self.road, self.segment)
    }

    fn bounds(&self) -> [Point; 2] {
        let [a, b] = &self.ends;
        [a.inf(b), a.sup(b)]
    }
}

/// All places where one road passes over another. `kept` has the stations between the intersections: roads that meet in one do
/// not cross there.
pub fn overpasses(network: &RoadNetwork, kept: &[Stations]) -> Vec<Overpass> {
    let pieces_of = |road: usize| pieces(road, &network.roads[road]);
    // Of two roads on different levels at least one is off the ground, and these are few.
    let off_ground = (0..network.roads.len()).filter(|road| network.roads[*road].level != 0.0);
    let off_ground: Vec<LevelPiece> = off_ground.flat_map(pieces_of).collect();
    if off_ground.is_empty() {
        return Vec::new();
    }
    let cells = SpatialHash::new(off_ground.iter().map(LevelPiece::bounds).collect(), CELL);
    let crossings_of = |road: usize| {
        let mut found = Vec::new();
        for piece in pieces_of(road) {
            cells.touching(piece.bounds(), |i| found.extend(crossing(&piece, &off_ground[i])));
        }
        found.retain(|(_, crossing)| !meets(network, kept, crossing));
        found
    };
    let mut found: Vec<_> = (0..network.roads.len()).into_par_iter().finely().flat_map_iter(crossings_of).collect();
    found.sort_unstable_by_key(|(places, _)| *places);
    found.dedup_by_key(|(places, _)| *places);
    found.into_iter().map(|(_, crossing)| crossing).collect()
}

/// The crossing of a piece with one off the ground, and which pieces cross. Of two pieces off the ground only the upper one finds
/// it.
fn crossing(piece: &LevelPiece, off_ground: &LevelPiece) -> Option<([(usize, usize); 2], Overpass)> {
    let (upper, lower) = match piece.level.total_cmp(&off_ground.level) {
        Ordering::Greater => (piece, off_ground),
        Ordering::Less if piece.level == 0.0 => (off_ground, piece),
        _ => return None,
    };
    let [[a, b], [c, d]] = [upper.ends, lower.ends];
    let (_, _, place) = segment_crossing(a, b, c, d)?;
    let [above, below] = [upper, lower].map(|piece| (piece.road, piece.station + (place - piece.ends[0]).norm()));
    let levels = upper.level - lower.level;
    Some(([upper.place(), lower.place()], Overpass { upper: above, lower: below, levels, place }))
}

fn pieces(i: usize, road: &Road) -> impl Iterator<Item = LevelPiece> + '_ {
    let mut station = 0.0;
    road.line.segments().enumerate().map(move |(segment, (a, b))| {
        let piece = LevelPiece { road: i, level: road.level, segment, ends: [a, b], station };
        station += (b - a).norm();
        piece
    })
}

/// Whether two roads meet at an intersection where they seem to cross.
fn meets(network: &RoadNetwork, kept: &[Stations], crossing: &Overpass) -> bool {
    let ends = [crossing.upper, crossing.lower].map(|(road, station)| {
        let [from, to] = kept[road];
        let (road, length) = (&network.roads[road], network.roads[road].line.length());
        let near = [station < from.max(MEETING), station > to.min(length - MEETING)];
        [near[0].then_some(road.from), near[1].then_some(road.to)]
    });
    ends[0].iter().flatten().any(|ix| ends[1].contains(&Some(*ix)))
}
