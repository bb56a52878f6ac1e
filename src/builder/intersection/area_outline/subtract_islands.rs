//! Islands that reach into the outline of an intersection from its edge are subtracted from it.
//!
//! An outline is one ring, which can have no hole: an island wholly inside gets a kerb around it. No lanelet of the intersection may
//! leave its area: an island stays where lanelets run over more of it than their widths may be wrong.

use crate::builder::ids::Key;
use crate::builder::intersection::turning_lanelets::{SharedBounds, TurningLanelet};
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Island;
use crate::geometry::{Point, polygon};
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

/// A ring without islands, and what it has of them nevertheless.
pub struct WithoutIslands {
    pub ring: Vec<PointId>,
    /// The islands wholly inside over which no lanelet leads.
    pub inside: Vec<Island>,
    /// The OpenStreetMap ways around the others that it covers.
    pub covered: Vec<i64>,
}

/// Removes the islands from a ring.
pub fn subtract_islands(
    assembly: &mut MapBuilder,
    key: Key,
    mut ring: Vec<PointId>,
    (arms, bounds, paths): (&[&Arm], &SharedBounds, &[TurningLanelet]),
    islands: &[Island],
) -> WithoutIslands {
    let (mut inside, mut covered) = (Vec::new(), Vec::new());
    for island in islands {
        let common = polygon::common_area(&places(assembly, &ring), &island.ring);
        if common < TOUCH {
            continue;
        }
        let shared = |path: &TurningLanelet| polygon::common_area(&path.outline, &island.ring);
        let over: Vec<TurningLanelet> = paths.iter().filter(|path| shared(path) > GRAZE).cloned().collect();
        if area_of(&island.ring) - common > TOUCH && over.iter().map(shared).sum::<f64>() <= UNDER * common {
            let key = key.word("island").number(island.way);
            let teeth = polygon::teeth(&places(assembly, &ring), &island.ring, NARROW, TOOTH);
            let with_teeth = [vec![island.ring.clone()], teeth].concat();
            // Without the teeth first; where they are needed they stay.
            let parts = [&with_teeth[..], &with_teeth[..1]].into_iter().take(with_teeth.len().min(2));
            let without = parts.enumerate().find_map(|(i, islands)| {
                let key = if i == 0 { key } else { key.word("teeth") };
                let without = without_ground(assembly, key, &ring, (arms, bounds, paths), islands, &over)?;
                let left = polygon::common_area(&places(assembly, &without), &island.ring);
                (left <= UNDER * common).then_some(without)
            });
            if let Some(without) = without {
                ring = without;
                continue;
            }
        }
        if over.is_empty() && area_of(&island.ring) - common <= TOUCH {
            inside.push(island.clone());
        } else {
            covered.push(island.way);
        }
    }
    WithoutIslands { ring, inside, covered }
}

/// A ring without some ground, but with the lanelets `over` that run over it; `None` if it would be no valid outline then.
pub fn without_ground(
    assembly: &mut MapBuilder,
    key: Key,
    ring: &[PointId],
    (arms, bounds, paths): (&[&Arm], &SharedBounds, &[TurningLanelet]),
    islands: &[Vec<Point>],
    over: &[TurningLanelet],
) -> Option<Vec<PointId>> {
    let around = nodes(assembly, ring);
    let union = RingUnion { ring: &around, islands, paths: over, behind: &[] };
    let without = union_outline(assembly, key, &union, arms, bounds);
    let arms_beside = |ring: &[PointId]| arms.iter().filter(|arm| runs_beside(ring, arm)).count();
    let valid = is_simple(assembly, &without) && covers(&places(assembly, &without), paths);
    (valid && arms_beside(&without) >= arms_beside(ring)).then_some(without)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_island_inside_is_no_part_of_the_edge() {
        let mut assembly = MapBuilder::default();
        let key = Key::new("test");
        let square =
            |half: f64| [(-half, -half), (-half, half), (half, half), (half, -half)].map(|(x, y)| Point::new(x, y));
        let ring: Vec<PointId> =
            square(10.0).iter().enumerate().map(|(i, p)| assembly.point(key.number(i as i64), *p, 0.0)).collect();
        let moved = |east: f64| square(2.0).iter().map(|p| Point::new(p.x + east, p.y)).collect();
        let islands = [0.0, 9.0].map(|east| Island { way: east as i64, ring: moved(east) });
        let found = subtract_islands(&mut assembly, key, ring, (&[], &SharedBounds::default(), &[]), &islands);
        assert_eq!(found.inside.iter().map(|island| island.way).collect::<Vec<_>>(), [0]);
        assert!(found.covered.is_empty());
        // The other one reaches over the edge, of which it takes a bay of 3 by 4 m.
        let left = polygon::signed_area(&places(&assembly, &found.ring)).abs();
        assert!((left - (400.0 - 12.0)).abs() < 0.01, "{left}");
    }
}
