//! Lays roads that overlap lengthwise side by side.
//!
//! OpenStreetMap draws a ramp from the middle of the road it leaves, and the carriageways of a divided road as close
//! as the mapper's hand put them. Widened to their lanes, such roads overlap far from any intersection. Here each
//! gives way sideways, the lighter more than the wider, until their edges touch.

mod again;
mod beside;
mod sieve;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::{End, Road, RoadEnd, RoadNetwork};
use crate::geometry::{Point, Polyline, Vector, left_of};
use crate::parallel::Finely;

use super::eased;
use super::sides::{Sides, Told, sides};
use again::{Surroundings, sorted};
use beside::{Beside, apart, find};
use sieve::likely;

/// Distance between the places, metres, at which a road is compared with others.
const STEP: f64 = 4.0;
/// Gap, metres, that is left between two roads laid side by side.
const CLEAR: f64 = 0.05;
/// An overlap below this, metres, is left as it is.
const TOLERANCE: f64 = 0.03;
/// Two roads drawn closer together than this, metres, may lie on either side of each other: a mapper's accuracy.
const UNCLEAR: f64 = 1.0;
/// A road is never moved further than this, metres: beyond, the map is wrong, or the widths are.
const FARTHEST: f64 = 7.0;
/// Metres sideways per metre along the road at which it gives way.
const SLOPE: f64 = 0.12;
/// A place of a moved road is no point of it where it lies within this, metres, of the straight way.
const STRAIGHT: f64 = 0.001;
/// Rounds after which what still overlaps is left.
const ROUNDS: usize = 12;
/// A part of a road shorter than this between its cuts, metres, need not be laid abreast.
const SHORTEST: f64 = 2.0;

/// The tracks of the roads that may move or lie near others that do; all others stay as they are drawn.
struct Tracks<'a> {
    network: &'a RoadNetwork,
    kept: &'a [[f64; 2]],
    made: FxHashMap<usize, Track>,
}

impl Tracks<'_> {
    /// The track of a road.
    fn of(&mut self, road: usize) -> &mut Track {
        self.made.entry(road).or_insert_with(|| Track::new(&self.network.roads[road], self.kept[road]))
    }

    /// Makes the tracks of many roads.
    fn make(&mut self, roads: &[usize]) {
        let new = roads.par_iter().finely().filter(|road| !self.made.contains_key(road));
        let new: Vec<_> = new.map(|&road| (road, Track::new(&self.network.roads[road], self.kept[road]))).collect();
        self.made.extend(new);
    }

    /// How far an end of a road has moved.
    fn shift(&self, at: RoadEnd) -> f64 {
        let track = self.made.get(&(at.road.0 as usize));
        track.and_then(|track| track.shift.get(track.end(at.end))).copied().unwrap_or_default()
    }
}

/// One road as a list of places that can move sideways.
struct Track {
    stations: Vec<f64>,
    base: Vec<Point>,
    normals: Vec<Vector>,
    /// Signed, left positive, metres.
    shift: Vec<f64>,
    /// First and last place between the cuts; `None` if nothing worth moving remains.
    kept: Option<[usize; 2]>,
    half: f64,
    level: f64,
    mobility: f64,
}

impl Track {
    fn new(road: &Road, kept: [f64; 2]) -> Self {
        let length = road.line.length();
        let [from, to] = [kept[0].clamp(0.0, length), kept[1].clamp(0.0, length)];
        let mut stations = vec![0.0];
        if to - from > SHORTEST {
            let pieces = ((to - from) / STEP).ceil() as usize;
            let inner = (0..=pieces).map(|i| from + (to - from) * i as f64 / pieces as f64);
            stations.extend(inner.filter(|s| *s > Polyline::MERGE && *s < length - Polyline::MERGE));
        }
        stations.push(length);
        let base: Vec<Point> = places(&road.line, &stations);
        let normals = normals(&base);
        let index = |station: f64| stations.iter().position(|s| *s >= station - Polyline::MERGE);
        let kept = if to - from > SHORTEST { index(from).zip(index(to)).map(|(a, b)| [a, b]) } else { None };
        let width = road.section.width();
        let mobility = if road.link { 3.0 } else { 1.0 } / (width * width).max(1.0);
        let shift = vec![0.0; base.len()];
        Self { stations, base, normals, shift, kept, half: width / 2.0, level: road.level, mobility }
    }

