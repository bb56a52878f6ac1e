//! Roundabout elements: which lanelets lead onto a ring, run around it and lead out, so that Autoware's roundabout module waits where
//! a vehicle joins, and its turn signals show where one leaves.
//!
//! Source: autoware_universe, `behavior_velocity_roundabout_module` and `turn_signal_decider` (2025).

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::ids::Key;
use crate::builder::intersection::ring_movements::RingMovements;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Lanes;
use crate::builder::layout::map_layout::IntersectionLanelets;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::{RoadIx, RoadNetwork, WholeRoundabouts};
use crate::builder::tags::cross_section::StripKind;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::lanelet::{LaneletId, LaneletMap, RegulatoryElementId, Target};

/// The lanelets for cars of one roundabout.
#[derive(Default)]
struct Ring {
    /// Those that lead onto it and wait there for all on it. Where lights or other streets rule, the area of an intersection does.
    entries: BTreeSet<LaneletId>,
    /// Those that lead out.
    exits: BTreeSet<LaneletId>,
    /// Those between two places of the ring.
    internal: BTreeSet<LaneletId>,
    /// Those of them from which on a vehicle that leaves over the next exit shows it.
    before_exits: BTreeSet<LaneletId>,
}

/// The roundabout elements of a map, and what its lanelets are to say of them once they are all in it.
#[derive(Default)]
pub(super) struct RoundaboutElements {
    /// Entries and exits, with the element to which they refer.
    carriers: Vec<(LaneletId, RegulatoryElementId)>,
    /// Lanelets on which a vehicle that takes the next exit shows it.
    signalling: BTreeSet<LaneletId>,
    /// What the user has to know.
    pub(super) note: Option<Finding>,
}

impl RoundaboutElements {
    /// Adds an element for each roundabout that somebody joins.
    pub(super) fn add(
        assembly: &mut MapBuilder,
        network: &RoadNetwork,
        roundabouts: &WholeRoundabouts,
        lanes: &Lanes,
        turning: &[Option<Box<IntersectionLanelets>>],
    ) -> Self {
        let mut rings = rings(network, roundabouts, lanes, turning);
        rings.retain(|_, ring| !ring.entries.is_empty());
        let mut all = Self { note: note(&rings), ..Self::default() };
        for (node, ring) in rings {
            let id = ring.element(assembly, Key::new("roundabout").number(node));
            all.carriers.extend(ring.entries.union(&ring.exits).map(|lanelet| (*lanelet, id)));
            if !ring.exits.is_empty() {
                all.signalling.extend(ring.before_exits);
            }
        }
        all
    }

    /// Lets the lanelets of the whole map refer to the elements.
    pub(super) fn attach_to(self, map: &mut LaneletMap) {
        for (lanelet, element) in self.carriers {
            if let Some(lanelet) = map.lanelets.get_mut(lanelet) {
                lanelet.regulatory_elements.push(element);
            }
        }
        for lanelet in self.signalling {
            if let Some(lanelet) = map.lanelets.get_mut(lanelet) {
                lanelet.attributes.set("enable_exit_turn_signal", "true");
            }
        }
    }
}

/// The roundabouts, by the least OpenStreetMap node of their rings.
fn rings(
    network: &RoadNetwork,
    roundabouts: &WholeRoundabouts,
    lanes: &Lanes,
    turning: &[Option<Box<IntersectionLanelets>>],
) -> BTreeMap<i64, Ring> {
    let mut rings: BTreeMap<i64, Ring> = BTreeMap::new();
    for road in RoadIx::all(network.roads.len()) {
        let Some(ring) = roundabouts.ring_of(road) else { continue };
        let ring = rings.entry(ring).or_default();
        let strips = &network.road(road).section.strips;
        let for_cars = lanes.of_road(road).iter().filter(|lane| strips[lane.strip].kind == StripKind::Drive);
        let lanelets: Vec<LaneletId> = for_cars.map(|lane| lane.lanelet).collect();
        ring.internal.extend(&lanelets);
        ring.before_exits.extend(lanelets);
    }
    for (at, turning) in network.intersections.iter().zip(turning) {
        let Some(turning) = turning else { continue };
        let paths = &turning.drawn.paths;
        let movements = RingMovements { roundabouts, lanes, at, paths };
        for path in paths.iter().filter(|path| path.kind == StripKind::Drive) {
            let Some(movement) = movements.of(path) else { continue };
            let ring = rings.entry(movement.ring).or_default();
            // Where an intersection has an area, Autoware's intersection module says who waits.
            let waits = movement.joins && turning.area.is_none() && !at.signals;
            if waits {
                ring.entries.insert(path.lanelet);
            }
            if movement.leaves && (waits || !movement.joins) {
                ring.exits.insert(path.lanelet);
            }
            if movement.circulates() {
                ring.internal.insert(path.lanelet);
                let from = path.movement.from;
                let leaves = |it: &TurningLanelet| {
                    it.movement.from == from && movements.of(it).is_some_and(|movement| movement.leaves)
                };
                if !paths.iter().any(leaves) {
                    ring.before_exits.insert(path.lanelet);
                }
            }
        }
    }
    rings
}

/// What the user has to switch on in Autoware.
fn note(rings: &BTreeMap<i64, Ring>) -> Option<Finding> {
    let what = match rings.len() {
        1 => "1 roundabout has a regulatory element".to_owned(),
        count => format!("{count} roundabouts have regulatory elements"),
    };
    let message = format!(
        "{what}: vehicles that join give way by Autoware's roundabout module, which runs with launch_roundabout_module:=true \
         alone."
    );
    let first = *rings.first_key_value()?.0;
    Some(Finding::new("roundabout-module", Subject::Node(first), message).graded(Severity::Info))
}

impl Ring {
    fn element(&self, assembly: &mut MapBuilder, key: Key) -> RegulatoryElementId {
        let roles = [("entry", &self.entries), ("exit", &self.exits), ("internal", &self.internal)];
        let of_role = |(role, lanelets): (&'static str, &BTreeSet<LaneletId>)| {
            lanelets.iter().map(move |id| (role, Target::Lanelet(*id))).collect::<Vec<_>>()
        };
        let members: Vec<(&str, Target)> = roles.into_iter().flat_map(of_role).collect();
        assembly.element(key, "roundabout", &members, &[])
    }
}
