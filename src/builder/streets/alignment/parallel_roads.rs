//! Lays roads that overlap lengthwise side by side.
//!
//! OpenStreetMap draws a ramp from the middle of the road it leaves, and the carriageways of a divided road as close
//! as the mapper's hand put them. Widened to their lanes, such roads overlap far from any intersection. Here each
//! gives way sideways, the lighter more than the wider, until their edges touch.

mod broad_phase;
mod carriageway_edges;
mod overlap_search;
mod recheck;
#[cfg(test)]
mod tests;

use crate::builder::network::{End, Road, RoadNetwork, Stations};
use crate::geometry::Polyline;
use crate::parallel::Finely;

use super::eased;
use super::side_order::{Sides, Told, sides};
use broad_phase::candidates;
use carriageway_edges::{CarriagewayEdges, TOLERANCE, Tracks, normals, places};
use overlap_search::{OverlapSearch, apart, find};
use recheck::{Surroundings, sorted};

use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Two roads drawn closer together than this, metres, may lie on either side of each other: a mapper's accuracy.
const UNCLEAR: f64 = 1.0;
/// A place of a moved road is no point of it where it lies within this, metres, of the straight way.
const STRAIGHT: f64 = 0.001;
/// Rounds after which what still overlaps is left.
const ROUNDS: usize = 12;

/// The network with roads laid abreast. `kept` gives the stations between which each road remains: what lies within
/// the intersections may overlap.
#[must_use]
pub fn lay_side_by_side(mut network: RoadNetwork, kept: &[Stations]) -> RoadNetwork {
    let (sides, mut hot) = rayon::join(|| sides(&network), || candidates(&network, kept));
    let mut tracks = Tracks { network: &network, kept, made: FxHashMap::default() };
    tracks.make(&hot);
    let mut beside = find(&tracks.made, &sides, &hot, &hot);
    let mut surroundings = None;
    for round in 1..=ROUNDS {
        let targets = targets(&tracks.made, &sides, &beside);
        if targets.is_empty() {
            break;
        }
        let mut moved: Vec<usize> = targets.iter().map(|(road, _)| *road).collect();
        for (road, target) in targets {
            tracks.of(road).take(&target);
        }
        moved.extend(join(&mut tracks));
        sorted(&mut moved);
        if round < ROUNDS {
            let surroundings = surroundings.get_or_insert_with(|| Surroundings::new(&network, &moved));
            hot = surroundings.find_again(&mut beside, &mut tracks, &sides, &hot, &moved);
        }
    }
    let tracks = tracks.made;
    network.roads.par_iter_mut().finely().enumerate().for_each(|(i, road)| {
        if let Some(track) = tracks.get(&i)
            && track.shift.iter().any(|s| s.abs() > TOLERANCE)
            && let Some(line) = shifted(road, track)
        {
            for feature in &mut road.features {
                feature.station = line.project(road.line.at(feature.station)).station;
            }
            road.line = line;
        }
    });
    network
}

/// The road's line, moved; places at which it only goes on straight are no points of it.
fn shifted(road: &Road, track: &CarriagewayEdges) -> Option<Polyline> {
    let mut stations = road.line.stations();
    stations.extend(&track.stations);
    stations.sort_by(f64::total_cmp);
    stations.dedup_by(|a, b| (*a - *b).abs() < 0.01);
    let points = places(&road.line, &stations);
    let normals = normals(&points);
    let mut i = 0;
    let moved = stations.iter().zip(points.iter().zip(&normals)).map(|(s, (p, n))| {
        while i + 2 < track.stations.len() && track.stations[i + 1] < *s {
            i += 1;
        }
        let span = track.stations[i + 1] - track.stations[i];
        let t = if span > 0.0 { ((s - track.stations[i]) / span).clamp(0.0, 1.0) } else { 0.0 };
        p + n * (track.shift[i] + (track.shift[i + 1] - track.shift[i]) * t)
    });
    Some(eased(&Polyline::new(moved)?, track.half).straightened(STRAIGHT))
}

