//! Rights of way at an intersection: what controls its arms, which vehicles go first, and which lanelets each lanelet may ignore.

use crate::builder::ids::Key;
use crate::builder::intersection::conflict::Conflicts;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::tags::cross_section::StripKind;
use crate::geometry::{Vector, angle_between};
use crate::lanelet::index::{Crossed, Edge, legs};
use crate::lanelet::right_of_way::{OPPOSITE, RankedMovement, Relation, Turn, opposites, yields};
use crate::lanelet::{PointId, Target};

/// For each arm, the first arm of its leg. Carriageways on both sides of a median, or side by side, are one leg.
pub(crate) fn legs_of(assembly: &MapBuilder, arms: &[&Arm]) -> Vec<usize> {
    let place = |ids: [PointId; 2]| Edge { ids, points: ids.map(|id| assembly.position(id)) };
    let mut edges: Vec<(usize, Crossed)> = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let lanes = arm.into.iter().map(|lane| (lane, true)).chain(arm.out.iter().map(|lane| (lane, false)));
        edges.extend(lanes.map(|(lane, inward)| {
            let for_cars = lane.kind == StripKind::Drive;
            (i, Crossed { edge: place(lane.nodes), inward, for_cars })
        }));
    }
    let crossed: Vec<Crossed> = edges.iter().map(|(_, edge)| *edge).collect();
    let mut first: Vec<usize> = (0..arms.len()).collect();
    for (&(arm, _), leg) in edges.iter().zip(legs(&crossed)) {
        first[arm] = first[arm].min(edges[leg].0);
    }
    first
}

/// Adds a `right_of_way` element for each lanelet that may ignore others. `phases` has the arms that have green together, where that is
/// known; else those that face each other have.
pub(crate) fn rights_of_way(
    assembly: &mut MapBuilder,
    legs: &[usize],
    paths: &[TurningLanelet],
    ranked: &[RankedMovement],
    conflicts: &Conflicts,
    phases: &[Vec<usize>],
) {
    let heading_of = headings(legs, paths);
    let opposite = opposites(&heading_of, OPPOSITE);
    let legs = legs_by_light(legs, paths, &heading_of);
    let phase = |x: usize| phases.iter().position(|arms| arms.contains(&ranked[x].arm));
    let relation = |x: usize, y: usize| match [x, y].map(|at| legs[ranked[at].arm]) {
        [a, b] if a == b => Relation::Same,
        _ if phase(x).is_some() && phase(y).is_some() => {
            if phase(x) == phase(y) {
                Relation::InPhase
            } else {
                Relation::AntiPhase
            }
        }
        [a, b] if opposite[a] == Some(b) => Relation::InPhase,
        _ => Relation::AntiPhase,
    };
    for (x, path) in paths.iter().enumerate() {
        // Autoware's routing graph for cars has no bus lanes, so it does not watch them.
        let watched: Vec<usize> =
            conflicts.real[x].iter().copied().filter(|&y| paths[y].kind != StripKind::Bus).collect();
        let mut yields = yields(x, ranked, &watched, relation);
        // Autoware would wait for lanelets that only touch this one.
        if !(ranked[x].signalised && ranked[x].turn == Turn::Straight) {
            yields.extend(conflicts.touching(x).filter(|&y| paths[y].kind != StripKind::Bus));
            yields.sort_unstable();
        }
        if yields.is_empty() {
            continue;
        }
        let mut members = vec![("right_of_way", Target::Lanelet(path.lanelet))];
        members.extend(yields.iter().map(|&y| ("yield", Target::Lanelet(paths[y].lanelet))));
        let key = Key::new("right of way").number(path.lanelet.0);
        assembly.element(key, "right_of_way", &members, &[path.lanelet]);
    }
}

/// For the first arm of each leg, the unit direction of the cars that arrive there; `None` if no car arrives, and for all
/// other arms. Two legs are opposite only if cars arrive on both: otherwise a bus road in the middle of a street would be
/// opposite to the street's own cars.
pub(crate) fn headings(legs: &[usize], paths: &[TurningLanelet]) -> Vec<Option<Vector>> {
    (0..legs.len()).map(|leg| heading(legs, paths, leg, StripKind::Drive)).collect()
}

/// The unit direction of the vehicles of one kind that arrive on a leg; `None` if none arrives.
fn heading(legs: &[usize], paths: &[TurningLanelet], leg: usize, kind: StripKind) -> Option<Vector> {
    let arriving = paths.iter().filter(|path| legs[path.movement.from] == leg && path.kind == kind);
    arriving.map(|path| path.heading).sum::<Vector>().try_normalize(f64::EPSILON)
}

/// For each arm, the leg whose lights its vehicles obey. Buses on a road of their own have green with the cars of the same
/// direction, so that neither ignores vehicles that may have green at the same time.
fn legs_by_light(legs: &[usize], paths: &[TurningLanelet], headings: &[Option<Vector>]) -> Vec<usize> {
    let with_cars = |leg: usize| -> usize {
        if headings[leg].is_some() {
            return leg;
        }
        let Some(buses) = heading(legs, paths, leg, StripKind::Bus) else { return leg };
        let off = |(at, cars): (usize, &Option<Vector>)| Some((angle_between(buses, (*cars)?).abs().to_degrees(), at));
        let nearest = headings.iter().enumerate().filter_map(off).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.filter(|(off, _)| *off <= OPPOSITE).map_or(leg, |(_, at)| at)
    };
    legs.iter().map(|&leg| with_cars(leg)).collect()
}
