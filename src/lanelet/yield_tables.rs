//! The yield sets of the reference crossings: four ways and a T, with lights, with priority and without.

use super::*;
use crate::lanelet::index::DrivingSide;

const ARMS: &str = "NESW";

/// Movement, conflicts and yields where people drive on the left, and the same on the right; four ways with lights,
/// north and south green together.
#[rustfmt::skip]
const FOUR_WAYS: [(&str, &str, &str, &str, &str); 12] = [
    ("SN", "EN EW NW WE WN WS", "", "EN ES EW NE WE WN", ""),
    ("SW", "EW NW", "EW NW", "ES EW NS NW WE WN", "ES EW WE WN"),
    ("SE", "EN EW NE NS WE WS", "EN EW WE WS", "NE WE", "WE NE"),
    ("NS", "EN ES EW SE WE WS", "", "ES EW SW WE WN WS", ""),
    ("NE", "SE WE", "WE SE", "ES EW SE SN WE WN", "ES EW WE WN"),
    ("NW", "EN EW SN SW WE WS", "EN EW WE WS", "EW SW", "EW SW"),
    ("WE", "EN NE NS NW SE SN", "", "ES NE NS SE SN SW", ""),
    ("WN", "EN SN", "SN EN", "EN EW NE NS SN SW", "NE NS SN SW"),
    ("WS", "ES EW NS NW SE SN", "NS NW SE SN", "ES NS", "NS ES"),
    ("EW", "NS NW SE SN SW WS", "", "NE NS NW SN SW WN", ""),
    ("ES", "NS WS", "NS WS", "NE NS SN SW WE WS", "NE NS SN SW"),
    ("EN", "NS NW SE SN WE WN", "NS NW SE SN", "SN WN", "SN WN"),
];

/// The same crossing without lights, the road from north to south with priority: yields, left and right.
const NORTH_SOUTH_FIRST: [(&str, &str, &str); 12] = [
    ("SN", "EN EW WE WN WS NW", "EN ES EW WE WN NE"),
    ("NS", "EN ES EW WE WS SE", "ES EW WE WN WS SW"),
    ("SW", "EW NW", "ES EW WE WN"),
    ("SE", "EN EW WE WS", "WE NE"),
    ("NE", "WE SE", "ES EW WE WN"),
    ("NW", "EN EW WE WS", "EW SW"),
    ("WE", "EN", "ES"),
    ("EW", "WS", "WN"),
    ("WN", "EN", ""),
    ("WS", "", "ES"),
    ("ES", "WS", ""),
    ("EN", "", "WN"),
];

/// Nobody has priority: yields, left and right.
const ALL_EQUAL: [(&str, &str, &str); 12] = [
    ("SN", "NW", "NE"),
    ("NS", "SE", "SW"),
    ("WE", "EN", "ES"),
    ("EW", "WS", "WN"),
    ("SW", "NW", ""),
    ("SE", "", "NE"),
    ("NE", "SE", ""),
    ("NW", "", "SW"),
    ("WN", "EN", ""),
    ("WS", "", "ES"),
    ("ES", "WS", ""),
    ("EN", "", "WN"),
];

/// A T whose stem comes from the south: yields with the main road first (left), with lights (left), and both (right).
const T_JUNCTION: [(&str, &str, &str, &str, &str); 6] = [
    ("WE", "SE", "", "ES SE SW", ""),
    ("EW", "SE SW WS", "", "SW", ""),
    ("WS", "SE", "SE", "ES", "ES"),
    ("ES", "WS", "WS", "SW", "SW"),
    ("SE", "", "EW WE WS", "", "WE"),
    ("SW", "", "EW", "", "ES EW WE"),
];

fn arm(letter: u8) -> usize {
    ARMS.bytes().position(|c| c == letter).unwrap()
}

fn turn(name: &str, side: DrivingSide) -> Turn {
    let [from, to] = [arm(name.as_bytes()[0]), arm(name.as_bytes()[1])];
    // Arms are clockwise: the next one clockwise from where one is lies on the left.
    match ((to + 4 - from) % 4, side) {
        (2, _) => Turn::Straight,
        (1, DrivingSide::Left) | (3, DrivingSide::Right) => Turn::Near,
        _ => Turn::Far,
    }
}

fn relation(a: usize, b: usize) -> Relation {
    match a.abs_diff(b) {
        0 => Relation::Same,
        2 => Relation::InPhase,
        _ => Relation::AntiPhase,
    }
}

struct Case<'a> {
    side: DrivingSide,
    signalised: bool,
    /// Arms without a light or a sign.
    uncontrolled: Vec<usize>,
    priority: &'a dyn Fn(u8) -> Option<bool>,
    names: Vec<String>,
    bicycles: Vec<bool>,
    conflicts: Vec<Vec<String>>,
}

impl<'a> Case<'a> {
    /// The four-way crossing, or what is left of it without one arm.
    fn new(side: DrivingSide, signalised: bool, priority: &'a dyn Fn(u8) -> Option<bool>, without: char) -> Self {
        let mut case = Case {
            side,
            signalised,
            uncontrolled: Vec::new(),
            priority,
            names: Vec::new(),
            bicycles: Vec::new(),
            conflicts: Vec::new(),
        };
        for (name, left, _, right, _) in FOUR_WAYS.iter().filter(|row| !row.0.contains(without)) {
            let conflicts = if side == DrivingSide::Left { left } else { right };
            let conflicts = conflicts.split(' ').filter(|c| !c.contains(without)).map(str::to_owned);
            case.names.push((*name).to_owned());
            case.bicycles.push(false);
            case.conflicts.push(conflicts.collect());
        }
        case
    }

