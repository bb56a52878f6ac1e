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

/// Ground beside an island that is narrower than twice this, metres, is too narrow for any wheel...
const NARROW: f64 = 0.75;
/// ... and goes with the island if it has at least this area, square metres: where outline and island meet at less than 60 degrees.
const TOOTH: f64 = 0.4;

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
            let around = nodes(assembly, &ring);
            let teeth = polygon::teeth(&places(assembly, &ring), &island.ring, NARROW, TOOTH);
            let with_teeth = [vec![island.ring.clone()], teeth].concat();
            // Without the teeth first; where they are needed they stay.
            let parts = [&with_teeth[..], &with_teeth[..1]].into_iter().take(with_teeth.len().min(2));
            let without = parts.enumerate().find_map(|(i, islands)| {
                let union = RingUnion { ring: &around, islands, paths: &over, behind: &[] };
                let key = if i == 0 { key } else { key.word("teeth") };
                let without = union_outline(assembly, key, &union, arms, bounds);
                let outline = places(assembly, &without);
                let left = polygon::common_area(&outline, &island.ring);
                let valid = is_simple(assembly, &without) && covers(&outline, paths) && left <= UNDER * common;
                (valid && arms_beside(&without) >= arms_beside(&ring)).then_some(without)
            });
            if let Some(without) = without {
                ring = without;
                continue;
            }
        }
        covered.push(island.way);
    }
    (ring, covered)
}
