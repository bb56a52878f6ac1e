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

use crate::builder::road_network::RoadNetwork;

use super::REACH;
use super::crossings::Crossing;

/// Heights are kept as whole tenths of a millimetre, which have an order.
const PER_METRE: f64 = 1e4;
/// A crossing that has lifted the road over it so often lifts itself: the two roads are joined by too short a way.
const MOST_LIFTS: u32 = 6;
/// A height beyond all others: what is not held.
const FREE: i64 = 1 << 40;
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
pub type OnRoad = (usize, f64);

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

/// A way between two places, or the room between them, and the most or the least that one lies above the other.
type Pair = (usize, usize, i64);

/// What binds the height of one place to that of another.
#[derive(Clone, Copy)]
enum Bound {
    /// A way along a road, and the most that it climbs.
    Climb(u32),
    /// The other place lies on the road over this one: the crossing's index.
    Above(u32),
    /// The other place lies on the road below this one.
    Below(u32),
}

/// What every place binds, one place after the other.
struct Bounds {
    /// Where those of a place begin.
    first: Vec<u32>,
    all: Vec<(u32, Bound)>,
}

impl Bounds {
    fn of(&self, place: usize) -> &[(u32, Bound)] {
        &self.all[self.first[place] as usize..self.first[place + 1] as usize]
    }
}

/// All places with a height, the intersections first, and how they bind each other.
pub struct Web<'a> {
    sampled: &'a [Sampled],
    chains: Vec<Chain>,
    wanted: Vec<i64>,
    /// Pairs of places that are not neighbours on a road, with the most that one may lie above the other.
    ties: Vec<Pair>,
    /// Lower and upper place of every crossing, and the room asked between them.
    rooms: Vec<Pair>,
}

impl<'a> Web<'a> {
    /// The places of all roads, and the room at crossings.
    pub fn new(network: &RoadNetwork, sampled: &'a [Sampled], crossings: &[Crossing], storey: f64) -> Self {
        let mut wanted = vec![0; network.intersections.len()];
        let mut chains = Vec::with_capacity(sampled.len());
        for (road, Sampled { wanted: heights, .. }) in network.roads.iter().zip(sampled) {
            let inner = heights.len().saturating_sub(2);
            let chain = Chain { ends: [road.from, road.to].map(|at| at.0 as usize), first: wanted.len(), inner };
            wanted.resize(chain.first + inner, 0);
            for (i, height) in heights.iter().enumerate() {
                wanted[chain.place(i)] = units(*height);
            }
            chains.push(chain);
        }
        let mut web = Self { sampled, chains, wanted, ties: Vec::new(), rooms: Vec::new() };
        for Crossing { upper: (upper, above), lower: (lower, below), levels, .. } in crossings {
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

    /// Lets two places differ by so many metres at most.
    pub fn tie(&mut self, [a, b]: [OnRoad; 2], climb: f64) {
        self.ties.push((self.at(a), self.at(b), units(climb)));
    }

    /// Heights of every road that hold the grades, and the room at crossings where it can be had.
    pub fn heights(mut self) -> Vec<Vec<f64>> {
        let held = self.held();
        let height = |place: usize| held[place] as f64 / PER_METRE;
        let along = |chain: &Chain| (0..chain.inner + 2).map(|i| height(chain.place(i))).collect();
        self.chains.par_iter().map(along).collect()
    }

    /// Pairs of places with the most that one may lie above the other.
    fn climbs(&self) -> impl Iterator<Item = Pair> + '_ {
        let along = |(chain, sampled): (&Chain, &'a Sampled)| {
            let chain = *chain;
            sampled
                .climbs
                .iter()
                .enumerate()
                .map(move |(i, climb)| (chain.place(i), chain.place(i + 1), units(*climb) + 1))
        };
        self.chains.iter().zip(self.sampled).flat_map(along).chain(self.ties.iter().copied())
    }
}

fn negated(heights: Vec<i64>) -> Vec<i64> {
    heights.into_iter().map(|height| -height).collect()
}

fn units(metres: f64) -> i64 {
    (metres * PER_METRE).round() as i64
}

impl Web<'_> {
    /// The heights nearest to the wanted ones that keep all bounds.
    fn held(&mut self) -> Vec<i64> {
        let steep = self.climbs().any(|(a, b, climb)| (self.wanted[a] - self.wanted[b]).abs() > climb);
        let near = self.rooms.iter().any(|(low, high, room)| self.wanted[*high] - self.wanted[*low] < *room);
        if !steep && !near {
            return self.wanted.clone();
        }
        let least: Vec<i64> = self.rooms.iter().map(|(_, _, room)| (room + PARTS - 1) / PARTS).collect();
        let bounds = self.bounds();
        loop {
            let mut lifts = vec![0; self.rooms.len()];
            let raised = self.raised(&bounds, self.wanted.clone(), 1, &mut lifts);
            let lowered = self.raised(&bounds, negated(self.wanted.clone()), -1, &mut lifts);
            if lifts.iter().all(|lifts| *lifts <= MOST_LIFTS) {
                return self
                    .nearest(&bounds, raised.iter().zip(&lowered).map(|(high, low)| (high - low).div_euclid(2)));
            }
            for ((room, lifts), least) in self.rooms.iter_mut().zip(lifts).zip(&least) {
                room.2 -= if lifts > MOST_LIFTS { *least } else { 0 };
            }
        }
    }

