//! Which movements have priority where there is no signal, as far as the map shows it.

use rustc_hash::{FxHashMap, FxHashSet};

use super::types::{Intersection, MapIndex, Movement, Rank};
use super::union_find::UnionFind;
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{RegulatoryElement, Target};

/// The priority of every movement by the first source that decides it: the user's settings, private ground, signs, existing
/// `right_of_way` elements. As soon as one movement gives way, the undecided ones have priority; but not those that come from opposite
/// a sign and cross a road without any: another sign may stand there that the map lacks.
///
/// An approach gives way if all its carriageways do. A sign on one of them holds for that one, whatever is said of the approach.
pub(super) fn priorities(
    map: &MapIndex,
    intersection: &Intersection,
    movements: &[Movement],
    by_user: &[usize],
) -> (Vec<Option<bool>>, Rank) {
    let arrivals = arrivals(map, movements);
    let arm_waits = |arm: usize| {
        let mut of_arm = movements.iter().zip(&arrivals).filter(|(movement, _)| movement.from == arm).peekable();
        of_arm.peek().is_some() && of_arm.all(|(_, arrival)| arrival.gives_way())
    };
    let arms: Vec<bool> = (0..intersection.arms.len()).map(arm_waits).collect();
    if !by_user.is_empty() {
        let goes_first = |(movement, arrival): (&Movement, &Arrival)| {
            by_user.contains(&movement.from) && (!arrival.gives_way() || arms[movement.from])
        };
        return (movements.iter().zip(&arrivals).map(|each| Some(goes_first(each))).collect(), Rank::Known);
    }
    if arrivals.iter().any(Arrival::gives_way) {
        if arrivals.iter().all(Arrival::gives_way) {
            return (vec![None; movements.len()], Rank::Equal);
        }
        let opposite = |arm: usize| intersection.arms[arm].opposite;
        let goes_through = |arm: usize| !arms[arm] && opposite(arm).is_some_and(|to| !arms[to]);
        let has_main_road = (0..arms.len()).any(goes_through);
        let has_sign =
            |arm: usize| movements.iter().zip(&arrivals).any(|(one, arrival)| one.from == arm && arrival.signed);
        let is_doubtful = |arm: usize| has_main_road && opposite(arm).is_some_and(has_sign);
        let priority = |(movement, arrival): (&Movement, &Arrival)| match arrival.gives_way() {
            true => Some(false),
            false => (!is_doubtful(movement.from)).then_some(true),
        };
        return (movements.iter().zip(&arrivals).map(priority).collect(), Rank::Known);
    }
    let over = by_elements(map, intersection, movements);
    let minor = |arm: usize| over.iter().any(|&(_, below)| below == arm);
    let major = |arm: usize| over.iter().any(|&(above, _)| above == arm);
    if over.is_empty() || (0..arms.len()).any(|arm| minor(arm) && major(arm)) {
        return (vec![None; movements.len()], Rank::Unknown);
    }
    (movements.iter().map(|movement| Some(!minor(movement.from))).collect(), Rank::Known)
}

/// Whether something makes the vehicles of each movement wait: a light on its carriageway, a stop or give-way sign, or the way out of
/// private ground. A road that leads through an intersection with signals and has none of these may pass under or over it, though
/// all is drawn at one height.
pub(super) fn controlled(map: &MapIndex, movements: &[Movement]) -> Vec<bool> {
    arrivals(map, movements).iter().map(|one| one.lit || one.gives_way()).collect()
}

/// What the vehicles of a movement pass where they arrive.
#[derive(Clone, Copy)]
struct Arrival {
    /// A traffic light on the carriageway.
    lit: bool,
    /// A stop or give-way sign on the carriageway.
    signed: bool,
    /// The way out of private ground, on all carriageways of the approach.
    private: bool,
}

impl Arrival {
    fn gives_way(&self) -> bool {
        self.signed || self.private
    }
}