/// The roads that have to give way, ascending, and how far each should lie from its drawn line, place by place.
fn targets(
    tracks: &FxHashMap<usize, CarriagewayEdges>,
    sides: &Sides,
    pairs: &FxHashMap<(usize, usize), Vec<OverlapSearch>>,
) -> Vec<(usize, Vec<f64>)> {
    let mut keys: Vec<&(usize, usize)> = pairs.keys().collect();
    keys.par_sort_unstable();
    let target = |of_road: &[&(usize, usize)]| {
        let road = of_road.first()?.0;
        let me = &tracks[&road];
        // To the left and to the right, the farthest that any neighbour asks for.
        let mut push: Option<Vec<[f64; 2]>> = None;
        for &&(a, b) in of_road {
            let other = &tracks[&b];
            let share = me.mobility / (me.mobility + other.mobility);
            let told = sides.get(&(a, b)).map_or(&[][..], Vec::as_slice);
            for run in pairs[&(a, b)].chunk_by(|x, y| x.place + 1 == y.place) {
                if me.level != other.level && !told.iter().any(|t| begins_where_they_meet(me, run, t)) {
                    continue;
                }
                let side = told_side(me, run, told).unwrap_or_else(|| drawn_side(run, a < b));
                for beside in run {
                    let overlap = apart(me, other) - beside.offset * side;
                    if overlap > TOLERANCE {
                        let push = push.get_or_insert_with(|| vec![[0.0; 2]; me.base.len()]);
                        let way = &mut push[beside.place][usize::from(side > 0.0)];
                        *way = way.max(overlap * share);
                    }
                }
            }
        }
        Some((road, me.shift.iter().zip(push?).map(|(s, [left, right])| s + left - right).collect()))
    };
    keys.par_chunk_by(|x, y| x.0 == y.0).filter_map(target).collect()
}

/// Whether a run of places begins at the cut of the intersection that the two roads share.
fn begins_where_they_meet(track: &CarriagewayEdges, run: &[OverlapSearch], told: &Told) -> bool {
    let Some([first, last]) = track.kept else { return false };
    match told.meets {
        Some(End::Start) => run.first().is_some_and(|beside| beside.place == first),
        Some(End::End) => run.last().is_some_and(|beside| beside.place == last),
        None => false,
    }
}

/// On which side the other road lies along a run of places as the intersections tell it; `None` if they tell nothing,
/// or contradict each other. Away from the intersection they are heard only where the drawing leaves it open.
fn told_side(track: &CarriagewayEdges, run: &[OverlapSearch], told: &[Told]) -> Option<f64> {
    let unclear = run.iter().all(|beside| beside.offset.abs() < UNCLEAR);
    let holds = |t: &&Told| {
        begins_where_they_meet(track, run, t) || unclear && run.iter().any(|beside| t.at(track.stations[beside.place]))
    };
    let mut holding = told.iter().filter(holds).map(|t| t.side);
    let first = holding.next()?;
    holding.all(|side| side == first).then_some(first)
}

/// On which side the other road is drawn along a run of places: 1 left, -1 right. Where it is drawn on top, the lower
/// index goes left of the higher.
fn drawn_side(run: &[OverlapSearch], first: bool) -> f64 {
    let farthest = run.iter().max_by(|x, y| x.offset.abs().total_cmp(&y.offset.abs()));
    match farthest {
        Some(beside) if beside.offset.abs() > TOLERANCE => beside.offset.signum(),
        Some(beside) if beside.along && !first => 1.0,
        _ => -1.0,
    }
}

/// Two roads that continue each other shift together where they meet. Returns those that moved.
fn join(tracks: &mut Tracks) -> Vec<usize> {
    let mut moved = Vec::new();
    for intersection in &tracks.network.intersections {
        let [a, b] = intersection.arms.as_slice() else { continue };
        if a.road == b.road {
            continue;
        }
        let [sa, sb] = [*a, *b].map(|at| tracks.shift(at));
        // Lines that both begin here run apart: left of one is right of the other.
        let turn = if a.end == b.end { -1.0 } else { 1.0 };
        let (at, shift, value) = match sa.abs() > sb.abs() {
            true => (b, sb, sa * turn),
            false => (a, sa, sb * turn),
        };
        if (shift - value).abs() > TOLERANCE {
            let road = at.road.position();
            let track = tracks.of(road);
            let mut target = track.shift.clone();
            target[track.end(at.end)] = value;
            track.take(&target);
            moved.push(road);
        }
    }
    moved
}
