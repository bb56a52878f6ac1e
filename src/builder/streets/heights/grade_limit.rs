//! Limits the grades: finds the heights nearest to the wanted ones at which no road climbs more than it may.
//!
//! Places are *raised* to the least heights above the wanted ones that keep every grade, and *lowered* to the greatest heights
//! below them that do. The mean of both keeps the grades, too, and changes nothing where no grade is too steep. Around a
//! steep part it changes more than needed, so only the places between which a limit is broken take the mean; all others stay
//! as near to the wanted heights as these allow.
//!
//! The clearance between roads that cross is a limit of the same kind, on a step instead of a length. It yields if the grades
//! leave no room for it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::RangeInclusive;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::{End, Intersection, IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::parallel::InSmallParts;

use super::crossings::Overpass;
use super::options::ROUNDED_SAMPLES;

/// Heights are integers of a tenth of a millimetre, which have an order.
const UNITS_PER_METRE: f64 = 1e4;
/// A crossing that lifted its upper road more often lifts itself: the two roads are connected by too short a road.
const MOST_LIFTS: u32 = 6;
/// The clearance of such a crossing is reduced in this number of steps.
const PARTS: i64 = 4;
/// Steps of one spread for each place: a place is visited again after each lift, but in the extracts once or twice.
/// Beyond that, the clearances that still lift are reduced: bridges by the hundred above each other on one ramp.
const MOST_VISITS: usize = 4;

/// Heights along one road, from end to end.
#[derive(Clone, Debug)]
pub struct SampledHeights {
    /// Metres; not all equal.
    pub stations: Vec<f64>,
    /// Wanted heights, metres.
    pub wanted: Vec<f64>,
    /// The most that the road may climb from each station to the next, metres.
    pub climbs: Vec<f64>,
}

impl SampledHeights {
    /// The sample nearest to a station.
    fn nearest(&self, station: f64) -> usize {
        let after = self.stations.partition_point(|s| *s < station).min(self.stations.len() - 1);
        let before = after.saturating_sub(1);
        if station - self.stations[before] < self.stations[after] - station { before } else { after }
    }

    /// The samples from which the height at a station is averaged.
    fn around(&self, station: f64) -> RangeInclusive<usize> {
        let nearest = self.nearest(station);
        nearest.saturating_sub(ROUNDED_SAMPLES)..=(nearest + ROUNDED_SAMPLES).min(self.wanted.len() - 1)
    }
}

/// The places along one road: the intersections at its ends, and consecutive places between them.
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

/// Least height of one place above another.
struct Clearance {
    low: usize,
    high: usize,
    /// In units.
    room: i64,
}

/// A clearance as it moves one of its places: `other` is raised (`sign` 1) or lowered (-1) because of `place`.
struct ClearanceLimit {
    place: usize,
    other: usize,
    clearance: usize,
    sign: i64,
}

/// Limits between the ends of roads at one intersection.
#[derive(Clone, Copy)]
pub struct EndTies<'a> {
    /// Per road: the stations of its cuts.
    pub kept: &'a [Stations],
    /// The most that one of two ends may lie above the other, metres. Slow, so few are computed.
    pub climb: &'a (dyn Fn(RoadEnd, RoadEnd) -> f64 + Sync),
    /// Smaller differences are always allowed, metres.
    pub least: f64,
}

/// All places with a height, intersections first, and the limits between them.
pub struct HeightGraph<'a> {
    network: &'a RoadNetwork,
    sampled: &'a [SampledHeights],
    chains: Vec<Chain>,
    /// In units.
    wanted: Vec<i64>,
    ties: Option<EndTies<'a>>,
    clearances: Vec<Clearance>,
}

