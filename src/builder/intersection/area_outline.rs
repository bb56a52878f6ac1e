//! The `intersection_area`: straight cuts across the roads and kerbs between them, clockwise.

pub(crate) mod area_ring;
mod empty_ground;
mod subtract_islands;

use crate::builder::ids::Key;
use crate::builder::lanes::types::{Arm, Lanes};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Island;
use crate::builder::network::turn_angle::TURNS_BACK;
use crate::geometry::pose::Pose;
use crate::geometry::strip_index::StripIndex;
use crate::geometry::{Point, angle_between, curve, polygon, pose};
use crate::lanelet::{Attributes, PointId};

use super::turning_lanelets::{SharedBounds, TurningLanelet};
use area_ring::{Node, RingUnion, holds, is_simple, is_simple_ring, nodes, places, runs_beside, union_outline};
use empty_ground::{EmptyGround, RoadGround, empty_ground};
use subtract_islands::{WithoutIslands, subtract_islands, without_ground};

/// The outline of an intersection as nodes.
#[derive(Clone, Debug, Default)]
pub struct AreaOutline {
    /// Clockwise, not closed.
    pub ring: Vec<PointId>,
    /// Their places.
    pub places: Vec<Point>,
    /// Arms, by index, whose cuts are not on the outline, because some lanelet runs over them.
    pub overrun: Vec<usize>,
    /// Arms, by index, with lanes that do not end on the outline.
    pub lost: Vec<usize>,
    /// Whether it depends on the lanes of roads behind its cuts.
    pub yields: bool,
    /// The OpenStreetMap ways around islands that it covers.
    pub covered: Vec<i64>,
}

impl AreaOutline {
    /// Whether it has no more overrun and no more lost arms than another outline.
    pub fn fits_as_well(&self, other: &Self) -> bool {
        self.overrun.len() <= other.overrun.len() && self.lost.len() <= other.lost.len()
    }
}

/// The outline along the arms, clockwise: cut, kerb, cut, kerb. `paths` come with the indices of their outlines. Where a
/// lanelet leaves that ring, the ring is widened; where it then covers the end of a road, the lanes of that road are subtracted.
/// Islands that reach into it are subtracted, too.
pub fn area_outline(
    assembly: &mut MapBuilder,
    key: Key,
    lanes: &Lanes,
    arms: &[&Arm],
    bounds: &SharedBounds,
    (paths, indices): (&[TurningLanelet], &[Option<StripIndex>]),
    islands: &[Island],
) -> AreaOutline {
    let mut walked = ring_along_arms(assembly, key, arms, bounds, Kerbs::Rounded);
    // Where two roads turn back on opposite sides, their kerbs may bulge over each other.
    let mut simple = is_simple_ring(&walked);
    if !simple {
        let straight =
            ring_along_arms(assembly, key.word("straight kerbs"), arms, bounds, Kerbs::StraightWhereTheyTurnBack);
        if is_simple_ring(&straight) {
            (walked, simple) = (straight, true);
        }
    }
    let mut ring: Vec<PointId> = walked.iter().map(|(id, _)| *id).collect();
    let overrun =
        |ring: &[PointId]| -> Vec<usize> { (0..arms.len()).filter(|&i| !runs_along(ring, arms[i])).collect() };
    let mut yields = false;
    let mut overrun_arms = overrun(&ring);
    if !(simple && holds(&walked, paths, indices)) {
        let union = RingUnion { ring: &walked, islands: &[], paths, behind: &[] };
        ring = union_outline(assembly, key, &union, arms, bounds);
        overrun_arms = overrun(&ring);
        yields = !overrun_arms.is_empty() || !is_simple(assembly, &ring);
    }
    if yields {
        let ends = arms.iter().flat_map(|arm| arm.into.iter().chain(&arm.out));
        let behind: Vec<Vec<Point>> = ends.map(|end| assembly.outline(lanes.lanes[end.lane].lanelet)).collect();
        let union = RingUnion { ring: &walked, islands: &[], paths, behind: &behind };
        let yielding = union_outline(assembly, key.word("beside lanes"), &union, arms, bounds);
        if is_simple(assembly, &yielding) && overrun(&yielding).len() <= overrun_arms.len() {
            ring = yielding;
        }
    }
    let WithoutIslands { mut ring, inside, covered } =
        subtract_islands(assembly, key, ring, (arms, bounds, paths), islands);
    for island in &inside {
        add_island(assembly, key.word("island").number(island.way), &island.ring);
    }
    if !yields {
        ring = without_empty_ground(assembly, key, ring, (arms, bounds, paths), &inside);
    }
    let as_walked = ring.iter().eq(walked.iter().map(|(id, _)| id));
    let places = if as_walked { walked.iter().map(|node| node.1).collect() } else { places(assembly, &ring) };
    add_kerbs(assembly, key, &ring, arms);
    let lost = (0..arms.len()).filter(|&i| !runs_beside(&ring, arms[i])).collect();
    AreaOutline { ring, places, overrun: overrun_arms, lost, yields, covered }
}

