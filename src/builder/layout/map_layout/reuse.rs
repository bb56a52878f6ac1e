//! Reuse: turns the layout of a network into that of a network that was made from it. Only what changes is drawn again.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::builder::intersection::movement::{most_movements, movements};
use crate::builder::lanes::gore::gore_corners;
use crate::builder::lanes::lane_ends::connection_lines;
use crate::builder::lanes::road_continuation::Continuations;
use crate::builder::lanes::road_lanes::redraw;
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::network_diff::{NetworkDiff, NetworkSnapshot};
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::{End, Intersection, IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::diagnostic::Finding;
use crate::geometry::{Point, Vector};
use crate::lanelet::PointId;

use super::Layout;

/// The direction of a road at its end, and the nodes at which its lanes end.
type CutAt = (Vector, Vec<(PointId, Point)>);

fn cut_at(arm: &Arm, assembly: &MapBuilder) -> CutAt {
    (arm.inward, arm.cut.iter().map(|&node| (node, assembly.position(node))).collect())
}

impl Layout {
    /// The layout of a `network` that was made from this one by merging intersections, by taking merges back, or by taking directions
    /// from the roads `directed`. Only these, and roads that are new or end elsewhere than before, are drawn again, with the lanelets at
    /// their ends. `before` is the network of this layout. Of the new one, `kept` are the stations between which the outlines leave
    /// each road, and `back` the least setbacks, metres. Also gives the restrictions that cannot be expressed.
    pub(in crate::builder::layout) fn followed(
        self,
        (before, diff): (&NetworkSnapshot, &NetworkDiff),
        network: RoadNetwork,
        (kept, back): (&[Stations], Vec<[f64; 2]>),
        directed: &BTreeSet<RoadIx>,
    ) -> (Self, Vec<Finding>) {
        let mut roads: Vec<RoadIx> = (0..network.roads.len()).map(RoadIx::new).collect();
        let (restrictions, notes) = ResolvedRestrictions::new(&network);
        let Self {
            restrictions: old_restrictions,
            joins: met,
            lines: was,
            mut assembly,
            lanes,
            turning: mut known,
            needs,
            squeezed,
            drawn,
            ..
        } = self;
        let mut joins = Continuations::find(&network);
        let needs = needs.renewed(diff, &network, kept, |ix| joins.joined(ix));
        let stops = vec![[false; 2]; network.roads.len()];
        let cut_before = |ix: RoadIx| {
            let road = network.road(ix);
            let is_untouched = [road.from, road.to].iter().all(|&at| diff.untouched(at).is_some());
            diff.of(ix).filter(|_| is_untouched).map(|old| was.cut(old))
        };
        let lines = connection_lines(&network, &needs, &back, (&stops, &squeezed), cut_before);
        joins.set_gore_corners(gore_corners(&network, &lines));
        let elsewhere = joins.take_over(&met, diff);
        let stays = |road: &RoadIx| diff.of(*road).is_some_and(|old| was.kept[old] == lines.kept[*road]);
        roads.retain(|road| elsewhere.contains(road) || directed.contains(road) || !stays(road));
        let mut lanes = lanes.reindexed(diff);
        let ends = roads.iter().flat_map(|&road| End::BOTH.map(|end| RoadEnd { road, end }));
        let ends: FxHashMap<RoadEnd, CutAt> = ends.map(|at| (at, cut_at(lanes.arm(at), &assembly))).collect();
        redraw(&mut assembly, &network, &lines, &mut joins, &mut lanes, &roads);
        let most_movements = most_movements(&network);
        let standing = |(i, at): (usize, &Intersection)| {
            let old = diff.untouched(IntersectionIx::new(i))?;
            let mut turning = known[old].take()?;
            let redrawn: Vec<_> = at.arms.iter().filter_map(|at| Some((lanes.arm(*at), ends.get(at)?))).collect();
            let is_directed = at.arms.iter().any(|at| directed.contains(&at.road));
            if is_directed || redrawn.iter().any(|(arm, before)| cut_at(arm, &assembly) != **before) {
                return None;
            }
            let asked =
                !redrawn.is_empty() || restrictions.concern(&at.arms) || old_restrictions.concern(before.arms(old));
            (turning.unchanged, turning.turns_asked) = (true, true);
            (!asked || turning.plan == movements(&network, &restrictions, &lanes, at, most_movements))
                .then_some(turning)
        };
        let turning = network.intersections.iter().enumerate().map(standing).collect();
        let mut layout =
            Self { network, restrictions, joins, lines, assembly, lanes, turning, back, stops, squeezed, needs, drawn };
        layout.draw_lanelets();
        (layout, notes)
    }

    /// The least setbacks of the roads of a network that was made from this one, metres: as before, but 0 at merged intersections.
    pub(in crate::builder::layout) fn kept_setbacks(&self, diff: &NetworkDiff, network: &RoadNetwork) -> Vec<[f64; 2]> {
        let of_road = |(road, old): (RoadIx, Option<RoadIx>)| {
            let back = old.map_or([0.0; 2], |old| self.back[old]);
            let stays = |end: End| diff.of_intersection(network.road(road).intersection(end)).is_some();
            End::BOTH.map(|end| if stays(end) { back[end] } else { 0.0 })
        };
        diff.roads().map(of_road).collect()
    }
}
