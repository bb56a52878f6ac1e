//! The streets of a random town: a bent grid, with carriageways apart, turn lanes, roundabouts, doglegs and missing pieces.

use super::dice::Dice;
use super::plan::{Place, Plan, angle, between, distance, heading, plus};

/// The lanes of a street along it and against it, and its other tags. No lanes along it: no `lanes` tag.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    lanes: [u8; 2],
    one_way: bool,
    tags: &'static str,
}

const fn two_way(forward: u8, backward: u8, tags: &'static str) -> Section {
    Section { lanes: [forward, backward], one_way: false, tags }
}

const fn one_way(lanes: u8, tags: &'static str) -> Section {
    Section { lanes: [lanes, 0], one_way: true, tags }
}

const TWO_WAY: [Section; 16] = [
    two_way(0, 0, "highway=residential"),
    two_way(0, 0, "highway=residential sidewalk=both parking:both=lane"),
    two_way(0, 0, "highway=unclassified width=7 parking:right=lane"),
    two_way(0, 0, "highway=service"),
    two_way(0, 0, "highway=living_street"),
    two_way(0, 0, "highway=residential lanes=1 width=4"),
    two_way(1, 1, "highway=tertiary sidewalk=both"),
    two_way(1, 1, "highway=secondary cycleway:right=lane maxspeed=50"),
    two_way(1, 1, "highway=tertiary cycleway:both=track"),
    two_way(2, 2, "highway=secondary"),
    two_way(2, 1, "highway=primary"),
    two_way(2, 2, "highway=tertiary turn:lanes:forward=left|through;right"),
    two_way(2, 2, "highway=secondary busway:both=lane"),
    two_way(2, 2, "highway=primary bus:lanes:forward=yes|designated lanes:psv:backward=1"),
    two_way(1, 1, "highway=secondary lanes:both_ways=1 turn:lanes:both_ways=left"),
    two_way(3, 2, "highway=primary embedded_rails=tram"),
];
const ONE_WAY: [Section; 6] = [
    one_way(0, "highway=residential"),
    one_way(0, "highway=residential oneway:bicycle=no cycleway:left=opposite_lane"),
    one_way(2, "highway=tertiary"),
    one_way(2, "highway=secondary parking:right=lane"),
    one_way(3, "highway=secondary lanes:psv=1"),
    one_way(3, "highway=primary turn:lanes=left|through|right"),
];
/// Carriageways of streets that have two.
const DIVIDED: [Section; 6] = [
    one_way(1, "highway=tertiary"),
    one_way(2, "highway=secondary"),
    one_way(2, "highway=primary cycleway:right=lane"),
    one_way(3, "highway=primary"),
    one_way(3, "highway=trunk busway=lane"),
    one_way(2, "highway=secondary placement=right_of:1"),
];
/// Tags of crossings; most have none.
const SIGNS: [&str; 8] =
    ["highway=traffic_signals", "highway=traffic_signals", "highway=stop", "highway=mini_roundabout", "", "", "", ""];

impl Section {
    /// The tags, with so many more lanes before the end of the way.
    fn tags(&self, more: u8) -> String {
        let [forward, backward] = self.lanes;
        let mut tags = self.tags.to_owned();
        if self.one_way {
            tags += " oneway=yes";
        }
        if forward > 0 {
            let lanes = forward + more + backward + u8::from(tags.contains("both_ways"));
            tags += &format!(" lanes={lanes}");
            if !self.one_way {
                tags += &format!(" lanes:forward={} lanes:backward={backward}", forward + more);
            }
        }
        tags
    }

