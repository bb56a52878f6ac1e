//! Moves roads that overlap lengthwise side by side.
//!
//! OpenStreetMap draws a ramp from the middle of the road it leaves, and the carriageways of a divided road only about where
//! they are. Widened to their lanes, such roads overlap far from any intersection. Here both move sideways, the narrower one
//! more, until their edges touch. One that lies between two others that both overlap it stays, and they move.

mod broad_phase;
mod overlap_search;
mod recheck;
mod shifted_road;
mod sides;
#[cfg(test)]
mod tests;

use crate::builder::network::{Road, RoadKey, RoadNetwork, Stations};
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::{Point, Polyline};
use crate::parallel::InSmallParts;

use super::side_order::side_hints;
use super::{eased, set_line};
use broad_phase::candidates;
use overlap_search::{Adjacency, AdjacentPlace, MOST_BESIDE, OverlapSearch, least_distance};
use recheck::{Surroundings, sort_unique};
use shifted_road::{PLACE_STEP, ShiftedRoad, ShiftedRoads, TOLERANCE, normals, places};
use sides::Sides;

use std::sync::atomic::AtomicUsize;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// A place of a moved road within this distance, metres, of the line through its neighbours is no vertex of it.
const ON_LINE: f64 = 0.001;
/// The side of the squares in which that is decided, metres.
const STRAIGHT_WITHIN: f64 = 25.0;
/// Places that lie nearer, metres, to a vertex of the line do not become vertices.
const APART: f64 = 0.5;
/// Most rounds; remaining overlaps stay. The first passes on all that it moves: in it a place depends on those up to 83 m away, because
/// the farthest shift is led back over 58 m at the steepest slope, 12 m lie between the middles of wide roads, and a road is squeezed
/// by those within 13 m. In later ones it is moved because of places within 10 m, and depends on those up to 35 m away.
const ROUNDS: usize = 9;

/// Roads that lie beside others may have so many places for each vertex of the network, or [`LEAST_PLACES`]; those of campo_grande, a
/// city, have two.
const PLACES_OF_VERTEX: usize = 12;
/// The same for small networks.
const LEAST_PLACES: usize = 60_000;

/// The network with overlapping roads moved side by side. `kept` has the stations between which each road remains: within the
/// intersections roads may overlap. The finding tells of a road beside too many others, or that there are too many to move any.
#[must_use]
pub fn lay_side_by_side(mut network: RoadNetwork, kept: &[Stations]) -> (RoadNetwork, Option<Finding>) {
    let (hints, mut active) = rayon::join(|| side_hints(&network), || candidates(&network, kept));
    if let Some(finding) = too_long(&network, &active) {
        return (network, Some(finding));
    }
    let mut roads = ShiftedRoads { network: &network, kept, made: FxHashMap::default() };
    roads.make(&active);
    let crowded = AtomicUsize::new(usize::MAX);
    let mut adjacency = OverlapSearch { roads: &roads.made, hints: &hints, crowded: &crowded }.find(&active, &active);
    let sides = Sides::new(&roads.made, &hints, &adjacency);
    let mut surroundings = None;
    for round in 1..=ROUNDS {
        let passes_on = round == 1;
        let mut targets = targets(&roads.made, &sides, &adjacency);
        if !passes_on {
            targets.iter_mut().for_each(|(road, target)| roads.of(*road).keep_near(target));
            targets.retain(|(road, target)| roads.of(*road).shift != *target);
        }
        if targets.is_empty() {
            break;
        }
        let mut moved: Vec<usize> = targets.iter().map(|(road, _)| *road).collect();
        for (road, target) in targets {
            roads.of(road).shift_to(&target);
        }
        if passes_on {
            moved.extend(align_ends(&mut roads));
        }
        sort_unique(&mut moved);
        if round < ROUNDS {
            let surroundings = surroundings.get_or_insert_with(|| Surroundings::new(&network));
            active = surroundings.update(&mut adjacency, &mut roads, (&hints, &crowded), &active, &moved);
        }
    }
    let shifted_roads = roads.made;
    network.roads.par_iter_mut().in_small_parts().enumerate().for_each(|(i, road)| {
        if let Some(shifted) = shifted_roads.get(&i)
            && shifted.noticed().iter().any(|shift| *shift != 0.0)
            && let Some(line) = shifted_line(road, shifted)
        {
            set_line(road, line);
        }
    });
    let crowded = network.roads.get(crowded.into_inner()).map(too_many_beside);
    (network, crowded)
}

