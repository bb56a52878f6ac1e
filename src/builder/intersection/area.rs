//! The `intersection_area`: kerb chains between the roads, straight cuts across them, clockwise.

pub(crate) mod area_ring;
mod subtract_islands;

use crate::builder::ids::Key;
use crate::builder::lanes::types::{Arm, Lanes};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Island;
use crate::geometry::pose::Pose;
use crate::geometry::strip_index::StripIndex;
use crate::geometry::{Point, curve, pose};
use crate::lanelet::{Attributes, LineStringId, PointId};

use super::turning_lanelets::{SharedBounds, TurningLanelet};
use area_ring::{Node, holds, is_simple, nodes, places, runs_beside, union_outline};
use subtract_islands::subtract_islands;

/// The outline of an intersection as nodes.
#[derive(Clone, Debug, Default)]
pub struct AreaOutline {
    /// Clockwise, not closed.
    pub ring: Vec<PointId>,
    /// Where these lie.
    pub places: Vec<Point>,
    /// The kerbs between the roads, in ring order.
    pub kerbs: Vec<LineStringId>,
    /// Arms, by index, over whose cuts some path runs, so that the outline around all paths does not lead along them.
    pub overrun: Vec<usize>,
    /// Arms, by index, whose lanes do not end on the outline side by side.
    pub lost: Vec<usize>,
    /// Whether it gives way to the lanes of roads.
    pub yields: bool,
    /// The ways around islands on which the outline lies all the same.
    pub covered: Vec<i64>,
}

impl AreaOutline {
    /// Whether no more ways run over cuts, and no more lanes end inside, than with another outline.
    pub fn fits_as_well(&self, other: &Self) -> bool {
        self.overrun.len() <= other.overrun.len() && self.lost.len() <= other.lost.len()
    }
}

/// Walks the arms clockwise: cut, kerb, cut, kerb. `paths` come with the columns of their outlines. Where a path leaves
/// that ring, it is widened to hold the path; where it then swallows the end of a road, it gives way to the lanes of that
/// road. Islands that reach into it are cut out.
pub fn area_outline(
    assembly: &mut MapBuilder,
    key: Key,
    lanes: &Lanes,
    arms: &[&Arm],
    bounds: &SharedBounds,
    paths: (&[TurningLanelet], &[Option<StripIndex>]),
    islands: &[Island],
) -> AreaOutline {
    let walked = walked(assembly, key, arms, bounds);
    let mut ring: Vec<PointId> = walked.iter().map(|(id, _)| *id).collect();
    let apart = |ring: &[PointId]| -> Vec<usize> { (0..arms.len()).filter(|&i| !runs_along(ring, arms[i])).collect() };
    let (mut overrun, mut yields) = (apart(&ring), false);
    let (paths, columns) = paths;
    if !holds(&walked, paths, columns) {
        ring = union_outline(assembly, key, &walked, arms, bounds, paths, [&[], &[]]);
        overrun = apart(&ring);
        yields = !overrun.is_empty() || !is_simple(assembly, &ring);
        if yields {
            let behind: Vec<Vec<Point>> = arms.iter().flat_map(|arm| own_lanes(assembly, lanes, arm)).collect();
            let key = key.word("beside lanes");
            let beside = union_outline(assembly, key, &walked, arms, bounds, paths, [&[], &behind]);
            if is_simple(assembly, &beside) && apart(&beside).len() <= overrun.len() {
                ring = beside;
            }
        }
    }
    let (ring, covered) = subtract_islands(assembly, key, ring, (arms, bounds, paths), islands);
    let as_walked = ring.iter().eq(walked.iter().map(|(id, _)| id));
    let places = if as_walked { walked.iter().map(|node| node.1).collect() } else { places(assembly, &ring) };
    let kerbs = kerbs(assembly, key, &ring, arms);
    let lost = (0..arms.len()).filter(|&i| !runs_beside(&ring, arms[i])).collect();
    AreaOutline { ring, places, kerbs, overrun, lost, yields, covered }
}

