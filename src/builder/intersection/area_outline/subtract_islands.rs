//! Islands that reach into the outline of an intersection from its edge are subtracted from it.
//!
//! An outline is one ring, which can have no hole. No lanelet of the intersection may leave its area: an island stays where
//! lanelets run over more of it than their widths may be wrong.

use crate::builder::ids::Key;
use crate::builder::intersection::turning_lanelets::{SharedBounds, TurningLanelet};
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Island;
use crate::geometry::polygon;
use crate::lanelet::PointId;

use super::area_ring::{RingUnion, area_of, covers, is_simple, nodes, places, runs_beside, union_outline};

/// An island that shares less than this with an intersection, square metres, only touches it.
const TOUCH: f64 = 0.5;
/// A lanelet that shares less than this with an island, square metres, runs beside it.
const GRAZE: f64 = 1e-3;
/// Lanelets may run over this part of an island's ground in the intersection: widths by tags and classes are only accurate to
/// a few decimetres.
const UNDER: f64 = 0.2;

/// Removes the islands from a ring; gives it with the OpenStreetMap ways around those that it still covers.
pub fn subtract_islands(
    assembly: &mut MapBuilder,
    key: Key,
    mut ring: Vec<PointId>,
    (arms, bounds, paths): (&[&Arm], &SharedBounds, &[TurningLanelet]),
    islands: &[Island],
) -> (Vec<PointId>, Vec<i64>) {
    let mut covered = Vec::new();
    let arms_beside = |ring: &[PointId]| arms.iter().filter(|arm| runs_beside(ring, arm)).count();
    for island in islands {
        let common = polygon::common_area(&places(assembly, &ring), &island.ring);
        if common < TOUCH {
            continue;
        }
        let shared = |path: &TurningLanelet| polygon::common_area(&path.outline, &island.ring);
        let over: Vec<TurningLanelet> = paths.iter().filter(|path| shared(path) > GRAZE).cloned().collect();
        if area_of(&island.ring) - common > TOUCH && over.iter().map(shared).sum::<f64>() <= UNDER * common {
            let key = key.word("island").number(island.way);
            let (islands, around) = (std::slice::from_ref(&island.ring), nodes(assembly, &ring));
            let union = RingUnion { ring: &around, islands, paths: &over, behind: &[] };
            let without = union_outline(assembly, key, &union, arms, bounds);
            let outline = places(assembly, &without);
            let left = polygon::common_area(&outline, &island.ring);
            let valid = is_simple(assembly, &without) && covers(&outline, paths) && left <= UNDER * common;
            if valid && arms_beside(&without) >= arms_beside(&ring) {
                ring = without;
                continue;
            }
        }
        covered.push(island.way);
    }
    (ring, covered)
}