impl<'a> HeightGraph<'a> {
    /// The places of all roads, with a clearance of `storey` metres per level at crossings.
    pub fn new(network: &'a RoadNetwork, sampled: &'a [SampledHeights], crossings: &[Overpass], storey: f64) -> Self {
        let inner = |of: &SampledHeights| of.wanted.len().saturating_sub(2);
        let mut wanted = vec![0; network.intersections.len()];
        wanted.reserve_exact(sampled.iter().map(inner).sum());
        let mut chains = Vec::with_capacity(sampled.len());
        for (road, of) in network.roads.iter().zip(sampled) {
            let ends = [road.from, road.to].map(IntersectionIx::position);
            let chain = Chain { ends, first: wanted.len(), inner: inner(of) };
            wanted.resize(chain.first + chain.inner, 0);
            for (i, height) in of.wanted.iter().enumerate() {
                wanted[chain.place(i)] = units(*height);
            }
            chains.push(chain);
        }
        let mut graph = Self { network, sampled, chains, wanted, ties: None, clearances: Vec::new() };
        for Overpass { upper, lower, levels, .. } in crossings {
            let room = units(levels * storey);
            let [high, low] = [upper, lower].map(|(road, station)| graph.place_at(*road, *station));
            let [above, below] = [upper, lower].map(|(road, station)| {
                let places = sampled[*road].around(*station).map(|i| graph.chains[*road].place(i));
                places.collect::<Vec<usize>>()
            });
            let above = above.into_iter().map(|high| Clearance { low, high, room });
            let below = below.into_iter().filter(|place| *place != low).map(|low| Clearance { low, high, room });
            graph.clearances.extend(above.chain(below));
        }
        graph
    }

    /// The place nearest to a station of a road, metres.
    fn place_at(&self, road: usize, station: f64) -> usize {
        self.chains[road].place(self.sampled[road].nearest(station))
    }

    /// Reduces the clearances to what the wanted heights leave.
    pub fn reduce_clearances(&mut self) {
        for Clearance { low, high, room } in &mut self.clearances {
            *room = (*room).min(self.wanted[*high] - self.wanted[*low]);
        }
    }

    /// Adds limits between the ends of roads.
    pub fn tie(&mut self, ties: EndTies<'a>) {
        self.ties = Some(ties);
    }

    /// The place where a road is cut.
    fn cut_place(&self, ties: &EndTies<'_>, arm: RoadEnd) -> usize {
        self.place_at(arm.road.position(), ties.kept[arm.road][arm.end])
    }

    fn difference(&self, a: usize, b: usize) -> i64 {
        (self.wanted[a] - self.wanted[b]).abs()
    }

    /// The cuts at an intersection whose heights differ too much.
    fn steep_cuts(&self, ties: &EndTies<'_>, Intersection { arms, .. }: &Intersection) -> Vec<usize> {
        let cuts: Vec<usize> = arms.iter().map(|arm| self.cut_place(ties, *arm)).collect();
        let steep = pairs(cuts.len()).filter(|&(i, j)| {
            let difference = self.difference(cuts[i], cuts[j]);
            difference > units(ties.least) && difference > units((ties.climb)(arms[i], arms[j]))
        });
        steep.flat_map(|(i, j)| [cuts[i], cuts[j]]).collect()
    }

    /// The places tied to a place, with the most by which their heights may differ.
    fn tied(&self, place: usize) -> Vec<(usize, i64)> {
        let Some(ties) = &self.ties else { return Vec::new() };
        let roads: Vec<RoadIx> = match self.network.intersections.get(place) {
            Some(intersection) => intersection.arms.iter().map(|arm| arm.road).collect(),
            None => vec![RoadIx::new(self.road_of(place))],
        };
        let ends = roads.into_iter().flat_map(|road| End::BOTH.map(|end| RoadEnd { road, end }));
        let ends = ends.filter(|arm| self.cut_place(ties, *arm) == place);
        let mut around: Vec<IntersectionIx> = ends.map(|arm| self.network.intersection_at(arm)).collect();
        around.sort_unstable();
        around.dedup();
        let mut tied = Vec::new();
        for arms in around.into_iter().map(|ix| &self.network.intersection(ix).arms) {
            for (a, b) in arms.iter().enumerate().flat_map(|(i, a)| arms[i + 1..].iter().map(move |b| (*a, *b))) {
                let [first, second] = [a, b].map(|arm| self.cut_place(ties, arm));
                if [first, second].contains(&place) {
                    let most = units((ties.climb)(a, b));
                    let directions = [(first, second), (second, first)].into_iter();
                    tied.extend(directions.filter(|(from, _)| *from == place).map(|(_, to)| (to, most)));
                }
            }
        }
        tied
    }