/// The ring of cuts and the kerbs between them.
fn walked(assembly: &mut MapBuilder, key: Key, arms: &[&Arm], bounds: &SharedBounds) -> Vec<Node> {
    let cuts: Vec<Vec<Node>> = arms.iter().map(|arm| nodes(assembly, &arm.cut)).collect();
    let mut ring: Vec<Node> = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let next = (i + 1) % arms.len();
        ring.extend(&cuts[i]);
        let (Some(&from), Some(&to)) = (cuts[i].last(), cuts[next].first()) else { continue };
        ring.extend(match bounds.line(from.0, to.0) {
            Some(line) => line.inner(from.0),
            None => corner(assembly, key, [from, to], [arm, arms[next]]),
        });
    }
    ring.dedup_by_key(|(id, _)| *id);
    while ring.len() > 1 && ring.first().map(|(id, _)| id) == ring.last().map(|(id, _)| id) {
        ring.pop();
    }
    ring
}

/// The ground of the lanes that end at an arm.
fn own_lanes(assembly: &MapBuilder, lanes: &Lanes, arm: &Arm) -> Vec<Vec<Point>> {
    let ends = arm.into.iter().chain(&arm.out);
    ends.map(|end| assembly.outline(lanes.lanes[end.lane].lanelet)).collect()
}

/// Whether the ends of an arm's lanes are a run of the ring, in their order across the road.
fn runs_along(ring: &[PointId], arm: &Arm) -> bool {
    let is_end = |id: PointId| arm.into.iter().chain(&arm.out).any(|lane| lane.nodes.contains(&id));
    let mut line = arm.cut.iter().filter(|id| is_end(**id));
    let Some(start) = line.next().map(|first| ring.iter().position(|id| id == first)) else { return true };
    start.is_some_and(|start| ring.iter().cycle().skip(start + 1).zip(line).all(|(a, b)| a == b))
}

/// A rounded kerb between the ends of two cuts, which keeps clear of none and touches both.
fn corner(assembly: &mut MapBuilder, key: Key, [from, to]: [Node; 2], [arm, next]: [&Arm; 2]) -> Vec<Node> {
    let start = Pose { point: from.1, heading: arm.inward };
    let end = Pose { point: to.1, heading: -next.inward };
    if (start.point - end.point).norm() < pose::MIN_SPACING {
        return Vec::new();
    }
    let line: Vec<Point> = curve::join(start, end).into_iter().map(|p| p.point).collect();
    let line = curve::untangled(&line);
    let key = key.word("kerb").number(from.0.0).number(to.0.0);
    let inner = &line[1.min(line.len())..line.len().max(2) - 1];
    inner.iter().enumerate().map(|(i, p)| (assembly.point(key.number(i as i64), *p, 0.0), *p)).collect()
}

/// One `road_border` for every stretch of the ring that is not a cut.
fn kerbs(assembly: &mut MapBuilder, key: Key, ring: &[PointId], arms: &[&Arm]) -> Vec<LineStringId> {
    let is_cut = |a: PointId, b: PointId| arms.iter().any(|arm| arm.cut.contains(&a) && arm.cut.contains(&b));
    let count = ring.len();
    let Some(start) = (0..count).find(|&i| is_cut(ring[(i + count - 1) % count], ring[i])) else { return Vec::new() };
    let mut lines = Vec::new();
    let mut chain = vec![ring[start]];
    for step in 1..=count {
        let (a, b) = (ring[(start + step - 1) % count], ring[(start + step) % count]);
        if is_cut(a, b) {
            if chain.len() > 1 {
                lines.push(kerb(assembly, key, std::mem::take(&mut chain)));
            }
            chain = vec![b];
        } else {
            chain.push(b);
        }
    }
    if chain.len() > 1 {
        lines.push(kerb(assembly, key, chain));
    }
    lines
}

fn kerb(assembly: &mut MapBuilder, key: Key, chain: Vec<PointId>) -> LineStringId {
    let ends = [chain.first(), chain.last()].map(|id| id.map_or(0, |id| id.0));
    assembly.line(
        key.word("kerb line").number(ends[0]).number(ends[1]),
        chain,
        Attributes::of(&[("type", "road_border")]),
    )
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
