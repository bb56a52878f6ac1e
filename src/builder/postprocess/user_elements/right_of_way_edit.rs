//! Changes `right_of_way` elements of a finished map.

use std::collections::BTreeSet;

use crate::builder::ids::Key;
use crate::builder::postprocess::map_editor::{MapEditor, drop_elements, right_of_way_of};
use crate::lanelet::{LaneletId, Member, Target};

use rustc_hash::FxHashSet;

/// Lists the lanelets `ignored` as yielding to a lanelet, and no others of the lanelets `met`.
pub fn amend(editor: &mut MapEditor, lane: LaneletId, met: &[LaneletId], ignored: &[LaneletId]) {
    let Some(id) = right_of_way_of(editor.map, lane).next().map(|element| element.id) else {
        if !ignored.is_empty() {
            let mut members = vec![("right_of_way", Target::Lanelet(lane))];
            members.extend(ignored.iter().map(|&other| ("yield", Target::Lanelet(other))));
            editor.element(Key::new("right of way").number(lane.0), "right_of_way", members, &[lane]);
        }
        return;
    };
    let Some(element) = editor.map.regulatory_elements.get_mut(id) else { return };
    let listed: BTreeSet<LaneletId> = element.lanelets("yield").collect();
    let dropped: BTreeSet<LaneletId> = met.iter().copied().filter(|other| !ignored.contains(other)).collect();
    element.members.retain(|member| match member.target {
        Target::Lanelet(other) => member.role != "yield" || !dropped.contains(&other),
        _ => true,
    });
    let missing = ignored.iter().filter(|other| !listed.contains(other));
    element.members.extend(missing.map(|&other| Member { role: "yield".into(), target: Target::Lanelet(other) }));
    // An element that lists no yielding lanelet has no effect.
    if element.lanelets("yield").next().is_none() {
        drop_elements(editor.map, &FxHashSet::from_iter([id]));
    }
}
