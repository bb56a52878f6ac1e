//! Who goes first at an intersection: what rules its arms, and whom each lanelet may ignore.

use crate::builder::control::priority_road::{PriorityArm, give_way};
use crate::builder::ids::Key;
use crate::builder::intersection::conflict::Conflicts;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Arm;
use crate::builder::network::Intersection;
use crate::builder::network::approach_control::{Control, sign_at};
use crate::builder::network::turn_angle::STRAIGHT;
use crate::builder::tags::cross_section::StripKind;
use crate::builder::tags::road_class::{DrivingSide, is_priority_road};
use crate::geometry::Vector;
use crate::lanelet::index::{Crossed, Edge, Thresholds, legs};
use crate::lanelet::right_of_way::{Mover, OPPOSITE, Relation, Turn, opposites, yields};
use crate::lanelet::{PointId, Target};

use super::intersection::IntersectionAssembly;

impl IntersectionAssembly<'_> {
    pub(super) fn controls(&self, intersection: &Intersection, arms: &[&Arm]) -> Vec<Control> {
        arms.iter()
            .map(|arm| match (intersection.signals, intersection.all_way_stop) {
                (true, _) => Control::Signals,
                _ if self.context.guarded.binary_search(&arm.at).is_ok() => Control::Signals,
                (false, true) => Control::Stop,
                (false, false) => sign_at(self.context.network.road(arm.at.road), arm.at.end),
            })
            .collect()
    }

    pub(super) fn movers(
        &self,
        arms: &[&Arm],
        paths: &[TurningLanelet],
        controls: &[Control],
        legs: &[usize],
    ) -> Vec<Mover> {
        let leads_in = |a: &usize| !arms[*a].into.is_empty();
        let signed = |a: usize| matches!(controls[a], Control::Stop | Control::GiveWay);
        let private = |a: usize| !self.context.network.road(arms[a].at.road).public;
        // A driveway that arrives side by side with a street is part of its approach.
        let of_street = |a: usize| (0..arms.len()).any(|b| !private(b) && !signed(b) && legs[a] == legs[b]);
        let approaching = |a: usize| PriorityArm {
            leg: legs[a],
            priority_road: is_priority_road(&self.context.network.road(arms[a].at.road).tags),
            leads_in: leads_in(&a),
            signed: signed(a),
        };
        let before: Option<Vec<bool>> = give_way(&(0..arms.len()).map(approaching).collect::<Vec<_>>());
        let crosses_priority = |a: usize| before.as_ref().is_some_and(|gives_way| gives_way[a]);
        // Whoever has no light where others have one gives way to those.
        let mixed = controls.contains(&Control::Signals);
        let unlit = |a: usize| mixed && controls[a] != Control::Signals;
        let minor = |a: usize| signed(a) || private(a) && !of_street(a) || crosses_priority(a) || unlit(a);
        let all: Vec<usize> = (0..arms.len()).filter(leads_in).collect();
        let ranked = all.iter().any(|&a| minor(a)) && !all.iter().all(|&a| minor(a));
        let near = if self.context.network.side == DrivingSide::Left { 1.0 } else { -1.0 };
        paths
            .iter()
            .map(|path| {
                let arm = path.movement.from;
                let turn = match path.turn * near {
                    t if t.abs() <= STRAIGHT => Turn::Straight,
                    t if t > 0.0 => Turn::Near,
                    _ => Turn::Far,
                };
                let signalised = controls[arm] == Control::Signals;
                let bicycle = path.kind == StripKind::Bicycle;
                Mover { arm, turn, signalised, priority: ranked.then(|| !minor(arm)), bicycle }
            })
            .collect()
    }

    /// For each arm the first one of its leg: carriageways on both sides of a median, or beside each other, come to the
    /// intersection as one.
    pub(super) fn legs(&self, arms: &[&Arm]) -> Vec<usize> {
        let place = |ids: [PointId; 2]| Edge { ids, points: ids.map(|id| self.assembly.position(id)) };
        let mut edges: Vec<(usize, Crossed)> = Vec::new();
        for (i, arm) in arms.iter().enumerate() {
            let lanes = arm.into.iter().map(|lane| (lane, true)).chain(arm.out.iter().map(|lane| (lane, false)));
            edges.extend(lanes.map(|(lane, inward)| {
                let for_cars = lane.kind != StripKind::Bicycle;
                (i, Crossed { edge: place(lane.nodes), inward, for_cars })
            }));
        }
        let crossed: Vec<Crossed> = edges.iter().map(|(_, edge)| *edge).collect();
        let mut first: Vec<usize> = (0..arms.len()).collect();
        for (&(arm, _), leg) in edges.iter().zip(legs(&crossed, &Thresholds::default())) {
            first[arm] = first[arm].min(edges[leg].0);
        }
        first
    }

    pub(super) fn rights_of_way(
        &mut self,
        legs: &[usize],
        paths: &[TurningLanelet],
        movers: &[Mover],
        conflicts: &Conflicts,
    ) {
        // Only where vehicles arrive is there a light, or a rank, to be opposite to another. Where they head counts.
        let heading = |of: usize| -> Vector {
            paths.iter().filter(|path| legs[path.movement.from] == of).map(|path| path.heading).sum()
        };
        let inward: Vec<_> = (0..legs.len()).map(|arm| heading(arm).try_normalize(f64::EPSILON)).collect();
        let opposite = opposites(&inward, OPPOSITE);
        let of_arms = |a: usize, b: usize| match (a == b, opposite[a] == Some(b)) {
            (true, _) => Relation::Same,
            (_, true) => Relation::InPhase,
            _ => Relation::AntiPhase,
        };
        let relation = |x: usize, y: usize| of_arms(legs[movers[x].arm], legs[movers[y].arm]);
        for (x, path) in paths.iter().enumerate() {
            // A bus lane is no part of the graph that a car's planner watches.
            let watched: Vec<usize> =
                conflicts.real[x].iter().copied().filter(|&y| paths[y].kind != StripKind::Bus).collect();
            let mut yields = yields(x, movers, &watched, relation);
            // Lanes that only touch are in nobody's way, but Autoware would wait for them.
            if !(movers[x].signalised && movers[x].turn == Turn::Straight) {
                yields.extend(conflicts.touching(x).filter(|&y| paths[y].kind != StripKind::Bus));
                yields.sort_unstable();
            }
            if yields.is_empty() {
                continue;
            }
            let mut members = vec![("right_of_way", Target::Lanelet(path.lanelet))];
            members.extend(yields.iter().map(|&y| ("yield", Target::Lanelet(paths[y].lanelet))));
            let key = Key::new("right of way").number(path.lanelet.0);
            self.assembly.element(key, "right_of_way", &members, &[path.lanelet]);
        }
    }
}
