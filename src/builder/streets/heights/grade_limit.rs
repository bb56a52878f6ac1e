//! Grades held: the heights nearest to the wanted ones among which no road climbs more than it may.
//!
//! Of all heights that keep every grade, none that lies above the wanted heights everywhere is lower than the *raised*
//! ones (each place as high as its surroundings ask, less the climb from there), and none below them is higher than the
//! *lowered* ones. The mean of the two keeps the grades too, strays from what was wanted by no more than it must, and
//! leaves everything as it was where nothing is too steep. Around what is too steep it changes more than it must: so only the
//! places between which a bound is broken take it, and all others stay as near to the wanted heights as those let them.
//!
//! The room between roads that pass over each other is one more such bound, on a step instead of a way: where it cannot be
//! had with the grades, it gives way.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::RangeInclusive;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::{End, Intersection, IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::parallel::Finely;

use super::crossings::Overpass;
use super::options::REACH;

/// Heights are kept as whole tenths of a millimetre, which have an order.
const PER_METRE: f64 = 1e4;
/// A crossing that has lifted the road over it so often lifts itself: the two roads are joined by too short a way.
const MOST_LIFTS: u32 = 6;
/// The room at such a crossing gives way by so many parts of what is asked.
const PARTS: i64 = 4;

/// Heights along one road, from end to end.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// Where, metres; not all in one place.
    pub stations: Vec<f64>,
    /// Where the road is to lie, metres.
    pub wanted: Vec<f64>,
    /// The most that it may climb from each station to the next, metres.
    pub climbs: Vec<f64>,
}

impl Sampled {
    fn nearest(&self, station: f64) -> usize {
        let behind = self.stations.partition_point(|s| *s < station).min(self.stations.len() - 1);
        let before = behind.saturating_sub(1);
        if station - self.stations[before] < self.stations[behind] - station { before } else { behind }
    }

    /// What lies so near a station that it counts for the height there.
    fn around(&self, station: f64) -> RangeInclusive<usize> {
        let at = self.nearest(station);
        at.saturating_sub(REACH)..=(at + REACH).min(self.wanted.len() - 1)
    }
}

/// A place of a road: its index in the network, and the station, metres.
type OnRoad = (usize, f64);

/// The places along one road: an intersection at either end, and what lies between in a row.
#[derive(Clone, Copy)]
struct Chain {
    ends: [usize; 2],
    first: usize,
    inner: usize,
}

impl Chain {
    fn place(&self, i: usize) -> usize {
        match i {
            0 => self.ends[0],
            i if i > self.inner => self.ends[1],
            i => self.first + i - 1,
        }
    }
}

/// Two places, and the least that one lies above the other.
type Pair = (usize, usize, i64);

/// How the ends of roads at one intersection bind each other.
#[derive(Clone, Copy)]
pub struct Ties<'a> {
    /// Per road: the stations where it ends.
    pub kept: &'a [Stations],
    /// The most that one of two ends may lie above the other, metres. Few are asked for.
    pub climb: &'a (dyn Fn(RoadEnd, RoadEnd) -> f64 + Sync),
    /// No two are held closer than this, metres.
    pub least: f64,
}

/// What binds the height of one place to that of another on the road over or below it.
#[derive(Clone, Copy)]
enum Bound {
    /// The other place lies on the road over this one: the crossing's index.
    Above(usize),
    /// The other place lies on the road below this one.
    Below(usize),
}

/// Heights of all places, few of which differ from the wanted ones.
struct Heights<'a> {
    wanted: &'a [i64],
    moved: FxHashMap<usize, i64>,
}

impl<'a> Heights<'a> {
    fn of(wanted: &'a [i64]) -> Self {
        Self { wanted, moved: FxHashMap::default() }
    }

    fn at(&self, place: usize) -> i64 {
        self.moved.get(&place).copied().unwrap_or(self.wanted[place])
    }
}