    /// The heights of every road within the grades, metres, and with the clearances as far as possible.
    pub fn heights(mut self) -> Vec<Vec<f64>> {
        self.limit();
        let height = |place: usize| self.wanted[place] as f64 / UNITS_PER_METRE;
        let along = |chain: &Chain| (0..chain.inner + 2).map(|i| height(chain.place(i))).collect();
        self.chains.par_iter().in_small_parts().map(along).collect()
    }

    /// Replaces the wanted heights by the nearest ones within all limits.
    fn limit(&mut self) {
        let steep = self.steep();
        let mut broken = self.broken(&steep);
        if broken.is_empty() {
            return;
        }
        let parts: Vec<i64> = self.clearances.iter().map(|clearance| (clearance.room + PARTS - 1) / PARTS).collect();
        let limits = self.clearance_limits();
        let mut tied = FxHashMap::default();
        let [raised, lowered] = loop {
            let mut lifts = vec![0; self.clearances.len()];
            let moved =
                [1, -1].map(|sign| self.spread(&limits, &mut tied, FxHashMap::default(), (sign, &broken), &mut lifts));
            if lifts.iter().all(|lifts| *lifts <= MOST_LIFTS) {
                break moved;
            }
            for ((clearance, lifts), part) in self.clearances.iter_mut().zip(lifts).zip(&parts) {
                clearance.room -= if lifts > MOST_LIFTS { *part } else { 0 };
            }
            broken = self.broken(&steep);
        };
        // The mean where a limit is broken; the others follow as far as they must. The middle one of three heights, place by
        // place, keeps every limit that all three keep.
        let mean = |place: &usize| {
            let [high, low] = [&raised, &lowered].map(|moved| moved.get(place).unwrap_or(&self.wanted[*place]));
            (*place, (high + low).div_euclid(2))
        };
        let mut moved = broken.iter().map(mean).collect();
        let mut lifts = vec![0; self.clearances.len()];
        for sign in [1, -1] {
            moved = self.spread(&limits, &mut tied, moved, (sign, &broken), &mut lifts);
        }
        for (place, height) in moved {
            self.wanted[place] = height;
        }
    }

    /// The places between which the wanted heights climb too much.
    fn steep(&self) -> Vec<usize> {
        let chains = self.chains.par_iter().in_small_parts().zip(self.sampled);
        let mut steep: Vec<usize> = chains.flat_map_iter(|(chain, sampled)| self.steep_along(chain, sampled)).collect();
        if let Some(ties) = &self.ties {
            let intersections = self.network.intersections.par_iter().in_small_parts();
            steep.par_extend(intersections.flat_map_iter(|intersection| self.steep_cuts(ties, intersection)));
        }
        steep
    }

    fn steep_along(&self, chain: &Chain, sampled: &SampledHeights) -> impl Iterator<Item = usize> {
        let pairs = sampled.climbs.iter().enumerate().map(|(i, climb)| ([chain.place(i), chain.place(i + 1)], climb));
        let steep = pairs.filter(|&([a, b], climb)| {
            let difference = self.difference(a, b);
            // Most pairs are level.
            difference > 0 && difference > most(*climb)
        });
        steep.flat_map(|(ends, _)| ends)
    }

    /// The places whose wanted heights break a limit, given those that are too steep.
    fn broken(&self, steep: &[usize]) -> Vec<usize> {
        let short = self.clearances.iter().filter(|c| c.room > 0 && self.wanted[c.high] - self.wanted[c.low] < c.room);
        let mut broken: Vec<usize> = steep.iter().copied().chain(short.flat_map(|c| [c.low, c.high])).collect();
        broken.sort_unstable();
        broken.dedup();
        broken
    }