    /// The place at one end.
    fn end(&self, end: End) -> usize {
        match end {
            End::Start => 0,
            End::End => self.shift.len() - 1,
        }
    }

    fn place(&self, i: usize) -> Point {
        self.base[i] + self.normals[i] * self.shift[i]
    }

    fn is_kept(&self, i: usize) -> bool {
        self.kept.is_some_and(|[a, b]| (a..=b).contains(&i))
    }

    /// Station with the parts beyond the cuts folded into them: a road keeps its shift up to its end.
    fn folded(&self, i: usize) -> f64 {
        match self.kept {
            Some([a, b]) => self.stations[i.clamp(a, b)],
            None => self.stations[i],
        }
    }

    /// Raises the shift to at least `target` on its own side everywhere, with gentle slopes around.
    fn take(&mut self, target: &[f64]) {
        let mut high: Vec<f64> = self.shift.iter().zip(target).map(|(s, t)| s.max(*t).max(0.0)).collect();
        let mut low: Vec<f64> = self.shift.iter().zip(target).map(|(s, t)| (-s).max(-*t).max(0.0)).collect();
        for i in 0..target.len() {
            // A target between the old shift and zero lets the road come back.
            if target[i] >= 0.0 && self.shift[i] > target[i] {
                high[i] = target[i];
            }
            if target[i] <= 0.0 && self.shift[i] < target[i] {
                low[i] = -target[i];
            }
        }
        for side in [&mut high, &mut low] {
            for i in 1..side.len() {
                side[i] = side[i].max(side[i - 1] - SLOPE * (self.folded(i) - self.folded(i - 1)));
            }
            for i in (1..side.len()).rev() {
                side[i - 1] = side[i - 1].max(side[i] - SLOPE * (self.folded(i) - self.folded(i - 1)));
            }
        }
        for (i, shift) in self.shift.iter_mut().enumerate() {
            *shift = (high[i] - low[i]).clamp(-FARTHEST, FARTHEST);
        }
    }
}

/// The points of a line at ascending stations.
fn places(line: &Polyline, stations: &[f64]) -> Vec<Point> {
    let marks = line.stations();
    let points = line.points();
    let mut segment = 0;
    stations
        .iter()
        .map(|s| {
            while segment + 2 < marks.len() && marks[segment + 1] < *s {
                segment += 1;
            }
            let t = ((s - marks[segment]) / (marks[segment + 1] - marks[segment])).clamp(0.0, 1.0);
            points[segment] + (points[segment + 1] - points[segment]) * t
        })
        .collect()
}

/// Unit normals to the left at each of two or more points.
fn normals(points: &[Point]) -> Vec<Vector> {
    (0..points.len())
        .map(|i| {
            let (a, b) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
            left_of((b - a).try_normalize(0.0).unwrap_or_else(Vector::x))
        })
        .collect()
}

/// The network with roads laid abreast. `kept` gives the stations between which each road remains: what lies within
/// the intersections may overlap.
#[must_use]
pub fn abreast(mut network: RoadNetwork, kept: &[[f64; 2]]) -> RoadNetwork {
    let (sides, mut hot) = rayon::join(|| sides(&network), || likely(&network, kept));
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
fn shifted(road: &Road, track: &Track) -> Option<Polyline> {
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
    tracks: &FxHashMap<usize, Track>,
    sides: &Sides,
    pairs: &FxHashMap<(usize, usize), Vec<Beside>>,
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
fn begins_where_they_meet(track: &Track, run: &[Beside], told: &Told) -> bool {
    let Some([first, last]) = track.kept else { return false };
    match told.meets {
        Some(End::Start) => run.first().is_some_and(|beside| beside.place == first),
        Some(End::End) => run.last().is_some_and(|beside| beside.place == last),
        None => false,
    }
}

/// On which side the other road lies along a run of places as the intersections tell it; `None` if they tell nothing,
/// or contradict each other. Away from the intersection they are heard only where the drawing leaves it open.
fn told_side(track: &Track, run: &[Beside], told: &[Told]) -> Option<f64> {
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
fn drawn_side(run: &[Beside], first: bool) -> f64 {
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
            let road = at.road.0 as usize;
            let track = tracks.of(road);
            let mut target = track.shift.clone();
            target[track.end(at.end)] = value;
            track.take(&target);
            moved.push(road);
        }
    }
    moved
}