/// Says that so many roads lie beside others that none is moved: of some thousand vertices can be drawn as many roads as a country has.
fn too_long(network: &RoadNetwork, active: &[usize]) -> Option<Finding> {
    let metres: f64 = active.iter().map(|&road| network.roads[road].line.length()).sum();
    let vertices: usize = network.roads.iter().map(|road| road.line.points().len()).sum();
    let most = (PLACES_OF_VERTEX * vertices).max(LEAST_PLACES) as f64 * PLACE_STEP;
    let way = network.roads.get(*active.first()?)?.key.way;
    let message = format!(
        "Way {way} and {} other roads, {:.0} km, lie beside others: too much to lay side by side; they stay as they are drawn, and \
         lanes may lie on each other.",
        active.len() - 1,
        metres / 1000.0
    );
    (metres > most).then(|| Finding::new("too-many-beside", Subject::Way(way), message).graded(Severity::Warning))
}

/// Says that a road lies beside too many others.
fn too_many_beside(road: &Road) -> Finding {
    let RoadKey { way, first, last, .. } = road.key;
    let message = format!(
        "Of way {way} between nodes {first} and {last} a few metres lie beside or on {MOST_BESIDE} others: too many to lay side by side; lanes \
         may lie on each other there."
    );
    Finding::new("too-many-beside", Subject::Way(way), message).graded(Severity::Warning)
}

/// The moved line of a road. Where it does not move it stays as it is drawn.
fn shifted_line(road: &Road, shifted: &ShiftedRoad) -> Option<Polyline> {
    let shift = shifted.noticed();
    let is_moved = |place: usize| shift.get(place).is_some_and(|shift| *shift != 0.0);
    // From a place to the next.
    let piece_moves = |piece: usize| is_moved(piece) || is_moved(piece + 1);
    let own = shifted.stations.iter().enumerate();
    let own = own.filter(|(i, _)| piece_moves(*i) || i.checked_sub(1).is_some_and(piece_moves)).map(|(_, at)| *at);
    let mut stations = road.line.stations();
    // Beside a vertex even a small shift would turn the line far.
    let vertices = stations.clone();
    let is_apart = |at: &f64| {
        let next = vertices.partition_point(|vertex| vertex < at);
        vertices[next.saturating_sub(1)..].iter().take(2).all(|vertex| (vertex - at).abs() >= APART)
    };
    stations.extend(own.filter(is_apart));
    stations.sort_by(f64::total_cmp);
    let points = places(&road.line, &stations);
    let normals = normals(&points);
    let mut i = 0;
    let moved = stations.iter().zip(points.iter().zip(&normals)).map(|(s, (p, n))| {
        while i + 2 < shifted.stations.len() && shifted.stations[i + 1] < *s {
            i += 1;
        }
        let span = shifted.stations[i + 1] - shifted.stations[i];
        let t = if span > 0.0 { ((s - shifted.stations[i]) / span).clamp(0.0, 1.0) } else { 0.0 };
        (piece_moves(i), p + n * (shift[i] + (shift[i + 1] - shift[i]) * t))
    });
    let moved: Vec<(bool, Point)> = moved.collect();
    let stretches = moved.chunk_by(|a, b| a.0 == b.0).flat_map(|stretch| {
        let places = stretch.iter().map(|(_, place)| *place);
        match Polyline::new(places.clone()).filter(|_| stretch.first().is_some_and(|(moves, _)| *moves)) {
            Some(line) => straightened(&eased(&line, shifted.half)).into_points(),
            None => places.collect(),
        }
    });
    Polyline::new(stretches)
}

/// The line without the places that lie straight between their neighbours. Which of them remain is decided square by square of the
/// plane, so that it depends on no place far away.
fn straightened(line: &Polyline) -> Polyline {
    let square = |place: &Point| (place / STRAIGHT_WITHIN).coords.map(f64::floor);
    let mut straight = vec![line.first()];
    let mut part = straight.clone();
    for (before, place) in line.segments() {
        part.push(place);
        if square(&before) != square(&place) || place == line.last() {
            let of_part = Polyline::new(part).map(|part| part.straightened(ON_LINE));
            straight.extend(of_part.iter().flat_map(|part| part.points().iter().skip(1)));
            part = vec![place];
        }
    }
    Polyline::new(straight).unwrap_or_else(|| line.clone())
}

/// The roads that must move, ascending, with the shift of each of their places, metres, left positive.
fn targets(roads: &FxHashMap<usize, ShiftedRoad>, sides: &Sides, adjacency: &Adjacency) -> Vec<(usize, Vec<f64>)> {
    let mut pairs: Vec<&(usize, usize)> = adjacency.keys().collect();
    pairs.par_sort_unstable();
    let squeezed = squeezed(roads, sides, adjacency, &pairs);
    let target = |pairs: &[&(usize, usize)]| {
        let index = pairs.first()?.0;
        let road = &roads[&index];
        // The most that any neighbour asks for, to the left and to the right.
        let mut most: Option<Vec<[f64; 2]>> = None;
        for &&pair in pairs {
            for (place, side, push) in pushes(roads, sides, pair, (&adjacency[&pair], &squeezed)) {
                let most = most.get_or_insert_with(|| vec![[0.0; 2]; road.base.len()]);
                let away = &mut most[place][usize::from(side > 0.0)];
                *away = away.max(push);
            }
        }
        Some((index, road.shift.iter().zip(most?).map(|(s, [left, right])| s + left - right).collect()))
    };
    pairs.par_chunk_by(|x, y| x.0 == y.0).filter_map(target).collect()
}

