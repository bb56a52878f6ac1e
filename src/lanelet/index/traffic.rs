//! The traffic of an intersection: its movements, which of them are green together, and which approach has priority.

use rustc_hash::FxHashMap;

use super::lane::Lane;
use super::priority;
use super::thresholds;
use super::types::{Intersection, MapIndex, Movement, Rank, Traffic};
use super::user_names::UserNames;
use crate::geometry::angle_between;
use crate::lanelet::right_of_way::{RankedMovement, Turn};
use crate::lanelet::{LineStringId, RegulatoryElement, TurnDirection};

/// A movement is straight up to this change of heading (deg).
pub const STRAIGHT_ON: f64 = 30.0;
/// A turn of more than this (deg) is a U-turn.
pub const U_TURN: f64 = 150.0;

/// The traffic of one intersection; needs the rest of the index.
pub(super) fn traffic(map: &MapIndex, at: usize) -> Traffic {
    let intersection = &map.intersections[at];
    let Some(side) = map.side.side else { return Traffic::default() };
    let mut of_edge: FxHashMap<(usize, bool), usize> = FxHashMap::default();
    for (position, arm) in intersection.arms.iter().enumerate() {
        for edge in &arm.edges {
            of_edge.extend(edge.lanes.iter().map(|&lane| ((lane, edge.inward), position)));
        }
    }
    let mut movements: Vec<Movement> = Vec::new();
    for member in intersection.members.iter().filter(|member| member.is_inside()) {
        let lane = member.lane;
        let (Some(&from), Some(&to)) = (of_edge.get(&(lane, true)), of_edge.get(&(lane, false))) else { continue };
        let turn = match map.label_for(map.lanes[lane].turn(), STRAIGHT_ON, U_TURN) {
            TurnDirection::Straight => Turn::Straight,
            label if label == side.near_turn() => Turn::Near,
            _ => Turn::Far,
        };
        let signalised = map.is_signalised(map.lanes[lane].id);
        let bicycle = map.lanes[lane].bicycle;
        let ranked = RankedMovement { arm: from, turn, signalised, controlled: true, priority: None, bicycle };
        movements.push(Movement { lane, from, to, ranked });
    }
    let together = together(map, intersection, &movements);
    let named = UserNames::new(map, intersection, at, &movements);
    let first = named.priority_arms();
    let (prohibited, guide_lines, phases) = (named.prohibited(), named.guide_lines(), named.phases());
    let signalised = movements.iter().any(|movement| movement.ranked.signalised);
    let mut traffic = Traffic { movements, signalised, rank: Rank::Unknown, prohibited, guide_lines, together, phases };
    if traffic.signalised {
        let controlled = priority::controlled(map, &traffic.movements);
        // A movement without a light gives way to those with one.
        for (at, movement) in traffic.movements.iter_mut().enumerate() {
            movement.ranked.priority = Some(movement.ranked.signalised);
            movement.ranked.controlled = controlled[at] || !traffic.phases[at].is_empty();
        }
        traffic.rank = Rank::Known;
    } else {
        let (priorities, rank) = priority::priorities(map, intersection, &traffic.movements, &first);
        for (movement, priority) in traffic.movements.iter_mut().zip(priorities) {
            movement.ranked.priority = priority;
        }
        traffic.rank = rank;
    }
    traffic
}

/// Opposite approaches, and those whose elements refer to the same light, unless they cross: nobody can see the face of
/// a light from the side, so that a light of both is a slip.
fn together(map: &MapIndex, intersection: &Intersection, movements: &[Movement]) -> Vec<Vec<bool>> {
    let count = intersection.arms.len();
    let mut lights: Vec<Vec<LineStringId>> = vec![Vec::new(); count];
    for movement in movements {
        let elements = map.elements(map.lanes[movement.lane].id, "traffic_light");
        lights[movement.from].extend(elements.flat_map(|element| element.linestrings("refers")));
    }
    for list in &mut lights {
        list.sort_unstable();
        list.dedup();
    }
    let cross = |a: usize, b: usize| {
        let headings = intersection.arms[a].heading_in.zip(intersection.arms[b].heading_in);
        let angle = headings.map_or(0.0, |(a, b)| angle_between(a, b).abs().to_degrees());
        angle.min(180.0 - angle) > thresholds::SHARED_LIGHT
    };
    let shared =
        |a: usize, b: usize| !cross(a, b) && lights[a].iter().any(|light| lights[b].binary_search(light).is_ok());
    (0..count)
        .map(|a| {
            (0..count)
                .map(|b| a == b || intersection.arms[a].opposite == Some(b) || shared(a, b))
                .collect::<Vec<bool>>()
        })
        .collect()
}

impl<'m> MapIndex<'m> {
    /// Intersection, traffic and movement of a lane; of the first intersection that it is part of.
    pub fn movement(&self, lane: usize) -> Option<(&Intersection, &Traffic, usize)> {
        self.intersections_of(lane).iter().find_map(|&at| {
            let traffic = &self.traffic[at];
            traffic.of_lane(lane).map(|position| (&self.intersections[at], traffic, position))
        })
    }

    /// The `right_of_way` elements that have an effect on a lane: it refers to them, and they list it.
    pub fn rights_of_way(&self, lane: usize) -> Vec<&'m RegulatoryElement> {
        let Lane { id, lanelet, .. } = self.lanes[lane];
        let elements = lanelet.regulatory_elements.iter().filter_map(|&at| self.map.regulatory_elements.get(at));
        elements
            .filter(|element| element.subtype == "right_of_way")
            .filter(|element| element.lanelets("right_of_way").any(|own| own == id))
            .collect()
    }

    /// The lanes that Autoware ignores for the sake of a lane's `right_of_way` elements, by position, sorted.
    pub fn ignored(&self, lane: usize) -> Vec<usize> {
        let elements = self.rights_of_way(lane);
        let yields = elements.iter().flat_map(|element| element.lanelets("yield"));
        let mut lanes: Vec<usize> = yields.filter_map(|id| self.lane(id)).collect();
        lanes.sort_unstable();
        lanes.dedup();
        lanes
    }

    /// The lanes that Autoware watches for a lane of an intersection, by position: all that overlap it, whatever the
    /// signals show, except those that a `right_of_way` element lets it ignore; none for a straight lane with a light.
    pub fn attention(&self, lane: usize) -> Vec<usize> {
        let straight = self.turn_direction(lane) == Some(TurnDirection::Straight);
        if !self.lanes[lane].vehicle || (straight && self.is_signalised(self.lanes[lane].id)) {
            return Vec::new();
        }
        let ignored = self.ignored(lane);
        let others = self.conflicts[lane].iter().map(|conflict| conflict.other);
        others.filter(|&other| self.lanes[other].vehicle && ignored.binary_search(&other).is_err()).collect()
    }
}
