//! Finds where roads of different levels cross, or run over each other.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::builder::network::{End, Road, RoadEnd, RoadNetwork, Stations};
use crate::geometry::spatial_hash::SpatialHash;
use crate::geometry::{Point, Vector, segment_crossing};
use crate::parallel::InSmallParts;

use super::options::ROUNDED;

/// Cell size of the search, metres.
const CELL: f64 = 32.0;
/// Lines that cross this close to a common end, metres, only meet there.
const MEETING: f64 = 1.0;
/// Roads that run along each other lie over each other if they overlap by more than this, metres.
const OVERLAP: f64 = 1.0;
/// Within this distance by road, metres, two roads that run along each other may be about to join: a ramp beside its road.
const JOINING: f64 = 200.0;

/// A road has so many places at most at which it lies over or under others, and one more for each [`SPACING`] metres. The rest would
/// be as much work as the square of the roads.
const MOST: usize = 100;
/// Metres of a road for each further place.
const SPACING: f64 = 50.0;

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

/// The places where roads pass over others.
pub struct Overpasses {
    /// In the order of the roads; those of two roads follow each other.
    pub places: Vec<Overpass>,
    /// The roads that have more than are looked at, by their index, each with how many it has and how many are looked at.
    pub too_many: Vec<(usize, [usize; 2])>,
}

/// A segment of a road.
struct LevelPiece {
    road: usize,
    level: f64,
    segment: usize,
    ends: [Point; 2],
    /// Of its first point, metres.
    station: f64,
    half_width: f64,
}

impl LevelPiece {
    /// The indices of road and segment.
    fn place(&self) -> (usize, usize) {
        (self.road, self.segment)
    }

    /// The box around its ground.
    fn bounds(&self) -> [Point; 2] {
        let ([a, b], around) = (&self.ends, Vector::repeat(self.half_width));
        [a.inf(b) - around, a.sup(b) + around]
    }

    /// Points on it, with their stations on the road, one every [`ROUNDED`] metres of the road.
    fn samples(&self) -> impl Iterator<Item = (f64, Point)> + '_ {
        let [a, b] = self.ends;
        let length = (b - a).norm();
        let first = (self.station / ROUNDED).ceil() as usize;
        let stations = (first..).map(|i| i as f64 * ROUNDED - self.station).take_while(move |along| *along < length);
        stations.map(move |along| (self.station + along, a + (b - a) * (along / length)))
    }

    /// The station, metres, and the distance of the nearest point on it, if a perpendicular leads there.
    fn beside(&self, point: Point) -> Option<(f64, f64)> {
        let [a, b] = self.ends;
        let along = (b - a).dot(&(point - a)) / (b - a).norm_squared();
        let foot = a + (b - a) * along;
        (0.0..=1.0).contains(&along).then(|| (self.station + (foot - a).norm(), (point - foot).norm()))
    }
}

/// All places where one road passes over another. `kept` has the stations between the intersections: roads that meet in one do
/// not cross there. Where one runs along above the other there is a place every [`ROUNDED`] metres.
pub fn overpasses(network: &RoadNetwork, kept: &[Stations]) -> Overpasses {
    let pieces_of = |road: usize| pieces(road, &network.roads[road]);
    // Of two roads on different levels at least one is off the ground, and these are few.
    let off_ground = (0..network.roads.len()).filter(|road| network.roads[*road].level != 0.0);
    let off_ground: Vec<LevelPiece> = off_ground.flat_map(pieces_of).collect();
    if off_ground.is_empty() {
        return Overpasses { places: Vec::new(), too_many: Vec::new() };
    }
    let cells = SpatialHash::new(off_ground.iter().map(LevelPiece::bounds).collect(), CELL);
    let crossings_of = |road: usize| {
        let most = MOST + (network.roads[road].line.length() / SPACING) as usize;
        let (mut found, mut count) = (Vec::new(), 0);
        for piece in pieces_of(road) {
            cells.touching(piece.bounds(), |i| {
                let Some([upper, lower]) = by_level(&piece, &off_ground[i]) else { return };
                let mut add = |crossing| {
                    count += 1;
                    if found.len() < most {
                        found.push(([upper.place(), lower.place()], crossing));
                    }
                };
                match crossing(upper, lower) {
                    Some(crossing) if meets(network, kept, &crossing) => {}
                    Some(crossing) => add(crossing),
                    None => runs_along(upper, lower).filter(|place| !joins(network, place)).for_each(add),
                }
            });
        }
        (found, (count > most).then_some((road, [count, most])))
    };
    let of_roads: Vec<_> = (0..network.roads.len()).into_par_iter().in_small_parts().map(crossings_of).collect();
    let too_many = of_roads.iter().filter_map(|(_, too_many)| *too_many).collect();
    let mut found: Vec<_> = of_roads.into_iter().flat_map(|(found, _)| found).collect();
    let order = |[upper, lower]: [(usize, usize); 2]| ([upper.0, lower.0], [upper.1, lower.1]);
    found.sort_unstable_by(|(a, first), (b, second)| {
        order(*a).cmp(&order(*b)).then(first.upper.1.total_cmp(&second.upper.1))
    });
    found.dedup_by_key(|(places, crossing)| (*places, crossing.upper.1.to_bits()));
    Overpasses { places: found.into_iter().map(|(_, crossing)| crossing).collect(), too_many }
}