    /// Raises (`sign` 1) or lowers (-1) places by the least that keeps the limits around the places `from`, and around those
    /// that move. `tied` keeps what is tied to each place visited. `lifts` counts how often each clearance moved a place; beyond
    /// the most it moves none.
    fn spread(
        &self,
        limits: &[ClearanceLimit],
        tied: &mut FxHashMap<usize, Vec<(usize, i64)>>,
        moved: FxHashMap<usize, i64>,
        (sign, from): (i64, &[usize]),
        lifts: &mut [u32],
    ) -> FxHashMap<usize, i64> {
        lifts.iter_mut().for_each(|lifts| *lifts = if *lifts > MOST_LIFTS { *lifts } else { 0 });
        let visits = MOST_VISITS * self.wanted.len();
        let mut spread = Spread { wanted: &self.wanted, sign, moved, lifts, visits, open: BinaryHeap::new() };
        spread.open = from.iter().map(|&place| (spread.height(place), Reverse(place))).collect();
        while let Some((height, Reverse(place))) = spread.open.pop() {
            if spread.height(place) != height {
                continue;
            }
            spread.visits = spread.visits.saturating_sub(1);
            self.neighbours(place, |to, most| spread.pull(to, height - most, None));
            let tied = tied.entry(place).or_insert_with(|| self.tied(place));
            tied.iter().for_each(|&(to, most)| spread.pull(to, height - most, None));
            let first = limits.partition_point(|limit| limit.place < place);
            for limit in limits[first..].iter().take_while(|limit| limit.place == place) {
                let room = self.clearances[limit.clearance].room;
                if limit.sign == sign && room > 0 {
                    spread.pull(limit.other, height + room, Some(limit.clearance));
                }
            }
        }
        spread.moved
    }

    /// Calls `each` with the neighbours of a place on its roads, and the most that is climbed between them.
    fn neighbours(&self, place: usize, mut each: impl FnMut(usize, i64)) {
        let mut step = |road: usize, i: usize, next: usize| {
            each(self.chains[road].place(next), most(self.sampled[road].climbs[i.min(next)]));
        };
        if let Some(intersection) = self.network.intersections.get(place) {
            for RoadEnd { road, end } in &intersection.arms {
                let road = road.position();
                let last = self.chains[road].inner + 1;
                match end {
                    End::Start => step(road, 0, 1),
                    End::End => step(road, last, last - 1),
                }
            }
        } else {
            let road = self.road_of(place);
            let i = place - self.chains[road].first + 1;
            step(road, i, i - 1);
            step(road, i, i + 1);
        }
    }

    /// The road of a place that is not an intersection.
    fn road_of(&self, place: usize) -> usize {
        self.chains.partition_point(|chain| chain.first <= place) - 1
    }

    /// Both limits of every clearance, in order of their places.
    fn clearance_limits(&self) -> Vec<ClearanceLimit> {
        let limits = self.clearances.iter().enumerate().flat_map(|(clearance, &Clearance { low, high, .. })| {
            let above = ClearanceLimit { place: low, other: high, clearance, sign: 1 };
            [above, ClearanceLimit { place: high, other: low, clearance, sign: -1 }]
        });
        let mut limits: Vec<ClearanceLimit> = limits.collect();
        limits.par_sort_by_key(|limit| limit.place);
        limits
    }
}

/// The state of one spread. Heights are multiplied by its sign.
struct Spread<'a> {
    wanted: &'a [i64],
    sign: i64,
    moved: FxHashMap<usize, i64>,
    lifts: &'a mut [u32],
    /// Places that may be visited before no clearance lifts any more.
    visits: usize,
    open: BinaryHeap<(i64, Reverse<usize>)>,
}

impl Spread<'_> {
    fn height(&self, place: usize) -> i64 {
        self.sign * self.moved.get(&place).unwrap_or(&self.wanted[place])
    }

    /// Moves a place to `least` if it lies below that.
    fn pull(&mut self, place: usize, least: i64, clearance: Option<usize>) {
        if least <= self.height(place) {
            return;
        }
        if let Some(clearance) = clearance {
            self.lifts[clearance] += if self.visits == 0 { MOST_LIFTS + 1 } else { 1 };
            if self.lifts[clearance] > MOST_LIFTS {
                return;
            }
        }
        self.moved.insert(place, self.sign * least);
        self.open.push((least, Reverse(place)));
    }
}

/// All pairs of different indices below `count`.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(|j| (0..j).map(move |i| (i, j)))
}

/// The most that a road climbs between two places, in units.
fn most(climb: f64) -> i64 {
    units(climb).min(i64::from(u32::MAX)) + 1
}

fn units(metres: f64) -> i64 {
    (metres * UNITS_PER_METRE).round() as i64
}
