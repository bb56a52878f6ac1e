//! phase: which signals are green together, where the map leaves it open.

use std::collections::BTreeMap;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::{Intersection, MapIndex, Traffic};
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{LineStringId, RegulatoryElementId};

use super::NoParams;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let all = map.intersections.iter().zip(&map.traffic);
    all.flat_map(|(intersection, traffic)| arrows(map, intersection, traffic)).collect()
}

/// The lights of one traffic light element of an approach, and the movements that it rules.
#[derive(Default)]
struct SignalMovements {
    lights: Vec<LineStringId>,
    movements: Vec<usize>,
}

/// Turns with a light of their own. They may be green with the rest of their approach or not; the map does not tell.
fn arrows(map: &MapIndex, intersection: &Intersection, traffic: &Traffic) -> Vec<Finding> {
    let mut by_arm: BTreeMap<usize, BTreeMap<RegulatoryElementId, SignalMovements>> = BTreeMap::new();
    for (x, movement) in traffic.movements.iter().enumerate().filter(|(_, one)| map.lanes[one.lane].vehicle) {
        for light in map.elements(map.lanes[movement.lane].id, "traffic_light") {
            let ruled = by_arm.entry(movement.from).or_default().entry(light.id).or_default();
            ruled.lights = light.linestrings("refers").collect();
            ruled.movements.push(x);
        }
    }
    let mut findings = Vec::new();
    for (arm, elements) in &by_arm {
        for (&id, own) in elements {
            let mut others = elements.iter().filter(|(other, _)| **other != id).map(|(_, ruled)| ruled).peekable();
            let alone = others.peek().is_none();
            let shared = others.any(|other| other.lights.iter().any(|light| own.lights.contains(light)));
            let turns = own.movements.iter().all(|&x| traffic.movements[x].ranked.turn != Turn::Straight);
            let said = own.movements.iter().all(|&x| traffic.has_phase(x));
            if alone || shared || !turns || said {
                continue;
            }
            let lanes = own.movements.iter().map(|&x| map.lanes[traffic.movements[x].lane].id);
            let names: Vec<String> = lanes.clone().map(|lane| lane.to_string()).collect();
            let message = format!(
                "Traffic light {id} rules only {} of the {}; it is taken to be green together with the others.",
                names.join(", "),
                map.approach_name(intersection, *arm, true)
            );
            let finding = Finding::new("arrow", Subject::RegulatoryElement(id.0), message);
            findings.push(lanes.fold(finding, |finding, lane| finding.with(Subject::Lanelet(lane.0), "turn")));
        }
    }
    findings
}