/// All places with a height, the intersections first, and how they bind each other.
pub struct Web<'a> {
    network: &'a RoadNetwork,
    sampled: &'a [Sampled],
    chains: Vec<Chain>,
    wanted: Vec<i64>,
    ties: Option<Ties<'a>>,
    /// Lower and upper place of every crossing, and the room asked between them.
    rooms: Vec<Pair>,
}

impl<'a> Web<'a> {
    /// The places of all roads, and the room at crossings.
    pub fn new(network: &'a RoadNetwork, sampled: &'a [Sampled], crossings: &[Overpass], storey: f64) -> Self {
        let inner = |of: &Sampled| of.wanted.len().saturating_sub(2);
        let mut wanted = vec![0; network.intersections.len()];
        wanted.reserve_exact(sampled.iter().map(inner).sum());
        let mut chains = Vec::with_capacity(sampled.len());
        for (road, of) in network.roads.iter().zip(sampled) {
            let ends = [road.from, road.to].map(|at| at.position());
            let chain = Chain { ends, first: wanted.len(), inner: inner(of) };
            wanted.resize(chain.first + chain.inner, 0);
            for (i, height) in of.wanted.iter().enumerate() {
                wanted[chain.place(i)] = units(*height);
            }
            chains.push(chain);
        }
        let mut web = Self { network, sampled, chains, wanted, ties: None, rooms: Vec::new() };
        for Overpass { upper: (upper, above), lower: (lower, below), levels, .. } in crossings {
            let room = units(levels * storey);
            let [high, low] = [web.at((*upper, *above)), web.at((*lower, *below))];
            let over = sampled[*upper].around(*above).map(|i| (low, web.chains[*upper].place(i), room));
            let under = sampled[*lower].around(*below).map(|i| web.chains[*lower].place(i)).filter(|at| *at != low);
            let rooms: Vec<Pair> = over.chain(under.map(|low| (low, high, room))).collect();
            web.rooms.extend(rooms);
        }
        web
    }

    /// The place nearest to a station of a road.
    fn at(&self, (road, station): OnRoad) -> usize {
        self.chains[road].place(self.sampled[road].nearest(station))
    }

    /// Asks no more room at crossings than the wanted heights leave.
    pub fn give_way(&mut self) {
        for (low, high, room) in &mut self.rooms {
            *room = (*room).min(self.wanted[*high] - self.wanted[*low]);
        }
    }

    /// Ties the ends of roads to each other.
    pub fn tie(&mut self, ties: Ties<'a>) {
        self.ties = Some(ties);
    }

    /// The place where a road ends.
    fn end(&self, ties: &Ties<'_>, at: RoadEnd) -> usize {
        let road = at.road.position();
        self.at((road, ties.kept[road][at.end]))
    }

    /// The ends at an intersection that are too steep beside each other.
    fn stepped(&self, ties: &Ties<'_>, at: &Intersection) -> Vec<usize> {
        let ends: Vec<usize> = at.arms.iter().map(|at| self.end(ties, *at)).collect();
        let apart = |i: usize, j: usize| (self.wanted[ends[i]] - self.wanted[ends[j]]).abs();
        let pairs = (0..ends.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let pairs = pairs.filter(|&(i, j)| apart(i, j) > units(ties.least));
        let steep = pairs.filter(|&(i, j)| apart(i, j) > units((ties.climb)(at.arms[i], at.arms[j])));
        steep.flat_map(|(i, j)| [ends[i], ends[j]]).collect()
    }

    /// Goes through the places to which the ends of roads at a place are tied, with the most by which they may differ.
    fn tied(&self, place: usize, mut each: impl FnMut(usize, i64)) {
        let Some(ties) = &self.ties else { return };
        let roads: Vec<usize> = match self.network.intersections.get(place) {
            Some(at) => at.arms.iter().map(|at| at.road.position()).collect(),
            None => vec![self.road_of(place)],
        };
        let ends = roads.iter().flat_map(|&road| End::BOTH.map(|end| RoadEnd { road: RoadIx::new(road), end }));
        let ends = ends.filter(|at| self.end(ties, *at) == place);
        let mut around: Vec<IntersectionIx> = ends.map(|at| self.network.road(at.road).intersection(at.end)).collect();
        around.sort_unstable();
        around.dedup();
        for at in around {
            let arms = &self.network.intersection(at).arms;
            for (i, &a) in arms.iter().enumerate() {
                for &b in &arms[i + 1..] {
                    let ends = [a, b].map(|at| self.end(ties, at));
                    if !ends.contains(&place) {
                        continue;
                    }
                    let most = units((ties.climb)(a, b));
                    for (from, to) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                        if from == place {
                            each(to, most);
                        }
                    }
                }
            }
        }
    }

