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

use crate::builder::road_network::RoadNetwork;

use super::crossings::Crossing;
use super::{HeightOptions, REACH};

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
    /// The ground, metres.
    pub ground: Vec<f64>,
    /// Where the road is to lie, metres.
    pub wanted: Vec<f64>,
    /// The stations between the intersections at its ends.
    pub kept: [f64; 2],
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

/// What binds the height of one place to that of another.
#[derive(Clone, Copy)]
enum Bound {
    /// A way along a road, and the most that it climbs.
    Climb(i64),
    /// The other place lies on the road over this one: the crossing's index.
    Above(usize),
    /// The other place lies on the road below this one.
    Below(usize),
}

/// All places with a height, the intersections first, and how they bind each other.
pub struct Web<'a> {
    network: &'a RoadNetwork,
    sampled: &'a [Sampled],
    /// Per road the first of the places between its ends.
    inner: Vec<usize>,
    wanted: Vec<i64>,
    /// Pairs of places with the most that one may lie above the other.
    climbs: Vec<(usize, usize, i64)>,
    /// Lower and upper place of every crossing, and the room asked between them.
    rooms: Vec<(usize, usize, i64)>,
}

impl<'a> Web<'a> {
    /// The places of all roads, the grades between them, and the room at crossings.
    pub fn new(
        network: &'a RoadNetwork,
        sampled: &'a [Sampled],
        crossings: &[Crossing],
        options: &HeightOptions,
    ) -> Self {
        let mut next = network.intersections.len();
        let mut inner = Vec::with_capacity(sampled.len());
        for road in sampled {
            inner.push(next);
            next += road.wanted.len().saturating_sub(2);
        }
        let (wanted, climbs, rooms) = (vec![0; next], Vec::with_capacity(next), Vec::new());
        let mut web = Self { network, sampled, inner, wanted, climbs, rooms };
        for (i, road) in network.roads.iter().enumerate() {
            web.add(i, [options.grade_of(road), options.steepest_of(road)]);
        }
        for Crossing { upper: (upper, above), lower: (lower, below), levels, .. } in crossings {
            let room = units(levels * options.storey);
            let [high, low] = [web.at((*upper, *above)), web.at((*lower, *below))];
            let over = sampled[*upper].around(*above).map(|i| (low, web.place(*upper, i), room));
            let under = sampled[*lower].around(*below).map(|i| web.place(*lower, i)).filter(|at| *at != low);
            let rooms: Vec<_> = over.chain(under.map(|low| (low, high, room))).collect();
            web.rooms.extend(rooms);
        }
        web
    }

    /// The wanted heights of a road, and what it may climb: by a ramp, and at most.
    fn add(&mut self, road: usize, [usual, most]: [f64; 2]) {
        let Sampled { stations, ground, wanted, kept } = &self.sampled[road];
        for (i, height) in wanted.iter().enumerate() {
            let place = self.place(road, i);
            self.wanted[place] = units(*height);
        }
        for (i, pair) in stations.windows(2).enumerate() {
            let (length, middle) = (pair[1] - pair[0], (pair[0] + pair[1]) / 2.0);
            // Between intersections a road may climb as the ground does; these are built as level as ramps allow.
            let ground = match (kept[0]..=kept[1]).contains(&middle) {
                true => (ground[i + 1] - ground[i]).abs(),
                false => 0.0,
            };
            let climb = ground.min(most * length).max(usual * length);
            self.climbs.push((self.place(road, i), self.place(road, i + 1), units(climb) + 1));
        }
    }

    /// A place by the road and its index there.
    fn place(&self, road: usize, i: usize) -> usize {
        let ends = &self.network.roads[road];
        match i {
            0 => ends.from.0 as usize,
            i if i + 1 == self.sampled[road].stations.len() => ends.to.0 as usize,
            i => self.inner[road] + i - 1,
        }
    }