    /// The tags of a piece with a lane more for those who turn, which the arrows tell.
    fn with_turn_lane(&self, left_hand: bool, dice: &mut Dice) -> Option<String> {
        if self.lanes[0] == 0 || self.tags.contains("turn:") || self.tags.contains("bus") || self.tags.contains("psv") {
            return None;
        }
        let (near, far) = if left_hand { ("left", "right") } else { ("right", "left") };
        let (turn, other) = if dice.chance(0.7) { (far, near) } else { (near, far) };
        let mut arrows = vec!["through".to_owned(); usize::from(self.lanes[0])];
        let beside = if turn == "left" { arrows.len() - 1 } else { 0 };
        if dice.chance(0.6) {
            arrows[beside] += &format!(";{other}");
        }
        arrows.insert(if turn == "left" { 0 } else { arrows.len() }, turn.to_owned());
        let key = if self.one_way { "turn:lanes" } else { "turn:lanes:forward" };
        Some(format!("{} {key}={}", self.tags(1), arrows.join("|")))
    }
}

/// A street from one edge of the town to the other.
#[derive(Debug)]
struct Street {
    section: Section,
    /// Metres between the middles of two carriageways, and up to which crossing there are two.
    divided: Option<(f64, usize)>,
    /// Its blocks that do not exist.
    missing: Option<usize>,
}

/// A piece of carriageway from one crossing to the next.
pub struct Block {
    /// The street runs to the north, which of them, which block of it, which carriageway from the west or south.
    pub key: (bool, usize, usize, usize),
    pub way: usize,
}

/// Where the arms of a crossing begin: to the east, north, west and south, by carriageway.
#[derive(Clone, Default)]
pub struct Crossing {
    pub arms: [Vec<usize>; 4],
    pub center: Place,
    /// Neither a roundabout nor a crossing of streets with two carriageways.
    pub plain: Option<usize>,
    /// The nodes of a roundabout.
    pub ring: Vec<usize>,
}

pub struct Grid {
    pub plan: Plan,
    pub dice: Dice,
    pub left_hand: bool,
    pub side: usize,
    pub spacing: f64,
    streets: [Vec<Street>; 2],
    pub crossings: Vec<Crossing>,
    pub blocks: Vec<Block>,
}

