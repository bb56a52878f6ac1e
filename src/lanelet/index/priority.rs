//! Which approach has priority where there is no signal, as far as the map shows it.

use rustc_hash::FxHashSet;

use super::types::{Intersection, MapIndex, Movement, Rank};
use super::union_find::UnionFind;
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{RegulatoryElement, Target};

/// The priority of every approach by the first source that decides it: the user's settings, private ground, signs, existing
/// `right_of_way` elements. As soon as one approach gives way, the undecided ones have priority; but not who comes from opposite a
/// sign and crosses a road without any: another sign may stand there that the map lacks.
pub(super) fn priorities(
    map: &MapIndex,
    intersection: &Intersection,
    movements: &[Movement],
    by_user: &[usize],
) -> (Vec<Option<bool>>, Rank) {
    let count = intersection.arms.len();
    if !by_user.is_empty() {
        return ((0..count).map(|arm| Some(by_user.contains(&arm))).collect(), Rank::Known);
    }
    let gives_way: Vec<bool> = (0..count).map(|arm| gives_way(map, movements, arm)).collect();
    let used: FxHashSet<usize> = movements.iter().map(|movement| movement.from).collect();
    if gives_way.contains(&true) {
        return match used.iter().all(|&arm| gives_way[arm]) {
            true => (vec![None; count], Rank::Equal),
            false => {
                let opposite = |arm: usize| intersection.arms[arm].opposite;
                let goes_through = |arm: usize| !gives_way[arm] && opposite(arm).is_some_and(|to| !gives_way[to]);
                let has_main_road = (0..count).any(goes_through);
                let faces_sign = |arm: usize| opposite(arm).is_some_and(|to| has_sign(map, movements, to));
                let is_doubtful = |arm: usize| has_main_road && !gives_way[arm] && faces_sign(arm);
                let priorities = (0..count).map(|arm| (!is_doubtful(arm)).then_some(!gives_way[arm]));
                (priorities.collect(), Rank::Known)
            }
        };
    }
    let over = by_elements(map, intersection, movements);
    let minor = |arm: usize| over.iter().any(|&(_, below)| below == arm);
    let major = |arm: usize| over.iter().any(|&(above, _)| above == arm);
    if over.is_empty() || (0..count).any(|arm| minor(arm) && major(arm)) {
        return (vec![None; count], Rank::Unknown);
    }
    ((0..count).map(|arm| Some(!minor(arm))).collect(), Rank::Known)
}

/// Whether something makes the vehicles of each movement wait: a light on its carriageway, a stop or give-way sign, or the way out of
/// private ground. A road that leads through an intersection with signals and has none of these may pass under or over it, though
/// all is drawn at one height.
pub(super) fn controlled(map: &MapIndex, intersection: &Intersection, movements: &[Movement]) -> Vec<bool> {
    let arms: Vec<bool> = (0..intersection.arms.len()).map(|arm| gives_way(map, movements, arm)).collect();
    let has_light = |lane: usize| map.elements(map.lanes[lane].id, "traffic_light").next().is_some();
    let is_lit = |movement: &Movement| {
        has_light(movement.lane) || map.predecessors(movement.lane).iter().any(|&lane| has_light(lane))
    };
    let lit: Vec<bool> = movements.iter().map(is_lit).collect();
    let mut carriageways = UnionFind::new(movements.len());
    for (x, one) in movements.iter().enumerate() {
        for (y, other) in movements.iter().enumerate().skip(x + 1) {
            if one.from == other.from && map.lanes[one.lane].start.touches(&map.lanes[other.lane].start) {
                carriageways.join(x, y);
            }
        }
    }
    let roots: Vec<usize> = (0..movements.len()).map(|at| carriageways.root(at)).collect();
    let lit: FxHashSet<usize> = roots.iter().zip(lit).filter(|(_, lit)| *lit).map(|(root, _)| *root).collect();
    movements.iter().zip(&roots).map(|(one, root)| lit.contains(root) || arms[one.from]).collect()
}

/// Whether an approach leads out of private ground or past a stop or give-way sign.
fn gives_way(map: &MapIndex, movements: &[Movement], arm: usize) -> bool {
    let (own, before) = lanes_of(map, movements, arm);
    let is_private = |lane: &usize| map.lanes[*lane].lanelet.attributes.is("location", "private");
    // A lane into private ground may be private itself, so what leads to it counts.
    let asked = if before.is_empty() { &own } else { &before };
    (!asked.is_empty() && asked.iter().all(is_private)) || has_sign(map, movements, arm)
}

/// Whether an approach leads past a stop or give-way sign.
fn has_sign(map: &MapIndex, movements: &[Movement], arm: usize) -> bool {
    let (own, before) = lanes_of(map, movements, arm);
    let signed = |lane: &usize| map.elements(map.lanes[*lane].id, "traffic_sign").any(|sign| map.ranks(sign));
    own.iter().chain(&before).any(signed)
}

/// The lanes that start at an approach, and those that lead to them.
fn lanes_of(map: &MapIndex, movements: &[Movement], arm: usize) -> (Vec<usize>, Vec<usize>) {
    let own: Vec<usize> = movements.iter().filter(|movement| movement.from == arm).map(|m| m.lane).collect();
    let before: Vec<usize> = own.iter().flat_map(|&lane| map.predecessors(lane)).copied().collect();
    (own, before)
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
    for x in movements.iter().filter(|movement| movement.mover.turn == Turn::Straight && ranked(movement.lane)) {
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
