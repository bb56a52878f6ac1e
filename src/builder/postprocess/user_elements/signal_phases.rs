//! Which signals are green together, by the user's word: whom the lanelets of an intersection ignore, and what the settings
//! beside the map say of it.

use crate::builder::postprocess::map_editor::MapEditor;
use crate::lanelet::index::MapIndex;
use crate::lanelet::{LaneletId, PolygonId};
use crate::settings::{ApproachName, IntersectionSettings, Settings};

use super::right_of_way;

/// Phase by phase what is green together.
type Phases = Vec<Vec<ApproachName>>;

/// The phases of one intersection, before they are written.
pub struct SignalPhases {
    area: PolygonId,
    phases: Phases,
    /// Per lanelet that has a phase all whom it meets, and those of them that it may ignore.
    rights: Vec<(LaneletId, [Vec<LaneletId>; 2])>,
}

/// What the entries say of an intersection; `None` where that is nothing.
pub fn phased(map: &MapIndex, at: usize, entries: &[&IntersectionSettings]) -> Option<SignalPhases> {
    let phases: Phases = entries.iter().flat_map(|entry| entry.phases.iter().cloned()).collect();
    let area = map.intersections[at].area.filter(|_| !phases.is_empty())?;
    let traffic = &map.traffic[at];
    let lane = |x: usize| map.lanes[traffic.movements[x].lane].id;
    let ids = |movements: Vec<usize>| movements.into_iter().map(lane).collect();
    let with_phase = (0..traffic.movements.len()).filter(|&x| traffic.has_phase(x));
    let rights = with_phase.map(|x| (lane(x), [ids(traffic.met(map, x)), ids(traffic.yields(map, x))]));
    Some(SignalPhases { area, phases, rights: rights.collect() })
}

/// Why the phases of an entry do not say what they are to say, each with its place in the list.
pub fn faults(map: &MapIndex, at: usize, entry: &IntersectionSettings) -> Vec<(usize, String)> {
    let movements = &map.traffic[at].movements;
    let lit = |x: usize| movements[x].mover.signalised;
    let named = entry.phases.iter().enumerate().flat_map(|(phase, names)| names.iter().map(move |name| (phase, name)));
    let unlit = named.filter(|(_, name)| !map.movements_named(at, name).into_iter().any(lit));
    unlit
        .map(|(phase, name)| {
            let sides = map.intersections[at].arms.iter().enumerate();
            let sides = sides.filter(|(arm, _)| (0..movements.len()).any(|x| movements[x].from == *arm && lit(x)));
            let sides: Vec<&str> = sides.map(|(_, arm)| arm.compass).collect();
            let there = if sides.is_empty() { "here".to_owned() } else { format!("but those of {}", sides.join(", ")) };
            (phase, format!("{name} has no traffic lights; there are none {there}"))
        })
        .collect()
}

/// Lets lanelets ignore those who are red while they drive, and nobody else; adds the phases to the settings of the map.
pub fn write(pen: &mut MapEditor, settings: &mut Settings, phased: SignalPhases) {
    for (lane, [met, ignored]) in &phased.rights {
        right_of_way::amend(pen, *lane, met, ignored);
    }
    let ia = Some(phased.area.0);
    match settings.intersection.iter_mut().find(|entry| entry.ia == ia) {
        Some(entry) => entry.phases.extend(phased.phases),
        None => {
            let entry = IntersectionSettings { ia, phases: phased.phases, ..IntersectionSettings::default() };
            settings.intersection.push(entry);
        }
    }
}
