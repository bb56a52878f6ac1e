//! Islands that reach into the outline of an intersection from its edge are cut out of it.
//!
//! An outline is one ring, so what lies wholly inside cannot be left out; and no way through the intersection may leave
//! its area, so where ways run over an island by more than their widths may be wrong, the island stays under them.

use crate::builder::ids::Key;
use crate::builder::intersection::turning_lanelets::{SharedBounds, TurningLanelet};
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Island;
use crate::geometry::polygon;
use crate::lanelet::PointId;

use super::area_ring::{area_of, covers, is_simple, nodes, places, runs_beside, union_outline};

/// Islands that share less than this with the ground of an intersection, square metres, only touch it.
const TOUCH: f64 = 0.5;
/// A way that shares less than this with an island, square metres, runs beside it.
const GRAZE: f64 = 1e-3;
/// Ways may run over this part of what an island has of the ground: lanes are as wide as tags and classes say, to a
/// few decimetres.
const UNDER: f64 = 0.2;

/// The ring without the islands, and the ways around those that it covers all the same.
pub fn subtract_islands(
    assembly: &mut MapBuilder,
    key: Key,
    mut ring: Vec<PointId>,
    (arms, bounds, paths): (&[&Arm], &SharedBounds, &[TurningLanelet]),
    islands: &[Island],
) -> (Vec<PointId>, Vec<i64>) {
    let mut covered = Vec::new();
    let along = |ring: &[PointId]| arms.iter().filter(|arm| runs_beside(ring, arm)).count();
    for island in islands {
        let common = polygon::common_area(&places(assembly, &ring), &island.ring);
        if common < TOUCH {
            continue;
        }
        let run_over = |path: &&TurningLanelet| polygon::common_area(&path.outline, &island.ring) > GRAZE;
        let over: Vec<TurningLanelet> = paths.iter().filter(run_over).cloned().collect();
        let under: f64 = over.iter().map(|path| polygon::common_area(&path.outline, &island.ring)).sum();
        if area_of(&island.ring) - common > TOUCH && under <= UNDER * common {
            let key = key.word("island").number(island.way);
            let ground = std::slice::from_ref(&island.ring);
            let around = nodes(assembly, &ring);
            let without = union_outline(assembly, key, &around, arms, bounds, &over, [ground, &[]]);
            let outline = places(assembly, &without);
            let left = polygon::common_area(&outline, &island.ring);
            let whole = is_simple(assembly, &without) && covers(&outline, paths) && left <= UNDER * common;
            if whole && along(&without) >= along(&ring) {
                ring = without;
                continue;
            }
        }
        covered.push(island.way);
    }
    (ring, covered)
}
