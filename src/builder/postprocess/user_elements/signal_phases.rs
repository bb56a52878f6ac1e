//! Signal phases that the user names: which lanelets of an intersection ignore each other, and the phases in the settings.

use crate::builder::postprocess::map_editor::MapEditor;
use crate::lanelet::index::MapIndex;
use crate::lanelet::{LaneletId, PolygonId};
use crate::settings::{ApproachName, IntersectionSettings, Settings};

use super::right_of_way_edit;

/// The approaches of each phase: they are green together.
type Phases = Vec<Vec<ApproachName>>;

/// The phases of one intersection.
pub struct SignalPhases {
    area: PolygonId,
    phases: Phases,
    /// For each lanelet with a phase, the lanelets that it meets and those of them that it may ignore.
    rights: Vec<(LaneletId, [Vec<LaneletId>; 2])>,
}

/// The phases that the entries give an intersection; `None` if they give none.
pub fn phases(map: &MapIndex, intersection: usize, entries: &[&IntersectionSettings]) -> Option<SignalPhases> {
    let phases: Phases = entries.iter().flat_map(|entry| entry.phases.iter().cloned()).collect();
    let area = map.intersections[intersection].area.filter(|_| !phases.is_empty())?;
    let traffic = &map.traffic[intersection];
    let lane = |x: usize| map.lanes[traffic.movements[x].lane].id;
    let lanes = |movements: Vec<usize>| movements.into_iter().map(lane).collect();
    let with_phase = (0..traffic.movements.len()).filter(|&x| traffic.has_phase(x));
    let rights = with_phase.map(|x| (lane(x), [lanes(traffic.met(map, x)), lanes(traffic.yields(map, x))]));
    Some(SignalPhases { area, phases, rights: rights.collect() })
}

/// The phases of an entry that name an approach without traffic lights, by index, each with a message.
pub fn faults(map: &MapIndex, intersection: usize, entry: &IntersectionSettings) -> Vec<(usize, String)> {
    let movements = &map.traffic[intersection].movements;
    let signalised = |x: usize| movements[x].ranked.signalised;
    let named = entry.phases.iter().enumerate().flat_map(|(phase, names)| names.iter().map(move |name| (phase, name)));
    let unsignalised = named.filter(|(_, name)| !map.movements_named(intersection, name).into_iter().any(signalised));
    unsignalised
        .map(|(phase, name)| {
            let arms = map.intersections[intersection].arms.iter().enumerate();
            let arms = arms.filter(|(arm, _)| (0..movements.len()).any(|x| movements[x].from == *arm && signalised(x)));
            let arms: Vec<&str> = arms.map(|(_, arm)| arm.compass).collect();
            let others = if arms.is_empty() { "here".to_owned() } else { format!("but those of {}", arms.join(", ")) };
            (phase, format!("{name} has no traffic lights; there are none {others}"))
        })
        .collect()
}

/// Lets each lanelet ignore those that have red while it has green, and adds the phases to the settings of the map.
pub fn write(editor: &mut MapEditor, settings: &mut Settings, signals: SignalPhases) {
    let SignalPhases { area, phases, rights } = signals;
    for (lane, [met, ignored]) in &rights {
        right_of_way_edit::amend(editor, *lane, met, ignored);
    }
    let ia = Some(area.0);
    match settings.intersection.iter_mut().find(|entry| entry.ia == ia) {
        Some(entry) => entry.phases.extend(phases),
        None => settings.intersection.push(IntersectionSettings { ia, phases, ..IntersectionSettings::default() }),
    }
}
