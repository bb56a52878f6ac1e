//! `right_of_way` elements of a map that stands.

use std::collections::BTreeSet;

use crate::builder::ids::Key;
use crate::builder::postprocess::map_editor::MapEditor;
use crate::lanelet::{LaneletId, Member, RegulatoryElementId, Target};

/// Lets a lanelet ignore `ignored`, and of `met` nothing else.
pub fn amend(pen: &mut MapEditor, lane: LaneletId, met: &[LaneletId], ignored: &[LaneletId]) {
    let Some(id) = element_of(pen, lane) else {
        if !ignored.is_empty() {
            let mut members = vec![("right_of_way", Target::Lanelet(lane))];
            members.extend(ignored.iter().map(|&other| ("yield", Target::Lanelet(other))));
            pen.element(Key::new("right of way").number(lane.0), "right_of_way", members, &[lane]);
        }
        return;
    };
    let Some(element) = pen.map.regulatory_elements.get_mut(id) else { return };
    let known: BTreeSet<LaneletId> = element.lanelets("yield").collect();
    let dropped: BTreeSet<LaneletId> = met.iter().copied().filter(|other| !ignored.contains(other)).collect();
    element.members.retain(|member| match member.target {
        Target::Lanelet(other) => member.role != "yield" || !dropped.contains(&other),
        _ => true,
    });
    let missing = ignored.iter().filter(|other| !known.contains(other));
    element.members.extend(missing.map(|&other| Member { role: "yield".into(), target: Target::Lanelet(other) }));
    if element.lanelets("yield").next().is_none() {
        // One that lists nobody says nothing.
        pen.map.regulatory_elements.retain(|element| element.id != id);
        if let Some(lanelet) = pen.map.lanelets.get_mut(lane) {
            lanelet.regulatory_elements.retain(|own| *own != id);
        }
    }
}

/// The one that a lanelet refers to and that lists it.
fn element_of(pen: &MapEditor, lane: LaneletId) -> Option<RegulatoryElementId> {
    let listing = |id: &RegulatoryElementId| {
        let element = pen.map.regulatory_elements.get(*id);
        element.is_some_and(|e| e.subtype == "right_of_way" && e.lanelets("right_of_way").any(|own| own == lane))
    };
    pen.map.lanelets.get(lane)?.regulatory_elements.iter().copied().find(listing)
}