/// The upper and the lower one of a piece and one off the ground. Of two pieces off the ground only the upper one finds the pair.
fn by_level<'a>(piece: &'a LevelPiece, off_ground: &'a LevelPiece) -> Option<[&'a LevelPiece; 2]> {
    match piece.level.total_cmp(&off_ground.level) {
        Ordering::Greater => Some([piece, off_ground]),
        Ordering::Less if piece.level == 0.0 => Some([off_ground, piece]),
        _ => None,
    }
}

/// Where the lines of two pieces cross.
fn crossing(upper: &LevelPiece, lower: &LevelPiece) -> Option<Overpass> {
    let [[a, b], [c, d]] = [upper.ends, lower.ends];
    let (_, _, place) = segment_crossing(a, b, c, d)?;
    let [above, below] = [upper, lower].map(|piece| (piece.road, piece.station + (place - piece.ends[0]).norm()));
    Some(Overpass { upper: above, lower: below, levels: upper.level - lower.level, place })
}

/// Places at which the ground of one piece lies over that of another although their lines do not cross.
fn runs_along<'a>(upper: &'a LevelPiece, lower: &'a LevelPiece) -> impl Iterator<Item = Overpass> + 'a {
    let reach = upper.half_width + lower.half_width - OVERLAP;
    upper.samples().filter_map(move |(station, place)| {
        let (below, distance) = lower.beside(place)?;
        let [upper_at, lower_at] = [(upper.road, station), (lower.road, below)];
        let levels = upper.level - lower.level;
        (distance < reach).then_some(Overpass { upper: upper_at, lower: lower_at, levels, place })
    })
}

fn pieces(i: usize, road: &Road) -> impl Iterator<Item = LevelPiece> + '_ {
    let mut station = 0.0;
    road.line.segments().enumerate().map(move |(segment, (a, b))| {
        let (level, half_width) = (road.level, road.half_width());
        let piece = LevelPiece { road: i, level, segment, ends: [a, b], station, half_width };
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

/// Whether the way by road from one of two roads to the other is short: they meet, or one road connects them.
fn joins(network: &RoadNetwork, Overpass { upper, lower, .. }: &Overpass) -> bool {
    let ends = |(road, station): (usize, f64)| {
        let own = &network.roads[road];
        [(own.from, station, End::Start), (own.to, own.line.length() - station, End::End)]
    };
    let lower_ends = ends(*lower);
    let near = |ix, passed: f64| lower_ends.iter().any(|(end, rest, _)| *end == ix && passed + rest < JOINING);
    ends(*upper).into_iter().any(|(ix, rest, own)| {
        let arms = network.intersection(ix).arms.iter().filter(|arm| (arm.road.position(), arm.end) != (upper.0, own));
        let over = |arm: &RoadEnd| {
            let road = network.road(arm.road);
            near(road.intersection(arm.end.other()), rest + road.line.length())
        };
        rest < JOINING && (near(ix, rest) || arms.into_iter().any(over))
    })
}