    /// Heights that keep all bounds: the mean between which a bound is broken, and elsewhere those nearest to the wanted
    /// ones that go with it. The middle of three heights, place by place, keeps every bound that all three keep.
    fn nearest(&self, bounds: &Bounds, mean: impl Iterator<Item = i64>) -> Vec<i64> {
        let broken = self.broken();
        let fixed = |free: i64| move |(height, broken): (i64, &bool)| if *broken { height } else { free };
        let mean: Vec<i64> = mean.collect();
        let least = mean.iter().copied().zip(&broken).map(fixed(-FREE)).collect();
        let most = mean.iter().copied().zip(&broken).map(fixed(FREE)).collect();
        let mut lifts = vec![0; self.rooms.len()];
        let least = self.raised(bounds, least, 1, &mut lifts);
        let most = negated(self.raised(bounds, negated(most), -1, &mut lifts));
        self.wanted.iter().zip(least.iter().zip(&most)).map(|(at, (low, high))| (*at).min(*high).max(*low)).collect()
    }

    /// Whether the wanted heights of a place break one of its bounds.
    fn broken(&self) -> Vec<bool> {
        let mut broken = vec![false; self.wanted.len()];
        for (a, b, most) in self.climbs() {
            if (self.wanted[a] - self.wanted[b]).abs() > most {
                (broken[a], broken[b]) = (true, true);
            }
        }
        for (low, high, room) in self.rooms.iter().filter(|(_, _, room)| *room > 0) {
            if self.wanted[*high] - self.wanted[*low] < *room {
                (broken[*low], broken[*high]) = (true, true);
            }
        }
        broken
    }

    /// The lowest heights at or above those given (`sign` 1), or below them with all signs turned (-1). `lifts` counts how
    /// often each crossing moved a road; one that exceeds the most moves it no more.
    fn raised(&self, bounds: &Bounds, mut heights: Vec<i64>, sign: i64, lifts: &mut [u32]) -> Vec<i64> {
        lifts.iter_mut().for_each(|lifts| *lifts = if *lifts > MOST_LIFTS { *lifts } else { 0 });
        let fall = |bound: Bound| match bound {
            Bound::Climb(most) => Some(i64::from(most)),
            Bound::Above(i) => Some(-self.rooms[i as usize].2).filter(|room| sign > 0 && *room < 0),
            Bound::Below(i) => Some(-self.rooms[i as usize].2).filter(|room| sign < 0 && *room < 0),
        };
        let lifts_any = |at: &usize| {
            let lifts =
                |(to, bound): &(u32, Bound)| fall(*bound).is_some_and(|f| heights[*at] - f > heights[*to as usize]);
            bounds.of(*at).iter().any(lifts)
        };
        let mut open: BinaryHeap<(i64, Reverse<usize>)> =
            (0..heights.len()).filter(lifts_any).map(|at| (heights[at], Reverse(at))).collect();
        while let Some((height, Reverse(at))) = open.pop() {
            if heights[at] != height {
                continue;
            }
            for (to, bound) in bounds.of(at) {
                let (to, least) = (*to as usize, fall(*bound).map(|fall| height - fall));
                let Some(least) = least.filter(|least| *least > heights[to]) else { continue };
                if let Bound::Above(i) | Bound::Below(i) = *bound {
                    let lifts = &mut lifts[i as usize];
                    *lifts += 1;
                    if *lifts > MOST_LIFTS {
                        continue;
                    }
                }
                heights[to] = least;
                open.push((least, Reverse(to)));
            }
        }
        heights
    }

    /// Per place what it binds: its neighbours on roads, and what lies above and below.
    fn bounds(&self) -> Bounds {
        let mut first = vec![0; self.wanted.len() + 1];
        let pairs = self.climbs().chain(self.rooms.iter().copied());
        pairs.flat_map(|(a, b, _)| [a, b]).for_each(|place| first[place + 1] += 1);
        for place in 0..self.wanted.len() {
            first[place + 1] += first[place];
        }
        let mut next = first.clone();
        let mut all = vec![(0, Bound::Climb(0)); first.last().map_or(0, |count| *count as usize)];
        let mut bind = |at: usize, to: usize, bound: Bound| {
            all[next[at] as usize] = (to as u32, bound);
            next[at] += 1;
        };
        for (a, b, most) in self.climbs() {
            let most = u32::try_from(most).unwrap_or(u32::MAX);
            bind(a, b, Bound::Climb(most));
            bind(b, a, Bound::Climb(most));
        }
        for ((low, high, _), i) in self.rooms.iter().zip(0..) {
            bind(*low, *high, Bound::Above(i));
            bind(*high, *low, Bound::Below(i));
        }
        Bounds { first, all }
    }
}