impl Grid {
    pub fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let (left_hand, side, spacing) = (dice.chance(0.5), 3 + dice.below(2), dice.between(70.0, 140.0));
        let streets = [false, true].map(|_| (0..side).map(|at| any_street(&mut dice, at, side)).collect());
        let (crossings, blocks) = (Vec::new(), Vec::new());
        let mut grid = Self { plan: Plan::default(), dice, left_hand, side, spacing, streets, crossings, blocks };
        for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
            let crossing = grid.crossing(x, y);
            grid.crossings.push(crossing);
        }
        for north in [false, true] {
            for (at, block) in (0..side).flat_map(|at| (0..side - 1).map(move |block| (at, block))) {
                grid.block(north, at, block);
            }
        }
        grid
    }

    /// How far to either side of its middle the carriageways of a street lie at a crossing.
    fn offsets(&self, north: bool, at: usize, crossing: usize) -> Vec<f64> {
        match self.streets[usize::from(north)][at].divided {
            Some((gap, last)) if crossing <= last => vec![-gap / 2.0, gap / 2.0],
            _ => vec![0.0],
        }
    }

    fn crossing(&mut self, x: usize, y: usize) -> Crossing {
        let mut moved = || self.dice.between(-0.12, 0.12) * self.spacing;
        let center = plus([moved(), moved()], [x as f64, y as f64], self.spacing);
        let [across, up] = [self.offsets(true, x, y), self.offsets(false, y, x)];
        let single = across.len() == 1 && up.len() == 1;
        if self.dice.chance(0.1) {
            return self.roundabout(center, [&up, &across], y);
        }
        if single && self.dice.chance(0.12) {
            return self.dogleg(center, y);
        }
        let signs = self.dice.pick(&SIGNS);
        let sign = if single { signs } else { signs.trim_end_matches("highway=mini_roundabout") };
        let mut nodes: Vec<Vec<usize>> = Vec::new();
        for east in &across {
            let row = up.iter().map(|north| {
                let twisted = if single { 0.0 } else { 1.5 };
                let off = [east + self.dice.between(-twisted, twisted), north + self.dice.between(-twisted, twisted)];
                self.plan.node(plus(center, off, 1.0), sign)
            });
            nodes.push(row.collect());
        }
        for (a, row) in nodes.iter().filter(|row| row.len() > 1).enumerate() {
            self.inner([row[0], row[1]], (true, x, a));
        }
        if let [west, east] = &nodes[..] {
            for (b, pair) in west.iter().zip(east).enumerate() {
                self.inner([*pair.0, *pair.1], (false, y, b));
            }
        }
        let column = |b: usize| nodes.iter().map(|row| row[b]).collect::<Vec<_>>();
        let arms = [nodes[nodes.len() - 1].clone(), column(up.len() - 1), nodes[0].clone(), column(0)];
        Crossing { arms, center, plain: single.then(|| nodes[0][0]), ring: Vec::new() }
    }

    /// A piece of a carriageway within a crossing.
    fn inner(&mut self, nodes: [usize; 2], (north, at, carriageway): (bool, usize, usize)) {
        let street = &self.streets[usize::from(north)][at];
        let (section, divided) = (street.section, street.divided.is_some());
        let way = self.plan.way(nodes.to_vec(), &section.tags(0));
        self.plan.ways[way].reversed = divided && self.against(north, carriageway);
    }

    /// Whether one drives on this carriageway to the south or west.
    fn against(&self, north: bool, carriageway: usize) -> bool {
        (carriageway == 1) != north ^ self.left_hand
    }

    fn roundabout(&mut self, center: Place, offsets: [&Vec<f64>; 2], y: usize) -> Crossing {
        let widest = offsets.iter().flat_map(|offsets| offsets.iter()).fold(0.0, |most: f64, off| most.max(off.abs()));
        let radius = self.dice.between(7.0, 18.0).max(widest * 1.5);
        let mut crossing = Crossing { center, ..Crossing::default() };
        let mut ring: Vec<(f64, usize)> = Vec::new();
        for arm in 0..4 {
            let to = arm as f64 * std::f64::consts::FRAC_PI_2;
            for off in offsets[arm % 2] {
                let aside = (off / radius).asin() * if arm == 0 || arm == 3 { 1.0 } else { -1.0 };
                let around = to + aside + self.dice.between(-0.15, 0.15);
                let node = self.plan.node(plus(center, heading(around), radius), "");
                ring.push((around.rem_euclid(std::f64::consts::TAU), node));
                crossing.arms[arm].push(node);
            }
        }
        for part in 0..4 {
            let around = (part as f64 + self.dice.between(0.4, 0.6)) * std::f64::consts::FRAC_PI_2;
            ring.push((around, self.plan.node(plus(center, heading(around), radius), "")));
        }
        ring.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut nodes: Vec<usize> = ring.into_iter().map(|(_, node)| node).collect();
        nodes.push(nodes[0]);
        let class = self.streets[0][y].section.tags.split(' ').next().unwrap();
        let lanes = if self.dice.chance(0.2) { " lanes=2" } else { "" };
        let way = self.plan.way(nodes.clone(), &format!("{class} junction=roundabout oneway=yes{lanes}"));
        self.plan.ways[way].reversed = self.left_hand;
        crossing.ring = nodes;
        crossing
    }

    /// A crossing whose northern arm begins a little aside from its southern one.
    fn dogleg(&mut self, center: Place, y: usize) -> Crossing {
        let (aside, turned) = (self.dice.between(3.0, 14.0), self.dice.chance(0.5));
        let west = self.plan.node(plus(center, [-aside, 0.0], 1.0), "");
        let east = self.plan.node(plus(center, [aside, self.dice.between(-2.0, 2.0)], 1.0), "");
        let tags = self.streets[0][y].section.tags(0);
        self.plan.way(vec![west, east], &tags);
        let (north, south) = if turned { (west, east) } else { (east, west) };
        Crossing { arms: [vec![east], vec![north], vec![west], vec![south]], center, ..Crossing::default() }
    }

    /// The carriageways of a street from a crossing to the next.
    fn block(&mut self, north: bool, at: usize, block: usize) {
        let street = &self.streets[usize::from(north)][at];
        let (section, divided) = (street.section, street.divided);
        if street.missing == Some(block) {
            return;
        }
        let index = |to: usize| if north { at * self.side + to } else { to * self.side + at };
        let [leave, reach] = if north { [1, 3] } else { [0, 2] };
        let from = self.crossings[index(block)].arms[leave].clone();
        let to = self.crossings[index(block + 1)].arms[reach].clone();
        if from.len() == to.len() {
            for (carriageway, (a, b)) in from.into_iter().zip(to).enumerate() {
                let way = self.bent(a, b, section, divided.is_some() && self.against(north, carriageway));
                self.blocks.push(Block { key: (north, at, block, carriageway), way });
            }
            return;
        }
        // Two carriageways become one.
        let apart = between(self.plan.place(from[0]), self.plan.place(from[1]), 0.5);
        let place = between(apart, self.plan.place(to[0]), self.dice.between(0.35, 0.7));
        let join = self.plan.node(place, "");
        for (carriageway, a) in from.into_iter().enumerate() {
            self.bent(a, join, section, self.against(north, carriageway));
        }
        let rest = Section { lanes: [section.lanes[0]; 2], one_way: false, tags: "highway=secondary" };
        let way = self.bent(join, to[0], rest, false);
        self.blocks.push(Block { key: (north, at, block, 0), way });
    }

    /// A way between two nodes with bends as people draw them; its ends may have a lane more.
    fn bent(&mut self, a: usize, b: usize, section: Section, reversed: bool) -> usize {
        let [from, to] = [self.plan.place(a), self.plan.place(b)];
        let (length, aside) = (distance(from, to), heading(angle(from, to) + std::f64::consts::FRAC_PI_2));
        let mut parts: Vec<f64> = (0..self.dice.below(4)).map(|_| self.dice.between(0.05, 0.95)).collect();
        parts.sort_by(f64::total_cmp);
        parts.dedup_by(|a, b| (*a - *b) * length < 4.0);
        let bend = if self.dice.chance(0.4) { self.dice.between(-0.3, 0.3) } else { 0.0 };
        let places: Vec<Place> = parts
            .iter()
            .map(|part| {
                let off = bend * length * part * (1.0 - part) + self.dice.between(-0.5, 0.5);
                plus(between(from, to, *part), aside, off)
            })
            .collect();
        let way = self.plan.path(a, &places, Some(b), &section.tags(0));
        self.plan.ways[way].reversed = reversed;
        if length > 60.0 && self.dice.chance(0.35) {
            self.pocket(way, section);
        }
        way
    }

    /// Gives the last metres of a way before a crossing a lane for those who turn.
    fn pocket(&mut self, way: usize, section: Section) {
        let Some(tags) = section.with_turn_lane(self.left_hand, &mut self.dice) else { return };
        let far = self.dice.between(20.0, 40.0);
        if self.plan.ways[way].reversed {
            let at = self.plan.along(way, far);
            // The block goes on as the longer piece.
            if self.plan.split(way, at).is_some() {
                let last = self.plan.ways.len() - 1;
                self.plan.ways.swap(way, last);
                self.plan.ways[last].tags = tags;
            }
        } else {
            let at = self.plan.along(way, self.plan.length(way) - far);
            if let Some(rest) = self.plan.split(way, at) {
                self.plan.ways[rest].tags = tags;
            }
        }
    }
}

fn any_street(dice: &mut Dice, at: usize, side: usize) -> Street {
    let outermost = at == 0 || at + 1 == side;
    let missing = (!outermost && dice.chance(0.3)).then(|| dice.below(side - 1));
    if dice.chance(0.3) {
        let last = if dice.chance(0.3) { dice.below(side) } else { side };
        return Street { section: dice.pick(&DIVIDED), divided: Some((dice.between(8.0, 20.0), last)), missing };
    }
    let section = if !outermost && dice.chance(0.25) { dice.pick(&ONE_WAY) } else { dice.pick(&TWO_WAY) };
    Street { section, divided: None, missing }
}