    fn yields(&self, name: &str) -> Vec<&str> {
        let ranked: Vec<RankedMovement> = self
            .names
            .iter()
            .zip(&self.bicycles)
            .map(|(n, &bicycle)| RankedMovement {
                arm: arm(n.as_bytes()[0]),
                turn: turn(n, self.side),
                signalised: self.signalised,
                controlled: self.signalised && !self.uncontrolled.contains(&arm(n.as_bytes()[0])),
                priority: (self.priority)(n.as_bytes()[0]),
                bicycle,
            })
            .collect();
        let index = |n: &str| self.names.iter().position(|other| other == n).unwrap();
        let x = index(name);
        let conflicts: Vec<usize> = self.conflicts[x].iter().map(|c| index(c)).collect();
        let mut found: Vec<&str> = super::yields(x, &ranked, &conflicts, |a, b| relation(ranked[a].arm, ranked[b].arm))
            .into_iter()
            .map(|y| self.names[y].as_str())
            .collect();
        found.sort_unstable();
        found
    }

    #[track_caller]
    fn expect(&self, name: &str, yields: &str) {
        let mut wanted: Vec<&str> = yields.split(' ').filter(|s| !s.is_empty()).collect();
        wanted.sort_unstable();
        assert_eq!(self.yields(name), wanted, "{name}, {:?}, lights: {}", self.side, self.signalised);
    }
}

const NOBODY: &dyn Fn(u8) -> Option<bool> = &|_| None;
const NONE: char = '-';

#[test]
fn four_ways_with_lights() {
    for (name, _, left, _, right) in FOUR_WAYS {
        Case::new(DrivingSide::Left, true, NOBODY, NONE).expect(name, left);
        Case::new(DrivingSide::Right, true, NOBODY, NONE).expect(name, right);
    }
}

#[test]
fn four_ways_with_a_priority_road() {
    let north_south = |arm: u8| Some(b"NS".contains(&arm));
    for (name, left, right) in NORTH_SOUTH_FIRST {
        Case::new(DrivingSide::Left, false, &north_south, NONE).expect(name, left);
        Case::new(DrivingSide::Right, false, &north_south, NONE).expect(name, right);
    }
}

#[test]
fn four_equal_ways() {
    for (name, left, right) in ALL_EQUAL {
        Case::new(DrivingSide::Left, false, NOBODY, NONE).expect(name, left);
        Case::new(DrivingSide::Right, false, NOBODY, NONE).expect(name, right);
    }
}

#[test]
fn a_t_junction() {
    let main_road = |arm: u8| Some(b"EW".contains(&arm));
    for (name, left, left_lights, right, right_lights) in T_JUNCTION {
        Case::new(DrivingSide::Left, false, &main_road, 'N').expect(name, left);
        Case::new(DrivingSide::Left, true, NOBODY, 'N').expect(name, left_lights);
        Case::new(DrivingSide::Right, false, &main_road, 'N').expect(name, right);
        Case::new(DrivingSide::Right, true, NOBODY, 'N').expect(name, right_lights);
    }
}

#[test]
fn who_has_neither_light_nor_sign_is_watched() {
    let west = vec![arm(b'W')];
    let left = Case { uncontrolled: west.clone(), ..Case::new(DrivingSide::Left, true, NOBODY, NONE) };
    left.expect("SW", "EW NW");
    left.expect("SE", "EN EW");
    left.expect("WN", "SN EN");
    let right = Case { uncontrolled: west, ..Case::new(DrivingSide::Right, true, NOBODY, NONE) };
    right.expect("SE", "NE");
    right.expect("SW", "ES EW");
    right.expect("WS", "NS ES");
}

/// Adds a bicycle lane drawn as a road, straight on from the south at the kerb.
fn with_bicycle_lane(mut case: Case<'_>) -> Case<'_> {
    let crossed = if case.side == DrivingSide::Left { "EW NW SW WE WN WS" } else { "WE NE SE EW EN ES" };
    for (name, conflicts) in case.names.iter().zip(&mut case.conflicts) {
        if crossed.contains(name.as_str()) {
            conflicts.push("SNb".to_owned());
        }
    }
    case.names.push("SNb".to_owned());
    case.bicycles.push(true);
    case.conflicts.push(crossed.split(' ').map(str::to_owned).collect());
    case
}

#[test]
fn a_bicycle_lane_at_the_kerb() {
    let left = with_bicycle_lane(Case::new(DrivingSide::Left, true, NOBODY, NONE));
    left.expect("SW", "EW NW SNb");
    left.expect("WN", "SN EN SNb");
    left.expect("WS", "NS NW SE SN SNb");
    left.expect("NW", "EN EW WE WS");
    let right = with_bicycle_lane(Case::new(DrivingSide::Right, true, NOBODY, NONE));
    right.expect("SE", "WE NE SNb");
    right.expect("ES", "NE NS SN SW SNb");
    right.expect("EN", "SN WN SNb");
    right.expect("NE", "ES EW WE WN");
}

#[test]
fn no_two_movements_ignore_each_other_without_lights() {
    let north_south = |arm: u8| Some(b"NS".contains(&arm));
    for side in [DrivingSide::Left, DrivingSide::Right] {
        for priority in [NOBODY, &north_south] {
            let case = Case::new(side, false, priority, NONE);
            for x in &case.names {
                for y in case.yields(x) {
                    assert!(!case.yields(y).contains(&x.as_str()), "{x} and {y}");
                }
            }
        }
    }
}