    /// Heights of every road that hold the grades, and the room at crossings where it can be had.
    pub fn heights(mut self) -> Vec<Vec<f64>> {
        self.hold();
        let height = |place: usize| self.wanted[place] as f64 / PER_METRE;
        let along = |chain: &Chain| (0..chain.inner + 2).map(|i| height(chain.place(i))).collect();
        self.chains.par_iter().finely().map(along).collect()
    }

    /// Puts the heights nearest to the wanted ones that keep all bounds in their place.
    fn hold(&mut self) {
        let steep = self.steep();
        let mut broken = self.broken(&steep);
        if broken.is_empty() {
            return;
        }
        let least: Vec<i64> = self.rooms.iter().map(|(_, _, room)| (room + PARTS - 1) / PARTS).collect();
        let bounds = self.bounds();
        let [raised, lowered] = loop {
            let mut lifts = vec![0; self.rooms.len()];
            let spread = [1, -1].map(|sign| {
                let mut heights = Heights::of(&self.wanted);
                self.spread(&bounds, &mut heights, sign, &broken, &mut lifts);
                heights.moved
            });
            if lifts.iter().all(|lifts| *lifts <= MOST_LIFTS) {
                break spread;
            }
            for ((room, lifts), least) in self.rooms.iter_mut().zip(lifts).zip(&least) {
                room.2 -= if lifts > MOST_LIFTS { *least } else { 0 };
            }
            broken = self.broken(&steep);
        };
        // The mean where a bound is broken; from there others give way as far as they must. The middle of three heights,
        // place by place, keeps every bound that all three keep.
        let mut held = Heights::of(&self.wanted);
        for &place in &broken {
            let [high, low] = [&raised, &lowered].map(|of| of.get(&place).unwrap_or(&self.wanted[place]));
            held.moved.insert(place, (high + low).div_euclid(2));
        }
        let mut lifts = vec![0; self.rooms.len()];
        for sign in [1, -1] {
            self.spread(&bounds, &mut held, sign, &broken, &mut lifts);
        }
        for (place, height) in held.moved {
            self.wanted[place] = height;
        }
    }

    /// The places between which the wanted heights climb more than they may.
    fn steep(&self) -> Vec<usize> {
        let apart = |a: usize, b: usize| (self.wanted[a] - self.wanted[b]).abs();
        let along = |(chain, sampled): (&Chain, &Sampled)| {
            let pair = |(i, climb): (usize, &f64)| {
                let ends = [chain.place(i), chain.place(i + 1)];
                let apart = apart(ends[0], ends[1]);
                // Most are level.
                (apart > 0 && apart > most(*climb)).then_some(ends)
            };
            sampled.climbs.iter().enumerate().filter_map(pair).flatten().collect::<Vec<usize>>()
        };
        let mut steep: Vec<usize> = self.chains.par_iter().finely().zip(self.sampled).flat_map_iter(along).collect();
        if let Some(ties) = &self.ties {
            steep.par_extend(self.network.intersections.par_iter().finely().flat_map_iter(|at| self.stepped(ties, at)));
        }
        steep
    }