/// The places, ascending, of each road that others overlap on both sides.
type Squeezed = FxHashMap<usize, Vec<usize>>;

/// The places where roads are squeezed. They cannot yield there; the roads beside them have to.
fn squeezed(
    roads: &FxHashMap<usize, ShiftedRoad>,
    sides: &Sides,
    adjacency: &Adjacency,
    pairs: &[&(usize, usize)],
) -> Squeezed {
    let of_road = |pairs: &[&(usize, usize)]| {
        let index = pairs.first()?.0;
        let mut pushed = vec![[false; 2]; roads[&index].base.len()];
        for &&pair in pairs {
            for (place, side, _) in overlaps(roads, sides, pair, &adjacency[&pair]) {
                pushed[place.index][usize::from(side > 0.0)] = true;
            }
        }
        let both = (0..pushed.len()).filter(|&place| pushed[place] == [true; 2]).collect::<Vec<_>>();
        (!both.is_empty()).then_some((index, both))
    };
    pairs.par_chunk_by(|x, y| x.0 == y.0).filter_map(of_road).collect()
}

/// How far a neighbour pushes a road at the places beside it: place, side of the neighbour (1 left, -1 right), metres.
fn pushes<'a>(
    roads: &'a FxHashMap<usize, ShiftedRoad>,
    sides: &'a Sides,
    pair: (usize, usize),
    (adjacent, squeezed): (&'a [AdjacentPlace], &'a Squeezed),
) -> impl Iterator<Item = (usize, f64, f64)> {
    let (road, other) = (&roads[&pair.0], &roads[&pair.1]);
    let share = road.mobility / (road.mobility + other.mobility);
    let is_squeezed = |road: usize, places: [usize; 2]| {
        let found = squeezed.get(&road);
        found.is_some_and(|found| places.iter().any(|place| found.binary_search(place).is_ok()))
    };
    overlaps(roads, sides, pair, adjacent).map(move |(place, side, overlap)| {
        let own = is_squeezed(pair.0, [place.index; 2]);
        let share = match (own, is_squeezed(pair.1, [place.beside, place.beside + 1])) {
            (true, false) => 0.0,
            (false, true) => 1.0,
            _ => share,
        };
        (place.index, side, overlap * share)
    })
}

/// The places of the first road of a pair where both overlap, with the side of the second (1 left, -1 right) and how far they overlap,
/// metres.
fn overlaps<'a>(
    roads: &'a FxHashMap<usize, ShiftedRoad>,
    sides: &'a Sides,
    pair: (usize, usize),
    adjacent: &'a [AdjacentPlace],
) -> impl Iterator<Item = (&'a AdjacentPlace, f64, f64)> {
    let (road, other) = (&roads[&pair.0], &roads[&pair.1]);
    let least = least_distance(road, other);
    let sides = adjacent.iter().filter_map(move |place| Some((place, sides.at(pair, [road, other], place)?)));
    let overlaps = sides.map(move |(place, side)| (place, side, least - place.offset * side));
    overlaps.filter(|(.., overlap)| *overlap > TOLERANCE)
}

/// Gives two roads that continue each other the same shift where they meet. Returns the roads that moved.
fn align_ends(roads: &mut ShiftedRoads) -> Vec<usize> {
    let mut moved = Vec::new();
    for intersection in &roads.network.intersections {
        let [a, b] = intersection.arms.as_slice() else { continue };
        if a.road == b.road {
            continue;
        }
        let [shift_a, shift_b] = [*a, *b].map(|arm| roads.shift(arm));
        // Lines that both begin here run apart: left of one is right of the other.
        let turn = if a.end == b.end { -1.0 } else { 1.0 };
        let (arm, shift, value) = match shift_a.abs() > shift_b.abs() {
            true => (b, shift_b, shift_a * turn),
            false => (a, shift_a, shift_b * turn),
        };
        if (shift - value).abs() > TOLERANCE {
            let index = arm.road.position();
            let road = roads.of(index);
            let mut target = road.shift.clone();
            target[road.end(arm.end)] = value;
            road.shift_to(&target);
            moved.push(index);
        }
    }
    moved
}
