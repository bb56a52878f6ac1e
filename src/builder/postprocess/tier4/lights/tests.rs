//! Two roads that cross at an angle: where their lights hang with and without the profile.

use std::collections::BTreeMap;

use super::*;
use crate::builder::BuildOptions;
use crate::builder::tests::{Asked, built_as};
use crate::settings::Profile;

/// A crossing with lights of a road to the east and one that runs at this angle, degrees, to it.
fn crossing(profile: Profile, angle: f64) -> LaneletMap {
    let (y, x) = angle.to_radians().sin_cos();
    let nodes = [
        (1, 0.0, 0.0, "highway=traffic_signals"),
        (2, -120.0, 0.0, ""),
        (3, 120.0, 0.0, ""),
        (4, -120.0 * x, -120.0 * y, ""),
        (5, 120.0 * x, 120.0 * y, ""),
    ];
    let road = "highway=secondary lanes=2 sidewalk=no";
    let ways: [(i64, &[i64], &str); 4] =
        [(10, &[2, 1], road), (11, &[1, 3], road), (12, &[4, 1], road), (13, &[1, 5], road)];
    built_as(&Asked { nodes: &nodes, ways: &ways, options: BuildOptions { profile, ..BuildOptions::default() } }).map
}

/// The angles, degrees, between the light of each turn and those of the lanelets that its element lists, or that the turn meets
/// without listing them. The latter do not include turns that no light tells apart.
fn angles(map: &LaneletMap) -> [Vec<f64>; 2] {
    let view = View::new(map);
    let seen = LanesSeen::new(&view);
    let mut angles = [Vec::new(), Vec::new()];
    for ([(_, own), (_, other)], apart) in (0..view.lanelets.len()).flat_map(|at| pairs_of(&seen, at)) {
        let angle = angle_between(own, other).abs().to_degrees();
        angles[usize::from(!apart)].push(angle.min(180.0 - angle));
    }
    angles
}

/// Both ends of each light.
fn ends(map: &LaneletMap) -> BTreeMap<LineStringId, [Point; 2]> {
    let elements = map.regulatory_elements.iter().filter(|element| element.subtype == "traffic_light");
    let lights = elements.flat_map(|element| element.linestrings("refers"));
    let ends = |id: LineStringId| {
        let line = map.linestrings.get(id).unwrap();
        [0, line.points.len() - 1].map(|at| map.points.get(line.points[at]).unwrap().position)
    };
    lights.map(|id| (id, ends(id))).collect()
}

#[test]
fn lights_of_roads_that_cross_at_a_small_angle_are_turned_apart() {
    let [ours, tier4] = [Profile::Ours, Profile::Tier4].map(|profile| crossing(profile, 35.0));
    let [listed, watched] = angles(&ours);
    assert!(!listed.is_empty() && listed.iter().all(|angle| *angle < SAME_TIMING), "{listed:?}");
    assert!(!watched.is_empty() && watched.iter().all(|angle| *angle < SAME_TIMING), "{watched:?}");
    let [listed, watched] = angles(&tier4);
    assert!(!listed.is_empty() && listed.iter().all(|angle| *angle > SAME_TIMING + 1.0), "{listed:?}");
    assert!(!watched.is_empty() && watched.iter().all(|angle| *angle < SAME_TIMING - 1.0), "{watched:?}");
}

#[test]
fn a_light_turns_around_its_middle_by_40_degrees_at_most() {
    let [ours, tier4] = [Profile::Ours, Profile::Tier4].map(|profile| ends(&crossing(profile, 35.0)));
    assert!(!ours.is_empty() && ours.keys().eq(tier4.keys()));
    let mut most: f64 = 0.0;
    for (before, after) in ours.values().zip(tier4.values()) {
        let moved = nalgebra::center(&before[0], &before[1]) - nalgebra::center(&after[0], &after[1]);
        assert!(moved.norm() < 1e-3, "{moved}");
        most = most.max(angle_between(before[1] - before[0], after[1] - after[0]).abs().to_degrees());
    }
    assert!((5.0..40.1).contains(&most), "{most}");
}

#[test]
fn lights_of_roads_that_cross_at_right_angles_stay_as_they_are() {
    let [ours, tier4] = [Profile::Ours, Profile::Tier4].map(|profile| ends(&crossing(profile, 90.0)));
    assert!(!ours.is_empty());
    assert_eq!(ours, tier4);
}