    /// The place nearest to a station of a road.
    fn at(&self, (road, station): OnRoad) -> usize {
        self.place(road, self.sampled[road].nearest(station))
    }

    /// Lets everything stay as it is wanted that breaks a bound.
    pub fn loosen(&mut self) {
        let wanted = &self.wanted;
        for (a, b, climb) in &mut self.climbs {
            *climb = (*climb).max((wanted[*a] - wanted[*b]).abs());
        }
        for (low, high, room) in &mut self.rooms {
            *room = (*room).min(wanted[*high] - wanted[*low]);
        }
    }

    /// Lets two places differ by so many metres at most.
    pub fn tie(&mut self, [a, b]: [OnRoad; 2], climb: f64) {
        let tie = (self.at(a), self.at(b), units(climb));
        self.climbs.push(tie);
    }

    /// Heights of every road that hold the grades, and the room at crossings where it can be had.
    pub fn heights(&mut self) -> Vec<Vec<f64>> {
        let held = self.held();
        let height = |road: usize, i: usize| held[self.place(road, i)] as f64 / PER_METRE;
        let along = |road: usize| (0..self.sampled[road].stations.len()).map(|i| height(road, i)).collect();
        (0..self.sampled.len()).map(along).collect()
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
        let steep = self.climbs.iter().any(|(a, b, climb)| (self.wanted[*a] - self.wanted[*b]).abs() > *climb);
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
    fn nearest(&self, bounds: &[Vec<(usize, Bound)>], mean: impl Iterator<Item = i64>) -> Vec<i64> {
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
        for (a, b, most) in &self.climbs {
            if (self.wanted[*a] - self.wanted[*b]).abs() > *most {
                (broken[*a], broken[*b]) = (true, true);
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
    fn raised(&self, bounds: &[Vec<(usize, Bound)>], mut heights: Vec<i64>, sign: i64, lifts: &mut [u32]) -> Vec<i64> {
        lifts.iter_mut().for_each(|lifts| *lifts = if *lifts > MOST_LIFTS { *lifts } else { 0 });
        let fall = |bound: Bound| match bound {
            Bound::Climb(most) => Some(most),
            Bound::Above(i) => (sign > 0 && self.rooms[i].2 > 0).then(|| -self.rooms[i].2),
            Bound::Below(i) => (sign < 0 && self.rooms[i].2 > 0).then(|| -self.rooms[i].2),
        };
        let lifts_any = |at: &usize| {
            let lifts = |(to, bound): &(usize, Bound)| fall(*bound).is_some_and(|f| heights[*at] - f > heights[*to]);
            bounds[*at].iter().any(lifts)
        };
        let mut open: BinaryHeap<(i64, Reverse<usize>)> =
            (0..heights.len()).filter(lifts_any).map(|at| (heights[at], Reverse(at))).collect();
        while let Some((height, Reverse(at))) = open.pop() {
            if heights[at] != height {
                continue;
            }
            for (to, bound) in &bounds[at] {
                let Some(least) = fall(*bound).map(|fall| height - fall).filter(|least| *least > heights[*to]) else {
                    continue;
                };
                if let Bound::Above(i) | Bound::Below(i) = *bound {
                    lifts[i] += 1;
                    if lifts[i] > MOST_LIFTS {
                        continue;
                    }
                }
                heights[*to] = least;
                open.push((least, Reverse(*to)));
            }
        }
        heights
    }

    /// Per place what it binds.
    fn bounds(&self) -> Vec<Vec<(usize, Bound)>> {
        let mut bounds = vec![Vec::new(); self.wanted.len()];
        for (a, b, most) in &self.climbs {
            bounds[*a].push((*b, Bound::Climb(*most)));
            bounds[*b].push((*a, Bound::Climb(*most)));
        }
        for (i, (low, high, _)) in self.rooms.iter().enumerate() {
            bounds[*low].push((*high, Bound::Above(i)));
            bounds[*high].push((*low, Bound::Below(i)));
        }
        bounds
    }
}