    /// The places whose wanted heights break one of their bounds, given those that are too steep.
    fn broken(&self, steep: &[usize]) -> Vec<usize> {
        let near = |(low, high, room): &&Pair| *room > 0 && self.wanted[*high] - self.wanted[*low] < *room;
        let near = self.rooms.iter().filter(near).flat_map(|(low, high, _)| [*low, *high]);
        let mut broken: Vec<usize> = steep.iter().copied().chain(near).collect();
        broken.sort_unstable();
        broken.dedup();
        broken
    }

    /// Raises (`sign` 1) or lowers (-1) places as little as keeps the bounds around these, and around those that it moves.
    /// `lifts` counts how often each crossing moved a road; one that exceeds the most moves it no more.
    fn spread(
        &self,
        bounds: &[(usize, usize, Bound)],
        heights: &mut Heights<'_>,
        sign: i64,
        from: &[usize],
        lifts: &mut [u32],
    ) {
        lifts.iter_mut().for_each(|lifts| *lifts = if *lifts > MOST_LIFTS { *lifts } else { 0 });
        let mut open: BinaryHeap<(i64, Reverse<usize>)> =
            from.iter().map(|&at| (sign * heights.at(at), Reverse(at))).collect();
        while let Some((height, Reverse(at))) = open.pop() {
            if sign * heights.at(at) != height {
                continue;
            }
            let mut pull = |to: usize, fall: i64, room: Option<usize>| {
                let least = height - fall;
                if least <= sign * heights.at(to) {
                    return;
                }
                if let Some(room) = room {
                    lifts[room] += 1;
                    if lifts[room] > MOST_LIFTS {
                        return;
                    }
                }
                heights.moved.insert(to, sign * least);
                open.push((least, Reverse(to)));
            };
            self.neighbours(at, |to, most| pull(to, most, None));
            self.tied(at, |to, most| pull(to, most, None));
            let first = bounds.partition_point(|(place, ..)| *place < at);
            for (_, to, bound) in bounds[first..].iter().take_while(|(place, ..)| *place == at) {
                match *bound {
                    Bound::Above(i) if sign > 0 && self.rooms[i].2 > 0 => pull(*to, -self.rooms[i].2, Some(i)),
                    Bound::Below(i) if sign < 0 && self.rooms[i].2 > 0 => pull(*to, -self.rooms[i].2, Some(i)),
                    _ => {}
                }
            }
        }
    }

    /// Goes through the neighbours of a place on its roads, with the most that is climbed on the way.
    fn neighbours(&self, place: usize, mut each: impl FnMut(usize, i64)) {
        let mut step = |road: usize, i: usize, next: usize| {
            each(self.chains[road].place(next), most(self.sampled[road].climbs[i.min(next)]));
        };
        match self.network.intersections.get(place) {
            Some(intersection) => {
                for RoadEnd { road, end } in &intersection.arms {
                    let road = road.position();
                    let last = self.chains[road].inner + 1;
                    match end {
                        End::Start => step(road, 0, 1),
                        End::End => step(road, last, last - 1),
                    }
                }
            }
            None => {
                let road = self.road_of(place);
                let i = place - self.chains[road].first + 1;
                step(road, i, i - 1);
                step(road, i, i + 1);
            }
        }
    }

    /// The road on which a place lies that is none of an intersection.
    fn road_of(&self, place: usize) -> usize {
        self.chains.partition_point(|chain| chain.first <= place) - 1
    }

    /// What binds places to others above and below them, in the order of the places.
    fn bounds(&self) -> Vec<(usize, usize, Bound)> {
        let rooms = self.rooms.iter().enumerate();
        let rooms = rooms.flat_map(|(i, &(low, high, _))| [(low, high, Bound::Above(i)), (high, low, Bound::Below(i))]);
        let mut bounds: Vec<(usize, usize, Bound)> = rooms.collect();
        bounds.par_sort_by_key(|(place, ..)| *place);
        bounds
    }
}

/// The most that a road climbs between two places, in whole units.
fn most(climb: f64) -> i64 {
    units(climb).min(i64::from(u32::MAX)) + 1
}

fn units(metres: f64) -> i64 {
    (metres * PER_METRE).round() as i64
}