/// A ring without the ground at its edge that no lanelet needs. Such ground inside, between lanelets, gets a kerb around it, unless
/// it has an island.
fn without_empty_ground(
    assembly: &mut MapBuilder,
    key: Key,
    mut ring: Vec<PointId>,
    (arms, bounds, paths): (&[&Arm], &SharedBounds, &[TurningLanelet]),
    islands: &[Island],
) -> Vec<PointId> {
    let ends: Vec<RoadGround> = arms.iter().map(|arm| RoadGround::of(arm, assembly.positions(&arm.cut))).collect();
    for (i, piece) in empty_ground(&places(assembly, &ring), &ends, paths).into_iter().enumerate() {
        let key = key.word("empty ground").number(i as i64);
        match piece {
            EmptyGround::Rim(piece) => {
                let without = without_ground(assembly, key, &ring, (arms, bounds, paths), &[piece], &[]);
                ring = without.unwrap_or(ring);
            }
            EmptyGround::Island(kerb) => {
                if !islands.iter().any(|island| polygon::common_area(&island.ring, &kerb) > 0.0) {
                    add_island(assembly, key, &kerb);
                }
            }
        }
    }
    ring
}

/// Adds a kerb around an island.
fn add_island(assembly: &mut MapBuilder, key: Key, ring: &[Point]) {
    let nodes = ring.iter().enumerate().map(|(i, place)| assembly.point(key.number(i as i64), *place, 0.0));
    let mut nodes: Vec<PointId> = nodes.collect();
    nodes.extend(nodes.first().copied());
    assembly.line(key.word("kerb line"), nodes, Attributes::of(&[("type", "road_border")]));
}

/// A kerb that would bulge out from its chord by more, metres, would enclose ground that no lanelet needs: it is straight, and the
/// outline leads around the lanelets beyond.
const BULGE_MOST: f64 = 12.0;

/// How kerbs lead from one road to the next.
#[derive(Clone, Copy, PartialEq)]
enum Kerbs {
    Rounded,
    /// Straight between two roads of which one leads back along the other.
    StraightWhereTheyTurnBack,
}

/// The ring of cuts and the kerbs between them.
fn ring_along_arms(
    assembly: &mut MapBuilder,
    key: Key,
    arms: &[&Arm],
    bounds: &SharedBounds,
    kerbs: Kerbs,
) -> Vec<Node> {
    let cuts: Vec<Vec<Node>> = arms.iter().map(|arm| nodes(assembly, &arm.cut)).collect();
    let mut ring: Vec<Node> = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let next = (i + 1) % arms.len();
        ring.extend(&cuts[i]);
        let (Some(&from), Some(&to)) = (cuts[i].last(), cuts[next].first()) else { continue };
        ring.extend(match bounds.line(from.0, to.0) {
            Some(line) => line.inner(from.0),
            None if kerbs == Kerbs::StraightWhereTheyTurnBack && turns_back(arm, arms[next]) => Vec::new(),
            None => corner(assembly, key, [from, to], [arm, arms[next]]),
        });
    }
    ring.dedup_by_key(|(id, _)| *id);
    while ring.len() > 1 && ring.first().map(|(id, _)| id) == ring.last().map(|(id, _)| id) {
        ring.pop();
    }
    ring
}

/// Whether the kerb from one road to the next turns back.
fn turns_back(arm: &Arm, next: &Arm) -> bool {
    angle_between(arm.inward, -next.inward).abs().to_degrees() > TURNS_BACK
}

