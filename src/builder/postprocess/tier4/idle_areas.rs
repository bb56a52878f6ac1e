//! Areas with lights in which no lanelet meets another, as where a road divides at lights.
//!
//! The area is there so that Autoware signals the turn. The validator wants an element on each turn with a light; there is nobody that it
//! could list, and the loader rejects an element that lists nobody. Without the area and the `turn_direction` it asks for none.

use std::collections::BTreeSet;

use super::lanes_seen::{Judged, LanesSeen};
use crate::lanelet::LaneletMap;
use crate::lanelet::index::tier4_yields::{Ruled, share_predecessor};
use crate::lanelet::index::view::View;
use crate::settings::Settings;

/// Removes these areas, and the tags of their lanelets and the settings that belong to them.
pub fn drop_idle_areas(map: &mut LaneletMap, settings: &mut Settings) {
    let idle = idle_areas(&LanesSeen::new(&View::new(map)));
    let is_idle = |area: Option<&str>| area.and_then(|id| id.parse().ok()).is_some_and(|id| idle.contains(&id));
    for lanelet in map.lanelets.as_mut_slice() {
        if is_idle(lanelet.attributes.get("intersection_area")) {
            let others =
                lanelet.attributes.iter().filter(|(key, _)| !matches!(*key, "intersection_area" | "turn_direction"));
            lanelet.attributes = others.collect();
        }
    }
    map.polygons.retain(|area| !idle.contains(&area.id.0));
    settings.intersection.retain(|entry| entry.ia.is_none_or(|id| !idle.contains(&id)));
}

/// The ids of these areas.
fn idle_areas(all: &LanesSeen) -> BTreeSet<i64> {
    let meets =
        |at: usize| all.graph.conflicting(at).into_iter().any(|other| !share_predecessor(&all.graph, at, other));
    let mut areas = all.areas();
    areas.retain(|_, members| {
        let has_light = members.iter().any(|&at| all.judged(at) == Judged::By(Ruled::ByLight));
        has_light && !members.iter().any(|&at| meets(at))
    });
    areas.into_keys().collect()
}

#[cfg(test)]
mod tests {
    use crate::builder::BuildOptions;
    use crate::builder::tests::{Asked, built_as};
    use crate::settings::Profile;

    /// The numbers of areas and of lanelets with a turn direction where a street divides, with `middle` on the node, and others may
    /// join it there.
    fn counts(profile: Profile, middle: &str, joined: bool) -> [usize; 2] {
        let nodes =
            [(1, 0.0, 0.0, middle), (2, -90.0, 0.0, ""), (3, 90.0, 0.0, ""), (4, 0.0, 90.0, ""), (5, 0.0, -90.0, "")];
        let street = "highway=residential oneway=yes lanes=1";
        let ways: [(i64, &[i64], &str); 4] =
            [(10, &[2, 1], street), (11, &[1, 3], street), (12, &[1, 4], street), (13, &[5, 1], street)];
        let options = BuildOptions { profile, ..BuildOptions::default() };
        let map = built_as(&Asked { nodes: &nodes, ways: &ways[..3 + usize::from(joined)], options }).map;
        let turns = map.lanelets.iter().filter(|lanelet| lanelet.attributes.has("turn_direction")).count();
        [map.polygons.len(), turns]
    }

    #[test]
    fn lights_where_nobody_meets_have_no_area_for_the_validator() {
        let lights = "highway=traffic_signals";
        assert_eq!(counts(Profile::Ours, lights, false), [1, 2]);
        assert_eq!(counts(Profile::Tier4, lights, false), [0, 0]);
        assert_eq!(counts(Profile::Tier4, "", false), [1, 2]);
        assert_eq!(counts(Profile::Tier4, lights, true), counts(Profile::Ours, lights, true));
    }
}