/// How the vehicles of each movement arrive. A carriageway has the lanes of one approach that start side by side.
fn arrivals(map: &MapIndex, movements: &[Movement]) -> Vec<Arrival> {
    let mut side_by_side = UnionFind::new(movements.len());
    for (x, one) in movements.iter().enumerate() {
        for (y, other) in movements.iter().enumerate().skip(x + 1) {
            if one.from == other.from && map.lanes[one.lane].start.touches(&map.lanes[other.lane].start) {
                side_by_side.join(x, y);
            }
        }
    }
    let roots: Vec<usize> = (0..movements.len()).map(|at| side_by_side.root(at)).collect();
    let (mut of_carriageway, mut of_approach) = (Lanes::default(), Lanes::default());
    for (movement, root) in movements.iter().zip(&roots) {
        of_carriageway.entry(*root).or_default().push(movement.lane);
        of_approach.entry(movement.from).or_default().push(movement.lane);
    }
    let has = |own: &[usize], subtype: &'static str, is: &dyn Fn(&RegulatoryElement) -> bool| {
        let mut lanes = own.iter().copied().chain(before(map, own));
        lanes.any(|lane| map.elements(map.lanes[lane].id, subtype).any(is))
    };
    let passes =
        |own: &Vec<usize>| (has(own, "traffic_light", &|_| true), has(own, "traffic_sign", &|sign| map.ranks(sign)));
    let passed: FxHashMap<usize, (bool, bool)> =
        of_carriageway.iter().map(|(root, own)| (*root, passes(own))).collect();
    let private: FxHashMap<usize, bool> = of_approach.iter().map(|(arm, own)| (*arm, is_private(map, own))).collect();
    let arrival = |(movement, root): (&Movement, &usize)| {
        let (lit, signed) = passed[root];
        Arrival { lit, signed, private: private[&movement.from] }
    };
    movements.iter().zip(&roots).map(arrival).collect()
}

/// Lanes in the intersection by the carriageway or the approach where they begin.
type Lanes = FxHashMap<usize, Vec<usize>>;

/// Whether all lanes that lead to some lanes of an intersection lie on private ground. A lane into private ground may be private
/// itself, so it counts only where none leads to it.
fn is_private(map: &MapIndex, own: &[usize]) -> bool {
    let before: Vec<usize> = before(map, own).collect();
    let asked = if before.is_empty() { own } else { &before };
    asked.iter().all(|&lane| map.lanes[lane].lanelet.attributes.is("location", "private"))
}

fn before<'a>(map: &'a MapIndex, own: &'a [usize]) -> impl Iterator<Item = usize> + 'a {
    own.iter().flat_map(|&lane| map.predecessors(lane)).copied()
}

impl MapIndex<'_> {
    /// Whether a traffic sign element is a stop or give-way sign, by its own word or its sign's.
    pub fn ranks(&self, element: &RegulatoryElement) -> bool {
        let known = |word: Option<&str>| matches!(word, Some("stop_sign" | "give_way"));
        known(element.attributes.get("sign_type"))
            || element.role("refers").any(|target| match target {
                Target::LineString(id) => {
                    self.map.linestrings.get(id).is_some_and(|sign| known(sign.attributes.get("subtype")))
                }
                _ => false,
            })
    }
}

/// Pairs of approaches where a straight lanelet of the first may ignore a crossing lanelet of the second, and not the other way
/// round.
fn by_elements(map: &MapIndex, intersection: &Intersection, movements: &[Movement]) -> Vec<(usize, usize)> {
    let mut over = FxHashSet::default();
    // A lanelet with a virtual traffic light ignores all others, whatever the priority.
    let ranked = |lane: usize| map.elements(map.lanes[lane].id, "virtual_traffic_light").next().is_none();
    for x in movements.iter().filter(|movement| movement.ranked.turn == Turn::Straight && ranked(movement.lane)) {
        for y in map.ignored(x.lane) {
            let Ok(at) = movements.binary_search_by_key(&y, |movement| movement.lane) else { continue };
            let below = movements[at].from;
            let crossing = below != x.from && intersection.arms[x.from].opposite != Some(below);
            if crossing && map.conflicts[x.lane].iter().any(|conflict| conflict.other == y && conflict.real) {
                over.insert((x.from, below));
            }
        }
    }
    let mut clear: Vec<(usize, usize)> = over.iter().copied().filter(|&(a, b)| !over.contains(&(b, a))).collect();
    clear.sort_unstable();
    clear
}