/// Whether the ends of an arm's lanes follow each other on the ring, in their order across the road.
fn runs_along(ring: &[PointId], arm: &Arm) -> bool {
    let is_end = |id: PointId| arm.into.iter().chain(&arm.out).any(|lane| lane.nodes.contains(&id));
    let mut line = arm.cut.iter().filter(|id| is_end(**id));
    let Some(start) = line.next().map(|first| ring.iter().position(|id| id == first)) else { return true };
    start.is_some_and(|start| ring.iter().cycle().skip(start + 1).zip(line).all(|(a, b)| a == b))
}

/// The nodes of a rounded kerb between the ends of two cuts, without those ends; none if it would bulge out.
fn corner(assembly: &mut MapBuilder, key: Key, [from, to]: [Node; 2], [arm, next]: [&Arm; 2]) -> Vec<Node> {
    let start = Pose { point: from.1, heading: arm.inward };
    let end = Pose { point: to.1, heading: -next.inward };
    if (start.point - end.point).norm() < pose::MIN_SPACING {
        return Vec::new();
    }
    let line = curve::untangled(&curve::join(start, end).iter().map(|pose| pose.point).collect::<Vec<_>>());
    // The ring is clockwise, so its outer side is to the left.
    let along = (end.point - start.point).normalize();
    if line.iter().any(|p| along.perp(&(p - start.point)) > BULGE_MOST) {
        return Vec::new();
    }
    let key = key.word("kerb").number(from.0.0).number(to.0.0);
    let inner = &line[1.min(line.len())..line.len().max(2) - 1];
    inner.iter().enumerate().map(|(i, p)| (assembly.point(key.number(i as i64), *p, 0.0), *p)).collect()
}

/// Adds one `road_border` for every part of the ring between cuts.
fn add_kerbs(assembly: &mut MapBuilder, key: Key, ring: &[PointId], arms: &[&Arm]) {
    let is_cut = |a: PointId, b: PointId| arms.iter().any(|arm| arm.cut.contains(&a) && arm.cut.contains(&b));
    let count = ring.len();
    let Some(start) = (0..count).find(|&i| is_cut(ring[(i + count - 1) % count], ring[i])) else { return };
    let round: Vec<PointId> = (0..=count).map(|step| ring[(start + step) % count]).collect();
    for chain in round.chunk_by(|&a, &b| !is_cut(a, b)) {
        if let [first, .., last] = chain {
            let key = key.word("kerb line").number(first.0).number(last.0);
            assembly.line(key, chain.to_vec(), Attributes::of(&[("type", "road_border")]));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::simple_ring;

    use super::area_ring::without_spikes;
    use super::*;

    /// What is left of a ring of nodes 0, 1, 2, ... of which some are fixed.
    fn left(places: &[(f64, f64)], fixed: &[i64]) -> Vec<i64> {
        let ring = (0..places.len() as i64).map(PointId).collect();
        let place = |id: PointId| Point::new(places[id.0 as usize].0, places[id.0 as usize].1);
        without_spikes(ring, &fixed.iter().copied().map(PointId).collect(), place).into_iter().map(|id| id.0).collect()
    }

    #[test]
    fn a_spike_is_taken_off_but_not_the_end_of_a_lane() {
        let spike = [(0.0, 0.0), (0.0, 9.0), (5.0, 9.0), (5.0, 12.0), (5.0, 9.0), (9.0, 9.0), (9.0, 0.0)];
        assert_eq!(left(&spike, &[]), [0, 1, 2, 4, 5, 6]);
        assert_eq!(left(&spike, &[3]), [0, 1, 3, 4, 5, 6]);
    }

    #[test]
    fn a_small_loop_is_left_out() {
        let looped = [(0.0, 0.0), (0.0, 9.0), (4.0, 9.0), (5.0, 8.9), (3.9, 8.8), (4.1, 9.1), (9.0, 9.0), (9.0, 0.0)];
        let places =
            |ids: &[i64]| ids.iter().map(|&i| Point::new(looped[i as usize].0, looped[i as usize].1)).collect();
        let kept = left(&looped, &[]);
        let shape: Vec<Point> = places(&kept);
        assert!(simple_ring::is_simple(&shape), "{kept:?}");
        assert!([0, 1, 6, 7].iter().all(|corner| kept.contains(corner)), "{kept:?}");
    }

    #[test]
    fn a_simple_ring_stays() {
        assert_eq!(left(&[(0.0, 0.0), (0.0, 1.0), (1.0, 1.0)], &[]), [0, 1, 2]);
    }
}
